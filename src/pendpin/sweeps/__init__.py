"""Sweeps: one scene with many sets of numbers, each run and measured, on all cores or a cluster (docs/sweep.md).

plan.py says which cases there are, measures.py and attractors.py what is measured. cases.py runs a block of cases, smooth
ones side by side; workers.py shares the blocks out, for `simulate_many` (ensemble.py) too; store.py keeps the results in a
Zarr store, figure.py shows them. significance.py runs a scene without each of its effects, for `pendpin effects`.
May import: motions, runs, graphics and what is below them; no other tool.
To add a measure: a function in measures.py and its row in `MEASURES`.
"""

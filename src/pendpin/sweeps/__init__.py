"""Sweeps: one scene with many sets of numbers, each run and measured, on all cores or a cluster (docs/sweep.md).

plan.py says which cases there are, measures.py what is measured; task.py is both with a scene. cases.py runs a block of
cases, smooth ones side by side. store.py keeps the results in a Zarr store, workers.py shares the work out.
To add a measure: a function in measures.py and its row in `MEASURES`.
"""

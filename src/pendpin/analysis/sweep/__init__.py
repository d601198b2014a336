"""Sweeps: one scene with many sets of numbers, each run and measured, on all cores or a cluster (docs/sweep.md).

plan.py says which cases there are, measures.py what is measured, cases.py runs a block of cases, batches.py does so for
smooth scenes in the processor's vectors, store.py keeps the results in a Zarr store, workers.py shares the work out.
To add a measure: a function in measures.py and its row in `MEASURES`.
"""

"""Agreement with published results: cases of other simulators, benchmarks and closed forms (`pendpin validate`).

May import: motions, runs and what is below it, graphics; no other tool.
To add a case: a TOML file in cases/, with its source, its scene, what is compared and the published numbers. published.py
reads it, validate.py runs it by every method and shows it.
"""

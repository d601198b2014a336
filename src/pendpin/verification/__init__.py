"""Why the numbers can be believed: four rooms, each one command and one page of docs.

`pendpin validate` is agreement/, published results. `pendpin hard` is hardcases/, what breaks simulators. `pendpin cost` is
work_precision/, what accuracy costs in time. `pendpin check` is motions/crosschecks: a run's page prints its verdict.
simulators/ runs a scene in MuJoCo, Drake and SciPy for the others.
May import: graphics, motions, runs and what is below them; no other tool.
"""

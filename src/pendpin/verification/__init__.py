"""Why the numbers can be believed: five rooms, each one command and one page of docs.

`pendpin check` is crosschecks/, routes compared at random states. `pendpin validate` is agreement/, published results.
`pendpin hard` is hardcases/, what breaks simulators. `pendpin cost` is work_precision/, what accuracy costs in time.
simulators/ runs a scene in MuJoCo, Drake and SciPy for the others.
May import: graphics, motions, runs and what is below them; no other tool.
"""

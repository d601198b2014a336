"""The cross-check: the same states by every independent route, and the largest difference of each pair (`pendpin check`).

functions.py compares functions of your own with a scene, joint by joint (`pp.diagnose(scene, accelerations=...)`).

May import: dynamics and what is below it.
To add a route: a file of equations/ or engines/, and its name in routes.py.
"""

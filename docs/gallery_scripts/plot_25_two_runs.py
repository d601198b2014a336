"""
Two runs side by side
=====================

The same double pendulum with a second rod that is 2 % heavier. The other run is shown as a ghost.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_25_two_runs.png"

import pendpin as pp

scene = pp.load_scene("examples/double_pendulum.toml").replace(
    duration=6.0
)
one = pp.simulate(scene, samples=241)
other = pp.simulate(scene.replace({"model.rods[1].mass": 0.612}), samples=241)
figure = one.plot("theta_1", "theta_2", compare=other)

# %%
# Both motions:

one.animate(compare=other)

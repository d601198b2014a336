"""
A Panda with a controller
=========================

The arm starts at zero and moves to a pose. A proportional-derivative controller acts on each joint.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_18_panda.png"

import matplotlib.pyplot as plt

import pendpin as pp

# rad
pose = {
    "panda_joint1": 0.5,
    "panda_joint2": 0.3,
    "panda_joint4": -1.8,
    "panda_joint6": 1.5,
}
arm = pp.UrdfModel("panda")
names = [f"panda_joint{k}" for k in range(1, 8)]
motors = [
    pp.effects.Motor(
        joint=name,
        target=pose.get(name, 0.0),
        proportional=400.0,
        derivative=60.0,
    )
    for name in names
]
scene = pp.Scene(
    model=arm, effects=[pp.effects.Gravity(), *motors], duration=3.0
)
run = pp.simulate(scene, tolerance=1e-8)
figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
for name in names:
    axes.plot(run.t, run[name], label=name)
axes.set(xlabel="time (s)", ylabel="angle (rad)")
axes.legend(fontsize=7, ncols=2)

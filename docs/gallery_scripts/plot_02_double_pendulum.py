"""
A double pendulum
=================

Two rods swing in a plane. The motion is chaotic, so two correct runs drift apart after some time.
"""

import pendpin as pp

run = pp.simulate("../../examples/double_pendulum.toml")
figure = run.plot()

# %%
# The motion:

run.animate()

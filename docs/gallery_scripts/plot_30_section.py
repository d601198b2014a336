"""
A section of the double pendulum
================================

Forty motions of one energy, recorded where the upper rod passes the vertical. Curves are regular motion, the cloud is chaos.
"""

import pendpin as pp

section = pp.sections.crossing(
    "theta_1",
    level=0.0,
    direction=+1,
    of=("theta_2", "theta_2_rate"),
    count=300,
)
portrait = pp.sections.portrait(
    "examples/double_pendulum.toml", section, starts=40, energy=-10.0
)
figure = portrait.plot().figure

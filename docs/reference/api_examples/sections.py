import pendpin as pp

section = pp.sections.crossing(
    "theta_1", of=("theta_2", "theta_2_rate"), count=50
)
portrait = pp.sections.portrait(
    "examples/double_pendulum.toml", section, starts=4, energy=-10.0
)
print(portrait)
print(portrait.values.shape)  # (4, 50, 2): rad, rad/s

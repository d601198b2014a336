import pendpin as pp

modes = pp.modes("examples/double_pendulum.toml")
print(modes)

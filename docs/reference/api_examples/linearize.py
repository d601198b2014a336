import pendpin as pp

# about the rest that hangs down
model = pp.linearize("examples/double_pendulum.toml")
print(model)

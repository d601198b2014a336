import pendpin as pp

model = pp.linearize("examples/double_pendulum.toml")  # about the rest that hangs down
print(model)

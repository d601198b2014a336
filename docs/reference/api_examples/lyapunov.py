import pendpin as pp

exponents = pp.lyapunov(
    "examples/double_pendulum.toml", count=1, duration=20.0
)
print(exponents)

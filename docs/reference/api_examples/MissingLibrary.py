import pendpin as pp

try:
    pp.sweep(
        "examples/double_pendulum.toml",
        {"model.rods[0].length": [0.5, 1.0]},
        ["swing"],
    )
except pp.MissingLibrary as error:  # without the extra sweep
    print(error)

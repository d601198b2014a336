import pendpin as pp

scene = pp.load_scene("examples/double_pendulum.toml")
try:
    pp.simulate(scene, method="euler", step=0.1)
except pp.RunError as error:
    print(error)
    print(error.partial.t[-1])  # s: the good part of the run

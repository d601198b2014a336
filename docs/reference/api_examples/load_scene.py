import pendpin as pp

scene = pp.load_scene("examples/crane.toml")
print(scene.title, scene.duration)

import pendpin as pp

report = pp.validate(["opensim-3d"], methods=["dop853"])
print(report)

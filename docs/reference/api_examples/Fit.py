import pendpin as pp

fit = pp.fit(
    "examples/lab/single.toml",
    "examples/lab/single.csv",
    free=["effects[1].kinetic"],
)
print(fit.verdict)
fit.scene.save("fitted.toml")

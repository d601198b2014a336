import pendpin as pp

report = pp.diagnose(
    r"\phi'' = -\frac{3 g}{2 l} \sin\phi - \theta'^2 \sin\phi \cos\phi",
    rod="thin",
)
print(report)

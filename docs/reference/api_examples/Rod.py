import pendpin as pp

uniform = pp.Rod(length=1.0, mass=1.0, radius=0.01)  # m, kg, m
thin = pp.Rod(length=1.0, mass=1.0)
# kg m², kg
measured = pp.Rod(
    length=0.5, mass=0.3, com=0.3, inertia=(0.007, 0.007, 0.001), payload=0.1
)

import pendpin as pp

rod = pp.Rod(length=0.2, mass=0.2, radius=0.008)
cable = pp.Chain(rods=[rod], copies=50)
print(cable.count)  # 50

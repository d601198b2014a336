import pendpin as pp

try:
    pp.Rod(length=-1.0, mass=1.0)
except pp.InputError as error:
    print(error)

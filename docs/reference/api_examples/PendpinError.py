import pendpin as pp

try:
    pp.load_scene("no_such_file.toml")
except pp.PendpinError as error:  # the root of all of them
    print(error)

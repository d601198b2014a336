"""The ground: frozen validated data, whole files, key paths, vectors, arguments, optional libraries.

May import: errors.
To add a thing that every room needs and that knows no physics: a file here.
"""

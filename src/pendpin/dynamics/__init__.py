"""A model with its effects on an engine: accelerations, wrenches, energy, power; equations on symbols; contacts.

May import: engines, model and what is below them.
To add an interface of effects: a class like BoundTorque in binding.py.
"""

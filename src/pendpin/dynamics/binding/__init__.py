"""The effects of a scene, bound to a model: one class for each interface, with all that an effect does through it.

May import: what dynamics may.
To add an interface of effects: a class like those in bound.py (its law with the time counted from the start, its power, its
potential), and its name in binding.py.
"""

from pendpin.dynamics.binding.binding import Accounts, Binding, Powered
from pendpin.dynamics.binding.bound import bodies_of

__all__ = ["Accounts", "Binding", "Powered", "bodies_of"]

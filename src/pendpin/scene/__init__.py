"""What goes in: the scene, its model, start, effects and solver, as frozen, validated data; read from TOML.

May import: effects, equations and the ground.
To add a kind of model: a record in models.py, and the function that builds it in model/build.py. To add a setting of the
integration: a field of Solver in methods.py; a method: a record there.
"""

from pendpin.scene.methods import METHODS, Method, Solver, add_method, event_methods, fixed_methods, method_of
from pendpin.scene.models import Chain, PinModel, Rod, UrdfModel
from pendpin.scene.scene import Data, Scene, Start, builtin_scene, chosen_scene, load_scene, scene_of, unit_of_key

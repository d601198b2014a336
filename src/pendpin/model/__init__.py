"""From a scene's model, a chain of rods or a URDF, to bodies, joints and frames; kinematics; reading and writing URDF.

May import: effects, equations, scene and what is below them. A model is built once per run and never changed.
To add a kind of model: a record in scene/models.py, and the function that builds it in model/build.py.
"""

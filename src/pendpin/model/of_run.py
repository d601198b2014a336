"""What the model of a run says of it, where the model can still be built."""

from pendpin.arrays import Array
from pendpin.errors import InputError
from pendpin.model import kinematics
from pendpin.model.build import Model, build
from pendpin.scene import Scene
from pendpin.trajectory import Trajectory


def model_of(run: Trajectory) -> Model:
    """The model of a run. Raises InputError where it cannot be built again, as when its URDF is gone."""
    scene = run.source if isinstance(run.source, Scene) else Scene(model=run.scene.get("model"))
    model = build(scene.model)
    if model.joints != run.joints or len(model.bodies) != run.tip.shape[1]:
        raise InputError("the run does not fit its model: its file has changed since, or is another of the same name")
    return model


def slides_of(run: Trajectory) -> frozenset[str]:
    """The names of the prismatic joints of a run. Raises InputError as `model_of`."""
    model = model_of(run)
    return frozenset(name for name, slides in zip(model.joints, model.slides, strict=True) if slides)


def swings_of(run: Trajectory) -> Array:
    """As `kinematics.swings`, (n,) rad. Raises InputError as `model_of`."""
    model = model_of(run)
    return kinematics.swings(model, kinematics.poses(model, run.q))

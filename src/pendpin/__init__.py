"""pendpin: the 3D compound pendulum on a universal joint, and chains of them, every number computed by several routes."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from pendpin.errors import did_you_mean
from pendpin.ground.libraries import VERSION

if TYPE_CHECKING:
    from pendpin import effects
    from pendpin.doctor.diagnose import diagnose
    from pendpin.dynamics.dynamics import Dynamics, bind
    from pendpin.errors import InputError, MissingLibrary, PendpinError, RunError
    from pendpin.fitting import Fit, fit
    from pendpin.motions.crosschecks.crosscheck import crosscheck
    from pendpin.motions.periodic import periodic_orbit
    from pendpin.motions.special_starts import Start
    from pendpin.motions.trajectory import Trajectory, simulate
    from pendpin.scene import Chain, Rod, Scene, Solver, UrdfModel, load_scene
    from pendpin.stability import sections
    from pendpin.stability.branches import follow
    from pendpin.stability.linearize import linearize
    from pendpin.stability.lyapunov import lyapunov
    from pendpin.stability.modes import modes
    from pendpin.sweeps.ensemble import Ensemble, simulate_many
    from pendpin.sweeps.sweep import sweep
    from pendpin.verification.agreement import validate
    from pendpin.verification.work_precision.cost import cost

__version__ = VERSION

_HOMES = {
    "verification.agreement": ("validate",),
    "motions.crosschecks.crosscheck": ("crosscheck",),
    "doctor.diagnose": ("diagnose",),
    "fitting": ("Fit", "fit"),
    "verification.work_precision.cost": ("cost",),
    "dynamics.dynamics": ("Dynamics", "bind"),
    "errors": ("InputError", "MissingLibrary", "PendpinError", "RunError"),
    "scene": ("Chain", "Rod", "Scene", "Solver", "UrdfModel", "load_scene"),
    "motions.special_starts": ("Start",),
    "sweeps.ensemble": ("Ensemble", "simulate_many"),
    "motions.periodic": ("periodic_orbit",),
    "stability.branches": ("follow",),
    "stability.linearize": ("linearize",),
    "stability.lyapunov": ("lyapunov",),
    "stability.modes": ("modes",),
    "sweeps.sweep": ("sweep",),
    "motions.trajectory": ("Trajectory", "simulate"),
}
_MODULES = {"effects": "pendpin.effects", "sections": "pendpin.stability.sections"}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

_OTHER_WORDS = {  # of other packages, and what is meant here
    **dict.fromkeys(("load_urdf", "load_robot", "load_robot_description"), "UrdfModel"),
    **dict.fromkeys(("run", "solve", "integrate"), "simulate"),
    **dict.fromkeys(("normal_modes", "eigenmodes"), "modes"),
    **dict.fromkeys(("load_run", "load_trajectory"), "Trajectory"),
    "load": "load_scene",
    "linearise": "linearize",
    "check": "crosscheck",
}

__all__ = ["Chain", "Dynamics", "Ensemble", "Fit", "InputError", "MissingLibrary", "PendpinError", "Rod"]
__all__ += ["RunError", "Scene", "Solver", "Start", "Trajectory", "UrdfModel", "bind", "cost", "crosscheck"]
__all__ += ["diagnose", "effects", "fit", "follow", "linearize", "load_scene", "lyapunov", "modes"]
__all__ += ["periodic_orbit", "sections", "simulate", "simulate_many", "sweep", "validate"]


def __getattr__(name: str) -> Any:
    """Load a public name where it is first used, so that importing pendpin costs nothing."""
    if name in _MODULES:
        return import_module(_MODULES[name])
    if name not in _HOME_OF:  # what it probably means: a public name, or an effect
        if _OTHER_WORDS.get(name) in __all__:
            hint = f"; did you mean {_OTHER_WORDS[name]!r}?"
        elif not name.startswith("_") and name in import_module("pendpin.effects").__all__:
            hint = f"; did you mean 'effects.{name}'?"
        else:
            hint = did_you_mean(name, __all__)
        raise AttributeError(f"module 'pendpin' has no attribute {name!r}{hint}")
    return getattr(import_module(f"pendpin.{_HOME_OF[name]}"), name)


def __dir__() -> list[str]:
    """The public names and nothing else."""
    return __all__

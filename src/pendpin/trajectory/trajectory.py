"""The result of a run: arrays over time, statistics, and the file that holds them."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np

from pendpin.errors import InputError, PendpinError
from pendpin.ground.arrays import Array, ArrayLike
from pendpin.ground.files import open_arrays, path_of, refuse_other_format, write_arrays, write_whole
from pendpin.ground.records import LARGEST
from pendpin.trajectory.columns import Place, column, columns
from pendpin.trajectory.parts import Energy, Event, Reactions, Stats, exchanged, share
from pendpin.trajectory.presentation import Summary, page, summary, text, title
from pendpin.trajectory.reading import ARRAYS, FORMAT, event_arrays, read_fields
from pendpin.trajectory.tables import TABLES, to_csv, to_pandas, to_xarray


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """A motion sampled at t, with everything that was computed along it.

    q, v, a hold one value per joint, in model order, in rad and s (m for prismatic joints). Angles are not wrapped.
    wrench is the force (N), then the moment (N m), that each joint's parent exerts on its child, at the joint's origin,
    in the child joint's frame. Two runs are equal if their scenes and all their numbers are, to the bit; `stats` does not
    count. The arrays are read-only: for other numbers take a copy, as run.q.copy().
    """

    joints: tuple[str, ...]
    t: Array  # (n,)
    q: Array  # (n, nv)
    v: Array  # (n, nv)
    a: Array  # (n, nv)
    wrench: Array  # (n, joints, 6)
    kinetic: Array  # (n,)
    potential: Array  # (n,)
    tips: Array  # (n, rods, 3), world frame W
    rod_reactions: Reactions | None  # None for a model without universal joints
    stats: Stats
    events: tuple[Event, ...] = ()  # of dry friction and stops, as they happened; none in older files
    work: dict[str, Array] = field(default_factory=dict)  # J (n,), of each kind of effect, with energy_balance
    held: tuple[Array, ...] = ()  # N m (instants, k), of each Torque with `every`: its outputs, from t[0] on
    scene: dict[str, Any] = field(default_factory=dict)  # as in a scene file
    source: Any = field(default=None, repr=False, compare=False)  # the Scene that was run, in the process that ran it

    def __post_init__(self) -> None:
        """A number that is changed would no longer belong to this motion: its arrays are read-only."""
        for array in (*self.arrays.values(), *self.held):
            array.setflags(write=False)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """A copy or an unpickled run is read-only too, which NumPy does not keep."""
        vars(self).update(state)
        self.__post_init__()

    def __contains__(self, name: object) -> bool:
        """Whether run[name] is there."""
        try:
            return column(self, name) is not None
        except InputError:
            return False

    def __iter__(self) -> Iterator[str]:
        """The names of all quantities, as of a mapping."""
        return iter(self.names)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.names)

    def __getitem__(self, name: str) -> Array:
        """One quantity by its name, (n,): run["theta_1"], run["R3_2"], run["tip_x"]. Raises InputError.

        Beside `names` there are energy_drift and effort_, a kind of effect and a joint, as in run["effort_gravity_theta_1"].
        """
        return column(self, name)

    @property
    def title(self) -> str:
        """The name of the run in figures and pages: its scene's title, or the model and its effects."""
        return title(self)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all quantities, t first."""
        return tuple(self.places)

    @cached_property
    def places(self) -> dict[str, Place]:
        """Where each quantity is, by its name."""
        return columns(self)

    @cached_property
    def slides(self) -> frozenset[str] | None:
        """The names of the prismatic joints; None where the model cannot be built again, as when its URDF is gone."""
        from pendpin.model.model_of_run import slides_of

        try:
            return slides_of(self)
        except PendpinError:
            return None

    @cached_property
    def links(self) -> tuple[str, ...] | None:
        """The names of the links whose tips there are; None as `slides`."""
        from pendpin.model.model_of_run import links_of

        try:
            return links_of(self)
        except PendpinError:
            return None

    @cached_property
    def swing(self) -> Array:
        """The largest angle of any rod from hanging straight down, (n,) rad; NaN as `slides` and where none can swing."""
        from pendpin.model.model_of_run import swings_of

        try:
            return swings_of(self)
        except PendpinError:
            return np.full(len(self.t), np.nan)

    @cached_property
    def computed_efforts(self) -> dict[str, Array]:
        """As `efforts`, computed once."""
        return self.efforts()

    def __eq__(self, other: object) -> bool:
        """Whether another run is of the same scene and holds the same numbers."""
        if not isinstance(other, Trajectory):
            return NotImplemented
        one, two = ((run.joints, run.scene, run.events, run.arrays.keys(), len(run.held)) for run in (self, other))
        if one != two or not all(map(np.array_equal, self.held, other.held)):
            return False
        return all(np.array_equal(array, other.arrays[name]) for name, array in self.arrays.items())

    def __hash__(self) -> int:
        """Equal runs have equal hashes."""
        return hash((self.joints, len(self.t)))

    @property
    def arrays(self) -> dict[str, Array]:
        """Every array with a row for each sample, by its name in the file of a run."""
        rods = {} if self.rod_reactions is None else self.rod_reactions._asdict()
        work = {f"work_{kind}": work for kind, work in self.work.items()}
        return {name: getattr(self, name) for name in ARRAYS} | rods | work

    def with_arrays(self, arrays: Mapping[str, Array]) -> Self:
        """The run with other arrays by these names."""
        rods = self.rod_reactions and Reactions(*(arrays[name] for name in Reactions._fields))
        work = {kind: arrays[f"work_{kind}"] for kind in self.work}
        return replace(self, **{name: arrays[name] for name in ARRAYS}, rod_reactions=rods, work=work)

    @property
    def _sampled(self) -> Self:
        """This run. Raises InputError if it is one without samples, as of crossings that there are not."""
        if not len(self.t):
            raise InputError("this run has no samples, as nothing was crossed")
        return self

    def reactions(self) -> Reactions:
        """R1, R2, R3, M3, Mc of every rod on a universal joint. Raises InputError where the model has none."""
        if self.rod_reactions is None:
            raise InputError("this model has no universal joint, so no R1, R2, R3, M3; see .wrench for every joint")
        return self.rod_reactions

    def express(self, joint: str, frame: str = "world", point: ArrayLike | None = None, on: str = "child") -> Array:
        """The wrench of a joint in a frame and at a point of your choice, (n, 6): force in N, then moment in N m.

        Args:
            joint: its name.
            frame: "world" (W), "parent" (the link that the joint hangs on) or "child" (the link that it moves).
            point: (3,) in m, in that frame; the joint's origin if absent.
            on: "child" for the wrench of the parent on the child, "parent" for the reaction.

        Raises:
            InputError: for other names, and if the run's model cannot be built again.
        """
        from pendpin.model.model_of_run import express_wrench

        return express_wrench(self._sampled, joint, frame, point, on)

    def energy(self) -> Energy:
        """Kinetic and potential energy over time."""
        return Energy(self.kinetic, self.potential)

    @property
    def imbalance(self) -> float:
        """The largest difference of the change of kinetic energy and the works, divided by the energy exchanged."""
        if not self.work:
            return 0.0
        return share(np.abs(self.unbalanced), exchanged(self.kinetic, *self.work.values()))

    @property
    def unbalanced(self) -> Array:
        """The change of kinetic energy that no work explains, (n,) in J."""
        return self.kinetic - self.kinetic[:1] - sum(work - work[:1] for work in self.work.values())

    def at(self, times: ArrayLike) -> "Trajectory":
        """The run at any times inside it, (m,) in s, rising, or one: as accurate as the run.

        Integrated from the sample before, by the run's own method and setting; at the instant of an impact the state
        after it. Raises InputError for other times, and where the run's scene cannot be built again.
        """
        from pendpin.motions.continuation import at

        return at(self._sampled, times)

    def crossings(self, name: str, level: float = 0.0, direction: int = 0) -> "Trajectory":
        """The run at the instants at which a quantity crosses a level: upwards (1), downwards (-1) or both ways (0).

        Found between the samples, each to the accuracy of the run. An angle counts its turns: it is not wrapped. There
        may be none. Raises InputError.
        """
        from pendpin.motions.crossings import crossings

        return crossings(self._sampled, name, level, direction)

    def extend(self, duration: float) -> "Trajectory":
        """The run continued for another duration in s, with samples as dense as before.

        With rk4 and euler, if the run ends on a step, the result is bit for bit that of one long run; else it is that within
        the run's accuracy.
        """
        from pendpin.motions.continuation import extend

        return extend(self._sampled, duration)

    def state_transition(self, t0: float, t1: float) -> Array:
        """The derivative of (q, v) at t1 by (q, v) at t0 (s, inside the run): (2 nv, 2 nv), to the accuracy of the run.

        Integrated beside the motion by exact derivatives of the equations. Raises InputError for other times, for friction
        and stops, which act at events, and for effects without derivatives; RunError where angles have no derivative.
        """
        from pendpin.motions.sensitivity import state_transition

        return state_transition(self._sampled, t0, t1)

    def sensitivity(self, keys: Sequence[str] | str, of: str | None = None) -> Array:
        """The derivatives of the motion by numbers of the scene at k key paths, to the accuracy of the run.

        Args:
            keys: such as "model.rods[0].length", "effects[1].coefficient", "start.positions.theta_1".
            of: the name of a quantity, or a name with a statistic of its samples, as in "R3_1.max".

        Returns:
            d(q, v)/d(number) at the samples, (n, 2 nv, k). With `of` the derivatives of the quantity, (n, k), or of its
            statistic, (k,). Units are those of the quantity over those of the number.

        Raises:
            InputError: for keys that are not numbers of the scene, and as `state_transition`.
        """
        from pendpin.motions.sensitivity import sensitivity

        return sensitivity(self._sampled, keys, of)

    def summary(self) -> Summary:
        """The largest angle of any rod from straight down, the tip's way sideways, rest; extremes of R1, R2, R3, M3.

        With their times; periods and energy too. Extremes are those of the samples.
        """
        return summary(self)

    def to_pandas(self, *names: str) -> Any:
        """A pandas DataFrame over time, a column for each name, units in attrs["units"]. MissingLibrary without pandas."""
        return to_pandas(self, names)

    def to_xarray(self) -> Any:
        """An xarray.Dataset of the arrays over t, joint, rod, axis and component, with units; tips of a robot over link.

        Raises MissingLibrary without xarray.
        """
        return to_xarray(self)

    def efforts(self) -> dict[str, Array]:
        """The generalised force of each kind of effect on each joint, (n, nv) in N m, N for slides; dry friction and stops
        together as "contacts". Their sum is the inverse dynamics of the motion. By name: run["effort_gravity_theta_1"].
        Raises InputError.
        """
        from pendpin.dynamics.efforts import efforts

        return efforts(self._sampled)

    def to_csv(self, path: str | Path, *names: str) -> Path:
        """Write a CSV file with a column for each name, t first, every digit kept; all `names` if absent. InputError."""
        return to_csv(self, path, names)

    def plot(self, *names: str, ax: Any = None, compare: Any = None) -> Any:
        """Draw quantities by name, as in run[name], against time on a matplotlib Axes, and return it.

        Without `ax` a new Figure is returned, with a panel for each unit. Without names it is the figure of the run.
        `compare` is another run, or up to three, drawn on the same axes. Raises InputError.
        """
        from pendpin.graphics.figure import plot

        return plot(self if names else self._sampled, names, ax, compare)

    def animate(self, compare: Any = None) -> Any:
        """The motion as an Animation, which shows itself in a notebook; .save("x.html"), "x.gif" or "x.mp4".

        `compare` is another run, or up to three, shown in the page as ghosts, with their distance. Raises InputError.
        """
        from pendpin.graphics.animation import Animation
        from pendpin.verification.crosschecks.crosscheck import run_verdict

        return Animation(self._sampled, compare, run_verdict)

    def show(self, viewer: Any) -> Any:
        """Play the run in a viewer that is there: a meshcat.Visualizer, or Pinocchio's MeshcatVisualizer."""
        from pendpin.graphics.viewers import show

        return show(self._sampled, viewer)

    def configurations(self, pin_model: Any) -> Array:
        """q as a pin.Model takes it, (n, nq): continuous joints as cosine and sine, joints that are locked in place."""
        from pendpin.model.configurations import configurations

        return configurations(self, pin_model)

    def __repr__(self) -> str:
        return text(self)

    def _repr_html_(self) -> str:
        from pendpin.graphics.animation import frame_of

        return page(self, frame_of(self))

    @property
    def sound(self) -> int:
        """The number of samples before the first with a number that is not finite or beyond LARGEST."""
        n = len(self.t)
        arrays = [array.reshape(n, -1) for name, array in self.arrays.items() if not name.startswith("work_")]
        if all(np.abs(array).max(initial=0.0) <= LARGEST for array in arrays):  # False for NaN
            return n
        return int(np.argmin(np.all([(np.abs(array) <= LARGEST).all(1) for array in arrays], 0)))

    def save(self, path: str | Path) -> Path:
        """Write everything to an .npz file, whole or not at all. Raises InputError where that cannot be."""
        path = path_of(path)
        if path.suffix.lower() in TABLES:
            raise InputError(f"{path}: save writes .npz; to_csv({str(path)!r}) writes this run as a table")
        refuse_other_format(path, ".npz")
        held = {f"held_{i}": outputs for i, outputs in enumerate(self.held)}
        meta = json.dumps({"format": FORMAT, "scene": self.scene, **asdict(self.stats)})
        texts = {"joints": np.array(self.joints), "meta": np.array(meta)}
        arrays: dict[str, Any] = self._sampled.arrays | held | event_arrays(self.events) | texts
        return write_whole(path, lambda file: write_arrays(file, arrays))

    @classmethod
    def load(cls, path: str | Path, scene: Any = None) -> Self:
        """Read a saved run. Raises InputError for anything that is not one; nothing in the file is executed.

        A run of code (a Torque, an effect of one's own) or of a pin.Model can be continued only with its `scene` given:
        its model and effects have to be those of the run.
        """
        path = path_of(path)
        if path.suffix == ".csv":
            raise InputError(f"{path}: a table, not a run; pendpin run SCENE --out run.npz saves a run")
        with open_arrays(path, "a run that pendpin saved (pendpin run SCENE saves one)") as file:
            run = cls(**read_fields(file))
        if scene is None:
            return run
        scene = scene.replace(**{name: value for name, value in run.scene.items() if name not in ("model", "effects")})
        if scene.model_dump(mode="json") != run.scene:
            raise InputError(f"scene: its model or effects are not those of the run in {path}")
        return replace(run, source=scene)

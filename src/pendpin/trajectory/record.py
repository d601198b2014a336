"""The record of a run: arrays over time, names, statistics, and the file that holds them.

What a user asks of a run beside its numbers is in pendpin.motions.trajectory, whose Trajectory is this record.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self, TypeVar

import numpy as np

from pendpin.errors import InputError, amount, moment, one_line, shown
from pendpin.ground.arrays import Array
from pendpin.ground.files import open_arrays, path_of, refuse_other_format, write_arrays, write_whole
from pendpin.ground.records import LARGEST
from pendpin.trajectory.columns import TABLES, Place, column, columns
from pendpin.trajectory.parts import STATES, AnyReactions, Derived, Energy, Event, Stats, pack_run, read_fields, share

MOST_LETTERS = 90  # of a title


@dataclass(frozen=True, eq=False, repr=False)
class RunRecord:
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
    derived: Derived | Callable[[], Derived] = field(repr=False)  # a function is called where one of them is asked for
    stats: Stats
    events: tuple[Event, ...] = ()  # of dry friction and stops, as they happened; none in older files
    work: dict[str, Array] = field(default_factory=dict)  # J (n,), of each kind of effect, with energy_balance
    held: tuple[Array, ...] = ()  # N m (instants, k), of each Torque with `every`: its outputs, from t[0] on
    scene: dict[str, Any] = field(default_factory=dict)  # as in a scene file
    source: Any = field(default=None, repr=False, compare=False)  # the Scene that was run, in the process that ran it

    def __post_init__(self) -> None:
        """A number that is changed would no longer belong to this motion: its arrays are read-only."""
        for array in (self.t, self.q, self.v, *self.work.values(), *self.held):
            array.setflags(write=False)

    def __getstate__(self) -> dict[str, Any]:
        """A copy, and what another process gets, holds numbers, not the function that computes them."""
        fields = {name: value for name, value in vars(self).items() if name in FIELDS}
        return fields | {"derived": self._derived._replace(rod_reactions=self.rod_reactions)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """A copy or an unpickled run is read-only too, which NumPy does not keep."""
        vars(self).update(state)
        self.__post_init__()

    @classmethod
    def of(cls, record: "RunRecord") -> Self:
        """The same run as one of this class; one that is of this class already stays itself."""
        if isinstance(record, cls):
            return record
        return cls(**{name: getattr(record, name) for name in FIELDS})

    @cached_property
    def _derived(self) -> Derived:
        derived = self.derived() if callable(self.derived) else self.derived
        for array in derived[:-1]:
            array.setflags(write=False)
        return derived

    @property
    def a(self) -> Array:
        """Accelerations, (n, nv) in rad/s² (m/s² for prismatic joints)."""
        return self._derived.a

    @property
    def wrench(self) -> Array:
        """Force (N), then moment (N m), of each joint's parent on its child, (n, joints, 6) in the child joint's frame."""
        return self._derived.wrench

    @property
    def kinetic(self) -> Array:
        """Kinetic energy, (n,) in J."""
        return self._derived.kinetic

    @property
    def potential(self) -> Array:
        """Potential energy of the conservative effects, (n,) in J."""
        return self._derived.potential

    @property
    def tips(self) -> Array:
        """The far end of each rod, (n, rods, 3) in m, in the world frame W."""
        return self._derived.tips

    @cached_property
    def rod_reactions(self) -> AnyReactions | None:
        """What its joint exerts on every rod; None where no rod has a joint of its own."""
        given = self._derived.rod_reactions
        rods = given() if callable(given) else given
        for array in rods or ():
            array.setflags(write=False)
        return rods

    @property
    def arrays(self) -> dict[str, Array]:
        """Every array with a row for each sample, by its name in the file of a run."""
        rods = {} if self.rod_reactions is None else self.rod_reactions._asdict()
        work = {f"work_{kind}": work for kind, work in self.work.items()}
        return {name: getattr(self, name) for name in (*STATES, *Derived._fields[:-1])} | rods | work

    def with_arrays(self, arrays: Mapping[str, Array]) -> Self:
        """The run with other arrays by these names."""
        work = {kind: arrays[f"work_{kind}"] for kind in self.work}
        states: dict[str, Any] = {name: arrays[name] for name in STATES}
        return replace(self, **states, derived=Derived.of_arrays(arrays), work=work)

    @property
    def title(self) -> str:
        """The name of the run in figures and pages, which is its scene's title, or else the model and its effects."""
        kinds = dict.fromkeys(str(effect.get("kind", "an effect")) for effect in self.scene.get("effects") or ())
        under = ", ".join(kind.replace("_", " ") for kind in kinds)
        said = str(self.scene.get("title") or "") or f"{model_in_words(self)}{under and f' under {under}'}"
        return one_line(said)[:MOST_LETTERS]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all quantities, t first."""
        return tuple(self.places)

    @cached_property
    def places(self) -> dict[str, Place]:
        """Where each quantity is, by its name."""
        return columns(self)

    def __getitem__(self, name: str) -> Array:
        """One quantity by its name, (n,): run["theta_1"], run["R3_2"], run["tip_x"]. Raises InputError.

        Beside `names` there are energy_drift and effort_, a kind of effect and a joint, as in run["effort_gravity_theta_1"].
        """
        return column(self, name)

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

    def __eq__(self, other: object) -> bool:
        """Whether another run is of the same scene and holds the same numbers."""
        if not isinstance(other, RunRecord):
            return NotImplemented
        one, two = ((run.joints, run.scene, run.events, run.arrays.keys(), len(run.held)) for run in (self, other))
        if one != two or not all(map(np.array_equal, self.held, other.held)):
            return False
        return all(np.array_equal(array, other.arrays[name]) for name, array in self.arrays.items())

    def __hash__(self) -> int:
        """Equal runs have equal hashes."""
        return hash((self.joints, len(self.t)))

    def __repr__(self) -> str:
        if not len(self.t):
            return "a run without samples"
        setting = f"{self.stats.method} with {self.stats.setting}, {self.stats.steps} steps"
        span = f"{moment(self.t[0])} to {moment(self.t[-1])} s, {amount(len(self.t), 'sample')}"
        return f"{model_in_words(self)}: {span}, {setting}"

    def reactions(self) -> AnyReactions:
        """What its joint exerts on every rod, each (n, rods): docs/python.md. Raises InputError where no rod has its own."""
        if self.rod_reactions is None:
            raise InputError("this model has no universal joint, so no R1, R2, R3, M3; see .wrench for every joint")
        return self.rod_reactions

    def energy(self) -> Energy:
        """Kinetic and potential energy over time."""
        return Energy(self.kinetic, self.potential)

    @property
    def imbalance(self) -> float:
        """The largest difference of the change of kinetic energy and the works, divided by the energy exchanged."""
        if not self.work:
            return 0.0
        return share(np.abs(self.unbalanced), self.kinetic, *self.work.values())

    @property
    def unbalanced(self) -> Array:
        """The change of kinetic energy that no work explains, (n,) in J."""
        return self.kinetic - self.kinetic[:1] - sum(work - work[:1] for work in self.work.values())

    @property
    def sound(self) -> int:
        """The number of samples before the first with a number that is not finite or beyond LARGEST."""
        n, rods = len(self.t), self._derived.rod_reactions
        given = () if rods is None or callable(rods) else rods  # those still to be computed are wrenches, turned
        arrays = [array.reshape(n, -1) for array in (self.t, self.q, self.v, *self._derived[:-1], *given)]
        if sum(float(np.vdot(array, array)) for array in arrays) <= LARGEST**2:  # and none is NaN: a third of the time
            return n
        fine = np.all([(np.abs(array) <= LARGEST).all(1) for array in arrays], 0)
        return n if fine.all() else int(np.argmin(fine))

    def save(self, path: str | Path) -> Path:
        """Write everything to an .npz file, whole or not at all. Raises InputError where that cannot be."""
        path = path_of(path)
        if path.suffix.lower() in TABLES:
            raise InputError(f"{path}: save writes .npz; to_csv({str(path)!r}) writes this run as a table")
        refuse_other_format(path, ".npz")
        arrays = pack_run(with_samples(self))
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
        if not hasattr(scene, "model_dump"):
            raise InputError(f"scene: {shown(scene)} is not a Scene")
        scene = scene.replace(**{name: value for name, value in run.scene.items() if name not in ("model", "effects")})
        if scene.model_dump(mode="json") != run.scene:
            raise InputError(f"scene: its model or effects are not those of the run in {path}")
        return replace(run, source=scene)


FIELDS = frozenset(RunRecord.__dataclass_fields__)
Kind = TypeVar("Kind", bound=RunRecord)


def model_in_words(run: RunRecord) -> str:
    """The number of rods, or a URDF by its name."""
    model, bodies, joints = run.scene.get("model") or {}, run.tips.shape[1], len(run.joints)
    if model.get("kind") == "chain":
        return amount(bodies, "rod")
    name = str(model.get("name") or model.get("path") or "").replace("\\", "/").rpartition("/")[2]
    return f"{name[:40] or 'a tree'}, {amount(joints, 'joint')}"


def with_samples(run: Kind) -> Kind:
    """The run itself. Raises InputError if it has no samples, as `crossings` gives where nothing is crossed."""
    if not len(run.t):
        raise InputError("this run has no samples, as nothing was crossed")
    return run


def samples_of(run: Kind, rows: Any) -> Kind:
    """The samples of a run at some places, an index of NumPy that leaves an array."""
    return run.with_arrays({name: array[rows] for name, array in run.arrays.items()})


def joined(runs: Sequence[Kind]) -> Kind:
    """Runs one after the other, each without what the one before has; stats and scene are those of the first."""
    whole = runs[0].with_arrays({name: np.concatenate([run.arrays[name] for run in runs]) for name in runs[0].arrays})
    events = tuple(event for run in runs for event in run.events)
    return replace(whole, held=runs[-1].held, events=events)  # held: from the first instant on

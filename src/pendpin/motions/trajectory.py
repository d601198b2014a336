"""`simulate`: the motion of a scene as a Trajectory, the public face of a run: its record, and what a user asks of it."""

import html
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any, Self

import numpy as np

from pendpin.dynamics.dynamics import efforts as efforts_of
from pendpin.engines import ProgressCallback
from pendpin.errors import PendpinError, RunError, amount, say_note
from pendpin.ground.arguments import flag, function
from pendpin.ground.arrays import Array, ArrayLike
from pendpin.ground.files import path_of, refuse_other_format, write_csv
from pendpin.ground.libraries import optional
from pendpin.model.build import Model, build
from pendpin.model.kinematics import configurations, express_wrench, model_of, spins_and_momentum
from pendpin.model.notes import notes
from pendpin.motions import continuation, search
from pendpin.motions.search import Extreme
from pendpin.motions.summary import Summary, summary, text
from pendpin.runs.checkpoint import EVERY, Checkpoint
from pendpin.runs.limits import Deadline
from pendpin.runs.simulate import run_to_setting, varied
from pendpin.scene import Scene
from pendpin.trajectory import HingeReactions, RunRecord, samples_of, with_samples
from pendpin.trajectory.columns import AXES, EFFORTS, TABLES, UNITS, WRENCH, is_chain, place_of, unit_of

ROWS_AT_ONCE = 4096  # turned into text: bounds the memory that a long run takes


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(RunRecord):
    __doc__ = RunRecord.__doc__

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
        return express_wrench(with_samples(self), joint, frame, point, on)

    def at(self, times: ArrayLike) -> Self:
        """The run at any times inside it, (m,) in s, rising, or one: as accurate as the run.

        Integrated from the sample before, by the run's own method and setting; at the instant of an impact the state
        after it. Raises InputError for other times, and where the run's scene cannot be built again.
        """
        return self.of(continuation.at(with_samples(self), times))

    def crossings(self, name: str, level: float = 0.0, direction: int = 0) -> Self:
        """The run at the instants at which a quantity crosses a level: upwards (1), downwards (-1) or both ways (0).

        Found between the samples, each to the accuracy of the run. An angle counts its turns: it is not wrapped. There
        may be none. Raises InputError.
        """
        return self.of(search.crossings(with_samples(self), name, level, direction))

    def maximum(self, name: str) -> Extreme:
        """The largest value of a quantity, and when it is reached in s: found between the samples, to the run's accuracy.

        As run.maximum("R3_1").value and .t. Where the quantity jumps at an event, t is the event's time for a value just
        behind it, and the double before for one just before it: run.at(t) has the value. At an impact forces and
        accelerations are not defined; those between impacts count, and a Note says so. Raises InputError.
        """
        return self._extreme(name, 1.0)

    def minimum(self, name: str) -> Extreme:
        """The least value of a quantity, and when it is reached in s, like `maximum`."""
        return self._extreme(name, -1.0)

    def _extreme(self, name: str, sign: float) -> Extreme:
        extreme, count = search.extreme(with_samples(self), name, sign), search.impacts(self)
        if count and place_of(self, name)[0] in ("a", "wrench", EFFORTS, *HingeReactions._fields):  # infinite there
            reason = f"not defined at {amount(count, 'impact')}; the extreme elsewhere is returned"
            say_note(f"{name} is {reason}", stacklevel=4)
        return extreme

    def extend(self, duration: float) -> Self:
        """The run continued for another duration in s, with samples as dense as before.

        With rk4 and euler the result is bit for bit that of one long run with the same sample times; with other methods and
        thin rods it is that within the run's accuracy. Fixed steps go on from the last sample at which one ends.
        """
        return self.of(continuation.extend(with_samples(self), duration))

    def state_transition(self, t0: float, t1: float) -> Array:
        """The derivative of (q, v) at t1 by (q, v) at t0 (s, inside the run): (2 nv, 2 nv), to the accuracy of the run.

        Integrated beside the motion by exact derivatives of the equations, through sticking and slipping too. Raises
        InputError for other times, for stops, and for effects without derivatives; RunError where angles have no derivative.
        """
        from pendpin.motions.variations import state_transition

        return state_transition(with_samples(self), t0, t1)

    def sensitivity(self, keys: Sequence[str] | str, of: str | None = None) -> Array:
        """The derivatives of the motion by numbers of the scene at k key paths, to the accuracy of the run.

        Args:
            keys: such as "model.rods[0].length", "effects[1].coefficient", "start.positions.theta_1".
            of: the name of a quantity, or a name with a statistic. "R3_1.max" and "R3_1.min" are the values of `maximum` and
                `minimum`, between the samples too; "R3_1.final" and "R3_1.mean" are those of the samples.

        Returns:
            d(q, v)/d(number) at the samples, (n, 2 nv, k). With `of` the derivatives of the quantity, (n, k), or of its
            statistic, (k,). Units are those of the quantity over those of the number.

        Raises:
            InputError: for keys that are not numbers of the scene, as `state_transition`, and for an extreme that has no
                derivative: of a rate where a joint sticks or slips, or of the swing at 0 or half a turn. Also for works and
                efforts: their derivatives are not computed.
        """
        from pendpin.motions.variations import sensitivity

        return sensitivity(with_samples(self), keys, of)

    _summary = cached_property(summary)

    def summary(self) -> Summary:
        """The largest swing, of the line from the support to the last tip, rest; extremes of R1, R2, R3, M3.

        With their times; periods and energy too. Extremes are those between the samples too, unless a remark says why not.
        """
        return self._summary

    def to_pandas(self, *names: str) -> Any:
        """A pandas DataFrame over time, a column for each name, units in attrs["units"]. MissingLibrary without pandas."""
        pandas = optional("pandas", "to_pandas", "pandas")
        columns = [name for name in names or self.names if str(name) != "t"]
        frame = pandas.DataFrame({name: self[name] for name in columns}, index=pandas.Index(self.t, name="t"))
        frame.attrs["units"] = {name: unit_of(self, name) for name in ("t", *columns)}
        return frame

    def to_xarray(self) -> Any:
        """An xarray.Dataset of the arrays over t, joint, rod, axis and component, with units; tips of a robot over link.

        Raises MissingLibrary without xarray.
        """
        xarray = optional("xarray", "to_xarray", "xarray")
        units = {name: f"{UNITS[name]}, of slides {UNITS[name].replace('rad', 'm')}" for name in "qva"}
        per_joint = {name: (("t", "joint"), getattr(self, name), {"units": unit}) for name, unit in units.items()}
        rods, count = 0 if self.rod_reactions is None else self.rod_reactions.R1.shape[1], self.tips.shape[1]
        bodies = {"rod": range(1, rods + 1)} if rods else {}
        bodies |= {} if rods == count else {"link": self.links or range(1, count + 1)}
        fixed = {
            "wrench": (("t", "joint", "component"), self.wrench, {"units": "N, of moments N m"}),
            "tips": (("t", list(bodies)[-1], "axis"), self.tips, {"units": "m"}),
            "kinetic": (("t",), self.kinetic, {"units": "J"}),
            "potential": (("t",), self.potential, {"units": "J"}),
        }
        reactions = {} if self.rod_reactions is None else self.rod_reactions._asdict()
        fixed |= {name: (("t", "rod"), values, {"units": UNITS[name]}) for name, values in reactions.items()}
        if is_chain(self):
            fixed |= {"tension": (("t", "rod"), reactions["R3"], {"units": "N"})}
            fixed |= {f"omega{k + 1}": (("t", "rod"), self.omega[..., k], {"units": UNITS["omega"]}) for k in range(3)}
            fixed["swing"] = (("t",), self["swing"], {"units": UNITS["swing"]})
            fixed["angular_momentum"] = (("t", "axis"), self.angular_momentum, {"units": UNITS["angular_momentum"]})
        fixed |= {f"work_{kind}": (("t",), work, {"units": "J"}) for kind, work in self.work.items()}
        coordinates: dict[str, Any] = {"t": ("t", self.t, {"units": "s"}), "joint": list(self.joints)}
        coordinates |= {name: list(labels) for name, labels in bodies.items()}
        coordinates |= {"axis": list(AXES), "component": list(WRENCH)}
        dataset = xarray.Dataset(per_joint | fixed, coordinates, {"title": self.title, "method": self.stats.method})
        return dataset.copy(deep=True)  # the arrays of the run are read-only

    def efforts(self) -> dict[str, Array]:
        """The generalised force of each kind of effect on each joint, (n, nv) in N m, N for slides; dry friction and stops
        together as "contacts". Their sum is the inverse dynamics of the motion. By name: run["effort_gravity_theta_1"].
        Raises InputError.
        """
        return efforts_of(with_samples(self))

    def to_csv(self, path: str | Path, *names: str) -> Path:
        """Write a CSV file with a column for each name, t first, every digit kept; all `names` if absent. InputError."""
        path = path_of(path)
        refuse_other_format(path, *TABLES)
        columns = ["t", *(name for name in names or self.names if str(name) != "t")]
        rows = np.array([self[name] for name in columns]).T
        pieces = (rows[first : first + ROWS_AT_ONCE].tolist() for first in range(0, len(rows), ROWS_AT_ONCE))
        return write_csv(path, columns, chain.from_iterable(pieces))

    def plot(self, *names: str, ax: Any = None, compare: Any = None) -> Any:
        """Draw quantities by name, as in run[name], against time on a matplotlib Axes, and return it.

        Without `ax` a new Figure is returned, with a panel for each unit. Without names it is the figure of the run.
        `compare` is another run, or up to three, drawn on the same axes. Raises InputError.
        """
        from pendpin.graphics.figure import plot

        return plot(self if names else with_samples(self), names, ax, compare)

    def animate(self, compare: Any = None) -> Any:
        """The motion as an Animation, which shows itself in a notebook; .save("x.html"), "x.gif" or "x.mp4".

        `compare` is another run, or up to three, shown in the page as ghosts, with their distance. Raises InputError.
        """
        from pendpin.graphics.view import Animation
        from pendpin.motions.crosschecks.crosscheck import run_verdict

        return Animation(with_samples(self), compare, run_verdict)

    def show(self, viewer: Any) -> Any:
        """Play the run in a viewer that is there: a meshcat.Visualizer, or Pinocchio's MeshcatVisualizer."""
        from pendpin.graphics.view import show

        return show(with_samples(self), viewer)

    def configurations(self, pin_model: Any) -> Array:
        """q as a pin.Model takes it, (n, nq): continuous joints as cosine and sine, joints that are locked in place."""
        return configurations(self, pin_model)

    @cached_property
    def _model(self) -> Model | None:
        try:
            return model_of(self)
        except PendpinError:
            return None

    @cached_property
    def slides(self) -> frozenset[str] | None:
        """The names of the prismatic joints; None where the model cannot be built again, as when its URDF is gone."""
        model = self._model
        return None if model is None else frozenset(np.array(model.joints)[model.slides].tolist())

    @cached_property
    def links(self) -> tuple[str, ...] | None:
        """The names of the links whose tips there are; None like `slides`."""
        return None if self._model is None else tuple(body.link for body in self._model.bodies)

    @property
    def omega(self) -> Array:
        """Angular velocities of the rods of a chain, (n, rods, 3) in rad/s along b1, b2, b3. Raises InputError."""
        return self._spins_and_momentum[0]

    @property
    def angular_momentum(self) -> Array:
        """That of a chain about its support, (n, 3) in kg m²/s, in W, of the motion relative to W. Raises InputError."""
        return self._spins_and_momentum[1]

    _spins_and_momentum = cached_property(spins_and_momentum)

    computed_efforts = cached_property(efforts)

    def __repr__(self) -> str:
        return text(self)

    def _repr_html_(self) -> str:
        from pendpin.graphics.view import frame_of

        lines = f'<pre style="white-space: pre-wrap">{html.escape(text(self))}</pre>'
        return f"{frame_of(self)}{lines}{self.summary()._repr_html_()}"


def simulate(
    scene: Scene | str | Path,
    *,
    duration: float | None = None,
    samples: int | None = None,
    times: ArrayLike | None = None,
    method: str | None = None,
    tolerance: float | None = None,
    step: float | None = None,
    accuracy: float | None = None,
    energy_balance: bool = False,
    progress: ProgressCallback = lambda t: None,
    limit: float | None = None,
    checkpoint: str | Path | None = None,
    every: float = EVERY,
    anyway: bool = False,
) -> Trajectory:
    """Simulate a scene and return its motion at the output times.

    Arguments that are given replace those of the scene and its solver. An input that is allowed and probably a mistake, such
    as angles of many turns, gives a warning (pendpin.errors.Note).

    Args:
        scene: a Scene, or the path of a TOML file.
        duration: s; the scene's if absent, or up to the last of `times`.
        samples: number of evenly spaced output times, both ends included.
        times: output times in place of samples, (n,) s, rising, in the scene's own time: from start.time on.
        method: a method by name, or "auto".
        tolerance: for methods without a fixed step, relative and absolute; rad and rad/s.
        step: s, for methods with a fixed step; the last one may be shorter.
        accuracy: target for the largest distance of a tip from the true motion over the chain's length. The tolerance or
            step that meets it is found, and the method if none is given; `stats` holds them and the estimated error.
        energy_balance: integrate the work of every effect too; see the trajectory's `work`.
        progress: called with the time reached, s.
        limit: s of wall time, after which the call ends; infinity sets no limit. Compiling, all runs for
            an accuracy, and the samples count.
        checkpoint: a file in which the state is saved, whole or not at all, at output times. If it exists, the run
            continues from it, with a result that is equal bit for bit to that of an uninterrupted run. Scene, settings
            and versions must be the same. The file stays when the run has ended: delete it once the result is saved.
        every: s of wall time between two saves.
        anyway: run to the end where the energy goes wrong, as by a poor method; a note in `stats` says from when on.

    Returns:
        The Trajectory.

    Raises:
        InputError: for a scene that cannot be run.
        RunError: for a run that cannot reach its end or its accuracy; `partial` is the Trajectory up to there.
    """
    deadline, progress = Deadline(limit), function("progress", progress)
    settings = {"method": method, "tolerance": tolerance, "step": step, "accuracy": accuracy}
    energy_balance, anyway = flag("energy_balance", energy_balance), flag("anyway", anyway)
    chosen = varied(scene, duration, samples, times, settings)
    for note in notes(chosen, build(chosen.model)):
        say_note(note, stacklevel=3)
    saved = None if checkpoint is None else Checkpoint(path_of(checkpoint), every)
    try:
        return _with_asked_samples(chosen, run_to_setting(chosen, energy_balance, progress, deadline, saved, anyway))
    except RunError as error:
        error.partial = _with_asked_samples(chosen, error.partial)
        raise


def _with_asked_samples(scene: Scene, record: RunRecord) -> Trajectory:
    """The run without the sample at the start if that is not one of the requested times."""
    extra = scene.extra_samples
    return Trajectory.of(samples_of(record, slice(extra, None)) if extra and len(record.t) > extra else record)

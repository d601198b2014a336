"""What a run needs before it begins: the effects of a scene bound once, its method and engine chosen once."""

from dataclasses import dataclass, replace
from functools import cache, cached_property, partial

import numpy as np

from pendpin.dynamics.acting import built_in, in_order, plain_arithmetic
from pendpin.dynamics.binding import Accounts, State
from pendpin.dynamics.contacts import check_start
from pendpin.dynamics.dynamics import Dynamics, bind
from pendpin.dynamics.pace import Paces, paces_of
from pendpin.effects import Idle, Torque
from pendpin.engines import Engine
from pendpin.errors import InputError
from pendpin.ground.arrays import Array
from pendpin.ground.libraries import ThreadCache
from pendpin.integrators import choose_method_and_engine
from pendpin.model.build import Model, build, start_state
from pendpin.scene import PinModel, Scene, method_of

MACHINE_CODE = ("auto", "compiled")  # engines with which something may be compiled
MOST_KEPT = 8  # scenes, in a thread
MOST_JOINTS = 20  # of a scene that is kept: Pinocchio's data grow like nv³, 600 MB at 200 joints
known_dynamics, known_runs = ThreadCache["Dynamics"](MOST_KEPT), ThreadCache["Prepared"](MOST_KEPT)


class EnergyBalance:
    """The work of each kind of effect in one scene; `engine`: the dynamics', if compiled with the work in its state."""

    def __init__(self, dynamics: Dynamics) -> None:
        effects, accounts = dynamics.effects, Accounts.of(dynamics.effects, dynamics.potentials)
        self.kinds, self._nv = accounts.kinds, len(dynamics.model.joints)
        self._idle = tuple(effect.kind for effect in effects if isinstance(effect, Idle))
        self.engine: Engine = dynamics.compiled(accounts) if dynamics.engine.compiles else dynamics.engine
        self._powers = dynamics.binding.powers(accounts)
        ordered = [effect for effect, _ in in_order(effects)]
        self._offered = [
            (self.kinds.index(ordered[place].kind), place)
            for place, potential in enumerate(dynamics.potentials)
            if potential is not None and not isinstance(ordered[place], Idle)
        ]

    def powers(self, t: float, y: Array) -> Array:
        """The power (kinds,) in W of the effects without a potential, at t in s since the start and the engine's state y."""
        nv = self._nv
        return np.array(self._powers(State(t, y[:nv], y[nv : 2 * nv], cache(lambda: self.engine.motion(y)))), float)

    def close(self, work: Array, potentials: Array) -> dict[str, Array]:
        """The work of each kind (n,) in J, from what was integrated (n, kinds) and the effects' potentials (n, effects)."""
        total = work.copy()
        for account, place in self._offered:
            total[:, account] += potentials[0, place] - potentials[:, place]
        return dict.fromkeys(self._idle, np.zeros(len(work))) | dict(zip(self.kinds, total.T, strict=True))


@dataclass(frozen=True, eq=False)
class Prepared:
    """A scene that can be run at once. One run at a time: dynamics are not shared among threads."""

    scene: Scene  # with a method and an engine in place of "auto"
    bound: Dynamics  # as the scene was bound, for other methods
    dynamics: Dynamics  # in the form in which it is integrated
    q: Array  # (nv,) at the start
    v: Array  # (nv,)
    balance: EnergyBalance | None  # of the work of effects, if it is integrated too

    @classmethod
    def of(cls, scene: Scene, energy_balance: bool = False) -> "Prepared":
        """The scene, bound; as for its last run where it may run again. InputError for a scene that cannot be run."""

        def anew() -> Prepared:  # bound again where the method that is chosen integrates another form of state
            chosen, dynamics = scene, bind_for_run(scene)
            q, v = start_state(dynamics.model, scene.start)
            if dynamics.contacts is not None:
                check_start(dynamics.contacts, dynamics.model, q)
            method, engine = choose_method_and_engine(scene, dynamics, q, v, energy_balance)
            if (method, engine) != (scene.solver.method, scene.solver.engine):
                chosen = scene.with_solver(method=method, engine=engine)
                if _form_of(method, dynamics.model) != _form_of(scene.solver.method, dynamics.model):
                    dynamics = bind_for_run(chosen)
            return cls._from_start(chosen, energy_balance, dynamics, q, v)

        if isinstance(scene.model, PinModel):
            return anew()
        return known_runs.look_up((build(scene.model), scene, energy_balance), anew, partial(_runs_again, scene))

    @classmethod
    def _from_start(cls, scene: Scene, energy_balance: bool, bound: Dynamics, q: Array, v: Array) -> "Prepared":
        """The scene, by the method and engine that it names, from q, v (nv,): the dynamics of what moves from there."""
        for part in (q, v):  # several runs may begin from them
            part.setflags(write=False)
        method, compiles, dynamics = method_of(scene.solver.method), scene.solver.engine == "compiled", bound
        if method.setting == "tolerance" and not energy_balance and (compiles or method.name == "taylor"):
            dynamics = bound.in_motion(q, v, compiles)
        elif compiles:
            dynamics = bound.in_machine_code
        return cls(scene, bound, dynamics, q, v, EnergyBalance(dynamics) if energy_balance else None)

    def with_scene(self, scene: Scene) -> "Prepared":
        """The same model and effects with another setting or start; bound again for another method or engine."""
        same = all(getattr(scene.solver, name) == getattr(self.scene.solver, name) for name in ("method", "engine"))
        # Sampled torques are bound for each run, as they record its outputs.
        if not same or self.bound.sampled_torques or scene.start.time != self.scene.start.time:
            return Prepared.of(scene, self.balance is not None)
        if scene.start is self.scene.start:
            return replace(self, scene=scene)
        q, v = start_state(self.bound.model, scene.start)
        if self.bound.contacts is not None:
            check_start(self.bound.contacts, self.bound.model, q)
        return Prepared._from_start(scene, self.balance is not None, self.bound, q, v)

    @cached_property
    def paces(self) -> Paces:
        """How fast what acts on the scene changes, and what is known of that."""
        scene, dynamics = self.scene, self.dynamics
        return paces_of(dynamics, dynamics.effects, self.q, self.v, scene.duration, scene.solver.tolerance)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What a reader of its runs should know."""
        solver, notes = self.scene.solver, self.paces.notes(self.scene.duration, self.scene.solver.step)
        if not method_of(solver.method).damps or built_in(self.scene.effects):
            return notes
        # a difference across a jump looks like a fast decay
        jumps = f"{solver.method} may be wrong where a function of your own jumps, as sign(v) does: compare with dop853"
        return jumps, *notes


def _runs_again(scene: Scene) -> bool:
    """Whether what is bound of a scene serves further runs in this thread: all that it holds is the scene's own numbers."""
    return (  # a function of the user's may change, and so may a file; a torque with `every` records a run
        plain_arithmetic(scene.effects)
        and not any(isinstance(effect, Torque) or getattr(effect, "csv", None) for effect in scene.effects)
        and len(build(scene.model).joints) <= MOST_JOINTS
    )


def bind_for_run(scene: Scene) -> Dynamics:
    """The dynamics of a scene, which others that differ in start and settings alone share within a thread."""
    try:
        scene.refuse_short_effects()
    except ValueError as error:
        raise InputError(str(error)) from None

    def bound() -> Dynamics:
        dynamics = bind(scene)
        if scene.solver.engine in MACHINE_CODE:  # samples too
            dynamics.use_compiled_samples()
        return dynamics

    if isinstance(scene.model, PinModel):  # built anew for every run, as it may have changed
        return bound()
    model = build(scene.model)
    settings = scene.solver.engine, _form_of(scene.solver.method, model), scene.start.time
    return known_dynamics.look_up((model, scene.effects, *settings), bound, partial(_runs_again, scene))


def _form_of(method: str, model: Model) -> str:
    """The form of the state that a method integrates; "any" of one still to be chosen, and where there is one form only."""
    thin = model.chain is not None and model.chain.first_thin == 0
    return method_of(method).state if thin and method != "auto" else "any"

"""How a scene is integrated: the methods, one record each with what is true of it in every run, and a scene's Solver.

To add a method: a class in pendpin/integrators and a record below. The scene's validation, the choice of an integrator,
the search for an accuracy, the comparison of costs and the figures read the record; a law in tests/test_integrators.py
measures the order that it states.
"""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, ValidationInfo, WithJsonSchema, field_validator
from pydantic_core import PydanticKnownError

from pendpin.errors import InputError, choices, not_one_of
from pendpin.ground.records import Number, Positive, Record

Form = Literal["any", "angles", "directions"]  # of the state; "angles" never carries thin rods as directions

EXPLICIT, IMPLICIT, MULTISTEP = "explicit Runge-Kutta", "implicit Runge-Kutta", "linear multistep"
COLLOCATION, SERIES, SPLITTING = "Gauss-Legendre collocation", "Taylor series", "symplectic splitting"


@dataclass(frozen=True, kw_only=True)
class Method:
    """What is true of a method in every run."""

    name: str
    integrator: str | type  # the class, or its module and name in pendpin.integrators
    family: str  # one of the six above
    setting: Literal["tolerance", "step"]
    order: float | None  # of convergence in the step; None where the method varies it
    stages: int = 1  # evaluations in a step; of collocation, its points
    state: Form = "any"  # what it can integrate
    library_name: str = ""  # in CyRK and SciPy
    damps: bool = False  # L-stable: what decays fast is damped in one step, and so is what only looks like a decay
    machine_code: bool = False  # whether engine = "auto" compiles the equations for it
    least_tolerance: float = 1e-14  # a few times the rounding error of one step
    # Both measured on random scenes by benchmarks/goal.py, with a margin: the search for an accuracy rests on them.
    steepest: float = math.inf  # the highest power of the step with which the error falls between two tolerances
    scatter: float = 1.5  # the largest factor between an error and the power law through its neighbours
    step_price: float = 1.0  # the time of a step over that of a step of euler, which takes 0.01 ms for one rod
    color: str = "#1a202c"  # in figures
    price_rank: int = 99  # comparisons begin with the methods that are most often the cheapest

    @property
    def implicit(self) -> bool:
        """Whether its steps solve equations: they may be long where a motion is stiff, and may agree on a wrong one."""
        return self.family in (IMPLICIT, MULTISTEP, COLLOCATION)

    @property
    def symplectic(self) -> bool:
        """Whether its energy error stays bounded over long horizons, at a fixed step."""
        return self.family in (COLLOCATION, SPLITTING)

    @property
    def shows_rounding(self) -> bool:
        """Whether a run that is pushed off by its rounding error shows what rounding does: its steps hardly change."""
        return self.setting == "tolerance" and self.family != EXPLICIT

    @property
    def handles_events(self) -> bool:
        """Whether its steps can be searched for events: all adaptive methods but the series."""
        return bool(self.library_name)


def _adaptive(name: str, library_name: str, family: str, order: float | None, **facts: Any) -> Method:
    facts |= {"integrator": "adaptive:Adaptive", "setting": "tolerance", "machine_code": True}
    return Method(name=name, library_name=library_name, family=family, order=order, **facts)


def _collocation(stages: int, **facts: Any) -> Method:
    facts |= {"integrator": "gauss:Gauss", "setting": "step", "state": "angles"}  # it integrates positions and momenta
    facts |= {"step_price": 30.0}  # 20 to 40: it solves the stage equations in Python
    return Method(name=f"gauss{2 * stages}", family=COLLOCATION, order=2 * stages, stages=stages, **facts)


def _fixed(name: str, of: str, family: str, order: float, **facts: Any) -> Method:
    return Method(name=name, integrator=f"fixed:{of}", family=family, setting="step", order=order, **facts)


_RECORDS = (
    _adaptive("dop853", "DOP853", EXPLICIT, 8, stages=12, steepest=9, scatter=2.5, color="#2b6cb0", price_rank=0),
    _adaptive("rk45", "RK45", EXPLICIT, 5, stages=6, steepest=6, color="#63a4d8", price_rank=3),
    _adaptive("rk23", "RK23", EXPLICIT, 3, stages=3, steepest=4, color="#a3c9e8", price_rank=9),
    _adaptive("radau", "Radau", IMPLICIT, 5, stages=3, steepest=6, damps=True, color="#6b46c1", price_rank=5),
    _adaptive("bdf", "BDF", MULTISTEP, None, steepest=7, scatter=2.5, damps=True, color="#9f7aea", price_rank=8),
    _adaptive("lsoda", "LSODA", MULTISTEP, None, steepest=14, scatter=3, color="#2f855a", price_rank=2),
    Method(
        name="taylor",
        integrator="taylor:Taylor",
        family=SERIES,
        setting="tolerance",
        order=None,
        state="directions",
        least_tolerance=1e-18,  # its sums are compensated
        scatter=2.5,
        color="#d9622b",
        price_rank=1,
    ),
    _collocation(1, color="#d69e2e", price_rank=10),
    _collocation(2, color="#b7791f", price_rank=7),
    _collocation(3, color="#744210", price_rank=6),
    _fixed("rk4", "RungeKutta4", EXPLICIT, 4, stages=4, machine_code=True, color="#718096", price_rank=4),
    _fixed("euler", "SemiImplicitEuler", SPLITTING, 1, state="angles", color="#a0aec0", price_rank=11),
)
METHODS = {record.name: record for record in _RECORDS}


def add_method(method: Method) -> None:
    """Make a method of one's own known by its name: to scenes, `simulate`, `cost` and all that walks the table.

    `method.integrator` is a class that derives from Integrator or FixedStep of pendpin.integrators. Other processes, such as
    the workers of a cluster, have to call this too. Raises InputError for a name that the table has.
    """
    if method.name in ("auto", *METHODS):
        raise InputError(f"add_method: {method.name} is there already; give the method another name")
    METHODS[method.name] = method


def fixed_methods() -> tuple[str, ...]:
    """The names of the methods with a fixed step."""
    return tuple(name for name, method in METHODS.items() if method.setting == "step")


def event_methods() -> tuple[str, ...]:
    """The names of the methods that find events."""
    return tuple(name for name, method in METHODS.items() if method.handles_events)


def method_of(name: str) -> Method:
    """The record of a method. Raises InputError for a name that no record has."""
    if name not in METHODS:
        raise InputError(f"solver.method: {not_one_of(name, tuple(METHODS))}")
    return METHODS[name]


# --- the settings of a scene ----------------------------------------------------------------------------------------

TOLERANCE = 1e-10  # unless another is given
MAX_SAMPLES = 2_000_000
BESIDE_ACCURACY = "an accuracy is given, from which pendpin finds this number; leave one of them out"


def _refuse_unknown(name: str) -> str:
    if name != "auto" and name not in METHODS:
        raise PydanticKnownError("literal_error", {"expected": ", ".join(("auto", *METHODS))})
    return name


NAMES = ("auto", *METHODS)  # those of pendpin; `add_method` adds others
MethodName = Annotated[
    str, Field(strict=True), AfterValidator(_refuse_unknown), WithJsonSchema({"type": "string", "enum": [*NAMES]})
]


Accuracy = Annotated[Positive, Field(le=0.1)]


class Solver(Record):
    """How the scene is integrated and how often the motion is recorded.

    A method has a tolerance (relative and absolute, rad and rad/s) or, with fixed steps, a step. The step asked is
    the step taken; the last one may be shorter, and samples inside a step have the order of the method. An accuracy replaces
    both: pendpin finds the tolerance or step that meets it, and with method "auto" the method too.
    """

    method: MethodName = Field("auto", description=f"{choices(NAMES)} (docs/accuracy.md)")
    engine: Literal["auto", "pinocchio", "chain", "compiled"] = Field("auto", description="what computes accelerations")
    accuracy: Accuracy | None = Field(None, description="the target: largest tip error over the chain's length")
    tolerance: Annotated[Number, Field(le=0.1)] | None = Field(
        None, validate_default=True, description=f"for methods without a fixed step; {TOLERANCE:g} if none is given"
    )
    step: Positive | None = Field(
        None, validate_default=True, description=f"s, for methods with a fixed step: {', '.join(fixed_methods())}"
    )
    samples: Annotated[int, Field(strict=True, ge=1, le=MAX_SAMPLES)] | None = Field(
        None,
        description="evenly spaced output times from 0 to duration, both ends included; 60 a second (at least 2) if absent",
    )
    times: Annotated[tuple[Number, ...], Field(min_length=1, max_length=MAX_SAMPLES)] | None = Field(
        None, description="s, rising: the output times in place of samples, from start.time to start.time + duration"
    )

    @field_validator("tolerance")
    @classmethod
    def _tolerance_of(cls, tolerance: float | None, info: ValidationInfo) -> float | None:
        method, accurate = info.data.get("method", ""), info.data.get("accuracy") is not None
        if accurate or method in fixed_methods():
            if tolerance is not None:
                raise ValueError(BESIDE_ACCURACY if accurate else f"{method} takes a step, not a tolerance")
            return None
        least = METHODS[method].least_tolerance if method in METHODS else 1e-14  # where it is still to be chosen
        if tolerance is not None and tolerance < least:
            raise PydanticKnownError("greater_than_equal", {"ge": least})
        return TOLERANCE if tolerance is None else tolerance

    @field_validator("step")
    @classmethod
    def _step_of(cls, step: float | None, info: ValidationInfo) -> float | None:
        method = info.data.get("method", "")
        if info.data.get("accuracy") is not None:
            if step is not None:
                raise ValueError(BESIDE_ACCURACY)
            return None
        # a tolerance that was refused is the fault; that no step is given follows from it
        if method in fixed_methods() and step is None and "tolerance" in info.data:
            raise ValueError(f"{method} takes a step, in s")
        if step is not None and method and method not in fixed_methods():
            raise ValueError(f"{method} takes a tolerance, not a step; a step is for {choices(fixed_methods())}")
        return step

    @field_validator("times")
    @classmethod
    def _times_rise(cls, times: tuple[float, ...] | None, info: ValidationInfo) -> tuple[float, ...] | None:
        if times is None:
            return None
        if info.data.get("samples") is not None:
            raise ValueError("samples are given too; leave one of them out")
        for i, (before, after) in enumerate(pairwise(times), 1):
            if not before < after:
                raise ValueError(f"times[{i}], {after:.15g} s, does not come after {before:.15g} s")
        return times

    def with_settings(self, **settings: Any) -> Self:
        """The solver with the settings given (those not None); its own settings that no longer fit are left out."""
        settings = {name: value for name, value in settings.items() if value is not None}
        method = settings.get("method", self.method)
        unfit = {"tolerance" if isinstance(method, str) and method in fixed_methods() else "step"}
        if "accuracy" in settings:
            unfit = {"tolerance", "step"}
        elif "tolerance" in settings or "step" in settings:
            unfit |= {"accuracy"}
        if "samples" in settings or "times" in settings:
            unfit |= {"samples", "times"}
        kept = {name: value for name, value in self.model_dump().items() if value is not None and name not in unfit}
        return type(self)(**(kept | settings))

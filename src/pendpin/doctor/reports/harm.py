"""What wrong equations do: the motion and reactions that they give when they are solved, beside the true ones."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import DOP853

from pendpin.arrays import Array
from pendpin.doctor.checking.check import euler_lagrange
from pendpin.doctor.checking.residuals import ENERGIES, Equation, residuals
from pendpin.doctor.diagnosis import Diagnosis, Finding
from pendpin.doctor.reading.tree import Unread
from pendpin.doctor.systems.base import Quantities, Values, dot, random_states, solved
from pendpin.doctor.systems.base import System as Kind
from pendpin.doctor.systems.rod import RODS, balances
from pendpin.doctor.systems.rod_names import UNKNOWNS

# of the rod, in kg, m, m/s² and kg m²
ROD = {"m": 1.0, "l": 1.0, "g": 9.81, "h": 0.5, "r": 0.05, "I1": 1 / 12, "I2": 1 / 12, "I3": 0.00125}
START = (0.7, 0.4, 1.3, -0.8)  # rad, rad/s
DURATION, SAMPLES = 5.0, 301  # s
APART = 0.01  # of the length
TOLERANCE = 1e-6
MOST_EVALUATIONS = 2_000  # of one motion
LARGEST_RATE = 1e3  # rad/s


@dataclass(frozen=True, eq=False)
class Harm:
    """Tips (n, 3) in m, in I with z down, of the true motion and of the one that the printed equations give; t (n,) in s."""

    words: tuple[str, ...]
    t: Array
    true: Array
    printed: Array


class System:
    """Six equations for the accelerations and reactions at one state, some of them as printed."""

    def __init__(self, printed: list[Equation], system: Kind) -> None:
        self.printed, self.system = printed, system
        reactions = {"R", "R1", "R2", "R3", "M", "M1", "M2", "M3", "Mc"}
        self.moving = all(not equation.names & reactions for equation in printed)

    def solution(self, state: Array) -> Array:
        """theta'', phi'', R1, R2, R3, M3 at (theta, phi, theta', phi'). Raises LinAlgError where there is none."""
        q = self._columns(state)
        wrong = [rows[0] for equation in self.printed for rows, _ in residuals(equation, q, instead={})]
        rows = self._laws(q)
        for row in wrong:
            rows[self._nearest(row, rows)] = row
        table = np.array(rows)
        matrix = table[:, 1:] - table[:, :1]
        largest = np.abs(matrix).max(1)
        return np.linalg.solve(matrix / largest[:, None], -table[:, 0] / largest)

    def _columns(self, state: Array) -> Quantities:
        """The state (4,) seven times: all unknowns 0, then each of them 1."""
        unknowns = dict(zip(UNKNOWNS, np.eye(6, 7, 1), strict=True))
        return Quantities(_base(np.tile(state, (7, 1)), self.system) | unknowns, self.system, np)

    def _laws(self, q: Quantities) -> list[Values]:
        """The true equations: solved for the accelerations, or the six balances where reactions are printed."""
        if self.moving:
            truth = solved(q)
            return [q[name] - truth[name] for name in UNKNOWNS]
        return [dot(vector, q[axis]) for vector in balances(q)[:2] for axis in ("b1", "b2", "b3")]

    @staticmethod
    def _nearest(row: Values, rows: list[Values]) -> int:
        """The law that a printed equation stands for: the one whose coefficients are most alike."""
        slopes = [r[1:] - r[0] for r in (row, *rows)]
        units = [s / (np.linalg.norm(s) or 1.0) for s in slopes]
        return int(np.argmax([abs(units[0] @ unit) for unit in units[1:]]))


def harm_of(diagnosis: Diagnosis) -> Harm | None:
    """The harm of the equations that fail, as far as they can be solved; None where they cannot."""
    printed = [equation for finding in diagnosis.wrong for equation in _dynamic(finding, diagnosis)]
    if not printed or diagnosis.system.kind not in RODS:
        return None
    system = System(printed, diagnosis.system)
    numbers = [f.number for f in diagnosis.wrong if any(True for _ in _dynamic(f, diagnosis))]
    try:
        return _compared(system, numbers, diagnosis)
    except (np.linalg.LinAlgError, Unread, ValueError, FloatingPointError):
        return None


def _dynamic(finding: Finding, diagnosis: Diagnosis) -> list[Equation]:
    """An equation that determines accelerations or reactions; of a Lagrangian its two equations of motion."""
    equation = finding.equation
    if (
        equation is None or len(equation.sides) != 2 or not finding.proved
    ):  # one for small angles is not solved at large ones
        return []
    if equation.names & ENERGIES.keys():
        return _from_lagrangian(equation, diagnosis)
    rows = next(residuals(equation, random_states(diagnosis.system)))[0]
    lone = [side for side in equation.sides if side.kind == "symbol" and side.value in (*UNKNOWNS, "Mc")]
    balance = equation.names & {*UNKNOWNS, "Mc"} and not equation.names & {"ac1", "ac2", "ac3", "wd1", "wd3"}
    return [equation] if len(rows) == 1 and (lone or balance) else []


def _from_lagrangian(equation: Equation, diagnosis: Diagnosis) -> list[Equation]:
    if not (equation.sides[0].kind == "symbol" and equation.sides[0].value == "L"):
        return []
    return [replace(equation, sides=(left,)) for left in euler_lagrange(equation.sides[1], diagnosis.system.spec)]


def _compared(wrong: System, numbers: list[int], diagnosis: Diagnosis) -> Harm | None:
    listed = " and ".join([", ".join(map(str, numbers[:-1])), str(numbers[-1])] if numbers[1:] else [str(numbers[0])])
    start = "1 kg, 1 m, from theta 0.7, phi 0.4, rates 1.3, -0.8"
    who = f"Equation{'s' if numbers[1:] else ''} {listed}, solved as printed ({start})"

    def truth(state: Array) -> Array:
        true = solved(_at(state[None], diagnosis))
        return np.array([true[name][0] for name in UNKNOWNS])

    here, there = wrong.solution(np.array(START)), truth(np.array(START))
    if np.allclose(here[:2], there[:2], rtol=1e-9, atol=1e-12):
        worst = int(np.argmax(np.abs(here - there)))
        values = f"{UNKNOWNS[worst]} is {here[worst]:.4g} in place of {there[worst]:.4g} at the start"
        words = (f"{who}: the motion is not changed, but {values}.",)
        return Harm(words, np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)))
    motions = [_motion(lambda t, x, f=f: np.concatenate([x[2:], f(x)[:2]])) for f in (truth, wrong.solution)]
    count = min(map(len, motions))
    t = np.linspace(0, DURATION, SAMPLES)[:count]
    right, printed = (_at(states[:count], diagnosis) for states in motions)
    apart = np.linalg.norm(right["rT"] - printed["rT"], axis=0) / ROD["l"]
    first = f"after {t[np.argmax(apart > APART)]:.2f} s the tip is 1 % of the length off"
    when = first if apart.max() > APART else "the tip stays within 1 %"
    words = f"{who}: {when}, at most {100 * apart.max():.0f} % within {t[-1]:.3g} s."
    change = np.ptp(printed["E"]) / (ROD["m"] * ROD["g"] * ROD["h"])
    energy = f"The energy of that motion changes by {100 * change:.1f} % of m g h."
    return Harm((words, energy), t, right["rT"].T, printed["rT"].T)


def _motion(rates: Callable[[float, Array], Array]) -> Array:
    """States (n, 4) at the output times, up to where the motion takes too many evaluations or runs away."""
    solver = DOP853(rates, 0.0, np.array(START), DURATION, rtol=TOLERANCE, atol=TOLERANCE)
    times, states = np.linspace(0, DURATION, SAMPLES), [np.array([START])]
    while solver.status == "running" and solver.nfev < MOST_EVALUATIONS and np.abs(solver.y[2:]).max() < LARGEST_RATE:
        before = solver.t
        solver.step()
        new = times[(times > before) & (times <= solver.t)]
        states.append(solver.dense_output()(new).T.reshape(-1, 4))
    return np.concatenate(states)


def _base(states: Array, system: Kind) -> dict[str, Values]:
    """Coordinates and parameters at states (n, 4)."""
    base: dict[str, Values] = {name: states[:, i] for i, name in enumerate(system.spec.state)}
    return base | {name: np.full(len(states), ROD[name]) for name in system.spec.parameters}


def _at(states: Array, diagnosis: Diagnosis) -> Quantities:
    """The quantities at states (n, 4): theta, phi in rad and their rates in rad/s."""
    return Quantities(_base(states, diagnosis.system), diagnosis.system, np)

"""What wrong equations do: the motion and reactions that they give when they are solved, beside the true ones."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import DOP853

from pendpin.doctor.checking.check import euler_lagrange
from pendpin.doctor.checking.residuals import ENERGIES, Equation, residuals
from pendpin.doctor.reading.tree import Unread
from pendpin.doctor.systems.base import Quantities, System, Values, dot, random_states, solved
from pendpin.doctor.systems.rod import RODS, balances
from pendpin.doctor.systems.rod_names import UNKNOWNS
from pendpin.ground.arrays import Array

# of the rod, in kg, m, m/s² and kg m²
ROD = {"m": 1.0, "l": 1.0, "g": 9.81, "h": 0.5, "r": 0.05, "I1": 1 / 12, "I2": 1 / 12, "I3": 0.00125}
START = (0.7, 0.4, 1.3, -0.8)  # rad, rad/s
DURATION, SAMPLES = 5.0, 301  # s
APART = 0.01  # of the length
TOLERANCE = 1e-6
MOST_EVALUATIONS = 2_000  # of one motion
LARGEST_RATE = 1e3  # rad/s
REACTIONS = {"R", "R1", "R2", "R3", "M", "M1", "M2", "M3", "Mc"}


@dataclass(frozen=True, eq=False)
class Harm:
    """Tips (n, 3) in m, in I with z down, of the true motion and of the one that the printed equations give; t (n,) in s."""

    words: tuple[str, ...]
    t: Array
    true: Array
    printed: Array


def harm_of(wrong: dict[int, Equation], system: System) -> Harm | None:
    """The harm of equations that fail, by their numbers, as far as they can be solved; None where they cannot."""
    if system.kind not in RODS:
        return None
    solvable = {number: _dynamic(equation, system) for number, equation in wrong.items()}
    solvable = {number: equations for number, equations in solvable.items() if equations}
    try:
        return _compared(solvable, system) if solvable else None
    except (np.linalg.LinAlgError, Unread, ValueError, FloatingPointError):
        return None


def _dynamic(equation: Equation, system: System) -> list[Equation]:
    """An equation that determines accelerations or reactions; of a Lagrangian its two equations of motion."""
    if len(equation.sides) != 2:
        return []
    left, right = equation.sides
    if equation.names & ENERGIES.keys():
        lagrangian = left.kind == "symbol" and left.value == "L"
        motion = euler_lagrange(right, system.spec) if lagrangian else []
        return [replace(equation, sides=(side,)) for side in motion]
    rows = next(residuals(equation, random_states(system)))[0]
    lone = any(side.kind == "symbol" and side.value in (*UNKNOWNS, "Mc") for side in equation.sides)
    balance = equation.names & {*UNKNOWNS, "Mc"} and not equation.names & {"ac1", "ac2", "ac3", "wd1", "wd3"}
    return [equation] if len(rows) == 1 and (lone or balance) else []


def _solution(state: Array, printed: list[Equation], system: System) -> Array:
    """theta'', phi'', R1, R2, R3, M3 at (theta, phi, theta', phi') by the laws, printed equations in place of some.

    The state is taken seven times, with all unknowns 0 and with each of them 1, which gives the matrix of the unknowns.
    Raises LinAlgError where there is no solution.
    """
    unknowns = dict(zip(UNKNOWNS, np.eye(6, 7, 1), strict=True))
    q = Quantities(_base(np.tile(state, (7, 1)), system) | unknowns, system, np)
    wrong = [rows[0] for equation in printed for rows, _ in residuals(equation, q, instead={})]
    rows = _laws(q, printed)
    for row in wrong:
        rows[_nearest(row, rows)] = row
    table = np.array(rows)
    matrix = table[:, 1:] - table[:, :1]
    largest = np.abs(matrix).max(1)
    return np.linalg.solve(matrix / largest[:, None], -table[:, 0] / largest)


def _laws(q: Quantities, printed: list[Equation]) -> list[Values]:
    """The true equations: solved for the accelerations, or the six balances where reactions are printed."""
    if any(equation.names & REACTIONS for equation in printed):
        return [dot(vector, q[axis]) for vector in balances(q)[:2] for axis in ("b1", "b2", "b3")]
    truth = solved(q)
    return [q[name] - truth[name] for name in UNKNOWNS]


def _nearest(row: Values, rows: list[Values]) -> int:
    """The law that a printed equation stands for: the one whose coefficients are most alike."""
    slopes = [r[1:] - r[0] for r in (row, *rows)]
    units = [s / (np.linalg.norm(s) or 1.0) for s in slopes]
    return int(np.argmax([abs(units[0] @ unit) for unit in units[1:]]))


def _compared(solvable: dict[int, list[Equation]], system: System) -> Harm:
    """The motion of equations, by their numbers, beside the true one."""
    *others, last = map(str, solvable)
    listed = f"s {', '.join(others)} and {last}" if others else f" {last}"
    who = f"Equation{listed}, solved as printed (1 kg, 1 m, from theta 0.7, phi 0.4, rates 1.3, -0.8)"
    printed = [equation for equations in solvable.values() for equation in equations]

    def wrong(state: Array) -> Array:
        return _solution(state, printed, system)

    def truth(state: Array) -> Array:
        true = solved(_at(state[None], system))
        return np.array([true[name][0] for name in UNKNOWNS])

    here, there = wrong(np.array(START)), truth(np.array(START))
    if np.allclose(here[:2], there[:2], rtol=1e-9, atol=1e-12):
        worst = int(np.argmax(np.abs(here - there)))
        values = f"{UNKNOWNS[worst]} is {here[worst]:.4g} in place of {there[worst]:.4g} at the start"
        words = (f"{who}: the motion is not changed, but {values}.",)
        return Harm(words, np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)))
    motions = [_motion(lambda t, x, f=f: np.concatenate([x[2:], f(x)[:2]])) for f in (truth, wrong)]
    count = min(map(len, motions))
    t = np.linspace(0, DURATION, SAMPLES)[:count]
    right, false = (_at(states[:count], system) for states in motions)
    apart = np.linalg.norm(right["rT"] - false["rT"], axis=0) / ROD["l"]
    first = f"after {t[np.argmax(apart > APART)]:.2f} s the tip is 1 % of the length off"
    when = first if apart.max() > APART else "the tip stays within 1 %"
    words = f"{who}: {when}, at most {100 * apart.max():.0f} % within {t[-1]:.3g} s."
    change = np.ptp(false["E"]) / (ROD["m"] * ROD["g"] * ROD["h"])
    energy = f"The energy of that motion changes by {100 * change:.1f} % of m g h."
    return Harm((words, energy), t, right["rT"].T, false["rT"].T)


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


def _base(states: Array, system: System) -> dict[str, Values]:
    """Coordinates and parameters at states (n, 4)."""
    base: dict[str, Values] = {name: states[:, i] for i, name in enumerate(system.spec.state)}
    return base | {name: np.full(len(states), ROD[name]) for name in system.spec.parameters}


def _at(states: Array, system: System) -> Quantities:
    """The quantities at states (n, 4): theta, phi in rad and their rates in rad/s."""
    return Quantities(_base(states, system), system, np)

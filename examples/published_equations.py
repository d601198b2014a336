"""A test of a printed version of the rod's equations: which of them fail, by how much, and which change corrects them.

The six balances of a uniform thin rod on a universal joint circulate in print with two faults. The moments are taken about
the centre of mass G, but with m l²/3, the transverse inertia about the joint. One sign in the acceleration along b3 is
wrong. The equations below are as printed, with a switch for each fault. They are one more route for pendpin's cross-check.
docs/derivation.md, section 7, has the mathematics.
"""

from functools import partial

import numpy as np
from rich.console import Console
from rich.table import Table

import pendpin as pp
from pendpin.equations import newton_euler

SCENE = pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]), effects=[pp.effects.Gravity()])
QUANTITIES = ("theta_dd", "phi_dd", "R1", "R2", "R3", "Mc")
MENDS = {
    "m l²/12": "the inertia about G, m l²/12 for m l²/3,",
    "sign": "the sign in the acceleration along b3",
    "both": "the inertia and the sign together",
}


def printed_balances(rod, q, v, field, unknowns, inertia, sign):
    """What each of the six printed balances leaves over, (6, n) in N and N m: 0 where it holds.

    `inertia` is 1/3 and `sign` is -1 in print. Body frame B; theta'', phi'', R1, R2, R3, M are the unknowns.
    """
    theta_dd, phi_dd, R1, R2, R3, M = unknowns
    (theta, phi), (dt, dp) = q.T, v.T
    length, s, c = 2 * rod.h, np.sin(phi), np.cos(phi)
    along = np.sin(theta) * field[1] + np.cos(theta) * field[2]
    G1, G2, G3 = c * field[0] - s * along, np.cos(theta) * field[1] - np.sin(theta) * field[2], s * field[0] + c * along

    acceleration1 = length / 2 * (phi_dd + dt**2 * s * c)
    acceleration2 = length / 2 * (theta_dd * c - 2 * dt * dp * s)
    acceleration3 = -length / 2 * (dp**2 + sign * dt**2 * c**2)
    transverse = inertia * rod.m * length**2
    return [
        rod.m * acceleration1 - (R1 + rod.m * G1),
        rod.m * acceleration2 - (R2 + rod.m * G2),
        rod.m * acceleration3 - (-R3 + rod.m * G3),
        transverse * (-theta_dd * c + 2 * dt * dp * s) - (length / 2 * R2 - M * s),
        transverse * (phi_dd + dt**2 * s * c) - (-length / 2 * R1),
        M * c,
    ]


def route(rod, q, v, field, inertia, sign):
    """The six solved for their unknowns, in which they are linear: at rest and without a field they give the matrix."""

    def evaluate(v, field, unknowns):
        left_over = printed_balances(rod, q, v, field, unknowns, inertia, sign)
        return np.stack(np.broadcast_arrays(*left_over), -1)  # (n, 6)

    matrix = np.stack([evaluate(0 * v, 0 * field, unit) for unit in np.eye(6)], -1)  # (n, 6, 6)
    rest = evaluate(v, field, np.zeros(6))
    solution = np.linalg.solve(matrix, -rest[..., None])[..., 0].T
    return dict(zip(QUANTITIES, solution, strict=True))


VERSIONS = {
    "as printed": partial(route, inertia=1 / 3, sign=-1),
    "m l²/12": partial(route, inertia=1 / 12, sign=-1),
    "sign": partial(route, inertia=1 / 3, sign=1),
    "both": partial(route, inertia=1 / 12, sign=1),
}


def one_state(console):
    """The numbers at the state that every pendpin command starts from, theta 0.7, phi 0.4, rates 1.3, -0.8."""
    rod, field = SCENE.model.rods[0].properties, np.array([0, 0, 9.81])  # kg, m; m/s², z down
    state = np.array([[0.7, 0.4]]), np.array([[1.3, -0.8]])  # rad, rad/s
    right = newton_euler.solve(rod, *state, field)._asdict()
    wrong = VERSIONS["as printed"](rod, *state, field)
    table = Table("", "as printed", "right", "printed / right", title="At theta 0.7, phi 0.4, rates 1.3, -0.8 rad/s")
    for name in QUANTITIES:
        a, b = wrong[name][0], right[name][0]
        table.add_row(name, f"{a:.6f}", f"{b:.6f}", f"{a / b:.4f}" if b else "")
    console.print(table)


def many_states(console):
    """Each version against Pinocchio on 1000 random states. Returns the rows of the report, by quantity and version."""
    report = pp.crosscheck(SCENE, states=1000, seed=0, routes=VERSIONS)
    rows = {(row.quantity, row.second): row for row in report.rows if row.first == "pinocchio"}
    table = Table(
        "",
        "as printed",
        "with m l²/12",
        "with the sign",
        "with both",
        title="Worst difference from Pinocchio on 1000 states, relative to the terms that enter",
    )
    for name in QUANTITIES:
        table.add_row(name, *(_cell(rows[name, version]) for version in VERSIONS))
    console.print(table)
    return rows


def _cell(row):
    return f"[{'green' if row.ok else 'red'}]{row.relative:.1e}{'' if row.ok else ' fails'}[/]"


def verdict(rows):
    """One line for each equation that fails: the mends that it takes."""
    for name in QUANTITIES:
        if not rows[name, "as printed"].ok:
            mends = [MENDS[version] for version in MENDS if rows[name, version].ok]
            yield f"{name} fails as printed; {mends[0] if mends else 'neither'} mends it."


def main():
    """Print the two tables and the verdict."""
    console = Console()
    one_state(console)
    for line in verdict(many_states(console)):
        console.print(line, highlight=False)


if __name__ == "__main__":
    main()

"""Symmetries of the hand-derived routes for one rod: exact wherever signs and powers of two are all that changes."""

import numpy as np
import pytest

from pendpin.equations import balances
from pendpin.equations.base import RodInertia, RodSolution
from rod_states import (
    assert_equal,
    lagrange_solution,
    random_states,
    terms,
)
from test_equations import ROUTES

# --- symmetries: exact in floating point wherever signs and powers of two are all that changes ------------------------


def pivoting(solve):
    """Roundings to allow where a factor of two may change which row the linear solver takes first."""
    return 30 if solve is balances.solve else 0


@pytest.mark.parametrize("solve", [*ROUTES.values(), lagrange_solution], ids=[*ROUTES, "lagrange"])
class TestSymmetries:
    """What a change of the state does to the answers: signs or factors in the order of RodSolution."""

    rod = RodInertia(2.0, 0.7, 0.3, 0.2, 0.05)
    field = np.array([1.5, -0.7, 9.81])

    def check(self, solve, rod, q, v, field, factors, roundings=0):
        states = random_states(300)
        before = solve(self.rod, *states, self.field)
        after = solve(rod, states[0] * q, states[1] * v, self.field * field)
        expected = [None if x is None else x * factor for x, factor in zip(before, factors, strict=True)]
        sizes = RodSolution(*np.abs(np.array(factors))[:, None] * np.array(terms(self.rod, *states, self.field)))
        assert_equal(after, expected, sizes, roundings)

    def test_mirror_across_the_plane_of_x_and_z(self, solve):
        """A force keeps its components in the mirror's plane, a moment keeps the one across it: Mc turns round."""
        self.check(solve, self.rod, (-1, 1), (-1, 1), (1, -1, 1), (-1, 1, 1, -1, 1, -1, -1), roundings=8)

    def test_mirror_across_the_plane_of_y_and_z(self, solve):
        self.check(solve, self.rod, (1, -1), (1, -1), (-1, 1, 1), (1, -1, -1, 1, 1, -1, -1), roundings=8)

    def test_time_backwards_changes_nothing(self, solve):
        """Rates enter as products of two, in Mc as well."""
        self.check(solve, self.rod, 1, -1, 1, (1, 1, 1, 1, 1, 1, 1))

    def test_twice_the_speed_under_four_times_the_field(self, solve):
        self.check(solve, self.rod, 1, 2, 4, (4, 4, 4, 4, 4, 4, 4))

    def test_twice_the_mass(self, solve):
        m, h, *inertia = self.rod
        heavy = RodInertia(2 * m, h, *(2 * x for x in inertia))
        self.check(solve, heavy, 1, 1, 1, (1, 1, 2, 2, 2, 2, 2), pivoting(solve))

    def test_twice_the_length_under_twice_the_field(self, solve):
        m, h, *inertia = self.rod
        long = RodInertia(m, 2 * h, *(4 * x for x in inertia))
        self.check(solve, long, 1, 1, 2, (1, 1, 2, 2, 2, 4, 4), pivoting(solve))

    def test_the_other_pair_of_angles_of_a_direction(self, solve):
        """(theta + pi, pi - phi) is the pose turned half round about b3: b1, b2, a2 and a3 change sign, b3 does not.

        Angles half way between the axes, where the rounding of pi is not magnified.
        """
        random = np.random.default_rng(0)
        q = random.uniform(0.3, 1.2, (300, 2)) * random.choice([-1, 1], (300, 2))
        v = random.uniform(-100, 100, (300, 2))
        after = solve(self.rod, np.stack([q[:, 0] + np.pi, np.pi - q[:, 1]], -1), v * (1, -1), self.field)
        before = solve(self.rod, q, v, self.field)
        expected = [None if x is None else x * f for x, f in zip(before, (1, -1, -1, -1, 1, 1, -1), strict=True)]
        assert_equal(after, expected, terms(self.rod, q, v, self.field), roundings=20)

"""Functions of (q, v) compared with a scene: each fault in one line, joint by joint."""

import numpy as np
import pytest

import pendpin as pp
from pendpin.errors import InputError

CHAIN = pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.05)] * 2), effects=[pp.effects.Gravity()])


def test_black_boxes_are_compared_joint_by_joint():
    truth = pp.bind(CHAIN)

    def wrong(q, v):
        rest = truth.acceleration(0.0, q, 0 * v)
        return rest + np.array([1, 1, 1, 0.5]) * (truth.acceleration(0.0, q, v) - rest)

    right = pp.diagnose(
        CHAIN,
        accelerations=lambda q, v: truth.acceleration(0.0, q, v),
        reactions=lambda q, v: truth.wrenches(0.0, q, v),
    )
    assert right.ok
    found = pp.diagnose(CHAIN, accelerations=wrong)
    assert [row.ok for row in found.rows] == [True, True, True, False]
    assert "0.5 times" in found.rows[3].words


def test_joints_in_the_wrong_order_are_named():
    truth = pp.bind(CHAIN)
    found = pp.diagnose(CHAIN, accelerations=lambda q, v: truth.acceleration(0.0, q, v)[::-1])
    assert "it is that of phi_2" in found.rows[0].words


@pytest.mark.parametrize(
    ("function", "reason"),
    [
        (lambda q, v: q[:2], r"shape \(2,\)"),
        (lambda q, v: None, "None"),
        (lambda q, v: 1 / 0, "raises ZeroDivisionError"),
        (lambda q: q, "raises TypeError"),
        (lambda q, v: q + 1j, "not an array of numbers"),
        (3, "not a function"),
    ],
)
def test_black_boxes_that_do_not_answer_are_refused_in_one_line(function, reason):
    with pytest.raises(InputError, match=reason) as caught:
        pp.diagnose(CHAIN, accelerations=function)
    assert "\n" not in str(caught.value)


def test_a_black_box_that_gives_nan_fails():
    truth = pp.bind(CHAIN)
    found = pp.diagnose(CHAIN, reactions=lambda q, v: truth.wrenches(0.0, q, v) * np.nan)
    assert not any(row.ok for row in found.rows)

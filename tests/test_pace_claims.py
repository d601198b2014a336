"""Accuracies that are claimed where forces come in pulses, against their exact impulse."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin.effects import Gravity, Torque
from test_pace import INERTIA, ROD


@pytest.mark.slow
@law(6)
@given(
    method=st.sampled_from(["rk4", "gauss4", "dop853", "rk45", "lsoda"]),
    at=st.floats(0.1, 1.8),
    width=st.floats(4e-3, 0.1),
    square=st.booleans(),
)
@example(method="rk4", at=1.2345, width=5e-3, square=True)
@example(method="lsoda", at=1.21875, width=0.0625, square=False)  # a run for comparison does not converge
def test_claims_with_pulses_are_true(method, at, width, square) -> None:
    """An accuracy that is met with a pulse of a user's function is met in truth: against its exact impulse."""

    def torque(t, q, v):
        return np.array([0.02 / width * (at <= t < at + width if square else np.exp(-(((t - at) / width * 8) ** 2)))])

    scene = pp.Scene(duration=2.0, model=ROD, effects=[Torque(torque, joints=["theta"])])
    run = pp.simulate(scene, method=method, accuracy=1e-3)
    if square:
        turned = 0.02 / INERTIA * (2 - at - width / 2)
    else:
        s = width / 8  # the integral over time of the rate, which is an error function
        primitive = [(x * math.erf(x) + math.exp(-x * x) / math.sqrt(math.pi)) * s for x in ((2 - at) / s, at / s)]
        turned = 0.02 / 8 / INERTIA * math.sqrt(math.pi) / 2 * (primitive[0] - primitive[1] + 2 * math.erf(at / s))
    assert 2 * abs(math.sin((run.q[-1, 0] - turned) / 2)) <= run.stats.error


SYMMETRIC = {  # pulses of the time in widths from their middle, with a mean of 1 over a width
    "triangle": lambda s: 2 * max(0.0, 1 - 2 * abs(s)),
    "half sine": lambda s: math.pi / 2 * math.cos(math.pi * s) if abs(s) < 0.5 else 0.0,
    "bell": lambda s: 8 / math.sqrt(math.pi) * math.exp(-64 * s * s),
    "two triangles": lambda s: 2 * max(0.0, 1 - 4 * abs(s - 0.25)) + 2 * max(0.0, 1 - 4 * abs(s + 0.25)),
}


def test_claims_with_two_pulses_that_have_corners_are_true() -> None:
    """A quick form of the law below: two cases that were wrong."""
    check_claim("two triangles", "rk45", 0.6503, 0.0727, 6)
    check_claim("triangle", "dop853", 1.798, 0.0122, 7)


@pytest.mark.slow
@law(6)
@given(
    shape=st.sampled_from(list(SYMMETRIC)),
    method=st.sampled_from(["dop853", "rk45", "lsoda"]),
    at=st.floats(0.2, 1.8),
    width=st.floats(-2.4, -0.8).map(lambda x: 10**x),
    digits=st.floats(3, 8.5),
)
def test_claims_with_pulses_that_have_corners_are_true(shape, method, at, width, digits) -> None:
    """Whatever the pulse, the method and the accuracy."""
    check_claim(shape, method, at, width, digits)


def check_claim(shape, method, at, width, digits) -> None:
    """A free rod turns at the rate of the impulse from the middle of a symmetric pulse on, whatever its shape.

    Steps err at a corner between two samples, and three tolerances may agree by chance: shorter steps show it.
    """
    pulse = SYMMETRIC[shape]
    torque = Torque(lambda t, q, v: np.array([0.02 / width * pulse((t - at) / width)]), joints=["theta"])
    try:
        run = pp.simulate(pp.Scene(duration=2.0, model=ROD, effects=[torque]), method=method, accuracy=10**-digits)
    except pp.RunError:
        return  # nothing is claimed
    turned = 0.02 / INERTIA * (2 - at)
    assert 2 * abs(math.sin((run.q[-1, 0] - turned) / 2)) <= run.stats.error + 1e-14


def narrow(t, q, v):
    """50 N m within a milliradian of 0.2 rad."""
    return np.where(np.abs(q - 0.2) < 1e-3, 50.0, 0.0)


@pytest.mark.parametrize("method", ["dop853", pytest.param("radau", marks=pytest.mark.slow)])
def test_no_accuracy_is_claimed_of_steps_that_jump_over_a_narrow_force(method) -> None:
    """Let go at 1 rad: all runs to tolerances alone agree, and are wrong by percents; one with short steps shows it.

    A note names the effect, which declares nothing.
    """
    start = pp.Start(positions={"theta": 1.0})
    scene = pp.Scene(duration=1.0, model=ROD, start=start, effects=(Gravity(), Torque(narrow, joints=["theta"])))
    with pytest.raises(pp.RunError, match=r"accuracy 0\.0001 is not met") as caught:
        pp.simulate(scene, method=method, accuracy=1e-4)
    notes = [note for note in caught.value.partial.stats.notes if note.startswith("effects[1] (torque)")]
    assert any("does not declare that it is smooth" in note for note in notes)

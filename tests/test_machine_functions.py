"""Functions in machine code of pendpin's own: sines and cosines of many angles at once."""

import ctypes

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from laws import law

pytest.importorskip("llvmlite", reason="llvmlite is not installed: pip install llvmlite")
mpmath = pytest.importorskip("mpmath")

from pendpin.engines.machine.llvm import Library  # noqa: E402
from pendpin.engines.machine.routines import (  # noqa: E402
    DECLARED,
    FAR,
    TRIGONOMETRY,
    WIDE,
    trigonometry_code,
)

FUNCTION = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p)


@pytest.fixture(scope="module")
def trigonometry():
    """Sines and cosines (n,) of angles (n,)."""
    library = Library(DECLARED + trigonometry_code(), 2)
    function = FUNCTION(library.address(TRIGONOMETRY))

    def call(angles):
        x, out = np.append(angles, np.zeros(WIDE)), np.empty((2, len(angles) + WIDE))
        function(x.ctypes.data, len(angles), *(row.ctypes.data for row in out))
        return out[:, : len(angles)]

    call.library = library  # type: ignore[attr-defined]  # it lives as long as the function
    return call


def units(value: float, exact) -> float:
    """How many units in the last place a value is off."""
    return float(abs(mpmath.mpf(value) - exact) / mpmath.mpf(float(np.spacing(abs(float(exact))))))


def check(trigonometry, angles: np.ndarray) -> None:
    with mpmath.workdps(60):
        for x, sine, cosine in zip(angles.tolist(), *trigonometry(angles).tolist(), strict=True):
            assert units(sine, mpmath.sin(mpmath.mpf(x))) < 1
            assert units(cosine, mpmath.cos(mpmath.mpf(x))) < 1


@law(200)
@given(st.lists(st.floats(-1e300, 1e300), min_size=1, max_size=9))
def test_any_angles(trigonometry, angles: list[float]) -> None:
    """Within one unit in the last place, also far out and among others that are far out."""
    check(trigonometry, np.array(angles))


def test_near_every_quarter_turn(trigonometry) -> None:
    """Where a sine or cosine is next to 0 its last digits are right: the quarter turn is taken away in three parts."""
    quarters = np.arange(-63_661, 63_661, 487) * (np.pi / 2)
    check(trigonometry, np.concatenate([quarters, np.nextafter(quarters, np.inf), quarters + np.pi / 4]))


def test_symmetries_and_what_is_no_number(trigonometry) -> None:
    angles = np.random.default_rng(0).uniform(-1.2 * FAR, 1.2 * FAR, 1001)
    (sines, cosines), (mirrored, same) = trigonometry(angles), trigonometry(-angles)
    assert np.array_equal(sines, -mirrored)
    assert np.array_equal(cosines, same)
    assert trigonometry(np.zeros(3)).tolist() == [[0.0] * 3, [1.0] * 3]
    found = trigonometry(np.array([np.nan, np.inf, 1.0]))
    assert np.isnan(found[:, :2]).all()
    assert units(found[0, 2], mpmath.sin(1)) < 1

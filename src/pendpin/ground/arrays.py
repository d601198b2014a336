"""The types of arrays, and vectors and 3 x 3 matrices over any number type, with zeros that stay zeros.

The functions take floats and object arrays of other numbers; leading dimensions (...) broadcast, so the same lines take
one state or many.
"""

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[Any]  # floats, or mpmath's or heyoka's objects
    Mask = NDArray[np.bool_]
    Indices = NDArray[np.intp]
else:  # help() shows these names, and not what numpy makes of them
    Array = Mask = Indices = np.ndarray
    ArrayLike = Any  # numbers, or lists of them

EPS = float(np.finfo(float).eps)  # 2.2e-16: the distance of 1 from the next double, twice the error of one rounding
TINY = float(np.finfo(float).tiny)  # 2.2e-308: smaller doubles have fewer digits
_NEXT = np.array([1, 2, 0])
_UPPER = np.triu(np.ones((3, 3), dtype=bool))


@cache
def lapack(name: str) -> Callable[..., Any]:
    """A function of LAPACK or BLAS for floats; loaded when it is first asked for, as scipy.linalg takes 0.2 s."""
    from scipy.linalg import get_blas_funcs, get_lapack_funcs

    library: Any = get_blas_funcs if name == "tbsv" else get_lapack_funcs
    return library(name, dtype=np.float64)


def subdivided(times: Array, parts: ArrayLike) -> Array:
    """Times (n,) with each interval cut into equal parts, `parts` (n - 1,) or one count for all; given times to the bit."""
    parts = np.broadcast_to(parts, len(times) - 1)
    if (parts == 1).all():
        return times
    before = np.cumsum(parts) - parts
    shares = (np.arange(parts.sum()) - np.repeat(before, parts)) / np.repeat(parts, parts)
    return np.append(np.repeat(times[:-1], parts) + np.repeat(np.diff(times), parts) * shares, times[-1])


def applied(M: Array, x: Array) -> Array:
    """M x, (..., 3)."""
    return (M @ x[..., None])[..., 0]


def cross(x: Array, y: Array, axis: int = -1) -> Array:
    """x x y, (..., 3) or 3 along another axis, without the overhead of numpy.cross."""
    return (x * y.take(_NEXT, axis) - x.take(_NEXT, axis) * y).take(_NEXT, axis)


def dot(x: Array, y: Array) -> Array:
    """x . y, (..., 1)."""
    return (x * y).sum(-1, keepdims=True)


def across(z: Array) -> Array:
    """A unit vector (..., 3) normal to z (..., 3)."""
    x = cross(z, np.eye(3)[np.argmin(np.abs(z), -1)])
    return x / np.linalg.norm(x, axis=-1, keepdims=True)


def unit(direction: ArrayLike) -> Array:
    """The unit vector (3,) along a direction of any length but 0; no square overflows, and complex steps pass through it."""
    x = np.asarray(direction) / np.abs(direction).max()
    return x / np.sqrt(x @ x)


def outer(x: Array, y: Array) -> Array:
    """x y^T, (..., 3, 3)."""
    return x[..., :, None] * y[..., None, :]


def symmetric(M: Array) -> Array:
    """A matrix (..., 3, 3) that is symmetric but for rounding, made so; symbols are then the same on both sides."""
    return np.where(_UPPER, M, M.mT)


def skew(x: Array) -> Array:
    """The matrix (..., 3, 3) of the cross product: skew(x) y = x x y."""
    x1, x2, x3 = np.moveaxis(x, -1, 0)
    zero = np.zeros_like(x1)
    return _matrix([[zero, -x3, x2], [x3, zero, -x1], [-x2, x1, zero]])


def centripetal(omega: Array) -> Array:
    """The matrix (..., 3, 3) of omega x (omega x ...)."""
    x, y, z = np.moveaxis(omega, -1, 0)
    xx, yy, zz, yz, xz, xy = x * x, y * y, z * z, y * z, x * z, x * y
    return _matrix([[-(yy + zz), xy, xz], [xy, -(xx + zz), yz], [xz, yz, -(xx + yy)]])


def gyroscopic(J: Array, omega: Array) -> Array:
    """omega x (J omega) for a constant symmetric J (3, 3), collected by the products of rates: (..., 3)."""
    x, y, z = np.moveaxis(omega, -1, 0)
    (a, f, e), (_, b, d), (_, _, c) = J
    columns_xx_yy_zz = [[0.0, d, -d], [-e, 0.0, e], [f, -f, 0.0]]
    columns_yz_xz_xy = [[c - b, -f, e], [f, a - c, -d], [-e, d, b - a]]
    by_product = np.concatenate([np.array(columns_xx_yy_zz), np.array(columns_yz_xz_xy)], -1)
    return applied(by_product, np.stack([x * x, y * y, z * z, y * z, x * z, x * y], -1))


def _matrix(rows: list[list[Any]]) -> Array:
    """The matrix (..., r, c) with these rows of entries (...)."""
    return np.stack([np.stack(row, -1) for row in rows], -2)

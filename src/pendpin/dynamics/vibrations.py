"""Small motions M x'' + C x' + K x = 0 about a rest: the matrices, then frequencies, damping, shapes, stability.

The residual r(q, v, a) is the torque about each joint that the motion needs, by the recursion of Newton-Euler, less what
the effects give; a motion has r = 0. Its exact derivatives by a, v and q are the matrices M, C and K.

Without damping, and with a symmetric K, the modes are those of K u = omega² M u: solved with the roles of K and M exchanged
where K is positive definite, so that the low frequencies keep their digits beside high ones. Else they are those of the
first-order system of 2 n eigenvalues, in the coordinates in which M is the unit matrix. Coordinates that nothing couples are
solved apart: those of a hanging chain in its two planes.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from pendpin.dynamics.binding import Binding
from pendpin.dynamics.compiling import BoundTree, record_twice, records_by_rod
from pendpin.dynamics.derivatives import differentiable
from pendpin.dynamics.parameters import Parameters
from pendpin.effects import Effect
from pendpin.engines.machine.tangents import STATE, add_tangents
from pendpin.engines.machine.tape import Recording, Tape
from pendpin.equations import recursion
from pendpin.errors import InputError
from pendpin.ground.arrays import EPS, Array
from pendpin.model.build import Model, build
from pendpin.scene import Scene

NEVER = np.inf  # the damping ratio of what a damper holds and no spring brings back
MOST_DAMPED = 500  # coupled degrees of freedom: the time grows with their cube, to 6 s of one processor there
IN_STEP = 1e-10  # of the largest entry of a shape: imaginary parts below it are rounding
PARTS = 3  # of what is given: positions, rates, accelerations
TOGETHER = 128  # directions that are computed at once: what they need stays small

Residual = Callable[[Any, Array, Array, Array], Array]  # t, q, v, a (nv,) -> (nv,) N m


class Matrices(NamedTuple):
    """Derivatives (nv, nv) of the residual torques at a state."""

    mass: Array  # by accelerations, kg m²
    damping: Array  # by rates, N m s/rad
    stiffness: Array  # by positions, N m/rad


def matrices(scene: Scene, q: Array, v: Array, a: Array) -> Matrices:
    """M, C and K at q, v, a (nv,), with the effects as they are at the scene's start; friction and stops are left out.

    Raises InputError for effects without derivatives, MissingLibrary without llvmlite.
    """
    model, effects, start = build(scene.model), differentiable(scene), scene.start.time
    by_rod, nv = records_by_rod(model, effects), len(q)

    def recording(tape: Tape, numbers: Parameters, residual: Any) -> Recording:
        """The residual with its derivative along a change of q, v and a; by rod, of one rod."""
        if by_rod:
            one = Recording(tape, [], parts=PARTS, width=numbers.width, of_rod=list(residual))
        else:
            one = Recording(tape, list(residual), width=PARTS * nv)
        return add_tangents(one, [STATE])

    block, _ = record_twice("residual", model, by_rod, partial(_residual, model, effects, start), recording, PARTS)
    point, derivatives = np.concatenate([q, v, a]), np.empty((PARTS * nv, nv))
    for begin in range(0, PARTS * nv, TOGETHER):
        ways = np.eye(min(TOGETHER, PARTS * nv - begin), PARTS * nv, begin)
        states = np.concatenate([np.broadcast_to(point, ways.shape), ways], 1)
        derivatives[begin : begin + len(ways)] = block.evaluated(np.zeros(len(ways)), states)[0][:, nv : 2 * nv]
    of_q, of_v, of_a = derivatives.reshape(PARTS, nv, nv).transpose(0, 2, 1)
    return Matrices(of_a, of_v, of_q)


def _residual(model: Model, effects: Sequence[Effect], start: float, numbers: Parameters) -> Residual:
    """The torques (nv,) that a motion needs beyond those of the effects, as a function of t, q, v, a (nv,)."""
    numbers.constant(() if numbers.by_rod else (model.joints, tuple(body.link for body in model.bodies)))
    bound = BoundTree(Binding(model, effects, start, numbers))
    tree, loads = bound.tree, bound.loads

    def residual(t: Any, q: Array, v: Array, a: Array) -> Array:
        wrenches = recursion.wrenches(tree, q, v, a, loads.field(t), bound.external(t, q, v), numbers.xp)
        needed = recursion.along_axes(tree, wrenches)
        return needed if loads.torque is None else needed - loads.torque(t, q, v)

    return residual


class Vibrations(NamedTuple):
    """Modes by rising frequency, one for each of n degrees of freedom."""

    omega: Array  # (n,) rad/s
    damping_ratio: Array  # (n,), below 0 where the mode grows
    shapes: Array  # (n, n), a row for each mode, its largest entry 1; complex where not all move in step
    eigenvalues: Array  # (2 n,) 1/s
    stable: bool  # whether no eigenvalue is to the right of the imaginary axis by more than its rounding error


def vibrations(matrices: Matrices) -> Vibrations:
    """The modes of M, C, K (n, n). Raises InputError for a mass matrix that is not positive definite."""
    from scipy.sparse.csgraph import connected_components

    n, parts, solved = len(matrices.mass), [], dict[bytes, Vibrations]()
    coupled = np.zeros((n, n), bool)
    for part in matrices:  # whose entries that are rounding couple nothing
        size = np.sqrt(np.abs(np.diag(part)))
        coupled |= np.abs(part) > EPS * np.outer(size, size)
    count, group = connected_components(coupled, directed=False)
    for chosen in (np.flatnonzero(group == i) for i in range(count)):
        block = Matrices(*(part[np.ix_(chosen, chosen)] for part in matrices))
        key = b"".join(part.tobytes() for part in block)  # the two planes of a chain are the same to the bit
        if key not in solved:
            _, C, K = block
            is_conservative = not C.any() and np.abs(K - K.T).max() <= len(K) * EPS * np.abs(K).max()
            solved[key] = _undamped(block) if is_conservative else _damped(block)
        parts.append((chosen, solved[key]))
    omega = np.concatenate([part.omega for _, part in parts])
    kind = complex if any(np.iscomplexobj(part.shapes) for _, part in parts) else float
    shapes, row = np.zeros((n, n), kind), 0
    for chosen, part in parts:
        shapes[row : row + len(chosen), chosen] = part.shapes
        row += len(chosen)
    order, ratios = np.argsort(omega, kind="stable"), np.concatenate([part.damping_ratio for _, part in parts])
    eigenvalues, stable = np.concatenate([part.eigenvalues for _, part in parts]), all(part.stable for _, part in parts)
    return Vibrations(omega[order], ratios[order], shapes[order], eigenvalues, stable)


def spectrum(A: Array, off: float | None = None) -> tuple[Array, Array, Array]:
    """The eigenvalues (k,) of A (k, k), their errors, and the right eigenvectors as columns.

    `off` is what A may be off by, k eps |A| (its rounding) if absent. The error of an eigenvalue is this over the cosine of
    the angle between its left and right eigenvectors, and at most about the square root, as where two eigenvalues with
    one eigenvector meet (G. H. Golub, C. F. Van Loan, Matrix Computations, 2013, section 7.2). Of eigenvalues that are
    equal all combinations of vectors are eigenvectors: the left ones are taken as the inverse of the matrix of the right
    ones. Raises InputError for what is not finite.
    """
    from scipy.linalg import eig, matrix_balance

    if not np.isfinite(A).all():
        raise InputError("the linear model has entries that are not finite: at phi = ±pi/2 a thin rod has no angles")
    balanced, (scale, _) = matrix_balance(A, permute=False, separate=True)
    eigen: Any = eig(balanced)
    values, right = eigen[0], scale[:, None] * eigen[1]
    with np.errstate(all="ignore"):
        try:
            condition = np.linalg.norm(np.linalg.inv(right), axis=1) * np.linalg.norm(right, axis=0)
        except np.linalg.LinAlgError:
            condition = np.full(len(A), np.inf)
    off = len(A) * EPS * float(np.linalg.norm(A, 2)) if off is None else off
    return values, np.fmin(off * condition, 2 * np.sqrt(off)), right


def is_stable(values: Array, errors: Array) -> bool:
    """Whether no eigenvalue (k,) is right of the imaginary axis by more than its rounding error."""
    return bool((np.real(values) <= errors).all())


def _factor(M: Array) -> Array:
    """The Cholesky factor of the mass matrix."""
    try:
        return np.linalg.cholesky((M + M.T) / 2)
    except np.linalg.LinAlgError:
        raise InputError("the mass matrix is not positive definite here: some joint moves no inertia") from None


def _undamped(matrices: Matrices) -> Vibrations:
    """Of K u = omega² M u; where omega² is below 0 the mode grows at that rate: its damping ratio is -1."""
    from scipy.linalg import eigh

    M, K = (matrices.mass + matrices.mass.T) / 2, (matrices.stiffness + matrices.stiffness.T) / 2
    _factor(M)
    try:
        inverse, vectors = eigh(M, K)
        squares = 1 / inverse
    except np.linalg.LinAlgError:  # K is not positive definite
        squares, vectors = eigh(K, M)
    squares = np.where(np.abs(squares) <= len(M) * EPS * np.abs(squares).max(), 0.0, squares)
    omega, grows = np.sqrt(np.abs(squares)), squares < 0
    roots, ratios = np.where(grows, omega, 1j * omega), np.where(grows, -1.0, 0.0)
    return Vibrations(omega, ratios, _normalised(vectors.T), np.concatenate([roots, -roots]), not grows.any())


def _damped(matrices: Matrices) -> Vibrations:
    """Of the first-order system: pairs of eigenvalues, complex ones or two real ones."""
    from scipy.linalg import solve_triangular

    M, C, K = matrices
    if len(M) > MOST_DAMPED:
        many = f"damped modes are found for up to {MOST_DAMPED} coupled joints, here are {len(M)}"
        raise InputError(f"model: {many}: take fewer rods, or leave damping out")
    L, n = _factor(M), len(M)
    C, K = (solve_triangular(L, solve_triangular(L, part, lower=True).T, lower=True).T for part in (C, K))
    values, errors, vectors = spectrum(np.block([[np.zeros((n, n)), np.eye(n)], [-K, -C]]))
    stable, real, imag = is_stable(values, errors), np.real(values), np.imag(values)
    real = np.where(np.abs(real) <= errors, 0.0, real)  # not 1e-17: what does not lose energy has no damping
    values = np.where(np.abs(values) <= errors, 0.0, real + 1j * imag)
    real, imag = np.real(values), np.imag(values)
    shapes = solve_triangular(L.T, vectors[:n]).T
    swinging, others = np.flatnonzero(imag > 0), np.flatnonzero(imag == 0)
    pairs = [(values[i], values[i].conj(), shapes[i]) for i in swinging]
    left, unit = list(others[np.argsort(-real[others])]), vectors[:n] / np.linalg.norm(vectors[:n], axis=0)
    while left:  # real ones two by two, those with the most alike shapes together; the larger one first
        i = left.pop(0)
        j = left.pop(int(np.argmax([abs(np.vdot(unit[:, i], unit[:, other])) for other in left])))
        pairs.append((values[i], values[j], shapes[i]))
    omega, ratios = np.array([_frequency_and_damping(one, other) for one, other, _ in pairs]).T
    return Vibrations(omega, ratios, _normalised(np.array([shape for *_, shape in pairs])), values, stable)


def _frequency_and_damping(one: complex, other: complex) -> tuple[float, float]:
    """Frequency and damping ratio of two eigenvalues: s² + 2 zeta omega s + omega² is 0 at both."""
    # Of two real ones on either side of 0 the growing one counts: its rate, with a damping ratio of -1.
    if one.imag:
        return abs(one), -one.real / abs(one) + 0.0
    if one.real > 0 > other.real or (one.real > 0 and other.real == 0):
        return one.real, -1.0
    omega, sum_of_both = float(np.sqrt((one * other).real)), (one + other).real
    if omega == 0:
        return 0.0, NEVER if sum_of_both < 0 else 0.0
    return omega, -sum_of_both / (2 * omega)


def _normalised(shapes: Array) -> Array:
    """Rows with their largest entries 1; real where they are to rounding."""
    largest = np.take_along_axis(shapes, np.abs(shapes).argmax(1)[:, None], 1)
    shapes = shapes / largest
    if np.iscomplexobj(shapes) and np.abs(np.imag(shapes)).max() <= IN_STEP:
        return np.real(shapes).copy()
    return shapes

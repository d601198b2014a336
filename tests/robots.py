"""The robots of example-robot-data, and what Pinocchio computes with each file that it loads itself, against pendpin.

`python tests/robots.py` compares all of them and prints a table, the worst last.
"""

import sys
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

import pendpin as pp
from pendpin.equations.base import exact
from pendpin.equations.recursion import accelerations, wrenches
from pendpin.ground.arrays import EPS
from pendpin.model.bodies import tree_of
from pendpin.model.urdf import read_urdf
from rounding import terms

FOLDER = Path(pin.__file__).parents[4] / "share" / "example-robot-data" / "robots"
GRAVITY = pp.effects.Gravity()


def robot_files() -> list[Path]:
    """The well-formed URDFs with a joint that moves."""
    return [path for path in sorted(FOLDER.rglob("*.urdf")) if _moves(path)]


def robot(name: str) -> Path:
    """The file of this name, `anymal_b/...` where there are two."""
    return next(path for path in robot_files() if path.as_posix().endswith(f"/{name}.urdf"))


def _moves(path: Path) -> bool:
    try:
        joints = ElementTree.parse(path).getroot().findall("joint")
    except ElementTree.ParseError:
        return False
    return any(joint.get("type") != "fixed" for joint in joints)


class Comparison(NamedTuple):
    """The largest differences over some states, in roundings (eps) of the terms that enter, for each joint."""

    joints: int
    aba: float  # Pinocchio's ABA on what it loads itself, against what pendpin computes with
    rnea: float  # its RNEA, all six components of every joint's wrench, against the recursion
    recursion: float  # ABA against the recursion
    digits: float  # ABA against the recursion in 50 digits


def compare(path: Path, states: int, seed: int = 0, digits: bool = False) -> Comparison:
    """Pinocchio on its own model of a file, and pendpin on its own, at random states."""
    dynamics = pp.bind(pp.Scene(model=pp.UrdfModel(path=path), effects=(GRAVITY,)))
    own, theirs = dynamics.model.pin.copy(), _as_loaded(path, dynamics.model.joints)
    own.gravity.linear = theirs.gravity.linear
    tree, random, worst, n = tree_of(own), np.random.default_rng(seed), np.zeros(4), own.nv
    place = [theirs.getJointId(name) for name in dynamics.model.joints]
    velocities = [theirs.joints[joint].idx_v for joint in place]
    data = theirs.createData()
    for _ in range(states):
        q, v = random.uniform(-np.pi, np.pi, n), random.uniform(-5, 5, n)
        q_theirs, v_theirs = _configuration(theirs, place, q), np.zeros(n)
        v_theirs[velocities] = v
        a_theirs = pin.aba(theirs, data, q_theirs, v_theirs, np.zeros(n))
        a, g = a_theirs[velocities], own.gravity.linear
        pin.rnea(theirs, data, q_theirs, v_theirs, a_theirs)
        wrench = np.array([data.f[joint].vector for joint in place])
        size = terms(own, q, v, a)
        of_wrench = np.repeat(np.stack([size.force, size.moment], -1), 3, -1)
        reference = accelerations(tree, q, v, g, xp=exact(50)).astype(float) if digits else a
        differences = (
            (dynamics.acceleration(0.0, q, v) - a, size.acceleration),
            (wrenches(tree, q, v, a, g) - wrench, of_wrench),
            (accelerations(tree, q, v, g) - a, size.acceleration),
            (reference - a, size.acceleration),
        )
        worst = np.maximum(worst, [np.abs(x / y).max() / (n * EPS) for x, y in differences])
    return Comparison(n, *worst)


def _as_loaded(path: Path, joints: tuple[str, ...]) -> pin.Model:
    """What Pinocchio makes of a file, with the joints that move massless links only held at 0, as pendpin says it does."""
    model = pin.buildModelFromUrdf(str(path))
    locked = [joint for joint in range(1, model.njoints) if model.names[joint] not in joints]
    if not locked:
        return model
    assert read_urdf(pp.UrdfModel(path=path)).findings[0].startswith("joints ")
    return pin.buildReducedModel(model, locked, pin.neutral(model))


def _configuration(model: pin.Model, place: list[int], q: np.ndarray) -> np.ndarray:
    """Positions (nq,) in Pinocchio's form, a cosine and a sine for continuous joints, from one number a joint."""
    out = np.zeros(model.nq)
    for joint, x in zip(place, q, strict=True):
        at = model.joints[joint].idx_q
        out[at : at + model.joints[joint].nq] = (np.cos(x), np.sin(x)) if model.joints[joint].nq == 2 else x
    return out


def main() -> int:
    """All robots, the worst last."""
    found = {path: compare(path, states=20, digits=True) for path in robot_files()}
    print(f"{'robot':48}{'joints':>7}" + "".join(f"{name:>11}" for name in Comparison._fields[1:]))
    for path, row in sorted(found.items(), key=lambda item: max(item[1][1:])):
        print(
            f"{path.relative_to(FOLDER)!s:.46}".ljust(48) + f"{row.joints:7}" + "".join(f"{x:11.2g}" for x in row[1:])
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())

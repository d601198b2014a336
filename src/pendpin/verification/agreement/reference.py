"""Reference numbers for the tests of other engines: a folder with the model in three formats, states and a motion.

The numbers at states come from the recursion in 50 digits; the motion comes from two families of methods, whose
difference bounds its error.
"""

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from pendpin.dynamics.dynamics import Dynamics, bind, loads_at
from pendpin.effects import Effect, FieldEffect, Viscous
from pendpin.equations import recursion
from pendpin.equations.base import exact
from pendpin.equations.trees import place_joints, prepared
from pendpin.errors import InputError, PendpinError
from pendpin.ground.arrays import EPS, Array, applied
from pendpin.ground.files import fill_template, write_folder
from pendpin.ground.libraries import VERSION
from pendpin.ground.report import Report
from pendpin.model.bodies import tree_of
from pendpin.model.build import Model
from pendpin.model.urdf import parse, read_urdf
from pendpin.model.write_models import chain_urdf, mjcf, sdf
from pendpin.motions.trajectory import simulate
from pendpin.scene import METHODS, Chain, Scene, UrdfModel, chosen_scene

STATES, TIMES = 20, 50  # chosen: enough to meet every term, few enough to read
DIGITS = 50  # three times those of a double: rounding to it is all that the numbers lose
ANGLE, SLIDE = 1.2, 0.3  # rad, m: random positions; rods stay away from the poles, where thin ones are singular
# Explicit and implicit Runge-Kutta: their errors have nothing in common.
FAMILIES = (("dop853", 1e-13), ("radau", 1e-12))
MARGIN = 2.0  # times the difference of the two families
WORTH = 1e-6  # rad: where the families differ by more, as after a while in chaos, the motion ends
FORMATS = {
    "model.urdf": "the model as URDF, a universal joint as two revolute ones",
    "model.xml": "the model as MJCF, a universal joint as two hinges of one body",
    "model.sdf": "the model as SDF 1.9, a universal joint as one joint",
}


def write_reference(scene: Scene | str | Path, out: str | Path, seed: int = 0) -> Report:
    """Write the folder `out` for a scene, whole or not at all; the report lists its files, and those that are left out.

    Raises InputError for a model that Pinocchio does not hold, for effects with events, and for a folder that is there.
    """
    scene, path = chosen_scene(scene), Path(out)
    dynamics = bind(scene)
    if dynamics.model.pin is None:
        raise InputError(f"model: {len(dynamics.model.rods)} rods are too many for other engines")
    if dynamics.contacts is not None:
        raise InputError("effects: reference numbers need effects without events: no dry friction and no stops")
    # the texts of the formats that can carry the scene, and for the others the reason
    model, texts, left_out = dynamics.model, dict[str, str](), dict[str, str]()
    writers = {
        "model.urdf": lambda damping: _urdf(scene, damping),
        "model.xml": lambda damping: mjcf(model, dynamics.loads.constant, damping),
        "model.sdf": lambda damping: sdf(model, damping),
    }
    for name, write in writers.items():
        try:
            texts[name] = write(_damping_by_joint(scene.effects, model))
        except PendpinError as error:
            left_out[name] = str(error)
    states, state_bounds = reference_states(dynamics, np.random.default_rng(seed))
    motion, motion_bounds = reference_motion(scene)
    conventions = {
        "units": "SI, rad",
        "gravity": dynamics.loads.constant.tolist(),
        "wrench": "force, then moment, by the parent on the child, at the joint's origin, in the child's frame",
        "effects": [effect.kind for effect in scene.effects],
        "versions": {"pendpin": VERSION},
    }
    numbers = {"joints": list(dynamics.model.joints), "states": states, "motion": motion}
    numbers |= {"bounds": {"states": state_bounds, "motion": motion_bounds}, "conventions": conventions}
    texts["reference.json"] = json.dumps(numbers, indent=1) + "\n"
    texts["test_reference.py"] = fill_template("pendpin.verification.agreement", "folder/test_reference.py.in")
    methods = " and ".join(f"{name} ({METHODS[name].family}, tolerance {tolerance:g})" for name, tolerance in FAMILIES)
    texts["README.md"] = fill_template(
        "pendpin.verification.agreement",
        "folder/README.md",
        version=VERSION,
        files="\n".join(f"| {name} | {what} |" for name, what in FORMATS.items() if name in texts),
        left_out="\n".join(f"- {name} is left out: {why}." for name, why in left_out.items()),
        state_bound=f"{len(states)} random states, computed in {DIGITS} digits and rounded to doubles.",
        motion_bound=f"twice the largest difference of {methods}.",
    )

    def fill(folder: Path) -> None:
        scene.save(folder / "scene.toml")
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")

    write_folder(path, fill)
    files = ["scene.toml", *sorted(texts)]
    words = [f"wrote {path / name}" for name in files]
    words += [f"{name} is left out: {why}" for name, why in left_out.items()]
    return Report(words, {"path": str(path), "files": files, "left_out": left_out})


def _damping_by_joint(effects: tuple[Effect, ...], model: Model) -> dict[str, float]:
    """The viscous damping of joints by name. Raises InputError for effects that a model file cannot carry."""
    damping: dict[str, float] = {}
    for i, effect in enumerate(effects):
        if isinstance(effect, Viscous):
            for joint in effect.joints or model.joints:
                damping[joint] = damping.get(joint, 0.0) + effect.coefficient
        elif not (isinstance(effect, FieldEffect) and effect.constant):
            where = f"effects[{i}]: {effect.kind}"
            raise InputError(f"{where} is not part of a model file; its numbers are in reference.json")
    return damping


def _urdf(scene: Scene, damping: dict[str, float]) -> str:
    if damping:
        raise InputError("engines ignore the damping of a URDF; MJCF and SDF carry it")
    if isinstance(scene.model, Chain):
        return chain_urdf(scene.model)
    if not isinstance(scene.model, UrdfModel):
        raise InputError("a pin.Model has no URDF text")
    robot = parse(read_urdf(scene.model).text.encode())
    for joint in robot.iter("joint"):  # its <dynamics> do not act in the scene, and some engines would let them act
        for element in joint.findall("dynamics"):
            joint.remove(element)
    return ElementTree.tostring(robot, encoding="unicode") + "\n"


def reference_states(dynamics: Dynamics, random: np.random.Generator) -> tuple[list[dict[str, Any]], dict[str, float]]:
    """Random states with everything that is computed at them in 50 digits, as plain lists; the bounds by quantity."""
    reach = np.where(dynamics.model.slides, SLIDE, ANGLE)
    states, worst = [], dict[str, float]()
    for _ in range(STATES):
        q, v = random.uniform(-reach, reach), random.normal(size=len(reach))
        exactly = _quantities(dynamics, q, v, exact(DIGITS))
        rounded = {name: np.asarray(value).astype(float) for name, value in exactly.items()}
        loaded = dynamics.loads.torque is not None or dynamics.loads.wrench is not None
        plain = _quantities(dynamics, q, v, np) if loaded else rounded
        for name, value in rounded.items():
            # half a spacing of doubles; loads are doubles: their rounding changes less than rounding all of the route
            off = EPS * np.abs(value).max() + MARGIN * np.abs(np.asarray(plain[name]) - value).max()
            worst[name] = max(worst.get(name, 0.0), float(off))
        states.append({"q": q.tolist(), "v": v.tolist()} | {name: value.tolist() for name, value in rounded.items()})
    return states, worst


def _quantities(dynamics: Dynamics, q: Array, v: Array, xp: Any) -> dict[str, Any]:
    """Accelerations, mass matrix, wrenches and energies at a state q, v (nv,), on the numbers of xp."""
    tree, field = tree_of(dynamics.model.pin), dynamics.loads.field(0.0)
    tau, external = (None if x is None else xp.asarray(x[0]) for x in loads_at(dynamics, q[None], v[None]))
    q_, v_, g, none = (xp.asarray(x) for x in (q, v, field, np.zeros(3)))
    prepared_tree, signs = prepared(tree, xp)
    a = recursion.accelerations(tree, q_, v_, g, tau, external, xp=xp)

    columns = []  # of the mass matrix: the torques that unit accelerations need, without rates and gravity
    for unit in xp.asarray(np.eye(len(q))):
        wrench = recursion.wrenches(tree, q_, xp.asarray(np.zeros(len(q))), unit, none, xp=xp)
        columns.append(recursion.along_axes(prepared_tree, wrench))
    M = np.array(columns).T * signs[:, None]

    potential = xp.asarray(np.zeros(1))[0]  # - sum of m g.r over the centres of mass, J
    for (R, r), m, com in zip(place_joints(tree, q_, xp), prepared_tree.masses, prepared_tree.coms, strict=True):
        potential = potential - m * (g @ (r + applied(R, com)))
    wrench = recursion.wrenches(tree, q_, v_, a, g, external, xp=xp)
    return {"a": a, "mass_matrix": M, "wrench": wrench, "kinetic": v_ @ M @ v_ / 2, "potential": potential}


def reference_motion(scene: Scene) -> tuple[dict[str, Any], dict[str, float]]:
    """The motion at 50 times by two families of methods, up to where they agree; the bounds of q and v."""
    first, second = (simulate(scene.by(*family), samples=TIMES) for family in FAMILIES)
    apart = np.maximum.accumulate(np.abs(first.q - second.q).max(1))
    count = max(1, int((apart <= WORTH).sum()))
    motion = {name: getattr(first, name)[:count].tolist() for name in ("t", "q", "v")}
    apart = {name: np.abs(getattr(first, name) - getattr(second, name))[:count].max() for name in ("q", "v")}
    return motion, {name: float(MARGIN * off) + EPS for name, off in apart.items()}

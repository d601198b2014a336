"""From a run to what is drawn: solids and their poses over time, the tip's path, joint forces, curves."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.effects import FrameEffect, Support
from pendpin.errors import InputError
from pendpin.graphics.drawing import WORLD, Curve, Drawing, Joint, Plot, Quantity, Shape, distance, labels_of
from pendpin.graphics.figure import is_rope, joints_shown, rods_shown
from pendpin.graphics.style import BLACK, COLORS
from pendpin.ground.arrays import Array, across, cross
from pendpin.model import kinematics
from pendpin.model.bodies import pinocchio
from pendpin.model.build import Model
from pendpin.model.kinematics import model_of
from pendpin.model.notes import ignored, leaving
from pendpin.model.urdf import mesh_file, parse
from pendpin.scene import Chain, Scene, UrdfModel, scene_of
from pendpin.trajectory import RunRecord
from pendpin.trajectory.columns import DRIFT, unit_of

MOST_QUANTITIES = 600  # of a page


def drawing_of(trajectory: RunRecord) -> Drawing:
    """The drawing of a run in the axes of W, over the ground. Raises InputError where its model cannot be built again."""
    scene, known = _scene(trajectory)
    model = model_of(trajectory)
    leaves = bool(leaving(trajectory))
    extent = float(np.linalg.norm(trajectory.tips[: 1 if leaves else None], axis=-1).max()) or 1.0
    position, velocity = (_pivot_motion(scene, name, trajectory.t) for name in ("position", "velocity"))
    joints, shapes = _shapes(scene, model, extent, trajectory.q)
    as_rods = joints is not None
    poses = kinematics.poses(model, trajectory.q) if as_rods else kinematics.joint_poses(model, trajectory.q)
    wrench = trajectory.wrench[:, joints if as_rods else slice(None)]
    forces, moments = ((poses[..., :3, :3] @ wrench[..., part, None])[..., 0] for part in (slice(3), slice(3, 6)))
    # the velocity of the last tip, (n, 3) m/s, by a central difference along the rates
    step = (1e-6 / np.maximum(1.0, np.abs(trajectory.v).max(1, initial=0.0)))[:, None]
    sides = (kinematics.tips(model, kinematics.poses(model, trajectory.q + s * trajectory.v)) for s in (step, -step))
    after, before = (tips[:, -1] for tips in sides)
    count = len(trajectory.names) - 1  # without t
    note = f"{MOST_QUANTITIES} of {count} quantities can be plotted here; pendpin plot and run.plot draw any"
    few = [note] * (count > MOST_QUANTITIES)
    poses = np.insert(poses, poses.shape[1], np.eye(4), axis=1)  # what the bodies hang from
    poses[..., :3, 3] += position[:, None]
    plots = plots_of(trajectory)
    names, plotted = [name for name in trajectory.names if name != "t"], {one.name for x in plots for one in x.curves}
    if len(names) > MOST_QUANTITIES:  # those of the plots and the first, in their order
        first = sorted(names, key=lambda name: name not in plotted)  # stable
        names = sorted(first[:MOST_QUANTITIES], key=trajectory.names.index)
    names += [DRIFT] * trajectory.stats.conservative
    return Drawing(
        title=trajectory.title + ("" if known else ", seen from the support"),
        t=trajectory.t,
        poses=poses,
        shapes=shapes,
        trail=trajectory.tips[:, -1] + position,
        extent=extent,
        leaves=leaves,
        velocity=(after - before) / (2 * step) + velocity,
        forces=np.pad(forces, ((0, 0), (0, 1), (0, 0))),
        moments=np.pad(moments, ((0, 0), (0, 1), (0, 0))),
        quantities=tuple(Quantity(n, unit_of(trajectory, n), np.asarray(trajectory[n], float)) for n in names),
        plots=plots,
        joints=tuple(_joints(model, joints, extent)),
        support=poses.shape[1] - 1 if as_rods or trajectory.rod_reactions is not None else None,
        label=f"{trajectory.stats.method}, {trajectory.stats.setting}",
        notes=(*ignored(model.written or (), scene.effects), *few),  # limits too, which may be passed
    )


def ends_of(run: RunRecord) -> Array:
    """Both ends of every body over the ground, (n, bodies, 2, 3) m. Raises InputError as `drawing_of`."""
    scene, _ = _scene(run)
    joints = kinematics.poses(model_of(run), run.q)[..., :3, 3]
    return np.stack([joints, run.tips], 2) + _pivot_motion(scene, "position", run.t)[:, None, None]


def _scene(trajectory: RunRecord) -> tuple[Scene, bool]:
    """The scene of a run, or its model alone where the rest is gone, and whether the motion of the pivot is known."""
    try:
        return scene_of(trajectory), True
    except InputError:
        kinds = [effect.get("kind") for effect in trajectory.scene.get("effects") or ()]
        return Scene(model=trajectory.scene.get("model")), "support" not in kinds


def _pivot_motion(scene: Scene, quantity: str, t: Array) -> Array:
    """The position or velocity of the pivot at t (n,) s: (n, 3) m or m/s. InputError for times that a csv does not cover."""
    total = np.zeros((len(t), 3))
    for effect in scene.effects:
        if isinstance(effect, FrameEffect):
            of_time = getattr(effect, quantity)
            total += of_time(t) if isinstance(effect, Support) else [of_time(moment) for moment in t]
    if not np.isfinite(total).all():
        raise InputError("the times of the run are not those of its support")
    return total


def _shapes(scene: Scene, model: Model, extent: float, q: Array) -> tuple[list[int] | None, tuple[Shape, ...]]:
    """The solids of a URDF that shows any, each on what a joint moves; else rods, and the joint of each of them."""
    if isinstance(scene.model, UrdfModel):
        shapes = tuple(urdf_shapes(scene.model.file, model))
        if any(shape.body < len(model.joints) for shape in shapes):
            return None, shapes
    payloads = [0.0] * len(model.bodies)
    if isinstance(scene.model, Chain):
        payloads = [rod.payload for rod in scene.model.all_rods]
    brackets = () if model.chain is not None else bracket_shapes(model, extent, q)
    return [body.joint for body in model.bodies], (*rod_shapes(model, extent, payloads), *brackets)


def _joints(model: Model, rods: list[int] | None, extent: float) -> Iterator[Joint]:
    """The joints of rods; of a tree without any, all joints. `rods` are the joints of the bodies drawn, None for all."""
    bodies, parents = list(range(len(model.joints))) if rods is None else rods, model.tree.parents
    index, links = {joint: i for i, joint in enumerate(bodies)}, {body.joint: body for body in model.bodies}
    for i, rod in enumerate(model.rods, start=1):
        body, above = links[rod.last], index.get(parents[rod.first], WORLD)
        size = float(np.linalg.norm(body.tip)) or 0.3 * extent
        yield Joint(f"joint {i}", index[rod.last], above, rod.frame, rod.base, size, body.radius, True)
    for joint in () if model.rods else bodies:
        above = index.get(parents[joint], WORLD)
        yield Joint(model.joints[joint], index[joint], above, np.eye(3), np.eye(3), 0.3 * extent, 0.0, False)


# --- what the page plots against time: every quantity of a run by name, and the plots that are offered at once ------


def plots_of(run: RunRecord) -> tuple[Plot, ...]:
    """Several quantities together: energies, positions, rates, reactions; those that begin the page come first."""
    joints, least = joints_shown(run), float(run.potential.min())
    some = f", {len(joints)} of {len(run.joints)} joints" * (len(joints) < len(run.joints))
    kinetic, potential = Curve("kinetic", "kinetic", COLORS[1]), Curve("potential", "potential", COLORS[0], least)
    energy = (kinetic, potential, Curve("energy", "energy", BLACK, least))
    positions = _curves([run.joints[joint] for joint in joints])
    rates = Plot(f"Rates{some}", _curves([f"{run.joints[joint]}_rate" for joint in joints]))
    plots, reactions = [Plot("Energy, potential above its least", energy), Plot(f"Position{some}", positions)], []
    count = 0 if run.rod_reactions is None else run.rod_reactions.R3.shape[1]
    if count == 1:
        moments = [name for name in ("M1", "M2", "M3", "Mc") if name in run.places]
        reactions = [Plot("Reactions R1, R2, R3", _curves(["R1", "R2", "R3"])), Plot("Moments", _curves(moments))]
    elif count:  # of several the tension of those that are shown; the moments where there are any
        rods = rods_shown(run)
        few = f", {len(rods)} of {count} rods" * (len(rods) < count)
        named = (f"{name}_{i + 1}" for i in rods for name in ("Mc", "M1", "M2"))  # M3 of a hinge is about the rod
        moments = [name for name in named if name in run.places]
        title = "Moment Mc" if all(name.startswith("Mc") for name in moments) else "Moments"
        reactions = [Plot(f"Tension R3{few}", _curves([f"R3_{i + 1}" for i in rods]))]
        reactions += [Plot(f"Reactions of rod {i + 1}", _curves([f"R{k}_{i + 1}" for k in (1, 2, 3)])) for i in rods]
        reactions.append(Plot(f"{title}{few}", _curves(moments)))
    if not is_rope(run):
        return (*plots, *reactions, rates)
    offset = Plot("Tip's offset from the support", _curves(["tip_x", "tip_y"]))
    swing = Plot("Swing of the line to the tip", _curves(["swing"]))
    return (offset, swing, reactions[0], *plots, *reactions[1:], rates)


def _curves(names: list[str]) -> tuple[Curve, ...]:
    return tuple(Curve(name, name, color) for name, color in zip(names, COLORS, strict=False))


def compared_drawing(runs: Sequence[RunRecord]) -> Drawing:
    """The drawing of the first run, the others in it as ghosts. Raises InputError as `drawing_of`."""
    if len(runs) == 1:
        return drawing_of(runs[0])
    first, *rest = (replace(drawing_of(run), label=label) for run, label in zip(runs, labels_of(runs), strict=True))
    ghosts = []
    for drawing, run in zip(rest, runs[1:], strict=True):  # in the time of the first, with the distance of the tips
        rows, apart = distance(run, runs[0])
        cut: dict[str, Any] = {name: getattr(drawing, name)[rows] for name in ("t", "poses", "trail")}
        cut["velocity"] = None if drawing.velocity is None else drawing.velocity[rows]
        cut["shapes"] = tuple(shape for shape in drawing.shapes if shape.body != drawing.support)
        quantities = [quantity._replace(values=quantity.values[rows]) for quantity in drawing.quantities]
        quantities.append(Quantity("distance", "m", apart))
        ghosts.append(replace(drawing, **cut, forces=None, moments=None, quantities=tuple(quantities)))
    return replace(first, others=tuple(ghosts), extent=max(drawing.extent for drawing in (first, *rest)))


# --- the solids of a model: its rods, or what its URDF shows --------------------------------------------------------

COPPER, STEEL, BRASS = 0xD9622B, 0x7A8696, 0xE0A23C
THINNEST = 0.006  # of the extent: what is thinner is drawn this thick, as radius
MANY = 20  # rods; of more, thinner ones are drawn, without their joints
DENSITY = 7850.0  # kg/m³, of a payload: steel


def rod_shapes(model: Model, extent: float, payloads: Sequence[float]) -> Iterator[Shape]:
    """Rods, joints (a ball, or a hinge's pin), payloads in kg; and what they hang from, which is the body after them."""
    thick = THINNEST * extent
    many = len(model.bodies) > MANY
    hinges = dict[int, Array]()
    if model.chain is None:
        others = {rod.phi for rod in model.rods if rod.kind == "universal"} | set(np.flatnonzero(model.slides).tolist())
        hinges = {joint: axis for joint, axis in enumerate(model.tree.axes) if joint not in others}
    yield Shape("box", (12 * thick, 12 * thick, thick), _placement((0, 0, 3.5 * thick)), STEEL, len(model.bodies))
    for index, (body, payload) in enumerate(zip(model.bodies, payloads, strict=True)):
        radius = max(body.radius, thick * (0.4 if many else 1.0))
        long = any(body.tip)  # a rotor about its own centre is not
        if long:
            yield _stick(np.zeros(3), body.tip, radius, COPPER if index % 2 == 0 else BRASS, index)
        size = min(1.5 * radius, 3 * thick)
        if not (many and long):
            pin = hinges.get(body.joint)
            ball = Shape("sphere", (size,), np.eye(4), STEEL, index)
            yield ball if pin is None else _stick(-2 * size * pin, 2 * size * pin, 0.9 * size, STEEL, index)
        if payload or index == len(model.bodies) - 1:
            ball = min((3 * payload / (4 * math.pi * DENSITY)) ** (1 / 3), math.hypot(*body.tip) / 6)  # m, of steel
            ball = body.payload_radius or max(1.5 * thick, ball)
            yield Shape("sphere", (ball,), _placement(body.tip), STEEL, index)


def bracket_shapes(model: Model, extent: float, q: Array) -> Iterator[Shape]:
    """Thin lines of a tree: from rods to joints that hang beside them, and along the ways of slides in q (n, nv)."""
    thin = 0.5 * THINNEST * extent
    tree = model.tree
    places = {body.joint: (index, body.tip) for index, body in enumerate(model.bodies)}
    places[WORLD] = len(model.bodies), np.zeros(3)
    for joint, (parent, place) in enumerate(zip(tree.parents, tree.translations, strict=True)):
        if parent not in places:  # a link without mass has no pose here
            continue
        body, tip = places[parent]
        lines = [(np.clip(place @ tip / (tip @ tip or 1.0), 0.0, 1.0) * tip, place)]
        if model.slides[joint]:
            axis = tree.rotations[joint] @ tree.axes[joint]
            way = q[:, joint]
            lines.append((place + min(way.min(), 0.0) * axis, place + max(way.max(), 0.0) * axis))
        yield from (_stick(*ends, thin, STEEL, body) for ends in lines if math.dist(*ends) > thin)


def _stick(start: Array, end: Array, radius: float, color: int, body: int) -> Shape:
    """A cylinder from one place to another, (3,) m."""
    length = math.hypot(*(end - start))  # the norm of a tiny vector is 0
    z = (end - start) / length
    x = across(z)
    placement = _placement((start + end) / 2, np.stack([x, cross(z, x), z], -1))
    return Shape("cylinder", (radius, length), placement, color, body)


def _placement(place: Any, rotation: Array | None = None) -> Array:
    """A placement (4, 4) at a place (3,) in m, with a rotation (3, 3) if there is one."""
    placement = np.eye(4)
    placement[:3, 3] = place
    if rotation is not None:
        placement[:3, :3] = rotation
    return placement


def urdf_shapes(path: Path, model: Model) -> Iterator[Shape]:
    """The visuals of a URDF, fixed to the joint that moves each link; what none moves, to the body after all joints."""
    robot = parse(path.read_bytes())  # the model is built: every check has been passed
    materials = {str(material.get("name")): material for material in robot.findall("material")}
    assert model.pin is not None
    frames = {frame.name: frame for frame in model.pin.frames if frame.type == pinocchio().FrameType.BODY}
    tones: dict[int, int] = {}
    for link in robot.findall("link"):
        frame = frames[str(link.get("name"))]
        for visual in link.findall("visual"):
            placement = np.array(frame.placement.homogeneous)
            if (origin := visual.find("origin")) is not None:
                rotation = pinocchio().rpy.rpyToMatrix(np.array(_numbers(origin.get("rpy", "0 0 0"))))
                placement = placement @ _placement(_numbers(origin.get("xyz", "0 0 0")), rotation)
            body = (frame.parentJoint or model.pin.njoints) - 1
            color = tones.setdefault(body, (COPPER, BRASS)[len(tones) % 2])
            material = visual.find("material")
            if material is not None and material.find("color") is None:
                material = materials.get(str(material.get("name")))
            if material is not None and (written := material.find("color")) is not None:
                rgb = _numbers(written.get("rgba", "1 1 1 1"))[:3]
                red, green, blue = (round(255 * min(max(part, 0.0), 1.0)) for part in rgb)
                color = red << 16 | green << 8 | blue
            shape: Any = visual.find("geometry/*")
            if shape.tag != "mesh":
                keys = {"box": ("size",), "sphere": ("radius",)}.get(shape.tag, ("radius", "length"))
                size = tuple(number for key in keys for number in _numbers(shape.get(key)))
                yield Shape("cylinder" if shape.tag == "capsule" else shape.tag, size, placement, color, body)
            elif file := mesh_file(path.parent, shape.get("filename")):  # else it is gone, as the model's notes say
                yield Shape("mesh", _numbers(shape.get("scale", "1 1 1")), placement, color, body, str(file))


def _numbers(text: str) -> tuple[float, ...]:
    return tuple(float(part) for part in text.split())

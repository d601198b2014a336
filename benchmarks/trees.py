"""Trees of rods on universal joints and hinges: every route against every other, other simulators, and what they cost.

    python benchmarks/trees.py [--trees 200] [--states 20] [--rods 2 5 12 50]

First random trees of up to 12 rods: the worst difference of any two routes and from 50 digits, over the size of the terms
that enter. Then the accelerations of MuJoCo and Drake from the URDF, MJCF and SDF that are written of these trees, over the
same size. Then the processor time of one evaluation of the equations of motion, of a row of hinges and of one of universal
joints, beside MuJoCo's and Pinocchio's. It ends with status 1 if a difference is above 1e-12.
"""

import argparse
import logging
import sys
import time
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np
import pinocchio as pin

import pendpin as pp
from pendpin.dynamics.dynamics import Dynamics, bind
from pendpin.model.write_models import chain_urdf, mjcf, sdf
from pendpin.motions.crosschecks.routes import tree_scale

Acceleration = Callable[[np.ndarray, np.ndarray], np.ndarray]  # q, v -> accelerations, (nv,) each
BOUND = 1e-12  # of the terms
GRAVITY = pp.effects.Gravity()


def random_tree(random: np.random.Generator) -> pp.Scene:
    """Up to 12 rods of 0.3 to 2 m and 0.1 to 3 kg, branch by branch, each hung anywhere on one above it."""
    rods, branch = list[pp.Rod](), list[int]()
    for i in range(random.integers(1, 13)):
        branch = branch[: random.integers(1, len(branch) + 1)] if branch else []
        hung: dict[str, Any] = {}
        if branch:
            hung = {"hangs_on": f"rod_{branch[-1] + 1}", "at": random.uniform(0.2, 1.0) * rods[branch[-1]].length}
        kind = ({}, {"joint": "hinge"}, {"joint": "hinge", "axis": "y"})[random.integers(3)]
        length, mass = random.uniform(0.3, 2.0), random.uniform(0.1, 3.0)
        rods.append(pp.Rod(length=length, mass=mass, radius=random.uniform(0.02, 0.1), **kind, **hung))
        branch = [*branch, i]
    return pp.Scene(model=pp.Chain(rods=rods), effects=[GRAVITY])


def by_mujoco(dynamics: Dynamics, text: str) -> Acceleration:
    """Accelerations in pendpin's order of joints, of a URDF or MJCF."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(text)
    for sizes in (model.body_mass, model.body_inertia):
        sizes[sizes <= 1e-15] = 0.0  # what MuJoCo adds to the cross of a universal joint
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT.value | mujoco.mjtDisableBit.mjDSBL_LIMIT.value
    model.opt.gravity[:] = dynamics.loads.constant
    data, joints = mujoco.MjData(model), [model.joint(name) for name in dynamics.model.joints]
    at_q, at_v = [joint.qposadr[0] for joint in joints], [joint.dofadr[0] for joint in joints]

    def accelerate(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        data.qpos[at_q], data.qvel[at_v] = q, v
        mujoco.mj_forward(model, data)
        return data.qacc[at_v].copy()

    return accelerate


def by_drake(dynamics: Dynamics, text: str) -> Acceleration:
    """The same of a URDF or SDF; a universal joint of SDF is one joint with the names of both, __ between."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    logging.getLogger("drake").setLevel(logging.ERROR)  # it warns that it takes no motors at universal joints
    plant: Any = MultibodyPlant(time_step=0.0)
    Parser(plant).AddModelsFromString(text, "sdf" if "<sdf" in text else "urdf")
    if "<sdf" not in text:
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("support"))
    plant.mutable_gravity_field().set_gravity_vector(dynamics.loads.constant)
    plant.Finalize()
    places = {}
    for joint in (plant.get_joint(index) for index in plant.GetJointIndices()):
        names = joint.name().split("__")[: joint.num_velocities()]
        places |= {name: joint.velocity_start() + i for i, name in enumerate(names)}
    at, context = [places[name] for name in dynamics.model.joints], plant.CreateDefaultContext()

    def accelerate(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        positions, velocities = np.zeros((2, len(at)))
        positions[at], velocities[at] = q, v
        plant.SetPositions(context, positions)
        plant.SetVelocities(context, velocities)
        return plant.EvalTimeDerivatives(context).get_generalized_velocity().CopyToVector()[at]

    return accelerate


def simulators(scene: pp.Scene, dynamics: Dynamics) -> dict[str, Acceleration]:
    """Those that are installed, by the format that they read."""
    chain, out = scene.model, dict[str, Acceleration]()
    assert isinstance(chain, pp.Chain)
    if find_spec("mujoco"):
        out["MuJoCo, URDF"] = by_mujoco(dynamics, chain_urdf(chain))
        out["MuJoCo, MJCF"] = by_mujoco(dynamics, mjcf(dynamics.model, dynamics.loads.constant, {}))
    if find_spec("pydrake"):
        out["Drake, URDF"] = by_drake(dynamics, chain_urdf(chain))
        out["Drake, SDF"] = by_drake(dynamics, sdf(dynamics.model, {}))
    return out


def compare(trees: int, states: int) -> dict[str, float]:
    """The worst difference by the names of the two, over the terms of each quantity."""
    worst = dict[str, float]()
    for seed in range(trees):
        random = np.random.default_rng(seed)
        scene = random_tree(random)
        for row in pp.crosscheck(scene, states=states, seed=seed).rows:
            pair = f"{row.first} / {row.second}"
            worst[pair] = max(worst.get(pair, 0.0), row.relative)
        dynamics = bind(scene)
        q, v = random.uniform(-3, 3, (2, states, len(dynamics.model.joints)))
        a = np.array([dynamics.acceleration(0.0, *state) for state in zip(q, v, strict=True)])
        size = tree_scale(dynamics.model, dynamics.loads.constant, q, v, a).acceleration
        for name, accelerate in simulators(scene, dynamics).items():
            theirs = np.array([accelerate(*state) for state in zip(q, v, strict=True)])
            worst[name] = max(worst.get(name, 0.0), float((np.abs(theirs - a) / size).max()))
    return worst


# --- the time of an evaluation ----------------------------------------------------------------------------------------


def least(compute: Callable[[], Any], repetitions: int = 2000) -> float:
    """The least processor time of a call in five series, in us."""
    times = []
    for _ in range(5):
        begin = time.process_time()
        for _ in range(repetitions):
            compute()
        times.append(time.process_time() - begin)
    return 1e6 * min(times) / repetitions


def speed(rods: int, kind: dict[str, Any]) -> list[float]:
    """us of one evaluation in a run, by MuJoCo (NaN without it) and by Pinocchio's aba."""
    rod = pp.Rod(length=1 / rods, mass=1 / rods, radius=0.05 / rods, **kind)
    start = pp.Start(positions={"theta_1": 0.5} | ({} if kind else {"phi_1": 0.3}))
    scene = pp.Scene(model=pp.Chain(rods=[rod], copies=rods), effects=[GRAVITY], start=start, duration=2.0)
    runs = [pp.simulate(scene, method="dop853", tolerance=1e-10, samples=2).stats for _ in range(3)]
    dynamics = bind(scene)
    q, v = np.sin(1.0 + np.arange(2 * len(dynamics.model.joints))).reshape(2, -1)
    text = mjcf(dynamics.model, dynamics.loads.constant, {})
    theirs = by_mujoco(dynamics, text) if find_spec("mujoco") else None
    model, data, zero = dynamics.model.pin, dynamics.model.pin.createData(), np.zeros(len(q))
    return [
        1e6 * min(run.seconds / run.evaluations for run in runs),
        least(lambda: theirs(q, v)) if theirs else np.nan,
        least(lambda: pin.aba(model, data, q, v, zero)),
    ]


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--trees", type=int, default=200)
    parser.add_argument("--states", type=int, default=20)
    parser.add_argument("--rods", type=int, nargs="*", default=[2, 5, 12, 50])
    given = parser.parse_args()
    worst = compare(given.trees, given.states)
    print(f"{given.trees} random trees, {given.states} states of each: worst difference over the size of the terms")
    for name, value in worst.items():
        print(f"  {name:26} {value:.1e}")
    print(f"\none evaluation, us{'pendpin':>14}{'MuJoCo':>10}{'aba':>10}")
    for rods in given.rods:
        for name, kind in (("hinges", {"joint": "hinge"}), ("universal", {})):
            print(f"{rods:4} {name:12}" + "".join(f"{x:10.2f}" for x in speed(rods, kind)))
    sys.exit(max(worst.values()) > BOUND)


if __name__ == "__main__":
    main()

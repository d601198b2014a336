"""Cables: the error of n rods against closed forms, what more rods cost, a snatch, and a peer made for beams.

    python benchmarks/cables.py [--rods 8 16 32 64] [--cost 250 500 1000] [--snatch 8 16 32] [--stiff] [--peer]

Euler and Bernoulli's cantilever (tip under a small load, two frequencies), a heavy clamped elastica by SciPy's boundary
value problem, and the catenary's horizontal force: error times n², the same for every n where the order is two.
--cost: processor time of an evaluation with bending. --snatch: the peak tension of a rope that catches its load. --stiff:
steps of dop853 and radau for stiff anchors and bending. --peer: a falling beam of 60 m in 60 rods beside the ANCF cable
elements of Exudyn (pip install exudyn) at the same error of the tip.
"""

import argparse
import math
import time
import warnings

import numpy as np
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

import pendpin as pp
from pendpin import effects as fx
from pendpin.dynamics.dynamics import bind

EI, LENGTH, MASS = 3.0, 2.0, 0.5  # N m², m, kg/m
LOAD, APART, STIFF = 1e-6, 1.4, 1e7  # N, m, N/m
GRAVITY = 9.81  # m/s²


def beam(n: int, *effects: fx.Effect, **positions: float) -> pp.Scene:
    """A thin beam in n rods."""
    rods = [pp.Rod(length=LENGTH / n, mass=MASS * LENGTH / n, radius=1e-5, copies=n)]
    start = pp.Start(positions=positions)
    return pp.Scene(duration=1.0, model=pp.Chain(rods=rods), effects=effects, start=start)


def place_at_rest(scene: pp.Scene) -> np.ndarray:
    """Where the last tip is at the equilibrium, (3,) m."""
    return pp.simulate(scene.replace(start=pp.Start.at_rest(scene)), duration=0.0, samples=1).tips[0, -1]


def errors(n: int) -> dict[str, float]:
    """The relative errors of n rods."""
    clamped = fx.Bending(stiffness=EI, clamp=(0, 0, -1))
    pushed = beam(n, clamped, fx.Push(link=f"rod_{n}", force=(LOAD, 0, 0), point=LENGTH / n))
    roots = [brentq(lambda x: math.cos(x) * math.cosh(x) + 1, *ends) for ends in ((1, 3), (4, 6))]
    first, _, second, *_ = pp.modes(beam(n, clamped)).hertz
    exact = np.square(roots) * math.sqrt(EI / (MASS * LENGTH**4)) / (2 * math.pi)
    across = place_at_rest(beam(n, fx.Gravity(), fx.Bending(stiffness=EI, clamp=(0, -1, 0)), theta_1=1.4))[1]
    up = math.acos(APART / LENGTH)
    anchor = fx.Anchor(link=f"rod_{n}", point=(0, -APART, 0), stiffness=STIFF)
    v_shape = {"theta_1": math.pi / 2 - up, f"theta_{n // 2 + 1}": 2 * up}
    tip = place_at_rest(beam(n, fx.Gravity(), anchor, **v_shape))
    a = brentq(lambda a: 2 * a * math.sinh(APART / (2 * a)) - LENGTH, 0.1, 50)
    return {
        "tip of a cantilever": place_at_rest(pushed)[0] / (LOAD * LENGTH**3 / (3 * EI)) - 1,
        "its first frequency": first / exact[0] - 1,
        "its second frequency": second / exact[1] - 1,
        "reach of a heavy elastica": across / elastica() - 1,
        "force H of a catenary": STIFF * (tip[1] + APART) / (MASS * GRAVITY * a) - 1,
    }


def elastica() -> float:
    """How far a clamped heavy beam reaches along -y, m."""
    weight = MASS * GRAVITY
    solved = solve_bvp(
        lambda s, y: np.array([y[1], -weight * (LENGTH - s) * np.cos(y[0]) / EI]),
        lambda a, b: np.array([a[0], b[1]]),
        np.linspace(0, LENGTH, 201),
        np.zeros((2, 201)),
        tol=1e-10,
        max_nodes=10**5,
    )
    s = np.linspace(0, LENGTH, 20001)
    return -float(np.trapezoid(np.cos(solved.sol(s)[0]), s))


def time_evaluation(n: int) -> float:
    """The processor time of one evaluation of n rods with bending, s: the least of some."""
    scene = beam(n, fx.Gravity(), fx.Bending(stiffness=EI), theta_1=0.3)
    derivative, _ = bind(scene.with_solver(engine="compiled")).engine.derivative(lambda t: None)
    y, dy, best, calls = np.full(4 * n, 0.01), np.empty(4 * n), math.inf, max(1, 20_000 // n)
    for _ in range(8):
        begin = time.process_time()
        for _ in range(calls):
            derivative(dy, 0.0, y)
        best = min(best, (time.process_time() - begin) / calls)
    return best


def catch_load(n: int, line: float) -> tuple[float, float]:
    """The peak tension of a rope, `line` kg/m, whose load falls freely for a metre: between 49 samples, and at them, N."""
    length, load, fall = 10.0, 800.0, 1.0  # m, kg, m
    rod = pp.Rod(length=length / n, mass=line * length / n, radius=0.006, copies=n - 1)
    last = pp.Rod(length=length / n, mass=line * length / n, radius=0.006, payload=load)
    aside = math.acos(1 - fall / length)
    start = pp.Start(positions={"theta_1": aside, f"theta_{n // 2 + 1}": -2 * aside})
    scene = pp.Scene(duration=0.8, model=pp.Chain(rods=[rod, last]), effects=[fx.Gravity()], start=start)
    run = pp.simulate(scene, tolerance=1e-9, samples=49)
    return run.maximum("tension_1").value, float(run["tension_1"].max())


def stiff_scenes() -> dict[str, pp.Scene]:
    """Ropes between two points and beams, from soft to stiff."""
    up, scenes = math.acos(APART / LENGTH), dict[str, pp.Scene]()
    for stiffness, damping in ((1e4, 0.0), (1e6, 0.0), (1e4, 1e3), (1e4, 1e4)):
        anchor = fx.Anchor(link="rod_30", point=(0, -APART, 0), stiffness=stiffness, damping=damping)
        name = f"30 rods, anchor of {stiffness:.0e} N/m and {damping:.0e} N s/m"
        scenes[name] = beam(30, fx.Gravity(), anchor, theta_1=math.pi / 2 - up, theta_16=2 * up)
    for n in (10, 20, 40):
        bent = fx.Bending(stiffness=100.0, clamp=(0, -1, 0))
        scenes[f"{n} rods, bending of 100 N m²"] = beam(n, fx.Gravity(), bent, theta_1=math.pi / 2)
    return scenes


def count_steps(scene: pp.Scene, method: str) -> str:
    """The steps of a run at tolerance 1e-6, and its processor time."""
    begin = time.process_time()
    try:
        steps = pp.simulate(scene, method=method, tolerance=1e-6, limit=30).stats.steps
    except pp.errors.RunError:
        return "over 30 s"
    return f"{steps} in {time.process_time() - begin:.2f} s"


# --- a peer made for beams ------------------------------------------------------------------------------------------

BEAM, LINE, FALL = 60.0, 2.0, 3.0  # m, kg/m, s
BEAMS = {"clamped beam, 5 MN m²": (5e6, True), "hinged rope, 1 kN m²": (1e3, False)}  # N m², and whether clamped


def fall_in_rods(n: int, stiffness: float, clamped: bool, tolerance: float = 1e-7) -> tuple[np.ndarray, float]:
    """Where the tip of a beam is that began to fall when it was level, (2,) m, and the processor time in s."""
    bending = fx.Bending(stiffness=stiffness, clamp=(0, -1, 0) if clamped else None)
    rods = [pp.Rod(length=BEAM / n, mass=LINE * BEAM / n, copies=n)]
    start = pp.Start(positions={"theta_1": math.pi / 2})
    scene = pp.Scene(duration=FALL, model=pp.Chain(rods=rods), effects=[fx.Gravity(), bending], start=start)
    begin = time.process_time()
    run = pp.simulate(scene, tolerance=tolerance, samples=2)
    return run.tips[-1, -1, 1:], time.process_time() - begin


def fall_in_elements(count: int, steps: int, stiffness: float, clamped: bool) -> tuple[np.ndarray, float]:
    """The same by Exudyn: cubic ANCF cable elements with EA = 1 GN, generalised alpha."""
    import exudyn as exu
    from exudyn.beams import GenerateStraightLineANCFCable2D
    from exudyn.itemInterface import Cable2D

    begin = time.process_time()
    system = exu.SystemContainer().AddSystem()
    cable = Cable2D(physicsMassPerLength=LINE, physicsBendingStiffness=stiffness, physicsAxialStiffness=1e9)
    made = GenerateStraightLineANCFCable2D(
        *(system, [0, 0, 0], [-BEAM, 0, 0], count, cable),
        massProportionalLoad=[0, -GRAVITY, 0],
        fixedConstraintsNode0=[1, 1, 0, int(clamped)],
    )
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = steps, FALL
    settings.timeIntegration.verboseMode, settings.solutionSettings.writeSolutionToFile = 0, False
    settings.timeIntegration.newton.useModifiedNewton = True
    system.SolveDynamic(settings)
    tip = system.GetNodeOutput(made[0][-1], exu.OutputVariableType.Position)
    return np.array(tip[:2]), time.process_time() - begin


def compare_with_peer() -> None:
    """Print the error of 60 rods over the length, its price, and the cheapest of some elements and steps as good."""
    warnings.simplefilter("ignore", DeprecationWarning)
    for name, (stiffness, clamped) in BEAMS.items():
        fall_in_rods(60, stiffness, clamped)  # compiles
        tips = {n: fall_in_rods(n, stiffness, clamped)[0] for n in (30, 60, 120)}
        exact = tips[120] + (tips[120] - tips[60]) / 3
        _, price = fall_in_rods(60, stiffness, clamped)
        error = float(np.linalg.norm(tips[60] - exact)) / BEAM
        order = math.log2(np.linalg.norm(tips[30] - tips[60]) / np.linalg.norm(tips[60] - tips[120]))
        print(f"{name}: 60 rods, error {error:.1e} of the length, order {order:.2f}, {price:.2f} s")
        for count in (4, 8, 16):
            for steps in (100, 400, 1600):
                try:
                    tip, seconds = fall_in_elements(count, steps, stiffness, clamped)
                except ValueError as failure:
                    print(f"    Exudyn, {count:3} elements, {steps:5} steps: {str(failure).splitlines()[0][:60]}")
                    continue
                apart = float(np.linalg.norm(tip - exact)) / BEAM
                print(f"    Exudyn, {count:3} elements, {steps:5} steps: error {apart:.1e}, {seconds:.2f} s")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rods", type=int, nargs="*", default=[8, 16, 32, 64])
    parser.add_argument("--cost", type=int, nargs="*", default=[])
    parser.add_argument("--snatch", type=int, nargs="*", default=[])
    parser.add_argument("--stiff", action="store_true")
    parser.add_argument("--peer", action="store_true")
    asked = parser.parse_args()
    begin = time.process_time()
    if asked.rods:
        table = {n: errors(n) for n in asked.rods}
        print(f"{'error times n²':28}" + "".join(f"{n:>12} rods" for n in asked.rods))
        for name in table[asked.rods[0]]:
            print(f"{name:28}" + "".join(f"{table[n][name] * n * n:17.4f}" for n in asked.rods))
    for n in asked.cost:
        each = time_evaluation(n)
        print(f"{n} rods with bending: {each * 1e6:.1f} us an evaluation, {each / n * 1e9:.0f} ns a rod")
    for n in asked.snatch:
        for line in (0.7, 0.07):
            peak, sampled = catch_load(n, line)
            print(f"{n} rods of {line} kg/m that catch 800 kg: peak {peak:.2e} N, {sampled:.2e} N at 49 samples")
    for name, scene in stiff_scenes().items() if asked.stiff else ():
        print(f"{name}: dop853 {count_steps(scene, 'dop853')}, radau {count_steps(scene, 'radau')}")
    if asked.peer:
        compare_with_peer()
    print(f"{time.process_time() - begin:.1f} s of processor time")


if __name__ == "__main__":
    main()

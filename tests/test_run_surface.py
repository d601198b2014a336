"""A run asked for more: quantities by name, other times, crossings, more time, tables, pictures."""

import copy
import csv
import pickle
from pathlib import Path

import numpy as np
import pytest

import pendpin as pp
from pendpin.motions.continuation import resolve
from pendpin.motions.search import first_crossings
from pendpin.scene import builtin_scene

EXAMPLES = Path(__file__).parents[1] / "examples"
ROD = {"kind": "chain", "rods": [{"length": 1.0, "mass": 1.0, "radius": 0.02}]}
THIN = {"kind": "chain", "rods": [{"length": 1.0, "mass": 1.0}, {"length": 0.7, "mass": 0.5}]}
GRAVITY = pp.effects.Gravity()
START = {"positions": {"theta_1": 0.9, "phi_1": 0.4}, "velocities": {"theta_1": 1.0}}
SCENES = {
    "smooth": pp.Scene(model=ROD, start=START, effects=[GRAVITY], duration=3.0),
    "thin chain": pp.Scene(model=THIN, start=START, effects=[GRAVITY], duration=3.0),
    "damped": pp.Scene(model=THIN, start=START, effects=[GRAVITY, pp.effects.Drag(diameter=0.05)], duration=3.0),
    "later": pp.Scene(model=ROD, start=START | {"time": 5.0}, effects=[GRAVITY], duration=3.0),
    "friction": pp.Scene(model=ROD, start=START, effects=[GRAVITY, pp.effects.DryFriction(kinetic=0.3)], duration=3.0),
    "stops": pp.Scene(
        model=ROD, start=START, effects=[GRAVITY, pp.effects.Stop(lower=-0.3, upper=1.0, restitution=0.6)], duration=3.0
    ),
}


@pytest.fixture(params=SCENES)
def scene(request: pytest.FixtureRequest) -> pp.Scene:
    """One of the scenes."""
    return SCENES[request.param]


def test_between_samples_a_run_is_as_accurate_as_at_them(scene: pp.Scene) -> None:
    """Against a run 1000 times as tight, within 10 times the run's own error at its samples."""
    run = pp.simulate(scene, samples=61, tolerance=1e-8)
    between = np.sort(np.random.default_rng(1).uniform(run.t[0], run.t[-1], 50))
    tight = pp.simulate(scene, times=np.union1d(run.t, between), tolerance=1e-12)
    at_samples, at_others = np.searchsorted(tight.t, run.t), np.searchsorted(tight.t, between)
    found = run.at(between)
    for one, other, size in [(run.q, tight.q, 1.0), (run.v, tight.v, 1.0), (run.tips, tight.tips, 1.0)]:
        part = {id(run.q): found.q, id(run.v): found.v, id(run.tips): found.tips}[id(one)]
        error = max(float(np.abs(one - other[at_samples]).max()), 1e-9 * size)
        assert np.abs(part - other[at_others]).max() <= 10 * error


@pytest.mark.parametrize("name", ["smooth", "friction"])
def test_a_late_run_is_as_accurate_between_its_samples(name: str) -> None:
    """At 1e9 s: a sample is at its share of the duration, whatever the double of its time; derivatives too."""
    early, late = (pp.simulate(SCENES[name].replace({"start.time": t}), samples=31) for t in (0.0, 1e9))
    t = 1e9 + np.linspace(0.03, 2.99, 50)  # rounded to 1e-7 s
    one, other = early.at(t - 1e9), late.at(t)
    np.testing.assert_allclose(other.q, one.q, rtol=0, atol=1e-9)
    one, other = (run.sensitivity("model.rods[0].length") for run in (early, late))
    np.testing.assert_allclose(other, one, rtol=0, atol=1e-9 * np.abs(one).max())


def test_at_a_sample_it_is_the_sample(scene: pp.Scene) -> None:
    """Whatever else is asked for."""
    run = pp.simulate(scene, samples=31)
    found = run.at(run.t[[0, 7, 8, 30]])
    np.testing.assert_allclose(found.q, run.q[[0, 7, 8, 30]], atol=1e-12)
    np.testing.assert_allclose(found.wrench, run.wrench[[0, 7, 8, 30]], atol=1e-9)


def test_crossings_against_a_tighter_run(scene: pp.Scene) -> None:
    """Their instants are within 10 times the run's error over the rate there."""
    run, tight = (pp.simulate(scene, samples=40, tolerance=tolerance) for tolerance in (1e-8, 1e-12))
    found, right = (
        r.crossings("theta", 0.05) if len(r.joints) == 2 else r.crossings("theta_1", 0.05) for r in (run, tight)
    )
    assert len(found.t) == len(right.t) > 1
    error = max(float(np.abs(run.q - tight.q).max()), 1e-9)
    assert (np.abs(found.t - right.t) * np.abs(right.v[:, 0]) <= 10 * error).all()
    np.testing.assert_allclose(found.q[:, 0], 0.05, atol=1e-11)


def test_the_state_at_an_impact_is_the_one_after_it() -> None:
    """Where a joint hits its stop the rate jumps; at that time it has reversed."""
    run = pp.simulate(SCENES["stops"], samples=31)
    struck = run.crossings("theta_rate", 0.0, direction=1)
    on_stop = np.abs(struck["theta"] + 0.3) < 1e-9
    assert on_stop.any()
    before = run.at(struck.t[on_stop] - 1e-9)
    np.testing.assert_allclose(struck["theta_rate"][on_stop], -0.6 * before["theta_rate"], rtol=1e-6)


@pytest.mark.parametrize("samples", [2, *(pytest.param(n, marks=pytest.mark.slow) for n in (6, 12, 13)), 21])
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_crossings_do_not_depend_on_the_samples(samples: int, size: float) -> None:
    """Twenty seconds with several swings between two samples, or none at all to speak of; large and small swings."""
    start = {part: {joint: size * x for joint, x in START[part].items()} for part in START}
    scene = SCENES["smooth"].replace({"start": start})
    many, few = (pp.simulate(scene, duration=20.0, samples=n, tolerance=1e-11 * size) for n in (1201, samples))
    found, right = (run.crossings("theta", 0.0, direction=1) for run in (few, many))
    assert len(right.t) > 5
    np.testing.assert_allclose(found.t, right.t, rtol=0, atol=1e-8)
    assert not [name for name in few.summary() if name.startswith("period")]


def test_an_instant_takes_few_looks() -> None:
    """Of a smooth quantity: six digits more from the third on. By halving it would take fifty."""
    looks = []

    def over(rows: pp.Trajectory) -> np.ndarray:
        looks.append(len(rows.t))
        return rows["theta"] - 0.1

    run = pp.simulate(SCENES["smooth"], samples=200)
    (instant,) = first_crossings(resolve(run), [over])
    assert run.at([instant])["theta"] == pytest.approx([0.1], abs=1e-12)
    assert looks.count(1) <= 6


def test_crossings_that_no_two_samples_enclose() -> None:
    """A level just inside a turning point is crossed twice between two samples."""
    run = pp.simulate(SCENES["smooth"], samples=25)
    top = float(run.crossings("theta_rate", 0.0, direction=-1)["theta"][-1])
    near = run.crossings("theta", top - 1e-4)
    assert len(near.t) >= 2
    none = run.crossings("theta", 10.0)
    assert (len(none.t), none.stats.steps, none.stats.evaluations, none.stats.events) == (0, 0, 0, 0)
    up, down = (run.crossings("theta", 0.0, direction=d) for d in (1, -1))
    assert (up["theta_rate"] > 0).all()
    assert (down["theta_rate"] < 0).all()


def test_extend(scene: pp.Scene) -> None:
    """The run gone on with is one long run, to the tolerance."""
    run = pp.simulate(scene, samples=31, duration=1.5, tolerance=1e-9, energy_balance=True)
    whole, long = run.extend(1.5), pp.simulate(scene, samples=61, duration=3.0, tolerance=1e-9, energy_balance=True)
    np.testing.assert_array_equal(whole.t, long.t)
    np.testing.assert_allclose(whole.q, long.q, atol=1e-6)
    assert whole.imbalance < 1e-6
    assert whole.scene["duration"] == 3.0
    np.testing.assert_array_equal(whole.q[:31], run.q)


def test_extend_from_an_impact() -> None:
    """A run that ends as its joint reaches a stop goes on with the impact: 1 rad at 1 rad/s, and half as fast back."""
    point = pp.Chain(rods=[pp.Rod(length=1.0, mass=0.0, payload=1.0, joint="hinge")])
    start = pp.Start(velocities={"theta": 1.0})
    free = pp.Scene(model=point, start=start, effects=[pp.effects.Stop(upper=1.0, restitution=0.5)], duration=1.0)
    run = pp.simulate(free, energy_balance=True)
    whole = run.extend(1.0)
    assert whole.v[-1] == pytest.approx(-0.5, rel=1e-12)
    assert [event.kind for event in whole.events] == ["stop"]
    assert whole.events[0].t == pytest.approx(1.0, rel=1e-12)
    assert whole.work["stop"][-1] == pytest.approx(-0.375, rel=1e-12)


@pytest.mark.parametrize("method", ["rk4", "euler"])
def test_extend_bit_for_bit(method: str) -> None:
    """Fixed steps give what one long run gives."""
    scene = pp.load_scene(EXAMPLES / "double_pendulum.toml").replace({"solver.step": 0.004, "solver.method": method})
    whole, long = pp.simulate(scene, duration=1.0).extend(0.5), pp.simulate(scene, duration=1.5)
    np.testing.assert_array_equal(whole.q, long.q)
    np.testing.assert_array_equal(whole.wrench, long.wrench)
    assert whole.stats.steps == long.stats.steps


@pytest.mark.parametrize("method", ["rk4", "euler"])
@pytest.mark.parametrize(("start", "step"), [(0.0, 1 / 256), (7.1, 0.003), (1e6, 0.005)])
def test_extend_from_inside_a_step(method: str, start: float, step: float) -> None:
    """A run that ends inside a step, or at a time that is rounded beside its late start, goes on with the same steps."""
    solver = {"solver.method": method, "solver.step": step}
    scene = pp.load_scene(EXAMPLES / "double_pendulum.toml").replace(solver | {"start.time": start})
    run, long = (pp.simulate(scene, duration=duration) for duration in (1.3, 2.0))
    whole = run.extend(0.7)
    np.testing.assert_array_equal(whole.t, long.t)
    np.testing.assert_array_equal(whole.q, long.q)
    np.testing.assert_array_equal(whole.v, long.v)


def test_a_saved_run_goes_on_too(tmp_path: Path) -> None:
    """From what its file holds."""
    run = pp.simulate(SCENES["smooth"], samples=31)
    again = pp.Trajectory.load(run.save(tmp_path / "run.npz"))
    np.testing.assert_array_equal(again.at(1.2345).q, run.at(1.2345).q)


def test_a_saved_run_of_code_goes_on_with_its_scene(tmp_path: Path) -> None:
    """No file holds a function: the scene is given again, and has to be the same."""
    brake = pp.effects.Torque(lambda t, q, v: -0.3 * v, joints=["theta"])
    scene = SCENES["smooth"].replace(effects=[GRAVITY, brake])
    run = pp.simulate(scene, samples=31, duration=1.0)
    path = run.save(tmp_path / "run.npz")
    alone = pp.Trajectory.load(path)
    assert alone == run
    with pytest.raises(pp.InputError, match=r"cannot be built again: .* Trajectory.load\(path, scene=scene\)"):
        alone.at(0.5)
    again = pp.Trajectory.load(path, scene=scene)
    np.testing.assert_array_equal(again.at(0.5).q, run.at(0.5).q)
    assert again.extend(0.5).t[-1] == 1.5
    with pytest.raises(pp.InputError, match="are not those of the run"):
        pp.Trajectory.load(path, scene=scene.replace({"model.rods[0].mass": 2.0}))


def test_what_is_no_time_is_refused() -> None:
    """Outside, falling, not numbers; names, levels and directions too."""
    run = pp.simulate(SCENES["smooth"], samples=31)
    for times in (-0.1, 3.1, [1.0, 0.5], [], "soon", np.nan, [[1.0]]):
        with pytest.raises(pp.InputError, match="times: "):
            run.at(times)
    for times, says in [(np.nan, "times: nan is not"), ([0.0, np.nan], r"times\[1\]: nan is not a finite number")]:
        with pytest.raises(pp.InputError, match=says):
            run.at(times)
    with pytest.raises(pp.InputError, match=r"times\[1\]: nan is not a finite number"):
        pp.simulate(SCENES["smooth"], times=[0, np.nan])
    for arguments, says in [
        (("thets",), "did you mean 'theta'"),
        (("theta", np.nan), "level"),
        (("theta", 0.0, 2), "direction"),
    ]:
        with pytest.raises(pp.InputError, match=says):
            run.crossings(*arguments)
    for duration in (0, -1.0, np.inf, "1"):
        with pytest.raises(pp.InputError, match="duration"):
            run.extend(duration)


def test_names_and_tables(tmp_path: Path) -> None:
    """Every name is a column: in the CSV with all digits, in pandas, in [...]."""
    run = pp.simulate(SCENES["thin chain"], samples=7, energy_balance=True)
    assert {"t", "theta_1", "phi_2_rate", "R3_2", "tip_x", "tip_z_1", "kinetic", "energy", "work_gravity"} <= set(
        run.names
    )
    np.testing.assert_array_equal(run["R3_2"], run.reactions().R3[:, 1])
    np.testing.assert_array_equal(run["tip_x"], run.tips[:, -1, 0])
    assert run.tips.shape[1] == 2
    np.testing.assert_array_equal(run["tip_x_2"], run["tip_x"])
    assert "tip_x_2" not in run.names
    assert run.maximum("tip_z_2") == run.maximum("tip_z")
    np.testing.assert_array_equal(run["energy"], run.energy().total)
    with run.to_csv(tmp_path / "run.csv").open() as file:
        head, *rows = csv.reader(file)
    assert tuple(head) == run.names
    np.testing.assert_array_equal(np.array(rows, float), np.array([run[name] for name in run.names]).T)
    assert all(run[name].shape == (7,) for name in run.names)
    single = pp.simulate(SCENES["smooth"], samples=2)
    np.testing.assert_array_equal(single["theta_1"], single["theta"])
    np.testing.assert_array_equal(single["R3_1"], single["R3"])
    pandas = pytest.importorskip("pandas")
    table = run.to_pandas()
    assert isinstance(table, pandas.DataFrame)
    np.testing.assert_array_equal(table["theta_1"].to_numpy(), run["theta_1"])


def test_summary_of_a_known_swing() -> None:
    """A plane swing of 0.1 rad: its angle, its period by the elliptic integral, its tension by energy."""
    g, angle = 9.81, 0.1
    scene = pp.Scene(model={"kind": "chain", "rods": [{"length": 1.0, "mass": 0.0, "payload": 1.0}]}, effects=[GRAVITY])
    found = pp.simulate(scene.replace(start=pp.Start(positions={"phi": angle})), duration=20.0).summary()
    assert found["largest swing"].value == pytest.approx(np.degrees(angle), rel=1e-8)
    from scipy.special import ellipk

    assert found["period of phi"].value == pytest.approx(4 / np.sqrt(g) * ellipk(np.sin(angle / 2) ** 2), rel=1e-4)
    assert found["R3 largest"].value == pytest.approx(g * (3 - 2 * np.cos(angle)), rel=1e-4)
    assert "largest swing" in repr(found)
    assert not [
        name for name in found if name[:2] in ("R1", "R2", "M1", "M2", "M3")
    ]  # of a point mass they are rounding


def test_extremes_after_half_the_time_do_not_depend_on_the_samples() -> None:
    """A damped rod shown at its start and end alone, or at more times: half the time is that of the run."""
    effects, start = [GRAVITY, pp.effects.Viscous(coefficient=0.05)], pp.Start(positions={"theta": 1.0})
    scene = pp.Scene(model=builtin_scene().model, effects=effects, start=start, duration=10.0)
    many, *others = (pp.simulate(scene, samples=count).summary() for count in (1001, 2, 3, 4))
    for few in others:
        for name in ("largest swing, second half", "farthest sideways, second half"):
            assert few[name].value == pytest.approx(many[name].value, rel=1e-7)
            assert few[name].time == pytest.approx(many[name].time, rel=1e-4)


def test_the_largest_swing_is_that_of_the_line_to_the_tip() -> None:
    """Of several rods too: a rod may turn over while the line from the support to the last tip does not."""
    rods = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01), pp.Rod(length=0.2, mass=0.1, radius=0.01)])
    scene = pp.Scene(model=rods, start=pp.Start(positions={"theta_2": 3.0}), effects=[GRAVITY], duration=2.0)
    run = pp.simulate(scene)
    assert run.summary()["largest swing"].value == pytest.approx(np.degrees(run.maximum("swing").value))
    assert run.summary()["largest swing"].value < 90 < np.degrees(np.abs(run["theta_2"]).max())


def test_a_period_is_said_only_of_a_motion_that_has_one() -> None:
    """The rod's swings differ from one to the next: their mean lies in the range that is said with it."""
    found = pp.simulate(builtin_scene()).summary()
    assert not any(name.startswith("period") for name in found)
    for joint in ("theta", "phi"):
        figure = found[f"mean period of {joint}"]
        words = figure.place.split()
        assert float(words[1]) < figure.value < float(words[3])
        assert "not periodic" in str(figure)


def test_configurations() -> None:
    """Pinocchio's own functions take what a run gives, continuous joints as cosine and sine."""
    import pinocchio as pin

    model = pin.Model()
    for name in ("theta", "phi"):
        model.addJoint(model.njoints - 1, pin.JointModelRUBX(), pin.SE3.Identity(), name)
    run = pp.simulate(builtin_scene(), duration=0.1)
    q = run.configurations(model)
    assert q.shape == (len(run.t), 4)
    np.testing.assert_allclose(np.arctan2(q[:, 1], q[:, 0]), run.q[:, 0], atol=1e-15)
    with pytest.raises(pp.InputError, match="no joint 'theta'"):
        run.configurations(pin.buildSampleModelManipulator())


def test_a_controller_is_a_function() -> None:
    """It is the same as the effect that says so; its work is computed; what it returns is checked."""
    damped, own = (
        SCENES["smooth"].replace(effects=[GRAVITY, effect])
        for effect in (
            pp.effects.Viscous(coefficient=0.3, joints=["theta"]),
            pp.effects.Torque(lambda t, q, v: -0.3 * v, joints=["theta"]),
        )
    )
    one, other = (pp.simulate(scene, samples=31, energy_balance=True) for scene in (damped, own))
    np.testing.assert_allclose(other.q, one.q, atol=1e-8)
    np.testing.assert_allclose(other["work_torque"], one["work_viscous"], atol=1e-8)
    for bad in (lambda t, q, v: np.nan * v, lambda t, q, v: [1.0, 2.0], lambda t, q, v: "none", lambda t, q, v: None):
        with pytest.raises(pp.InputError, match="its function returned"):
            pp.simulate(own.replace(effects=[pp.effects.Torque(bad, joints=["theta"])]))


def test_particular_starts() -> None:
    """A cone keeps its height; an equilibrium keeps its place."""
    scene = pp.Scene(model={"kind": "chain", "rods": [{"length": 1.0, "mass": 1.0}]}, effects=[GRAVITY], duration=5.0)
    cone = pp.simulate(scene.replace(start=pp.Start.conical(scene, angle=0.5)))
    np.testing.assert_allclose(cone["tip_z"], -np.cos(0.5), atol=1e-8)
    windy = SCENES["damped"].replace(effects=[GRAVITY, pp.effects.Drag(diameter=0.05, wind=(6.0, 2.0, 0.0))])
    rest = pp.simulate(windy.replace(start=pp.Start.at_rest(windy)))
    np.testing.assert_allclose(rest.q, np.tile(rest.q[0], (len(rest.t), 1)), atol=1e-7)
    assert np.abs(rest.q[0]).max() > 0.01
    with pytest.raises(pp.InputError, match="a chain of one rod"):
        pp.Start.conical(windy, angle=0.5)


def test_runs_of_no_sample_and_of_the_start_alone(tmp_path: Path) -> None:
    """Where nothing was crossed there is nothing to draw, save or continue; a run of its start alone goes on."""
    none = pp.simulate(SCENES["damped"], samples=31, energy_balance=True).crossings("theta_1", level=50.0)
    assert (len(none.t), none.energy().drift, none.imbalance) == (0, 0.0, 0.0)
    for asked in (none.plot, none.animate, lambda: none.save(tmp_path / "a.npz"), lambda: none.extend(1.0)):
        with pytest.raises(pp.InputError, match="no samples, as nothing was crossed"):
            asked()
    assert none.plot("theta_1") is not None
    assert not list(tmp_path.iterdir())
    start = pp.simulate(builtin_scene(), times=[0.0])
    assert start.extend(1.0).t.tolist() == [0.0, 1.0]


def test_a_model_of_pinocchios_own() -> None:
    """A pin.Model with continuous joints moves like the URDF that it was read from."""
    import pinocchio as pin

    named = pp.UrdfModel("double_pendulum_continuous")
    own, model = (
        pp.Scene(model=m, effects=[GRAVITY], duration=1.0) for m in (pin.buildModelFromUrdf(str(named.file)), named)
    )
    start = {"start.velocities": {pp.bind(model).model.joints[0]: 1.0}}
    one, other = (pp.simulate(scene.replace(start)) for scene in (own, model))
    np.testing.assert_allclose(one.q, other.q, atol=1e-9)
    np.testing.assert_allclose(one.at(0.3).q, other.at(0.3).q, atol=1e-9)
    assert one.configurations(own.model.pin).shape == (61, 4)
    assert "<iframe" in one._repr_html_()
    scattered = pin.Model()
    for name, parent in (("root", 0), ("other", 0), ("leaf", 1)):  # of which Pinocchio's mass matrix is wrong
        scattered.addJoint(parent, pin.JointModelRX(), pin.SE3.Identity(), name)
        scattered.appendBodyToJoint(scattered.njoints - 1, pin.Inertia.Random(), pin.SE3.Identity())
    bad_models = {"takes revolute": pin.buildSampleModelHumanoid(), "no joint": pin.Model()}
    for says, bad in (bad_models | {"leaf.*each branch .* in one go": scattered}).items():
        with pytest.raises(pp.InputError, match=says):
            pp.simulate(pp.Scene(model=bad, effects=[GRAVITY]))
    with pytest.raises(pp.InputError, match="cannot be written"):
        own.save("scene.toml")


def test_the_model_carries_the_scenes_gravity() -> None:
    """Pinocchio's aba on it is what the dynamics compute."""
    import pinocchio as pin

    dynamics = pp.bind(SCENES["smooth"])
    q, v = np.array([0.3, -0.2]), np.array([1.0, 0.5])
    model = dynamics.model.pin
    np.testing.assert_allclose(
        pin.aba(model, model.createData(), q, v, np.zeros(2)), dynamics.acceleration(0.0, q, v), rtol=1e-14
    )


def test_copies_of_a_run_are_read_only() -> None:
    """As the run is: what was computed from its arrays stays true."""
    run = pp.simulate(SCENES["friction"], samples=7, energy_balance=True)
    for one in (pickle.loads(pickle.dumps(run)), copy.copy(run), copy.deepcopy(run)):
        assert one == run
        assert not any(array.flags.writeable for array in [*one.arrays.values(), *one.held])


def test_a_run_is_asked_like_a_mapping() -> None:
    """`in` says whether run[name] is there; the names come in order; other things are no names."""
    run = pp.simulate(SCENES["smooth"], samples=7)
    assert list(run) == list(run.names) == run._ipython_key_completions_()
    assert all(name in run for name in [*run, "energy_drift", "effort_gravity_theta"])
    assert not any(name in run for name in ("thetta", 0, None, ["theta"]))
    for wrong in (["theta"], 0, None, {}):
        with pytest.raises(pp.errors.InputError, match="not the name of a quantity"):
            run[wrong]

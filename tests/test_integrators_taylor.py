"""The Taylor integrator."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import pendpin as pp
from effect_cases import EFFECTS, MODELS
from pendpin import effects as fx
from pendpin.equations import recursion
from pendpin.equations.chain import thin
from pendpin.equations.exact import direction, direction_rate, planar, spherical
from pendpin.model.build import build
from test_integrators import SHAKEN, THICK, THIN, TWO, apart, needs_heyoka, scene

# --- Taylor ---------------------------------------------------------------------------------------------------------


@needs_heyoka
class TestTaylor:
    """The series, against what is known exactly and against Runge-Kutta on Pinocchio's equations."""

    def test_planar_swing_is_the_elliptic_one(self):
        run = pp.simulate(
            scene(THIN, q=(0.9, 0.0), v=(0.5, 0.0), duration=100.0, samples=6), method="taylor", tolerance=1e-18
        )
        angle = planar(0.9, 0.5, 2 / 3, 9.81, run.t)
        turned = 100.0 * np.sqrt(9.81 * 1.5)  # rad, of its phase, whose rounding the elliptic functions repeat
        assert np.abs(2 * np.sin((run.q[:, 0] - angle) / 2)).max() < 4 * np.finfo(float).eps * turned

    def test_spherical_swing_is_the_elliptic_one(self):
        run = pp.simulate(scene(THIN, duration=100.0, samples=2001), method="taylor", tolerance=1e-18)
        start = direction([0.7, 0.4]), direction_rate([0.7, 0.4], [1.3, -0.8])
        some = slice(None, None, 50)  # the elliptic functions take longer than the run
        assert np.abs(run.tips[some, 0] - spherical(*start, 2 / 3, 9.81, run.t[some])).max() < 2e-13
        assert run.stats.compile_seconds > 0
        assert run.stats.steps > 100
        assert run.stats.evaluations == run.stats.steps

    @pytest.mark.parametrize("rods", [1, 2])
    def test_a_thin_chain_through_the_pole(self, rods: int):
        """Straight through phi = pi/2, where the angles are at fault: the tips are those of the directions."""
        model = pp.Chain(rods=THIN.rods * rods)
        given = scene(model, q=(0.3, 1.2), v=(0.0, 6.0), duration=2.0, samples=9)
        run = pp.simulate(given, method="taylor", tolerance=1e-16)
        assert apart(run, pp.simulate(given, tolerance=1e-13)) < 1e-10

    CASES = (
        ("one rod", "viscous"),
        ("one rod", "sinusoid motor"),
        ("one rod", "push and torque"),
        ("one rod", "support"),
    )
    CASES += (("thin rod", "rotation"), ("thin chain of 3", "push"))

    @pytest.mark.parametrize(("model", "effect"), CASES)
    def test_effects_vs_dop853(self, model: str, effect: str):
        given = scene((MODELS | {"thin rod": THIN})[model], EFFECTS[effect], samples=4)
        run = pp.simulate(given, method="taylor", tolerance=1e-13)
        assert apart(run, pp.simulate(given, tolerance=1e-13)) < 2e-12

    def test_two_rods_vs_dop853(self):
        given = scene(TWO, SHAKEN)
        assert apart(pp.simulate(given, method="taylor", tolerance=1e-13), pp.simulate(given, tolerance=1e-13)) < 2e-12

    def test_stretches_leave_no_trace(self):
        """Many samples, in many segments, or few: the same end to rounding."""
        ends = [
            pp.simulate(scene(THIN, duration=20.0, samples=n), method="taylor", tolerance=1e-16).tips[-1]
            for n in (2, 1201)
        ]
        assert np.abs(ends[0] - ends[1]).max() < 1e-13

    def test_series_of_ended_runs_are_used_again(self):
        """From other starts, one after the other and in threads: every run has the bits of the first of its kind."""
        given = [scene(THIN, duration=d, q=(0.1 + d, 0.4), samples=90) for d in (1.0, 2.0, 3.0, 4.0)]
        alone = [pp.simulate(one, method="taylor", tolerance=1e-12) for one in given]
        with ThreadPoolExecutor(4) as pool:
            again = list(pool.map(lambda one: pp.simulate(one, method="taylor", tolerance=1e-12), given * 3))
        assert again == alone * 3

    def test_refuses_what_is_not_smooth(self):
        with pytest.raises(pp.InputError, match=r"effects\[1\]: drag is not smooth, and solver.method: taylor needs"):
            pp.simulate(scene(THICK, fx.Drag()), method="taylor")

    def test_refuses_long_chains(self):
        with pytest.raises(pp.InputError, match="up to 10 rods"):
            pp.simulate(scene(pp.Chain(rods=THICK.rods * 11)), method="taylor")


def test_taylor_without_heyoka_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "heyoka", None)
    with pytest.raises(pp.MissingLibrary, match="pip install heyoka"):
        pp.simulate(scene(THIN), method="taylor")


@pytest.mark.parametrize("rods", [1, 2, 5])
def test_thin_recursion_vs_reactions_as_unknowns(rods: int) -> None:
    """The articulated thin chain against the banded system, with forces and moments on the rods."""
    random = np.random.default_rng(rods)
    rod = pp.Rod(length=0.8, mass=1.3, payload=0.4)
    chain = build(pp.Chain(rods=(pp.Rod(length=1.0, mass=0.0, payload=1.0), *(rod,) * (rods - 1)))).chain
    assert chain is not None
    d, rate, force, moment = random.normal(size=(4, rods, 3))
    d, rate = thin.project_to_sphere(d, rate)
    moment -= d * (d * moment).sum(-1, keepdims=True)
    moment[0] = 0  # on a point mass
    field = random.normal(size=3)
    found, _ = recursion.thin_turning(chain, d, rate, field, force, moment)
    expected = np.cross(d, thin.solve(chain, d, rate, field, force=force, moment=moment).acceleration)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())

"""Laws of scenes with several stops and frictions on one joint."""

from typing import Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from pendpin import effects as fx
from pendpin.effects import ContactEffect
from test_scene_laws import CONTACTS, LEAN, ROD, START, TWO

# --- stops and friction on one joint --------------------------------------------------------------------------------

SIDES = st.tuples(st.floats(0.2, 0.7), st.sampled_from([0.0, 0.25, 1.0]))


@LEAN
@given(st.lists(st.tuples(st.booleans(), *(SIDES,) * 2), min_size=1, max_size=4), st.randoms())
def test_each_side_has_the_restitution_of_its_tighter_stop(stops: list[Any], random: Any) -> None:
    """Any stops on one joint, one- or two-sided, act as the tightest of each side; of equal ones the deader one does."""
    effects = [fx.Stop(lower=-low[0], restitution=low[1]) for _, low, _ in stops]
    effects += [fx.Stop(upper=high[0], restitution=high[1]) for both, _, high in stops if both]
    effects += [fx.Stop(lower=-9.0, upper=high[0], restitution=high[1]) for both, _, high in stops if not both]
    random.shuffle(effects)
    contacts = pp.bind(pp.Scene(model=pp.Chain(rods=(ROD,)), effects=tuple(effects))).contacts
    assert contacts is not None
    for side, tightest in enumerate((min(low for _, low, _ in stops), min(high for _, _, high in stops))):
        assert (contacts.lower, contacts.upper)[side].tolist() == [(-1, 1)[side] * tightest[0]] * 2
        assert contacts.restitution[side].tolist() == [tightest[1]] * 2


@pytest.mark.parametrize("turned", [False, True])
def test_the_two_sides_bounce_as_they_say(turned: bool) -> None:
    """A plane pendulum between a lossless stop and a dead one: it leaves the first as fast as it came, not the second."""
    stops = [fx.Stop(lower=-0.3, restitution=1.0, joints=("theta",)), fx.Stop(upper=0.2, joints=("theta",))]
    scene = pp.Scene(
        duration=1.0,
        model=pp.Chain(rods=(ROD,)),
        start=pp.Start(velocities={"theta": -2.0}),
        effects=tuple(stops[:: -1 if turned else 1]),
        solver=pp.Solver(samples=1001),
    )
    run = pp.simulate(scene)
    assert run.v[200, 0] == pytest.approx(2.0, rel=1e-9)  # struck the lower stop at 0.15 s
    assert run.q[-1, 0] == pytest.approx(0.2, abs=1e-12)
    assert run.v[-1, 0] == 0.0


def test_stops_that_exclude_each_other_are_refused_by_name() -> None:
    """One line with both effects, the joint, and what each wants; equal limits leave no room either."""
    for lower in (0.4, -0.5):
        effects = (fx.Gravity(), fx.Stop(lower=lower, joints=("theta",)), fx.Stop(lower=-0.9, upper=-0.5))
        says = (
            rf"effects\[1\] and effects\[2\]: their stops leave joint 'theta' no room: .* above {lower}, .* below -0.5$"
        )
        with pytest.raises(pp.InputError, match=says):
            pp.bind(pp.Scene(model=pp.Chain(rods=(ROD,)), effects=effects))


@pytest.mark.parametrize("kind", [fx.DryFriction, fx.Stop, fx.Viscous, fx.Spring])
@pytest.mark.parametrize(
    ("joints", "says"),
    [
        (("theta", "theta"), "joints: 'theta' is named twice"),
        ((), "joints: 0 values, where at least 1 are wanted"),
        (("theta", "theta_1"), "a joint is named twice: 'theta', 'theta_1'"),
        (("knee",), "joint 'knee' is not one of: theta, phi"),
    ],
)
def test_lists_of_joints_are_checked_alike(kind: Any, joints: tuple[str, ...], says: str) -> None:
    """Whatever the effect: no joint twice by one name or two, none left out by an empty list, none unknown."""
    needs: dict[Any, dict[str, float]] = {
        fx.DryFriction: {"kinetic": 0.1},
        fx.Stop: {"lower": -1.0},
        fx.Viscous: {"coefficient": 0.1},
        fx.Spring: {"stiffness": 0.1},
    }
    with pytest.raises(pp.InputError, match=says):
        pp.bind(pp.Scene(model=pp.Chain(rods=(ROD,)), effects=(kind(**needs[kind], joints=joints),)))


class Clutch(ContactEffect):
    """A contact effect of a user's own: it rubs, and stops."""

    kind: Literal["clutch"] = "clutch"

    def resistance(self) -> tuple[float, float]:
        """As `ContactEffect.resistance`."""
        return 0.04, 0.06

    def limits(self) -> tuple[float, float, float]:
        """As `ContactEffect.limits`."""
        return -0.3, 0.55, 0.6


@pytest.mark.parametrize("others", [(), CONTACTS[1:2], CONTACTS[3:4], (CONTACTS[1], CONTACTS[3])])
def test_contact_effects_of_ones_own_have_their_work(others: tuple[Any, ...]) -> None:
    """Alone and beside pendpin's own: the works add up, and each that rubs or is struck takes energy."""
    effects = (fx.Gravity(), Clutch(), *others)
    scene = pp.Scene(duration=1.0, model=TWO, start=START, effects=effects, solver=pp.Solver(samples=21))
    run = pp.simulate(scene, tolerance=1e-10, energy_balance=True)
    assert run.imbalance < 1e-7
    assert run.work["clutch"][-1] < -1e-3
    assert all(run.work[effect.kind][-1] < 0 for effect in others)

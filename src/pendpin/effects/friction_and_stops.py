"""Dry friction and stops, which act through events (dynamics/contacts.py)."""

import math
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, Strict, model_validator

from pendpin.effects.base import Effect, JointNames
from pendpin.ground.arrays import Array
from pendpin.ground.records import NotNegative, Number, Positive


class ContactEffect(JointNames, Effect):
    """An effect that can hold a joint at rest and acts at events."""

    @property
    def smooth(self) -> bool:
        """False: sticking and impacts are not."""
        return False

    @property
    def symbolic(self) -> bool:
        """True: between two events."""
        return True

    def resistance(self) -> tuple[float, float]:
        """The torque against sliding, and the largest that holds, in N m."""
        return 0.0, 0.0

    def limits(self) -> tuple[float, float, float]:
        """Lower and upper limit of the position in rad, and the restitution there."""
        return -math.inf, math.inf, 0.0


class DryFriction(ContactEffect):
    """Coulomb friction: -kinetic sign(v) on a joint that slides; one at rest sticks, exactly, up to the static limit.

    With `stribeck`, a speed v_s, friction falls from the static to the kinetic value as a joint slides faster:
    -(kinetic + (static - kinetic) exp(-(v / v_s)²)) sign(v) (B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit,
    Automatica 30 (1994), 1083). kinetic is in N m. static is in N m, by default (and at least) kinetic. stribeck is in
    rad/s; without it friction does not change with speed. joints are named (default: all). Friction matters if a joint
    comes to rest, and in every small swing.
    """

    strengths: ClassVar[tuple[str, ...]] = ("kinetic", "static")
    parameters: ClassVar[tuple[str, ...]] = ("kinetic", "static", "stribeck")
    kind: Literal["dry_friction"] = Field("dry_friction", description="which effect it is")
    kinetic: NotNegative = Field(description="N m, against sliding")
    static: NotNegative | None = Field(None, description="N m; kinetic if absent")
    stribeck: Positive | None = Field(None, description="rad/s, the speed over which friction falls to kinetic")

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.static is not None and self.static < self.kinetic:
            raise ValueError(f"static, {self.static:g} N m, is below kinetic, {self.kinetic:g} N m")
        if self.stribeck is not None and self.static is None:
            raise ValueError("stribeck needs static: the friction at rest, from which it falls to kinetic")
        return self

    @property
    def resistances(self) -> tuple[str, ...]:
        """All its numbers where it falls with speed, else what acts while a joint slides."""
        return self.parameters if self.stribeck is not None else ("kinetic",)

    def resistance(self) -> tuple[float, float]:
        return self.kinetic, self.kinetic if self.static is None else self.static

    def sliding(self, v: Array, xp: Any = np) -> Array:
        """The friction torque in N m at rates v in rad/s, both (k,)."""
        if self.stribeck is None or self.static is None:
            return self.kinetic + 0.0 * v
        return self.kinetic + (self.static - self.kinetic) * xp.exp(-((v / self.stribeck) ** 2))


class Stop(ContactEffect):
    """Limits of a joint's position; at a limit the rate is reversed and multiplied by the restitution.

    lower and upper are in rad. The restitution is from 0 (no rebound) to 1 (no energy lost). joints are named (default:
    all). Bounces too small to tell apart end in rest on the stop.
    """

    kind: Literal["stop"] = Field("stop", description="which effect it is")
    lower: Number | None = Field(None, description="rad; none if absent")
    upper: Number | None = Field(None, description="rad; none if absent")
    restitution: Annotated[Number, Field(ge=0, le=1)] = Field(
        0.0, description="rate after an impact over the rate before: 0 without rebound, 1 without loss"
    )

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.lower is None and self.upper is None:
            raise ValueError("a stop needs lower, upper or both")
        lower, upper, _ = self.limits()
        if lower >= upper:
            raise ValueError(f"lower, {lower:g} rad, is not below upper, {upper:g} rad")
        return self

    def limits(self) -> tuple[float, float, float]:
        """lower and upper in rad, infinite where absent, and the restitution."""
        lower = -math.inf if self.lower is None else self.lower
        return lower, math.inf if self.upper is None else self.upper, self.restitution


class AsWritten(Effect):
    """The damping, friction and limits that a URDF writes at its joints, as the effects viscous, dry_friction and stop.

    <dynamics damping> in N m s/rad, <dynamics friction> in N m, <limit lower upper> in rad (N s/m, N and m for a
    prismatic joint); restitution is 0. Where the start names no position, a joint whose limits leave out 0 begins at the
    nearer one. Effort and velocity limits belong to motors, and a URDF has none.
    """

    kind: Literal["as_written"] = Field("as_written", description="which effect it is")
    damping: Annotated[bool, Strict()] = Field(True, description="whether <dynamics damping> acts")
    friction: Annotated[bool, Strict()] = Field(True, description="whether <dynamics friction> acts")
    limits: Annotated[bool, Strict()] = Field(True, description="whether <limit lower upper> acts")

    @property
    def smooth(self) -> bool:
        """Whether it is damping alone: friction and stops are not smooth."""
        return not (self.friction or self.limits)

    @property
    def idle(self) -> bool:
        return not (self.damping or self.friction or self.limits)

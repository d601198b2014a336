"""What a URDF says of its joints, taken at its word: its <dynamics> and <limit> (dynamics/as_written.py)."""

from typing import Annotated, Literal

from pydantic import Field, Strict

from pendpin.effects.base import Effect

Flag = Annotated[bool, Strict()]


class AsWritten(Effect):
    """The damping, friction and limits that a URDF writes at its joints, as the effects viscous, dry_friction and stop.

    <dynamics damping> in N m s/rad, <dynamics friction> in N m, <limit lower upper> in rad (N s/m, N and m for a
    prismatic joint); restitution is 0. Where the start names no position, a joint whose limits leave out 0 begins at the
    nearer one. Effort and velocity limits belong to motors, and a URDF has none.
    """

    kind: Literal["as_written"] = Field("as_written", description="which effect it is")
    damping: Flag = Field(True, description="whether <dynamics damping> acts")
    friction: Flag = Field(True, description="whether <dynamics friction> acts")
    limits: Flag = Field(True, description="whether <limit lower upper> acts")

    @property
    def smooth(self) -> bool:
        """Whether it is damping alone: friction and stops are not smooth."""
        return not (self.friction or self.limits)

    @property
    def idle(self) -> bool:
        """Whether nothing of it acts."""
        return not (self.damping or self.friction or self.limits)

"""Bodies in a vertical plane that links carry: accelerations, energies and positions of one pendulum, two, or one on a cart.

Each link turns by an angle, the sum of some coordinates, from one of POSES; the first may slide instead.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from pendpin.doctor.systems.base import Formula, Quantities, Values

SLIDES = "1"  # the length of a link that slides: a horizontal arm of length 1 that does not turn
# from where angles are measured, in words, and functions of an angle: how far to the side and up the end of a unit link
# is, and how fast it rises
POSES = {
    "down": ("the vertical", lambda xp, x: (xp.sin(x), -xp.cos(x), xp.sin(x))),
    "up": ("upright", lambda xp, x: (xp.sin(x), xp.cos(x), -xp.sin(x))),
    "horizontal": ("the horizontal", lambda xp, x: (xp.cos(x), xp.sin(x), xp.cos(x))),
}


@dataclass(frozen=True)
class Linkage:
    """`links` are the coordinates whose sum is each link's angle; `bodies` a mass, an inertia about G, and lengths to G.

    Those lengths are along each link up to the body's own. `forces` are the loads on the coordinates, "" for none.
    """

    coordinates: tuple[str, ...]
    links: tuple[tuple[str, ...], ...]
    bodies: tuple[tuple[str, str, tuple[str, ...]], ...]
    pose: str = "down"
    mirrored: bool = False  # the angle is positive where the pendulum is at negative x
    forces: tuple[str, ...] = ()

    def _slides(self, link: int) -> bool:
        return self.bodies[-1][2][link] == SLIDES

    def _turning(self) -> Iterator[int]:
        """The links that turn."""
        return (link for link in range(len(self.links)) if not self._slides(link))

    def _angle(self, q: Quantities, link: int, rate: str = "") -> Values:
        """The angle of a link, or its rate for "d"; a link that slides has the angle 0."""
        zero = q.number(0)
        return zero if self._slides(link) and not rate else sum((q[rate + name] for name in self.links[link]), zero)

    def _end(self, q: Quantities, link: int) -> tuple[Values, Values, Values]:
        """How far to the side and up the end of a link of length 1 is, and how fast it rises with the angle."""
        return POSES[self.pose][1](q.xp, self._angle(q, link))

    def _carried(self, q: Quantities, *links: int) -> Values:
        """The masses that all of some links carry, each times its length along each of them."""
        total = q.number(0)
        for mass, _, lengths in self.bodies:
            if max(links) < len(lengths):
                product = q[mass]
                for name in (lengths[link] for link in links if lengths[link] != SLIDES):
                    product = product * q[name]
                total = total + product
        return total

    def _side(self, *links: int) -> int:
        """-1 where an angle that is positive the other way meets the direction in which the first link slides."""
        return -1 if self.mirrored and len({self._slides(link) for link in links}) > 1 else 1

    def _inertia(self, q: Quantities, i: int, j: int) -> Values:
        """An entry of the mass matrix of the links."""
        off = self._side(i, j) * self._carried(q, i, j) * q.xp.cos(self._angle(q, i) - self._angle(q, j))
        inertias = (inertia for _, inertia, lengths in self.bodies if i == j == len(lengths) - 1 and inertia)
        return sum((q[name] for name in inertias), off)

    def mass(self, first: str, second: str) -> Formula:
        """An entry of the mass matrix of the coordinates."""

        def value(q: Quantities) -> Values:
            rows = [i for i, names in enumerate(self.links) if first in names]
            columns = [j for j, names in enumerate(self.links) if second in names]
            return sum((self._inertia(q, i, j) for i in rows for j in columns), q.number(0))

        return value

    def _force(self, q: Quantities, link: int) -> Values:
        """What the weight and the turning of all links exert on one."""
        total = q.number(0)
        if not self._slides(link):
            total = -q["g"] * self._carried(q, link) * self._end(q, link)[2]
        for other in (k for k in self._turning() if k != link):
            turn = q.xp.sin(self._angle(q, link) - self._angle(q, other)) * self._angle(q, other, "d") ** 2
            total = total - self._side(link, other) * self._carried(q, link, other) * turn
        return total

    def solve(self, q: Quantities) -> dict[str, Values]:
        """The accelerations of the one or two coordinates."""
        right = []
        for i, name in enumerate(self.coordinates):
            pull = (self._force(q, link) for link, names in enumerate(self.links) if name in names)
            load = self.forces[i] if self.forces else ""
            right.append(sum(pull, q[load] if load else q.number(0)))
        first, *others = self.coordinates
        a = self.mass(first, first)(q)
        if not others:
            return {f"dd{first}": right[0] / a}
        b, d = self.mass(first, others[0])(q), self.mass(others[0], others[0])(q)
        det = a * d - b * b
        return {
            f"dd{first}": (d * right[0] - b * right[1]) / det,
            f"dd{others[0]}": (a * right[1] - b * right[0]) / det,
        }

    def momentum(self, name: str) -> Formula:
        """The momentum of a coordinate."""
        return lambda q: sum((self.mass(name, other)(q) * q[f"d{other}"] for other in self.coordinates), q.number(0))

    def kinetic(self, q: Quantities) -> Values:
        """The kinetic energy."""
        return sum((self.momentum(name)(q) * q[f"d{name}"] for name in self.coordinates), q.number(0)) / q.number(2)

    def potential(self, q: Quantities) -> Values:
        """The potential energy, 0 where all links are horizontal."""
        heights = (self._carried(q, link) * self._end(q, link)[1] for link in self._turning())
        return q["g"] * sum(heights, q.number(0))

    def place(self, axis: str, lengths: tuple[str, ...]) -> Formula:
        """x, or y upwards, of the end of some lengths along the links."""
        side = -1 if self.mirrored else 1

        def value(q: Quantities) -> Values:
            total = q["x"] if axis == "x" and self._slides(0) else q.number(0)
            for link in (k for k in self._turning() if k < len(lengths)):
                across, height, _ = self._end(q, link)
                total = total + q[lengths[link]] * (side * across if axis == "x" else height)
            return total

        return value

"""Every system that the doctor knows, by its name in --system and --rod, and the special cases of each."""

from pendpin.doctor.systems import rod
from pendpin.doctor.systems.base import Spec

SPECS: dict[str, Spec] = dict(rod.SPECS)

_THIN, _POINT = r"\bthin\b|slender", r"point mass|\bbob\b|massless|string|simple pendulum"
_UNIFORM = r"uniform|cylinder|homogeneous"
_AXIAL = ("I3", "J3")
# for each kind: words, what it is then, how a text says it, and what an equation on it does not contain
SPECIAL: dict[str, tuple[tuple[str, Spec, str, tuple[str, ...]], ...]] = {
    "general": (
        ("I3 = 0 and I1 = I2, as for a thin rod", rod.slender(SPECS["symmetric"]), _THIN, _AXIAL),
        ("it is a uniform thin rod", SPECS["thin"], _THIN, (*_AXIAL, "h")),
        ("it is a uniform rod of radius r", SPECS["uniform"], _UNIFORM, ("h",)),
        ("I1 = I2", SPECS["symmetric"], r"symmetric|I_?1\s*=\s*I_?2", ("I1", "I2", "J1", "J2")),
        ("it is a point mass on a massless rod", SPECS["point"], _POINT, (*_AXIAL, "h")),
    ),
    "symmetric": (
        ("I3 = 0, as for a thin rod", rod.slender(SPECS["symmetric"]), _THIN, _AXIAL),
        ("it is a uniform thin rod", SPECS["thin"], _THIN, (*_AXIAL, "h")),
        ("it is a uniform rod of radius r", SPECS["uniform"], _UNIFORM, ("h",)),
        ("it is a point mass on a massless rod", SPECS["point"], _POINT, (*_AXIAL, "h")),
    ),
    "uniform": (
        ("it is a uniform thin rod", SPECS["thin"], _THIN, (*_AXIAL, "r")),
        ("it is a point mass on a massless rod", SPECS["point"], _POINT, (*_AXIAL, "r")),
    ),
    "thin": (
        ("it is a uniform rod of radius r", SPECS["uniform"], _UNIFORM, ()),
        ("it is a point mass on a massless rod", SPECS["point"], _POINT, ()),
    ),
    "point": (("it is a uniform thin rod", SPECS["thin"], _THIN, ()),),
}

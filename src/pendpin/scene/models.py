"""Models: rods, chains of rods, and URDF trees."""

from collections import Counter
from functools import cache, cached_property
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    InstanceOf,
    Tag,
    field_serializer,
    model_validator,
)
from pydantic.json_schema import SkipJsonSchema

from pendpin.equations.base import RodInertia
from pendpin.equations.rod_tree import JointKind
from pendpin.errors import InputError, MissingLibrary, nearest_or_all, not_one_of, shown
from pendpin.ground.records import LARGEST_SIZE, FilePath, FrozenDict, NotNegative, Number, Positive, Record, Vector

FOLDER = "share/example-robot-data/robots"
MAX_RODS = 100_000
MODEL_FILES = (".urdf", ".xacro", ".xml", ".mjcf")  # the last three are refused when they are read, with what to do

FARTHEST = 1e9  # rad, or m: positions of joints
Position = Annotated[Number, Field(ge=-FARTHEST, le=FARTHEST)]
Place = Annotated[Number, Field(ge=-LARGEST_SIZE, le=LARGEST_SIZE)]
Size = Annotated[NotNegative, Field(le=LARGEST_SIZE)]
Copies = Annotated[int, Field(strict=True, ge=1, le=MAX_RODS)]
OTHER_JOINTS = {  # what is asked for and not offered, with what serves
    "revolute": 'a revolute joint is called "hinge"',
    "continuous": 'a continuous joint is called "hinge"',
    "fixed": "a fixed joint makes one body: one rod with the com and inertia of both",
    "prismatic": "a chain's rods do not slide: a URDF's links do",
    "ball": "a thin rod (radius 0) on a universal joint is a spherical pendulum",
    "spherical": "a thin rod (radius 0) on a universal joint is a spherical pendulum",
}


def _offered_joint(value: Any) -> Any:
    """A name of a joint. Raises ValueError for one that is not offered, with what to use."""
    if isinstance(value, str) and value in OTHER_JOINTS:
        raise ValueError(f"{shown(value)} is not one of: universal, hinge; {OTHER_JOINTS[value]}")
    return value


class Rod(Record):
    """A rod in its body frame B: b3 runs along it, from its joint to its tip.

    A uniform cylinder unless `com` or `inertia` say otherwise. Radius 0 is a thin rod; mass 0 with a payload is a
    point mass on a massless rod.
    """

    length: Annotated[Positive, Field(le=LARGEST_SIZE)] = Field(description="m, from the joint to the tip")
    mass: Size = Field(description="kg, without the payload")
    radius: Size = Field(0.0, description="m; 0 is a thin rod")
    com: Place | None = Field(None, description="m, centre of mass from the joint along the rod; length/2 if absent")
    inertia: tuple[Size, Size, Size] | None = Field(
        None, description="kg m², central principal inertia (I1, I2, I3) without the payload; a uniform rod if absent"
    )
    payload: Size = Field(0.0, description="kg, mass at the tip")
    payload_radius: Size = Field(0.0, description="m, of the payload, a sphere about the tip; 0 is a point")
    copies: Copies = Field(1, description="how many such rods, one hanging on the other")
    joint: Annotated[Literal["universal", "hinge"], BeforeValidator(_offered_joint)] = Field(
        "universal", description="on which it turns: two angles, theta and phi, or one"
    )
    axis: Literal["x", "y"] | None = Field(
        None, description="of a hinge: theta turns about x, phi about y; x if absent"
    )
    hangs_on: str | None = Field(None, description='"rod_1", ... or "world"; if absent the rod before it, or the world')
    at: Size | None = Field(None, description="m along the rod that it hangs on, from its joint; the tip if absent")

    @property
    def turns(self) -> JointKind:
        """How the joint turns, as a universal joint or as a hinge about x or y."""
        return "universal" if self.joint == "universal" else self.axis or "x"

    @cached_property
    def properties(self) -> RodInertia:
        """Mass, centre of mass and central inertia with the payload folded in (docs/derivation.md)."""
        m, p, length = self.mass, self.payload, self.length
        h = length / 2 if self.com is None else self.com
        transverse = m * (3 * self.radius**2 + length**2) / 12
        I1, I2, I3 = self.inertia or (transverse, transverse, m * self.radius**2 / 2)
        if not p:
            return RodInertia(m, h, I1, I2, I3)
        ball = 2 / 5 * p * self.payload_radius**2
        lever = m * (p / (m + p)) * (length - h) ** 2  # the reduced mass at the distance between the two
        return RodInertia(m + p, h + (length - h) * (p / (m + p)), I1 + lever + ball, I2 + lever + ball, I3 + ball)

    @property
    def impossible(self) -> str | None:
        """Why no real body has this inertia (one principal value above the sum of the others), or None."""
        small, middle, large = sorted(self.inertia or (1.0, 1.0, 1.0))
        if large <= (small + middle) * (1 + 1e-12):
            return None
        return f"no real body has this inertia, {large:g} > {small:g} + {middle:g}; the equations hold all the same"

    @model_validator(mode="after")
    def _is_a_body(self) -> Self:
        if self.axis and self.joint == "universal":
            raise ValueError(f'axis = "{self.axis}" is of a hinge, and this joint is universal: add joint = "hinge"')
        if self.payload_radius and not self.payload:
            raise ValueError("payload_radius is of a payload, and there is none: give payload, in kg")
        if self.mass + self.payload == 0:
            raise ValueError("a rod needs a mass or a payload above 0")
        if self.inertia and self.inertia[2] == 0 and self.inertia[0] != self.inertia[1]:
            raise ValueError(f"inertia {list(self.inertia)}: a rod with no inertia about its axis has I1 = I2")
        m, h, I1, I2, _ = self.properties
        both = (I1 + m * h * h, I2 + m * h * h)
        about_joint = {"universal": both, "x": both[:1], "y": both[1:]}[self.turns]
        if min(about_joint) < 1 / LARGEST_SIZE or max(about_joint) > LARGEST_SIZE:
            odd = f"the inertia about the joint, {min(about_joint):g} kg m², is out of range (1e-100 to 1e100)"
            raise ValueError(f"{odd}: a rod needs a centre of mass away from its joint, or an inertia about it")
        return self


class Chain(Record):
    """Rods that hang one on the other, each on a universal joint at the tip of the one before unless it says otherwise.

    Where some `hangs_on` says so they are a tree, and where some joint is a hinge it has one angle. A closed loop is not
    offered: a stiff Anchor holds a point of a rod.
    """

    kind: Literal["chain"] = Field("chain", description="which kind of model it is")
    rods: Annotated[tuple[Rod, ...], Field(min_length=1)] = Field(description="from the first to the last")
    copies: Copies = Field(1, description="how often the list is repeated")

    @property
    def count(self) -> int:
        """How many rods there are with the copies."""
        return sum(rod.copies for rod in self.rods) * self.copies

    @property
    def all_rods(self) -> tuple[Rod, ...]:
        """The rods with the copies written out."""
        return tuple(rod for rod in self.rods for _ in range(rod.copies)) * self.copies

    @property
    def places(self) -> tuple[float, ...]:
        """Where the joint of each of all rods is along the rod that it hangs on, m; 0 of those on the world."""
        rods = self.all_rods
        return tuple(0.0 if up < 0 else rods[up].length if at is None else at for _, up, at in self._hung)

    @property
    def in_a_row(self) -> bool:
        """Whether every rod has a universal joint at the tip of the one before it, so that its equations are a chain's."""
        return self.tip_to_tip and all(rod.joint == "universal" for rod in self.rods)

    @property
    def tip_to_tip(self) -> bool:
        """Whether every rod hangs at the tip of the one before it, on whatever joint."""
        return all(rod.at is None for rod in self.rods) and self.parents == tuple(range(-1, self.count - 1))

    @property
    def bearing(self) -> tuple[int, ...]:
        """The entries of `rods` at whose tips others hang; a motion shows their lengths."""
        return tuple(sorted({self._hung[up][0] for _, up, at in self._hung if at is None and up >= 0}))

    @cached_property
    def parents(self) -> tuple[int, ...]:
        """The place of the rod that each of all rods hangs on, -1 for the world."""
        return tuple(parent for _, parent, _ in self._hung)

    @cached_property
    def _hung(self) -> tuple[tuple[int, int, float | None], ...]:
        """Of each of all rods its entry in `rods`, its parent and its `at`. Raises ValueError where no parent fits."""
        named = self.count if any(rod.hangs_on is not None for rod in self.rods) else 0
        places = {"world": -1} | {f"rod_{i + 1}": i for i in range(named)}
        rows = list[tuple[int, int, float | None]]()
        for entry, rod in [*enumerate(self.rods)] * self.copies:
            first, name, where = len(rows), rod.hangs_on, f"rods[{entry}].hangs_on"
            parent = first - 1 if name is None else 0 if name == "rod" and first else places.get(name, first)
            if parent >= first and name not in places:
                raise ValueError(f"{where}: {not_one_of(name, [*places][: first + 1])}")
            if parent >= first:
                other = "itself" if parent == first else f"{name}, which is listed after it"
                circle = "a rod hangs on one before it; nothing hangs in a circle"
                raise ValueError(f"{where}: rod_{first + 1} hangs on {other}: {circle}")
            above = first - 1
            while above not in (parent, -1):
                above = rows[above][1]
            if above != parent:  # Pinocchio's mass matrix wants the joints of a branch together
                apart = f"rod_{first + 1} hangs on rod_{parent + 1}, and rod_{first} before it on another branch"
                remedy = f"list a branch as a whole, all that hangs below rod_{parent + 1} right behind it"
                raise ValueError(f"{where}: {apart}: {remedy}")
            rows += [(entry, parent, rod.at), *((entry, i, None) for i in range(first, first + rod.copies - 1))]
        return tuple(rows)

    @model_validator(mode="after")
    def _hang_together(self) -> Self:
        if self.count > MAX_RODS:
            raise ValueError(f"{self.count} rods are more than {MAX_RODS}")
        if self.copies > 1 and any(rod.hangs_on is not None for rod in self.rods):
            reason = "copies: a list with hangs_on is not repeated: list the rods, or give a rod its own copies"
            raise ValueError(reason)
        if all(rod.hangs_on is None and rod.at is None for rod in self.rods):
            return self  # a copy with other rods then takes no places along
        rods = self.all_rods
        for entry, parent, at in self._hung:
            if at is not None and parent < 0:
                raise ValueError(f"rods[{entry}].at: this rod hangs on the world; at is measured along another rod")
            if at is not None and at > rods[parent].length:
                tip = f"the tip of rod_{parent + 1}, at {rods[parent].length:g} m"
                raise ValueError(f"rods[{entry}].at: {at:g} m is beyond {tip}")
        return self


class UrdfModel(Record):
    """Any URDF tree of revolute, continuous, prismatic and fixed joints: a file, or a robot of example-robot-data.

    UrdfModel("ur5") and UrdfModel("rod.urdf") are short for a name and a path.
    """

    kind: Literal["urdf"] = Field("urdf", description="which kind of model it is")
    path: FilePath | None = Field(None, description="the file; in a scene file relative to that")
    name: str | None = Field(None, description="in place of a path: a robot of example-robot-data, such as ur5")
    mimic: Literal["free", "locked"] = Field(
        "free", description="joints with <mimic> move on their own, or are locked where the joint they follow is at 0"
    )
    lock: Annotated[dict[str, Position], AfterValidator(FrozenDict)] = Field(
        default_factory=FrozenDict,
        description="joints that are frozen, each at its position: rad, m for prismatic joints",
    )
    tips: Annotated[dict[str, Vector], AfterValidator(FrozenDict)] = Field(
        default_factory=FrozenDict,
        description="far ends of links in their frames, m; as they are drawn where none is given",
    )

    @classmethod
    def from_one(cls, source: str | Path) -> dict[str, Any]:
        """The field that one unnamed value stands for: a path where it looks like one, else a name."""
        if not isinstance(source, str | Path):
            raise InputError(f"UrdfModel: {shown(source)} is neither the path of a URDF nor the name of a robot")
        is_path = isinstance(source, Path) or Path(source).suffix in MODEL_FILES or "/" in source or "\\" in source
        is_path = is_path or ("." in str(source) and Path(source).is_file())
        return {"path" if is_path else "name": source}

    @cached_property
    def file(self) -> Path:
        """The URDF file. Raises InputError for a name that example-robot-data lacks."""
        return self.path or robot_file(self.name or "")

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if (self.path is None) == (self.name is None):
            raise ValueError("a URDF needs a path or a name, one of them")
        return self


class PinModel(Record):
    """A pin.Model of revolute, continuous and prismatic joints, added branch by branch, as Scene(model=...) takes it.

    No file can hold it.
    """

    kind: Literal["pin"] = Field("pin", description="which kind of model it is")
    pin: Any = Field(description="the pinocchio.Model", repr=False)

    @field_serializer("pin")
    def _named(self, pin: Any) -> dict[str, Any]:
        """What a record of a run says of it: its joints, and what tells its content from another's."""
        return {"joints": list(pin.names)[1:], "sha256": sha256(pin.saveToString().encode()).hexdigest()}

    def __repr__(self) -> str:
        return f"PinModel({self.pin.name!r}, {self.pin.njoints - 1} joints)"


def _wrapped(value: Any) -> Any:
    """A pin.Model, known by its class's name, as the record that holds it; a robot's name or a URDF's path as its table."""
    if isinstance(value, str | Path):
        return {"kind": "urdf"} | UrdfModel.from_one(value)
    if isinstance(value, Rod):
        raise ValueError("a rod is not a model yet: write model=Chain(rods=[Rod(...)])")
    if isinstance(value, list | tuple):
        raise ValueError("a list is not a model yet: write model=Chain(rods=[...])")
    is_pin = type(value).__name__ == "Model" and type(value).__module__.startswith("pinocchio")
    return PinModel(pin=value) if is_pin else value


def _model_branch(value: Any) -> str:
    if isinstance(value, Chain | UrdfModel | PinModel):
        return f"~{value.kind}"
    return f"~{value.get('kind', '')}" if isinstance(value, dict) else "~no table"


AnyModel = Annotated[
    Annotated[Chain, Tag("~chain")]
    | Annotated[UrdfModel, Tag("~urdf")]
    | Annotated[SkipJsonSchema[InstanceOf[PinModel]], Tag("~pin")],
    Discriminator(_model_branch),
    BeforeValidator(_wrapped),
]


def robot_file(name: str) -> Path:
    """The URDF of a robot by its name. Raises InputError that says which name was probably meant."""
    files = robot_files()
    short = name.removesuffix(".urdf").removesuffix("_description")
    if name not in files and short not in files:
        hint = f"{shown(name)} is not a robot of example-robot-data{nearest_or_all(name, tuple(files))}"
        raise InputError(f"model.name: {hint}; `pendpin urdf --list` lists all")
    return files[name if name in files else short]


@cache
def robot_files() -> dict[str, Path]:
    """The URDFs of example-robot-data by name: ur5 of `ur5_robot.urdf`, its folder's if it is alone there or not unique."""
    spec = find_spec("cmeel")
    places = (Path(place).parent for place in (spec and spec.submodule_search_locations) or ())
    folder = next((found for place in places if (found := place / "cmeel.prefix" / FOLDER).is_dir()), None)
    if folder is None:
        raise MissingLibrary("robots by name need example-robot-data: pip install example-robot-data")
    about = {}  # of each file, the robot that its folder NAME_description is about
    for path in sorted(folder.rglob("*.urdf")):
        top = path.relative_to(folder).parts[0]
        about[path] = top.removesuffix("_description").removesuffix("_data").removesuffix("_simple")
    in_folder, named = Counter(about.values()), Counter(path.stem for path in about)
    of_folder = {robot: path for path, robot in about.items() if in_folder[robot] == 1 or named[path.stem] > 1}
    exact = {path.stem: path for path in about if named[path.stem] == 1}
    short = {name.removesuffix("_robot"): path for name, path in exact.items()}
    return dict(sorted((of_folder | short | exact).items()))

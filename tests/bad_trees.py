"""Trees, hinges, sections and diagrams that cannot be, as a user meets them at the command line."""

from bad_input import Case

ROD = "length = 1.0, mass = 1.0, radius = 0.01"
HINGE = f'{ROD}, joint = "hinge"'


def scene(*rods: str, more: str = "", positions: str = "theta_1 = 0.7") -> str:
    """A scene of these rods under gravity, for 1 s."""
    listed = ", ".join(f"{{ {rod} }}" for rod in rods)
    head = f'duration = 1.0\nstart.positions = {{ {positions} }}\nmodel = {{ kind = "chain", rods = [{listed}] }}\n'
    return head + '[[effects]]\nkind = "gravity"\n' + more


TREES = {
    "hangs on itself": ((ROD, f'{ROD}, hangs_on = "rod_2"'), "model.rods[1].hangs_on: rod_2 hangs on itself"),
    "the first hangs on itself": ((f'{ROD}, hangs_on = "rod_1"',), "model.rods[0].hangs_on: rod_1 hangs on itself"),
    "hang in a circle": (
        (f'{ROD}, hangs_on = "rod_2"', f'{ROD}, hangs_on = "rod_1"'),
        "model.rods[0].hangs_on: rod_2",
    ),
    "hangs on a later rod": ((ROD, f'{ROD}, hangs_on = "rod_3"', ROD), "model.rods[1].hangs_on: rod_3"),
    "hangs on a rod that is not there": (
        (ROD, f'{ROD}, hangs_on = "rod_7"'),
        "model.rods[1].hangs_on: 'rod_7' is not one of: world, rod_1",
    ),
    "hangs on a number": ((ROD, f"{ROD}, hangs_on = 1"), "model.rods[1].hangs_on: 1 is not text"),
    "a branch in two parts": (
        (ROD, ROD, f'{ROD}, hangs_on = "rod_1"', f'{ROD}, hangs_on = "rod_2"'),
        "model.rods[3].hangs_on: rod_2",
    ),
    "at beyond the rod": ((ROD, f"{ROD}, at = 1.5"), "model.rods[1].at: 1.5 m is beyond the tip of rod_1, at 1 m"),
    "at below the joint": ((ROD, f"{ROD}, at = -0.1"), "model.rods[1].at: -0.1 is below 0"),
    "at nan": ((ROD, f"{ROD}, at = nan"), "model.rods[1].at: nan is not a finite number"),
    "at in words": ((ROD, f'{ROD}, at = "tip"'), "model.rods[1].at: 'tip' is not a number"),
    "at on the world": ((f"{ROD}, at = 0.5",), "model.rods[0].at: this rod hangs on the world"),
    "an axis that is none": ((f'{HINGE}, axis = "z"',), "model.rods[0].axis: 'z' is not one of: x, y"),
    "an axis of numbers": ((f"{HINGE}, axis = [1, 0, 0]",), "model.rods[0].axis: [1, 0, 0] is not one of: x, y"),
    "an axis without a hinge": ((f'{ROD}, axis = "x"',), 'model.rods[0]: axis = "x" is of a hinge'),
    "a ball": ((f'{ROD}, joint = "ball"',), "model.rods[0].joint: 'ball'"),
    "a slide": ((f'{ROD}, joint = "prismatic"',), "model.rods[0].joint: 'prismatic'"),
    "a weld": ((f'{ROD}, joint = "fixed"',), "model.rods[0].joint: 'fixed'"),
    "a slip in a joint": ((f'{ROD}, joint = "hinges"',), "model.rods[0].joint: 'hinges' did you mean 'hinge'"),
    "a slip in a name": ((ROD, f'{ROD}, hang_on = "rod_1"'), "model.rods[1].hang_on: did you mean 'hangs_on'"),
    "no inertia about a hinge": (
        ('length = 1.0, mass = 1.0, com = 0.0, inertia = [0.0, 1.0, 1.0], joint = "hinge"',),
        "model.rods[0]:",
    ),
    "400 hinges": ((f"{HINGE}, copies = 400",), "400 joints need about"),
    "copies of a tree": ((f'{HINGE}, copies = 2, hangs_on = "rod_9"',), "model.rods[0].hangs_on: 'rod_9'"),
}

STARTS = {
    "an angle that a hinge has not": ((HINGE, HINGE), "phi_2 = 0.1", "", "start.positions: 'phi_2' theta_1"),
    "a motor at an angle that is not": (
        (HINGE,),
        "theta_1 = 0.1",
        '[[effects]]\nkind = "motor"\njoint = "phi"\ntorque = 1.0\n',
        "effects[1] 'phi' is not one of: theta",
    ),
    "a stop at an angle that is not": (
        (HINGE,),
        "theta_1 = 0.1",
        '[[effects]]\nkind = "stop"\nupper = 1.0\njoints = ["phi_1"]\n',
        "effects[1].joints: 'phi' is not one of: theta",
    ),
    "an anchor on a rod that is not": (
        (HINGE,),
        "theta_1 = 0.1",
        '[[effects]]\nkind = "anchor"\nlink = "rod_2"\npoint = [0, 0, -1]\nstiffness = 1.0\n',
        "effects[1] 'rod_2' rod",
    ),
}

DRIVEN = scene(HINGE, more='[[effects]]\nkind = "motor"\njoint = "theta"\namplitude = 0.1\nfrequency = 20.0\n')
SECTION = ("section", "scene.toml", "--of", "theta_rate", "--at")
DIAGRAM = ("bifurcation", "scene.toml", "--of", "theta", "--count", "2", "--skip", "0", "--vary")
AMPLITUDE = "effects[1].amplitude=0.1:0.2:2"
SWEEP = ("sweep", "scene.toml", "--vary", "start.positions.theta_1=0:1:2", "--measure")
COMMANDS = [
    Case("section: no level", (*SECTION, "theta"), "at: 'theta' is not NAME = LEVEL, rising", status=2),
    Case("section: level in words", (*SECTION, "theta = top"), "at: 'top' is not a finite number", status=2),
    Case("section: another way", (*SECTION, "theta = 0, up"), "at: 'theta = 0, up' is not NAME", status=2),
    Case("section: level nan", (*SECTION, "theta = nan"), "at: 'nan' is not a finite number", status=2),
    Case("section: count 0", (*SECTION, "theta = 0", "--count", "0"), "Invalid value for '--count'", status=2),
    Case("section: skip -1", (*SECTION, "theta = 0", "--skip", "-1"), "Invalid value for '--skip'", status=2),
    Case("section: no starts", (*SECTION, "theta = 0", "--starts", "0"), "Invalid value for '--starts'", status=2),
    Case("section: starts without energy", (*SECTION, "theta = 0", "--starts", "3"), "energy: 3 starts"),
    Case("section: too little energy", (*SECTION, "theta = 0", "--energy", "-1e3"), "energy:"),
    Case("section: another name", (*SECTION, "tetha = 0"), "'tetha' did you mean 'theta'"),
    Case("section: one quantity drawn", (*SECTION, "theta = 0", "--plot", "a.png"), "--of: --plot", status=2),
    Case("section: nothing noted", ("section", "scene.toml", "--at", "theta = 0", "--of", ","), "of:", status=2),
    Case("section: a scene that is not", ("section", "no.toml", *SECTION[2:], "theta = 0"), "no.toml: cannot be read"),
    Case("bifurcation: count 0", (*DIAGRAM, AMPLITUDE, "--count", "0"), "Invalid value for '--count'", status=2),
    Case("bifurcation: no values", (*DIAGRAM, "effects[1].amplitude"), "--vary:", status=2),
    Case("bifurcation: two numbers", (*DIAGRAM, AMPLITUDE, "--vary", AMPLITUDE), "--vary: 2", status=2),
    Case("bifurcation: falling values", (*DIAGRAM, "effects[1].amplitude=2:1:3"), "values: rising order"),
    Case("bifurcation: no such effect", (*DIAGRAM, "effects[7].amplitude=1:2:2"), "effects[7]"),
    Case("bifurcation: no such number", (*DIAGRAM, "effects[1].amplitud=1:2:2"), "effects[1].amplitud 'amplitude'"),
    Case("bifurcation: period 0", (*DIAGRAM, AMPLITUDE, "--strobe", "0"), "--strobe: 0.0 is not", status=2),
    Case("bifurcation: another name", (*DIAGRAM[:3], "thet", *DIAGRAM[4:], AMPLITUDE), "'thet' 'theta'"),
    Case("sweep: attractor's period", (*SWEEP, "attractor(0)"), "measure: 'attractor(0)': attractor(9.42)"),
    Case("sweep: attractor too short", (*SWEEP, "attractor(1.0)"), "duration: 9 1 s 9 s"),
    Case("sweep: attractor's spread", (*SWEEP, "attractor.spread"), "measure: attractor.spread:"),
]


def _cases() -> list[Case]:
    run = ("run", "scene.toml")
    trees = [Case(f"scene: {name}", run, says, {"scene.toml": scene(*rods)}) for name, (rods, says) in TREES.items()]
    starts = [
        Case(f"scene: {name}", run, says, {"scene.toml": scene(*rods, more=more, positions=positions)})
        for name, (rods, positions, more, says) in STARTS.items()
    ]
    commands = [Case(c.name, c.arguments, c.says, {"scene.toml": DRIVEN}, c.status) for c in COMMANDS]
    return [*trees, *starts, *commands]


CASES = _cases()

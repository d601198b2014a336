"""How the doctor does on right derivations in any usual letters: nothing of them may be accused.

    python benchmarks/letters.py [--texts 140] [--seed 0] [--planted] [--show]

Each text is one of printed/derivations.md: its letters, the marks of its rates and its layout are drawn at random, and some
of its lines are left out. Letters that pages use for two things at once are among them: T, L, P and M. With --planted a text
has one fault: a sign, function, number, power or letter of one formula is another.
"""

import argparse
import re
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from random import Random
from typing import NamedTuple

import pendpin as pp

LEFT_OUT = 0.4  # of the lines that may be
FILE = Path(__file__).with_name("printed") / "derivations.md"
ANGLES = [r"\theta", r"\phi", r"\varphi", r"\alpha", r"\theta", r"\psi", r"\beta", r"\vartheta", r"q"]
RATES = [  # how a rate and an acceleration are printed
    (r"\dot{%s}", r"\ddot{%s}"),
    (r"\dot %s", r"\ddot %s"),
    ("%s'", "%s''"),
    (r"\left(\frac{d %s}{dt}\right)", r"\frac{d^2 %s}{dt^2}"),
]
ENERGIES = r"T,V T,U K,U K,V E_k,E_p E_c,E_p K,P KE,PE E_{kin},E_{pot} \mathcal{T},\mathcal{V}"
STATES = """theta1,omega1,theta2,omega2 theta1,z1,theta2,z2 th1,w1,th2,w2 phi1,dphi1,phi2,dphi2 t1,w1,t2,w2
theta_1,theta_1_dot,theta_2,theta_2_dot a1,a1_v,a2,a2_v"""
ALONE = "theta,omega th,w phi,dphi theta,theta_dot x,v angle,angular_velocity theta,thetadot q,qd"
DAMPINGS = "", " - b*<w>", " - (b/m)*<w>", " - b/(m*<L1>**2)*<w>", " - gamma*<w> + A*np.cos(omega_d*t)"
USUAL = {  # letters of quantities, as often as they are drawn
    "L": r"L \mathcal{L} \mathcal{L} \mathscr{L} L",
    "l": r"l L \ell R r a b l L",
    "m": "m m m M",
    "H": r"H \mathcal{H}",
    "I": "I J I_O I_0 I_A I",
    "E": r"E E E_{tot} \mathcal{E}",
    "F": "F u F f",
    "A": r"A F_0 F M_0 \tau_0",
    "b": r"b c \gamma k",
    "S": "S T N F_T F_s",
    "P": r"T T T_0 \tau P",
}
FAULTS = (  # the pattern of what is right, and what makes it wrong
    (r"(?<=[\w)} ])- ", "+ "),
    (r"\+ ", "- "),
    (r"\\cos", r"\\sin"),
    (r"\\sin", r"\\cos"),
    (r"\\frac\{1\}\{2\}|0\.5\*", ""),
    (r"\^2|\*\*2", ""),
    (r"(?<=[lm]_)1|(?<=[lmL])1", "2"),
    (r"\b2(?=[ *(])", "3"),
)


class Text(NamedTuple):
    """A derivation, and of one with a fault the line that is wrong."""

    heading: str
    text: str
    wrong: str = ""


class Outcome(NamedTuple):
    """How many equations hold, which are accused, and of a fault what is said of its line."""

    text: Text
    holds: int
    count: int
    accused: list[str]
    fault: str = ""


def derivations() -> dict[str, list[str]]:
    """The lines below each heading."""
    _, *parts = re.split(r"(?m)^# (.*)\n", FILE.read_text(encoding="utf-8"))
    return {name: body.strip().splitlines() for name, body in zip(parts[::2], parts[1::2], strict=True)}


def drawn(heading: str, lines: list[str], random: Random) -> str:
    """A derivation in letters that are drawn."""
    choose, double = random.choice, bool(re.search("double|triple|arm", heading))
    letters = {name: choose(every.split()) for name, every in USUAL.items()}
    letters["th"] = choose(ANGLES)
    rate, acceleration = RATES[0] if double else choose(RATES)
    letters |= {"th.": rate % letters["th"], "th..": acceleration % letters["th"]}
    letters["T"], letters["V"] = choose(ENERGIES.split()).split(",")
    letters |= {"g": "g", "M": "M", "w": r"\omega", "p": choose(["p", f"p_{letters['th']}"])}
    plain = double or heading in ("spherical pendulum", "vibrating pivot") or "cart" in heading
    letters |= {"m": "m", "p": "p"} if plain else {}
    if heading == "compound pendulum":
        letters["l"] = choose(["d", "h", "l", "a", "r", "s", "b"])
    if f"${letters['l']}$" in "\n".join(lines):  # which is another length there
        letters["l"] = "l"
    if letters["l"] in (letters["S"], letters["b"]):
        letters |= {"l": "l", "b": "c"}
    letters |= {"l": "l"} if letters["l"] == "a" and heading == "vibrating pivot" else {}
    if letters["S"] == letters["P"] or letters["P"] == letters["V"]:
        letters["P"] = "T_0"
    if "code" in heading:
        letters |= zip(("a1", "w1", "a2", "w2"), choose(STATES.split()).split(","), strict=True)
        letters |= zip(("a", "w"), choose(ALONE.split()).split(","), strict=True)
        letters |= zip(("c1", "c2"), choose(["acc1,acc2", "domega1,domega2", "alpha1,alpha2"]).split(","), strict=True)
        letters["c"] = choose(["domega", "alpha", "acc", "theta_ddot", "domega_dt"])
        letters |= zip(("L1", "L2"), choose(["L1,L2", "l1,l2", "length1,length2"]).split(","), strict=True)
        letters["damping"] = choose(DAMPINGS)
        letters |= {"L1": choose(["L", "l", "length", "self.L", "r"])} if heading == "pendulum in code" else {}
    kept = [line.removeprefix("@") for line in lines if not (line[:1] == "@" and random.random() < LEFT_OUT)]
    text = "\n".join(kept)
    for _ in range(2):  # letters within letters
        text = re.sub(r"<([\w.]+)>", lambda match: letters[match[1]], text)
    if random.random() < 0.3:
        text = text.replace(r"\frac{1}{2}", r"\frac12")
    if random.random() < 0.2:
        text = text.replace("$$ ", "\\begin{equation}\n").replace(" $$", "\n\\end{equation}")
    return text


def texts(count: int, seed: int, planted: bool = False) -> Iterator[Text]:
    """Derivations in turn, each with its own random letters."""
    every = derivations()
    for i in range(count):
        heading, random = [*every][i % len(every)], Random(seed + i)
        text = drawn(heading, every[heading], random)
        yield with_fault(heading, text, random) if planted else Text(heading, text)


def with_fault(heading: str, text: str, random: Random) -> Text:
    """A text with one fault in one of its formulas, where it has any that may have one."""
    lines = text.splitlines()
    places = [
        (i, match, by)
        for i, line in enumerate(lines)
        for pattern, by in FAULTS
        if "=" in line and "return" not in line
        for match in re.finditer(pattern, line)
    ]
    if not places:
        return Text(heading, text)
    i, match, by = random.choice(places)
    lines[i] = lines[i][: match.start()] + match.expand(by) + lines[i][match.end() :]
    return Text(heading, "\n".join(lines), lines[i])


def examine(one: Text) -> Outcome:
    """What the doctor says of a text."""
    findings = pp.diagnose(one.text).findings
    bare = lambda text: re.sub(r"\s|\$|\\q?quad", "", text)  # noqa: E731
    here = {finding.verdict for finding in findings if one.wrong and bare(finding.latex) in bare(one.wrong)}
    fault = "found" if "fails" in here else "not checked" if "not checked" in here or not here else "holds"
    accused = [f for f in findings if f.verdict == "fails" and not (one.wrong and bare(f.latex) in bare(one.wrong))]
    said = [f"{f.latex} -> {f.mends[0].words if f.mends else ''}" for f in accused if not f.follows]
    return Outcome(one, sum(f.verdict.startswith("holds") for f in findings), len(findings), said, fault)


def main() -> None:
    """Read the arguments, run, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--texts", type=int, default=140)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--planted", action="store_true", help="one fault in each text")
    parser.add_argument("--show", action="store_true", help="the texts of which something is accused that is right")
    choices = parser.parse_args()
    with ProcessPoolExecutor() as pool:
        outcomes = list(pool.map(examine, texts(choices.texts, choices.seed, choices.planted), chunksize=4))
    for one in (one for one in outcomes if one.accused):
        print(f"{one.text.heading}: {'; '.join(one.accused)}", *[one.text.text] * choices.show, sep="\n")
    holds, count = (sum(getattr(one, name) for one in outcomes) for name in ("holds", "count"))
    print(f"{len(outcomes)} texts, {count} equations: {holds} hold, {sum(len(o.accused) for o in outcomes)} accused")
    if choices.planted:
        print(f"faults: {dict(Counter(one.fault for one in outcomes))}")


if __name__ == "__main__":
    main()

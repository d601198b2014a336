"""The convention that a text is written in: given in words, or the one that explains most of its equations."""

from collections.abc import Callable
from dataclasses import replace
from itertools import product

from pendpin.analysis.doctor.judging.judge import TOLERANCE
from pendpin.analysis.doctor.judging.mechanics import Convention
from pendpin.analysis.doctor.patients import Printed, chosen
from pendpin.analysis.doctor.reading.tree import Unread, walk
from pendpin.errors import InputError, shown

WORDS = "theta-ccw, phi-reversed, z-up, swapped, b3-up, transposed, standard"
MOST_SEARCHED = 300  # parts of an equation whose convention is searched

CONVENTIONS = {
    "theta": {"ccw", "counterclockwise", "reversed"},
    "phi": {"cw", "clockwise", "reversed"},
    "z": {"up"},
}


def conventions_of(text: str) -> Convention:
    """A convention in words: theta-ccw, phi-reversed, z-up, swapped, b3-up, with commas; or standard. Raises InputError."""
    found = Convention()
    for part in filter(None, (p.strip().lower().replace("=", "-").replace(" ", "-") for p in text.split(","))):
        name, _, value = part.partition("-")
        value = value.replace("-", "")
        if part == "standard":
            continue
        if name == "swapped":
            found = replace(found, swapped=True)
        elif name == "transposed":
            found = replace(found, transposed=True)
        elif part in ("b3-up", "b3-joint"):
            found = replace(found, along=-1)
        elif name == "mirrored" or part == "z-mirrored":
            found = replace(found, z="mirrored")
        elif value in CONVENTIONS.get(name, ()):
            found = replace(found, **{name: "up" if name == "z" else -1})
        else:
            raise InputError(f"convention: {shown(part)} is not one of: {WORDS}")
    return found


def _all_conventions() -> list[Convention]:
    flags = product((1, -1), (1, -1), (False, True), ("down", "up", "mirrored"), (1, -1), (False, True))
    every = [Convention(*flag) for flag in flags]
    return sorted(every, key=lambda c: len([w for w in c.words.split(", ") if w]) + 0.1 * (c.z == "mirrored"))


def _holds(one: Printed, rod: str, convention: Convention) -> bool | None:
    """Whether an equation holds at random states; None for one that cannot be read or tells little of the convention."""
    parts = [part for sides, _ in one.ways[:1] for side in sides for part in walk(side)]
    if one.defines or len(parts) > MOST_SEARCHED or any(part.kind == "derivative" for part in parts):
        return None
    try:
        return chosen(one, rod, convention)[2] < TOLERANCE
    except Unread:
        return None


def find_convention(
    equations: list[Printed], rod: str, mended: Callable[[list[Printed]], bool]
) -> tuple[Convention, list[str]]:
    """The convention that a text was written in: the usual one, unless another explains clearly more of it.

    `mended` says whether single changes heal equations in the usual convention: then a single change is the likelier.
    """
    usual = Convention()
    verdicts = [(one, _holds(one, rod, usual)) for one in equations]
    right = [one for one, holds in verdicts if holds]
    wrong = [one for one, holds in verdicts if holds is False]
    if not wrong:
        return usual, []
    healed = {c: sum(_holds(one, rod, c) is True for one in wrong) for c in _all_conventions()}
    held = {
        c: n + sum(_holds(one, rod, c) is True for one in right) for c, n in healed.items() if n > 1 or n == len(wrong)
    }
    best = max(held, key=lambda convention: held[convention], default=usual)
    read = len(right) + len(wrong)
    if best == usual or held[best] <= len(right):
        return usual, []
    if held[best] >= len(right) + 2 and held[best] >= 0.6 * read:
        return best, []
    if held[best] < read:
        return usual, []
    if mended(wrong):
        return usual, [f"All equations hold if {best.words}; if that is meant, give it as the convention."]
    return best, []

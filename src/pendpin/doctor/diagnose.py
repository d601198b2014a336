"""The way in: equations as text, file, table or sympy expressions; or functions that compute what equations would."""

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pendpin.doctor.diagnosis import examine
from pendpin.doctor.reading.documents import MOST_BYTES, Document, read_text, read_toml, statements, text_of
from pendpin.doctor.report import Diagnosis
from pendpin.errors import InputError, inside, shown
from pendpin.ground.files import read_whole
from pendpin.ground.libraries import optional
from pendpin.scene import Scene, load_scene

if TYPE_CHECKING:
    from pendpin.motions.crosschecks.functions import Comparison

MOST_ALONE = 20_000  # characters of a text that may be one equation
_BINARY = re.compile(rb"[\x00-\x08\x0e-\x1a]")  # in no text in ASCII, UTF-8 or Latin-1
_MARKED = re.compile(r"\\\[|\\\(|\$|\\begin\{|```math|\n")


def diagnose(
    equations: Any,
    *,
    rod: str | None = None,
    symbols: Mapping[str, Any] | None = None,
    scene: Scene | None = None,
    convention: str | None = None,
    accelerations: Callable[..., Any] | None = None,
    reactions: Callable[..., Any] | None = None,
    progress: Callable[[str], object] = lambda what: None,
) -> "Diagnosis | Comparison":
    """Check the equations of a rod on a universal joint, and mend those that fail (docs/doctor.md).

    Args:
        equations: a text in LaTeX, Markdown or plain notation, a Path of such a file or of a TOML file, a list of texts and
            sympy expressions or Eq, or a mapping of names to these. A Scene compares functions instead; see below.
        rod: "point" (a mass at the tip), "thin" (uniform, I3 = 0), "uniform" (radius r), "symmetric" (h, I1 = I2, I3) or
            "general" (h, I1, I2, I3). Other systems: "plane", "moved", "elastic", "pulled", "double", "triple", "acrobot",
            "cart-pole", "cart-double", "polar", "conical", "turning", "coupled", "furuta". Found from the symbols if absent.
        symbols: names of your own, such as {"alpha": "theta", "A": "J_1"}.
        scene: a chain of rods that the equations describe.
        convention: differences from docs/derivation.md: "theta-ccw", "phi-reversed", "z-up", "z-mirrored", "swapped",
            "b3-up", "transposed", several with commas, or "standard" for none. Found if absent.
        accelerations: with a Scene, f(q, v) -> (nv,) rad/s², compared with the scene's own at random states.
        reactions: with a Scene, f(q, v) -> a mapping with any of R1, R2, R3, M3, Mc to (rods,), or wrenches (joints, 6).
        progress: called with the name of each step.

    Returns:
        A Diagnosis, or for a Scene a Comparison; both print as a report.

    Raises:
        InputError: for a text that cannot be read at all.
        MissingLibrary: without sympy.
    """
    if isinstance(equations, Scene):
        from pendpin.motions.crosschecks.functions import compare_functions

        return compare_functions(equations, accelerations, reactions)
    if accelerations is not None or reactions is not None:
        raise InputError("accelerations and reactions are compared with a Scene: give one as the first argument")
    optional("sympy", "the equation doctor", "sympy")
    document = _document(equations)
    own = {name: _plain(value) for name, value in (symbols or {}).items()}
    if not document.statements:
        raise InputError("no equation is found: an equation holds an equals sign")
    choices = {"rod": rod, "symbols": own, "convention": convention, "scene": scene}
    return examine(document, choices, progress)


def diagnose_file(
    path: Path,
    rod: str | None = None,
    convention: str | None = None,
    progress: Callable[[str], object] = lambda what: None,
    symbols: str | None = None,
    scene: Path | None = None,
) -> Diagnosis:
    """The diagnosis of a file; its errors name it. `symbols` is text such as alpha=theta,A=J_1. Raises InputError."""
    pairs = [part.partition("=") for part in re.split(r",(?![^()]*\))", symbols or "") if part.strip()]
    for name, equals, value in pairs:
        if not (name.strip() and equals and value.strip()):
            raise InputError(f"--symbols: {shown(name)} has no meaning; write name=meaning, as in alpha=theta,A=J_1")
    own, chain = {name.strip(): value.strip() for name, _, value in pairs}, load_scene(scene) if scene else None
    with inside(str(path)):
        found = diagnose(path, rod=rod, convention=convention, symbols=own, scene=chain, progress=progress)
    assert isinstance(found, Diagnosis)
    return found


def _document(equations: Any) -> Document:
    """What holds the equations, from a file, a text, a table or a list. Raises InputError."""
    if isinstance(equations, Path):
        with inside(str(equations)):
            data = read_whole(equations, MOST_BYTES, "a derivation")
        if equations.suffix.lower() == ".toml":
            return read_toml(data, str(equations))
        if _BINARY.search(data):
            raise InputError(f"{equations}: not a text file")
        return read_text(data.decode(errors="replace"))
    empty = isinstance(equations, str | list | tuple | Mapping) and not (equations and str(equations).strip())
    if empty or equations is None or isinstance(equations, int | float | bytes):
        raise InputError(f"equations: {shown(equations)} holds no equation; give a text, a Path or a list of equations")
    if isinstance(equations, Mapping):
        return Document(tuple(statements({str(name): _plain(value) for name, value in equations.items()})))
    if not isinstance(equations, str):
        return Document(tuple(statements(map(_plain, equations if isinstance(equations, Iterable) else [equations]))))
    if len(equations) > MOST_BYTES:
        raise InputError(f"larger than the {MOST_BYTES / 1e6:g} MB that equations may have")
    document = read_text(equations) if _MARKED.search(equations) else None
    alone = "=" in equations and len(equations) < MOST_ALONE
    return document if document and (document.statements or not alone) else Document(tuple(statements([equations])))


def _plain(value: Any) -> str:
    """A text as it is, a number or sympy expression as plain text. Raises InputError for anything else."""
    if isinstance(value, str):
        return value
    if isinstance(value, int | float):
        return repr(value)
    if (text := text_of(value)) is None:
        raise InputError(f"{shown(value)} is neither text nor an expression of sympy")
    return text

"""The way in: equations as text, file, table or sympy expressions; or functions that compute what equations would."""

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pendpin.analysis.doctor.checking.exact import need_sympy
from pendpin.analysis.doctor.diagnosis import Diagnosis, examine
from pendpin.analysis.doctor.reading.documents import MOST_BYTES, Document, read_text, read_toml, statements
from pendpin.errors import InputError, inside, shown
from pendpin.files import read_whole
from pendpin.scene import Scene

if TYPE_CHECKING:
    from pendpin.analysis.doctor.black_box import Comparison

_MARKED = re.compile(r"\\\[|\\\(|\$|\\begin\{|```math|\n")


def diagnose(
    equations: Any,
    *,
    rod: str | None = None,
    symbols: Mapping[str, Any] | None = None,
    convention: str | None = None,
    accelerations: Callable[..., Any] | None = None,
    reactions: Callable[..., Any] | None = None,
    progress: Callable[[str], object] = lambda what: None,
) -> "Diagnosis | Comparison":
    """Check the equations of a rod on a universal joint, and mend those that fail (docs/doctor.md).

    `equations` is a text in LaTeX, Markdown or plain notation, a Path of such a file or of a TOML file, a list of texts
    and sympy expressions or Eq, or a mapping of names to these. `rod` is "point" (a mass at the tip), "thin" (uniform,
    I3 = 0), "uniform" (radius r), "symmetric" (h, I1 = I2, I3) or "general" (h, I1, I2, I3); left out, the
    symbols tell. `symbols` gives names of your own.
    `convention` says how the text differs from docs/derivation.md: "theta-ccw", "phi-reversed", "z-up", "swapped",
    "b3-up", "transposed", several with commas, or "standard"; left out, it is found.

    With a Scene in place of equations, `accelerations(q, v)` and `reactions(q, v)` are compared with the scene's own at
    random states. Raises InputError for what cannot be read at all, MissingLibrary without sympy.
    """
    if isinstance(equations, Scene):
        from pendpin.analysis.doctor.black_box import compare

        return compare(equations, accelerations, reactions)
    if accelerations is not None or reactions is not None:
        raise InputError("accelerations and reactions are compared with a Scene: give one as the first argument")
    need_sympy()
    document = _document(equations)
    own = {name: _plain(value) for name, value in (symbols or {}).items()}
    document = Document(document.statements, {**document.symbols, **own}, document.rod, document.convention)
    if not document.statements:
        raise InputError("no equation is found: an equation holds an equals sign")
    return examine(document, rod, convention, progress)


def diagnose_file(
    path: Path,
    rod: str | None = None,
    convention: str | None = None,
    progress: Callable[[str], object] = lambda what: None,
) -> Diagnosis:
    """The diagnosis of a file; its errors name it. Raises InputError."""
    with inside(str(path)):
        found = diagnose(path, rod=rod, convention=convention, progress=progress)
    assert isinstance(found, Diagnosis)
    return found


def _document(equations: Any) -> Document:
    if isinstance(equations, Path):
        return _file(equations)
    if isinstance(equations, str):
        if len(equations) > MOST_BYTES:
            raise InputError(f"larger than the {MOST_BYTES / 1e6:g} MB that equations may have")
        return read_text(equations) if _MARKED.search(equations) else Document(tuple(statements([equations])), {})
    if isinstance(equations, Mapping):
        return Document(tuple(statements({str(name): _plain(value) for name, value in equations.items()})), {})
    if isinstance(equations, Iterable) and not isinstance(equations, bytes):
        return Document(tuple(statements([_plain(value) for value in equations])), {})
    return Document(tuple(statements([_plain(equations)])), {})


def _file(path: Path) -> Document:
    with inside(str(path)):
        data = read_whole(path, MOST_BYTES, "a derivation")
    if path.suffix.lower() == ".toml":
        return read_toml(data, str(path))
    return read_text(data.decode(errors="replace"))


def _plain(value: Any) -> str:
    """A text as it is, a number or sympy expression as plain text. Raises InputError for anything else."""
    if isinstance(value, str):
        return value
    if isinstance(value, int | float):
        return repr(value)
    from pendpin.analysis.doctor.reading.from_sympy import text_of

    if (text := text_of(value)) is None:
        raise InputError(f"{shown(value)} is neither text nor an expression of sympy")
    return text

"""Players on pages: each page shows its motion in a frame whose scripts are files that all players share.

A player (graphics.view.Animation) is one HTML page of 1 MB, nearly all of it the viewer. On the site the viewer is
stored once: after the build every frame with its page inside becomes a small file in _players, and the scripts and
styles that two of them have in common become files beside it.
"""

import base64
import gzip
import hashlib
import html
import re
from pathlib import Path
from typing import Any

FRAME = re.compile(r'<iframe srcdoc="([^"]*)"([^>]*)>')
SANDBOX = re.compile(r' sandbox="[^"]*"')  # a page in a sandbox may not read the scripts beside it from a disk
SCRIPT = re.compile(r"<script>(.*?)</script>", re.DOTALL)
POLICY = re.compile(r'<meta http-equiv="Content-Security-Policy"[^>]*>')
PACKED = re.compile(r'const packed = Uint8Array\.from\(atob\("([^"]+)"\)')
LARGE = 50_000  # characters: scripts above this are shared


def share(app: Any, error: Exception | None) -> None:
    """Replace the frames of all pages."""
    if error or app.builder.name != "html":
        return
    folder = Path(app.outdir) / "_players"
    for path in Path(app.outdir).rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        if '<iframe srcdoc="' not in text or path.parent == folder:
            continue
        up = "../" * len(path.parent.relative_to(app.outdir).parts)
        path.write_text(FRAME.sub(lambda m, up=up: _frame(folder, up, m), text), encoding="utf-8")


def _frame(folder: Path, up: str, found: re.Match[str]) -> str:
    return f'<iframe src="{up}{_stored(folder, found[1])}"{SANDBOX.sub("", found[2])}>'


def _stored(folder: Path, escaped: str) -> str:
    """The page of one player as a file; its address from the top of the site."""
    folder.mkdir(exist_ok=True)
    page = html.unescape(escaped)
    if packed := PACKED.search(page):  # as notebooks hold it
        page = gzip.decompress(base64.b64decode(packed[1])).decode()
    page = POLICY.sub("", page)
    page = SCRIPT.sub(lambda m: _script(folder, m), page)
    return _write(folder, page, ".html")


def _script(folder: Path, found: re.Match[str]) -> str:
    if len(found[1]) < LARGE or "</script" in found[1]:
        return found[0]
    return f'<script src="{Path(_write(folder, found[1], ".js")).name}"></script>'


def _write(folder: Path, text: str, suffix: str) -> str:
    name = hashlib.sha256(text.encode()).hexdigest()[:16] + suffix
    (folder / name).write_text(text, encoding="utf-8")
    return f"{folder.name}/{name}"


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("build-finished", share, priority=600)
    return {"parallel_read_safe": True}

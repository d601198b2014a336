"""After the build: every link leads somewhere, nothing is loaded from the network, and the site is small."""

import re
from html import unescape
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from sphinx.util import logging

MOST_BYTES = 30_000_000
LOADED = re.compile(r"<(?:script|img|iframe|source|video|link)\b[^>]*?\b(?:src|href)=\"([^\"]*)\"[^>]*>")
LINKED = re.compile(r"<a\b[^>]*?\bhref=\"([^\"]*)\"")
ANCHOR = re.compile(r"\b(?:id|name)=\"([^\"]*)\"")
KEPT = (
    "tex-chtml.js",
    "output/chtml/",
    "input/tex/",
    "a11y/",
    "ui/",
    "sre/mathmaps/base",
    "sre/mathmaps/en",
)  # MathJax
log = logging.getLogger(__name__)


def prune(app: Any, error: Exception | None) -> None:
    """Remove the parts of MathJax that no page loads: 20 MB."""
    folder = Path(app.outdir) / "_static" / "mathjax"
    if error or not folder.exists():
        return
    for path in sorted(folder.rglob("*"), reverse=True):
        if path.is_file() and not path.relative_to(folder).as_posix().startswith(KEPT):
            path.unlink()


def check(app: Any, error: Exception | None) -> None:
    """Warn of each fault; with -W the build fails."""
    if error or app.builder.name != "html":
        return
    top = Path(app.outdir)
    pages = {path: path.read_text(encoding="utf-8") for path in top.rglob("*.html") if path.parent.name != "_players"}
    anchors = {path: {unescape(anchor) for anchor in ANCHOR.findall(text)} for path, text in pages.items()}
    links = 0
    for path, text in pages.items():
        shown = path.relative_to(top)
        for address in LOADED.findall(text):
            if re.match(r"https?:|//", address) and "canonical" not in address:
                log.warning("%s loads %s from the network", shown, address)
        for address in [*LINKED.findall(text), *LOADED.findall(text)]:
            links += 1
            if fault := _fault(top, path, unescape(address), anchors):
                log.warning("%s: %s", shown, fault)
    size = sum(path.stat().st_size for path in top.rglob("*") if path.is_file() and ".doctrees" not in path.parts)
    if size > MOST_BYTES:
        log.warning("the site has %.1f MB; at most %.0f", size / 1e6, MOST_BYTES / 1e6)
    log.info("site: %d pages, %d links and files checked, %.1f MB", len(pages), links, size / 1e6)


def _fault(top: Path, page: Path, address: str, anchors: dict[Path, set[str]]) -> str:
    """What is wrong with one address on a page, or nothing."""
    if re.match(r"[a-z]+:|//", address):
        return ""  # another site; nothing is fetched here
    name, _, anchor = address.partition("#")
    target = (page.parent / unquote(name.split("?")[0])).resolve() if name else page
    if target.is_dir():
        target /= "index.html"
    if not target.exists():
        return f"the link {address} leads to no file"
    if anchor and target in anchors and unquote(anchor) not in anchors[target]:
        return f"the link {address} leads to no place on that page"
    return ""


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("build-finished", prune, priority=500)
    app.connect("build-finished", check, priority=900)
    return {"parallel_read_safe": True}

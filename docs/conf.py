"""The documentation site: `sphinx-build -W -n docs site` builds it from nothing and checks every link.

Pages are Markdown, read by MyST. The tutorials in docs/start are run while they are built, and so are the scripts of
docs/gallery_scripts. What can be read off the package (API, commands, scene file, effects, methods) is written by
docs/_extensions/reference_pages.py; docs/_extensions/site_checks.py checks the result.
"""

import json
import os
import re
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
LENT = HERE / "gallery_scripts" / "examples"  # a link, while the site is built
MOST_OF_A_PLAYER = 1_000_000  # characters in a notebook
sys.path[:0] = [str(HERE.parent / "src"), str(HERE / "_extensions")]
os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"  # tutorials call `pendpin`
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [sys.path[0], os.environ.get("PYTHONPATH", "")]))
os.environ["PENDPIN_CHECKOUT"] = str(HERE.parent)  # tutorials use its examples
os.environ |= {"COLUMNS": "79", "NO_COLOR": "1", "TTY_COMPATIBLE": "0", "TTY_INTERACTIVE": "0"}  # no progress bars
os.environ.setdefault("MPLBACKEND", "agg")

from pendpin.graphics.style import STYLE  # noqa: E402
from pendpin.ground.libraries import VERSION  # noqa: E402

os.environ["MATPLOTLIBRC"] = tempfile.mkdtemp()  # figures that tutorials draw themselves look like pendpin's own
look = [f"{key}: {', '.join(map(str, x)) if isinstance(x, tuple) else x}\n" for key, x in STYLE.items()]
(Path(os.environ["MATPLOTLIBRC"]) / "matplotlibrc").write_text("".join(look).replace("#", ""))

project = "pendpin"
author = "pendpin developers"
copyright = author
release = version = VERSION

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "sphinx-mathjax-offline",
    "reference_pages",
    "docstrings",
    "console",
    "figures",
    "shared_players",
    "site_checks",
]
exclude_patterns = [
    "_build",
    "_extensions",
    "gallery_scripts",
    "**.ipynb_checkpoints",
    "gallery/*.py",
    "gallery/*.ipynb",
]
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb", ".ipynb": "myst-nb"}
html_theme = "furo"
html_title = f"pendpin {VERSION}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"light_css_variables": {"content-padding": "1.5em"}, "navigation_with_keys": True}
templates_path = ["_templates"]

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence", "attrs_inline"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 4
myst_links_external_new_tab = False
nb_execution_mode = "auto"  # the pages with code cells; notebooks that hold their outputs are shown as they are
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = -1  # none: a busy machine is no error, and Ctrl-C ends what hangs
nb_merge_streams = True

default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_maximum_signature_line_length = 79
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_custom_sections = [("Fields", "params_style")]
napoleon_use_ivar = False
nitpick_ignore_regex = [("py:.*", r"(?!pendpin\.[A-Za-z]+$).*")]  # only public names have pages

copybutton_prompt_text = r"\$ "
copybutton_prompt_is_regexp = True
copybutton_only_copy_prompt_lines = True

sphinx_gallery_conf = {
    "examples_dirs": ["gallery_scripts"],
    "gallery_dirs": ["gallery"],
    "filename_pattern": r"/plot_",
    "ignore_pattern": r"__init__\.py|/_",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "remove_config_comments": True,
    "capture_repr": ("_repr_html_",),
    "image_scrapers": ("figures.scrape",),
    "reset_modules": ("figures.reset",),
    "matplotlib_animations": False,
    "plot_gallery": "True",
    "abort_on_example_error": False,
    "only_warn_on_example_error": False,
    "min_reported_time": 1_000,
    "write_computation_times": False,
    "thumbnail_size": (400, 280),
    "parallel": 2,
}


def point_into_the_site(app, name, source):
    """Pages that also serve readers of the repository link to folders there; on the site these links have pages."""
    text = source[0]
    text = re.sub(r"\]\(\.\./examples\)", "](gallery/index.rst)", text)
    text = re.sub(r"\]\(\.\./README\.md\)", "](index.md)", text)
    text = re.sub(r"\[(`?[^\]]+`?)\]\(\.\./(?:src|tests|examples|benchmarks)[^)]*\)", r"\1", text)
    source[0] = text


def copy_notebooks(app):
    """The notebooks of examples/ beside the tutorials; the player of a robot with its meshes is in the tutorial alone."""
    for path in (HERE.parent / "examples").glob("*.ipynb"):
        notebook = json.loads(path.read_text(encoding="utf-8"))
        for cell in notebook["cells"]:
            for output in cell.get("outputs", ()):
                if len("".join(output.get("data", {}).get("text/html", ""))) > MOST_OF_A_PLAYER:
                    del output["data"]["text/html"]
        (HERE / "start" / path.name).write_text(json.dumps(notebook), encoding="utf-8")


def lend_examples(app):
    """The gallery's scripts name scenes as in a checkout, `examples/crane.toml`, and are run in their folder."""
    LENT.unlink(missing_ok=True)
    LENT.symlink_to(HERE.parent / "examples")


def setup(app):
    """Sphinx calls this."""
    app.connect("builder-inited", copy_notebooks)
    app.connect("builder-inited", lend_examples, priority=100)
    app.connect("build-finished", lambda app, error: LENT.unlink(missing_ok=True))
    app.extensions["sphinx-mathjax-offline"].parallel_read_safe = True  # it only names files
    app.connect("source-read", point_into_the_site)

"""Sphinx: how the documentation is built. `make docs` calls it; nothing here is imported by rmfs."""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import generate  # noqa: E402

project = "rmfs"
author = "The rmfs authors"
version = release = version_of("rmfs")

extensions = [
    "myst_nb",  # pages in Markdown, and the notebook, which it executes
    "sphinx.ext.autodoc",  # the API from the docstrings
    "sphinx.ext.napoleon",  # which are numpydoc
    "sphinx.ext.mathjax",
    "sphinx_click",  # the commands from click
]
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
suppress_warnings = ["myst.strikethrough"]
nb_execution_mode = "force"  # the notebook is kept without its outputs
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_execution_timeout = 120

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
napoleon_google_docstring = False
napoleon_use_rtype = False
python_use_unqualified_type_names = True

html_theme = "furo"
html_title = f"rmfs {version}"
html_static_path = ["_static"]
exclude_patterns = ["_build", "paper/league", "paper/study", "reference/_generated"]
highlight_language = "default"  # Python where it is Python
default_role = "code"  # `name` in a docstring
toc_object_entries_show_parents = "hide"
html_show_copyright = False
html_css_files = ["tables.css"]

generate.write(HERE / "reference" / "_generated")


def setup(app):
    """Show a default that attrs makes anew for each object as `...`, not as its marker NOTHING."""
    app.connect("autodoc-process-signature", _with_dots)


def _with_dots(app, what, name, found, options, signature, returned):  # noqa: ARG001
    return signature and signature.replace("NOTHING", "..."), returned

"""Sphinx builds the documentation from here: sphinx-build -W --keep-going -b html docs docs/_build/html.

Nothing is fetched: formulas are drawn into the pages when they are built, and figures are files in docs/images.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import geomstats_anim

sys.path.insert(0, str(Path(__file__).parent))

project = "geomstats-anim"
author = "The geomstats-anim authors"
copyright = author
version = release = geomstats_anim.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "formulas",
    "verbs",
]
exclude_patterns = ["_build"]
sphinx_gallery_conf = {
    "examples_dirs": "../examples/notebooks",
    "gallery_dirs": "notebooks",
    "filename_pattern": "/plot_",
    "ignore_pattern": r"drawing\.py",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_memory": False,
    "remove_config_comments": True,
}
default_role = "py:obj"  # docstrings name things in single backquotes
toc_object_entries_show_parents = "hide"
html_math_renderer = "formulas"
html_theme = "furo"
html_title = "geomstats-anim"
html_static_path = ["_static"]
html_css_files = ["style.css"]
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#7b3fb5", "color-brand-content": "#7b3fb5"},
    "dark_css_variables": {"color-brand-primary": "#b48be0", "color-brand-content": "#b48be0"},
}
copybutton_prompt_text = r">>> |\.\.\. "
copybutton_prompt_is_regexp = True

_METADATA = "fit inverse_transform partial_fit predict predict_proba score transform".split()
autodoc_default_options = {
    "members": True,
    "exclude-members": ", ".join(f"set_{name}_request" for name in _METADATA),  # scikit-learn's own, on estimators
}
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # docstrings say types, and shapes
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False


def _escape(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Let ``|m|`` in a docstring be a length and ``*space.shape`` a shape, outside of backquotes."""
    for number, line in enumerate(lines):
        parts = line.split("`")
        parts[::2] = [re.sub(r"\|(\w+)\||\*space\.shape", _escaped, part) for part in parts[::2]]
        lines[number] = "`".join(parts)


def _escaped(found: re.Match[str]) -> str:
    return re.sub(r"([|*])", r"\\\1", found[0])


def setup(app: Any) -> None:
    """Listen to autodoc."""
    app.connect("autodoc-process-docstring", _escape)

"""Sphinx builds the documentation from here: sphinx-build -W --keep-going -b html docs docs/_build/html.

Nothing is fetched: formulas become MathML when the pages are built, and figures are files in docs/images.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.utils.math import latex2mathml

import geomstats_anim

sys.path.insert(0, str(Path(__file__).parent))

project = "geomstats-anim"
author = "The geomstats-anim authors"
copyright = author
version = release = geomstats_anim.__version__

extensions = ["sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton", "verbs"]
exclude_patterns = ["_build"]
smartquotes = False  # they would make dashes of options
default_role = "py:obj"  # docstrings name things in single backquotes
toc_object_entries_show_parents = "hide"
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

autodoc_default_options = {"members": True, "show-inheritance": True}
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # docstrings say types, and shapes
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False


def _mathml(text: str, as_block: bool) -> str:
    """Turn a formula into MathML, which browsers draw without a script."""
    return latex2mathml.tex2mathml(text, as_block=as_block)


def _visit_inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(_mathml(node.astext(), as_block=False))
    raise nodes.SkipNode


def _visit_block(translator: Any, node: nodes.math_block) -> None:
    text = node.astext()
    if r"\\" in text and r"\begin" not in text:
        text = rf"\begin{{aligned}} {text} \end{{aligned}}"
    translator.body.append(f'<div class="math">{_mathml(text, as_block=True)}</div>\n')
    raise nodes.SkipNode


def setup(app: Any) -> None:
    """Draw formulas as MathML."""
    app.add_html_math_renderer("mathml", (_visit_inline, None), (_visit_block, None))


html_math_renderer = "mathml"

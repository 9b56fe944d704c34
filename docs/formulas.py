"""Sphinx renderer of formulas: matplotlib's mathtext draws them into the page as SVG; no script, font or network."""

from __future__ import annotations

import re
from html import escape
from typing import Any

from docutils import nodes
from matplotlib.font_manager import FontProperties
from matplotlib.path import Path
from matplotlib.textpath import TextPath
from sphinx.util import logging

_FONT = FontProperties(math_fontfamily="stix")
_UNITS = 100.0  # of the SVG, for one em
_LARGER = 1.06  # than the text around
_COMMANDS = {Path.MOVETO: "M", Path.LINETO: "L", Path.CURVE3: "Q", Path.CURVE4: "C"}
_log = logging.getLogger(__name__)


def _svg(tex: str, block: bool) -> str:
    tex = " ".join(tex.replace(r"\tfrac", r"\frac").split())
    path = TextPath((0.0, 0.0), f"${tex}$", _UNITS, prop=_FONT)
    box = path.get_extents()
    outline = "".join(
        "Z"
        if code == Path.CLOSEPOLY
        else _COMMANDS[code] + " ".join(f"{x:.1f} {-y:.1f}" for x, y in corners.reshape(-1, 2))
        for corners, code in path.iter_segments(curves=True, simplify=False)
    )
    left, right = box.x0 - 2.0, box.x1 + 2.0
    low, high = box.y0 - 2.0, box.y1 + 2.0
    scale = _LARGER * (1.12 if block else 1.0) / _UNITS
    style = (
        f"width:{scale * (right - left):.3f}em;height:{scale * (high - low):.3f}em;vertical-align:{scale * low:.3f}em"
    )
    view = f"{left:.1f} {-high:.1f} {right - left:.1f} {high - low:.1f}"
    return (
        f'<svg class="formula" role="img" aria-label="{escape(tex)}" viewBox="{view}" style="{style}">'
        f'<path fill="currentColor" d="{outline}"/></svg>'
    )


def _drawn(node: nodes.Node, tex: str, block: bool) -> str:
    try:
        return _svg(tex, block)
    except ValueError as error:
        _log.warning("mathtext cannot draw %r: %s", tex, str(error).splitlines()[-1], location=node)
        return f"<code>{escape(tex)}</code>"


def _visit_inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(_drawn(node, node.astext(), block=False))
    raise nodes.SkipNode


def _visit_block(translator: Any, node: nodes.math_block) -> None:
    lines = [line for line in re.split(r"\\\\|\n\s*\n", node.astext()) if line.strip()]
    drawn = "".join(f"<div>{_drawn(node, line, block=True)}</div>" for line in lines)
    translator.body.append(f'<div class="math">{drawn}</div>\n')
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    """Add the renderer."""
    app.add_html_math_renderer("formulas", (_visit_inline, None), (_visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}

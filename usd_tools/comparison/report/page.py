"""The page of a comparison: one file with tables, figures and a player, which needs no network."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from usd_tools.comparison.acl import ACL, SOURCE
from usd_tools.comparison.distortion import METHODS, RateDistortion
from usd_tools.comparison.report.charts import curves
from usd_tools.comparison.report.figures import Picture, telling
from usd_tools.comparison.report.player_data import player_data
from usd_tools.comparison.report.scenes import Scene
from usd_tools.comparison.trials import Row
from usd_tools.figures.style import look, percent
from usd_tools.player.scripts import read_scripts, script_json

_HERE = Path(__file__).parent

COLUMNS = {
    "rate": "kept",
    "scheme": "scheme",
    "sample": "scored on",
    "keys": "keys",
    "q_loc": "Q_loc, m²",
    "q_rot": "Q_rot, rad",
    "q_hyb": "Q_hyb",
    "mean_rotation_deg": "mean, °",
    "mean_location_cm": "mean, cm",
    "max_location_cm": "largest, cm",
    "skate_cm_per_second": "skate, cm/s",
    "floating_cm": "floating, cm",
    "bytes_numpy": "bytes, NumPy",
    "bytes_usdc": "bytes, usdc",
}
"""Columns of the long tables: all that are the same in every run."""


def write_page(
    path: Path,
    figures: Path,
    head: Mapping[str, Any],
    rows: Sequence[Row],
    points: Sequence[RateDistortion],
    scenes: Sequence[Scene],
    pictures: Sequence[Picture],
) -> None:
    """Write the page.

    Parameters
    ----------
    path : Path
    figures : Path
        Folder of the pictures.
    head : mapping
        What results.json says before its rows.
    rows : sequence of Row
    points : sequence of RateDistortion
    scenes : sequence of Scene
        Without any, there are neither figures nor a player.
    pictures : sequence of Picture
    """
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_HERE),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    kind = head["settings"]["kind"]
    clips = [clip["clip"] for clip in head["clips"]]
    first = [scene for scene in scenes if scene.name == scenes[0].name]
    data = player_data(scenes, telling(first)) if scenes else None
    text = environment.get_template("page.html").render(
        head=head,
        kind=kind,
        columns=list(COLUMNS.values()),
        qualities=[_matrix(rows, clips, kind, unseen) for unseen in (False, True)],
        methods=_methods(points),
        source=SOURCE if ACL in _methods(points) else "",
        sizes=_sizes(points),
        long_tables={clip: [_cells(row) for row in rows if row.clip == clip] for clip in clips},
        failures=[row for row in rows if row.error is not None],
        pictures=[(picture, _embedded(figures / f"{picture.name}.svg")) for picture in pictures],
        stride=data["clips"][0]["frames"][1] if data and len(data["clips"][0]["frames"]) > 1 else 1,
        data=data and script_json(data),
        scripts=read_scripts(_HERE / "chart.js", _HERE / "player.js"),
        style=(_HERE / "page.css").read_text(encoding="utf-8"),
    )
    path.write_text(text, encoding="utf-8")


def _embedded(svg: Path) -> str:
    return f"data:image/svg+xml;base64,{base64.b64encode(svg.read_bytes()).decode('ascii')}"


def _matrix(rows: Sequence[Row], clips: Sequence[str], kind: str, unseen: bool) -> dict[str, Any]:
    """Make a table of quality: clips and rates down, schemes across, the best in each row marked."""
    by_clip = {clip: curves(rows, clip, kind, unseen) for clip in clips}
    words = list(dict.fromkeys(word for by_word in by_clip.values() for word in by_word))
    lines = []
    for clip, by_word in by_clip.items():
        for rate in dict.fromkeys(row.rate for row in rows if row.clip == clip):
            values = [by_word.get(word, {}).get(rate) for word in words]
            best = min((value for value in values if value is not None), default=None)
            cells = [
                ("–" if value is None else f"{value:.4g}", value is not None and value == best) for value in values
            ]
            lines.append({"clip": clip, "kept": percent(rate), "cells": cells})
    return {"words": [(word, look(word.partition(", ")[0]).color) for word in words], "lines": lines}


def _methods(points: Sequence[RateDistortion]) -> list[str]:
    """Name the methods whose bytes are shown: ACL where it is known."""
    return [*METHODS, *([ACL] if any(point.method == ACL for point in points) else [])]


def _sizes(points: Sequence[RateDistortion]) -> list[dict[str, Any]]:
    """Make a table of bytes: clips and tolerances down, methods across."""
    found = {(point.clip, point.tolerance_cm, point.method): point.bytes for point in points}
    lines = dict.fromkeys((clip, tolerance) for clip, tolerance, _ in found)
    cells = {line: [found.get((*line, method)) for method in _methods(points)] for line in lines}
    return [
        {"clip": clip, "tolerance": f"{tolerance:g} cm", "cells": ["–" if n is None else str(n) for n in row]}
        for (clip, tolerance), row in cells.items()
    ]


def _figure(value: float | None) -> str:
    return "" if value is None else str(value) if isinstance(value, int) else f"{value:.4g}"


def _cells(row: Row) -> dict[str, Any]:
    """Make a line of a long table."""
    if not row.out_of_sample:
        sample = "whole clip" if row.family is None else "whole clip, in-sample"
    else:
        learned = {"predict": ", learned from first to predict", "reconstruct": ", fitted to first"}
        sample = "second half" + learned.get(row.purpose or "", "")
    if row.library is not None:
        sample += f", library {row.library}"
    texts = [percent(row.rate), row.scheme, sample]
    if row.error is None:
        figures = [getattr(row, name) for name in list(COLUMNS)[3:]]
        texts += [_figure(value) for value in figures]
    return {"texts": texts, "error": row.error, "color": look(row.scheme).color, "unseen": row.out_of_sample}

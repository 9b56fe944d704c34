"""The report of a comparison: its figures, and its page."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from usd_tools.comparison.distortion import RateDistortion
from usd_tools.comparison.report.figures import draw_all
from usd_tools.comparison.report.page import write_page
from usd_tools.comparison.report.scenes import scenes
from usd_tools.comparison.results import ComparedClip
from usd_tools.comparison.trials import Row, TrialResult


def write_report(
    folder: Path,
    head: Mapping[str, Any],
    clips: Sequence[ComparedClip],
    results: Sequence[TrialResult],
    rows: Sequence[Row],
    points: Sequence[RateDistortion] = (),
    advance: Callable[[float, str], None] = lambda amount, what: None,
) -> None:
    """Draw the figures and write the page.

    Parameters
    ----------
    folder : Path
        Gets a folder `figures`, and `index.html`.
    head : mapping
        What results.json says before its rows.
    clips : sequence of ComparedClip
    results : sequence of TrialResult
    rows : sequence of Row
    points : sequence of RateDistortion
    advance : callable
        Told what is drawn.
    """
    seen = scenes(clips, results)
    figures = folder / "figures"
    figures.mkdir()
    pictures = []
    for picture in draw_all(figures, seen, rows, points, head["settings"]["kind"]):
        pictures.append(picture)
        advance(1.0, f"Drawing: {picture.name}")
    write_page(folder / "index.html", figures, head, rows, points, seen, pictures)

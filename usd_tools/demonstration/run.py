"""The work of `demo`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from usd_tools.comparison.options import CompareOptions
from usd_tools.comparison.run import compare_files
from usd_tools.console.progress import ProgressCallback
from usd_tools.demonstration.result import DemoResult
from usd_tools.example_clips.body import build_skin
from usd_tools.example_clips.motions import MOTIONS
from usd_tools.example_clips.stage import make_stage
from usd_tools.files.folders import check_folder, made_beside
from usd_tools.files.openusd_errors import openusd_errors

TOOL = "usd_tools.demo"

_MOTION, _RATE, _SCHEMES = "pitching", 0.1, ("slerp", "geodesic-spline")


@openusd_errors()
def make_demo(out: Path, progress: ProgressCallback | None, warn: Callable[[str], None] | None) -> DemoResult:
    """Make the demonstration; see `usd_tools.demo.demo`."""
    check_folder(out, TOOL, ())
    options = CompareOptions(rates=(_RATE,), schemes=_SCHEMES)  # type: ignore[arg-type]
    with made_beside(out, TOOL) as folder:
        stage = make_stage(MOTIONS[_MOTION](), build_skin())
        clip = folder / f"{_MOTION}.usda"
        clip.write_text(stage.GetRootLayer().ExportToString(), encoding="utf-8", newline="\n")
        compared = compare_files([clip], folder / "comparison", options, progress, warn)
    rows = [row for row in compared.as_dict()["rows"] if not row["out_of_sample"]]
    return DemoResult(
        out,
        out / clip.name,
        out / "comparison" / "index.html",
        out / "comparison" / "figures" / f"{_MOTION}-overlay.png",
        rows[0]["frames"],
        rows[0]["keys"],
        {row["scheme"]: (row["mean_location_cm"], row["max_location_cm"]) for row in rows},
    )

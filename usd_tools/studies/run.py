"""The work of `study`."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from usd_tools.comparison.report.scenes import Scene, joined, scenes
from usd_tools.comparison.results import ComparedClip
from usd_tools.comparison.run import read_compared
from usd_tools.comparison.trials import all_trials, measure
from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.progress import Progress, ProgressCallback
from usd_tools.files.folders import check_folder, made_beside
from usd_tools.files.openusd_errors import openusd_errors, usd_warnings
from usd_tools.player.characters import Character
from usd_tools.player.scripts import read_scripts, script_json
from usd_tools.studies.options import StudyOptions
from usd_tools.studies.pairs import QUESTIONS, all_pairs
from usd_tools.studies.result import StudyResult

TOOL = "usd_tools.study"
ORIGINAL = "original"
_HERE = Path(__file__).parent


@openusd_errors()
def make_study(
    sources: Sequence[Path],
    out: Path,
    options: StudyOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> StudyResult:
    """Write the page; see `usd_tools.study.study`."""
    messages = Messages(warn)
    check_folder(out, TOOL, ())
    with usd_warnings(messages):
        clips, _ = read_compared(sources, options, messages)
        check_folder(out, TOOL, [each.path for each in clips])
        found = _rebuilt(clips, options, messages, progress)
        data = _page_data(found, options.seed)
        with made_beside(out, TOOL) as folder:
            (folder / "index.html").write_text(_page(data), encoding="utf-8")
    words = dict.fromkeys(word for scene in found for word in scene.rebuilt)
    names = tuple(scene.name for scene in found)
    return StudyResult(out, out / "index.html", names, tuple(words), len(data["pairs"]), tuple(messages.warnings))


def _rebuilt(
    clips: Sequence[ComparedClip], options: StudyOptions, messages: Messages, progress: ProgressCallback | None
) -> list[Scene]:
    """Rebuild every clip by every scheme, and keep those of which there is a pair."""
    names = [each.name for each in clips]
    wanted = [trial for trial in all_trials(names, [options.rate], options.schemes) if not trial.unseen]
    takes, results = {each.name: each.take for each in clips}, []
    bar = Progress(progress, len(wanted), "Rebuilding")
    for trial in wanted:
        result = measure(trial, takes[trial.clip], "hyb")
        if result.row.error is not None:
            messages.warn(f"{trial} failed: {result.row.error}")
        results.append(result)
        bar.advance(1.0, f"Rebuilding: {trial}")
    found = [scene for scene in scenes(clips, results) if len(scene.rebuilt) > 1]
    if not found:
        raise ToolError("No clip could be rebuilt by two schemes; see the warnings.")
    return found


def _page_data(found: Sequence[Scene], seed: int) -> dict[str, Any]:
    """Return what the page shows and asks, as plain values."""
    pairs = all_pairs({scene.name: tuple(scene.rebuilt) for scene in found}, seed)
    clips = [_clip_data(scene) for scene in found]
    data = {"questions": QUESTIONS, "clips": clips, "pairs": [asdict(pair) for pair in pairs]}
    return {"study": hashlib.sha256(json.dumps(data).encode()).hexdigest()[:16], **data}


def _clip_data(scene: Scene) -> dict[str, Any]:
    rebuilt = {word: joined(each.stretches) for word, each in scene.rebuilt.items()}
    character = Character.of(scene.compared.clip, scene.original, list(rebuilt.values()))
    motions = {ORIGINAL: scene.original, **rebuilt}
    return {
        "name": scene.name,
        "character": character.as_dict(),
        "motions": {word: character.motion(motion) for word, motion in motions.items()},
    }


def _page(data: dict[str, Any]) -> str:
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_HERE), autoescape=True, undefined=jinja2.StrictUndefined
    )
    return environment.get_template("study.html").render(
        data=script_json(data), scripts=read_scripts(_HERE / "study.js")
    )

"""Write what a comparison leaves on disk besides its report: rows as JSON and CSV, and every rebuilt clip as USD."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

import numpy as np

from usd_tools.comparison.result import CompareResult
from usd_tools.comparison.trials import Rebuilt, Row, TrialResult, rebuild
from usd_tools.console.errors import Messages
from usd_tools.learning.clips import TrainingClip
from usd_tools.skel.channels import JOINT_CHANNELS, Channel
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.resampling import resample, signs_towards
from usd_tools.skel.writer import OverrideLayer, save

COLUMNS = tuple(field.name for field in fields(Row))
"""Columns of results.csv, and keys of the rows in results.json."""


@dataclass(frozen=True, eq=False)
class ComparedClip:
    """A clip that is compared.

    Parameters
    ----------
    name : str
        Unique in the comparison, and fit for a folder.
    path : Path
        File that it is in.
    clip : SkelClip
    take : TrainingClip
    """

    name: str
    path: Path
    clip: SkelClip
    take: TrainingClip


def named(clips: Sequence[tuple[Path, SkelClip, TrainingClip]]) -> list[ComparedClip]:
    """Name clips after their files, and after their prims where a file has several."""
    named: dict[str, ComparedClip] = {}
    files = [path for path, _, _ in clips]
    for path, clip, take in clips:
        words = [path.stem] if files.count(path) == 1 else [path.stem, clip.source.prim.GetName()]
        base = re.sub(r"[^\w.-]", "_", "-".join(words))
        name, number = base, 1
        while name in named:
            number += 1
            name = f"{base}-{number}"
        named[name] = ComparedClip(name, path, clip, take)
    return list(named.values())


def write_results(folder: Path, result: CompareResult) -> None:
    """Write results.json and results.csv.

    Parameters
    ----------
    folder : Path
    result : CompareResult
    """
    (folder / "results.json").write_text(json.dumps(result.as_dict(), indent=1) + "\n", encoding="utf-8")
    with open(folder / "results.csv", "w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(asdict(row) for row in result.rows)


def write_rebuilt(
    folder: Path, compared: ComparedClip, result: TrialResult, tool: str, kind: str, messages: Messages
) -> str:
    """Write a rebuilt clip as a layer over its source, in the folder `usd`.

    Every kept sample is the source's, bit for bit; the metric is stored with the animation.

    Parameters
    ----------
    folder : Path
        Of the comparison.
    compared : ComparedClip
    result : TrialResult
        Of the whole clip, without error.
    tool, kind : str
        For the layer's `customLayerData`.
    messages : Messages

    Returns
    -------
    name : str
        Of the file, as seen from the folder.
    """
    trial, clip = result.trial, compared.clip
    scheme = trial.choice.scheme
    rebuilt = rebuild(compared.take.stretches, trial.rate, scheme, result.metric, result.helps)
    settings = {"rate": trial.rate, "scheme": trial.choice.word, "kind": kind}
    layer = OverrideLayer(clip.source.stage, tool, settings)
    metric = None if result.metric is None else result.metric.for_joints(clip.joints)[0]
    layer.write_animation(clip.source, rebuilt_channels(clip, compared.take, rebuilt), clip.missing, metric, messages)
    name = f"usd/{trial.clip}/{trial.rate:g}/{trial.choice.word.replace(':', '_')}.usdc"
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    save(layer, compared.path, folder / name)
    return name


def rebuilt_channels(clip: SkelClip, take: TrainingClip, rebuilt: Rebuilt) -> dict[str, Channel]:
    """Replace all samples of a clip that were not kept.

    Within a stretch there are samples where the rotations have them; outside of all stretches, the clip's own.
    """
    aligned = resample(clip, clip.codes, "slerp").channels
    spans = [stretch.times for stretch in take.stretches]
    channels = {}
    for name in JOINT_CHANNELS:
        if name not in aligned:
            continue
        channel = aligned[name]
        times = channel.codes / clip.codes_per_second  # the same division as in `takes`, so that they are equal
        kept = np.ones(len(times), dtype=bool)
        for span in spans:
            kept &= (times < span[0]) | (times > span[-1]) | np.isin(times, span)
        values, times = channel.values[kept], times[kept]
        for stretch, keys in zip(rebuilt.stretches, rebuilt.keys, strict=True):
            between = np.delete(np.arange(stretch.n_frames), keys)
            new = clip.to_file_units(name, stretch)[between]
            place = np.searchsorted(times, stretch.times[between])
            if name == "rotations":  # signs as in the source, for DCCs that interpolate components
                new = new * signs_towards(values[place], new)
            values[place] = new
        channels[name] = replace(channel, codes=channel.codes[kept], values=values, blocked=channel.blocked[kept])
    return channels

"""Learn a library of in-betweens from clips of one rig, and write it."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from geomstats_anim.learning.library.learn_library import learn_library
from geomstats_anim.learning.library.samples import GAP_RATE, GAPS
from geomstats_anim.learning.library.storage import dump_library
from usd_tools.console.errors import ToolError
from usd_tools.console.progress import Progress, ProgressCallback
from usd_tools.files.atomic import written_beside
from usd_tools.learning.clips import TrainingClip
from usd_tools.learning.options import LearnOptions
from usd_tools.learning.result import LibraryReport

_SAME_VERTICAL = 0.98
"""Cosine between verticals that are the same."""


def learn_library_file(
    clips: Sequence[TrainingClip], out: Path, options: LearnOptions, progress: ProgressCallback | None
) -> LibraryReport:
    """Learn a library and write it.

    Raises
    ------
    ToolError
        If the clips are too short, or stand on different axes, Ray is asked for but not there, or the file cannot be
        written.
    """
    vertical = clips[0].vertical
    for clip in clips:
        if np.dot(clip.vertical, vertical) < _SAME_VERTICAL:
            raise ToolError(f"{clip} and {clips[0]} have different axes upwards; leave one of them out.")
    stretches = [stretch for clip in clips for stretch in clip.stretches]
    bar = Progress(progress, len(GAPS), "Learning the library")
    provenance = {
        "files": [clip.file for clip in clips],
        "sha256": [clip.sha256 for clip in clips],
        "prims": [clip.prim for clip in clips],
        "frames": [clip.n_frames for clip in clips],
        "seed": options.seed,
    }
    try:
        library = learn_library(
            stretches,
            vertical,
            seed=options.seed,
            provenance=provenance,
            progress=lambda done: bar.advance(1.0),
            address=options.address,
            cpus=options.cpus,
        )
    except (ValueError, ModuleNotFoundError, ConnectionError) as error:
        raise ToolError(str(error)) from error
    data = dump_library(library)
    with written_beside(out) as beside:
        beside.write_bytes(data)
    joints = library.skeleton.joints
    return LibraryReport(
        clips=tuple(map(str, clips)),
        frames=sum(clip.n_frames for clip in clips),
        parts=tuple(
            {"part": kind, "joints": [joints[joint] for joint in part]}
            for kind, part in zip(library.parts.kinds, library.parts.joints, strict=True)
        ),
        gaps=tuple(round(model.gap / GAP_RATE, 4) for model in library.models),
        bytes=len(data),
        sha256=hashlib.sha256(data).hexdigest(),
    )

"""The metric with which some frames of baked motion rebuild the others best."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from geomstats_anim import Animation, learn_metric
from geomstats_anim import rotations as quat
from geomstats_anim.names import LEARNABLE
from geomstats_anim.rotations import Array
from usd_tools.console.errors import ToolError
from usd_tools.console.progress import ProgressCallback, SearchProgress
from usd_tools.serving.channels import codec
from usd_tools.serving.requests import OBJECT, Rig, groups_of


def learned(
    header: Mapping[str, Any], arrays: Mapping[str, np.ndarray], progress: ProgressCallback | None = None
) -> tuple[dict[str, Any], dict[str, Array]]:
    """Answer a request for a learned metric.

    Parameters
    ----------
    header : mapping
        As for in-betweens; one group, of all frames; and settings, arguments of `learn_metric` by name.
    arrays : mapping of str to array-like
        The same; and keys, indices of frames.
    progress : callable
        Optional, default: nobody is told.

    Returns
    -------
    header : dict
        metric, its document.
    arrays : dict
        Empty.

    Raises
    ------
    ToolError
        If the request does not fit, or nothing can be learned.
    """
    rig = Rig.of(header, arrays)
    if rig.metric.scheme not in LEARNABLE:
        raise ToolError(f"Nothing can be learned for {rig.metric.scheme}; choose {' or '.join(LEARNABLE)}.")
    (group,) = groups_of(header, arrays, rig)
    shape = (len(group.times), rig.skeleton.n_joints)
    rotations = np.tile(rig.skeleton.rest_rotations, (shape[0], 1, 1))
    translations = np.tile(rig.skeleton.rest_translations, (shape[0], 1, 1))
    for track in group.tracks:
        if track.joint == OBJECT:
            continue
        rest = rig.skeleton.rest_rotations[track.joint]
        parts = codec(track.channel, track.values).split(track.values)
        if track.channel == "location":
            translations[:, track.joint] += rig.metres * quat.rotate(rest, track.values)
        elif track.turns:
            rotations[:, track.joint] = quat.multiply(rest, parts.turns)
    animation = Animation(rig.skeleton, group.times, rotations, translations)
    settings = dict(header.get("settings", {}))
    watch: Callable[[int, float], None] = SearchProgress(progress, None).watch
    found = learn_metric(animation, arrays["keys"], scheme=rig.metric.scheme, progress=watch, **settings)
    return {"metric": json.loads(found.to_json())}, {}

"""In-betweens of tracks, by the schemes of `geomstats_anim`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geomstats_anim import Animation, Skeleton
from geomstats_anim import rotations as quat
from geomstats_anim.interpolation.curves import Curve, Fallback, locate
from geomstats_anim.interpolation.schemes import make_curve
from geomstats_anim.names import DEFAULT_SCHEME, LEARNED, SCHEME_NAMES, WITH_METRIC
from geomstats_anim.rotations import Array
from usd_tools.console.errors import ToolError
from usd_tools.console.text import did_you_mean
from usd_tools.serving.channels import codec
from usd_tools.serving.requests import OBJECT, Group, Rig, groups_of
from usd_tools.skel.xform_motion import Parts

if TYPE_CHECKING:
    from geomstats_anim import MotionLibrary

_OBJECT_NAME = "//object"
"""No bone has this name."""


def in_betweens(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> tuple[dict[str, Any], dict[str, Array]]:
    """Answer a request for in-betweens.

    Parameters
    ----------
    header : mapping
        joints, parents, metric (a document, whose scheme is used), metres, library (a path or None), and groups: for
        each of them a list of joint and channel.
    arrays : mapping of str to array-like
        rest, and those of the groups; see `groups_of`.

    Returns
    -------
    header : dict
        notes, sentences.
    arrays : dict of str to array-like
        Values at the wanted times, shape=[F, C], named as the tracks are.

    Raises
    ------
    ToolError
        If the request does not fit.
    """
    rig = Rig.of(header, arrays)
    groups = groups_of(header, arrays, rig)
    scheme = rig.metric.scheme
    if scheme not in SCHEME_NAMES:
        raise ToolError(f"There is no scheme {scheme!r}{did_you_mean(scheme, SCHEME_NAMES)}")
    library = read_library(header, groups, rig) if scheme == LEARNED else None
    fallbacks: list[Fallback] = []
    spun: dict[str, None] = {}
    results = {}
    for g, group in enumerate(groups):
        found, spinning, values = _interpolated(group, rig, library)
        fallbacks += found
        spun.update(dict.fromkeys(spinning))
        results.update({f"{g}/{i}": each for i, each in enumerate(values)})
    notes = [f"{len(fallbacks)} segments are slerped. The first: {fallbacks[0]}"] if fallbacks else []
    if spun:
        notes.append(
            f"Angles that go half a turn or further are interpolated themselves, without metric: {', '.join(spun)}."
        )
    return {"notes": notes}, results


def read_library(header: Mapping[str, Any], groups: Sequence[Group], rig: Rig) -> MotionLibrary:
    """Read the library, and refuse what it cannot be used for."""
    path = header.get("library")
    if not isinstance(path, str) or not path:
        raise ToolError(f"The scheme {LEARNED} needs a library; choose its file.")
    from usd_tools.libraries.files import UPRIGHT, LibraryFile

    file = LibraryFile.read(Path(path))
    if sum(group.poses for group in groups) > 1:
        raise ToolError(f"The scheme {LEARNED} needs whole poses; key all bones on the same frames.")
    difference = file.library.rig_difference(rig.skeleton)
    if not difference and file.library.vertical @ np.array(header["up"], dtype=np.float64) < UPRIGHT:
        difference = "another axis is up"
    if difference:
        raise ToolError(f"The armature is of another rig than the library {file.name}: {difference}.")
    return file.library


def _interpolated(
    group: Group, rig: Rig, library: MotionLibrary | None
) -> tuple[tuple[Fallback, ...], list[str], list[Array]]:
    """Interpolate the tracks of a group as animations: turns and paths of joints, and angles as paths of their own.

    Returned are segments that are slerped, joints whose angles are paths, and the values of the tracks.
    """
    codecs = [codec(track.channel, track.values) for track in group.tracks]
    keys = [each.split(track.values) for track, each in zip(group.tracks, codecs, strict=True)]
    spins = [track.turns and bool(part.path.any()) for track, part in zip(group.tracks, keys, strict=True)]
    segment = locate(group.times, group.wanted)[0]
    fallbacks: tuple[Fallback, ...] = ()
    values: list[Array] = [np.zeros((0, 0))] * len(group.tracks)
    for spin in (False, True):
        chosen = [i for i, each in enumerate(spins) if each == spin]
        if not chosen:
            continue
        tracks = [group.tracks[i] for i in chosen]
        use = library if not spin and group.poses else None
        joints = list(range(rig.skeleton.n_joints)) if use else []
        joints += sorted({track.joint for track in tracks} - set(joints))
        columns = [joints.index(track.joint) for track in tracks]
        posed = _posed(rig, joints, columns, [keys[i] for i in chosen], len(group.times))
        curve = _curve(Animation(_flat(rig, joints), group.times, *posed), rig, use)
        dense, fallbacks = curve(group.wanted), (*fallbacks, *curve.fallbacks)
        assert dense.scales is not None
        rest = quat.conjugate(_rest(rig, joints))
        for i, b in zip(chosen, columns, strict=True):
            parts = Parts(quat.multiply(rest[b], dense.rotations[:, b]), dense.translations[:, b], dense.scales[:, b])
            values[i] = codecs[i].join(parts, group.tracks[i].values, segment)
    names = [*rig.skeleton.joints, "the armature"]
    return fallbacks, [names[group.tracks[i].joint] for i, each in enumerate(spins) if each], values


def _rest(rig: Rig, joints: Sequence[int]) -> Array:
    """Return the rest rotations of joints, shape=[J, 4]; of the object, the identity."""
    return np.concatenate([rig.skeleton.rest_rotations, quat.IDENTITY[None]])[list(joints)]


def _posed(
    rig: Rig, joints: Sequence[int], columns: Sequence[int], keys: Sequence[Parts], n_keys: int
) -> tuple[Array, Array, Array]:
    """Put the keys of tracks beside one another: rotations from the parent, paths and sizes, shape=[K, J, ...]."""
    shape = (n_keys, len(joints))
    turns = np.tile(quat.IDENTITY, (*shape, 1))
    paths, sizes = np.zeros((*shape, 3)), np.ones((*shape, 3))
    for b, part in zip(columns, keys, strict=True):
        # what a track does not have is at rest
        turns[:, b] = quat.multiply(turns[:, b], part.turns)
        paths[:, b] += part.path
        sizes[:, b] *= part.sizes
    return quat.multiply(_rest(rig, joints), turns), paths, sizes


def _flat(rig: Rig, joints: Sequence[int]) -> Skeleton:
    """Return joints without their tree, which schemes do not ask for; libraries get the tree that they know."""
    if len(joints) >= rig.skeleton.n_joints and OBJECT not in joints:
        return rig.skeleton
    names = [*rig.skeleton.joints, _OBJECT_NAME]
    flat = tuple(names[joint] for joint in joints)
    return Skeleton(flat, np.full(len(flat), -1), np.zeros((len(flat), 3)), _rest(rig, joints))


def _curve(animation: Animation, rig: Rig, library: MotionLibrary | None) -> Curve:
    """Make the curve; what is not a joint of a library follows its spline, and what carries the joints has no style."""
    scheme = rig.metric.scheme
    if scheme == LEARNED and library is None:
        scheme = DEFAULT_SCHEME
    metric = rig.metric.for_joints(animation.skeleton.joints)[0] if scheme in WITH_METRIC else None
    return make_curve(animation, scheme, metric, library)

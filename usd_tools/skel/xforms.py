"""Find the transform ops that move a character as a whole, and interpolate them as its joints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from pxr import Usd, UsdGeom, UsdLux, UsdSkel

from geomstats_anim import Animation, Skeleton
from geomstats_anim.rotations import IDENTITY
from usd_tools.skel.channels import Channel, held
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.cuts import find_cuts
from usd_tools.skel.find import AnimationSource
from usd_tools.skel.resampling import merged_codes
from usd_tools.skel.xform_motion import Codec, Parts, codec_of
from usd_tools.skel.xform_ops import read_op

_ONE = Skeleton(("xform",), np.array([-1]), np.zeros((1, 3)), IDENTITY[None])


@dataclass(frozen=True, eq=False)
class XformOp:
    """A transform op that has samples.

    Parameters
    ----------
    attribute : Usd.Attribute
    channel : Channel
        One element, whose numbers are as in `codec_of`.
    codec : Codec
    gaps : array-like of bool, shape=[K]
        Which samples were not finite, so that they were filled in; None if all were.
    """

    attribute: Usd.Attribute
    channel: Channel
    codec: Codec
    gaps: np.ndarray | None = None


class FoundOps(NamedTuple):
    """Hold the ops that move a character, and sentences on those that cannot be interpolated."""

    ops: tuple[XformOp, ...]
    notes: tuple[str, ...]


def find_xform_ops(source: AnimationSource, fills_gaps: bool = False) -> FoundOps:
    """Find the sampled transform ops of an animation's skeletons and of what is above them.

    Parameters
    ----------
    source : AnimationSource
    fills_gaps : bool
        Put the sample before, or the first good one, where a sample is not finite; `gaps` tells where.
        Optional, default: False, such an op is left.

    Returns
    -------
    found : FoundOps
    """
    ops: dict[str, XformOp] = {}
    notes: dict[str, None] = {}
    for prim in _prims_above(source):
        for op in UsdGeom.Xformable(prim).GetOrderedXformOps():
            attribute = op.GetAttr()
            path = str(attribute.GetPath())
            if path in ops or attribute.GetNumTimeSamples() < 2:
                continue
            channel = source.xforms.get(path) or read_op(attribute)
            if not channel.is_animated or channel.is_constant:
                continue
            op_type = op.GetOpTypeToken(op.GetOpType())
            gaps = ~channel.is_finite[:, 0]
            good = ~(channel.blocked | gaps)
            codec = codec_of(op_type, channel.values[good, 0]) if good.any() else None
            reason = _reason_to_leave(prim, source, codec)
            if gaps.any() and not reason:
                code = channel.codes[np.argmax(gaps)]
                reason = "" if fills_gaps else f"at time code {code:g} it is not finite; usd_tools.repair fills it in"
                channel = _without_gaps(channel, gaps)
            if reason or codec is None:
                notes[f"{path} keeps its {len(channel.codes)} samples: {reason}."] = None
            else:
                ops[path] = XformOp(attribute, channel, codec, gaps if gaps.any() else None)
    return FoundOps(tuple(ops.values()), tuple(notes))


def _without_gaps(channel: Channel, gaps: np.ndarray) -> Channel:
    good = np.flatnonzero(~(gaps | channel.blocked))
    values, last = channel.values.copy(), np.maximum(np.searchsorted(good, np.flatnonzero(gaps)) - 1, 0)
    values[gaps] = channel.values[good[last]]
    return replace(channel, values=values)


def _prims_above(source: AnimationSource) -> Iterator[Usd.Prim]:
    """Yield the skeletons, and the prims above whose transforms reach them."""
    for skeleton in source.skeletons:
        prim = skeleton
        while prim and not prim.IsPseudoRoot():
            if prim.IsA(UsdGeom.Xformable):
                yield prim
                if UsdGeom.Xformable(prim).GetResetXformStack():
                    break
            prim = prim.GetParent()


def _reason_to_leave(prim: Usd.Prim, source: AnimationSource, codec: Codec | None) -> str:
    if prim.IsInstanceProxy():
        return "it is inside an instance"
    if not _is_own(prim, source):
        return f"it also moves prims that {source.path} does not drive; use --no-xforms to leave all transforms"
    return "" if codec else "its matrices are not exactly a scale, a turn and a move"


def _is_own(prim: Usd.Prim, source: AnimationSource) -> bool:
    """Check that a prim moves nothing but the skeletons of an animation, and what is in their SkelRoots."""
    own = {skeleton.GetPath() for skeleton in source.skeletons}
    below = Usd.PrimRange(prim, Usd.TraverseInstanceProxies())
    if any(each.IsA(UsdSkel.Skeleton) and each.GetPath() not in own for each in below):
        return False
    below = iter(Usd.PrimRange(prim, Usd.TraverseInstanceProxies()))
    for each in below:
        if each.IsA(UsdSkel.Root) or each.IsA(UsdSkel.Skeleton):
            if any(path.HasPrefix(each.GetPath()) for path in own):
                below.PruneChildren()
                continue
        if each.IsA(UsdGeom.Boundable) or each.IsA(UsdGeom.Camera) or each.HasAPI(UsdLux.LightAPI):
            return False
    return True


def cuts_of(op: XformOp, clip: SkelClip, look_for_cuts: bool) -> np.ndarray:
    """Return the cuts of an op, shape=[C, 2]: those of its character, and jumps of its own if they are looked for."""
    return np.concatenate([clip.cuts, _jumps(op, clip.codes_per_second)]) if look_for_cuts else clip.cuts


def resample_op(op: XformOp, codes: np.ndarray, rate: float, scheme: str, cuts: np.ndarray) -> Channel:
    """Interpolate an op; its samples stay bit for bit.

    Parameters
    ----------
    op : XformOp
    codes : array-like, shape=[F]
        Time codes, such as those of the character's samples.
    rate : float
        Time codes per second.
    scheme : str
        A name in `SCHEMES`.
    cuts : array-like, shape=[C, 2]
        See `cuts_of`.

    Returns
    -------
    channel : Channel
    """
    from geomstats_anim import SCHEMES  # which looking at a file need not wait for

    channel = op.channel
    filled = held(channel, merged_codes(channel.codes, codes, rate))
    for span in channel.stretches(rate, cuts):
        keys, numbers = channel.codes[span], channel.values[span, 0]
        inside = (filled.codes > keys[0]) & (filled.codes < keys[-1]) & ~np.isin(filled.codes, keys)
        segment = np.searchsorted(keys, filled.codes[inside], side="right") - 1
        places = np.flatnonzero(inside)[~channel.holds[span.start + segment, 0]]
        if not len(places):
            continue
        times = filled.codes[places]
        dense = SCHEMES[scheme](_animation(op.codec.split(numbers), keys / rate))(times / rate)
        assert dense.scales is not None
        parts = Parts(dense.rotations[:, 0], dense.translations[:, 0], dense.scales[:, 0])
        segment = np.searchsorted(keys, times, side="right") - 1
        filled.values[places, 0] = op.codec.join(parts, numbers, segment)
    return filled


def _jumps(op: XformOp, rate: float) -> np.ndarray:
    """Find cuts in an op alone, shape=[C, 2]."""
    found = [np.zeros((0, 2))]
    for span in op.channel.spans:
        codes = op.channel.codes[span]
        before = np.flatnonzero(find_cuts(_animation(op.codec.split(op.channel.values[span, 0]), codes / rate)))
        found.append(np.stack([codes[before], codes[before + 1]], axis=-1))
    return np.concatenate(found)


def _animation(parts: Parts, times: np.ndarray) -> Animation:
    """Make an animation of one joint that moves as an op does."""
    return Animation(_ONE, times, parts.turns[:, None], parts.path[:, None], parts.sizes[:, None])

"""Packed motion, unpacked: the samples of a SkelAnimation, and of the transforms that move its character."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from pxr import Sdf, Usd

from geomstats_anim.rotations import Array
from usd_tools.console.errors import ToolError
from usd_tools.skel.channels import JOINT_CHANNELS, Channel, held, write_values
from usd_tools.skel.packed import PACKED, WEIGHTS, PackedMotion
from usd_tools.skel.packed_xforms import unpacked_ops
from usd_tools.skel.xform_ops import op_values

if TYPE_CHECKING:
    from usd_tools.skel.clip import SkelClip
    from usd_tools.skel.find import AnimationSource


class Unpacked(NamedTuple):
    """Hold what packed motion has samples of; value blocks are where the file has them.

    Attributes
    ----------
    channels : dict of str to Channel
        Attributes of the SkelAnimation.
    xforms : dict of str to Channel
        Transform ops, by the paths of their attributes.
    """

    channels: dict[str, Channel]
    xforms: dict[str, Channel]


def unpack_motion(clip: SkelClip, packed: PackedMotion) -> Unpacked:
    """Decode packed motion.

    Parameters
    ----------
    clip : SkelClip
        As it is in the file.
    packed : PackedMotion

    Returns
    -------
    unpacked : Unpacked
        Attributes that have samples in the file.

    Raises
    ------
    ToolError
        If the stream is damaged, or of another skeleton.
    """
    channels, columns = unpacked_channels(clip, packed)
    ops = unpacked_ops(clip.source.prim, columns) if columns else {}
    xforms = {path: _at_frames(op, packed.codes, numbers[:, None]) for path, (op, numbers) in ops.items()}
    return Unpacked(channels, xforms)


def unpacked_channels(clip: SkelClip, packed: PackedMotion) -> tuple[dict[str, Channel], dict[str, Array]]:
    """Decode attributes that have samples in the file, and the columns of transforms; see `unpack_motion`."""
    from geomstats_anim.codec import StreamError, unpack, unpack_channels

    try:
        animation = unpack(packed.stream, clip.skeleton)
        others = unpack_channels(packed.stream, clip.skeleton) if packed.has_others else {}
    except StreamError as error:
        raise ToolError(f"{clip.path}: {PACKED} cannot be read: {error}") from error
    weights = others.pop(WEIGHTS, None)
    found = {}
    for name, channel in clip.channels.items():
        if not len(channel.codes):
            continue
        if name in JOINT_CHANNELS:
            if name == "scales" and animation.scales is None:
                values: Array = np.ones((len(packed.codes), len(clip.joints), 3))
            else:
                values = clip.to_file_units(name, animation)
        elif weights is not None and weights.shape[1] == channel.values.shape[1]:
            values = weights[..., None]
        else:
            raise ToolError(f"{clip.path}: {PACKED} does not hold {name}; pack the source again.")
        found[name] = _at_frames(channel, packed.codes, values)
    return found, others


def _at_frames(channel: Channel, codes: np.ndarray, values: Array) -> Channel:
    """Return a channel with other values where it is not blocked."""
    shown = held(channel, codes)
    values = values[np.isin(codes, shown.codes)].astype(channel.values.dtype)
    values[shown.blocked] = 0
    return replace(shown, values=values, source=f"{PACKED} of {channel.source}")


def unpacked_stage(source: AnimationSource) -> Usd.Stage:
    """Open the part of a stage around an animation's skeletons anew, with the samples of its packed transforms."""
    stage, session = source.stage, Sdf.Layer.CreateAnonymous(".usda")
    for path, channel in source.xforms.items():
        for prefix in Sdf.Path(path).GetPrimPath().GetPrefixes():
            if stage.GetPrimAtPath(prefix).IsInstance():
                Sdf.CreatePrimInLayer(session, prefix).SetInfo("instanceable", False)
        write_op(Sdf.CreatePrimInLayer(session, Sdf.Path(path).GetPrimPath()), stage.GetAttributeAtPath(path), channel)
    if stage.GetSessionLayer() is not None:
        session.subLayerPaths = [stage.GetSessionLayer().identifier]
    mask = Usd.StagePopulationMask([prim.GetPath() for prim in source.rig])
    opened = Usd.Stage.OpenMasked(stage.GetRootLayer(), session, stage.GetPathResolverContext(), mask)
    opened.MuteAndUnmuteLayers(stage.GetMutedLayers(), [])
    opened.SetInterpolationType(stage.GetInterpolationType())
    return opened


def write_op(
    spec: Sdf.PrimSpec, attribute: Usd.Attribute, channel: Channel, offset: Sdf.LayerOffset | None = None
) -> None:
    """Write the samples of a transform op, and no others, to the spec of its prim; an offset maps time codes."""
    name = attribute.GetName()
    own = spec.attributes.get(name) or Sdf.AttributeSpec(spec, name, attribute.GetTypeName())
    write_values(own, channel, op_values(attribute, channel.values[:, 0]), offset)

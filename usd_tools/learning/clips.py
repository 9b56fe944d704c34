"""Take from an animation what can be learned from: stretches of motion between value blocks, steps and cuts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from geomstats_anim import Animation, Skeleton
from geomstats_anim.learning.training_set import turns
from usd_tools.console.errors import ToolError
from usd_tools.console.text import counted, short_names
from usd_tools.files.stages import stage_sha256
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.resampling import sampled_together
from usd_tools.skel.vertical import up_in_world, vertical

MIN_SAMPLES = 4
"""Two segments, and a sample between keys to be rebuilt."""


@dataclass(frozen=True, eq=False)
class TrainingClip:
    """Motion of one animation, to learn from.

    Parameters
    ----------
    file : str
        Name of its file.
    sha256 : str
        Of the file, in hexadecimal digits; not of other files that it needs.
    prim : str
        Path of the SkelAnimation.
    label : str
        How to name it to a user: the file, and the prim if there are several in it.
    joints : tuple of str
        The animation's joints, in its own order.
    stretches : tuple of Animation
        All joints of the skeleton, at the samples of the rotations.
    vertical : array-like, shape=[3]
        Unit vector upwards in the space of the skeleton.
    worlds : tuple of array-like or None
        Of each stretch: where the skeleton stands in the world, see `Animation`.
    up : array-like, shape=[3]
        Unit vector upwards in the world.
    """

    file: str
    sha256: str
    prim: str
    label: str
    joints: tuple[str, ...]
    stretches: tuple[Animation, ...]
    vertical: np.ndarray
    worlds: tuple[np.ndarray | None, ...]
    up: np.ndarray

    def __str__(self) -> str:
        """Return the label."""
        return self.label

    @property
    def skeleton(self) -> Skeleton:
        """Skeleton of all stretches."""
        return self.stretches[0].skeleton

    @property
    def placed(self) -> tuple[Animation, ...]:
        """The stretches, where they stand in the world."""
        return tuple(replace(stretch, world=world) for stretch, world in zip(self.stretches, self.worlds, strict=True))

    @property
    def n_frames(self) -> int:
        """Number of frames in all stretches."""
        return sum(stretch.n_frames for stretch in self.stretches)


def training_clip(path: Path, clip: SkelClip, alone: bool = True) -> TrainingClip:
    """Take from an animation what can be learned from.

    Stretches that are too short, or in which no joint turns, are left out.

    Parameters
    ----------
    path : Path
        File that it is in.
    clip : SkelClip
    alone : bool
        Whether it is the only animation of the file.
        Optional, default: True.

    Returns
    -------
    training : TrainingClip

    Raises
    ------
    ToolError
        If there is nothing to learn from.
    """
    channel = clip.channels.get("rotations")
    if channel is None or not channel.is_animated:
        raise ToolError(f"{path}: {clip.path} has no animated rotations, so there is nothing to learn.")
    stretches = _stretches(clip)
    longest = max((stretch.n_frames for stretch in stretches), default=1)
    if longest < MIN_SAMPLES:
        between = " between value blocks, steps and cuts" if len(stretches) > 1 else ""
        raise ToolError(
            f"{path}: {clip.path} has {counted(longest, 'sample')}{between}, too few to learn from; at least "
            f"{MIN_SAMPLES} are needed."
        )
    moving = tuple(stretch for stretch in stretches if stretch.n_frames >= MIN_SAMPLES and turns(stretch))
    if not moving:
        raise ToolError(f"{path}: no joint of {clip.path} turns, so there is nothing to learn.")
    label = path.name if alone else f"{path.name}, {clip.path}"
    sha256 = stage_sha256(clip.source.stage)
    worlds = tuple(clip.placements(stretch.times * clip.codes_per_second) for stretch in moving)
    up = up_in_world(clip)
    return TrainingClip(path.name, sha256, clip.path, label, clip.joints, moving, vertical(clip), worlds, up)


def _stretches(clip: SkelClip) -> list[Animation]:
    """Return the stretches of an animation, at the samples of its rotations."""
    names = [name for name, channel in clip.channels.items() if channel.is_animated]
    sampled = np.isin(clip.codes, clip.channels["rotations"].codes)
    try:
        stretches = list(sampled_together(clip).stretches(names))
    except ValueError as error:
        raise ToolError(f"{clip.path} cannot be learned from: {error}") from error
    return [keys.at_frames(np.flatnonzero(sampled[span])) for span, keys in stretches]


def rig_difference(clip: TrainingClip, first: TrainingClip) -> str | None:
    """Describe how the rig of a clip differs from the first's; None if it has the same joints by name."""
    own, wanted = set(clip.skeleton.joints), set(first.skeleton.joints)
    if own == wanted:
        return None
    if not own & wanted:
        return f"{clip} has no joint in common with {first}"
    names, words = short_names(sorted(own | wanted)), []
    if wanted - own:
        words.append(f"lacks {len(wanted - own)} of {len(wanted)} joints, such as {names[min(wanted - own)]}")
    if own - wanted:
        words.append(f"has {counted(len(own - wanted), 'other')}, such as {names[min(own - wanted)]}")
    return f"{clip} has a different rig than {first}: it {', and '.join(words)}"


def with_joint_order(clip: TrainingClip, joints: Sequence[str]) -> TrainingClip:
    """Put the joints of a clip into another order."""
    place = {joint: i for i, joint in enumerate(clip.skeleton.joints)}
    order = np.array([place[joint] for joint in joints], dtype=np.intp)
    return replace(clip, stretches=tuple(_reordered(stretch, order) for stretch in clip.stretches))


def _reordered(animation: Animation, order: np.ndarray) -> Animation:
    old = animation.skeleton
    rank = np.argsort(order)
    parents = old.parents[order]
    skeleton = Skeleton(
        tuple(old.joints[i] for i in order),
        np.where(parents >= 0, rank[parents], -1),
        old.rest_translations[order],
        old.rest_rotations[order],
        old.bone_ends[order],
    )
    scales = None if animation.scales is None else animation.scales[:, order]
    rotations, translations = animation.rotations[:, order], animation.translations[:, order]
    return Animation(skeleton, animation.times, rotations, translations, scales, animation.world)

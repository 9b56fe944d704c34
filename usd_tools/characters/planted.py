"""Planted points of a clip: found in its samples, and those that a sparse file stores."""

from __future__ import annotations

import numpy as np

from geomstats_anim import Animation
from geomstats_anim.contacts import Contacts, Plants, find_contacts
from usd_tools.characters.placement import placed
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.resampling import sampled_together
from usd_tools.skel.source_codes import stored_source_codes
from usd_tools.skel.stored_contacts import StoredContacts, read_contacts
from usd_tools.skel.vertical import up_in_world


def found_plants(clip: SkelClip, motion: Animation) -> Plants:
    """Find what is planted in samples of a clip.

    Parameters
    ----------
    clip : SkelClip
    motion : Animation
        Of all joints of its skeleton.

    Returns
    -------
    plants : Plants
    """
    there = placed(clip, motion)
    return Plants.of(find_contacts(there, up_in_world(clip)), there)


def find_clip_contacts(clip: SkelClip) -> list[Contacts]:
    """Find what is planted in each stretch of the motion of a clip, as USD shows it; nothing where no joint turns.

    Parameters
    ----------
    clip : SkelClip
        Without gaps.
    """
    names = [name for name, channel in clip.channels.items() if channel.is_animated]
    if "rotations" not in names:
        return []
    up, together = up_in_world(clip), sampled_together(clip)
    return [find_contacts(placed(clip, keys), up) for _, keys in together.stretches(names)]


def contacts_to_store(clip: SkelClip, motions: list[Animation]) -> StoredContacts:
    """Find what is planted in stretches of a clip, as it is stored with few of the samples.

    Parameters
    ----------
    clip : SkelClip
    motions : list of Animation
        Of all joints of its skeleton.
    """
    times = clip.codes / clip.codes_per_second
    spans, places, used = [np.zeros((0, 3), dtype=np.intp)], [np.zeros((0, 3))], []
    for plants in (found_plants(clip, motion) for motion in motions):
        ends = [np.searchsorted(times, each - 1e-9) for each in (plants.starts, plants.ends)]
        spans.append(np.stack([plants.joints, *ends], axis=-1))
        places.append(_in_skeleton(clip, plants))
        used.append(plants.joints)
    joints, index = np.unique(np.concatenate(used), return_inverse=True) if used else (np.zeros(0, dtype=np.intp),) * 2
    rows = np.concatenate(spans)
    rows[:, 0] = index
    return StoredContacts(tuple(clip.skeleton.joints[joint] for joint in joints), rows, np.concatenate(places))


def stored_plants(clip: SkelClip) -> Plants | None:
    """Read what is planted in the source of a sparse clip; None if the file does not say.

    Raises
    ------
    ToolError
        If what is stored cannot be used.
    """
    codes = stored_source_codes(clip.source.prim, clip.codes)
    contacts = None if codes is None else read_contacts(clip.source.prim, codes.n_all)
    if codes is None or contacts is None:
        return None
    place = {joint: k for k, joint in enumerate(clip.skeleton.joints)}
    joints = np.array([place.get(joint, -1) for joint in contacts.joints], dtype=np.intp)[contacts.spans[:, 0]]
    first, last = (contacts.spans[:, 1:] - codes.n_before).T
    inside = (joints >= 0) & (last > 0) & (first < len(codes.codes) - 1)
    starts, ends = (codes.codes[np.clip(k[inside], 0, len(codes.codes) - 1)] for k in (first, last))
    middles = 0.5 * (starts + ends)
    places = contacts.places[inside] * clip.world_scale
    worlds = clip.placements(middles)
    if worlds is not None:
        places = (worlds[:, :, :3] @ places[..., None])[..., 0] + worlds[:, :, 3]
    rate = clip.codes_per_second
    return Plants(joints[inside], starts / rate, ends / rate, places, places)


def _in_skeleton(clip: SkelClip, plants: Plants) -> np.ndarray:
    """Return the places of plants in the space of the Skeleton, in its units."""
    places = plants.start_places
    worlds = clip.placements(0.5 * (plants.starts + plants.ends) * clip.codes_per_second)
    if worlds is not None and len(places):
        places = np.linalg.solve(worlds[:, :, :3], (places - worlds[:, :, 3])[..., None])[..., 0]
    return places / clip.world_scale

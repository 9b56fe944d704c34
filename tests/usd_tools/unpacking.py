"""Undo in Python what is packed for pages, as character.js does."""

import base64
import zlib
from dataclasses import replace

import numpy as np

WIDTHS = {"rotations": 4, "translations": 3, "scales": 3}


def decoded(text, kind):
    return np.frombuffer(zlib.decompress(base64.b64decode(text)), dtype=kind)


def whole_numbers(text, n_frames):
    lower, upper = decoded(text, "u1").reshape(2, -1)
    rows = (lower | upper.astype("<u2") << 8).view("<i2").reshape(-1, n_frames)
    return np.cumsum(rows, axis=1, dtype="<i2").T


def unpacked(character, motion, animation):
    """Return the animation that a motion was packed of; `animation` gives the skeleton and the times."""
    values = {}
    for name, text in motion.items():
        base, unit = (decoded(character["channels"][name][word], "<f4") for word in ("base", "unit"))
        rows = base + unit * whole_numbers(text, len(character["times"]))
        values[name] = rows.astype(np.float64).reshape(len(rows), character["joints"], WIDTHS[name])
    values["rotations"] /= np.linalg.norm(values["rotations"], axis=-1, keepdims=True)
    world = decoded(character["world"], "<f4").reshape(-1, 3, 4).astype(np.float64)
    return replace(animation, world=np.broadcast_to(world, (animation.n_frames, 3, 4)), **values)


def skinned(body, matrices):
    """Place the points of a body that was packed, shape=[P, 3]."""
    owners = decoded(body["owners"], "<u2").reshape(-1, body["influences"])
    weights = body["weight"] * decoded(body["weights"], "<i2").reshape(owners.shape)
    offsets = body["offset"] * decoded(body["offsets"], "<i2").reshape(*owners.shape, 3)
    moved = np.einsum("piab,pib->pia", matrices[owners][..., :3], offsets) + matrices[owners][..., 3]
    return np.einsum("pi,pia->pa", weights, moved)

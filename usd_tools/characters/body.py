"""The body of a character: its skinned meshes, or a capsule for each bone; triangles whose corners move with joints."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
from pxr import Usd, UsdGeom

from geomstats_anim import Animation
from geomstats_anim.markers import Markers, joint_matrices
from usd_tools.characters.bones import Bones
from usd_tools.characters.meshes import triangle_colors, triangles
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.skin import skinned_meshes

_SIDES, _RINGS = 8, 3
"""Of a capsule: corners around, and rings of each round end."""

_THICKNESS = 0.12
"""Radius of a capsule by the length of its bone."""


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles of one colour, whose corners move with joints.

    Parameters
    ----------
    markers : Markers
        The P points.
    faces : array-like of int, shape=[T, 3]
        Points of each triangle, counter-clockwise from outside.
    color : tuple of int, shape=[3]
        sRGB, 0 to 255; None where the file gives none.
    """

    markers: Markers
    faces: np.ndarray
    color: tuple[int, int, int] | None


@dataclass(frozen=True, eq=False)
class Body:
    """Shape that is drawn of a character.

    Parameters
    ----------
    parts : tuple of Part
    """

    parts: tuple[Part, ...]

    @cached_property
    def n_points(self) -> int:
        """Number of points of all parts."""
        return sum(part.markers.n_markers for part in self.parts)

    def joined(self) -> Body:
        """Return the body as one part, without colours: one mesh, shaded across the borders of its parts."""
        if not self.parts:
            return self
        starts = np.cumsum([0] + [part.markers.n_markers for part in self.parts])
        markers = reduce(Markers.joined, (part.markers for part in self.parts))
        faces = np.concatenate([part.faces + start for part, start in zip(self.parts, starts, strict=False)])
        return Body((Part(markers, faces, None),))

    def points(self, matrices: np.ndarray) -> list[np.ndarray]:
        """Place the points of each part in a pose.

        Parameters
        ----------
        matrices : array-like, shape=[B, 3, 4]
            Of the joints, see `joint_matrices`.

        Returns
        -------
        points : list of array-like, shape=[P, 3]
            For each part; metres.
        """
        return [part.markers.places(matrices[None])[0] for part in self.parts]

    def joint_at(self, matrices: np.ndarray, origin: np.ndarray, direction: np.ndarray) -> int | None:
        """Find the joint that moves what a ray meets first.

        Parameters
        ----------
        matrices : array-like, shape=[B, 3, 4]
        origin, direction : array-like, shape=[3]

        Returns
        -------
        joint : int or None
            None where the ray meets nothing.
        """
        nearest, found = np.inf, None
        for part, points in zip(self.parts, self.points(matrices), strict=True):
            distance, face, corner = _first_hit(points[part.faces], origin, direction)
            if distance < nearest:
                nearest, found = distance, int(part.markers.owners[part.faces[face, corner]])
        return found


def _first_hit(corners: np.ndarray, origin: np.ndarray, direction: np.ndarray) -> tuple[float, int, int]:
    """Return the distance, triangle and nearest corner where a ray first meets triangles, shape=[T, 3, 3].

    After Möller and Trumbore (1997), over all triangles at once; the distance is infinite where it meets none.
    """
    base, edges = corners[:, 0], corners[:, 1:] - corners[:, :1]
    normal = np.cross(direction, edges[:, 1])
    volume = np.einsum("ti,ti->t", edges[:, 0], normal)
    with np.errstate(divide="ignore", invalid="ignore"):
        to = origin - base
        u = np.einsum("ti,ti->t", to, normal) / volume
        across = np.cross(to, edges[:, 0])
        v = across @ direction / volume
        distances = np.einsum("ti,ti->t", edges[:, 1], across) / volume
        meets = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (distances > 0.0)
    if not meets.any():
        return np.inf, 0, 0
    face = int(np.argmin(np.where(meets, distances, np.inf)))
    shares = np.array([1.0 - u[face] - v[face], u[face], v[face]])
    return float(distances[face]), face, int(shares.argmax())


def skin(clip: SkelClip) -> Body:
    """Make the body of the meshes that are bound to a clip's skeleton; it has no parts where there are none."""
    parts = []
    for prim, markers in skinned_meshes(clip):
        corners, faces = triangles(prim)
        if not len(faces):
            continue
        points = np.array(UsdGeom.Mesh(prim).GetFaceVertexIndicesAttr().Get(Usd.TimeCode.EarliestTime()))[corners]
        if points.min() < 0 or points.max() >= markers.n_markers:
            continue
        colors = triangle_colors(prim, corners, faces)
        parts += _by_color(markers, points, colors)
    return Body(tuple(parts))


def _by_color(markers: Markers, faces: np.ndarray, colors: np.ndarray | None) -> list[Part]:
    if colors is None:
        return [_part(markers, faces, None)]
    shades, which = np.unique(colors, axis=0, return_inverse=True)
    which = which.reshape(-1)
    return [_part(markers, faces[which == i], tuple(shade.tolist())) for i, shade in enumerate(shades)]


def _part(markers: Markers, faces: np.ndarray, color: tuple[int, int, int] | None) -> Part:
    """Keep the points that triangles have."""
    used, place = np.unique(faces, return_inverse=True)
    return Part(markers.chosen(used), place.reshape(faces.shape), color)


def capsules(animation: Animation) -> Body:
    """Make a body of a capsule for each bone, as thick as the bone is long, within limits.

    Parameters
    ----------
    animation : Animation
        The bones' lengths are those in its first frame.
    """
    skeleton = animation.skeleton
    bones = Bones.of(skeleton)
    translations = animation.translations[0]
    tails = np.concatenate([translations, skeleton.bone_ends[bones.leaves]])[bones.lines[:, 1]]
    lengths = np.linalg.norm(tails, axis=-1)
    seen = lengths > 1e-9
    owners, tails, lengths = bones.owners[seen], tails[seen], lengths[seen]
    if not len(owners):
        return Body(())
    typical = np.median(lengths)
    radii = np.clip(_THICKNESS * lengths, 0.04 * typical, 0.3 * typical)
    radii = np.minimum(radii, 0.5 * lengths)
    points, faces = _capsule()
    axes = _frames(tails / lengths[:, None])
    local = np.empty((len(owners), len(points), 3))
    local[..., :2] = points[None, :, :2] * radii[:, None, None]
    along = points[None, :, 2]  # below 0 and above 1: the round ends
    inside = np.clip(along, 0.0, 1.0)
    local[..., 2] = inside * lengths[:, None] + (along - inside) * radii[:, None]
    offsets = np.einsum("bij,bpj->bpi", axes, local).reshape(-1, 3)
    corners = (faces[None] + len(points) * np.arange(len(owners))[:, None, None]).reshape(-1, 3)
    return Body((Part(Markers.on_joints(np.repeat(owners, len(points)), offsets), corners, None),))


def _capsule() -> tuple[np.ndarray, np.ndarray]:
    """Make a capsule of radius 1 around the z axis from 0 to 1: points, shape=[P, 3], and triangles, shape=[T, 3]."""
    heights = 0.5 * np.pi * np.arange(_RINGS) / _RINGS
    lower = np.stack([np.cos(heights), -np.sin(heights)], axis=-1)[::-1]
    profile = np.concatenate([lower, lower[::-1] * [1.0, -1.0] + [0.0, 1.0]])
    angles = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    rings = np.stack(
        [
            profile[:, None, 0] * np.cos(angles),
            profile[:, None, 0] * np.sin(angles),
            np.broadcast_to(profile[:, None, 1], (len(profile), _SIDES)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    points = np.concatenate([rings, [[0.0, 0.0, -1.0], [0.0, 0.0, 2.0]]])
    side, after = np.arange(_SIDES), np.roll(np.arange(_SIDES), -1)
    faces = []
    for ring in range(len(profile) - 1):
        low, high = ring * _SIDES, (ring + 1) * _SIDES
        faces += [
            np.stack([low + side, low + after, high + after], -1),
            np.stack([low + side, high + after, high + side], -1),
        ]
    last = (len(profile) - 1) * _SIDES
    bottom, top = np.full(_SIDES, len(rings)), np.full(_SIDES, len(rings) + 1)
    faces += [np.stack([bottom, after, side], -1), np.stack([top, last + side, last + after], -1)]
    return points, np.concatenate(faces)


def _frames(directions: np.ndarray) -> np.ndarray:
    """Complete unit vectors, shape=[N, 3], to frames whose last axis they are, shape=[N, 3, 3]."""
    least = np.eye(3)[np.abs(directions).argmin(axis=-1)]
    first = np.cross(least, directions)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack([first, np.cross(directions, first), directions], axis=-1)


def body_of(clip: SkelClip, animation: Animation, as_bones: bool = False) -> Body:
    """Make the body of a character: its skin, or capsules where it has none or bones are asked for."""
    skinned = Body(()) if as_bones else skin(clip)
    return skinned if skinned.parts else capsules(animation)


def bounds(body: Body, animation: Animation) -> np.ndarray:
    """Measure the box that a body stays in over an animation: lowest and highest corner, shape=[2, 3], metres."""
    corners = []
    for matrices in joint_matrices(animation):
        corners += [[points.min(axis=0), points.max(axis=0)] for points in body.points(matrices)]
    both = np.array(corners)
    return np.stack([both[:, 0].min(axis=0), both[:, 1].max(axis=0)])

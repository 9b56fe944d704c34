"""The skin: one closed quad mesh around the rig, and its weights.

The body is a smooth union of round cones, each belonging to a joint. Naive surface nets turn its distance field into
quads; a few rounds of smoothing and projecting back make these even.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from usd_tools.example_clips.biped import INDEX, NAMES, PARENTS, rest_positions

_CELL = 0.026  # metres: the size of a quad
_BLEND = 0.01  # metres: how far two cones flow into each other
_SOFTNESS = 0.045  # metres: how far around a joint its skin follows both bones
_INFLUENCES = 3

# Round cones at rest: joint, start (x, y, z) and radius, end and radius; metres, from the joint.
_MIDDLE = (
    ("Hips", (0.05, 0.0, -0.015), 0.108, (-0.05, 0.0, -0.015), 0.108),
    ("Spine", (0.0, 0.13, 0.01), 0.09, (0.0, -0.05, 0.0), 0.09),
    ("UpperChest", (0.065, 0.095, -0.005), 0.058, (-0.065, 0.095, -0.005), 0.058),
    ("Neck", (0.0, -0.04, 0.0), 0.052, (0.0, 0.08, 0.012), 0.047),
    ("Head", (0.0, 0.1, -0.012), 0.088, (0.0, 0.1, 0.018), 0.085),
    ("Head", (0.0, 0.085, 0.03), 0.07, (0.0, 0.008, 0.055), 0.042),
    ("Head", (0.0, 0.062, 0.1), 0.009, (0.0, 0.042, 0.108), 0.012),
)
_LEFT = (
    ("Hips", (0.05, -0.02, -0.02), 0.1, (0.048, 0.09, -0.005), 0.088),
    ("Spine", (0.048, 0.0, 0.005), 0.088, (0.048, 0.13, 0.012), 0.084),
    ("Chest", (0.048, 0.0, 0.012), 0.084, (0.062, 0.13, 0.012), 0.088),
    ("UpperChest", (0.062, 0.0, 0.012), 0.088, (0.07, 0.06, 0.005), 0.08),
    ("Shoulder", (0.03, -0.005, -0.005), 0.046, (0.13, 0.0, -0.01), 0.054),
    ("UpperArm", (0.0, -0.005, 0.0), 0.057, (0.12, 0.0, 0.0), 0.045),
    ("UpperArm", (0.12, 0.0, 0.0), 0.045, (0.275, 0.0, 0.0), 0.034),
    ("ForeArm", (0.0, 0.0, 0.0), 0.034, (0.07, 0.0, 0.0), 0.038),
    ("ForeArm", (0.07, 0.0, 0.0), 0.038, (0.25, 0.0, 0.0), 0.023),
    ("Hand", (0.0, 0.0, 0.0), 0.022, (0.085, 0.0, 0.024), 0.018),
    ("Hand", (0.0, 0.0, 0.0), 0.022, (0.085, 0.0, -0.024), 0.018),
    ("Hand", (0.02, -0.005, 0.02), 0.017, (0.08, -0.02, 0.068), 0.012),
    ("Fingers", (0.0, 0.0, 0.024), 0.018, (0.08, -0.004, 0.018), 0.013),
    ("Fingers", (0.0, 0.0, -0.024), 0.018, (0.07, -0.004, -0.02), 0.012),
    ("Thigh", (0.004, -0.02, -0.005), 0.086, (0.0, -0.42, 0.0), 0.05),
    ("Shin", (0.0, 0.0, 0.0), 0.05, (0.0, -0.11, -0.014), 0.051),
    ("Shin", (0.0, -0.11, -0.014), 0.051, (0.0, -0.4, 0.0), 0.031),
    ("Foot", (0.0, -0.005, 0.0), 0.033, (0.0, -0.044, -0.035), 0.032),
    ("Foot", (0.0, -0.01, 0.0), 0.035, (0.01, -0.051, 0.125), 0.024),
    ("Foot", (0.0, -0.045, -0.03), 0.03, (-0.014, -0.055, 0.12), 0.02),
    ("Toes", (0.013, 0.002, 0.0), 0.024, (0.014, -0.006, 0.06), 0.017),
    ("Toes", (-0.014, 0.0, 0.0), 0.022, (-0.016, -0.006, 0.068), 0.018),
)


@dataclass(frozen=True)
class Cones:
    """Round cones: joints (C,), starts and ends (C, 3) in the world at rest, radii (C, 2); metres."""

    joints: np.ndarray
    starts: np.ndarray
    ends: np.ndarray
    radii: np.ndarray


@dataclass(frozen=True)
class Skin:
    """A quad mesh at rest: points (V, 3), quads (Q, 4), and each point's joints and their weights, both (V, 3)."""

    points: np.ndarray
    quads: np.ndarray
    joints: np.ndarray
    weights: np.ndarray


@cache
def body_cones() -> Cones:
    """Return the cones that make up the body, the right side mirrored from the left."""
    rows = list(_MIDDLE)
    for side, mirror in (("Left", 1.0), ("Right", -1.0)):
        for name, (x, y, z), start_radius, (u, v, w), end_radius in _LEFT:
            joint = side + name if side + name in INDEX else name
            rows.append((joint, (mirror * x, y, z), start_radius, (mirror * u, v, w), end_radius))
    joints = np.array([INDEX[name] for name, *_ in rows])
    origins = rest_positions()[joints]
    return Cones(
        joints,
        origins + np.array([start for _, start, _, _, _ in rows]),
        origins + np.array([end for _, _, _, end, _ in rows]),
        np.array([(start_radius, end_radius) for _, _, start_radius, _, end_radius in rows]),
    )


def _distances(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Measure points (N, 3) against the cones: distances to their surfaces and to their cores, (N, C), metres."""
    cones = body_cones()
    core, surface = [], []
    for start, end, (start_radius, end_radius) in zip(cones.starts, cones.ends, cones.radii, strict=True):
        along = np.clip((points - start) @ (end - start) / np.sum((end - start) ** 2), 0.0, 1.0)
        core.append(np.linalg.norm(points - start - along[:, None] * (end - start), axis=1))
        surface.append(core[-1] - start_radius - along * (end_radius - start_radius))
    return np.stack(surface, axis=1), np.stack(core, axis=1)


def _field(points: np.ndarray) -> np.ndarray:
    """Return the smooth union's signed distance (N,), metres, negative inside."""
    surface, _ = _distances(points)
    nearest = surface.min(axis=1)
    return nearest - _BLEND * np.log(np.sum(np.exp((nearest[:, None] - surface) / _BLEND), axis=1))


def _surface_nets() -> tuple[np.ndarray, np.ndarray]:
    """Mesh the body's zero level: one point for each cell it crosses, one quad for each lattice edge it crosses."""
    cones = body_cones()
    reach = np.abs(np.concatenate([cones.starts, cones.ends])).max(axis=0) + 0.15
    cells = np.ceil(reach / _CELL)
    low = np.array([-cells[0] - 0.5, -2.5, -cells[2] - 0.5])  # half a cell off the mirror plane: a symmetric mesh
    high = np.array([cells[0] + 0.5, cells[1] + 0.5, cells[2] + 0.5])
    axes = [_CELL * np.arange(first, last + 0.5) for first, last in zip(low, high, strict=True)]
    lattice = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    inside = _field(lattice.reshape(-1, 3)).reshape(lattice.shape[:-1]) < 0.0

    number = np.full(inside.shape, -1)  # of the point in the cell that starts at a lattice site
    quads = []
    for axis in range(3):
        ahead = np.roll(inside, -1, axis)
        for outwards in (True, False):
            sites = np.argwhere(inside & ~ahead if outwards else ~inside & ahead)
            u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
            ring = np.stack([sites - u - v, sites - v, sites, sites - u], axis=1)
            quads.append(ring if outwards else ring[:, ::-1])
    corners = np.concatenate(quads)
    used = np.unique(corners.reshape(-1, 3), axis=0)
    number[tuple(used.T)] = np.arange(len(used))
    return lattice[tuple(used.T)] + 0.5 * _CELL, number[tuple(np.moveaxis(corners, -1, 0))]


def _relax(points: np.ndarray, quads: np.ndarray, rounds: int = 12) -> np.ndarray:
    """Even out the points: move each to the mean of its neighbours, then back onto the surface."""
    edges = np.concatenate([np.stack([quads[:, side], quads[:, side - 1]], axis=1) for side in range(4)])
    edges = np.concatenate([edges, edges[:, ::-1]])
    counts = np.bincount(edges[:, 0], minlength=len(points))[:, None]
    step = 1e-4 * np.eye(3)
    for _ in range(rounds):
        total = np.stack([np.bincount(edges[:, 0], points[edges[:, 1], axis]) for axis in range(3)], axis=1)
        points = 0.5 * points + 0.5 * total / counts
        for _ in range(2):
            gradient = np.stack([_field(points + h) - _field(points - h) for h in step], axis=1) / 2e-4
            points = points - (_field(points) / np.sum(gradient**2, axis=1))[:, None] * gradient
    return points


def _weigh(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Share each point among the joint it is nearest to and that joint's parent and children."""
    surface, core = _distances(points)
    owner = body_cones().joints
    reach = np.stack([core[:, owner == joint].min(axis=1) for joint in range(len(NAMES))], axis=1)
    nearest = owner[surface.argmin(axis=1)]
    joints = np.arange(len(NAMES))
    related = (joints[:, None] == joints) | (PARENTS[:, None] == joints) | (PARENTS == joints[:, None])
    excess = reach**2 - reach[np.arange(len(points)), nearest][:, None] ** 2
    closeness = np.where(related[nearest], np.exp(-np.maximum(excess, -(_SOFTNESS**2)) / _SOFTNESS**2), 0.0)
    chosen = np.argsort(-closeness, axis=1, kind="stable")[:, :_INFLUENCES]
    weights = np.take_along_axis(closeness, chosen, axis=1)
    return chosen, weights / weights.sum(axis=1, keepdims=True)


@cache
def build_skin() -> Skin:
    """Build the body's mesh and weights; the same every time."""
    points, quads = _surface_nets()
    points = _relax(points, quads)
    joints, weights = _weigh(points)
    return Skin(points, quads, joints, weights)


def deform(skin: Skin, positions: np.ndarray, orientations: np.ndarray) -> np.ndarray:
    """Skin the mesh by linear blending.

    Parameters
    ----------
    skin : Skin
        The mesh at rest.
    positions : (F, 24, 3)
        Positions of the joints, metres.
    orientations : (F, 24, 3, 3)
        Orientations of the joints, rotation matrices.

    Returns
    -------
    points : (F, V, 3)
        The points of the mesh, metres.
    """
    shifts = positions - orientations @ rest_positions()[:, :, None] @ np.ones(1)
    turned = np.einsum("vk,fvkij,vj->fvi", skin.weights, orientations[:, skin.joints], skin.points)
    return turned + np.einsum("vk,fvki->fvi", skin.weights, shifts[:, skin.joints])

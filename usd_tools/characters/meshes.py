"""Triangles of USD meshes, and their colours."""

from __future__ import annotations

import numpy as np
from pxr import Usd, UsdGeom, UsdShade

_SHADES = 16
"""Levels of each channel that are told apart: a mesh is drawn in parts of one colour each."""

MAX_TRIANGLES = 1 << 19
"""Of one mesh; a denser one is drawn with every n-th of its triangles."""


def triangles(prim: Usd.Prim) -> tuple[np.ndarray, np.ndarray]:
    """Cut the faces of a mesh into triangles, counter-clockwise from outside.

    Parameters
    ----------
    prim : Usd.Prim
        Prims that are no meshes, such as points, have none.

    Returns
    -------
    corners : array-like of int, shape=[T, 3]
        Places in the mesh's list of face corners.
    faces : array-like of int, shape=[T]
        Face that each triangle is of.
    """
    mesh = UsdGeom.Mesh(prim)
    sizes = np.array(mesh.GetFaceVertexCountsAttr().Get(Usd.TimeCode.EarliestTime()) or [] if mesh else [], dtype=int)
    n_corners = len(mesh.GetFaceVertexIndicesAttr().Get(Usd.TimeCode.EarliestTime()) or ()) if mesh else 0
    if (sizes < 0).any() or sizes.sum() != n_corners:
        return np.zeros((0, 3), dtype=int), np.zeros(0, dtype=int)
    counts = np.maximum(sizes - 2, 0)
    faces = np.repeat(np.arange(len(sizes)), counts)
    first = (np.cumsum(sizes) - sizes)[faces]
    place = np.arange(len(faces)) - (np.cumsum(counts) - counts)[faces]
    corners = np.stack([first, first + place + 1, first + place + 2], axis=-1)
    if mesh and mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded:
        corners = corners[:, ::-1]
    holes = np.array(mesh.GetHoleIndicesAttr().Get() or [] if mesh else [], dtype=int)
    seen = ~np.isin(faces, holes)
    step = -(-len(corners) // MAX_TRIANGLES) or 1
    return corners[seen][::step], faces[seen][::step]


def triangle_colors(prim: Usd.Prim, corners: np.ndarray, faces: np.ndarray) -> np.ndarray | None:
    """Read the colour of each triangle of a mesh: the display colour of its first corner, else its material's.

    Parameters
    ----------
    prim : Usd.Prim
    corners, faces : array-like
        See `triangles`.

    Returns
    -------
    colors : array-like of int, shape=[T, 3]
        sRGB, 0 to 255, in few shades; None where there is no colour.
    """
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
    values = primvar.ComputeFlattened(Usd.TimeCode.EarliestTime()) if primvar else None
    if not values:
        diffuse = _diffuse_color(prim)
        return None if diffuse is None else np.tile(_srgb(np.array(diffuse)), (len(faces), 1))
    colors = np.nan_to_num(np.array(values, dtype=np.float64).reshape(-1, 3))
    points = np.array(UsdGeom.Mesh(prim).GetFaceVertexIndicesAttr().Get(Usd.TimeCode.EarliestTime()))
    at = {
        UsdGeom.Tokens.uniform: faces[:, None],
        UsdGeom.Tokens.vertex: points[corners],
        UsdGeom.Tokens.varying: points[corners],
        UsdGeom.Tokens.faceVarying: corners,
    }.get(primvar.GetInterpolation(), np.zeros((len(faces), 1), dtype=int))
    if at.size and at.max() >= len(colors):
        return None
    return _srgb(colors[at[:, 0]])


def _diffuse_color(prim: Usd.Prim) -> tuple[float, float, float] | None:
    """Return the colour of the preview surface bound to a prim; None where a texture or nothing gives it."""
    material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
    shader = material.ComputeSurfaceSource()[0] if material else None
    color = shader.GetInput("diffuseColor") if shader else None
    value = color.Get() if color and not color.HasConnectedSource() else None
    return None if value is None or len(value) != 3 else tuple(value)


def _srgb(linear: np.ndarray) -> np.ndarray:
    """Encode linear light for a screen, shape=[..., 3], in few shades."""
    light = np.clip(linear, 0.0, 1.0)
    encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055)
    return np.round(np.round(encoded * (_SHADES - 1)) * (255.0 / (_SHADES - 1))).astype(int)

r"""Render one frame of a clip in Blender: the original, and what each scheme makes of that frame laid over it.

It runs in a Python that has Blender's bpy, version 4.5, and needs nothing else. Here .venv-blender is one:

    python -m usd_tools.compare examples/clips/pitching.usda -o pitching --rates 0.1
    .venv-blender/bin/python examples/render_overlay.py examples/clips/pitching.usda \
        pitching/usd/pitching/0.1/{constant,linear,slerp,geodesic}.usdc -o docs/images/blender_overlay.png
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Euler, Vector

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from usd_tools.figures.style import INK, TRUTH, look  # noqa: E402  needs no USD, and so not the environment of usd_tools

_GAP, _MARGIN = 0.12, 0.22  # metres between bodies, and around all of them
_LINE = 0.105  # metres: the size of letters
_TILT = 8.0  # degrees that the camera looks down
_GLASS = 0.6  # how much of the original a scheme's skin hides
_NEARER = 4.0  # metres: a scheme's skin is moved towards a camera without perspective, so that it lies over all of it


@dataclass(frozen=True)
class Posed:
    """A skin as it is at one frame: vertices (V, 3) in the world, metres, z up, and its faces."""

    name: str
    vertices: np.ndarray
    faces: list[tuple[int, ...]]


def read(path: Path, frame: float) -> Posed:
    """Import a USD file and take the skin that its armature moves, or raise a ValueError that says why it cannot."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=str(path))
    whole, part = int(np.floor(frame)), frame - np.floor(frame)
    bpy.context.scene.frame_set(whole, subframe=float(part))
    skins = [each for each in bpy.data.objects if any(m.type == "ARMATURE" for m in each.modifiers)]
    if not skins:
        raise ValueError(f"{path} has no skinned mesh; name a clip with one, such as examples/make_clips.py writes.")
    vertices, faces = [], []
    for skin in skins:
        shown = skin.evaluated_get(bpy.context.evaluated_depsgraph_get())
        first = sum(map(len, vertices))
        vertices.append(np.array([shown.matrix_world @ vertex.co for vertex in shown.data.vertices]))
        faces += [tuple(first + corner for corner in face.vertices) for face in shown.data.polygons]
    return Posed(path.stem, np.concatenate(vertices), faces)


def color_of(text: str) -> tuple[float, float, float, float]:
    """Turn #rrggbb into what Blender takes: linear light."""
    share = np.array([int(text[at : at + 2], 16) for at in (1, 3, 5)]) / 255.0
    red, green, blue = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4).tolist()
    return red, green, blue, 1.0


def material(name: str, color: str, opacity: float = 1.0) -> Any:
    """Make a transparent material, denser at the outline, whose inner side never shows."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    surface = nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = color_of(color)
    surface.inputs["Roughness"].default_value = 0.55
    if opacity < 1.0:
        rim, geometry = nodes.new("ShaderNodeLayerWeight"), nodes.new("ShaderNodeNewGeometry")
        rim.inputs["Blend"].default_value = 0.35
        amount, front, seen = (nodes.new("ShaderNodeMath") for _ in range(3))
        amount.operation, front.operation, seen.operation = "MULTIPLY_ADD", "SUBTRACT", "MULTIPLY"
        amount.inputs[1].default_value, amount.inputs[2].default_value = 1.0 - opacity, opacity
        front.inputs[0].default_value = 1.0
        links.new(rim.outputs["Facing"], amount.inputs[0])
        links.new(geometry.outputs["Backfacing"], front.inputs[1])
        links.new(amount.outputs[0], seen.inputs[0])
        links.new(front.outputs[0], seen.inputs[1])
        links.new(seen.outputs[0], surface.inputs["Alpha"])
    return made


def add_skin(posed: Posed, place: Vector, look_of: Any) -> Any:
    """Put a skin somewhere, and smooth it."""
    mesh = bpy.data.meshes.new(posed.name)
    mesh.from_pydata(posed.vertices.tolist(), [], posed.faces)
    mesh.shade_smooth()
    body = bpy.data.objects.new(posed.name, mesh)
    body.location = place
    body.data.materials.append(look_of)
    smooth = body.modifiers.new("Smooth", "SUBSURF")
    smooth.levels = smooth.render_levels = 2
    bpy.context.scene.collection.objects.link(body)
    return body


def add_text(text: str, place: Vector, turn: Euler, color: str, size: float = _LINE) -> None:
    """Write a line that faces the camera and shines, so that its color is the one that was asked for."""
    curve = bpy.data.curves.new(text, "FONT")
    curve.body, curve.size, curve.align_x = text, size, "CENTER"
    line = bpy.data.objects.new(text, curve)
    line.location, line.rotation_euler = place, turn
    ink = bpy.data.materials.new(text)
    ink.use_nodes = True
    surface = ink.node_tree.nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    surface.inputs["Specular IOR Level"].default_value = 0.0
    surface.inputs["Emission Color"].default_value = color_of(color)
    surface.inputs["Emission Strength"].default_value = 1.0
    curve.materials.append(ink)
    line.visible_shadow = line.visible_diffuse = line.visible_glossy = False
    bpy.context.scene.collection.objects.link(line)


def arrange(original: Posed, results: list[Posed], turn: float) -> tuple[float, float]:
    """Fill an empty scene: bodies in a row, lines below them, floor, light and camera; return the width and height."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    facing = Euler((np.radians(90.0 - _TILT), 0.0, np.radians(turn)))
    right, up, back = (facing.to_matrix() @ Vector(axis) for axis in np.eye(3).tolist())
    flat = np.array(right)
    reach = np.array([original.vertices @ flat] + [result.vertices @ flat for result in results])
    across = np.array([original.vertices @ np.array(up)] + [result.vertices @ np.array(up) for result in results])
    floor = min(original.vertices[:, 2].min(), *(result.vertices[:, 2].min() for result in results))
    # the outline of every panel: the original, and the scheme where there is one
    low = np.minimum(reach.min(axis=1), reach[0].min())
    high = np.maximum(reach.max(axis=1), reach[0].max())
    starts = np.concatenate([[0.0], np.cumsum(high - low + _GAP)[:-1]])
    width = float(starts[-1] + (high - low)[-1])

    truth = material("original", TRUTH)
    for number, (start, panel) in enumerate(zip(starts, [None, *results], strict=True)):
        place = right * float(start - low[number] - 0.5 * width)
        add_skin(original, place, truth)
        name, color, off = "original", INK, ""
        if panel is not None:
            name, color = panel.name, look(panel.name).color
            over = add_skin(panel, place + back * _NEARER, material(name, color, _GLASS))
            over.visible_shadow = over.visible_diffuse = over.visible_glossy = False
            away = np.linalg.norm(panel.vertices - original.vertices, axis=1).mean()
            off = f"{100.0 * away:.1f} cm off"
        middle = float(start + 0.5 * (high[number] - low[number]) - 0.5 * width)
        below = right * middle + up * float(across.min() - 1.9 * _LINE) + back * 12.0
        add_text(name, below, facing, color)
        if off:
            add_text(off, below - up * 1.25 * _LINE, facing, color, 0.8 * _LINE)

    bottom, top = float(across.min() - 3.7 * _LINE), float(across.max())
    _add_surroundings(floor, right, back)
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.clip_end = "ORTHO", 100.0
    camera.ortho_scale = width + 2.0 * _MARGIN
    eye = bpy.data.objects.new("Camera", camera)
    eye.location, eye.rotation_euler = up * (0.5 * (bottom + top)) + back * 20.0, facing
    bpy.context.scene.collection.objects.link(eye)
    bpy.context.scene.camera = eye
    return width + 2.0 * _MARGIN, top - bottom + 1.2 * _MARGIN


def _add_surroundings(floor: float, right: Vector, back: Vector) -> None:
    """Add a floor that shows nothing but shadows, a sun from the left, and an even sky."""
    mesh = bpy.data.meshes.new("Floor")
    mesh.from_pydata([(x, y, floor) for x, y in ((-50, -50), (50, -50), (50, 50), (-50, 50))], [], [(0, 1, 2, 3)])
    ground = bpy.data.objects.new("Floor", mesh)
    ground.is_shadow_catcher = True
    bpy.context.scene.collection.objects.link(ground)
    light = bpy.data.lights.new("Sun", "SUN")
    light.energy, light.angle = 2.6, np.radians(12.0)
    sun = bpy.data.objects.new("Sun", light)
    towards = -right * 0.5 + back * 0.6 + Vector((0.0, 0.0, 1.6))
    sun.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(sun)
    sky = bpy.data.worlds.new("Sky")
    sky.use_nodes = True
    nodes, links = sky.node_tree.nodes, sky.node_tree.links
    path, strength = nodes.new("ShaderNodeLightPath"), nodes.new("ShaderNodeMapRange")
    strength.inputs["To Min"].default_value, strength.inputs["To Max"].default_value = 0.55, 1.0  # white to the camera
    links.new(path.outputs["Is Camera Ray"], strength.inputs["Value"])
    nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    links.new(strength.outputs["Result"], nodes["Background"].inputs["Strength"])
    bpy.context.scene.world = sky


def render(out: Path, width: int, height: int, samples: int) -> None:
    """Render with Cycles on the processor, denoised, on white."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.seed = "CPU", samples, 0
    scene.cycles.use_denoising, scene.cycles.denoiser = True, "OPENIMAGEDENOISE"
    scene.cycles.transparent_max_bounces = 16
    scene.view_settings.view_transform = "Standard"
    scene.render.dither_intensity = 0.0  # noise that makes the file twice as large
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.compression = "PNG", "RGB", 100
    scene.render.filepath = str(out.resolve())
    bpy.ops.render.render(write_still=True)


def main(argv: list[str] | None = None) -> int:
    """Render the picture, print where it is, and return 0, or 1 if there is none."""
    parser = argparse.ArgumentParser(prog="render_overlay.py", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("original", metavar="ORIGINAL", type=Path, help="USD file with a skinned mesh")
    parser.add_argument("results", metavar="RESULT", type=Path, nargs="+", help="the same by a scheme, named after it")
    parser.add_argument("-o", "--out", metavar="OUT.png", type=Path, default=Path("overlay.png"))
    parser.add_argument("--frame", metavar="N", type=float, default=94.0, help="time code; default: 94")
    parser.add_argument("--turn", metavar="DEGREES", type=float, default=50.0, help="where the camera stands")
    parser.add_argument("--width", metavar="PIXELS", type=int, default=1400)
    parser.add_argument("--samples", metavar="N", type=int, default=32, help="of light, a pixel; default: 32")
    arguments = parser.parse_args(argv)
    try:
        for path in (arguments.original, *arguments.results):
            if not path.exists():
                raise ValueError(f"There is no file {path}.")
        original, *results = (read(path, arguments.frame) for path in (arguments.original, *arguments.results))
        for path, result in zip(arguments.results, results, strict=True):
            if len(result.vertices) != len(original.vertices):
                raise ValueError(f"{path} has another mesh than {arguments.original}.")
        across, tall = arrange(original, results, arguments.turn)
        render(arguments.out, arguments.width, round(arguments.width * tall / across), arguments.samples)
    except (ValueError, RuntimeError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print(arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())

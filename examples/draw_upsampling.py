"""Draw what upsampling does: a clip's keys, its in-betweens along geodesics, and how far they and slerp are off."""

from __future__ import annotations

import argparse
import sys
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import UsdGeom, UsdSkel
from scipy.ndimage import gaussian_filter

from geomstats_anim import Animation, interpolate, learn_metric, uniform_keyframes
from geomstats_anim.rotations import distance
from usd_tools.console.errors import ToolError
from usd_tools.example_clips.biped import INDEX, NAMES, forward_kinematics, joint_paths
from usd_tools.example_clips.body import Skin, deform
from usd_tools.files.paths import check_output
from usd_tools.files.stages import open_stage
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH, _HEIGHT, _FINE = 2000, 1000, 2  # pixels; samples per pixel, each way
_SCALE, _SMALL = 236.0, 180.0  # pixels per metre
_SHOWN, _SPACING = 8, 0.9  # keys in the strip, where the body moves most, and metres between them
_PAPER, _INK, _FAINT, _KEY, _TRUTH = "#fafafa", "#2b2d42", "#85879a", "#59628c", "#b4b5bd"
_SLERP, _GEODESIC = "#e5a400", "#7b3fb5"  # the papers' yellow and purple
_COLORS = {"original": _TRUTH, "slerp": _SLERP, "geodesic": _GEODESIC, "key": _KEY}
_LIGHT = np.array([-0.42, 0.66, 0.62])  # right, up, towards the viewer
_SIDE, _THREE_QUARTERS = (-12.0, 7.0), (-50.0, 15.0)  # views: degrees to turn and to tilt


def read(path: Path) -> tuple[Animation, Skin]:
    """Read the motion and the skin of a clip of the biped, or raise a ToolError that says why not."""
    stage = open_stage(path)
    clips = [read_clip(source) for source in find_animations(stage)]
    mesh = UsdGeom.Mesh.Get(stage, "/World/Biped/Skin")
    if not mesh or not clips or not clips[0].is_animated or clips[0].joints != tuple(joint_paths()):
        raise ToolError(f"{path} is not a clip of the example biped; name one that examples/make_clips.py writes.")
    points, corners = np.array(mesh.GetPointsAttr().Get(), float), np.array(mesh.GetFaceVertexIndicesAttr().Get())
    binding = UsdSkel.BindingAPI(mesh)
    joints, weights = (
        np.array(primvar.Get()).reshape(len(points), -1)
        for primvar in (binding.GetJointIndicesPrimvar(), binding.GetJointWeightsPrimvar())
    )
    animation = clips[0].keys(["rotations", "translations"], slice(None))
    return animation, Skin(points, corners.reshape(-1, 4), joints, weights)


def bone_ends(animation: Animation) -> np.ndarray:
    """Find where the bones end: (F, 24, 3), metres."""
    positions, turns = forward_kinematics(animation.rotations, animation.translations[:, 0])
    return positions + np.einsum("fbij,bj->fbi", turns, animation.skeleton.bone_ends)


def pose(skin: Skin, animation: Animation) -> np.ndarray:
    """Pose the skin: (F, V, 3), metres."""
    return deform(skin, *forward_kinematics(animation.rotations, animation.translations[:, 0]))


def view(points: np.ndarray, turn: float, tilt: float) -> np.ndarray:
    """Look at points along the x axis, turned and tilted by degrees: right, up, towards the viewer."""
    (sine, lift), (cosine, level) = np.sin(np.radians([turn, tilt])), np.cos(np.radians([turn, tilt]))
    right, near = np.array([sine, 0.0, cosine]), np.array([-cosine * level, lift, sine * level])
    return points @ np.stack([right, np.cross(near, right), near], axis=-1)


def paint(axes: Axes, points: np.ndarray, quads: np.ndarray, color: str, scale: float, glass: bool = False) -> None:
    """Paint a skin with smooth shading: sample its quads densely, far ones first, into a buffer of normals.

    Points are right, up and towards the viewer, in metres; scale is in pixels per metre. Glass is
    transparent, least at its outline.
    """
    from matplotlib.colors import to_rgb

    corners = points[quads]
    normals = np.zeros_like(points)
    for corner in quads.T:
        np.add.at(normals, corner, np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    quads = quads[np.argsort(corners[..., 2].mean(axis=1), kind="stable")]
    quads = quads[(normals[quads, 2] > 0.0).any(axis=1)]
    low = np.floor(points[:, :2].min(axis=0) * scale - 1.0)
    width, height = (np.ceil(points[:, :2].max(axis=0) * scale + 1.0) - low).astype(int)
    edges = np.linalg.norm(points[quads] - points[np.roll(quads, 1, axis=1)], axis=-1)
    count = int(1.3 * edges.max() * scale * _FINE) + 2
    u, v = (np.indices((count, count)).reshape(2, -1, 1) + 0.5) / count
    blend = np.concatenate([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=1)
    x, y = np.moveaxis(((blend @ points[quads, :2]) * scale - low) * _FINE, -1, 0).astype(int)
    buffer = np.zeros((height * _FINE, width * _FINE, 3))
    buffer[y, x] = blend @ normals[quads]

    length = np.linalg.norm(buffer, axis=-1, keepdims=True)
    normal = buffer / np.maximum(length, 1e-9)
    half = _LIGHT + [0.0, 0.0, 1.0]
    lit = np.clip(normal @ _LIGHT, 0.0, 1.0)[..., None]
    shine = np.clip(normal @ half / np.linalg.norm(half), 0.0, 1.0)[..., None] ** 30
    rim = (1.0 - np.clip(normal[..., 2:], 0.0, 1.0)) ** 2
    light = 0.8 + 0.3 * lit if glass else 0.5 + 0.12 * normal[..., 1:2] + 0.58 * lit
    alpha = (length > 0.0) * (0.13 + 0.6 * rim if glass else 1.0)
    image = np.concatenate([np.clip(np.array(to_rgb(color)) * light + 0.14 * shine, 0.0, 1.0) * alpha, alpha], axis=-1)
    image = image.reshape(height, _FINE, width, _FINE, 4).mean(axis=(1, 3))
    image[..., :3] /= np.maximum(image[..., 3:], 1e-9)
    _show(axes, image, low[0] / scale, low[1] / scale, width / scale, height / scale)


def _show(axes: Axes, image: np.ndarray, left: float, bottom: float, width: float, height: float) -> None:
    extent = (left, left + width, bottom, bottom + height)
    axes.imshow(image, extent=extent, aspect="auto", origin="lower", zorder=2.0)


def _panel(figure: Figure, left: float, bottom: float, width: float, height: float, scale: float = 1.0) -> Axes:
    """Add a stage at pixels of the picture, metres around 0."""
    axes = figure.add_axes((left / _WIDTH, bottom / _HEIGHT, width / _WIDTH, height / _HEIGHT), facecolor="none")
    axes.set(xlim=(-0.5 * width / scale, 0.5 * width / scale), ylim=(-0.5 * height / scale, 0.5 * height / scale))
    axes.set_autoscale_on(False)
    axes.set_axis_off()
    return axes


def _write(figure: Figure, x: float, y: float, text: str, color: str = _INK, size: float = 16, **style: Any) -> None:
    figure.text(x / _WIDTH, y / _HEIGHT, text, color=color, size=size, va="baseline", **style)


def draw_strip(axes: Axes, kept: np.ndarray, motion: Animation, skin: Skin, path: Animation, joint: int) -> None:
    """Draw keys in solid and in-betweens in glass, side by side in time, and the path of a joint's end."""
    moved = np.linalg.norm(np.diff(bone_ends(motion), axis=0), axis=-1).sum(axis=1)
    shown = min(_SHOWN, len(kept)) - 1
    start = int(np.convolve(np.add.reduceat(moved, kept[:-1]), np.ones(shown), "valid").argmax())
    keys = kept[start : start + shown + 1]
    first, last = motion.times[keys[[0, -1]]]
    middle = motion.translations[keys[0] : keys[-1], 0].mean(axis=0) * [0.0, 0.0, 1.0] + [0.0, 0.85, 0.0]
    points = pose(skin, motion)

    def place(points: np.ndarray, time: float) -> np.ndarray:
        return view(points - middle, *_SIDE) + [_SPACING * shown * ((time - first) / (last - first) - 0.5), 0.0, 0.0]

    reach = np.concatenate([place(points[key], motion.times[key])[:, 0] for key in keys[[0, -1]]])
    axes.set_xlim(np.array(axes.get_xlim()) + 0.5 * (reach.min() + reach.max()))
    for key in keys:
        x, y, _ = place(points[key] * [1.0, 0.0, 1.0], motion.times[key]).T
        left, bottom = x.mean() - 1.5, y.mean() - 0.4
        shadow = np.histogram2d(y, x, (64, 240), ((bottom, bottom + 0.8), (left, left + 3.0)))[0]
        shadow = gaussian_filter(np.minimum(shadow, 5.0), 3.0)[..., None]
        _show(axes, np.concatenate([np.full((64, 240, 3), 0.2), 0.3 * shadow / shadow.max()], -1), left, bottom, 3, 0.8)
        axes.text(x.mean(), -1.12, str(key), ha="center", color=_FAINT, size=15)
    between = [np.linspace(a, b, 5)[1:-1] for a, b in zip(keys, keys[1:], strict=False)]
    for frame in np.round(np.concatenate(between)).astype(int):
        paint(axes, place(points[frame], motion.times[frame]), skin.quads, _GEODESIC, _SCALE, glass=True)
    for key in keys:
        paint(axes, place(points[key], motion.times[key]), skin.quads, _KEY, _SCALE)
    path = path.at_frames(np.flatnonzero((path.times >= first) & (path.times <= last)))
    curve = np.array([place(end, time) for end, time in zip(bone_ends(path)[:, joint], path.times, strict=True)])
    axes.plot(*curve[:, :2].T, color=_GEODESIC, lw=2.2, zorder=5.0)
    spots = curve[np.searchsorted(path.times, motion.times[keys])]
    axes.plot(*spots[:, :2].T, "o", color=_KEY, mec=_PAPER, mew=1.5, ms=10, zorder=5.0)


def draw_pose(axes: Axes, truth: Animation, motion: Animation, skin: Skin, color: str, joint: int) -> None:
    """Draw one pose in glass over the true one, and the gap between the ends of a joint."""
    seen = view(pose(skin, truth)[0], *_SIDE)
    middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
    paint(axes, seen - middle, skin.quads, _TRUTH, _SMALL)
    paint(axes, view(pose(skin, motion)[0], *_SIDE) - middle, skin.quads, color, _SMALL, glass=True)
    gap = np.stack([bone_ends(truth)[0, joint], bone_ends(motion)[0, joint]])
    axes.plot(*(view(gap, *_SIDE) - middle)[:, :2].T, "o-", color=color, mec=_PAPER, ms=8, lw=2.0, zorder=5.0)


def draw_paths(axes: Axes, paths: dict[str, Animation], keys: Animation, joint: int) -> None:
    """Draw the paths of a joint's end by the original and by each scheme, and the keys."""
    times = keys.times[[0, -1]] + [-1e-9, 1e-9]
    curves = {n: bone_ends(path)[np.searchsorted(times, path.times) == 1, joint] for n, path in paths.items()}
    seen = {n: view(curve, *_THREE_QUARTERS) for n, curve in (*curves.items(), ("key", bone_ends(keys)[:, joint]))}
    middle = 0.5 * (np.max(seen["original"], axis=0) + np.min(seen["original"], axis=0))
    for name, curve in seen.items():
        line: dict[str, Any] = {"lw": 9.0 if name == "original" else 3.0, "solid_capstyle": "round"}
        dots: dict[str, Any] = {"marker": "o", "lw": 0.0, "mec": _PAPER, "mew": 1.5, "ms": 11}
        axes.plot(*(curve - middle)[:, :2].T, color=_COLORS[name], **(dots if name == "key" else line))


def draw(animation: Animation, skin: Skin, joint: int, rate: float) -> Figure:
    """Draw the whole picture, following the end of one joint and keeping some share of the frames."""
    from matplotlib.figure import Figure
    from matplotlib.patches import FancyBboxPatch

    kept, times = uniform_keyframes(animation.n_frames, rate), animation.times
    keys = animation.at_frames(kept)
    metrics = {"slerp": None, "geodesic": learn_metric(animation, kept, family="spd", scheme="geodesic")}
    motions = {name: interpolate(keys, times, name, metric) for name, metric in metrics.items()}
    dense = np.union1d(times, np.linspace(times[0], times[-1], 8 * len(times)))
    paths = {"original": animation} | {n: interpolate(keys, dense, n, metric) for n, metric in metrics.items()}
    off = {n: 100.0 * np.linalg.norm(bone_ends(m) - bone_ends(animation), axis=-1) for n, m in motions.items()}
    worst = int(np.abs(off["slerp"] - off["geodesic"])[:, joint].argmax())
    after = int(np.clip(np.searchsorted(kept, worst), 1, len(kept) - 1))
    name_of_joint = "".join(f" {c.lower()}" if c.isupper() else c for c in NAMES[joint]).strip()

    figure = Figure(figsize=(_WIDTH / 100, _HEIGHT / 100), dpi=100, facecolor="none")
    style: dict[str, Any] = {"boxstyle": "round,pad=0,rounding_size=0.012", "mutation_aspect": _WIDTH / _HEIGHT}
    figure.add_artist(FancyBboxPatch((0, 0), 1, 1, fc=_PAPER, ec="none", zorder=-1, **style))
    write = partial(_write, figure)
    write(50, 934, f"{len(kept)} of {len(times)} frames kept", _KEY, 26, weight="bold")
    write(_WIDTH - 50, 934, f"the {len(times) - len(kept)} between them follow geodesics", _GEODESIC, 26, ha="right")
    strip = _panel(figure, 0, 390, _WIDTH, 530, _SCALE)
    draw_strip(strip, kept, motions["geodesic"], skin, paths["geodesic"], joint)

    write(50, 330, f"Frame {worst}, between keys {kept[after - 1]} and {kept[after]}, the original in grey", _FAINT)
    for left, (name, motion) in zip((45, 435), motions.items(), strict=True):
        there = motion.at_frames([worst])
        panel = _panel(figure, left, 20, 300, 300, _SMALL)
        draw_pose(panel, animation.at_frames([worst]), there, skin, _COLORS[name], joint)
        write(left + 225, 128, name, _COLORS[name], weight="bold")
        write(left + 225, 94, f"{off[name][worst, joint]:.0f} cm off", _COLORS[name])
    write(860, 330, f"Path of the {name_of_joint}", _FAINT)
    nearby = animation.at_frames(kept[max(after - 2, 0) : after + 2])
    draw_paths(_panel(figure, 850, 30, 360, 290, 200.0), paths, nearby, joint)

    chart = _panel(figure, 1300, 48, 650, 130)
    high = max(error[:, joint].max() for error in off.values())
    chart.set(xlim=(0, len(times) - 1), ylim=(0, high))
    less, more = off["geodesic"][:, joint], off["slerp"][:, joint]
    for name, error in off.items():
        color, best = _COLORS[name], np.minimum(less, more)
        chart.fill_between(np.arange(len(times)), best, error[:, joint], color=color, alpha=0.35, lw=0)
        chart.plot(error[:, joint], color=color, lw=2.2, clip_on=False)
    chart.plot(kept, np.zeros(len(kept)), "o", color=_KEY, mec=_PAPER, ms=9, clip_on=False, zorder=5.0)
    chart.text(float(np.argmax(np.maximum(less, more))) + 3.0, 0.9 * high, f"{high:.0f} cm", color=_FAINT, size=15)
    write(1300, 330, "Mean error, the metric learned from this clip", _FAINT)
    write(1300, 178, f"Error of the {name_of_joint}", _FAINT)
    for x, head in ((1560, "rotations"), (1735, "bone ends"), (1950, name_of_joint)):
        write(x, 296, head, _FAINT, ha="right")
    for y, (name, motion) in zip((264, 232), motions.items(), strict=True):
        angle = np.degrees(distance(motion.rotations, animation.rotations)).mean()
        write(1300, y, name, _COLORS[name], weight="bold")
        cells = (f"{angle:.2f}°", f"{off[name].mean():.2f} cm", f"{off[name][:, joint].mean():.2f} cm")
        for x, cell in zip((1560, 1735, 1950), cells, strict=True):
            write(x, y, cell, _COLORS[name], ha="right")
    return figure


def save(figure: Figure, path: Path) -> None:
    """Write a picture as PNG, its colors rounded a little for a smaller file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image  # matplotlib needs it, too

    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    pixels = np.array(canvas.buffer_rgba())
    pixels[..., :3] = np.minimum(np.round(pixels[..., :3] / 5.0) * 5.0, 255.0)
    Image.fromarray(pixels).save(path, "PNG", optimize=True)


def main(argv: list[str] | None = None) -> int:
    """Draw a clip, print where the picture is, and return 0, or 1 if there is none."""
    here = Path(__file__).parent
    parser = argparse.ArgumentParser(prog="draw_upsampling.py", description=__doc__)
    parser.add_argument("clip", metavar="CLIP", type=Path, nargs="?", default=here / "clips" / "pitching.usda")
    parser.add_argument("-o", "--out", metavar="OUT.png", type=Path, default=here.parent / "docs/images/upsampling.png")
    parser.add_argument("--joint", metavar="NAME", choices=NAMES, default="RightHand", help="whose end to follow")
    parser.add_argument("--rate", metavar="S", type=float, default=0.1, help="share of the frames to keep")
    arguments = parser.parse_args(argv)
    if find_spec("matplotlib") is None:
        print("error: drawing needs matplotlib; install it with pip install matplotlib.", file=sys.stderr)
        return 1
    try:
        check_output(arguments.out, "--out")
        save(draw(*read(arguments.clip), INDEX[arguments.joint], arguments.rate), arguments.out)
    except (ToolError, ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print(arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())

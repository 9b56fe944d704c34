"""Render the moving picture of the README: python docs/make_animation.py. The picture is kept in git.

The original pitch; slerp between equally spaced keys; and the learned spline between as many chosen keys: those that
`downsample --keys 14` keeps, and from which `upsample --times source` rebuilds the clip.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch
from PIL import Image
from scipy.ndimage import gaussian_filter1d

from geomstats_anim import Animation, compress, interpolate, uniform_keyframes
from usd_tools.example_clips.biped import INDEX
from usd_tools.example_clips.body import build_skin
from usd_tools.example_clips.posing import RATE
from usd_tools.figures.style import FAINT, INK, TRUTH, look

_HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(_HERE.parent / "examples"))
from draw_upsampling import bone_ends, paint, pose, view  # noqa: E402
from make_figures import clip  # noqa: E402

_WIDTH, _HEIGHT, _SCALE = 960, 430, 140.0  # pixels; pixels per metre
_PAPER, _VIEW, _TRAIL = "#fafafa", (-12.0, 7.0), 10  # degrees to turn and to tilt; frames
_HAND = INDEX["RightHand"]


@dataclass(frozen=True)
class Panel:
    """One of the three bodies: its motion, its keys, and what stands above and below it."""

    title: str
    words: str
    color: str
    motion: Animation
    keys: np.ndarray
    off: np.ndarray  # centimetres per frame and joint


def panels(animation: Animation, rate: float) -> list[Panel]:
    """Rebuild the clip from a share of its frames, by slerp and by the learned spline."""
    uniform = uniform_keyframes(animation.n_frames, rate)
    compressed = compress([animation], counts=[len(uniform)])
    chosen = compressed.keyframes[0]
    slerp = interpolate(animation.at_frames(uniform), animation.times, "slerp")
    spline = interpolate(animation.at_frames(chosen), animation.times, "geodesic-spline", compressed.metric)
    rows = [
        ("original", f"{animation.n_frames} frames", TRUTH, animation, np.arange(animation.n_frames)),
        ("slerp", f"from {len(uniform)} equally spaced keys", look("slerp").color, slerp, uniform),
        ("learned spline", f"from {len(chosen)} chosen keys", look("geodesic-spline").color, spline, chosen),
    ]
    ends = bone_ends(animation)
    return [Panel(*row, 100.0 * np.linalg.norm(bone_ends(row[3]) - ends, axis=-1)) for row in rows]


def _stage(figure: Figure, number: int) -> Axes:
    """Add the place of a body: metres, the ground at 0."""
    width, height, low = _WIDTH / 3, _HEIGHT - 130, 62
    axes = figure.add_axes((number / 3, low / _HEIGHT, 1 / 3, height / _HEIGHT), facecolor="none")
    axes.set(xlim=(-0.5 * width / _SCALE, 0.5 * width / _SCALE), ylim=(-0.12, height / _SCALE - 0.12))
    axes.set_autoscale_on(False)
    axes.set_axis_off()
    return axes


def _draw_trail(axes: Axes, ends: np.ndarray, frame: int, color: str, width: float) -> None:
    """Draw where the hand has just been, fading out."""
    for step in range(max(frame - _TRAIL, 0), frame):
        share = 1.0 - (frame - step) / (_TRAIL + 1.0)
        axes.plot(*ends[step : step + 2, :2].T, color=color, lw=width, alpha=share, solid_capstyle="round", zorder=5.0)


def _draw_timeline(figure: Figure, number: int, panel: Panel, frame: int) -> None:
    """Draw the keys as ticks, and where the frame is between them."""
    axes = figure.add_axes(((number + 0.12) / 3, 18 / _HEIGHT, 0.76 / 3, 16 / _HEIGHT), facecolor="none")
    axes.set(xlim=(0, panel.motion.n_frames - 1), ylim=(-1, 1))
    axes.set_axis_off()
    axes.axhline(0.0, color=FAINT, lw=0.8, alpha=0.5)
    if len(panel.keys) < panel.motion.n_frames:
        axes.plot(panel.keys, np.zeros(len(panel.keys)), "|", color=panel.color, ms=9, mew=2.0, clip_on=False)
    axes.plot(frame, 0.0, "o", color=INK, ms=6, clip_on=False)


def draw(rows: list[Panel], bodies: list[np.ndarray], quads: np.ndarray, camera: np.ndarray, frame: int) -> Image.Image:
    """Draw one frame of the picture."""
    figure = Figure(figsize=(_WIDTH / 100, _HEIGHT / 100), dpi=100, facecolor="none")
    round_corners = {"boxstyle": "round,pad=0,rounding_size=0.015", "mutation_aspect": _WIDTH / _HEIGHT}
    figure.add_artist(FancyBboxPatch((0, 0), 1, 1, fc=_PAPER, ec="none", zorder=-1, **round_corners))
    truth = view(bone_ends(rows[0].motion)[:, _HAND] - camera[frame], *_VIEW)
    for number, (panel, body) in enumerate(zip(rows, bodies, strict=True)):
        axes = _stage(figure, number)
        paint(axes, view(body[frame] - camera[frame], *_VIEW), quads, panel.color, _SCALE)
        if number:
            _draw_trail(axes, truth, frame, TRUTH, 5.0)
        _draw_trail(axes, view(bone_ends(panel.motion)[:, _HAND] - camera[frame], *_VIEW), frame, panel.color, 2.5)
        _draw_timeline(figure, number, panel, frame)
        middle = (number + 0.5) / 3
        title_color = INK if number == 0 else panel.color
        figure.text(middle, 1 - 34 / _HEIGHT, panel.title, color=title_color, size=15, weight="bold", ha="center")
        figure.text(middle, 1 - 56 / _HEIGHT, panel.words, color=FAINT, size=10.5, ha="center")
        if number:
            words = f"hand {panel.off[frame, _HAND]:.0f} cm off; mean of bone ends {panel.off.mean():.1f} cm"
            figure.text(middle, 46 / _HEIGHT, words, color=panel.color, size=9, ha="center")
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return Image.fromarray(np.array(canvas.buffer_rgba()))


def main(argv: list[str] | None = None) -> int:
    """Render the picture and print its path."""
    parser = argparse.ArgumentParser(prog="make_animation.py", description=__doc__)
    parser.add_argument("-o", "--out", metavar="OUT.webp", type=Path, default=_HERE / "images" / "pitch.webp")
    parser.add_argument("--rate", metavar="S", type=float, default=0.1, help="share of the frames to keep")
    parser.add_argument("--frames", metavar="N", type=int, nargs="+", help="draw these only, to look at")
    arguments = parser.parse_args(argv)
    animation, skin = clip("pitching"), build_skin()
    rows = panels(animation, arguments.rate)
    bodies = [pose(skin, panel.motion) for panel in rows]
    hips = animation.translations[:, 0] * [1.0, 0.0, 1.0]
    camera = gaussian_filter1d(hips, 0.4 * RATE, axis=0, mode="nearest")
    frames = arguments.frames or range(animation.n_frames)
    images = [draw(rows, bodies, skin.quads, camera, frame) for frame in frames]
    images[0].save(
        arguments.out,
        save_all=True,
        append_images=images[1:],
        duration=[round(1000 * (i + 1) / RATE) - round(1000 * i / RATE) for i in range(len(images))],
        loop=0,
        quality=60,
        method=4,
        minimize_size=True,
    )
    print(arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())

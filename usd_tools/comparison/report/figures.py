"""The figures of a comparison, as PNG and SVG files; matplotlib is imported when they are drawn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from usd_tools.comparison.distortion import RateDistortion
from usd_tools.comparison.report import charts, distortion, skeletons
from usd_tools.comparison.report.scenes import Scene
from usd_tools.comparison.trials import Row
from usd_tools.skel.sizes import COMPARING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_STYLE: dict[Any, Any] = {
    "font.size": 10.0,
    "axes.labelcolor": "#2b2d42",
    "text.color": "#2b2d42",
    "svg.hashsalt": "geomstats_anim",  # else names in the file are drawn by lot
}


@dataclass(frozen=True)
class Picture:
    """A figure that is drawn.

    Parameters
    ----------
    name : str
        Of its files, without extension.
    clip : str or None
        Clip that it shows; None for all of them.
    caption : str
    """

    name: str
    clip: str | None
    caption: str


def draw_all(
    folder: Path, scenes: Sequence[Scene], rows: Sequence[Row], points: Sequence[RateDistortion], kind: str
) -> Iterator[Picture]:
    """Draw all figures, one after the other.

    Parameters
    ----------
    folder : Path
    scenes : sequence of Scene
    rows : sequence of Row
    points : sequence of RateDistortion
        Without any, there is no figure of them.
    kind : str
        Quality to show.

    Yields
    ------
    picture : Picture
        In the order in which a reader wants them.
    """
    from matplotlib import rc_context

    def keep(figure: Figure, picture: Picture) -> Picture:
        figure.savefig(folder / f"{picture.name}.png", dpi=160)
        figure.set_layout_engine("none")  # it is laid out, which takes as long as drawing it
        figure.savefig(folder / f"{picture.name}.svg", metadata={"Date": None})
        return picture

    clips = list(dict.fromkeys(scene.name for scene in scenes))
    with rc_context(_STYLE):
        for unseen in (False, True):
            by_clip = {clip: found for clip in clips if (found := charts.curves(rows, clip, kind, unseen))}
            if by_clip:
                name, caption = _QUALITY[unseen]
                yield keep(charts.draw_quality(by_clip, kind), Picture(name, None, caption))
        if points:
            yield keep(distortion.draw_rate_distortion(points), Picture("bytes", None, _BYTES))
        for clip in clips:
            scene = telling([scene for scene in scenes if scene.name == clip])
            yield keep(skeletons.draw_overlay(scene), Picture(f"{clip}-overlay", clip, _OVERLAY))
            yield keep(charts.draw_errors(scene), Picture(f"{clip}-error", clip, _ERROR))
            metrics = skeletons.draw_metrics(scene)
            if metrics is not None:
                yield keep(metrics, Picture(f"{clip}-metric", clip, _METRIC))


def telling(scenes: Sequence[Scene]) -> Scene:
    """Choose the middle one of the rates: with many keys all schemes look alike, and with few all are far off."""
    return sorted(scenes, key=lambda scene: scene.rate)[(len(scenes) - 1) // 2]


_QUALITY = {
    False: (
        "quality",
        "Quality against the share of frames kept, and below it as a share of slerp's. Metrics are learned for each "
        "clip and rate, and scored on the frames that they were learned from (in-sample).",
    ),
    True: (
        "quality-unseen",
        "The same out of sample: the second half of each clip. Metrics are learned from the first half, to predict; "
        "dotted, fitted freely to the first half.",
    ),
}
_BYTES = f"Bytes of motion against the largest error of joints, bone ends and points around joints. {COMPARING}"
_OVERLAY = (
    "The frame in which the schemes differ most. Thin lines lead from each joint to where the scheme puts it; the "
    "figure is the mean distance of bone ends."
)
_ERROR = "Error against time. Ticks are the frames kept; the dashed line is the frame above."
_METRIC = (
    "What was learned, over the rest pose. Turns about a joint's y axis cost alpha, those about z cost beta, where x "
    "costs 1; side is the invariance. Tension bends the curve: 0 the geodesic, 1 continuous velocity, 2 continuous "
    "acceleration; large dots are the tension of translations."
)

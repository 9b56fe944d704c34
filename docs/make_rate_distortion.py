"""Measure and draw bytes against largest error: python docs/make_rate_distortion.py. The picture is kept in git.

Clips are taken from ../shared/data. The rows of the table in benchmarks.rst are printed.
"""

from __future__ import annotations

from pathlib import Path

from usd_tools.comparison.acl import ACL
from usd_tools.comparison.distortion import METHODS, RateDistortion, acl_reference, rate_distortion
from usd_tools.comparison.report.distortion import draw_rate_distortion
from usd_tools.console.errors import Messages
from usd_tools.learning.files import read_clips, training_clips

_HERE = Path(__file__).resolve().parent
_CLIPS = _HERE.parents[1] / "shared" / "data" / "clips"

NAMES = ("pitching", "sitting", "punching")
CENTIMETRES = (0.1, 0.3, 1.0, 3.0)


def measure(name: str) -> list[RateDistortion]:
    """Count the bytes of a clip by every method within every tolerance."""
    path, messages = _CLIPS / f"{name}.usda", Messages(None)
    ((_, clip),), _ = training_clips(path, read_clips(path, (), messages), messages)
    points = [rate_distortion(name, method, clip.stretches, at) for method in METHODS for at in CENTIMETRES]
    known = [acl_reference(name, clip.stretches, at) for at in CENTIMETRES]
    found = {(point.method, point.tolerance_cm): point.bytes for point in (*points, *known) if point is not None}
    first = f'"{name}, {clip.n_frames} x {len(clip.joints)}"'
    for at in CENTIMETRES:
        cells = [found.get((method, at)) for method in (*METHODS, ACL)]
        print(
            f"   {first}, {at:g} cm, " + ", ".join("" if size is None else _spaced(size) for size in cells), flush=True
        )
        first = ""
    return [*points, *(point for point in known if point is not None)]


def _spaced(number: int) -> str:
    return f"{number:,}".replace(",", " ") if number >= 10_000 else str(number)


def main() -> None:
    """Write the picture."""
    points = [point for name in NAMES for point in measure(name)]
    draw_rate_distortion(points).savefig(_HERE / "images" / "rate_distortion.png", dpi=160, metadata={"Software": None})


if __name__ == "__main__":
    main()

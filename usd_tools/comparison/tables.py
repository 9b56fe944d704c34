"""A comparison as tables on stdout: one per clip, out-of-sample scores beside in-sample ones."""

from __future__ import annotations

from collections.abc import Sequence

from usd_tools.comparison.acl import ACL, SOURCE
from usd_tools.comparison.distortion import RateDistortion
from usd_tools.comparison.result import CompareResult
from usd_tools.comparison.trials import Row
from usd_tools.console.tables import show
from usd_tools.console.text import counted, say
from usd_tools.skel.sizes import COMPARING

_COLUMNS = ("rate", "scheme", "mean cm", "max cm", "Q_hyb", "unseen Q", "skate")
_ALL_COLUMNS = (
    "rate",
    "scheme",
    "keys",
    "mean cm",
    "max cm",
    "skate",
    "floating cm",
    "mean deg",
    "Q_loc m2",
    "Q_rot rad",
    "Q_hyb",
    "unseen Q",
    "fitted unseen Q",
    "kB NumPy",
    "kB usdc",
    "s learn",
    "ms rebuild",
)
EXPLANATION = (
    "Q is summed over joints and averaged over frames; lower is better. Learned schemes are scored on the frames that "
    "they were fitted to (in-sample). unseen Q is out of sample: scored on the second half of the clip, with a metric "
    "learned from the first half to predict."
)
LIBRARY = (
    "learned is out of sample: it predicts from a library of other clips; a clip of the library is scored by a library "
    "of the others alone."
)
SKATE = (
    "skate is how fast points slide, in cm per second, that are planted on the ground in the original; floating is how "
    "far they are above or below their height there."
)
FITTED = "fitted unseen Q: the same, with the metric that fits the first half best."


def print_summary(result: CompareResult, kind: str, verbose: bool) -> None:
    """Print a table for each clip, what its columns mean, and what was written."""
    for clip in (each["clip"] for each in result.clips):
        _print_clip(clip, [row for row in result.rows if row.clip == clip], kind, verbose)
        _print_sizes(clip, [point for point in result.rate_distortion if point.clip == clip])
    say(EXPLANATION)
    if any(row.library for row in result.rows):
        say(LIBRARY)
    if any(row.skate_cm_per_second is not None for row in result.rows):
        say(SKATE)
    if result.rate_distortion:
        say(COMPARING)
    if any(point.method == ACL for point in result.rate_distortion):
        say(SOURCE)
    if verbose:
        say(FITTED)
    say(f"Wrote {result.path}; open {result.path / 'index.html'} in a browser.")


def _print_clip(clip: str, rows: Sequence[Row], kind: str, verbose: bool) -> None:
    """Print the table of a clip.

    Parameters
    ----------
    clip : str
    rows : sequence of Row
        Of that clip.
    kind : str
        Quality that is shown for unseen frames.
    verbose : bool
        Whether to show all columns.
    """
    unseen = {(row.rate, row.scheme, row.purpose): row for row in rows if row.out_of_sample}
    whole = [row for row in rows if not row.out_of_sample]
    unmeasured = {"skate", "floating cm"} if all(row.skate_cm_per_second is None for row in whole) else set()
    columns = [column for column in (_ALL_COLUMNS if verbose else _COLUMNS) if column not in unmeasured]
    table = []
    for row in whole:
        predicted = unseen.get((row.rate, row.scheme, None if row.family is None else "predict"))
        fitted = unseen.get((row.rate, row.scheme, "reconstruct"))
        cells = _cells(row) | {"unseen Q": _quality(predicted, kind), "fitted unseen Q": _quality(fitted, kind)}
        table.append([cells.get(column, "") for column in columns])
    frames = next((f", {row.frames} samples of {counted(row.joints or 0, 'joint')}" for row in whole if row.frames), "")
    show(f"{clip}{frames}", table, columns)


def _print_sizes(clip: str, points: Sequence[RateDistortion]) -> None:
    """Print the bytes of a clip by tolerance and method, if they were counted."""
    if points:
        table = [
            (
                f"{point.tolerance_cm:g} cm",
                point.method,
                "not within" if point.bytes is None else str(point.bytes),
                "" if point.share is None else f"{point.share:.4f}",
                "" if point.mean_cm is None else f"{point.mean_cm:.3f}",
                "" if point.largest_cm is None else f"{point.largest_cm:.3f}",
            )
            for point in sorted(points, key=lambda point: point.tolerance_cm)
        ]
        show(f"{clip}: bytes of motion", table, ("within", "method", "bytes", "of NumPy", "mean cm", "max cm"))


def _cells(row: Row) -> dict[str, str]:
    """Write the values of a row, by the names of their columns."""

    def number(value: float | None, digits: str) -> str:
        return "" if value is None else format(value, digits)

    name = {"rate": f"{row.rate:g}", "scheme": row.scheme}
    if row.error is not None:
        return {**name, "mean cm": "failed"}
    return {
        **name,
        "keys": number(row.keys, "d"),
        "mean cm": number(row.mean_location_cm, ".3f"),
        "max cm": number(row.max_location_cm, ".2f"),
        "skate": number(row.skate_cm_per_second, ".1f"),
        "floating cm": number(row.floating_cm, ".2f"),
        "mean deg": number(row.mean_rotation_deg, ".3f"),
        "Q_loc m2": number(row.q_loc, ".4g"),
        "Q_rot rad": number(row.q_rot, ".4g"),
        "Q_hyb": number(row.q_hyb, ".4g"),
        "kB NumPy": number((row.bytes_numpy or 0) / 1000.0, ".1f"),
        "kB usdc": number((row.bytes_usdc or 0) / 1000.0, ".1f"),
        "s learn": "" if row.family is None else number(row.seconds_learn, ".2f"),
        "ms rebuild": number(1000.0 * (row.seconds_interpolate or 0.0), ".1f"),
    }


def _quality(row: Row | None, kind: str) -> str:
    if row is None:
        return ""
    return "failed" if row.error is not None else format(getattr(row, f"q_{kind}"), ".4g")

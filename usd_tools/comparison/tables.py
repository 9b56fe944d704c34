"""A comparison as tables on stdout: one a clip, what was not learned from beside what was."""

from __future__ import annotations

from collections.abc import Sequence

from usd_tools.comparison.cells import Row
from usd_tools.console.tables import counted, show

HEADER = (
    "rate",
    "scheme",
    "keys",
    "Q_loc m2",
    "Q_rot rad",
    "Q_hyb",
    "mean deg",
    "mean cm",
    "max cm",
    "kB NumPy",
    "kB usdc",
    "s learn",
    "ms rebuild",
    "unseen Q",
    "fitted unseen Q",
)
EXPLANATION = (
    "Q is summed over joints and averaged over frames; lower is better. What is learned is scored on the frames that "
    "it was learned from (in-sample). Out of sample is 'unseen Q': the second half of the clip, with the metric "
    "learned from the first half to predict, and 'fitted unseen Q': with the one that fits the first half best."
)


def tell(clip: str, rows: Sequence[Row], kind: str) -> None:
    """Print the table of a clip.

    Parameters
    ----------
    clip : str
    rows : sequence of Row
        Of that clip.
    kind : str
        Quality that is shown for unseen frames.
    """
    unseen = {(row.rate, row.scheme, row.purpose): row for row in rows if row.out_of_sample}
    whole = [row for row in rows if not row.out_of_sample]
    table = []
    for row in whole:
        learned = row.family is not None
        predicted = unseen.get((row.rate, row.scheme, "predict" if learned else None))
        fitted = unseen.get((row.rate, row.scheme, "reconstruct"))
        table.append(
            (
                f"{row.rate:g}",
                row.scheme,
                *(_cells(row) if row.error is None else ("failed", *[""] * 10)),
                _quality(predicted, kind),
                _quality(fitted, kind),
            )
        )
    frames = next((f", {row.frames} samples of {counted(row.joints or 0, 'joint')}" for row in whole if row.frames), "")
    show(f"{clip}{frames}", table, HEADER)


def _cells(row: Row) -> tuple[str, ...]:
    def number(value: float | None, digits: str) -> str:
        return "" if value is None else format(value, digits)

    return (
        number(row.keys, "d"),
        number(row.q_loc, ".4g"),
        number(row.q_rot, ".4g"),
        number(row.q_hyb, ".4g"),
        number(row.mean_rotation_deg, ".3f"),
        number(row.mean_location_cm, ".3f"),
        number(row.max_location_cm, ".2f"),
        number((row.bytes_numpy or 0) / 1000.0, ".1f"),
        number((row.bytes_usdc or 0) / 1000.0, ".1f"),
        "" if row.family is None else number(row.seconds_learn, ".2f"),
        number(1000.0 * (row.seconds_interpolate or 0.0), ".1f"),
    )


def _quality(row: Row | None, kind: str) -> str:
    if row is None:
        return ""
    return "failed" if row.error is not None else format(getattr(row, f"q_{kind}"), ".4g")

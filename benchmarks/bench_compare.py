"""The papers' experiment on the real clips, each claim beside its bar.

    python benchmarks/bench_compare.py [--quick] [--cpus N] [--keep FOLDER] [--markdown]

Clips are taken from ../shared/data/clips. A line that ends in MISSED fails a bar, and then the exit code is 1.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pxr import Sdf
from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parents[1]
CLIPS = ROOT.parent / "shared" / "data" / "clips"
sys.path.insert(0, str(ROOT))

from geomstats_anim.names import OWN_SCHEMES  # noqa: E402
from usd_tools import compare  # noqa: E402
from usd_tools.comparison.options import RATES  # noqa: E402

NAMES = ("jumping", "pitching", "punching", "rolling", "sitting")
OURS, SPD = "geodesic-spline", "geodesic:spd"
PEERS = ("slerp", "squad", "rotation-spline")
SECONDS_BAR, ONE_CLIP_BAR = 300.0, 60.0
TIE = 1.0 + 1e-6
"""Between two keys of the same pose all schemes agree, but for rounding: nobody wins there."""

Cell = tuple[str, float]
Quality = Mapping[str, Mapping[Cell, float]]
"""Q_hyb by scheme, then by clip and rate; a cell that failed is missing."""


class Line(NamedTuple):
    """A measured figure, its bar, and whether it is met."""

    what: str
    bar: str
    figure: str
    met: bool

    @property
    def verdict(self) -> str:
        """Word for the last column."""
        return "ok" if self.met else "MISSED"


def make_long(path: Path, source: Path, n_frames: int) -> None:
    """Write a clip of a number of samples that plays another forwards and backwards."""
    layer = Sdf.Layer.OpenAsAnonymous(str(source))
    attributes: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, lambda at: attributes.append(at) if at.IsPropertyPath() else None)
    for attribute in attributes:
        codes = layer.ListTimeSamplesForPath(attribute)
        values = [layer.QueryTimeSample(attribute, code) for code in codes]
        there_and_back = values + values[-2:0:-1]
        for n in range(n_frames if len(codes) > 1 else 0):
            layer.SetTimeSample(attribute, codes[0] + n, there_and_back[n % len(there_and_back)])
    layer.Export(str(path))


def timed(clips: Sequence[Path], out: Path, options: Sequence[str]) -> float:
    """Compare clips without a word on stdout, and tell how many seconds it took."""
    start = time.perf_counter()
    with contextlib.redirect_stdout(io.StringIO()):
        code = compare.main([*map(str, clips), "-o", str(out), *options])
    if code:
        raise SystemExit(f"The comparison ended with exit code {code}.")
    return time.perf_counter() - start


def qualities(rows: Sequence[Mapping[str, Any]], unseen: bool) -> dict[str, dict[Cell, float]]:
    """Q_hyb by scheme; out of sample, that of what is fitted freely is under its name with `, fitted` behind."""
    found: dict[str, dict[Cell, float]] = {}
    for row in rows:
        if row["out_of_sample"] == unseen and row["error"] is None:
            fitted = ", fitted" if unseen and row["purpose"] == "reconstruct" else ""
            found.setdefault(row["scheme"] + fitted, {})[row["clip"], row["rate"]] = row["q_hyb"]
    return found


def no_worse(q: Quality, one: str, other: str, cells: Sequence[Cell]) -> Line:
    """Line of a scheme that must not lose to another in any cell."""
    there = [cell for cell in cells if cell in q.get(one, {}) and cell in q.get(other, {})]
    lost = [cell for cell in there if q[one][cell] > q[other][cell] * (1.0 + 1e-9)]
    where = f"; lost: {named(lost)}" if lost else ""
    absent = f"; failed: {named([cell for cell in cells if cell not in there])}" if len(there) < len(cells) else ""
    figure = f"{len(there) - len(lost)} of {len(cells)} cells{where}{absent}"
    return Line(f"{one} at most {other}", "all cells", figure, len(there) == len(cells) and not lost)


def named(cells: Sequence[Cell]) -> str:
    """Name cells."""
    return ", ".join(f"{clip} {rate:g}" for clip, rate in cells)


def in_sample(q: Quality, cells: Sequence[Cell]) -> list[Line]:
    """Lines of what is fitted to the clip that it rebuilds."""
    lines = [no_worse(q, "geodesic", "slerp", cells), no_worse(q, SPD, "geodesic", cells)]
    ratios = {c: q[OURS][c] / min(q[word][c] for word in OWN_SCHEMES if c in q[word]) for c in cells if c in q[OURS]}
    best = [cell for cell, ratio in ratios.items() if ratio <= TIE]
    others = [cell for cell in cells if cell not in best]
    where = f"; not: {named(others)}" if others else ""
    enough = len(cells) - 1
    figure = f"{len(best)} of {len(cells)}{where}"
    lines.append(Line(f"{OURS} best of seven", f"{enough} of {len(cells)}", figure, len(best) >= enough))
    worst = max(ratios.values(), default=np.inf)
    bar, met = "at most 1 %", worst <= 1.01 and len(ratios) == len(cells)
    lines.append(Line(f"{OURS} above the best, at worst", bar, f"{100.0 * (worst - 1.0):.2f} %", met))
    return lines


def against_peers(q: Quality, cells: Sequence[Cell], word: str) -> dict[Cell, float]:
    """Out of sample, a scheme as a share of the best of the peers."""
    return {c: q[word][c] / min(q[peer][c] for peer in PEERS) for c in cells if c in q.get(word, {})}


def out_of_sample(q: Quality, cells: Sequence[Cell]) -> list[Line]:
    """Lines of what is learned to predict."""
    ratios = against_peers(q, cells, OURS)
    if not ratios:
        return [Line(f"unseen: {OURS}", "", "failed in every cell", False)]
    complete = len(ratios) == len(cells)
    mean, worst = float(np.mean(list(ratios.values()))), max(ratios, key=lambda cell: ratios[cell])
    what = f"unseen: {OURS} against the best of {', '.join(PEERS)}"
    number = f"{len(ratios)} of {len(cells)} cells"
    lines = [
        Line(f"{what}, mean", "at most +1 %", f"{100.0 * (mean - 1.0):+.2f} %, {number}", complete and mean <= 1.01),
        Line(
            f"{what}, worst",
            "at most +3 %",
            f"{100.0 * (ratios[worst] - 1.0):+.2f} %, {named([worst])}",
            complete and ratios[worst] <= 1.03,
        ),
    ]
    means = {word: float(np.mean(list(against_peers(q, list(ratios), word).values()))) for word in OWN_SCHEMES}
    best = min(means, key=lambda word: means[word])
    lines.append(Line("unseen: best single choice", OURS, f"{best} ({100 * (means[best] - 1):+.2f} %)", best == OURS))
    return lines


def print_table(
    console: Console, title: str, header: Sequence[str], rows: Sequence[Sequence[str]], plain: bool
) -> None:
    """Print a table for a terminal, or as Markdown."""
    if plain:
        print(f"\n{title}\n\n| {' | '.join(header)} |\n|{' --- |' * len(header)}")
        for row in rows:
            print(f"| {' | '.join(row)} |")
        return
    table = Table(*header, title=title)
    for row in rows:
        table.add_row(*row)
    console.print(table)


def shares(q: Quality, words: Sequence[str]) -> list[list[str]]:
    """Rows of Q_hyb as a share of slerp's, geometric means over clips."""
    rows = []
    for word in words:
        cells = []
        for rate in RATES:
            logs = [np.log(v / q["slerp"][c]) for c, v in q.get(word, {}).items() if c[1] == rate]
            cells.append(f"{np.exp(np.mean(logs)):.3f}" if logs else "")
        rows.append([word, *cells])
    return rows


def beside_peers(q: Quality, clips: Sequence[str], cells: Sequence[Cell]) -> list[list[str]]:
    """Rows of what geodesic-spline leaves of the best peer's error on unseen frames: predict / fitted."""
    pairs = [against_peers(q, cells, word) for word in (OURS, f"{OURS}, fitted")]
    return [
        [clip, *(" / ".join(f"{p[clip, rate]:.3f}" if (clip, rate) in p else "-" for p in pairs) for rate in RATES)]
        for clip in clips
    ]


def main(argv: list[str] | None = None) -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="only punching and sitting")
    parser.add_argument("--cpus", metavar="N", default=str(min(2, os.cpu_count() or 1)), help="default: %(default)s")
    parser.add_argument("--keep", metavar="FOLDER", type=Path, help="keep the comparison here")
    parser.add_argument("--markdown", action="store_true", help="tables as the README has them")
    arguments = parser.parse_args(argv)
    names = NAMES[2::2] if arguments.quick else NAMES
    paths = [path for name in names if (path := CLIPS / f"{name}.usda").is_file()]
    if not paths:
        print(f"Nothing to measure: there are no clips in {CLIPS}.")
        return 0
    console = Console(width=max(Console().width, 120))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        workers = ["--cpus", arguments.cpus]
        timed(paths[:1], folder / "warm", ["--rates", ".03"])  # compiles, if need be
        one = None
        if (CLIPS / "pitching.usda").is_file() and not arguments.quick:
            make_long(folder / "long.usdc", CLIPS / "pitching.usda", 300)
            one = timed([folder / "long.usdc"], folder / "one", workers)
        out = arguments.keep or folder / "five"
        five = timed(paths, out, [*workers, "--schemes", *OWN_SCHEMES])
        spd = timed(paths, folder / "spd", [*workers, "--schemes", SPD])
        rows = json.loads((out / "results.json").read_text())["rows"]
        rows += json.loads((folder / "spd" / "results.json").read_text())["rows"]
    clips = [path.stem for path in paths]
    cells = [(clip, rate) for clip in clips for rate in RATES]
    seen, unseen = qualities(rows, False), qualities(rows, True)
    lines = [*in_sample(seen, cells), *out_of_sample(unseen, cells)]
    lines += [
        Line(
            f"{len(paths)} clips, seven schemes, five rates", f"{SECONDS_BAR:g} s", f"{five:.0f} s", five < SECONDS_BAR
        ),
        Line(f"{SPD} alone", "", f"{spd:.0f} s", True),
    ]
    if one is not None:
        what = "one clip of 300 x 31, seven schemes, five rates"
        lines.append(Line(what, f"{ONE_CLIP_BAR:g} s", f"{one:.0f} s", one < ONE_CLIP_BAR))
    rates = [f"{rate:g}" for rate in RATES]
    learned = [SPD, "geodesic, fitted", f"{SPD}, fitted", f"{OURS}, fitted"]
    title = "Q_hyb as a share of slerp's, mean over clips, in-sample"
    print_table(console, title, ["scheme", *rates], shares(seen, [*OWN_SCHEMES, SPD]), arguments.markdown)
    title = "Q_hyb as a share of slerp's, mean over clips, out of sample"
    print_table(console, title, ["scheme", *rates], shares(unseen, [*OWN_SCHEMES, *learned]), arguments.markdown)
    title = f"Out of sample, {OURS} as a share of the best of {', '.join(PEERS)}: predict / fitted freely"
    print_table(console, title, ["clip", *rates], beside_peers(unseen, clips, cells), arguments.markdown)
    bars = [[line.what, line.bar, line.figure, line.verdict] for line in lines]
    print_table(console, "Bars", ["what", "bar", "measured", ""], bars, arguments.markdown)
    return int(not all(line.met for line in lines))


if __name__ == "__main__":
    sys.exit(main())

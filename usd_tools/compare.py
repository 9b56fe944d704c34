"""Compare interpolation schemes: rebuild animations from few of their samples, score each, and write a report.

python -m usd_tools.compare walk.usda run.usda -o comparison
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from geomstats_anim import SCHEMES, __version__
from geomstats_anim.names import KINDS
from usd_tools.comparison import tables as comparison_tables
from usd_tools.comparison.cells import RATES, Contender, Outcome, Row, cells
from usd_tools.comparison.report.report import write_report
from usd_tools.comparison.results import ComparedClip, named, write_rebuilt, write_results
from usd_tools.comparison.run import measure_all
from usd_tools.console.arguments import add_prim, add_workers, share
from usd_tools.console.errors import Messages, ToolError, print_warning, run
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import Progress, ProgressBar
from usd_tools.console.text import say
from usd_tools.files.folders import check_folder, made_beside
from usd_tools.files.openusd_errors import openusd_errors, usd_warnings
from usd_tools.learning.files import find_files, read_clips, training_clips
from usd_tools.learning.result import Skipped

TOOL = "usd_tools.compare"
CONTENTS = ("figures", "index.html", "results.csv", "results.json", "usd")

PROG = "python -m usd_tools.compare"


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Rebuild skeletal animation from a share of its samples by every interpolation scheme, score each "
        "against the original, and write a report: the experiment of Kushner, Modi and Miolane, for any clip.",
        epilog="FOLDER gets results.json and results.csv, figures, every rebuilt clip as a USD layer over its source, "
        "and index.html, a page with all of it and a player that needs no network. Metrics are learned for each clip "
        "and rate, and scored on the very frames they were learned from (in-sample); beside them stand scores out of "
        "sample: learned from the first half, scored on the second.",
    )
    parse.add_argument(
        "inputs",
        metavar="IN",
        type=Path,
        nargs="+",
        help="USD file, or folder, searched with all folders in it",
    )
    parse.add_argument(
        "-o", "--out", metavar="FOLDER", type=Path, required=True, help="folder to make, or to replace if it is ours"
    )
    parse.add_argument(
        "--rates",
        metavar="S",
        type=share,
        nargs="+",
        default=list(RATES),
        help=f"shares of the samples kept as uniform keys; default: {' '.join(f'{rate:g}' for rate in RATES)}",
    )
    parse.add_argument(
        "--schemes",
        metavar="SCHEME",
        type=Contender.parse,
        nargs="+",
        default=[Contender.parse(scheme) for scheme in SCHEMES],
        help=f"of {', '.join(SCHEMES)}; one that learns may carry its family, as in geodesic:spd; default: all",
    )
    parse.add_argument(
        "--kind",
        choices=KINDS,
        default="hyb",
        help="what learning minimises: places of bone ends (loc), angles of joints (rot), or half of each (default)",
    )
    add_workers(parse)
    add_prim(parse)
    parse.add_argument("-v", "--verbose", action="store_true", help="print all columns of the tables")
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    args = parser(prog).parse_args(argv)
    return run(lambda: compare(args))


@openusd_errors()
def compare(args: argparse.Namespace) -> int:
    """Do what the arguments say."""
    messages = Messages(print_warning)
    check_folder(args.out, TOOL, CONTENTS, ())
    with usd_warnings(messages):
        clips, skipped = _read(args, messages)
        sources = [layer.realPath for each in clips for layer in each.clip.source.stage.GetUsedLayers()]
        check_folder(args.out, TOOL, CONTENTS, [each.path for each in clips] + [path for path in sources if path])
        outcomes = _measure(args, clips, messages)
        with made_beside(args.out) as folder:
            rows = _write(args, folder, clips, outcomes, skipped, messages)
    for each in clips:
        comparison_tables.tell(each.name, [row for row in rows if row.clip == each.name], args.kind, args.verbose)
    say(comparison_tables.EXPLANATION)
    if args.verbose:
        say(comparison_tables.FITTED)
    say(f"Wrote {args.out}; open {args.out / 'index.html'} in a browser.")
    return 0


def _read(args: argparse.Namespace, messages: Messages) -> tuple[list[ComparedClip], list[Skipped]]:
    files = find_files(args.inputs, messages)
    found, skipped = [], []
    for path in files:
        try:
            taken, lost = training_clips(path, read_clips(path, args.prim, messages), messages)
        except ToolError as error:
            if len(files) == 1:
                raise
            messages.warn(f"skipped: {error}")
            taken, lost = [], [Skipped(path.name, str(error))]
        found += [(path, clip, take) for clip, take in taken]
        skipped += lost
    if not found:
        raise ToolError(f"None of the {len(files)} files can be compared; the warnings say why.")
    return named(found), skipped


def _measure(args: argparse.Namespace, clips: Sequence[ComparedClip], messages: Messages) -> list[Outcome]:
    rates, contenders = list(dict.fromkeys(args.rates)), list(dict.fromkeys(args.schemes))
    wanted = cells([each.name for each in clips], rates, contenders)
    with ProgressBar() as bar:
        progress = Progress(bar, len(wanted), "Comparing")

        def done(outcome: Outcome) -> None:
            if outcome.row.error is not None:
                messages.warn(f"{outcome.cell} failed: {outcome.row.error}")
            progress.advance(1.0, f"Comparing: {outcome.cell}")

        return measure_all(wanted, {each.name: each.take for each in clips}, args.kind, args.address, args.cpus, done)


def _write(
    args: argparse.Namespace,
    folder: Path,
    clips: Sequence[ComparedClip],
    outcomes: Sequence[Outcome],
    skipped: list[Skipped],
    messages: Messages,
) -> list[Row]:
    """Fill the folder."""
    by_name = {each.name: each for each in clips}
    rows = []
    for outcome in outcomes:
        row = outcome.row
        if not outcome.cell.unseen and row.error is None:
            usd = write_rebuilt(folder, by_name[row.clip], outcome, TOOL, args.kind, messages)
            row = replace(row, usd=usd)
        rows.append(row)
    head = _head(args, clips, skipped, messages)
    write_results(folder, head, rows)
    with ProgressBar() as bar:
        progress = Progress(bar, None, "Drawing")
        write_report(folder, head, clips, outcomes, rows, progress.advance)
    return rows


def _head(
    args: argparse.Namespace, clips: Sequence[ComparedClip], skipped: list[Skipped], messages: Messages
) -> dict[str, Any]:
    """Tell what is compared, as plain values without paths of this machine."""
    return {
        "tool": TOOL,
        "version": __version__,
        "settings": {
            "rates": list(dict.fromkeys(args.rates)),
            "schemes": list(dict.fromkeys(contender.word for contender in args.schemes)),
            "kind": args.kind,
            "prim": args.prim,
        },
        "clips": [
            {
                "clip": each.name,
                "file": each.take.file,
                "sha256": each.take.sha256,
                "prim": each.take.prim,
                "frames": each.take.n_frames,
                "joints": each.take.skeleton.n_joints,
                "stretches": len(each.take.stretches),
            }
            for each in clips
        ],
        "skipped": [asdict(each) for each in skipped],
        "warnings": messages.warnings,
    }


if __name__ == "__main__":
    sys.exit(main())

"""Do time and memory grow in proportion? Commands on clips of many samples, and of many joints, at half and full size.

    python benchmarks/bench_scale.py

Each command runs in a process of its own. What the imports alone take is taken off before sizes are compared. Seconds
are the processor's, of all cores, so that others on the machine do no harm. Twice the size should be twice as much:
exponent 1.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from math import log2
from pathlib import Path

from bench_usd import IMPORTS, make_elsewhere, run_python

SIZES = ((20_000, 70, "samples"), (300, 2_000, "joints"))
"""Samples, joints, and which of them is halved."""

COMMANDS = {
    "inspect": "inspect {clip}",
    "upsample": "upsample {clip} -o {out} --factor 2",
    "upsample --alpha 4 --beta .5": "upsample {clip} -o {out} --factor 2 --alpha 4 --beta .5",
    "downsample --scheme slerp": "downsample {clip} -o {out} --rate .3 --select uniform --scheme slerp",
    "downsample": "downsample {clip} -o {out} --rate .3 --select uniform",
}
"""Commands that are measured; uniform samples, for the choice of the best is not linear by its nature."""


def main() -> None:
    """Print the table."""
    from rich.console import Console
    from rich.table import Table

    parse = argparse.ArgumentParser(prog="python benchmarks/bench_scale.py")
    parse.add_argument("--shrink", type=int, default=1, metavar="N", help="sizes divided by N, for a quick look")
    parse.add_argument("--only", choices=list(COMMANDS), action="append", help="this command; repeatable")
    args = parse.parse_args()
    title = "processor seconds and peak MiB beyond imports, at half and full size"
    table = Table(
        "command", "samples x joints", "half", "full", "exponent", "half MiB", "full MiB", "exponent", title=title
    )
    base_seconds, base_memory = run_python(IMPORTS)[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        warm, out = folder / "warm.usdc", folder / "out.usdc"
        make_elsewhere(warm, 40, 5)
        for command in COMMANDS.values():  # compiles, if need be
            _run(command, warm, out)
        for n_samples, n_joints, halved in SIZES:
            n_samples, n_joints = (
                (n_samples // args.shrink, n_joints) if halved == "samples" else (n_samples, n_joints // args.shrink)
            )
            half = (n_samples // 2, n_joints) if halved == "samples" else (n_samples, n_joints // 2)
            clips = [folder / f"{halved}_{k}.usdc" for k in range(2)]
            for clip, size in zip(clips, (half, (n_samples, n_joints)), strict=True):
                make_elsewhere(clip, *size)
            for title, command in COMMANDS.items():
                if args.only and title not in args.only:
                    continue
                (t0, m0), (t1, m1) = (_run(command, clip, out) for clip in clips)
                seconds = (t0 - base_seconds, t1 - base_seconds)
                memory = (m0 - base_memory, m1 - base_memory)
                table.add_row(
                    title,
                    " x ".join(map(str, size)),
                    *(f"{value:.2f}" for value in seconds),
                    f"{log2(seconds[1] / seconds[0]):.2f}",
                    *(f"{value:.0f}" for value in memory),
                    f"{log2(memory[1] / memory[0]):.2f}",
                )
    Console(width=None if sys.stdout.isatty() else 160).print(table)


def _run(command: str, clip: Path, out: Path) -> tuple[float, float]:
    verb, *words = command.format(clip=clip, out=out).split()
    return run_python(["-m", f"usd_tools.{verb}", *words])[1:]


if __name__ == "__main__":
    main()

"""A folder of clips by one command, against one command for each clip.

    python benchmarks/bench_folders.py

200 clips of 300 samples and 31 joints, upsampled by 4. Of the 200 commands, every tenth is run and counted ten times.
Seconds are the processor's, of all cores and processes; those on the clock are beside them.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from pathlib import Path

from bench_usd import Used, make_elsewhere, run_python


def main() -> None:
    """Print the table."""
    from rich.console import Console
    from rich.table import Table

    parse = argparse.ArgumentParser(prog="python benchmarks/bench_folders.py")
    parse.add_argument("--clips", type=int, default=200, metavar="N")
    args = parse.parse_args()
    title = f"{args.clips} clips, 300 samples of 31 joints, upsampled by 4"
    table = Table("command", "processor seconds", "seconds", "of single commands", "peak MiB", title=title)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        clips, out = folder / "clips", folder / "out"
        clips.mkdir()
        make_elsewhere(clips / "clip_000.usdc", 300, 31)
        for k in range(1, args.clips):
            shutil.copy(clips / "clip_000.usdc", clips / f"clip_{k:03}.usdc")
        some = sorted(clips.iterdir())[:: 10 if args.clips >= 20 else 1]
        upsample(some[0], folder / "warm.usdc")
        used = [upsample(clip, folder / "single.usdc") for clip in some]
        scale = args.clips / len(some)
        single = Used(
            scale * sum(each.seconds for each in used),
            scale * sum(each.processor_seconds for each in used),
            max(each.mib for each in used),
        )
        rows = {"one command per clip": single, "one for the folder": upsample(clips, out)}
        shutil.rmtree(out)
        rows["... --jobs 2"] = upsample(clips, out, "--jobs", "2")
    for command, each in rows.items():
        share = each.processor_seconds / single.processor_seconds
        table.add_row(
            command, f"{each.processor_seconds:.1f}", f"{each.seconds:.1f}", f"{share:.2f}", f"{each.mib:.0f}"
        )
    Console(width=None if sys.stdout.isatty() else 120).print(table)


def upsample(source: Path, out: Path, *options: str) -> Used:
    """Upsample a file or a folder in a process of its own."""
    return run_python(["-m", "usd_tools.upsample", str(source), "-o", str(out), "--factor", "4", *options])


if __name__ == "__main__":
    main()

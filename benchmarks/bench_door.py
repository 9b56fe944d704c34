"""Processor seconds until a command has answered, beside bare imports of what it stands on.

    python benchmarks/bench_door.py

Every line is a Python process of its own, user and system time, the least of some runs. Real clips are taken from
../shared/data where it is there, else from the tests.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
RUNS = 5

PITCHING = DATA / "clips" / "pitching.usda"
HIK = DATA / "usd" / "mayausd_HIK_Export.usda"
SHIPPED = ROOT / "tests" / "data" / "punching.usdc"


def processor_seconds(arguments: list[str], exit_code: int = 0) -> float:
    """Return the least processor time of some runs of Python, in seconds."""
    found = []
    for _ in range(RUNS):
        process = subprocess.Popen(
            [sys.executable, *arguments], cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != exit_code:
            raise SystemExit(f"{' '.join(arguments)} ended with exit code {process.returncode}.")
        found.append(usage.ru_utime + usage.ru_stime)
    return min(found)


def main() -> int:
    """Print the table; return 1 if a command takes longer than its bar."""
    verbs = ["-m", "usd_tools"]
    look, move = (PITCHING, HIK) if DATA.exists() else (SHIPPED, SHIPPED)
    with tempfile.TemporaryDirectory() as folder:
        out = str(Path(folder, "out.usda"))
        lines: list[tuple[str, list[str], int, float | None]] = [
            ("python -c pass", ["-c", "pass"], 0, None),
            *((f"import {name}", ["-c", f"import {name}"], 0, None) for name in ("numpy", "pxr.Usd", "numba")),
            ("geomstats-anim --help", [*verbs, "--help"], 0, 0.3),
            ("geomstats-anim --version", [*verbs, "--version"], 0, 0.3),
            ("geomstats-anim upsample --help", [*verbs, "upsample", "--help"], 0, 0.3),
            ("geomstats-anim learn --nonsense", [*verbs, "learn", "--nonsense"], 2, 0.3),
            (f"geomstats-anim inspect {look.name}", [*verbs, "inspect", str(look)], 0, 0.8),
            (f"geomstats-anim upsample {move.name} --factor 4", [*verbs, "upsample", str(move), "-o", out], 0, 1.5),
        ]
        lines[-1][1].extend(["--factor", "4"])
        processor_seconds(lines[-1][1])  # compiles, if need be
        print(f"{'processor seconds':60} {'taken':>6} {'bar':>6}")
        slow = []
        for name, arguments, exit_code, bar in lines:
            taken = processor_seconds(arguments, exit_code)
            if bar is not None and taken > bar:
                slow.append(name)
            print(f"{name:60} {taken:6.2f} {'' if bar is None else format(bar, '6.2f')}")
    if slow:
        print(f"Above the bar: {', '.join(slow)}.")
    return 1 if slow else 0


if __name__ == "__main__":
    raise SystemExit(main())

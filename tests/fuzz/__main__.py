"""Break small files in thousands of ways, and count what the commands say to them.

    python -m tests.fuzz --inputs 10000

Never a traceback, a hang, a file left behind or a changed input: exit code 1 if there is one. What OpenUSD itself dies
of is counted apart. `--only N` writes the file of a number and tells its command.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

for name in ("PXR_WORK_THREAD_LIMIT", "NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"  # a process with threads must not fork

from tests.fuzz.trial import Outcome, Trial, Trials, warm_up  # noqa: E402
from tests.fuzz.workers import run  # noqa: E402


def main() -> int:
    """Print the counts."""
    parse = argparse.ArgumentParser(prog="python -m tests.fuzz")
    parse.add_argument("--inputs", type=int, default=300)
    parse.add_argument("--first", type=int, default=0)
    parse.add_argument("--seed", type=int, default=0)
    parse.add_argument("--workers", type=int, default=2)
    parse.add_argument("--only", type=int, help="write the file of this number here, and tell its command")
    args = parse.parse_args()
    trials = Trials(args.seed)
    if args.only is not None:
        trial = trials[args.only]
        Path(trial.name).write_bytes(trial.data)
        print(trial.command)
        return 0
    counts, sentences, bad = Counter[tuple[str, str]](), Counter[str](), []
    with tempfile.TemporaryDirectory() as folder:
        warm_up(Path(folder))
    start = time.monotonic()

    def told(trial: Trial, outcome: Outcome) -> None:
        counts[trial.suffix, outcome.result] += 1
        if outcome.result == "refused":
            sentences[_kind(outcome.words)] += 1
        elif outcome.result != "accepted":
            bad.append((trial.number, outcome))
            words = outcome.words.splitlines() or [""]
            print(f"{outcome.result} {trial.number}: {trial.command}: {words[0][:300]} ... {words[-1][:300]}")

    run(trials, list(range(args.first, args.first + args.inputs)), args.workers, told)
    results = ("accepted", "refused", "USD", "failed")
    print(f"{args.inputs} inputs of seed {args.seed} in {time.monotonic() - start:.0f} s")
    for suffix in sorted({suffix for suffix, _ in counts}):
        print(f"  {suffix}: " + ", ".join(f"{counts[suffix, result]} {result}" for result in results))
    totals = {result: sum(n for (_, each), n in counts.items() if each == result) for result in results}
    print("  all: " + ", ".join(f"{n} {result}" for result, n in totals.items()))
    print(f"{len(sentences)} kinds of sentences:")
    for words, n in sentences.most_common(None):
        print(f"  {n:5d} {words[:220]}")
    return 1 if totals["failed"] or sum(totals.values()) != args.inputs else 0


def _kind(sentence: str) -> str:
    """Cut names and numbers out of a sentence."""
    sentence = re.sub(r"in\d+\.\w+", "IN", sentence)
    sentence = re.sub(r"(cannot be read as USD: ).*", r"\1...", sentence)
    sentence = re.sub(r"/[\w/.]+|'[^']*'|\b(hips|spine|arm)\b[/\w]*", "X", sentence)
    return re.sub(r"-?\d[\w.+-]*|\bnan\b|\binf\b", "N", sentence)


if __name__ == "__main__":
    sys.exit(main())

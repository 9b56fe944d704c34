"""The command `geomstats-anim VERB ...`: every verb under one name."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module

from geomstats_anim._version import __version__
from usd_tools.console.text import did_you_mean, printable

VERBS = {
    "demo": "see what this is about: a clip rebuilt from a tenth of its samples",
    "inspect": "show the skeletal animation of a file, and warn of what may go wrong",
    "from_bvh": "convert motion capture in BVH to UsdSkel",
    "to_bvh": "convert UsdSkel to BVH",
    "upsample": "add samples, along geodesics of a metric",
    "resample": "exactly F samples per second, on whole frames",
    "repair": "gaps, spikes and drop-outs of recordings, rebuilt",
    "downsample": "keep few samples, and the metric that rebuilds the others",
    "pack": "few bytes, every sample within a tolerance",
    "unpack": "the samples of packed animation",
    "learn": "learn the metric that rebuilds or predicts animation best",
    "live": "see a character play, and bend its in-betweens with the mouse",
    "metric": "show, set, copy, export and import stored metrics",
    "study": "ask people which motion they prefer, and evaluate their answers",
    "compare": "compare interpolation schemes, and write a report",
}
"""Each verb, the module of the same name, in a line."""


def main(argv: Sequence[str] | None = None, prog: str = "geomstats-anim") -> int:
    """Run a verb and return its exit code."""
    arguments = sys.argv[1:] if argv is None else list(argv)
    verb = arguments[0] if arguments else "--help"
    if verb in ("-h", "--help"):
        print(_help(prog))
    elif verb == "--version":
        print(f"geomstats-anim {__version__}")
    elif verb in VERBS:
        return import_module(f"usd_tools.{verb}").main(arguments[1:], f"{prog} {verb}")
    else:
        what = "option" if verb.startswith("-") else "verb"
        sentence = (
            f"error: unknown {what} {printable(verb)}{did_you_mean(verb, (*VERBS, '--help', '--version')) or '.'}"
        )
        print(f"{sentence}\nusage: {prog} VERB ...", file=sys.stderr)
        return 2
    return 0


def _help(prog: str) -> str:
    width = max(map(len, VERBS))
    lines = (f"  {verb:{width}}  {line}" for verb, line in VERBS.items())
    return "\n".join(
        [
            f"usage: {prog} VERB ...",
            "",
            "Interpolate, compress and learn skeletal animation in USD files.",
            "",
            "verbs:",
            *lines,
            "",
            f"{prog} VERB --help lists the options of a verb; {prog} --version shows the version.",
        ]
    )


if __name__ == "__main__":
    sys.exit(main(prog="python -m usd_tools"))

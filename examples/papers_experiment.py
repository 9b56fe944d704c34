"""The papers' experiment on the five example clips: make them, compare all schemes, and say where the page is.

Kushner, Modi and Miolane, "Learning Riemannian Metrics for Interpolating Animations", sections 4 and 5: each clip is
rebuilt from 50, 30, 20, 10 and 5 % of its frames by every scheme, with metrics learned for each clip and rate. Options
that are not named here go to usd_tools.compare, such as --cpus 2.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import make_clips

from usd_tools import compare


def main(argv: list[str] | None = None) -> int:
    """Run the experiment and return 0, or 1 if something could not be written.

    Parameters
    ----------
    argv : list of str, optional
        The arguments; the command line's unless given.

    Returns
    -------
    status : int
    """
    here = Path(__file__).parent
    parser = argparse.ArgumentParser(prog="papers_experiment.py", description=__doc__)
    parser.add_argument("-o", "--out", metavar="FOLDER", type=Path, default=here / "papers_experiment")
    parser.add_argument("--clips", metavar="FOLDER", type=Path, default=here / "clips", help="where the clips go")
    arguments, more = parser.parse_known_args(argv)
    status = make_clips.main(["-o", str(arguments.clips)])
    if status:
        return status
    clips = [str(arguments.clips / f"{name}.usda") for name in make_clips.MOTIONS]
    return compare.main([*clips, "-o", str(arguments.out), *more])


if __name__ == "__main__":
    raise SystemExit(main())

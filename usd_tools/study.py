"""Ask people which motion they prefer, blindly, and say what their answers show.

python -m usd_tools.study walk.usda run.usda -o study
python -m usd_tools.study --results answers-*.json
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from geomstats_anim.names import SCHEME_NAMES
from usd_tools.comparison.options import SchemeChoice
from usd_tools.console.arguments import add_prim, seed, share
from usd_tools.console.errors import UsageError, print_warning, run
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressBar, ProgressCallback
from usd_tools.console.text import say
from usd_tools.studies.options import SCHEMES, StudyOptions
from usd_tools.studies.result import Preference, QuestionResult, StudyResult

__all__ = ["Preference", "QuestionResult", "StudyOptions", "StudyResult", "main", "parser", "study", "study_results"]

PROG = "python -m usd_tools.study"


def study(
    sources: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    options: StudyOptions | None = None,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> StudyResult:
    """Write a page on which people compare pairs of motions without knowing what made them.

    Parameters
    ----------
    sources : path-like or sequence of path-like
        USD files, and folders that are searched with all folders in them.
    out : path-like
        Folder to make; replaced if all its files were made by an earlier study.
    options : StudyOptions
        Optional, default: `StudyOptions()`.
    progress : callable
        Called with the work done, all the work (None if nobody knows), and a text.
        Optional, default: nobody is told.
    warn : callable
        Called with each warning as it comes; all are in the result.
        Optional, default: nobody is told.

    Returns
    -------
    result : StudyResult

    Raises
    ------
    ToolError
        If something is wrong with the files or the folder; nothing is written then.
    """
    from usd_tools.studies.run import make_study

    paths = [sources] if isinstance(sources, str | os.PathLike) else sources
    return make_study(list(map(Path, paths)), Path(out), options or StudyOptions(), progress, warn)


def study_results(files: Sequence[str | os.PathLike[str]]) -> tuple[QuestionResult, ...]:
    """Count answers: preference by scheme with exact intervals, and scores of Bradley and Terry.

    Parameters
    ----------
    files : sequence of path-like
        Answers that were downloaded from the page of one study.

    Returns
    -------
    results : tuple of QuestionResult
        For each question that was answered.

    Raises
    ------
    ToolError
        If a file holds no answers, or the files are of several studies.
    """
    from usd_tools.studies.answers import read_answers
    from usd_tools.studies.statistics import evaluate

    return evaluate(read_answers(list(map(Path, files))))


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Write a blind page: pairs of motions, rebuilt by different schemes from the same keys, play in "
        "sync, in random order and on random sides; people say which is nearer to the original, and which looks more "
        "natural. With --results, evaluate their answers.",
        epilog="The page needs no network. Answers stay in the browser until they are downloaded as JSON, and name "
        "nobody.",
    )
    parse.add_argument(
        "inputs", metavar="IN", type=Path, nargs="*", help="USD file, or a folder to search with its subfolders"
    )
    parse.add_argument(
        "-o",
        "--out",
        metavar="FOLDER",
        type=Path,
        help="output folder; replaced only if an earlier run of this command created it",
    )
    parse.add_argument(
        "--results", metavar="FILE", type=Path, nargs="+", help="evaluate these answers instead of writing a page"
    )
    parse.add_argument(
        "--rate", metavar="S", type=share, default=0.1, help="share of the samples to keep as uniform keys; default: .1"
    )
    parse.add_argument(
        "--schemes",
        metavar="SCHEME",
        type=SchemeChoice.parse,
        nargs="+",
        default=list(SCHEMES),
        help=f"at least two of {', '.join(SCHEME_NAMES)}; a learned scheme may be plain, with nothing learned; "
        f"default: {' '.join(choice.word for choice in SCHEMES)}",
    )
    parse.add_argument("--seed", metavar="N", type=seed, default=0, help="of the order and the sides; default: 0")
    add_prim(parse)
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    parse = parser(prog)
    args = parse.parse_args(argv)

    def command() -> int:
        if args.results:
            if args.inputs or args.out:
                raise UsageError("--results takes neither IN nor --out")
            from usd_tools.studies.summary import print_results

            print_results(study_results(args.results))
            return 0
        if not args.inputs or args.out is None:
            raise UsageError("name files with IN, and the output with -o/--out; or answers with --results")
        options = StudyOptions.from_args(args)
        with ProgressBar() as bar:
            result = study(args.inputs, args.out, options, progress=bar, warn=print_warning)
        say(
            f"Wrote {result.page}: {result.questions} questions about {len(result.clips)} clips and "
            f"{', '.join(result.schemes)}. Send it to people, and read their answers with --results."
        )
        return 0

    return run(command, parse.error)


if __name__ == "__main__":
    sys.exit(main())

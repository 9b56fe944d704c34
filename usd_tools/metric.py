"""Show, set, copy, export and import stored metrics: style as data, without new samples.

python -m usd_tools.metric set walk.usda -o walk_style.usda --joint '*Arm*:alpha=4,tension=.5'
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from usd_tools.batch.tasks import is_batch
from usd_tools.console.arguments import add_inputs, add_output, add_prim, add_several
from usd_tools.console.errors import print_warning, run
from usd_tools.console.parser import ArgumentParser
from usd_tools.styling.options import MetricOptions
from usd_tools.styling.result import AnimationMetric, MetricResult
from usd_tools.upsampling.arguments import add_metric

if TYPE_CHECKING:
    from pxr import Usd

__all__ = [
    "AnimationMetric",
    "MetricOptions",
    "MetricResult",
    "export_metric",
    "main",
    "parser",
    "set_metric",
    "set_metric_stage",
    "show_metric",
    "show_metric_stage",
]

PROG = "python -m usd_tools.metric"


def show_metric(
    source: str | os.PathLike[str], *, prim: Sequence[str] = (), warn: Callable[[str], None] | None = None
) -> MetricResult:
    """Read the metrics that a USD file stores.

    Parameters
    ----------
    source : path-like
        USD file.
    prim : sequence of str
        Paths of SkelAnimations, Skeletons or prims above them.
        Optional, default: all animations.
    warn : callable
        Called with each warning as it comes; all are in the result.
        Optional, default: nobody is told.

    Returns
    -------
    result : MetricResult

    Raises
    ------
    ToolError
        If the file cannot be read, or has no animation.
    """
    from usd_tools.styling.run import show_file

    return show_file(Path(source), prim, warn)


def show_metric_stage(
    stage: Usd.Stage, *, prim: Sequence[str] = (), warn: Callable[[str], None] | None = None
) -> MetricResult:
    """Read the metrics that an open stage stores; see `show_metric`."""
    from usd_tools.styling.run import show_open_stage

    return show_open_stage(stage, prim, warn)


def set_metric(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str] | None,
    options: MetricOptions,
    *,
    warn: Callable[[str], None] | None = None,
) -> MetricResult:
    """Store metrics with the animations of a USD file; no sample changes.

    Parameters
    ----------
    source : path-like
        USD file.
    out : path-like or None
        USD file to write; None with `in_place`.
    options : MetricOptions
    warn : callable
        See `show_metric`.

    Returns
    -------
    result : MetricResult

    Raises
    ------
    UsageError
        If the output is not named, or there is no such preset.
    ToolError
        If something is wrong with the file or the options do not fit it; nothing is written then.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from pxr import Usd, UsdSkel
    >>> folder = Path(tempfile.mkdtemp())
    >>> stage = Usd.Stage.CreateNew(str(folder / "turn.usda"))
    >>> _ = UsdSkel.Animation.Define(stage, "/Turn").CreateJointsAttr(["arm", "arm/hand"])
    >>> stage.Save()
    >>> _ = set_metric(folder / "turn.usda", folder / "style.usda", MetricOptions(joint="hand:alpha=4"))
    >>> show_metric(folder / "style.usda").animations[0].metric.parameters.alpha.tolist()
    [1.0, 4.0]
    """
    from usd_tools.styling.run import set_file

    return set_file(Path(source), None if out is None else Path(out), options, None, warn)


def set_metric_stage(
    stage: Usd.Stage, options: MetricOptions, *, warn: Callable[[str], None] | None = None
) -> MetricResult:
    """Store metrics with the animations of an open stage, in the layer of its edit target; see `set_metric`."""
    from usd_tools.styling.run import set_open_stage

    return set_open_stage(stage, options, warn)


def export_metric(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    prim: Sequence[str] = (),
    warn: Callable[[str], None] | None = None,
) -> MetricResult:
    """Write the metric that a USD file stores as JSON, which `--metric` takes everywhere.

    Parameters
    ----------
    source : path-like
        USD file.
    out : path-like
        JSON file to write.
    prim, warn : sequence of str, callable
        See `show_metric`.

    Returns
    -------
    result : MetricResult

    Raises
    ------
    ToolError
        If the file stores no metric, or different ones.
    """
    from usd_tools.styling.run import export_file

    return export_file(Path(source), Path(out), prim, warn)


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Show, set, copy, export and import stored metrics: style as data, without new samples.",
    )
    actions = parse.add_subparsers(dest="action", required=True, metavar="ACTION", help="one of these", prog=prog)

    show = _action(actions, "show", "Show the metric of each joint, and what is wrong with what is stored.")
    show.add_argument("input", metavar="IN", type=Path, help="USD file")
    add_prim(show)
    show.add_argument("--json", action="store_true", help="print JSON instead of tables")

    change = _action(actions, "set", "Store a metric with the animations of a file; what is not named stays as stored.")
    add_inputs(change)
    _add_out(change)
    change.add_argument(
        "--preset", metavar="NAME", help="slerp, smooth, soft, snappy, or a JSON file of usd_tools.live; styles follow"
    )
    add_metric(change)
    _add_rest(change)
    add_several(change)

    copy = _action(actions, "copy", "Give the animations of a file the metric of another, by names of joints.")
    copy.add_argument("metric", metavar="FROM", type=Path, help="USD file that stores a metric")
    copy.add_argument("input", metavar="IN", type=Path, help="USD file that is to get it")
    _add_out(copy)
    _add_rest(copy)

    export = _action(actions, "export", "Write the metric of a file as JSON.")
    export.add_argument("input", metavar="IN", type=Path, help="USD file")
    export.add_argument("-o", "--out", metavar="OUT", type=Path, required=True, help="JSON file to write")
    add_prim(export)

    bring = _action(
        actions, "import", "Give the animations of a file the metric of a JSON file, by the names of joints."
    )
    bring.add_argument("input", metavar="IN", type=Path, help="USD file that is to get it")
    bring.add_argument("metric", metavar="METRIC", type=Path, help="JSON file that export or learn wrote")
    _add_out(bring)
    _add_rest(bring)
    return parse


def _action(actions: argparse._SubParsersAction, name: str, description: str) -> ArgumentParser:
    parse = actions.add_parser(name, description=description, help=description[0].lower() + description[1:-1])
    parse.set_defaults(usage_error=parse.error)
    return parse


def _add_out(parse: ArgumentParser) -> None:
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, help="USD file, or folder, to write; .usdz packs all")


def _add_rest(parse: ArgumentParser) -> None:
    add_prim(parse)
    add_output(parse)
    parse.add_argument("--report", metavar="FILE", type=Path, help="write a report as JSON")


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    args = parser(prog).parse_args(argv)
    return run({"show": _show, "export": _export}.get(args.action, _set)(args), args.usage_error)


def _show(args: argparse.Namespace) -> Callable[[], int]:
    def command() -> int:
        result = show_metric(args.input, prim=args.prim, warn=print_warning)
        if args.json:
            print(json.dumps(result.as_dict(), indent=2))
        else:
            from usd_tools.styling.summary import print_metrics

            print_metrics(result)
        return 0

    return command


def _export(args: argparse.Namespace) -> Callable[[], int]:
    def command() -> int:
        result = export_metric(args.input, args.out, prim=args.prim, warn=print_warning)
        from usd_tools.styling.summary import print_written

        print_written(result)
        return 0

    return command


def _set(args: argparse.Namespace) -> Callable[[], int]:
    def command() -> int:
        options = MetricOptions.from_args(args)
        if args.action == "set" and is_batch(args):
            from usd_tools.batch.command import run_verb
            from usd_tools.styling.run import set_file

            return run_verb("usd_tools.metric", set_file, args, options)
        source = args.input[0] if args.action == "set" else args.input
        result = set_metric(source, args.out, options, warn=print_warning)
        from usd_tools.styling.summary import print_written

        print_written(result)
        return 0

    return command


if __name__ == "__main__":
    sys.exit(main())

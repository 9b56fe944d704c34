"""Pack skeletal animation into few bytes, no point further from its place than a tolerance.

python -m usd_tools.pack walk.usda -o walk_packed.usdc --tolerance 1
python -m usd_tools.unpack walk_packed.usdc -o walk_back.usdc
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from geomstats_anim.names import EFFORTS, MEASURES, WEIGHTS_TOLERANCE
from usd_tools.batch.main import Work, run_on_files
from usd_tools.console.arguments import add_inputs, add_output, add_prim, add_several, positive_number
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressCallback
from usd_tools.packing.options import PackOptions, preview_keys
from usd_tools.packing.result import PackedAnimation, PackResult

if TYPE_CHECKING:
    from pxr import Usd

__all__ = ["PackOptions", "PackResult", "PackedAnimation", "main", "pack", "pack_stage", "parser"]

PROG = "python -m usd_tools.pack"


def pack(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str] | None,
    options: PackOptions,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> PackResult:
    """Pack the skeletal animation of a USD file.

    Parameters
    ----------
    source : path-like
        USD file.
    out : path-like or None
        USD file to write; None with `in_place`.
    options : PackOptions
    progress : callable
        Called with the work done, all the work (None if nobody knows), and a text.
        Optional, default: nobody is told.
    warn : callable
        Called with each warning as it comes; all are in the result.
        Optional, default: nobody is told.

    Returns
    -------
    result : PackResult

    Raises
    ------
    UsageError
        If the output is not named.
    ToolError
        If something is wrong with the file, the options do not fit it, or what was written does not hold the tolerance;
        nothing is left behind then.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from pxr import Gf, Usd, UsdSkel
    >>> folder = Path(tempfile.mkdtemp())
    >>> stage = Usd.Stage.CreateNew(str(folder / "turn.usda"))
    >>> arm = UsdSkel.Skeleton.Define(stage, "/Arm")
    >>> _ = arm.CreateJointsAttr(["arm"]), arm.CreateRestTransformsAttr([Gf.Matrix4d(1)])
    >>> turn = UsdSkel.Animation.Define(stage, "/Arm/Turn")
    >>> _ = turn.CreateJointsAttr(["arm"])
    >>> _ = UsdSkel.BindingAPI.Apply(arm.GetPrim()).CreateAnimationSourceRel().SetTargets(["/Arm/Turn"])
    >>> for code in range(11):
    ...     _ = turn.CreateRotationsAttr().Set([Gf.Quatf(Gf.Rotation((1, 0, 0), 9 * code).GetQuat())], code)
    >>> stage.Save()
    >>> result = pack(folder / "turn.usda", folder / "packed.usdc", PackOptions(tolerance=0.1))
    >>> result.animations[0].samples, result.animations[0].errors["centimetres"]["largest"] <= 0.1
    (11, True)
    """
    from usd_tools.packing.run import pack_file

    return pack_file(Path(source), None if out is None else Path(out), options, progress, warn)


def pack_stage(
    stage: Usd.Stage,
    options: PackOptions,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> PackResult:
    """Pack the skeletal animation of an open stage, in the layer of its edit target.

    What is left there for viewers hides the samples of weaker layers, which stay there.

    Parameters
    ----------
    stage : Usd.Stage
    options : PackOptions
        Those about files are not used.
    progress, warn : callable
        See `pack`.

    Returns
    -------
    result : PackResult

    Raises
    ------
    ToolError
        If something is wrong with the stage, the options do not fit it, or stronger opinions would hide what is
        written; the layer is as it was then.
    """
    from usd_tools.packing.run import pack_open_stage

    return pack_open_stage(stage, options, progress, warn)


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Pack skeletal animation: joints and blend shape weights in few bytes, at every sample within a "
        "tolerance that is measured on the written file. Everything else on the stage is unchanged. Every verb reads "
        "OUT as if it had all samples; usd_tools.unpack restores them; other programs see the preview.",
    )
    add_inputs(parse)
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, help="USD file or folder to write")
    parse.add_argument(
        "--tolerance",
        metavar="CM",
        type=positive_number,
        required=True,
        help="largest distance in the world of any measured point from its place, in centimetres",
    )
    parse.add_argument(
        "--measure",
        choices=MEASURES,
        default="shell",
        help="points that --tolerance is about: joints, bone ends and points around the joints (shell, the default); "
        "joints and bone ends alone (ends); or the points of the skin too (skin)",
    )
    parse.add_argument(
        "--shell",
        metavar="CM",
        type=positive_number,
        help="distance of the points of the shell from joints; default: 3",
    )
    parse.add_argument(
        "--weights-tolerance",
        metavar="W",
        type=positive_number,
        default=WEIGHTS_TOLERANCE,
        help="largest error of blend shape weights; default: %(default)g",
    )
    parse.add_argument(
        "--preview",
        metavar="K",
        type=preview_keys,
        default=0,
        help="samples that stay for programs that do not unpack: the K best for slerp, or one pose (0, the default)",
    )
    parse.add_argument(
        "--segment", metavar="SECONDS", type=positive_number, help="pack pieces of this length that unpack alone"
    )
    parse.add_argument(
        "--effort",
        choices=EFFORTS,
        default=EFFORTS[0],
        help="full (the default), or fast: a tenth of the time, larger files",
    )
    parse.add_argument(
        "--no-xforms", action="store_true", help="leave the transforms that move a character as a whole as they are"
    )
    add_prim(parse)
    add_output(parse)
    parse.add_argument("--report", metavar="FILE", type=Path, help="write bytes and errors as JSON")
    add_several(parse)
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    return run_on_files(parser(prog), argv, "usd_tools.pack", PackOptions, _work)


def _work() -> Work:
    from usd_tools.packing.run import pack_file
    from usd_tools.packing.summary import print_packed

    return pack_file, lambda result, args: print_packed(result, args.input[0])


if __name__ == "__main__":
    sys.exit(main())

"""Options of the command lines that lead curves through samples; imports nothing that is slow."""

from __future__ import annotations

import argparse
from pathlib import Path

from geomstats_anim.names import DEFAULT_SCHEME, INVARIANCES, SCHEME_NAMES
from usd_tools.console.arguments import positive_number, time_codes
from usd_tools.upsampling.joint_styles import parse_style, tension_number
from usd_tools.upsampling.options import EULER_ORDERS


def add_cuts(parse: argparse.ArgumentParser) -> None:
    """Add the options that say which samples a curve links, and whether transforms are among them."""
    cuts = parse.add_mutually_exclusive_group()
    cuts.add_argument(
        "--cut",
        metavar="T",
        type=time_codes,
        help="hold the pose across the gaps between samples in which these time codes are, or which end there; "
        "default: the gaps across which it jumps far more than before and after",
    )
    cuts.add_argument("--no-cuts", action="store_true", help="lead the motion through every jump")
    parse.add_argument(
        "--no-xforms", action="store_true", help="leave the transforms that move a character as a whole as they are"
    )
    parse.add_argument(
        "--euler",
        choices=EULER_ORDERS,
        help="write the turns of joints as Euler angles too, in degrees and without jumps: custom attributes "
        "geomstatsAnim:eulerAngles and eulerOrder of the SkelAnimation; XYZ turns about x first, as xformOp:rotateXYZ",
    )
    parse.add_argument(
        "--loop",
        action="store_true",
        help="the motion is a cycle, whose first pose is the last, or comes one sample later: lead curves across the "
        "seam, and fill it; what roots travel goes on with each cycle",
    )


def add_contacts(parse: argparse.ArgumentParser) -> None:
    """Add the options that keep feet on the ground."""
    parse.add_argument(
        "--contacts",
        action="store_true",
        help="keep what is planted on the ground in two samples, such as feet, in place between them: the joints above "
        "turn as little as their metric allows, and what moves the whole body comes last; with any --scheme, "
        "and on top of a --library",
    )
    parse.add_argument(
        "--contact-reach",
        metavar="CM",
        type=positive_number,
        help="with --contacts: leave a point to lift that would have to be moved further than this; default: 10",
    )


def add_metric(parse: argparse.ArgumentParser) -> None:
    """Add the options for the scheme and its metric."""
    parse.add_argument(
        "--scheme",
        choices=SCHEME_NAMES,
        help=f"interpolation; default: the scheme that the metric was learned for, else {DEFAULT_SCHEME}",
    )
    parse.add_argument(
        "--metric",
        metavar="M",
        help="stored, identity, a JSON file, a USD file that stores one, or learn: fit on every other sample; kept "
        "only where cross-validation shows it beats slerp; default: stored if the file stores one, else identity",
    )
    parse.add_argument("--alpha", metavar="A", type=positive_number, help="second principal moment, for all joints")
    parse.add_argument("--beta", metavar="B", type=positive_number, help="third principal moment, for all joints")
    parse.add_argument("--invariance", choices=INVARIANCES, help="side of the metric, for all joints")
    parse.add_argument(
        "--tension",
        metavar="T",
        type=tension_number,
        help="of geodesic-spline, for the turns of all joints: 0 as geodesic, 1 continuous velocity, 2 continuous "
        "acceleration",
    )
    parse.add_argument(
        "--translation-tension", metavar="T", type=tension_number, help="the same for the translations of all joints"
    )
    parse.add_argument(
        "--joint",
        metavar="STYLE",
        type=parse_style,
        action="append",
        default=[],
        help="set values for joints whose name matches: 'PATTERN:alpha=4,beta=.5,invariance=right,tension=0', also "
        "translation-tension, and axes=X Y Z: their rotation vector in degrees; repeatable, the last wins",
    )


def add_library(parse: argparse.ArgumentParser) -> None:
    """Add the option for a library."""
    parse.add_argument(
        "--library",
        metavar="FILE",
        type=Path,
        help="predict what splines miss from other clips of this rig, as far as it helps on the samples themselves; "
        "FILE is made by usd_tools.learn --library; implies --scheme learned",
    )

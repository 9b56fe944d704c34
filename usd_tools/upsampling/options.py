"""Options of `upsample`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from geomstats_anim.names import INVARIANCES, LEARNED, SCHEME_NAMES
from usd_tools.console.arguments import SOURCE, TimeCodes, as_time_codes, positive_number, whole_number
from usd_tools.console.errors import UsageError
from usd_tools.console.options import OutputOptions, one_of, option, several
from usd_tools.skel.frame_rates import typed_rate
from usd_tools.upsampling.joint_styles import Style, parse_style, tension_number

EULER_ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
"""Those of transform ops: XYZ turns about x first."""

METRIC_WORDS = ("stored", "identity", "learn")
"""Metrics that are no file."""


def _metric(value: str | Path) -> str | Path:
    return value if isinstance(value, str) and value in METRIC_WORDS else Path(value)


def _style(value: str | Style) -> Style:
    return value if isinstance(value, Style) else parse_style(value)


@dataclass(frozen=True, kw_only=True)
class StyleOptions(OutputOptions):
    """Options that say how in-betweens look: the scheme, and the metric of each joint.

    Parameters
    ----------
    scheme : str
        Interpolation scheme.
        Optional, default: the one that the metric was made for, else "geodesic-spline".
    metric : str or Path
        "stored", "identity", "learn", a JSON file, or a USD file that stores one.
        Optional, default: the stored one where there is one, else the identity.
    alpha, beta : float
        Second and third principal moment, for all joints; the first is 1.
    invariance : str
        "left" or "right", for all joints.
    tension, translation_tension : float
        Of geodesic-spline, from 0 (as geodesic) by 1 (continuous velocity) to 2 (continuous acceleration), for the
        turns and for the translations of all joints.
    joint : tuple of str or Style
        Settings of the joints whose name matches, such as "arm*:alpha=4,invariance=right,tension=0"; the last wins.
    """

    scheme: str | None = option(None, one_of(SCHEME_NAMES))
    metric: str | Path | None = option(None, _metric)
    alpha: float | None = option(None, positive_number)
    beta: float | None = option(None, positive_number)
    invariance: str | None = option(None, one_of(INVARIANCES))
    tension: float | None = option(None, tension_number)
    translation_tension: float | None = option(None, tension_number)
    joint: tuple[Style, ...] = option((), several(_style))

    @property
    def styles(self) -> tuple[Style, ...]:
        """Settings by hand: those of all joints, then those of patterns."""
        everywhere = Style("*", self.alpha, self.beta, self.invariance, self.tension, self.translation_tension)
        return (*(() if everywhere == Style("*") else (everywhere,)), *self.joint)


@dataclass(frozen=True, kw_only=True)
class CurveOptions(StyleOptions):
    """Options of the verbs that lead curves through the samples of a file: which samples they link.

    Those of `StyleOptions` are not repeated here.

    Parameters
    ----------
    library : Path
        File that `learn` made of clips of this rig, for the scheme "learned", which it implies.
    cut : str, TimeCodes or sequence of float
        Time codes at which the pose is held until the next sample, instead of where it is found to jump.
    no_cuts : bool
        Lead the motion through every jump.
    no_xforms : bool
        Leave the transforms that move a character as a whole as they are.
    euler : str
        Order, such as "XYZ", of Euler angles to write beside the quaternions.
        Optional, default: none are written.
    loop : bool
        Lead curves from the last sample on to the first: the motion is a cycle.
    dry_run : bool
        Do all but write.
    verbose : bool
        Warn of every step of more than 120 degrees, not only of the widest.
    """

    library: Path | None = option(None, Path)
    cut: TimeCodes | None = option(None, as_time_codes)
    no_cuts: bool = option(False, bool)
    no_xforms: bool = option(False, bool)
    euler: str | None = option(None, one_of(EULER_ORDERS))
    loop: bool = option(False, bool)
    dry_run: bool = option(False, bool, recorded=False)
    verbose: bool = option(False, bool, recorded=False)

    def check(self) -> None:
        """Refuse values that do not go together."""
        if self.library is not None and self.scheme not in (None, LEARNED):
            raise UsageError(f"--library is for --scheme {LEARNED}, not {self.scheme}")
        if self.scheme == LEARNED and self.library is None:
            raise UsageError(f"--scheme {LEARNED} needs --library FILE, which usd_tools.learn --library makes")
        if self.cut is not None and self.cut.text == SOURCE:
            raise UsageError("--cut must be numbers with commas between them, or a file of such")
        if self.cut is not None and self.no_cuts:
            raise UsageError("--cut and --no-cuts cannot go together; leave one of them out")

    @property
    def looks_for_cuts(self) -> bool:
        """True if cuts are where the pose is found to jump."""
        return self.cut is None and not self.no_cuts


@dataclass(frozen=True, kw_only=True)
class UpsampleOptions(CurveOptions):
    """Options of `upsample`, in the words of its command line; exactly one of `factor`, `fps` and `times` is needed.

    Those of `CurveOptions` are not repeated here.

    Parameters
    ----------
    factor : int
        Parts that every gap between samples is cut into.
    fps : float
        Samples per second.
    times : str, TimeCodes or sequence of float
        Time codes of the stage; or "source": where `downsample` removed samples.
    retime : bool
        With `fps`: give the output `fps` time codes per second, so that added samples are whole frames.
    contacts : bool
        Keep points that are planted on the ground, such as feet, where they are between samples.
    contact_reach : float
        With `contacts`: centimetres by which a point is moved at most; one that would be moved further is left to lift.
        Optional, default: 10.
    """

    factor: int | None = option(None, whole_number)
    fps: float | None = option(None, typed_rate)
    times: TimeCodes | None = option(None, as_time_codes)
    retime: bool = option(False, bool)
    contacts: bool = option(False, bool)
    contact_reach: float | None = option(None, positive_number)

    def check(self) -> None:
        """Refuse values that do not go together."""
        given = [word for word in ("factor", "fps", "times") if getattr(self, word) is not None]
        if len(given) != 1:
            raise UsageError(f"name exactly one of --factor, --fps and --times, not {' and '.join(given) or 'none'}")
        if self.retime and self.fps is None:
            raise UsageError("--retime needs --fps")
        if self.contact_reach is not None and not self.contacts:
            raise UsageError("--contact-reach needs --contacts")
        super().check()

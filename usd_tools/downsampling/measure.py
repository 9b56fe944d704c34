"""Choose the points whose distance in the world a tolerance is about."""

from __future__ import annotations

import numpy as np

from geomstats_anim import Animation
from geomstats_anim.markers import Markers, largest_by_marker, spread
from usd_tools.console.errors import ToolError
from usd_tools.downsampling.options import DownsampleOptions
from usd_tools.downsampling.thinning import Errors
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.resampling import animation_of
from usd_tools.skel.skin import skin_markers


class Measure:
    """Points to measure, and as few of them as tell what the others will: skin has many.

    Parameters
    ----------
    clip : SkelClip
    options : DownsampleOptions

    Attributes
    ----------
    markers : Markers
        All that is measured.
    shown : Markers
        Those that tables are about: without the joints themselves, where bone ends are measured.

    Raises
    ------
    ToolError
        If the skin is to be measured, and joints move none.
    """

    def __init__(self, clip: SkelClip, options: DownsampleOptions) -> None:
        self.markers, self.shown = Markers.of_bones(clip.skeleton), Markers.of_ends(clip.skeleton)
        if options.measured == "shell":
            self.markers = self.shown = Markers.of_shell(animation_of(clip), 0.01 * options.shell_centimetres)
        self._chosen = np.arange(self.markers.n_markers)
        if options.measured == "skin" and clip.joints:
            skin = skin_markers(clip)
            if not skin.n_markers:
                raise ToolError(
                    f"{clip.path} moves no skinned mesh, so --measure skin cannot be used; use --measure shell."
                )
            few = spread(skin)
            self._chosen = np.concatenate([self._chosen, self.markers.n_markers + few])
            self.markers = self.shown = self.markers.joined(skin)

    @property
    def few(self) -> Markers:
        """The points that keys are chosen by."""
        return self.markers.chosen(self._chosen)

    def errors(self, rebuilt: SkelClip, source: SkelClip) -> Errors:
        """Compare two clips that have the same samples."""
        return Errors.between(rebuilt, source, self.shown, self.markers)

    def add_missed(self, rebuilt: Animation, truth: Animation, tolerance: float) -> bool:
        """Add the worst point of each joint beyond a tolerance, metres, to the few; return whether any is new."""
        distances = largest_by_marker(rebuilt, truth, self.markers)
        order = np.lexsort((-distances, self.markers.owners))
        _, first = np.unique(self.markers.owners[order], return_index=True)
        worst = order[first]
        missed = np.setdiff1d(worst[distances[worst] > tolerance], self._chosen)
        self._chosen = np.union1d(self._chosen, missed)
        return bool(len(missed))

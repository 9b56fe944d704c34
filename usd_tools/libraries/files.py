"""A library's file: read, and matched to a clip's rig."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from geomstats_anim.learning.library.motion_library import MotionLibrary
from geomstats_anim.learning.library.storage import LARGEST, load_library
from usd_tools.console.errors import ToolError
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.vertical import vertical

UPRIGHT = 0.98
"""Cosine between verticals that are the same."""


@dataclass(frozen=True, eq=False)
class LibraryFile:
    """A library and the file that it is from.

    Parameters
    ----------
    name : str
    sha256 : str
    library : MotionLibrary
    """

    name: str
    sha256: str
    library: MotionLibrary

    @classmethod
    def read(cls, path: Path) -> LibraryFile:
        """Read a library.

        Raises
        ------
        ToolError
            If it cannot be read, or is broken.
        """
        try:
            with path.open("rb") as file:
                data = file.read(LARGEST + 1)
            return cls(path.name, hashlib.sha256(data).hexdigest(), load_library(data))
        except FileNotFoundError as error:
            raise ToolError(
                f"--library {path}: there is no such file; make one with usd_tools.learn CLIPS --purpose predict "
                "--library -o FILE.inbetween."
            ) from error
        except OSError as error:
            raise ToolError(f"--library {path} cannot be read: {error.strerror}.") from error
        except ValueError as error:
            raise ToolError(f"--library {path}: {error}") from error

    def check(self, clip: SkelClip) -> None:
        """Refuse a clip of another rig.

        Raises
        ------
        ToolError
        """
        difference = self.library.rig_difference(clip.skeleton)
        if not difference and self.library.vertical @ vertical(clip) < UPRIGHT:
            difference = "another axis is up"
        if difference:
            raise ToolError(
                f"{clip.path} is of another rig than the library {self.name}: {difference}; learn a library from "
                "clips of this rig."
            )

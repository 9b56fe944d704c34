"""Result of `inspect`, as plain values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from usd_tools.console.text import counted


@dataclass(frozen=True)
class InspectResult:
    """Content of a file or a stage; a value that does not apply is None.

    Parameters
    ----------
    file : str
        Name of the file, or of the stage's root layer.
    layers : tuple of str
        Names of the layers that are used.
    default_prim : str or None
    up_axis : str
    meters_per_unit : float
    time_codes_per_second : float
    frames_per_second, start_time_code, end_time_code : float or None
        Where they are authored.
    skeletons : tuple of dict
        prim, joints, animation, instance, size (at rest in the world, metres), joints_off_bind_pose (elsewhere at
        rest).
    animations : tuple of dict
        prim, instances, skeletons, error (then nothing more), joints, rig (8 digits, the same for the same joints),
        still_joints, blend_shapes, meters_per_unit (in the world), channels (a name each: samples, value_blocks,
        held_gaps, from), samples, codes and seconds (first and last), samples_per_second, evenly_spaced,
        samples_of_source (of a sparse animation), packed_bytes (of a packed one), stepped_pairs, largest_step and
        wide_steps (joint, start, end, degrees), largest_step_joint (its short name), loop (None, or of what is nearly
        one: closed, misses_degrees, joint, joint_name), contacts (None, or of a folder's files: the joints that are
        planted on the ground, and the share of the time in which one is), faults (kind, channel, joint, joint_name,
        start and end, samples, degrees or centimetres; as `repair` finds them), sign_flips, not_unit_quaternions,
        metric (error, summary, scheme, joints, quality, provenance, by_joint).
    warnings : tuple of str
    """

    file: str
    layers: tuple[str, ...]
    default_prim: str | None
    up_axis: str
    meters_per_unit: float
    time_codes_per_second: float
    frames_per_second: float | None
    start_time_code: float | None
    end_time_code: float | None
    skeletons: tuple[dict[str, Any], ...]
    animations: tuple[dict[str, Any], ...]
    warnings: tuple[str, ...]

    @property
    def brief(self) -> str:
        """Summary of what is there, in a few words."""
        return counted(len(self.animations), "animation")

    def as_dict(self) -> dict[str, Any]:
        """Return what `--json` prints."""
        return {name: list(value) if isinstance(value, tuple) else value for name, value in vars(self).items()}

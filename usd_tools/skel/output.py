"""Write a command's result: a layer over the source, one flattened file, or the source itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pxr import Usd

from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.options import OutputOptions
from usd_tools.files.atomic import Verify
from usd_tools.files.openusd_gaps import lost_by_flattening
from usd_tools.files.packages import check_package
from usd_tools.files.paths import check_output, check_usd_output, extension, same_file
from usd_tools.files.stages import files_outside
from usd_tools.skel.find import AnimationSource
from usd_tools.skel.writer import OverrideLayer, save, save_copy, save_in_place

_A_FEW = 5
"""Variant sets that are named; a crowd has more."""


@dataclass(frozen=True)
class Output:
    """Destination of a command's result.

    Parameters
    ----------
    source : Path
        File that is read.
    out : Path or None
        File to write.
    options : OutputOptions
    copy : bool
        Whether to write the source's own layer, changed, instead of a layer over it.
        Optional, default: False.
    """

    source: Path
    out: Path | None
    options: OutputOptions
    copy: bool = False

    @property
    def path(self) -> Path:
        """File that is written."""
        return self.source if self.options.in_place or self.out is None else self.out

    def check(self) -> None:
        """Check the names, before any work is done.

        Raises
        ------
        ToolError
            If one of them cannot be written, or is another's.
        """
        if self.out is not None:
            check_usd_output(self.out, self.options.usd_format)
            if same_file(self.out, [self.source]) and not self.options.in_place:
                raise ToolError(f"--out {self.out} is the input itself; choose another name, or add --in-place.")
            if self.options.in_place and not same_file(self.out, [self.source]):
                raise ToolError(f"--in-place changes {self.source}, but --out is {self.out}; leave one of them out.")
        if self.options.in_place:
            if extension(self.source) == ".usdz":
                raise ToolError(
                    f"{self.source} is a package and cannot be changed in place; name another file with --out."
                )
            check_output(self.source, "--in-place")
        check_report(self.options.report, self.source, self.path)
        if extension(self.source) == extension(self.path) == ".usdz" and self.source.is_file():
            check_package(self.source, 1e9 * self.options.max_unpacked)

    def check_layers(self, stage: Usd.Stage) -> None:
        """Refuse to write over a file that the source needs."""
        needed = [layer.realPath for layer in stage.GetUsedLayers() if layer != stage.GetRootLayer()]
        for argument, path in (("--out", self.out), ("--report", self.options.report)):
            if path is not None and same_file(path, needed):
                raise ToolError(f"{argument} {path} is a file that {self.source} needs; choose another name.")

    def without_source(self, sources: Sequence[AnimationSource]) -> Output:
        """Have the result hold what it needs of some animations, so that the source's samples can go.

        If they are in the source's own layer, a copy of it is changed, which keeps all composition. Otherwise the
        result is flattened.

        Raises
        ------
        ToolError
            If the source is to be changed in place, but they are in other files.
        """
        if all(_is_in_root_layer(source) for source in sources) and extension(self.path) != ".usdz":
            return replace(self, copy=True)
        if self.options.in_place and not self.options.flatten:
            raise ToolError(
                f"--in-place: the samples are in files that {self.source} needs; name another file with --out."
            )
        return replace(self, options=replace(self.options, flatten=True))

    def layer(
        self,
        stage: Usd.Stage,
        tool: str,
        settings: Mapping[str, Any],
        messages: Messages,
        codes_per_second: float | None = None,
    ) -> OverrideLayer:
        """Begin the layer that is to be written, see `OverrideLayer`; warn of what flattening will take from it."""
        fixed = lost_by_flattening(stage) if self.options.flatten else []
        if fixed:
            more = f" and {len(fixed) - _A_FEW} more" if len(fixed) > _A_FEW else ""
            messages.warn(f"flattening keeps only the selected variants: {', '.join(fixed[:_A_FEW])}{more}.")
        if extension(self.path) == ".usdz":
            for file in files_outside(self.source):
                messages.warn(f"{self.path} will hold {file}, which is outside the folder of {self.source}.")
        base = stage.GetRootLayer() if (self.options.in_place or self.copy) and not self.options.flatten else None
        return OverrideLayer(stage, tool, settings, codes_per_second, base)

    def save(self, layer: OverrideLayer, verify: Verify | None = None) -> None:
        """Write the layer; `verify` looks at it before it takes the place of an older file, see `written_beside`."""
        if self.options.in_place and not self.options.flatten:
            save_in_place(layer, self.source.resolve(), verify)
        elif self.copy and not self.options.flatten:
            save_copy(layer, self.source, self.path, self.options.usd_format, verify)
        else:
            save(layer, self.source, self.path, self.options.usd_format, self.options.flatten, verify)


def _is_in_root_layer(source: AnimationSource) -> bool:
    """Return whether all opinions on an animation are in the layer that was opened."""
    layers = {spec.layer for spec in source.prim.GetPrimStack()}
    root = source.stage.GetRootLayer()
    return layers == {root} and not source.prim.IsInstanceProxy() and not root.GetFileFormat().IsPackage()


def check_report(report: Path | None, *others: Path) -> None:
    """Check the name of a report: a file that can be written, and none of the others."""
    if report is not None:
        check_output(report, "--report")
        if same_file(report, others) or report.resolve() in [other.resolve() for other in others]:
            raise ToolError(f"--report {report} is the input or the output; choose another name.")

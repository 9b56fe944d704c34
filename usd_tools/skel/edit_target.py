"""Animations written into an open stage, where its edit target points."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from pxr import Sdf, Usd

from usd_tools.console.errors import ToolError
from usd_tools.skel.writer import AnimationLayer


class EditTargetLayer(AnimationLayer):
    """The layer of a stage's edit target, seen through its mapping of paths and times.

    Parameters
    ----------
    stage : Usd.Stage

    Raises
    ------
    ToolError
        If the layer may not be edited.
    """

    def __init__(self, stage: Usd.Stage) -> None:
        target = stage.GetEditTarget()
        layer = target.GetLayer()
        if not layer.permissionToEdit:
            raise ToolError(
                f"The edit target {layer.GetDisplayName()} may not be edited; choose another edit target, or unlock it."
            )
        mapping = target.GetMapFunction()
        if mapping.isIdentity and layer in stage.GetLayerStack():
            # An edit target made from a layer alone does not know the offset that the stage sees it through.
            mapping = stage.GetEditTargetForLocalLayer(layer).GetMapFunction()
        super().__init__(layer, mapping.timeOffset.GetInverse())
        self._stage, self._target = stage, target
        self._written: dict[Sdf.Path, Sdf.Path] = {}

    @property
    def name(self) -> str:
        """Name of the layer, without folders."""
        return self.layer.GetDisplayName()

    def spec_path(self, path: Sdf.Path) -> Sdf.Path:
        """Return where a prim of the stage is in the layer.

        Raises
        ------
        ToolError
            If the edit target cannot hold it.
        """
        mapped = self._target.MapToSpecPath(path)
        if mapped.isEmpty:
            raise ToolError(f"The edit target {self.name} cannot hold {path}; choose another edit target.")
        return mapped

    def can_hold(self, path: Sdf.Path) -> bool:
        """Return whether a prim of the stage can be in the layer."""
        return not self._target.MapToSpecPath(path).isEmpty

    def prim(self, path: Sdf.Path) -> Sdf.PrimSpec:
        """Return the spec of a prim of the stage, made where there is none."""
        self._written[path] = self.spec_path(path)
        return super().prim(path)

    @contextmanager
    def editing(self) -> Iterator[None]:
        """Leave the layer as it was if something is wrong within, or if what is written does not count on the stage.

        Raises
        ------
        ToolError
            If stronger opinions hide what is written.
        """
        before = Sdf.Layer.CreateAnonymous()
        before.TransferContent(self.layer)
        try:
            yield
            self._check_strength(before)
        except BaseException:
            self.layer.TransferContent(before)
            raise

    def _check_strength(self, before: Sdf.Layer) -> None:
        for path, spec_path in self._written.items():
            spec, prim = self.layer.GetPrimAtPath(spec_path), self._stage.GetPrimAtPath(path)
            for attribute in spec.attributes:
                if _is_same(attribute, before.GetAttributeAtPath(attribute.path)):
                    continue
                strongest = next(
                    (each for each in prim.GetAttribute(attribute.name).GetPropertyStack() if _has_value(each)), None
                )
                if _has_value(attribute) and strongest != attribute:
                    hidden_by = "the composition" if strongest is None else strongest.layer.GetDisplayName()
                    raise ToolError(
                        f"{path}: {attribute.name} in the edit target {self.name} would be hidden by {hidden_by}; "
                        "choose a stronger edit target."
                    )


def _is_same(attribute: Sdf.AttributeSpec, before: Sdf.AttributeSpec | None) -> bool:
    keys = ("default", "timeSamples")
    return before is not None and all(attribute.GetInfo(key) == before.GetInfo(key) for key in keys)


def _has_value(spec: Sdf.AttributeSpec) -> bool:
    return spec.HasDefaultValue() or bool(spec.layer.GetNumTimeSamplesForPath(spec.path))

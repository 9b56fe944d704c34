"""Write animations to a USD file: an override layer over the source, or one flattened file."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Ar, Sdf, Usd

from geomstats_anim import LearnedMetric, __version__
from usd_tools.console.errors import Messages
from usd_tools.files.atomic import Verify, written_beside
from usd_tools.files.openusd_errors import TEMPORARY
from usd_tools.files.openusd_gaps import flatten_stage, modify_asset_paths
from usd_tools.files.packages import pack, unpack
from usd_tools.files.paths import extension, relative_asset_path
from usd_tools.files.stages import export_layer, is_binary
from usd_tools.metrics.attributes import (
    NAMESPACE,
    SOURCE_CODES,
    hide_source_codes,
    write_metric,
    write_source_codes,
)
from usd_tools.metrics.strings import carriers, write_strings
from usd_tools.skel.channels import CHANNELS, Channel, write_samples
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.euler_angles import write_euler
from usd_tools.skel.find import AnimationSource
from usd_tools.skel.instancing import editable_paths, give_up_instances
from usd_tools.skel.packed import StoredStream, remove_packed, write_packed
from usd_tools.skel.replaced import home_of, replaced_samples
from usd_tools.skel.stored_contacts import StoredContacts, hide_contacts, write_contacts
from usd_tools.skel.unpacked import write_op

MADE_BY = "geomstats_anim"
"""Key of `customLayerData` that says what made a file."""

_NOT_COPIED = {
    "subLayers",
    "subLayerOffsets",
    "comment",
    "documentation",
    "primOrder",
    "layerRelocates",
    "customLayerData",
}
"""Fields that a layer says of itself, and not of the stage."""


def made_by(tool: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the entry of `customLayerData` that says what made a file: tool, version and settings, plain values."""
    return {MADE_BY: {"tool": tool, "version": __version__, "settings": dict(settings)}}


class AnimationLayer:
    """A layer that animations of a stage are written into.

    Parameters
    ----------
    layer : Sdf.Layer
    offset : Sdf.LayerOffset
        From the stage's time codes to the layer's.
    """

    def __init__(self, layer: Sdf.Layer, offset: Sdf.LayerOffset) -> None:
        self.layer, self.offset = layer, offset

    def spec_path(self, path: Sdf.Path) -> Sdf.Path:
        """Return where a prim of the stage is in the layer."""
        return path

    def can_hold(self, path: Sdf.Path) -> bool:
        """Return whether a prim of the stage can be in the layer."""
        return True

    def prim(self, path: Sdf.Path) -> Sdf.PrimSpec:
        """Return the spec of a prim of the stage, made where there is none."""
        return Sdf.CreatePrimInLayer(self.layer, self.spec_path(path))

    def write_animation(
        self,
        source: AnimationSource,
        channels: Mapping[str, Channel],
        defaults: Mapping[str, np.ndarray],
        metric: LearnedMetric | None,
        messages: Messages,
        source_codes: np.ndarray | None = None,
        source_cuts: np.ndarray | None = None,
        keeps_samples: bool = True,
        packed: StoredStream | None = None,
        euler: str | None = None,
        contacts: StoredContacts | None = None,
    ) -> None:
        """Write the samples of an animation, all of them: one sample here hides every sample below.

        Parameters
        ----------
        source : AnimationSource
        channels : mapping of str to Channel
            Sampled attributes.
        defaults : mapping of str to array-like, shape=[N, C]
            Attributes that get a default value only.
        metric : LearnedMetric
        messages : Messages
            Told of instances that have to be given up.
        source_codes : array-like, shape=[F]
            Of a sparse animation: where its source had samples.
            Optional, default: it is not sparse.
        source_cuts : array-like, shape=[C, 2]
            Likewise: time codes of the samples before and after each cut.
            Optional, default: there is none.
        keeps_samples : bool
            Whether the samples of `source` are among these; if not, what it stores of a source of its own is hidden.
            Optional, default: True.
        packed : StoredStream
            Motion of the sampled attributes, packed; packed motion of `source` goes where samples are written.
            Optional, default: none.
        euler : str
            Order of Euler angles that rotations are written as too, see `write_euler`.
            Optional, default: they are not.
        contacts : StoredContacts
            Of a sparse animation: what is planted in its source.
            Optional, default: nothing is said of that.
        """
        for path in editable_paths(self, source, messages):
            spec = self.prim(path)
            for name, values in defaults.items():
                kind, attribute = CHANNELS[name], _attribute(spec, name)
                attribute.ClearInfo("timeSamples")
                attribute.default = kind.to_usd(values.astype(kind.dtype))
            for name, channel in channels.items():
                write_samples(_attribute(spec, name), channel, self.offset)
            if packed is not None:
                write_packed(spec, *packed)
            elif channels:
                remove_packed(spec, source.prim)
            if packed is not None or channels:
                self._write_unpacked_xforms(source, path, messages)
            if euler is not None and "rotations" in channels:
                write_euler(spec, channels["rotations"], euler, self.offset)
            if metric is not None:
                axes = source.prim.GetAttribute(f"{NAMESPACE}:axes")
                write_metric(spec, metric, hide_axes=bool(axes) and axes.HasAuthoredValue())
            if source_codes is not None:
                write_source_codes(spec, source_codes, source_cuts)
                hide_contacts(spec, source.prim)
            elif not keeps_samples and source.prim.HasAttribute(SOURCE_CODES):
                hide_source_codes(spec)
            if contacts is not None:
                write_contacts(spec, contacts)
        if metric is not None:
            for skeleton in source.skeletons:
                for prim in carriers(skeleton)[:2]:
                    if not prim.IsInstanceProxy() and self.can_hold(prim.GetPath()):
                        write_strings(self.prim(prim.GetPath()), metric)

    def _write_unpacked_xforms(self, source: AnimationSource, path: Sdf.Path, messages: Messages) -> None:
        """Write the samples of transforms that were packed with an animation, where an instance of it has them."""
        for text, channel in source.xforms.items():
            relative = Sdf.Path(text).MakeRelativePath(source.prim.GetPath())
            attribute = source.stage.GetAttributeAtPath(relative.MakeAbsolutePath(path))
            if not attribute:
                attribute = source.stage.GetAttributeAtPath(text)
            prim = attribute.GetPrim()
            if prim.IsInstanceProxy():
                give_up_instances(self, prim, messages)
            write_op(self.prim(prim.GetPath()), attribute, channel, self.offset)

    def store_metric(self, clip: SkelClip, metric: LearnedMetric, messages: Messages) -> None:
        """Write the metric of an animation, and leave its samples where they are."""
        # An animation within an instance may have to move out of it, and must take its samples along.
        moved = clip.channels if clip.source.prim.IsInstanceProxy() else {}
        sampled = {name: channel for name, channel in moved.items() if len(channel.codes)}
        self.write_animation(clip.source, sampled, {}, metric, messages)

    def write_op(self, attribute: Usd.Attribute, channel: Channel) -> None:
        """Write the samples of a transform op of the stage, all of them."""
        write_op(self.prim(attribute.GetPrim().GetPath()), attribute, channel, self.offset)


class OverrideLayer(AnimationLayer):
    """A layer that changes animations of a stage and leaves everything else to it by composition.

    Parameters
    ----------
    stage : Usd.Stage
        The source.
    tool : str
        What makes the layer, for its `customLayerData`.
    settings : mapping
        Plain values, for its `customLayerData`.
    codes_per_second : float
        Plays the source at another number of time codes a second: USD stretches a sublayer whose rate differs.
        Optional, default: the source's own.
    base : Sdf.Layer
        Layer to be changed in place.
        Optional, default: a new layer, to be put over the source.
    """

    def __init__(
        self,
        stage: Usd.Stage,
        tool: str,
        settings: Mapping[str, Any],
        codes_per_second: float | None = None,
        base: Sdf.Layer | None = None,
    ) -> None:
        super().__init__(Sdf.Layer.CreateAnonymous(".usda"), Sdf.LayerOffset())
        root = stage.GetRootLayer()
        if base is not None:
            self.layer.TransferContent(base)
        else:
            # Stage metadata counts in the root layer only: what is not copied up is lost, the frame rate first.
            # A usdc has it in the order in which it is set, and OpenUSD lists it in that of addresses in memory.
            for key in sorted(root.pseudoRoot.ListInfoKeys()):
                if key not in _NOT_COPIED:
                    self.layer.pseudoRoot.SetInfo(key, root.pseudoRoot.GetInfo(key))
        if codes_per_second is not None:
            stretch = codes_per_second / stage.GetTimeCodesPerSecond()
            self.offset = Sdf.LayerOffset(0.0, stretch)
            self.layer.timeCodesPerSecond = self.layer.framesPerSecond = codes_per_second
            if root.HasStartTimeCode():
                self.layer.startTimeCode = root.startTimeCode * stretch
            if root.HasEndTimeCode():
                self.layer.endTimeCode = root.endTimeCode * stretch
        self.layer.customLayerData = {**root.customLayerData, **made_by(tool, settings)}
        self._is_copy = base is not None
        self._homes: dict[Sdf.Path, Sdf.Path] = {}
        self._replaced: list[Sdf.Path] = []

    def spec_path(self, path: Sdf.Path) -> Sdf.Path:
        """Return where a prim of the stage is in the layer."""
        return self._homes.get(path, path)

    def replace_samples(self, selected: Sequence[AnimationSource], everyone: Sequence[AnimationSource]) -> None:
        """Remove the samples of some animations from all that they inherit or reference, and write in their variants.

        Parameters
        ----------
        selected : sequence of AnimationSource
            Whose samples will be written, all of them.
        everyone : sequence of AnimationSource
            All of the stage; what any other uses stays.

        Raises
        ------
        ToolError
            If samples cannot be replaced without changing other variants.
        """
        for source in selected:
            if self._is_copy:
                self._homes[source.prim.GetPath()] = home_of(source)
            self._replaced += replaced_samples(source, selected, everyone)
        if self._is_copy:
            self.remove_replaced(self.layer)

    def remove_replaced(self, layer: Sdf.Layer) -> None:
        """Remove the samples that `replace_samples` found from a layer."""
        for path in self._replaced:
            attribute = layer.GetAttributeAtPath(path)
            if attribute:
                attribute.ClearInfo("timeSamples")


def _attribute(spec: Sdf.PrimSpec, name: str) -> Sdf.AttributeSpec:
    return spec.attributes.get(name) or Sdf.AttributeSpec(spec, name, CHANNELS[name].value_type)


def save(
    override: OverrideLayer,
    source: Path,
    out: Path,
    usd_format: str | None = None,
    flatten: bool = False,
    verify: Verify | None = None,
) -> None:
    """Write an override layer to a file, over its source or flattened with it.

    Parameters
    ----------
    override : OverrideLayer
    source : Path
        File that it goes over.
    out : Path
        Its extension says how: .usda is text, .usdc binary, .usdz a package of both layers.
    usd_format : str
        "usda" or "usdc" for a file that ends in .usd.
        Optional, default: "usdc".
    flatten : bool
        Whether to write one layer with everything in it.
        Optional, default: False.
    verify : callable
        See `written_beside`.
        Optional, default: none.

    Raises
    ------
    ToolError
        If it cannot be written.
    """
    with written_beside(out, verify) as beside:
        if extension(out) == ".usdz":
            _save_package(override, source, beside, flatten)
        else:
            layer = override.layer
            if flatten:
                layer = _flatten_override(override, source, out.parent, _context(source))
            else:
                layer.subLayerPaths = [relative_asset_path(source, out.parent)]
            export_layer(layer, beside, usd_format, check=flatten)


def save_in_place(override: OverrideLayer, source: Path, verify: Verify | None = None) -> None:
    """Write an override layer that was made from its source back to it, in the same format; see `save`.

    Raises
    ------
    ToolError
        If it cannot be written.
    """
    binary = is_binary(source)
    with written_beside(source, verify) as beside:
        usd_format = ("usdc" if binary else "usda") if extension(source) == ".usd" else None
        export_layer(override.layer, beside, usd_format, check=True)


def save_copy(
    override: OverrideLayer, source: Path, out: Path, usd_format: str | None = None, verify: Verify | None = None
) -> None:
    """Write an override layer that was made from its source to another file; see `save`.

    Raises
    ------
    ToolError
        If it cannot be written.
    """
    here, there = os.path.abspath(source.parent), os.path.abspath(out.parent)
    if here != there:

        def moved(path: str) -> str:
            """Name a file as seen from the other folder; what is found by a search path stays."""
            package, bracket, inner = path.partition("[")
            if os.path.isabs(package) or not (package.startswith(".") or os.path.exists(os.path.join(here, package))):
                return path
            return relative_asset_path(Path(here) / package, out.parent) + bracket + inner

        modify_asset_paths(override.layer, moved)
    with written_beside(out, verify) as beside:
        export_layer(override.layer, beside, usd_format, check=True)


def save_layer(layer: Sdf.Layer, out: Path, usd_format: str | None = None) -> None:
    """Write a layer that needs no other file; see `save`.

    Raises
    ------
    ToolError
        If it cannot be written.
    """
    with written_beside(out) as beside:
        if extension(out) == ".usdz":
            with tempfile.TemporaryDirectory(prefix=TEMPORARY) as folder:
                pack(layer, Path(folder) / f"{out.stem}.usdc", beside)
        else:
            export_layer(layer, beside, usd_format)


def _flatten_override(override: OverrideLayer, source: Path, folder: Path, context: Ar.ResolverContext) -> Sdf.Layer:
    """Flatten an override and its source into one layer, with the files that it needs named as seen from a folder."""
    over = override.layer
    over.subLayerPaths = [os.path.abspath(source)]
    layer = flatten_stage(Usd.Stage.Open(over, context))
    override.remove_replaced(layer)
    for key in sorted(over.pseudoRoot.ListInfoKeys()):
        if key not in _NOT_COPIED or key == "customLayerData":
            layer.pseudoRoot.SetInfo(key, over.pseudoRoot.GetInfo(key))
    modify_asset_paths(layer, lambda path: relative_asset_path(Path(path), folder) if os.path.isabs(path) else path)
    return layer


def _context(path: Path) -> Ar.ResolverContext:
    """Return the context in which OpenUSD opens a file: names without a dot may count from that file's folder."""
    return Ar.GetResolver().CreateDefaultContextForAsset(os.path.abspath(path))


def _save_package(override: OverrideLayer, source: Path, out: Path, flatten: bool) -> None:
    """Write a usdz package of an override layer, its source, and all files that they need."""
    with tempfile.TemporaryDirectory(prefix=TEMPORARY) as folder:
        context = _context(source)
        if extension(source) == ".usdz":
            # A package in a package is not valid usdz, so the source is packed anew; its names may count from its root.
            context = _context(Path(folder) / source.name)
            source = unpack(source, Path(folder))
        root = Path(folder) / f"{out.stem}.usdc"
        while root.exists():
            root = root.with_stem(f"{root.stem}_over")
        if flatten:
            layer = _flatten_override(override, source, root.parent, context)
        else:
            layer = override.layer
            layer.subLayerPaths = [os.path.abspath(source)]
        with Ar.ResolverContextBinder(context):
            pack(layer, root, out)

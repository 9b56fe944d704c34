"""Find the prims on which an opinion on an animation counts: inside an instance, none does."""

from __future__ import annotations

from typing import Protocol

from pxr import Sdf, Usd, UsdSkel

from usd_tools.console.errors import Messages
from usd_tools.skel.channels import CHANNELS
from usd_tools.skel.find import BINDING, AnimationSource


class Layer(Protocol):
    """A layer, seen from the stage; see `writer.AnimationLayer`."""

    layer: Sdf.Layer

    def spec_path(self, path: Sdf.Path) -> Sdf.Path:
        """Return where a prim of the stage is in the layer."""

    def prim(self, path: Sdf.Path) -> Sdf.PrimSpec:
        """Return the spec of a prim of the stage, made where there is none."""


def editable_paths(layer: Layer, source: AnimationSource, messages: Messages) -> list[Sdf.Path]:
    """Find or make the prims of a layer on which samples of an animation count.

    The prim itself, if it is in no instance. Otherwise the prim that the instances are made of, if the stage's own
    layers have it at the same times; a new SkelAnimation beside the instance, if the skeletons take their animation
    from outside; and as a last resort the prims inside, which then are no longer instances.

    Parameters
    ----------
    layer : Layer
        To be changed.
    source : AnimationSource
    messages : Messages
        Told of instances that have to be given up.

    Returns
    -------
    paths : list of Sdf.Path
    """
    if not source.prim.IsInstanceProxy():
        return [source.prim.GetPath()]
    own_layers = source.stage.GetLayerStack()
    stack = source.prim.GetPrimStackWithLayerOffsets()
    # Through a layer offset the samples would be at other times than those that are asked for.
    local = [spec.path for spec, offset in stack if spec.layer in own_layers and offset.IsIdentity()]
    if local:
        return [local[0].StripAllVariantSelections()]
    if source.skeletons and not any(_is_bound_inside(skeleton) for skeleton in source.skeletons):
        return [_moved_outside(layer, source)]
    for prim in source.prims:
        give_up_instances(layer, prim, messages)
    return [prim.GetPath() for prim in source.prims]


def give_up_instances(layer: Layer, prim: Usd.Prim, messages: Messages) -> None:
    """Have the instances that a prim is in be instances no longer, so that opinions on it count."""
    for path in prim.GetPath().GetPrefixes():
        if prim.GetStage().GetPrimAtPath(path).IsInstance():
            layer.prim(path).SetInfo("instanceable", False)
            messages.warn(f"{path} is no longer an instance, so that its animation can be changed.")


def _instance_root(prim: Usd.Prim) -> Usd.Prim:
    """Return the outermost instance that a prim is in."""
    ancestors = (prim.GetStage().GetPrimAtPath(path) for path in prim.GetPath().GetPrefixes())
    return next(ancestor for ancestor in ancestors if ancestor.IsInstance())


def _is_bound_inside(skeleton: Usd.Prim) -> bool:
    """Return whether the binding of a skeleton is authored where it cannot be changed."""
    if not skeleton.IsInstanceProxy():
        return False
    root, prim = _instance_root(skeleton), skeleton
    while prim != root:
        if prim.GetRelationship(BINDING).HasAuthoredTargets():
            return True
        prim = prim.GetParent()
    return False


def _moved_outside(layer: Layer, source: AnimationSource) -> Sdf.Path:
    """Copy what an animation has besides samples to a new prim, and bind the instances to it."""
    root = _instance_root(source.prim)
    name = f"{root.GetName()}_{source.prim.GetName()}"
    path = root.GetPath().GetParentPath().AppendChild(name)
    while source.stage.GetPrimAtPath(path) or layer.layer.GetPrimAtPath(layer.spec_path(path)):
        path = path.ReplaceName(f"{path.name}_")
    spec = layer.prim(path)
    spec.specifier, spec.typeName = Sdf.SpecifierDef, "SkelAnimation"
    for attribute in source.prim.GetAuthoredAttributes():
        value = attribute.Get()
        if value is not None and (attribute.GetName() in CHANNELS or attribute.GetNumTimeSamples() == 0):
            copy = Sdf.AttributeSpec(spec, attribute.GetName(), attribute.GetTypeName(), attribute.GetVariability())
            copy.custom, copy.default = attribute.IsCustom(), value
    for skeleton in source.skeletons:
        bound = _instance_root(skeleton) if skeleton.IsInstanceProxy() else skeleton
        over = layer.prim(bound.GetPath())
        if BINDING not in over.relationships:
            Sdf.RelationshipSpec(over, BINDING, custom=False)
        over.relationships[BINDING].targetPathList.explicitItems = [layer.spec_path(path).StripAllVariantSelections()]
        if not bound.HasAPI(UsdSkel.BindingAPI):
            over.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=["SkelBindingAPI"]))
    return path

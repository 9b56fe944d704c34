"""Find the animations of a stage, those that a command works on, and the variants that they come from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pxr import Sdf, Usd, UsdSkel

from usd_tools.console.errors import ToolError
from usd_tools.skel.channels import Channel

BINDING = "skel:animationSource"
"""Relationship of a skeleton, or of an ancestor, to the animation that drives it."""


@dataclass(frozen=True)
class AnimationSource:
    """A SkelAnimation on a stage, treated once however many skeletons or instances use it.

    Parameters
    ----------
    stage : Usd.Stage
        Kept alive, for prims die with their stage.
    prims : tuple of Usd.Prim
        The prim; inside instances, its proxy in each of them.
    skeletons : tuple of Usd.Prim
        The skeletons that it drives; none for an animation of a library.
    ignored : tuple of Usd.Prim
        Skeletons whose `skel:animationSource` names it, but does not count: SkelBindingAPI is not applied.
    xforms : mapping of str to Channel
        Transform ops whose samples are packed with it, unpacked, by the paths of their attributes.
    """

    stage: Usd.Stage
    prims: tuple[Usd.Prim, ...]
    skeletons: tuple[Usd.Prim, ...]
    ignored: tuple[Usd.Prim, ...] = ()
    xforms: Mapping[str, Channel] = field(default_factory=dict, compare=False)

    @property
    def prim(self) -> Usd.Prim:
        """The prim to read."""
        return self.prims[0]

    @property
    def rig(self) -> tuple[Usd.Prim, ...]:
        """The skeletons to measure on: those that it drives, else those that name it."""
        return self.skeletons or self.ignored

    @property
    def path(self) -> str:
        """Path of the prim to read."""
        return str(self.prim.GetPath())


def find_animations(stage: Usd.Stage) -> list[AnimationSource]:
    """Find every SkelAnimation: those that skeletons are bound to, and those of libraries.

    Parameters
    ----------
    stage : Usd.Stage

    Returns
    -------
    sources : list of AnimationSource
        In the order of the stage.
    """
    prims: dict[Sdf.Path, list[Usd.Prim]] = {}
    skeletons: dict[Sdf.Path, list[Usd.Prim]] = {}
    ignored: dict[Sdf.Path, list[Usd.Prim]] = {}
    cache = UsdSkel.Cache()
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdSkel.Animation):
            prims.setdefault(_shared_path(prim), []).append(prim)
        elif prim.IsA(UsdSkel.Skeleton):
            query = cache.GetSkelQuery(UsdSkel.Skeleton(prim)).GetAnimQuery()
            if query:
                skeletons.setdefault(_shared_path(query.GetPrim()), []).append(prim)
            elif named := _named_animation(prim):
                ignored.setdefault(_shared_path(named), []).append(prim)
    for path in skeletons:
        prims.setdefault(path, [stage.GetPrimAtPath(path)])
    return [
        AnimationSource(stage, tuple(found), tuple(skeletons.get(path, ())), tuple(ignored.get(path, ())))
        for path, found in prims.items()
    ]


def find_binding(skeleton: Usd.Prim) -> Usd.Prim | None:
    """Return the prim, a skeleton or its nearest ancestor, that names an animation; None if none does."""
    prim = skeleton
    while prim and not prim.IsPseudoRoot():
        if prim.GetRelationship(BINDING).HasAuthoredTargets():
            return prim
        prim = prim.GetParent()
    return None


def _named_animation(skeleton: Usd.Prim) -> Usd.Prim | None:
    """Return the animation that a skeleton names in a binding that OpenUSD ignores."""
    binding = find_binding(skeleton)
    targets = binding.GetRelationship(BINDING).GetForwardedTargets() if binding else []
    prim = skeleton.GetStage().GetPrimAtPath(targets[0]) if targets else None
    return prim if prim and prim.IsA(UsdSkel.Animation) else None


def _shared_path(prim: Usd.Prim) -> Sdf.Path:
    """Return the path that is the same for all instances of a prim."""
    return (prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim).GetPath()


def select_animations(path: Path, sources: list[AnimationSource], wanted: Sequence[str]) -> list[AnimationSource]:
    """Keep the animations that `--prim` asks for.

    Parameters
    ----------
    path : Path
        File that they are in.
    sources : list of AnimationSource
    wanted : sequence of str
        Paths of prims; none for all.

    Returns
    -------
    sources : list of AnimationSource
        At least one, in the same order.

    Raises
    ------
    ToolError
        If there is no such prim, or no animation there.
    """
    if not sources:
        raise ToolError(f"{path} has no skeletal animation.")
    if not wanted:
        return sources
    stage = sources[0].stage
    chosen = []
    for text in wanted:
        prefix = Sdf.Path(text) if Sdf.Path.IsValidPathString(text) else Sdf.Path()
        if not prefix.IsAbsolutePath() or not stage.GetPrimAtPath(prefix):
            raise ToolError(f"--prim {text}: there is no such prim in {path}; usd_tools.inspect lists the animations.")
        below = [
            source
            for source in sources
            if any(prim.GetPath().HasPrefix(prefix) for prim in (*source.prims, *source.skeletons, *source.ignored))
        ]
        if not below:
            raise ToolError(f"--prim {text} has no skeletal animation in {path}; usd_tools.inspect lists them.")
        chosen += below
    return [source for source in sources if source in chosen]


def chosen_variants(prim: Usd.Prim) -> list[str]:
    """Name the variants that a prim's opinions come from.

    Parameters
    ----------
    prim : Usd.Prim

    Returns
    -------
    variants : list of str
        Such as "{take=run} of /Char", without repetition.
    """
    in_prototype = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
    found: dict[str, None] = {}
    for arc in Usd.PrimCompositionQuery(in_prototype).GetCompositionArcs():
        node = arc.GetTargetNode()
        if not arc.HasSpecs():
            continue
        while node:  # a reference may be what the variant chooses
            path = node.path
            while path.ContainsPrimVariantSelection():
                if path.IsPrimVariantSelectionPath():
                    name, value = path.GetVariantSelection()
                    found[f"{{{name}={value}}} of {path.GetPrimPath()}"] = None
                path = path.GetParentPath()
            node = node.parent
    return list(found)

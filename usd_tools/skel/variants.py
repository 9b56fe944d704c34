"""Variants that an animation's samples come from: what is written over a stage goes over all of them."""

from __future__ import annotations

from pxr import Usd


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

"""Write the turns of joints as Euler angles too, for programs that cannot read quaternions."""

from __future__ import annotations

import numpy as np
from pxr import Sdf, Vt

from geomstats_anim.euler import to_euler
from geomstats_anim.rotations import normalize
from usd_tools.skel.channels import Channel, write_values

ANGLES = "geomstatsAnim:eulerAngles"
"""Custom float3[] of a SkelAnimation: of each joint the angles about x, y and z, degrees."""

ORDER = "geomstatsAnim:eulerOrder"
"""Custom token beside it: the order, as in the transform op of the same name; XYZ turns about x first."""


def write_euler(spec: Sdf.PrimSpec, rotations: Channel, order: str, offset: Sdf.LayerOffset) -> None:
    """Write rotations as angles that do not jump, at the same time codes.

    Parameters
    ----------
    spec : Sdf.PrimSpec
        Of the SkelAnimation.
    rotations : Channel
    order : str
        Such as "XYZ".
    offset : Sdf.LayerOffset
        From the stage's time codes to the layer's.
    """
    degrees: np.ndarray = np.zeros((*rotations.values.shape[:2], 3), dtype=np.float32)
    live = ~rotations.blocked
    turned = to_euler(normalize(rotations.values[live].astype(np.float64)), order[::-1])
    degrees[live] = np.degrees(turned)[..., [order[::-1].index(axis) for axis in "XYZ"]]
    angles = _attribute(spec, ANGLES, Sdf.ValueTypeNames.Float3Array)
    write_values(angles, rotations, [Vt.Vec3fArray.FromNumpy(values) for values in degrees], offset)
    _attribute(spec, ORDER, Sdf.ValueTypeNames.Token).default = order


def _attribute(spec: Sdf.PrimSpec, name: str, value_type: Sdf.ValueTypeName) -> Sdf.AttributeSpec:
    attribute = spec.attributes.get(name) or Sdf.AttributeSpec(spec, name, value_type)
    attribute.custom = True
    return attribute

"""Files of the walker, whose feet are known to be planted."""

import numpy as np
from walker import JOINTS, walk

from geomstats_anim import rotations as quat
from usd_tools.skel.new_file import ANIMATION, Character, Units, new_stage

UPRIGHT = quat.exp(np.array([0.5 * np.pi, 0.0, 0.0]))
"""From y to z."""

RATE = 60.0


def write_walk(path, step=8, up="Y", metres=1.0, seconds=2.4, stride=0.7):
    """Write every so many frames of a walk; its time codes are those of 60 per second."""
    animation, _ = walk(seconds, stride=stride)
    rotations, translations = np.array(animation.rotations), animation.translations / metres
    rest = animation.skeleton
    if up == "Z":
        rotations[:, 0] = quat.multiply(UPRIGHT, rotations[:, 0])
        translations[:, 0] = quat.rotate(UPRIGHT, translations[:, 0])
    skeleton = type(rest)(rest.joints, rest.parents, rest.rest_translations / metres, rest.rest_rotations)
    stage = new_stage(Character(skeleton, JOINTS, rotations, translations, Units(metres, up, RATE)))
    for name in ("rotations", "translations"):
        attribute = stage.GetAttributeAtPath(ANIMATION.AppendProperty(name))
        for code in attribute.GetTimeSamples():
            if code % step:
                attribute.ClearAtTime(code)
    stage.Export(str(path))
    return animation

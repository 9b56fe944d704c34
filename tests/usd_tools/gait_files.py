"""Gaits as UsdSkel files."""

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdSkel, Vt


def write(path, clip, up=UsdGeom.Tokens.y, step=1):
    """Write a gait as a UsdSkel file, of which some samples are kept."""
    stage, skeleton = Usd.Stage.CreateNew(str(path)), clip.skeleton
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(30)
    UsdSkel.Root.Define(stage, "/Rig")
    rig, motion = UsdSkel.Skeleton.Define(stage, "/Rig/Skel"), UsdSkel.Animation.Define(stage, "/Rig/Anim")
    rest = Vt.Matrix4dArray([Gf.Matrix4d().SetTranslate(Gf.Vec3d(*bone)) for bone in skeleton.rest_translations])
    rig.CreateJointsAttr(skeleton.joints)
    rig.CreateRestTransformsAttr(rest)
    rig.CreateBindTransformsAttr(rest)
    motion.CreateJointsAttr(skeleton.joints)
    motion.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1, 1, 1)] * clip.n_joints))
    for code in range(0, clip.n_frames, step):
        motion.CreateRotationsAttr().Set(Vt.QuatfArray.FromNumpy(clip.rotations[code].astype(np.float32)), code)
        motion.CreateTranslationsAttr().Set(Vt.Vec3fArray.FromNumpy(clip.translations[code].astype(np.float32)), code)
    UsdSkel.BindingAPI.Apply(rig.GetPrim()).CreateAnimationSourceRel().SetTargets(["/Rig/Anim"])
    stage.Save()
    return path

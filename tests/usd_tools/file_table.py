"""What comes of every real file: what moves, what is passed through, what is refused, and with which sentence."""

from dataclasses import dataclass, field, replace

LETTERS = {"R": "rotations", "T": "translations", "S": "scales", "W": "blendShapeWeights"}


NOTHING = "{} has no skeletal animation."
NO_CHOICE = "{} has no skeletal animation with at least two samples."


@dataclass(frozen=True)
class Row:
    """One file.

    Animations by their prims: a letter for every channel that has a value, and its number of samples if there are any.
    Two samples or more are animated; one sample, or a value without, is passed through like the rest of the file.
    Where only weights of blend shapes move, downsample keeps the number of samples that is written as kept.

    A verb has the sentence with which it refuses the file, None if it does not; {} is the path of the file. What it
    needs, but is not there, is nowhere. Transforms are those that upsample gives samples, as they move the character.
    """

    animations: dict[str, str] = field(default_factory=dict)
    upsample: str | None = None
    learn: str | None = None
    compare: str | None = None
    downsample: str | None = None
    warnings: tuple[str, ...] = ()
    nowhere: tuple[str, ...] = ()
    transforms: tuple[str, ...] = ()
    kept: int | None = None

    @property
    def samples(self):
        """Time codes of each animation that moves."""
        counts = ([int(word[1:] or 0) for word in text.split()] for text in self.animations.values())
        return [max(each) for each in counts if max(each, default=0) > 1]


def tiny(skeleton, metres):
    """Warnings of a skeleton whose unit is doubtful."""
    return (f"{skeleton} is {metres} metres large; check metersPerUnit of the stage, and scales.",)


def refused(animations, upsample, learn, warnings=()):
    """A row of which no verb makes anything; what learn says, compare says too."""
    return Row(animations, upsample, learn, learn, NO_CHOICE if animations else NOTHING, warnings)


def too_short(animations, learn, warnings=()):
    """A row that can be upsampled, but has too little to learn from."""
    return Row(animations, None, learn, learn, None, warnings)


def only_weights(animations, learn, kept):
    """A row with blend shapes only, which are not learned from."""
    return Row(animations, None, learn, learn, kept=kept)


def still(counts):
    return "{} has no skeletal animation with at least two samples: " + counts + "."


def few(prim, count):
    return f"{{}}: {prim} has {count} samples, too few to learn from; at least 4 are needed."


def unsampled(prim):
    return f"{{}}: {prim} has no animated rotations, so there is nothing to learn."


def unbound(skeleton, animation):
    return (f"{skeleton} has skel:animationSource {animation}, but SkelBindingAPI is not applied, so USD ignores it.",)


def wide(prim, joint, degrees, *spans):
    beyond = "a file cannot store which way a turn beyond 180 degrees went."
    return tuple(f"{prim}: joint {joint} turns {degrees} degrees from time code {span}; {beyond}" for span in spans)


NONE_OF_THEM = "{} has no animation to learn from."
ONE_SEGMENT = "--rate 0.3 keeps 2 of the 5 samples of {name}, which is one segment; use at least 0.6."
ELEPHANT = {"Elefant/_anim": "R3023 T3023 S", "Elefant_Monochord_Play/_anim": "R3023 T S"}
LACKS_OF_ELEPHANT = ("Elefant.mp3", "Elefant_Diff.packed.png", "Monochord_diff.png")
BENDS = ("/Root/Skeleton/Animation", "joint2", "174.9", "60 to 90", "90 to 120")
THUMB = "RThumb"
NO_BIND_POSE = tuple(
    f"/World/Rig/Skel -- size of '{name}' attr [0] does not match the number of joints in the 'joints' attr [2]."
    for name in ("bindTransforms", "restTransforms")
)

TABLE = {
    "clips/jumping.usda": Row(
        {"/root/animateddrawings_jumping/animateddrawings_jumping/animateddrawings_jumping": "R164 T164 S"}
    ),
    "clips/pitching.usda": Row({"/root/_124_01/_124_01/_124_01": "R160 T160 S"}),
    "clips/punching.usda": Row({"/root/Rig_Medium/Rig_Medium/Rig_Medium_Melee_Unarmed_Attack_Punch_A": "R36 T36 S"}),
    "clips/rolling.usda": Row(
        {"/root/_90_02/_90_02/_90_02": "R195 T195 S"},
        warnings=wide("/root/_90_02/_90_02/_90_02", THUMB, "178.4", "111 to 112")
        + wide("/root/_90_02/_90_02/_90_02", THUMB, "176.5", "121 to 122"),
    ),
    "clips/sitting.usda": Row({"/root/Rig_Medium/Rig_Medium/Rig_Medium_Sit_Floor_StandUp": "R35 T35 S"}),
    "usd/bresilla_skel.usda": refused(
        {"/World/Rig/Anim": ""},
        still("/World/Rig/Anim has 0"),
        unsampled("/World/Rig/Anim"),
        (*unbound("/World/Rig", "/World/Rig/Anim"), *NO_BIND_POSE),
    ),
    "usd/bresilla_skel_test_simple.usda": too_short(
        {"/Test/Skel/Anim": "R3 T S"}, few("/Test/Skel/Anim", 3), unbound("/Test/Skel", "/Test/Skel/Anim")
    ),
    "usd/mayausd_HIK_Export.usda": Row({"/Fight_Dummy_Fight/Fight_Hips/Animation": "R101 T101 S"}),
    "usd/mayausd_framerate.usda": too_short(
        {"/Root/joint1/Animation": "R2 T S", "/Root/joint4/Animation": "R T2 S", "/Root/joint5/Animation": "R T2 S"},
        NONE_OF_THEM,
    ),
    "usd/mayausd_materialAssignment.usda": refused(
        {"/SkelAnimation1": ""}, still("/SkelAnimation1 has 0"), unsampled("/SkelAnimation1")
    ),
    "usd/mayausd_morpher_box.usd": refused(
        {"/root/Bones/Animations": ""},
        still("/root/Bones/Animations has 0"),
        unsampled("/root/Bones/Animations"),
        (
            "/root/Bones/Animations: blendShapeWeights at time code 5 has 2 values for 1 blendShapes; "
            "the weights are left as they are.",
        ),
    ),
    "usd/mayausd_skelCube.usda": Row({"/Root/Animation": "R30 T30 S30"}),
    "usd/mayausd_skelCubeDq.usda": refused(
        {"/Root/Animation": ""}, still("/Root/Animation has 0"), unsampled("/Root/Animation")
    ),
    "usd/mayausd_skelStaticTimeSampledMesh.usda": refused(
        {"/group1/joint1/Animation": "R T S"},
        still("/group1/joint1/Animation has 0"),
        unsampled("/group1/joint1/Animation"),
    ),
    "usd/mayausd_skinCluster.usda": Row({"/group1/joint1/Animation": "R101 T S"}),
    "usd/needle_CesiumMan.glb.openusd.usdz": Row(
        {"/CesiumMan/Z_UP/Armature/Armature_SkelRoot/Armature/SkelAnim": "R48 T48 S48"},
        nowhere=("Cesium_Man-effect_diffuse.jpg",),
    ),
    "usd/openusd_bake_blendshapes.usda": only_weights(
        {"/TestPlane/Skel/Anim": "W131"}, unsampled("/TestPlane/Skel/Anim"), 18
    ),
    "usd/openusd_bake_blendshapesWithNormals.usda": only_weights(
        {"/TestPlane/Skel/Anim": "W9"}, unsampled("/TestPlane/Skel/Anim"), 8
    ),
    "usd/openusd_bake_dqs.usda": Row({"/Root/Skeleton/Animation": "R30 T30 S30"}),
    "usd/openusd_bake_lbs.usda": Row({"/Root/Skeleton/Animation": "R30 T30 S30"}),
    "usd/openusd_cache_populate.usda": refused(
        {"/Anim1": "", "/Anim2": "", "/InstancedModelAnimBindings/Anim": "", "/AnimBinding/Instance/Anim": ""},
        still("/Anim1 has 0, /Anim2 has 0, /InstancedModelAnimBindings/Anim has 0, /AnimBinding/Instance/Anim has 0"),
        NONE_OF_THEM,
        (
            "/AnimBinding/BoundToInactiveAnim has skel:animationSource /InactiveAnim, but its target is not an "
            "animation on this stage.",
        ),
    ),
    "usd/openusd_imaging_arm.usda": too_short({"/Model/Skel/Anim1": "R2 T S"}, few("/Model/Skel/Anim1", 2)),
    "usd/openusd_imaging_blendshapes.usda": only_weights(
        {"/TestPlane/Skel/Anim": "W3"}, unsampled("/TestPlane/Skel/Anim"), 3
    ),
    "usd/openusd_imaging_dqs.usda": Row(
        {"/Root/Skeleton/Animation": "R5 T2 S"}, learn=ONE_SEGMENT, warnings=wide(*BENDS)
    ),
    "usd/openusd_imaging_lbs.usda": Row(
        {"/Root/Skeleton/Animation": "R5 T2 S"}, learn=ONE_SEGMENT, warnings=wide(*BENDS)
    ),
    "usd/openusd_imaging_skeleton.usda": replace(
        too_short({"/SkelChar/SkelAnim": "R3 T3 S"}, few("/SkelChar/SkelAnim", 3)),
        transforms=("/SkelChar.xformOp:transform",),
    ),
    "usd/openusd_imaging_twoBends.usda": refused(
        {"/Root/joint1/Animation": "R T S"}, still("/Root/joint1/Animation has 0"), unsampled("/Root/joint1/Animation")
    ),
    "usd/openusd_jointInfluences.usda": refused(
        {"/Anim1": "", "/Anim2": ""}, still("/Anim1 has 0, /Anim2 has 0"), NONE_OF_THEM
    ),
    "usd/openusd_root.usda": Row({"/Root/Skeleton/Animation": "R30 T30 S30"}),
    "usd/openusd_skinnedArm.usda": too_short({"/Model/Skel/Anim": "R2 T S"}, few("/Model/Skel/Anim", 2)),
    "usd/openusd_usdview_arm.usda": too_short({"/Model/Skel/Anim1": "R2 T S"}, few("/Model/Skel/Anim1", 2)),
    "usd/openusddotnet_native-usdskel-authored.usda": refused(
        {"/World/Character/Animation": "R1 T1 S"},
        still("/World/Character/Animation has 1"),
        unsampled("/World/Character/Animation"),
        tiny("/World/Character/Skeleton", 0.01),
    ),
    "usd/openusddotnet_parity-skinned-pennant.usda": too_short(
        {"/World/Rig/Animation": "R2 T2 S2"}, few("/World/Rig/Animation", 2), tiny("/World/Rig/Skeleton", 0.0018)
    ),
    "usd/tinyusdz_FAIL_usdskel-002.usda": refused({}, NOTHING, NOTHING),
    "usd/tinyusdz_blendshape-and-animation-test-001.usda": only_weights(
        {"/root/Cube/Skel/Anim": "W250"}, unsampled("/root/Cube/Skel/Anim"), 11
    ),
    "usd/tinyusdz_blendshape.usda": refused(
        {"/root/Cube/Skel/Anim": "W"},
        still("/root/Cube/Skel/Anim has 0"),
        unsampled("/root/Cube/Skel/Anim"),
        unbound("/root/Cube/Skel", "/root/Cube/Skel/Anim"),
    ),
    "usd/tinyusdz_simple-blendshape-test-001.usda": refused({}, NOTHING, NOTHING),
    "usd/tinyusdz_skeleton-purpose-001.usda": refused({}, NOTHING, NOTHING),
    "usd/tinyusdz_usdskel-001.usda": too_short(
        {"/Model/Skel/Anim": "R2 T S"}, few("/Model/Skel/Anim", 2), unbound("/Model/Skel", "/Model/Skel/Anim")
    ),
    "usd/tinyusdz_usdskel-001.usdc": too_short(
        {"/Model/Skel/Anim": "R2 T S"}, few("/Model/Skel/Anim", 2), unbound("/Model/Skel", "/Model/Skel/Anim")
    ),
    "usd/usdwg_CesiumMan.usdz": Row({"/CesiumMan/Animations/skelAnim_0": "R48 T48 S48"}),
    "usd/usdwg_ElephantWithMonochord/SoC-ElephantWithMonochord.usdc": Row(
        {f"/SoC_ElephantWithMonochord/Object/{prim}": channels for prim, channels in ELEPHANT.items()},
        warnings=(
            *tiny("/SoC_ElephantWithMonochord/Object/Elefant/_skel", 0.00113),
            *tiny("/SoC_ElephantWithMonochord/Object/Elefant_Monochord_Play/_skel", 0.000337),
        ),
        nowhere=LACKS_OF_ELEPHANT,
    ),
    "usd/usdwg_ElephantWithMonochord/SoC-ElephantWithMonochord_thumbnail.usda": Row(
        {f"/Elephant/Object/{prim}": channels for prim, channels in ELEPHANT.items()},
        nowhere=LACKS_OF_ELEPHANT,
    ),
    "usd/usdwg_RiggedFigure.usdz": too_short(
        {"/RiggedFigure/Animations/skelAnim_0": "R2 T2 S2"}, few("/RiggedFigure/Animations/skelAnim_0", 2)
    ),
    "usd/usdwg_RiggedSimple.usdz": Row({"/RiggedSimple/Animations/skelAnim_0": "R50 T50 S50"}),
    "usd/usdzstudio_skel.usda": too_short(
        {"/Character/Anim": "R2 T2 S2"}, few("/Character/Anim", 2), tiny("/Character/Skel", 0.01)
    ),
    "usd/usdzstudio_skel.usdz": too_short(
        {"/Character/Anim": "R2 T2 S2"}, few("/Character/Anim", 2), tiny("/Character/Skel", 0.01)
    ),
}

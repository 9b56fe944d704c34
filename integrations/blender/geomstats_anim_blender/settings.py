"""Settings of an armature, and the style of a pose bone as sliders."""

import math

import bpy

from . import live, style


def _bent(self, context):
    """Do what follows a change of the settings."""
    style.store(self.id_data)
    live.touch(self.id_data)


_SCHEMES = [
    ("constant", "Constant", "Hold every key"),
    ("linear", "Linear", "Quaternion components on straight lines, as most editors do"),
    ("slerp", "Slerp", "The shortest turn at a steady rate"),
    ("squad", "Squad", "Spherical quadrangles: smooth at the keys"),
    ("rotation-spline", "Rotation Spline", "Continuous angular acceleration"),
    ("geodesic", "Geodesic", "Shortest curves of each bone's metric"),
    ("geodesic-spline", "Geodesic Spline", "These, bent to be smooth at the keys as far as the tension says"),
    ("learned", "Learned from a Library", "The spline, and what a library of clips of this rig predicts"),
]


def _set_scheme(self, number):
    self.chosen_scheme = style.SCHEMES[number]
    _bent(self, None)


class Settings(bpy.types.PropertyGroup):
    """Settings of an armature, and which working copy it has."""

    scheme: bpy.props.EnumProperty(
        name="Scheme",
        description="Curve through the keys; at first that of the metric that a file has brought",
        items=_SCHEMES,
        get=lambda self: style.SCHEMES.index(style.scheme_of(self.id_data)),
        set=_set_scheme,
    )
    chosen_scheme: bpy.props.StringProperty()
    library: bpy.props.StringProperty(
        name="Library",
        description="File that geomstats-anim learn --library has written",
        subtype="FILE_PATH",
        update=_bent,
    )
    scope: bpy.props.EnumProperty(
        name="Between",
        items=[
            ("RANGE", "Frame Range", "All keys; frames of the scene's range"),
            ("SELECTED", "Selected Keys", "The keys that are selected in the dope sheet; others between are replaced"),
        ],
    )
    only_selected_bones: bpy.props.BoolProperty(name="Only Selected Bones")
    live: bpy.props.BoolProperty(
        name="Live",
        description="Fill again whenever keys or sliders change",
        update=lambda self, context: live.touch(self.id_data),
    )
    keep: bpy.props.EnumProperty(
        name="Keep",
        items=[
            ("EVERY", "Every n-th Frame", "Rebuild the frames between these"),
            ("SELECTED", "Selected Keys", "Rebuild the frames between the keys that are selected in the dope sheet"),
        ],
    )
    every: bpy.props.IntProperty(name="Every", default=10, min=2, soft_max=60)
    purpose: bpy.props.EnumProperty(
        name="Purpose",
        items=[
            ("RECONSTRUCT", "Reconstruct", "Fit this motion as well as possible"),
            ("PREDICT", "Predict", "Keep what carries over to other motion"),
        ],
    )
    family: bpy.props.EnumProperty(
        name="Metrics",
        items=[("DIAGONAL", "Along the Axes", "Alpha and beta"), ("SPD", "Any", "Turned axes too")],
    )
    source: bpy.props.PointerProperty(name="Original", type=bpy.types.Action)
    source_slot: bpy.props.StringProperty()
    result: bpy.props.PointerProperty(name="In-betweens", type=bpy.types.Action)


def _number(name, **options):
    """Return a slider of a bone's setting, which sets all selected bones."""

    def get(bone):
        return style.value(bone, name)

    def set(bone, new):
        style.edit(bone, name, new)
        live.touch(bone.id_data)

    return bpy.props.FloatProperty(name=name.replace("_", " ").title(), get=get, set=set, **options)


def _set_side(bone, new):
    style.edit(bone, "side", style.SIDES[new])
    live.touch(bone.id_data)


def _set_axes(bone, new):
    style.edit(bone, "axes", new)
    live.touch(bone.id_data)


_MOMENT = {"min": 1e-2, "max": 1e2, "soft_min": 0.1, "soft_max": 10.0, "step": 1, "precision": 3}
_TENSION = {"min": 0.0, "max": 2.0, "step": 1, "precision": 3}


def _sliders():
    return {
        "geodesic_slider_alpha": _number("alpha", description="Second principal moment; the first is 1", **_MOMENT),
        "geodesic_slider_beta": _number("beta", description="Third principal moment; the first is 1", **_MOMENT),
        "geodesic_slider_tension": _number(
            "tension", description="0 as geodesic, 1 continuous velocity, 2 continuous acceleration", **_TENSION
        ),
        "geodesic_slider_translation_tension": _number(
            "translation_tension", description="The same for the location", **_TENSION
        ),
        "geodesic_slider_side": bpy.props.EnumProperty(
            name="Side",
            description="Whether the metric turns with the bone, or with its parent",
            items=[("left", "Left", "The axes are the bone's"), ("right", "Right", "The axes are the parent's")],
            get=lambda bone: style.SIDES.index(style.value(bone, "side")),
            set=_set_side,
        ),
        "geodesic_slider_axes": bpy.props.FloatVectorProperty(
            name="Axes",
            description="Rotation vector of the principal axes",
            subtype="EULER",
            soft_min=-math.pi,
            soft_max=math.pi,
            get=lambda bone: style.value(bone, "axes"),
            set=_set_axes,
        ),
    }


def register():
    """Register the settings and the sliders."""
    bpy.utils.register_class(Settings)
    bpy.types.Object.geodesic = bpy.props.PointerProperty(type=Settings)
    for name, slider in _sliders().items():
        setattr(bpy.types.PoseBone, name, slider)


def unregister():
    """Unregister the settings and the sliders."""
    for name in _sliders():
        delattr(bpy.types.PoseBone, name)
    del bpy.types.Object.geodesic
    bpy.utils.unregister_class(Settings)

"""The panel in the sidebar of the 3D view."""

import bpy

from . import live, style
from .operators import armature_of


class _Panel:
    """Base of the panels."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Geodesic"

    @classmethod
    def poll(cls, context):
        """Show it for armatures."""
        return armature_of(context) is not None


class InBetweensPanel(_Panel, bpy.types.Panel):
    """Scheme, what to fill, and the buttons."""

    bl_idname = "GEODESIC_PT_in_betweens"
    bl_label = "Geodesic In-betweens"

    def draw(self, context):
        """Draw the panel."""
        layout, armature = self.layout, armature_of(context)
        settings = armature.geodesic
        layout.use_property_split = True
        layout.prop(settings, "scheme")
        if settings.scheme == style.LEARNED:
            layout.prop(settings, "library")
        layout.prop(settings, "scope")
        layout.prop(settings, "only_selected_bones")
        row = layout.row(align=True)
        row.operator("geodesic.in_betweens")
        row.operator("geodesic.remove", text="", icon="X")
        row = layout.row()
        row.enabled = settings.result is not None
        row.prop(settings, "live")
        if armature.name in live.last_error:
            layout.label(text=live.last_error[armature.name], icon="ERROR")


class StylePanel(_Panel, bpy.types.Panel):
    """Metric and tension of the selected bones."""

    bl_idname = "GEODESIC_PT_style"
    bl_parent_id = "GEODESIC_PT_in_betweens"
    bl_label = "Style of Bones"

    def draw(self, context):
        """Draw the panel."""
        layout, bone = self.layout, context.active_pose_bone
        layout.use_property_split = True
        if bone is None:
            layout.label(text="Select bones in pose mode")
            return
        layout.label(text=f"{bone.name}, {len(style.selected(bone))} selected", icon="BONE_DATA")
        column = layout.column()
        column.enabled = armature_of(context).geodesic.scheme in style.WITH_METRIC
        for name in ("alpha", "beta", "tension", "translation_tension", "side", "axes"):
            column.prop(bone, f"geodesic_slider_{name}")
        row = layout.row(align=True)
        row.operator("geodesic.mirror")
        row.operator("geodesic.reset")


class MetricPanel(_Panel, bpy.types.Panel):
    """Learning a metric, and its file."""

    bl_idname = "GEODESIC_PT_metric"
    bl_parent_id = "GEODESIC_PT_in_betweens"
    bl_label = "Metric"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        """Draw the panel."""
        layout, settings = self.layout, armature_of(context).geodesic
        layout.use_property_split = True
        layout.prop(settings, "keep")
        if settings.keep == "EVERY":
            layout.prop(settings, "every")
        layout.prop(settings, "purpose")
        layout.prop(settings, "family")
        layout.operator("geodesic.learn")
        row = layout.row(align=True)
        row.operator("geodesic.import_metric", text="Import")
        row.operator("geodesic.export_metric", text="Export")


_CLASSES = (InBetweensPanel, StylePanel, MetricPanel)


def register():
    """Register the panels."""
    for each in _CLASSES:
        bpy.utils.register_class(each)


def unregister():
    """Unregister the panels."""
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)

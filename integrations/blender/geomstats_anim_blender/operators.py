"""Operators: what the buttons of the panel do."""

import json
import threading

import bpy
from bpy_extras.io_utils import ExportHelper, ImportHelper

from . import fill, learn, service, style, working_copy


def armature_of(context):
    """Return the active armature, or None."""
    active = context.object
    return active if active is not None and active.type == "ARMATURE" else None


class _OnArmature:
    """Base of operators on the active armature: it must be there, and what is wrong is reported."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        """Ask for an active armature."""
        if armature_of(context) is None:
            cls.poll_message_set("Make an armature the active object")
            return False
        return True

    def execute(self, context):
        """Do it, and report what was done or why not."""
        try:
            self.report({"INFO"}, self.work(context, armature_of(context)))
        except (fill.FillError, service.ServiceError, style.StyleError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class InBetweens(_OnArmature, bpy.types.Operator):
    """Put in-betweens between the keys, in a copy of the action."""

    bl_idname = "geodesic.in_betweens"
    bl_label = "In-betweens"

    def work(self, context, armature):
        """Fill."""
        filled = fill.fill(armature, armature.geodesic.scope)
        for note in filled.notes:
            self.report({"WARNING"}, note)
        return str(filled)


class Remove(_OnArmature, bpy.types.Operator):
    """Take the in-betweens away and play the original action."""

    bl_idname = "geodesic.remove"
    bl_label = "Remove"

    @classmethod
    def poll(cls, context):
        """Ask for in-betweens."""
        armature = armature_of(context)
        return armature is not None and working_copy.opened(armature) is not None

    def work(self, context, armature):
        """Remove."""
        return working_copy.remove(armature, working_copy.opened(armature))


class Learn(_OnArmature, bpy.types.Operator):
    """Learn the metric with which the kept keys rebuild the baked motion best."""

    bl_idname = "geodesic.learn"
    bl_label = "Learn from Baked Motion"

    def work(self, context, armature):
        """Learn, and wait."""
        return learn.learn(armature)

    def invoke(self, context, event):
        """Learn while Blender goes on; Esc ends it."""
        armature = armature_of(context)
        try:
            request = learn.request(armature)
        except (fill.FillError, style.StyleError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._armature, self._text, self._answer, self._error = armature.name, "Learning", None, None
        self._thread = threading.Thread(target=self._ask, args=request, daemon=True)
        self._thread.start()
        self._timer = context.window_manager.event_timer_add(0.2, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def _ask(self, header, arrays):
        def progress(text):
            self._text = text

        try:
            self._answer, _ = service.ask(header, arrays, progress)
        except service.ServiceError as error:
            self._error = str(error)

    def modal(self, context, event):
        """Show what is being done, until it is."""
        context.workspace.status_text_set(f"{self._text} (Esc to end)")
        if event.type == "ESC":
            service.close()
            self._thread.join()
            self._error = "Learning was ended."
        elif event.type != "TIMER" or self._thread.is_alive():
            return {"PASS_THROUGH"}
        self._thread.join()
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        armature = bpy.data.objects.get(self._armature)
        if self._error is not None or self._answer is None or armature is None:
            self.report({"WARNING"}, self._error or f"{self._armature} is gone.")
            return {"CANCELLED"}
        self.report({"INFO"}, learn.take(armature, self._answer))
        return {"FINISHED"}


class Mirror(_OnArmature, bpy.types.Operator):
    """Give the bones of the other side the style of the selected ones, by their names."""

    bl_idname = "geodesic.mirror"
    bl_label = "Mirror"

    def work(self, context, armature):
        """Mirror."""
        bones = [bone for bone in armature.pose.bones if style.is_selected(bone)]
        n = style.mirror(bones)
        if not n:
            raise style.StyleError("No selected bone has a counterpart; Blender's rules of names are .L and .R.")
        style.changed(armature)
        return f"Mirrored to {n} bones."


class Reset(_OnArmature, bpy.types.Operator):
    """Give the selected bones the metric that bends nothing."""

    bl_idname = "geodesic.reset"
    bl_label = "Reset"

    def work(self, context, armature):
        """Reset."""
        bones = [bone for bone in armature.pose.bones if style.is_selected(bone)]
        style.reset(bones)
        style.changed(armature)
        return f"Reset {len(bones)} bones."


class ImportMetric(_OnArmature, ImportHelper, bpy.types.Operator):
    """Read a metric from JSON."""

    bl_idname = "geodesic.import_metric"
    bl_label = "Import Metric"
    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    def work(self, context, armature):
        """Read."""
        with open(self.filepath, "rb") as file:
            data = file.read(style.LARGEST + 1)
        try:
            text = data.decode()
        except UnicodeDecodeError:
            raise style.StyleError(f"{self.filepath} is no text in UTF-8.") from None
        style.take(armature, style.parse(text))
        return f"Read {self.filepath}."


class ExportMetric(_OnArmature, ExportHelper, bpy.types.Operator):
    """Write the metric as JSON."""

    bl_idname = "geodesic.export_metric"
    bl_label = "Export Metric"
    bl_options = {"REGISTER"}
    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    def work(self, context, armature):
        """Write."""
        style.store(armature)
        document = style.stored(armature) or style.document_of(armature)
        with open(self.filepath, "w", encoding="utf-8") as file:
            file.write(json.dumps(document, indent=2) + "\n")
        return f"Wrote {self.filepath}."


class Check(bpy.types.Operator):
    """Start geomstats-anim and say its version; after an installation it compiles now, for up to a minute."""

    bl_idname = "geodesic.check"
    bl_label = "Check"

    def execute(self, context):
        """Ask for the version."""
        try:
            answer, _ = service.ask({"request": "hello"}, {})
            service.warm_up()
        except service.ServiceError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"geomstats-anim {answer['version']} answers.")
        return {"FINISHED"}


_CLASSES = (InBetweens, Remove, Learn, Mirror, Reset, ImportMetric, ExportMetric, Check)


def register():
    """Register the operators."""
    for each in _CLASSES:
        bpy.utils.register_class(each)


def unregister():
    """Unregister the operators."""
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)

# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel in the modifier tab."""
from __future__ import annotations

import bpy

from ...core.mesh.base_mesh import RAISE_MOST
from .. import ui_base
from ..bake import panel as bake_panel
from ..brush import panel as brush_panel
from ..frame import clip_status, disk_frames
from ..maps import keys as maps_keys, modifier as maps_modifier
from ..nodes import field_profile, field_shader
from ..objects import changes, clip_place, lost_maps, modifier, properties, runtimes, stack_notes, units
from ..translation import OWN_CONTEXT, said
from ..ui_base import Panel, draw_message, draw_note, draw_setting, named_paint, property_column, settings_column
from ..viewport import preview
from . import (cloth_panel, examples, guides_panel, healing, paint_panel, paths_panel, rest_panel, saved_settings,
               thumbnails)

ICONS = {"MESH": "MOD_CLOTH", "FIELD": "MOD_WAVE", "PATHS": "MOD_CURVE"}


class DATA_PT_rumple(bpy.types.Panel):
    bl_label = ""  # draw_header() shows system and fabric
    bl_idname = "DATA_PT_rumple"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "modifier"
    bl_order = 100

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Hidden if there are no wrinkles: the Add Modifier menu has the entries."""
        obj = context.object
        return obj is not None and obj.type == "MESH" and modifier.find(obj) is not None

    def draw_header(self, context: bpy.types.Context) -> None:
        room = ui_base.letters_across() - (15 if examples.files() else 12)  # for the buttons
        words = "" if ui_base.is_narrow() else ui_base.shortened(title(context.object), room)
        self.layout.label(text=words, translate=False)

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        nodes_mod = modifier.find(context.object)
        row = self.layout.row(align=True)
        if not ui_base.is_narrow():  # otherwise it would cover the arrow that opens the panel
            examples.draw_button(row)
        row.prop(nodes_mod, "show_viewport", text="", emboss=False)
        row.prop(nodes_mod, "show_render", text="", emboss=False)
        saved_settings.DATA_PT_rumple_saved_settings.draw_panel_header(row)

    def draw(self, context: bpy.types.Context) -> None:
        layout, obj = self.layout, context.object
        draw_message(layout, runtimes.message(obj))
        for note in stack_notes.of(obj):
            draw_message(layout, note)
        if runtimes.of(obj).left_out:
            draw_message(layout, runtimes.of(obj).left_out)
        system = properties.system_of(obj)
        if system.presets:
            thumbnails.draw(layout, obj, ICONS[system.method])
        _draw_first(settings_column(layout, obj), obj)
        paint_panel.draw_active_map(layout, obj)
        runtime = runtimes.known(obj)
        for note in runtime.notes if runtime is not None else ():
            if note.endswith(RAISE_MOST):
                draw_note(layout, note)
        bake_panel.draw_header(layout, obj)
        row = layout.row()
        row.operator("object.rumple_apply", text="Apply")
        row.operator("object.rumple_copy_settings", text="", icon="COPYDOWN")
        row.operator("object.rumple_remove", text="" if ui_base.is_narrow() else "Remove", icon="X")
        if may_get_maps(obj):
            layout.operator("rumple.maps_add", text="Wrinkle Maps" if ui_base.is_narrow() else "Add Wrinkle Maps",
                            icon="ADD")


def title(obj: bpy.types.Object) -> str:
    """Wrinkle Mesh, and the last chosen fabric."""
    system = properties.system_of(obj)
    words = [system.label] + ([system.presets[properties.group_of(obj).preset].label] if system.presets else [])
    return " \u00b7 ".join(said(word) for word in words)


def _draw_first(column: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """Draw the settings that artists change first."""
    settings = properties.group_of(obj)
    if obj.rumple.method == "MESH" and properties.settings_of(obj, units.scene_of(obj)).layered:
        for name in ("drape", "folds", "detail"):
            cloth_panel.painted(column, obj, name)
    if obj.rumple.method == "FIELD":
        for name in ("output", "strength"):
            draw_setting(column, settings, name)
    if obj.rumple.method == "PATHS":
        paths_panel.draw_size(column, settings)
    elif obj.rumple.method == "FIELD" or (settings.source == "SUBDIVISION" and settings.density == "WAVELENGTH"):
        draw_setting(column, settings, "wavelength")
    if obj.rumple.method == "FIELD" and settings.output == "SHADING":
        column.prop(settings, "gpu_preview")
        shaded = field_shader.is_shaded(obj)
        column.operator(f"object.rumple_{'unshade' if shaded else 'shade'}", icon="X" if shaded else "MATERIAL")


class DATA_PT_rumple_fine_mesh(Panel, bpy.types.Panel):
    bl_label = "Fine Mesh"
    bl_options = {"DEFAULT_CLOSED"}
    method = "MESH"

    def draw(self, context: bpy.types.Context) -> None:
        column, obj = settings_column(self.layout, context.object), context.object
        settings = obj.rumple.mesh
        column.prop(settings, "source")
        if settings.source == "SUBDIVISION":
            column.prop(settings, "density")
            if settings.density == "LEVEL":
                column.prop(settings, "level")
        elif settings.source == "REGULAR":
            column.prop(settings, "segments")
        elif settings.source == "EDGE_LENGTH":
            draw_setting(column, settings, "edge_length")
        else:
            column.prop(obj.rumple, "own_mesh")
        steps = column.column(align=True)
        steps.prop(obj.rumple, "viewport_steps", text="Smooth Viewport")
        steps.prop(settings, "display_steps", text="Render")
        if preview.can_solve_meshes():
            column.prop(settings, "gpu_preview")
        column.prop(obj.rumple, "most_vertices")
        column.prop(settings, "weld")
        if settings.source != "OBJECT":
            column.prop(settings, "rigid_parts")


class DATA_PT_rumple_waves(Panel, bpy.types.Panel):
    bl_label = "Waves"
    bl_options = {"DEFAULT_CLOSED"}
    bl_translation_context = OWN_CONTEXT  # Blender's own French has waves of the sea
    method = "FIELD"

    def draw(self, context: bpy.types.Context) -> None:
        column, obj = settings_column(self.layout, context.object), context.object
        settings = obj.rumple.field
        if settings.output == "GEOMETRY":
            for name in ("source", "detail", "attachment", "keep_length"):
                column.prop(settings, name)
            column.prop(obj.rumple, "most_vertices")
            column.separator()
        else:
            draw_note(column, "Apply in this panel makes the waves geometry; Blender's own Apply leaves them out")
        for name in ("buckling_threshold", "dissolve", "irregularity", "seed", "profile"):
            column.prop(settings, name)
        curve = field_profile.node(obj) if settings.profile == "CURVE" else None
        if curve is not None:
            self.layout.template_curve_mapping(curve, "mapping")
            changes.note_drawn_profile(obj)
        column.separator()
        for name, group in (("mask", "mask"), ("wavelength_scale", "wavelength")):
            named_paint(column, obj, name, group)


class DATA_PT_rumple_relaxation(Panel, bpy.types.Panel):
    bl_label = "Relaxation"
    bl_options = {"DEFAULT_CLOSED"}
    method = "FIELD"

    def draw(self, context: bpy.types.Context) -> None:
        column = settings_column(self.layout, context.object)
        for name in ("rate", "rounds", "start", "start_rounds", "stateless", "weld", "rigid_parts"):
            column.prop(context.object.rumple.field, name)


class DATA_PT_rumple_constraints(Panel, bpy.types.Panel):
    bl_label = "Attachment & Constraints"
    bl_options = {"DEFAULT_CLOSED"}
    method = "MESH"

    def draw(self, context: bpy.types.Context) -> None:
        column, obj = settings_column(self.layout, context.object), context.object
        settings = obj.rumple.mesh
        column.prop(settings, "attachment")
        for name in ("radius", "prestretch", "bending"):
            cloth_panel.painted(column, obj, name)
        column.prop(settings, "collision")
        if settings.collision != "NONE":
            cloth_panel.painted(column, obj, "inside")
        column.separator()
        for name in ("stretch_relief", "buckling_threshold", "compression_limit", "hem_rings"):
            column.prop(settings, name)


class DATA_PT_rumple_solver(Panel, bpy.types.Panel):
    bl_label = "Solver"
    bl_options = {"DEFAULT_CLOSED"}
    method = "MESH"

    def draw(self, context: bpy.types.Context) -> None:
        column = settings_column(self.layout, context.object)
        for name in ("iterations", "start_iterations", "damping", "stateless", "offset_space", "nudge", "seed"):
            column.prop(context.object.rumple.mesh, name)


class DATA_PT_rumple_frames(Panel, bpy.types.Panel):
    bl_label = "Stored Frames"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column, obj = property_column(self.layout), context.object
        column.prop(obj.rumple, "memory_limit")
        column.prop(obj.rumple, "keep_frames")
        if obj.rumple.keep_frames:
            column.prop(obj.rumple, "disk_limit")
            _draw_disk(column, obj)
        runtime = runtimes.known(obj)
        if runtime is None or runtime.evaluator is None:
            return
        frame_cache = runtime.evaluator.frame_cache
        frames = frame_cache.frames()
        for label, final in (("Played through: {0}", True), ("After a jump: {0}", False)):
            numbers = [frame for frame, is_final in frames if is_final == final]
            if numbers:
                draw_note(column, said(label).format(ranges(numbers)), "BLANK1")
        draw_note(column, f"{len(frames)} frames, {frame_cache.bytes / 2**20:.1f} MB", "BLANK1")
        column.operator("object.rumple_clear_frames")


def _draw_disk(column: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """Draw messages about frames on disk."""
    kept = disk_frames.of(obj)
    if clip_place.of(obj) is None:
        draw_note(column, f"{obj.name}: save the file first: stored frames are kept beside it")
    elif kept is not None and kept.note:
        draw_note(column, kept.note)


def ranges(frames: list[float], most: int = 6) -> str:
    """1-20, 31, 40-55: whole frames as ranges, without subframes."""
    runs: list[list[int]] = []
    for frame in (int(f) for f in frames if f == int(f)):
        if runs and frame == runs[-1][1] + 1:
            runs[-1][1] = frame
        else:
            runs.append([frame, frame])
    words = [f"{a}" if a == b else f"{a}-{b}" for a, b in runs]
    return ", ".join(words[:most]) + (" ..." if len(words) > most else "")


class DATA_PT_rumple_status(Panel, bpy.types.Panel):
    bl_label = "Status"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        self.layout.label(text=said(status_line(context.object)), translate=False)

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column()
        for line, icon in status_lines(context.object):
            draw_note(column, line, icon)
        healing.draw(column, context.object)


def status_line(obj: bpy.types.Object) -> str:
    """The most important numbers, beside the closed panel: how much is shown, and the time of the last frame."""
    runtime = runtimes.known(obj)
    if modifier.plays_clip(modifier.find(obj)) or runtime is None or runtime.evaluator is None:
        return ""
    evaluator, inputs, result = runtime.evaluator, runtime.inputs, runtime.result  # read once: a render may change them
    in_viewport = inputs is not None and inputs.in_viewport and evaluator.in_viewport is not None
    count = evaluator.in_viewport.vertex_count if in_viewport else evaluator.vertex_count
    took = 0.0 if result is None else sum(result.milliseconds.values())
    return f"{count:,} vertices, {took:.0f} ms"


def status_lines(obj: bpy.types.Object) -> list[tuple[str, str]]:
    """(text, icon) for the Status panel."""
    runtime = runtimes.known(obj)
    if modifier.plays_clip(modifier.find(obj)):
        return [("Baked: the clip is shown, nothing is solved", "CHECKMARK")]
    if runtime is None or runtime.evaluator is None:
        return [("Nothing solved yet", "INFO")]
    evaluator, inputs, result, lines = runtime.evaluator, runtime.inputs, runtime.result, []
    if inputs is not None and inputs.for_preview:
        lines.append((f"Drawn on the graphics card; {evaluator.vertex_count} vertices in renders", "SHADING_SOLID"))
    else:
        fewer = evaluator.in_viewport if inputs is not None and inputs.in_viewport else None
        lines.append((f"{evaluator.vertex_count:,} vertices are shown" if fewer is None else
                      f"{fewer.vertex_count:,} vertices are shown, {evaluator.vertex_count:,} in renders", "MESH_DATA"))
    if result is not None:
        times = ", ".join(f"{stage} {ms:.2f}" for stage, ms in result.milliseconds.items())
        if times:
            lines.append((f"Milliseconds: {times}" + (" (stored frame)" if result.replayed else ""), "TIME"))
        lines += [(line, "BLANK1") for line in evaluator.status(result)]
    notes = [*runtime.notes, clip_status.late_in_renders(obj), runtime.unplayed, preview.refusal(obj),
             *_fields_not_felt(inputs), *lost_maps.deleted(obj)]
    return lines + [(note, "INFO") for note in notes if note]


def _fields_not_felt(inputs: runtimes.Inputs | None) -> list[str]:
    names = inputs.surroundings.not_felt if inputs is not None else ()
    return [f"{name}: the cloth does not feel a force field of this type" for name in names]


def may_get_maps(obj: bpy.types.Object) -> bool:
    """Wrinkle Maps can be added beside other wrinkles, whose folds can be baked into them."""
    return maps_modifier.find(obj) is None and (obj.find_armature() is not None or bool(maps_keys.blocks(obj)))


CLASSES = (DATA_PT_rumple, cloth_panel.DATA_PT_rumple_cloth, cloth_panel.DATA_PT_rumple_body,
           paint_panel.DATA_PT_rumple_paint, DATA_PT_rumple_fine_mesh, DATA_PT_rumple_waves, DATA_PT_rumple_relaxation,
           *paths_panel.CLASSES, guides_panel.DATA_PT_rumple_guides,
           brush_panel.DATA_PT_rumple_rest_wrinkles, rest_panel.DATA_PT_rumple_rest,
           DATA_PT_rumple_constraints, DATA_PT_rumple_solver, DATA_PT_rumple_frames,
           bake_panel.DATA_PT_rumple_bake, DATA_PT_rumple_status)


register, unregister = bpy.utils.register_classes_factory(CLASSES)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Warnings about the modifier stack around the wrinkles: nothing fails, but no folds are visible, or it needs
gigabytes."""
from __future__ import annotations

import os

import bpy

from . import (bodies, held_by_others, lost_maps, mesh_reader, modifier, point_caches, properties, runtimes,
               subdivision_behind, units)

# Modifiers that pose or simulate a garment. Behind the wrinkles they do not affect the folds. Smooth, Shrinkwrap and
# similar ones are allowed there.
_POSES = frozenset(("ARMATURE", "CLOTH", "CURVE", "HOOK", "LATTICE", "MESH_CACHE", "MESH_DEFORM", "MESH_SEQUENCE_CACHE",
                    "SOFT_BODY", "SURFACE_DEFORM"))


def of(obj: bpy.types.Object) -> list[str]:
    """Sentences for the panel. They are made at each redraw, because Blender does not report a moved modifier. Only
    reads."""
    nodes_mod = modifier.find(obj)
    if nodes_mod is None:
        return []
    if modifier.is_baked(nodes_mod):
        return held_by_others.notes(obj) + point_caches.notes(obj)
    return (lost_maps.renamed(obj) + _order(obj, nodes_mod) + _particles(obj, nodes_mod) + _armatures(obj) + _scale(obj)
            + _other_points_in_renders(obj, nodes_mod)
            + subdivision_behind.notes(obj, runtimes.of(obj).evaluator) + skipped_frames(obj) + _finer_bodies(obj)
            + held_by_others.notes(obj) + point_caches.notes(obj))


def skipped_frames(obj: bpy.types.Object) -> list[str]:
    """About an animation rendered with a Step: each frame is a jump. Cloth that swings has its own message in each
    frame."""
    scene = units.scene_of(obj)
    settings = properties.settings_of(obj, scene)
    if scene.frame_step == 1 or settings.stateless or settings.swings or _are_stored(obj, scene):
        return []
    return [f"{obj.name}: Step of the scene is {scene.frame_step}, so a render solves each frame as after a jump: play "
            "all frames first, set it to 1, or bake"]


def resumed(obj: bpy.types.Object) -> list[str]:
    """About an animation with Overwrite off whose first pictures exist: the first frame that is rendered is a jump. It
    looks at files, so only the check before a render calls it."""
    scene = units.scene_of(obj)
    render, settings, evaluator = scene.render, properties.settings_of(obj, scene), runtimes.of(obj).evaluator
    if render.use_overwrite or render.is_movie_format or settings.stateless or settings.swings:
        return []
    first = next((frame for frame in range(scene.frame_start, scene.frame_end + 1, scene.frame_step)
                  if not os.path.exists(render.frame_path(frame=frame))), None)
    if first in (None, scene.frame_start) or first <= units.first_frame(obj, scene):
        return []
    stored = [] if evaluator is None else [evaluator.frame_cache.get(float(frame)) for frame in (first - 1, first)]
    if any(frame is not None and frame.final for frame in stored):
        return []
    return [f"{obj.name}: Overwrite is off and pictures exist, so a render goes on in frame {first} as after a jump: "
            "play all frames first, switch it on, or bake"]


def _are_stored(obj: bpy.types.Object, scene: bpy.types.Scene) -> bool:
    """Whether every frame of a rendered animation was reached by playback and is stored."""
    evaluator = runtimes.of(obj).evaluator
    stored = [None if evaluator is None else evaluator.frame_cache.get(float(frame))
              for frame in range(scene.frame_start, scene.frame_end + 1, scene.frame_step)]
    return all(frame is not None and frame.final for frame in stored)


def _finer_bodies(obj: bpy.types.Object) -> list[str]:
    """About a body that has other points in renders, so that the folds on it are others than those that were played.
    Of a garment under this one the solved surface counts, which is the same."""
    differs = (body for body in bodies.of(obj) if modifier.find(body) is None and any(
        m.show_viewport != m.show_render or m.levels != m.render_levels
        for m in body.modifiers if m.type in ("SUBSURF", "MULTIRES")))
    return [f"{obj.name}: its body {body.name} has other levels of Subdivision in renders, so folds differ there: set "
            "the same for viewport and renders" for body in differs][:1]


def _particles(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> list[str]:
    """Behind the wrinkles, particles lie at the object's origin, because faces of the fine mesh have no index in the
    coarse one."""
    stack = list(obj.modifiers)
    return [f"{obj.name}: the particles of \"{m.name}\" do not find their places on the fine mesh: move "
            f"{nodes_mod.name} below it in the stack"
            for m in stack[stack.index(nodes_mod) + 1:] if m.type == "PARTICLE_SYSTEM" and _is_on(m)][:1]


def _armatures(obj: bpy.types.Object) -> list[str]:
    """Armature modifiers that move no vertex, because they have no object or there are no weights for its bones. With a
    base cloth the garment would hang without support."""
    groups, notes = {group.name for group in obj.vertex_groups}, []
    for m in obj.modifiers:
        if m.type != "ARMATURE" or not _is_on(m):
            continue
        if m.object is None:
            notes.append(f"{obj.name}: the modifier \"{m.name}\" has no armature: choose it there (Object)")
        elif m.object.type == "ARMATURE" and not m.use_bone_envelopes and not any(
                b.use_deform and b.name in groups for b in m.object.data.bones):
            notes.append(f"{obj.name}: the modifier \"{m.name}\" moves no vertex: no vertex group has the name of one "
                         "of its bones. Parent the mesh to the armature with automatic weights, or paint weights")
    return notes


def _scale(obj: bpy.types.Object) -> list[str]:
    """Lengths are compared in object space. If this differs from the space of the deformation by more than a uniform
    scale, rotations change lengths."""
    uneven = units.unevenly_scaled(obj, units.scene_of(obj))
    return [] if uneven is None else [
        f"{obj.name}: the scale of \"{uneven.name}\" differs by axes, so folds come where cloth only turns: apply it "
        "(Object > Apply > Scale)"]


def _order(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> list[str]:
    stack = list(obj.modifiers)
    place = stack.index(nodes_mod)
    late = next((m for m in stack[place + 1:] if m.type in _POSES and _is_on(m)), None)
    if late is not None:
        return [f"{obj.name}: the modifier \"{late.name}\" is below {nodes_mod.name} in the stack, so the wrinkles do "
                f"not see what it moves: move {nodes_mod.name} below it"]
    if not any(_is_on(m) and (m.type in modifier.DEFORMING or m.type == "NODES") for m in stack[:place]) \
            and not _is_folded_otherwise(obj):
        return [f"{obj.name}: nothing above {nodes_mod.name} in the stack deforms the mesh, so it has no folds: add a "
                f"shape key, or put an Armature or a simulation above {nodes_mod.name}"]
    return []


def _other_points_in_renders(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> list[str]:
    """About the first modifier that makes other points in renders: the fine mesh is made for the viewports' points."""
    for m in modifier.in_front(obj):
        if not modifier.changes_topology(m):
            continue
        if m.show_viewport != m.show_render or (_levels(m, "levels") != _levels(m, "render_levels")
                                                and not _is_simplified(m)):
            return [f"{obj.name}: the modifier \"{m.name}\" above {nodes_mod.name} makes other vertices in renders "
                    "than in viewports, so renders have no wrinkles: set both alike"]
        if _levels(m, "levels") != _levels(m, "render_levels"):
            return [f"{obj.name}: Simplify (Render Properties) lets the modifier \"{m.name}\" above {nodes_mod.name} "
                    "make other vertices in renders than in viewports, so renders have no wrinkles: set Max "
                    "Subdivision of both alike, or switch Simplify off"]
    return []


def _is_simplified(m: bpy.types.Modifier) -> bool:
    """Whether its levels differ only because of Simplify."""
    return bpy.context.scene.render.use_simplify and getattr(m, "levels", 0) == getattr(m, "render_levels", 0)


def _levels(m: bpy.types.Modifier, name: str) -> int:
    """Subdivisions in viewports ("levels") or renders ("render_levels"), limited by Simplify."""
    render, levels = bpy.context.scene.render, getattr(m, name, 0)
    most = render.simplify_subdivision_render if name == "render_levels" else render.simplify_subdivision
    return min(levels, most) if render.use_simplify and m.type == "SUBSURF" else levels


def _is_on(m: bpy.types.Modifier) -> bool:
    return m.show_viewport or m.show_render


def _is_folded_otherwise(obj: bpy.types.Object) -> bool:
    """Whether it has shape keys, a deforming parent, cloth, another rest shape, or paint by hand."""
    keys, settings = obj.data.shape_keys, properties.group_of(obj)
    painted = obj.rumple.method == "FIELD" and mesh_reader.REST_WRINKLE in obj.data.attributes
    return ((keys is not None and len(keys.key_blocks) > 1) or obj.parent_type in ("ARMATURE", "LATTICE", "CURVE")
            or settings.base_cloth != "OFF" or settings.rest_shape in ("SHAPE_KEY", "FRAME") or bool(bodies.of(obj))
            or painted)

# SPDX-License-Identifier: GPL-3.0-or-later
"""The two hidden objects that a Wrinkle Maps modifier reads, in no collection: its inputs keep them alive.

The skin has a point for each vertex, with its weights. The skeleton has two for each bone, its head and its tail, and
four for the root bone, whose space is read from them. An Armature modifier poses them. For a shape key it has a point
that a key of its own moves along x, driven by the value of the artist's. So the present pose
reaches the nodes within Blender's one evaluation of a frame: no handler, no second evaluation, and on a machine
without Rumple the masks follow the pose just so. What stands in their attributes says maps_mask_tree.py.

Blender's matrices of objects are in single precision: kilometres from the origin a place in the world has no
millimetres left. So no number here has the armature's place in it. The object stands where the armature does, but is
neither turned nor scaled: what leads from it to the armature is then the turn and scale of that, to the bit. A Hook
turns and scales the points, which lie in armature space, before the Armature modifier, which looks for them there. What
they all have been turned and scaled by does not count in root space.
"""
from __future__ import annotations

from typing import Sequence

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ...core.poses import ROW, PoseComparison, PoseRig, packed
from .. import compat
from ..nodes import maps_mask_tree
from ..nodes.maps_mask_tree import FRAME
from .rig import is_rigid

KEY = "rumple_maps_carrier"  # custom property: tells leftovers from the artist's objects
SHAPE = "rumple_maps_shape"  # ... and what it was made from
SKIN, SKELETON = ".maps", ".bones"
KEY_RANGE = -10.0, 10.0  # Blender's own limits


def _hidden(name: str, mesh: bpy.types.Mesh, shape: str) -> bpy.types.Object:
    hidden_obj = bpy.data.objects.new(name, mesh)
    hidden_obj[KEY], hidden_obj[SHAPE] = True, shape
    return hidden_obj


def made_from(hidden_obj: bpy.types.Object | None, shape: str) -> bool:
    """True where it can be written and is what new_skin() or new_skeleton() would make."""
    # An override of a hidden object has the linked mesh, where writing is silently ignored.
    return hidden_obj is not None and all(map(compat.is_editable,
                                              (hidden_obj, hidden_obj.data))) and hidden_obj.get(SHAPE) == shape


def new_skin(name: str, comparison: PoseComparison, shape: str) -> bpy.types.Object:
    """Without weights: write_weights() must follow."""
    table = comparison.table()
    mesh = bpy.data.meshes.new(name + SKIN)
    mesh.vertices.add(len(table.bone))
    for column in range(ROW):
        compat.write_attribute(mesh, maps_mask_tree.BONE.format(column), "INT", "POINT", table.bone[:, column])
    for row, further in enumerate(table.more):
        values = np.full(len(table.bone), -1, np.int32)
        values[:len(further)] = further
        compat.write_attribute(mesh, maps_mask_tree.MORE.format(row), "INT", "POINT", values)
    return _hidden(name + SKIN, mesh, shape)


def write_weights(hidden_obj: bpy.types.Object, comparison: PoseComparison, gain: float,
                  strength: Sequence[float]) -> None:
    """With gain and strengths. The only thing that handlers write, and only where these are animated."""
    table = comparison.table()
    for number, lifts in enumerate(packed(comparison.lifts(gain, strength))):
        for column in range(ROW):
            compat.write_attribute(hidden_obj.data, maps_mask_tree.WEIGHTS.format(number, column), "FLOAT_VECTOR",
                                   "POINT",
                                   table.weight[:, column, None] * lifts[table.vertex])
    hidden_obj.data.update()


def new_skeleton(obj: bpy.types.Object, comparison: PoseComparison, shape: str) -> bpy.types.Object:
    """Follows the bones that deform an object, and its shape keys."""
    rig, count = comparison.rig, len(comparison.rig.elements)
    mesh = bpy.data.meshes.new(obj.name + SKELETON)
    mesh.vertices.add(2 * count + (FRAME if rig.bones else 0))
    hidden_obj = _hidden(obj.name + SKELETON, mesh, shape)
    compat.set_positions(mesh, np.zeros((len(mesh.vertices), 3), np.float32))
    unit = 1.0
    if rig.bones:
        unit = _unit_of(rig, obj.find_armature())
        _follow_bones(hidden_obj, rig, unit, obj.find_armature())
    _write_rig(mesh, comparison, unit)
    mesh.update()
    if rig.keys:
        _follow_keys(hidden_obj, rig, obj.data.shape_keys)
    return hidden_obj


def _unit_of(rig: PoseRig, armature: bpy.types.Object) -> float:
    """About the length of the root bone, in armature units: so long are the axes that its space is read from. A power
    of two: what is divided by it keeps its bits."""
    known = armature.data.bones
    return float(2.0 ** np.round(np.log2(known[rig.root].length if rig.root else known[rig.bones[0].name].length)))


def _points(rig: PoseRig, unit: float, armature: bpy.types.Object) -> dict[str, list[tuple[int, Vector]]]:
    """Bone, empty for the armature itself -> its points: their numbers, and their places in the space of the bone."""
    count = len(rig.elements)
    found: dict[str, list[tuple[int, Vector]]] = {}
    for number, tracked in enumerate(rig.bones):
        tail = Vector((0.0, armature.data.bones[tracked.name].length, 0.0))
        found[tracked.name] = [(number, Vector()), (count + number, tail)]
    ends = (Vector(), *(unit * axis for axis in Matrix.Identity(3)))
    found.setdefault(rig.root, []).extend(enumerate(ends, 2 * count))
    return found


def _follow_bones(hidden_obj: bpy.types.Object, rig: PoseRig, unit: float, armature: bpy.types.Object) -> None:
    posed: list[int] = []
    for name, points in _points(rig, unit, armature).items():
        bone, numbers = armature.data.bones.get(name), [number for number, _ in points]
        rest = Matrix.Identity(4)
        if bone is not None and not is_rigid(bone):
            _drive(_hook(hidden_obj, armature, name, numbers), armature, name)
        else:
            posed += numbers
            if bone is not None:
                rest = bone.matrix_local
                hidden_obj.vertex_groups.new(name=name).add(numbers, 1.0, "REPLACE")
        for number, place in points:
            hidden_obj.data.vertices[number].co = rest @ place
    _hook(hidden_obj, armature, "To Armature", posed)
    hidden_obj.modifiers.new("Armature", "ARMATURE").object = armature
    hidden_obj.constraints.new("COPY_LOCATION").target = armature


def _hook(hidden_obj: bpy.types.Object, armature: bpy.types.Object, name: str, points: list[int]
          ) -> bpy.types.HookModifier:
    """From armature space, or what its matrix_inverse leads from, to the object's."""
    hook = hidden_obj.modifiers.new(name, "HOOK")
    hook.object, hook.falloff_type, hook.strength = armature, "NONE", 1.0
    hook.vertex_indices_set(points)
    hook.matrix_inverse = Matrix.Identity(4)
    return hook


def _drive(hook: bpy.types.HookModifier, armature: bpy.types.Object, bone: str) -> None:
    """By a bone that no Armature modifier moves, as roots often are: number by number, which takes 30 times as long.

    Not by a Hook's own bone, whose place in the world Blender would compute."""
    path = f'pose.bones["{bpy.utils.escape_identifier(bone)}"].matrix'
    for entry in range(16):
        if entry % 4 < 3:  # the last row stays
            driver = hook.driver_add("matrix_inverse", entry).driver
            _add_variable(driver, "entry", armature, f"{path}[{entry // 4}][{entry % 4}]")
            driver.expression = "entry"


def _follow_keys(hidden_obj: bpy.types.Object, rig: PoseRig, keys: bpy.types.Key) -> None:
    """Points at the origin, each moved along x by its key's value. Blender mends the drivers where keys are renamed."""
    hidden_obj.shape_key_add(name="Basis")
    for point, tracked in enumerate(rig.keys, len(rig.bones)):
        block = hidden_obj.shape_key_add(name=str(point), from_mix=False)
        block.slider_min, block.slider_max = KEY_RANGE
        block.data[point].co.x += 1.0
        driver = hidden_obj.data.shape_keys.driver_add(f'key_blocks["{point}"].value').driver
        for name in ("value", "mute"):
            _add_variable(driver, name, keys, f'key_blocks["{bpy.utils.escape_identifier(tracked.name)}"].{name}')
        driver.expression = "value * (1 - mute)"  # simple: Blender computes it without Python, and asks for no trust


def _add_variable(driver: bpy.types.Driver, name: str, owner: bpy.types.ID, path: str) -> None:
    variable = driver.variables.new()
    variable.name = name
    target = variable.targets[0]
    target.id_type = "KEY" if isinstance(owner, bpy.types.Key) else "OBJECT"
    target.id, target.data_path = owner, path


def armature_of(skeleton: bpy.types.Object) -> bpy.types.Object | None:
    """The armature that it follows."""
    return next((c.target for c in skeleton.constraints if c.type == "COPY_LOCATION"), None)


def keys_of(skeleton: bpy.types.Object) -> bpy.types.Key | None:
    """The shape keys that it follows."""
    own = skeleton.data.shape_keys
    drivers = own.animation_data.drivers if own is not None and own.animation_data is not None else ()
    return drivers[0].driver.variables[0].targets[0].id if len(drivers) else None


def follows(skeleton: bpy.types.Object, obj: bpy.types.Object, rig: PoseRig) -> bool:
    """It has the bones and shape keys of this object, not those of another that it was copied from."""
    return (armature_of(skeleton) == (obj.find_armature() if rig.bones else None)
            and keys_of(skeleton) == (obj.data.shape_keys if rig.keys else None))


def _write_rig(mesh: bpy.types.Mesh, comparison: PoseComparison, unit: float) -> None:
    """unit: what 1 is in the root space of the nodes, in armature units."""
    rig, count = comparison.rig, len(comparison.rig.elements)
    units = np.repeat(np.array([unit, 1.0], np.float32), [len(rig.bones), len(rig.keys)])[:, None]

    def write(name: str, data_type: str, heads: np.ndarray, tails: np.ndarray, frame: float = 0) -> None:
        """heads: also of keys."""
        rest = np.full((len(mesh.vertices) - 2 * count, *heads.shape[1:]), frame, heads.dtype)
        compat.write_attribute(mesh, name, data_type, "POINT", np.concatenate([heads, tails, rest]))

    def write_ends(name: str, values: np.ndarray) -> None:
        write(name, "FLOAT_VECTOR", values[:, :3], values[:, 3:])

    write_ends(maps_mask_tree.NEUTRAL, comparison.neutral() / units)
    for number, slope in enumerate(comparison.slopes()):
        write_ends(maps_mask_tree.SLOPE.format(number), slope * units)
    group = rig.group_numbers()
    alone = group < 0
    group[alone] = count + np.flatnonzero(alone)
    write(maps_mask_tree.GROUP, "INT", group, np.full(count, -1, np.int32), -1)  # tails count for none
    for number, shares in enumerate(packed(comparison.shares())):
        write(maps_mask_tree.SHARE.format(number), "FLOAT_VECTOR", shares, np.zeros_like(shares))
    is_key = (np.arange(count) >= len(rig.bones)).astype(np.float32)
    write(maps_mask_tree.KEY, "FLOAT", is_key, np.zeros_like(is_key))

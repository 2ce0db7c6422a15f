# SPDX-License-Identifier: GPL-3.0-or-later
"""The two hidden objects that a Wrinkle Maps modifier reads. They are in no collection; its inputs keep them alive.

The skin has a point for each vertex, with its weights. The skeleton has two points for each bone, head and tail, and
four for the root bone, which define its space. An Armature modifier poses these points. For a shape key the skeleton
has a point that a key of its own moves along x, driven by the value of the artist's key. So the nodes get the current
pose in Blender's single evaluation of a frame, without a handler. The masks also follow the pose on a machine without
Rumple. maps_mask_tree.py describes the attributes.

Blender's object matrices have single precision. Kilometres from the origin, millimetres are lost. So no number here
contains the armature's location. The object has the location of the armature, but no rotation and scale. The transform
between both is then exactly the armature's rotation and scale. A Hook applies it to the points, which are in armature
space, before the Armature modifier, which expects them there. A common rotation and scale of all points has no effect
in root space.
"""
from __future__ import annotations

from typing import Sequence

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ...core.systems.poses import ROW, PoseComparison, PoseRig, packed
from .. import compat
from ..nodes import maps_mask_tree
from ..nodes.maps_mask_tree import FRAME
from .rig import is_rigid

KEY = "rumple_maps_carrier"  # custom property: identifies our objects, to remove unused ones
SHAPE = "rumple_maps_shape"  # custom property: fingerprint of the inputs
SKIN, SKELETON = ".maps", ".bones"
KEY_RANGE = -10.0, 10.0  # Blender's own limits


def _hidden(name: str, mesh: bpy.types.Mesh, shape: str) -> bpy.types.Object:
    hidden_obj = bpy.data.objects.new(name, mesh)
    hidden_obj[KEY], hidden_obj[SHAPE] = True, shape
    return hidden_obj


def made_from(hidden_obj: bpy.types.Object | None, shape: str) -> bool:
    """Whether it can be written and equals a new one from new_skin() or new_skeleton()."""
    # An override of a hidden object has the linked mesh, where writing is silently ignored.
    return hidden_obj is not None and all(map(compat.is_editable,
                                              (hidden_obj, hidden_obj.data))) and hidden_obj.get(SHAPE) == shape


def new_skin(name: str, comparison: PoseComparison, shape: str) -> bpy.types.Object:
    """A new skin, without weights. Call write_weights() next."""
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
    """Write weights, gain and strengths. Handlers write nothing else, and this only if gain or strengths are
    animated."""
    table = comparison.table()
    for number, lifts in enumerate(packed(comparison.lifts(gain, strength))):
        for column in range(ROW):
            compat.write_attribute(hidden_obj.data, maps_mask_tree.WEIGHTS.format(number, column), "FLOAT_VECTOR",
                                   "POINT",
                                   table.weight[:, column, None] * lifts[table.vertex])
    compat.values_changed(hidden_obj.data)


def new_skeleton(obj: bpy.types.Object, comparison: PoseComparison, shape: str) -> bpy.types.Object:
    """A new skeleton, which follows the bones that deform an object, and its shape keys."""
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
    """The length of the axes that define the root's space: about the length of the root bone, in armature units. It is
    a power of two, so that a division by it is exact."""
    known = armature.data.bones
    return float(2.0 ** np.round(np.log2(known[rig.root].length if rig.root else known[rig.bones[0].name].length)))


def _points(rig: PoseRig, unit: float, armature: bpy.types.Object) -> dict[str, list[tuple[int, Vector]]]:
    """Bone (empty: the armature itself) -> its points: their numbers, and their positions in the bone's space."""
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
    """A Hook that transforms points from armature space, or from the source space of its matrix_inverse, to the
    object's space."""
    hook = hidden_obj.modifiers.new(name, "HOOK")
    hook.object, hook.falloff_type, hook.strength = armature, "NONE", 1.0
    hook.vertex_indices_set(points)
    hook.matrix_inverse = Matrix.Identity(4)
    return hook


def _drive(hook: bpy.types.HookModifier, armature: bpy.types.Object, bone: str) -> None:
    """Let a bone that no Armature modifier moves (often the root) move a Hook, by a driver for each entry of its
    matrix, which takes 30 times as long.

    Not by a Hook's own bone, because Blender would compute its place in world space."""
    path = f'pose.bones["{bpy.utils.escape_identifier(bone)}"].matrix'
    for entry in range(16):
        if entry % 4 < 3:  # the last row stays
            driver = hook.driver_add("matrix_inverse", entry).driver
            _add_variable(driver, "entry", armature, f"{path}[{entry // 4}][{entry % 4}]")
            driver.expression = "entry"


def _follow_keys(hidden_obj: bpy.types.Object, rig: PoseRig, keys: bpy.types.Key) -> None:
    """Points at the origin, each moved along x by its key's value. Blender updates the drivers if keys are renamed."""
    hidden_obj.shape_key_add(name="Basis")
    for point, tracked in enumerate(rig.keys, len(rig.bones)):
        block = hidden_obj.shape_key_add(name=str(point), from_mix=False)
        block.slider_min, block.slider_max = KEY_RANGE
        block.data[point].co.x += 1.0
        driver = hidden_obj.data.shape_keys.driver_add(f'key_blocks["{point}"].value').driver
        for name in ("value", "mute"):
            _add_variable(driver, name, keys, f'key_blocks["{bpy.utils.escape_identifier(tracked.name)}"].{name}')
        # a simple expression: Blender evaluates it without Python, so it also works in files that are not trusted
        driver.expression = "value * (1 - mute)"


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
    """Whether it follows the bones and shape keys of this object, and not those of an object that it was copied
    from."""
    return (armature_of(skeleton) == (obj.find_armature() if rig.bones else None)
            and keys_of(skeleton) == (obj.data.shape_keys if rig.keys else None))


def _write_rig(mesh: bpy.types.Mesh, comparison: PoseComparison, unit: float) -> None:
    """Write the attributes of the rig. unit: the unit of the nodes' root space, in armature units."""
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
    write(maps_mask_tree.GROUP, "INT", group, np.full(count, -1, np.int32), -1)  # tails are in no group
    for number, shares in enumerate(packed(comparison.shares())):
        write(maps_mask_tree.SHARE.format(number), "FLOAT_VECTOR", shares, np.zeros_like(shares))
    is_key = (np.arange(count) >= len(rig.bones)).astype(np.float32)
    write(maps_mask_tree.KEY, "FLOAT", is_key, np.zeros_like(is_key))

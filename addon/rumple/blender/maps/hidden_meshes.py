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

from typing import NamedTuple, Sequence

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
REACH = 1000.0  # sizes of the rig, of a bone that a driver follows, at a tenth of these limits


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


# ---------------------------------------------------------------- its bones
class _Point(NamedTuple):
    """One that follows a bone."""

    number: int
    bone: str  # empty: the armature itself
    rest: Vector  # armature space
    terms: tuple[tuple[str, float], ...]  # properties of the posed bone, and how much of each: it is their sum


def _unit_of(rig: PoseRig, armature: bpy.types.Object) -> float:
    """About the length of the root bone, in armature units: so long are the axes that its space is read from. A power
    of two: what is divided by it keeps its bits."""
    known = armature.data.bones
    return float(2.0 ** np.round(np.log2(known[rig.root].length if rig.root else known[rig.bones[0].name].length)))


def _points(rig: PoseRig, unit: float, armature: bpy.types.Object) -> list[_Point]:
    known, count = armature.data.bones, len(rig.elements)
    found = []
    for number, tracked in enumerate(rig.bones):
        bone = known[tracked.name]
        found += [_Point(number, bone.name, bone.head_local, (("head", 1.0),)),
                  _Point(count + number, bone.name, bone.tail_local, (("tail", 1.0),))]
    root = known[rig.root].matrix_local if rig.root else Matrix.Identity(4)
    for point, end in enumerate((Vector(), *(unit * axis for axis in Matrix.Identity(3)))):
        axes = ((f"matrix[{point - 1}]", unit),) if point else ()
        found.append(_Point(2 * count + point, rig.root, root @ end, (("matrix[3]", 1.0), *axes)))
    return found


def _follow_bones(hidden_obj: bpy.types.Object, rig: PoseRig, unit: float, armature: bpy.types.Object) -> None:
    points = _points(rig, unit, armature)
    posed = [point for point in points if not point.bone or is_rigid(armature.data.bones[point.bone])]
    for point in posed:
        hidden_obj.data.vertices[point.number].co = point.rest
        if point.bone:
            group = hidden_obj.vertex_groups.get(point.bone) or hidden_obj.vertex_groups.new(name=point.bone)
            group.add([point.number], 1.0, "REPLACE")
    reach = 2.0 ** np.ceil(np.log2(REACH * max(point.rest.length for point in points)))
    for point in points:
        if point not in posed:
            _drive(hidden_obj, point, armature, float(reach))
    hook = hidden_obj.modifiers.new("To Armature", "HOOK")
    hook.object, hook.falloff_type, hook.strength = armature, "NONE", 1.0
    hook.vertex_indices_set([point.number for point in points])
    hook.matrix_inverse = Matrix.Identity(4)
    hidden_obj.modifiers.new("Armature", "ARMATURE").object = armature
    hidden_obj.constraints.new("COPY_LOCATION").target = armature


def _drive(hidden_obj: bpy.types.Object, point: _Point, armature: bpy.types.Object, reach: float) -> None:
    """Of a bone that no Armature modifier moves, as roots often are: a shape key for each axis, 30 times as slow.

    reach: what a value of 1 is, in armature units. Blender holds values within KEY_RANGE.
    """
    for axis in range(3):
        block, driver = _driven_key(hidden_obj, f"{point.number}.{'xyz'[axis]}")
        block.data[point.number].co[axis] += reach
        for number, (name, _) in enumerate(point.terms):
            path = f'pose.bones["{bpy.utils.escape_identifier(point.bone)}"].{name}[{axis}]'
            _add_variable(driver, f"term{number}", "OBJECT", armature, path)
        terms = " + ".join(f"term{number} * {share}" for number, (_, share) in enumerate(point.terms))
        driver.expression = f"({terms}) / {reach}"


# ---------------------------------------------------------------- its shape keys
def _follow_keys(hidden_obj: bpy.types.Object, rig: PoseRig, keys: bpy.types.Key) -> None:
    """Points at the origin, each moved along x by its key's value. Blender mends the drivers where keys are renamed."""
    for point, tracked in enumerate(rig.keys, len(rig.bones)):
        block, driver = _driven_key(hidden_obj, str(point))
        block.data[point].co.x += 1.0
        for name in ("value", "mute"):
            _add_variable(driver, name, "KEY", keys,
                          f'key_blocks["{bpy.utils.escape_identifier(tracked.name)}"].{name}')
        driver.expression = "value * (1 - mute)"


def _driven_key(hidden_obj: bpy.types.Object, name: str) -> tuple[bpy.types.ShapeKey, bpy.types.Driver]:
    """A new one. Its expression is to be simple: Blender computes it without Python then, and asks for no trust."""
    if hidden_obj.data.shape_keys is None:
        hidden_obj.shape_key_add(name="Basis")
    block = hidden_obj.shape_key_add(name=name, from_mix=False)
    block.slider_min, block.slider_max = KEY_RANGE
    return block, hidden_obj.data.shape_keys.driver_add(f'key_blocks["{name}"].value').driver


def _add_variable(driver: bpy.types.Driver, name: str, id_type: str, owner: bpy.types.ID, path: str) -> None:
    variable = driver.variables.new()
    variable.name = name
    target = variable.targets[0]
    target.id_type, target.id, target.data_path = id_type, owner, path


# ---------------------------------------------------------------- what it follows
def armature_of(skeleton: bpy.types.Object) -> bpy.types.Object | None:
    """The armature that it follows."""
    return next((c.target for c in skeleton.constraints if c.type == "COPY_LOCATION"), None)


def keys_of(skeleton: bpy.types.Object) -> bpy.types.Key | None:
    """The shape keys that it follows."""
    own = skeleton.data.shape_keys
    drivers = own.animation_data.drivers if own is not None and own.animation_data is not None else ()
    followed = (curve.driver.variables[0].targets[0].id for curve in drivers)
    return next((owner for owner in followed if isinstance(owner, bpy.types.Key)), None)


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

# SPDX-License-Identifier: GPL-3.0-or-later
"""The node groups "Rumple Wrinkle Mesh", "Rumple Wrinkle Field" and so on, built by code: one for each system.

A group shows the mesh of a hidden output object instead of the incoming coarse mesh:

    position = p0 + u (p1 - p0) + v (p2 - p0) + t o.x + b o.y + n o.z
    t = normalize(p1 - p0),  n = normalize((p1 - p0) x (p2 - p0)),  b = n x t

p0 p1 p2 are incoming points. The offset is in an orthonormal frame, not an affine one, because it then stays near the
cloth if no add-on writes new offsets. A collapsed triangle has t = n = b = 0: Blender's Normalize gives zero for zero,
so there is no NaN.

If the object is baked, positions and attributes come from the points of another hidden object, the cache object, which
a Mesh Cache moves. clip_file.py describes them. Everything is stored as positions, because only positions can be played
without an add-on.

Attributes, all starting with "rumple_":
  on the output object only, removed from the result
    rumple_corner_0, _1, _2   INT     incoming points the vertex is embedded in
    rumple_barycentric        VECTOR  (u, v, 0)
    rumple_local_offset       VECTOR  (o.x, o.y, o.z), rewritten for every frame
    rumple_stands_in          INT     on all points: 1 if viewports show the coarse mesh, moved by
    rumple_stand_in           VECTOR  the displacement of point i; see preview.py
  on the result, for Rumple itself
    rumple_base_position      VECTOR  incoming position of point i, on the first N points
    rumple_base_index         INT     i: shows how later modifiers have reordered the points
  on the result, for shaders and nodes
    rumple_stretch_min, rumple_stretch_max   FLOAT   principal stretches of the coarse mesh, 1 = rest
    rumple_stretch_direction                 VECTOR  strongest compression, object space
    rumple_offset                            VECTOR  displacement from the coarse surface, object space
    and the system's own, see ATTRIBUTES of its class in ../core
  on the coarse mesh
    rumple_rest_position      VECTOR  rest shape captured from a frame
    rumple_rest_basis         VECTOR  undeformed positions that it, and painted rest wrinkles, belong to
"""
from __future__ import annotations

import bpy

from ...core.files import clip_file
from ...core.mesh.frame_result import Attribute
from ...core.systems.all_systems import SYSTEMS, System
from .. import compat
from .builder import GeometryNodes, empty_modifier_group
from .output_flags import THRESHOLD, Flag

VERSION = 10  # increase it when the nodes change: trees in older files are then rebuilt in place
VERSION_KEY = "rumple_wrinkle_mesh_version"
METHOD_KEY = "rumple_method"

CORNERS = ("rumple_corner_0", "rumple_corner_1", "rumple_corner_2")
BARYCENTRIC = "rumple_barycentric"
LOCAL_OFFSET = "rumple_local_offset"
BASE_POSITION = "rumple_base_position"
BASE_INDEX = "rumple_base_index"
REST_POSITION = "rumple_rest_position"
REST_BASIS = "rumple_rest_basis"
SHOWS_PROXY = "rumple_stands_in"
PROXY_OFFSET = "rumple_stand_in"
OUTPUT_ONLY = (*CORNERS, BARYCENTRIC, LOCAL_OFFSET, SHOWS_PROXY, PROXY_OFFSET)

OUTPUT, COUNT, BAKED, CACHE = "Carrier", "Coarse Vertices", "Baked", "Player"
VIEWPORT_OUTPUT = "Viewport Carrier"  # viewports show it instead of OUTPUT
BODY, BODIES = "Body", "Bodies"  # no node reads them, but Blender evaluates their objects first, even if hidden
_INPUTS = (("Geometry", "NodeSocketGeometry"), (OUTPUT, "NodeSocketObject"), (COUNT, "NodeSocketInt"),
           (BAKED, "NodeSocketBool"), (CACHE, "NodeSocketObject"), (BODY, "NodeSocketObject"),
           (BODIES, "NodeSocketCollection"), (VIEWPORT_OUTPUT, "NodeSocketObject"))


def is_ours(group: bpy.types.NodeTree | None) -> bool:
    """Whether it is one of these node groups, independent of its name and version."""
    return group is not None and VERSION_KEY in group


def system(group: bpy.types.NodeTree) -> System:
    """The system of one of our node groups."""
    return SYSTEMS[group.get(METHOD_KEY, "MESH")]  # files from before the second system have no key


def ensure(method: str) -> bpy.types.NodeTree:
    """The node group of this file for a method. It is created or upgraded if necessary."""
    for group in bpy.data.node_groups:
        if is_ours(group) and compat.is_editable(group) and system(group).method == method:
            upgrade(group)
            return group
    group = bpy.data.node_groups.new(f"Rumple {SYSTEMS[method].label}", "GeometryNodeTree")
    group[VERSION_KEY], group[METHOD_KEY] = 0, method
    upgrade(group)
    return group


def upgrade(group: bpy.types.NodeTree) -> bool:
    """Rebuild the nodes of an older version in place, so that modifiers keep their inputs."""
    if group[VERSION_KEY] == VERSION or not compat.is_editable(group):
        return False
    empty_modifier_group(group, _INPUTS)
    _Builder(group, system(group).wrinkles.ATTRIBUTES).build()
    group[VERSION_KEY] = VERSION
    return True


class _Builder(GeometryNodes):
    """The tree of one system."""

    def __init__(self, group: bpy.types.NodeTree, attributes: tuple[Attribute, ...]) -> None:
        super().__init__(group)
        self.attributes = attributes

    def is_set(self, place: list[bpy.types.NodeSocket], flag: Flag) -> bpy.types.NodeSocket:
        """place: location of the output object with the flag."""
        return self.above(place[flag.axis], THRESHOLD)

    def is_unset(self, place: list[bpy.types.NodeSocket], flag: Flag) -> bpy.types.NodeSocket:
        return self.above(self.math("SUBTRACT", 1.0, place[flag.axis]), 1.0 - THRESHOLD)

    def embedded_position(self, geometry: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        return self.embedded([self.sample(geometry, self.named(name, "INT")) for name in CORNERS],
                             self.named(BARYCENTRIC, "FLOAT_VECTOR"), self.named(LOCAL_OFFSET, "FLOAT_VECTOR"))

    def played(self, fine: bpy.types.NodeSocket, clip: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """The shown mesh with the positions and attributes of a clip's points: see clip_file.points_of()."""
        index = self.index()
        fine = self.moved(fine, self.sample(clip, index))
        begin, counts = self.element_count(fine, "POINT"), {}
        for block in clip_file.blocks(self.attributes):
            # As floats: exact up to 2^24 points, four times the engine's limit.
            values = self.sample(clip, self.math("ADD", begin, index))
            if block.attributes[0].unit:  # between two samples the cache averages two unit vectors
                values = self.vector("NORMALIZE", values)
            parts = [values] if block.attributes[0].vector else self.components(values)
            for attribute, value in zip(block.attributes, parts):
                fine = self.store(fine, attribute.name, attribute.data_type, value, attribute.domain)
            if block.domain not in counts:
                counts[block.domain] = self.element_count(fine, block.domain)
            begin = self.math("ADD", begin, counts[block.domain])
        return fine

    def clip_points(self, carried: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """clip_file.point_count() of a mesh."""
        domains = [block.domain for block in clip_file.blocks(self.attributes)]
        points = self.math("MULTIPLY", self.element_count(carried, "POINT"), 1.0 + domains.count("POINT"))
        return self.math("MULTIPLY_ADD", self.element_count(carried, "CORNER"), float(domains.count("CORNER")), points)

    def store_base_position(self, geometry: bpy.types.NodeSocket, fine: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        return self.store(fine, BASE_POSITION, "FLOAT_VECTOR", self.sample(geometry, self.index()))

    def shown_here(self, fine: bpy.types.NodeSocket, baked: bpy.types.NodeSocket,
                   in_viewport: bpy.types.NodeOutputs) -> bpy.types.NodeSocket:
        """The mesh of viewports if this is a viewport, the mesh exists, its flag is not set and no clip is played;
        otherwise the fine mesh."""
        mesh, place = in_viewport["Geometry"], self.components(in_viewport["Location"])
        here = self.node("GeometryNodeIsViewport").outputs[0]
        for wanted in (self.above(self.element_count(mesh, "POINT"), 0.5), self.is_unset(place, Flag.RENDER_MESH),
                       self.above(self.math("SUBTRACT", 1.0, baked), 0.5)):
            here = self.both(here, wanted)
        return self.switch(here, fine, mesh)

    def proxy(self, geometry: bpy.types.NodeSocket, carried: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """The coarse mesh, moved by the displacements on the output object."""
        index = self.index()
        way = self.at(carried, self.named(PROXY_OFFSET, "FLOAT_VECTOR"), index)
        return self.moved(self.store(geometry, BASE_INDEX, "INT", index), self.added(self.position(), way))

    def uses_proxy(self, carried: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """Whether this is a viewport that shows the coarse mesh."""
        return self.both(self.node("GeometryNodeIsViewport").outputs[0],
                         self.above(self.largest(carried, self.named(SHOWS_PROXY, "INT")), 0.5))

    def coarse(self, geometry: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """The coarse mesh with the attributes that the first pass of a frame needs: see frame/first_pass.py."""
        index = self.index()
        numbered = self.store(geometry, BASE_INDEX, "INT", index)
        return self.store(numbered, BASE_POSITION, "FLOAT_VECTOR", self.position())

    def counts_match(self, geometry: bpy.types.NodeSocket, expected: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        compare = self.node("FunctionNodeCompare", data_type="INT", operation="EQUAL")
        self.link(self.element_count(geometry, "POINT"), compare, "A")
        self.link(expected, compare, "B")
        return compare.outputs[0]

    def build(self) -> None:
        inputs = self.node("NodeGroupInput").outputs
        geometry, output = inputs["Geometry"], self.object_info(inputs[OUTPUT])
        carried = self.shown_here(output["Geometry"], inputs[BAKED], self.object_info(inputs[VIEWPORT_OUTPUT]))
        clip = self.mesh_of(inputs[CACHE])
        # A clip with another number of points (or no clip) is not shown: the mesh follows the pose with its last
        # offsets.
        place = self.components(output["Location"])
        baked = self.both(inputs[BAKED], self.counts_match(clip, self.clip_points(carried)))
        baked = self.both(baked, self.is_unset(place, Flag.LIVE_FOLDS))
        # Switches evaluate only the branch they take, so a baked clip needs no embedding.
        live = self.switch(self.uses_proxy(carried), self.moved(carried, self.embedded_position(geometry)),
                           self.proxy(geometry, carried))
        fine = self.switch(baked, live, self.played(carried, clip))
        fine = self.store_base_position(geometry, fine)
        for name in OUTPUT_ONLY:
            fine = self.without(fine, name)
        fine = self.switch(self.is_set(place, Flag.COARSE_ONLY), fine, self.coarse(geometry))
        shown = self.switch(self.counts_match(geometry, inputs[COUNT]), geometry, fine)
        self.group.links.new(shown, self.node("NodeGroupOutput").inputs[0])

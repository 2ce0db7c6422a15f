# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulates a clip of truth_clip with Blender's Cloth.

Blender's cloth counts time in frames, has gravity's 9.81 as 0.00981 and gives each vertex the mass of the settings.
So gravity is set for the frame rate, and what matters is stiffness against the mass of a vertex. The values below
are those of a light cotton jersey at edges of about 8 mm: 0.2 % strain under its own weight from collar to hem.
How stiffly it bends is set as its bending length, metres, for Blender's stiffness depends on the mesh: strips of 8 cm
that hang over an edge (F. T. Peirce 1930) have BENDING * edge * (bending_stiffness / mass)^(1/3) at 30 frames a second,
with edges of 5, 8 and 10 mm, within a tenth.
Bending and its damping are explicit there: stable while 0.6 * bending_stiffness / mass / quality^2 is below about 1 and
1.3 * bending_damping * bending_stiffness / mass / quality below 1. Beyond that the cloth is crepe, then rags.
"""
from __future__ import annotations

import struct
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree
from truth_clip import Clip, Surface, triangles_of
from truth_pins import Hold, along_cloth, edges_of, hugging

GRAVITY = 9.81  # metres per second squared
REPORT_EVERY = 10
BORDER, SHALLOW = 0.05, 0.004  # metres from a hugging border to the inner surface's whole depth; its depth there
BENDING = 0.299  # measured: see above
UNSTABLE_STIFFNESS, UNSTABLE_DAMPING = 0.6, 1.3  # see above
CALM = 0.3  # damping of bending / the most that is stable
TOO_FAR = 0.5  # metres from the animated base: the simulation has exploded


@dataclass
class Fabric:
    """Settings of the simulation, by Blender's names."""

    quality: int = 8  # steps a frame, more if bending needs them
    mass: float = 0.05  # of a vertex
    tension_stiffness: float = 15.0
    compression_stiffness: float = 15.0
    shear_stiffness: float = 5.0
    bending_length: float = 0.022  # metres: cotton's, as of the add-on's settings
    hem_stiffness: float = 1.0  # of the last centimetre at borders, over the rest; real cloth lies double there
    tension_damping: float = 5.0
    compression_damping: float = 5.0
    shear_damping: float = 5.0
    air_damping: float = 0.05
    pin_stiffness: float = 0.1
    collision_quality: int = 3
    distance_min: float = 0.001  # metres
    self_collision: bool = True
    self_distance_min: float = 0.001  # metres
    self_friction: float = 1.0
    friction: float = 4.0  # of the body
    thickness: float = 0.002  # of the body, metres
    shrink: float = 0.014  # of the inner surface that stands in for a missing body, metres ...
    inner_thickness: float = 0.003  # ... and its thickness: the cloth stops at the difference

    def bending(self, edge: float, fps: float) -> tuple[float, int, float]:
        """For edges of this length (metres): Blender's bending stiffness, the steps a frame and the damping of bending
        for which it is stable."""
        ratio = (self.bending_length / (BENDING * edge)) ** 3 * (30.0 / fps) ** 2
        stiffest = ratio * max(self.hem_stiffness, 1.0)
        quality = max(self.quality, int(np.ceil(np.sqrt(UNSTABLE_STIFFNESS * stiffest))))
        return self.mass * ratio, quality, CALM * quality / (UNSTABLE_DAMPING * stiffest)

    def as_dict(self) -> dict[str, float]:
        """For the cache."""
        return asdict(self)


def write_pc2(path: Path, positions: np.ndarray) -> None:
    """positions (frames, n, 3) float32 as a point cache that Mesh Cache reads."""
    frames, points, _ = positions.shape
    with path.open("wb") as file:
        file.write(b"POINTCACHE2\0" + struct.pack("<iiffi", 1, points, 1.0, 1.0, frames))
        file.write(np.ascontiguousarray(positions, np.float32).tobytes())


def vertex_normals(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(n, 3) unit, weighted by area."""
    a, b, c = (positions[triangles[:, k]].astype(np.float64) for k in range(3))
    face = np.cross(b - a, c - a)
    normals = np.stack([np.bincount(triangles.ravel(), np.repeat(face[:, k], 3), len(positions)) for k in range(3)], 1)
    return normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-20)[:, None]


def room(inner: Surface, triangles: np.ndarray, bodies: list[Surface], fabric: Fabric) -> np.ndarray:
    """(n,) metres that the inner surface goes inwards: fabric.shrink, less near hugging borders,
    and where a body is nearer, so that what is left of it does not come through the cloth that lies beside it."""
    normals = vertex_normals(inner.rest, triangles)
    away = along_cloth(inner.rest, triangles, hugging(inner.rest, triangles, bodies[0].rest), BORDER)
    depth = SHALLOW + (fabric.shrink - SHALLOW) * np.minimum(away / BORDER, 1.0)
    for body in bodies:
        tree = BVHTree.FromPolygons(body.rest.tolist(), triangles_of(body.starts, body.corners)[0].tolist())
        for vertex, (point, normal) in enumerate(zip(inner.rest.tolist(), normals.tolist())):
            clearance = tree.ray_cast(point, [-x for x in normal], fabric.shrink)[3]
            if clearance is not None:
                depth[vertex] = min(depth[vertex], clearance + fabric.inner_thickness)
    edges, _ = edges_of(triangles)
    for _ in range(4):  # rises by at most 1.5 mm an edge
        for a, b in ((0, 1), (1, 0)):
            np.minimum.at(depth, edges[:, a], depth[edges[:, b]] + 0.0015)
    return depth


def shrunk(surface: Surface, bodies: list[Surface], fabric: Fabric) -> Surface:
    """The surface moved inwards along its normals, in every frame."""
    triangles, _ = triangles_of(surface.starts, surface.corners)
    depth = room(surface, triangles, bodies, fabric)[:, None]
    moved = [(p - depth * vertex_normals(p, triangles)).astype(np.float32) for p in surface.positions]
    return Surface(np.stack(moved), moved[0], surface.starts, surface.corners)


def moving_object(name: str, surface: Surface, folder: Path) -> bpy.types.Object:
    """A mesh object that Mesh Cache moves from frame 1 on."""
    mesh = bpy.data.meshes.new(name)
    ends = np.append(surface.starts, len(surface.corners))
    faces = [surface.corners[a:b].tolist() for a, b in zip(ends[:-1], ends[1:])]
    mesh.from_pydata(surface.positions[0].tolist(), [], faces)
    made = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(made)
    path = folder / f"{name}.pc2"
    write_pc2(path, surface.positions)
    motion = made.modifiers.new("Motion", "MESH_CACHE")
    motion.cache_format, motion.filepath = "PC2", str(path)
    motion.frame_start = 1.0
    return made


def add_collider(thing: bpy.types.Object, thickness: float, fabric: Fabric) -> None:
    """Make the cloth collide with an object. thickness in metres, outwards."""
    thing.modifiers.new("Collision", "COLLISION")
    thing.collision.thickness_outer = thickness
    thing.collision.thickness_inner = 0.02
    thing.collision.cloth_friction = fabric.friction


def add_group(thing: bpy.types.Object, name: str, weights: np.ndarray) -> str:
    """A vertex group from weights (n,); its name."""
    group = thing.vertex_groups.new(name=name)
    for vertex in np.flatnonzero(weights > 0.0).tolist():
        group.add([vertex], float(weights[vertex]), "REPLACE")
    return group.name


def vertex_spacing(surface: Surface) -> float:
    """Metres: root of the area at rest over the vertices."""
    triangles, _ = triangles_of(surface.starts, surface.corners)
    a, b, c = (surface.rest[triangles[:, k]].astype(np.float64) for k in range(3))
    return float(np.sqrt(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / len(surface.rest)))


def set_fabric(settings: bpy.types.ClothSettings, fabric: Fabric, edge: float, fps: float) -> None:
    """How it stretches, bends and is damped on a mesh with edges of this length (metres)."""
    settings.bending_model = "ANGULAR"
    for name in ("mass", "tension_stiffness", "compression_stiffness", "shear_stiffness", "tension_damping",
                 "compression_damping", "shear_damping", "air_damping", "pin_stiffness"):
        setattr(settings, name, getattr(fabric, name))
    stiffness, quality, damping = fabric.bending(edge, fps)
    for name, value in (("quality", quality), ("bending_stiffness", stiffness), ("bending_damping", damping),
                        ("tension_stiffness_max", fabric.tension_stiffness),
                        ("compression_stiffness_max", fabric.compression_stiffness),
                        ("shear_stiffness_max", fabric.shear_stiffness),
                        ("bending_stiffness_max", fabric.hem_stiffness * stiffness)):
        setattr(settings, name, value)


def set_gravity(scene: bpy.types.Scene, fps: float) -> None:
    scene.gravity = (0.0, 0.0, -GRAVITY * 1000.0 / fps ** 2)


def add_cloth(garment: bpy.types.Object, hold: Hold, fabric: Fabric, clip: Clip) -> None:
    """The Cloth modifier after the garment's motion."""
    cloth = garment.modifiers.new("Cloth", "CLOTH")
    settings, collisions = cloth.settings, cloth.collision_settings
    settings.vertex_group_mass = add_group(garment, "Pin", hold.pins ** 0.25)  # the solver takes the fourth power
    settings.vertex_group_bending = add_group(garment, "Hems", hold.hems)
    set_fabric(settings, fabric, vertex_spacing(clip.garment), clip.fps)
    collisions.use_collision, collisions.use_self_collision = True, fabric.self_collision
    for name in ("collision_quality", "distance_min", "self_distance_min", "self_friction"):
        setattr(collisions, name, getattr(fabric, name))
    cloth.point_cache.frame_start, cloth.point_cache.frame_end = 1, len(clip.garment.positions)


def build(clip: Clip, hold: Hold, fabric: Fabric, inner: bool, folder: Path) -> bpy.types.Object:
    """An empty scene with the garment under Cloth and what it collides with; the garment."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    total = len(clip.garment.positions)
    scene.frame_start, scene.frame_end = 1, total
    set_gravity(scene, clip.fps)
    if inner:
        lining = shrunk(clip.inner, clip.bodies, fabric)
        add_collider(moving_object("inner", lining, folder), fabric.inner_thickness, fabric)
    for number, body in enumerate(clip.bodies):
        add_collider(moving_object(f"body{number}", body, folder), fabric.thickness, fabric)
    garment = moving_object("garment", clip.garment, folder)
    add_cloth(garment, hold, fabric, clip)
    return garment


def simulate(garment: bpy.types.Object, clip: Clip, say: Callable[[str], None]) -> tuple[np.ndarray, float]:
    """Plays every frame. The clip's positions (frames, n, 3), without the lead, and processor seconds a frame."""
    kept = []
    total = len(clip.garment.positions)
    began, worked = time.perf_counter(), time.process_time()
    flat = np.empty(clip.garment.rest.size, np.float32)
    for number in range(total):
        bpy.context.scene.frame_set(number + 1)
        shown = garment.evaluated_get(bpy.context.evaluated_depsgraph_get())
        shown.data.vertices.foreach_get("co", flat)
        positions = flat.reshape(-1, 3).copy()
        away = np.linalg.norm(positions - clip.garment.positions[number], axis=1)
        if not np.isfinite(positions).all() or away.max() > TOO_FAR:
            raise SystemExit(f"the cloth exploded at frame {clip.frames[0] + number - clip.lead}")
        if number % REPORT_EVERY == 0 or number == total - 1:
            spent = (time.perf_counter() - began) / (number + 1)
            say(f"frame {clip.frames[0] + number - clip.lead} of {clip.frames[-1]}: {spent:.2f} s a frame "
                f"({(time.process_time() - worked) / (number + 1):.2f} of the processor), "
                f"from the base {1e3 * away.mean():.1f} mm, at most {1e3 * away.max():.0f} mm")
        if number >= clip.lead:
            kept.append(positions)
    return np.stack(kept), (time.process_time() - worked) / total

# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of every system: default, range, unit and tooltip, each defined only here.

The Blender properties are made from these fields (blender/objects/properties.py), and the native settings are filled
from them (core/systems/wrinkle_mesh.py and the other systems).
"""
from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from .cloth_settings import ClothSettings, Draped
from .setting import setting

SOURCES = (
    ("SUBDIVISION", "Subdivision", "Refine the mesh smoothly: Catmull-Clark for quads, Loop for triangles"),
    ("REGULAR", "Regular Split", "Split every triangle into a regular grid of triangles"),
    ("EDGE_LENGTH", "Edge Length", "Split the longest edges until all are short enough"),
    ("OBJECT", "Custom Mesh", "A fine mesh of your own, of any topology, bound to the closest points at rest"),
)
DENSITIES = (
    ("WAVELENGTH", "Wavelength", "The fold width you want chooses the density"),
    ("LEVEL", "Level", "The density is set by hand"),
)
ATTACHMENTS = (
    ("LIMIT", "Smooth Surface", "Folds ride on the smooth subdivision surface of the mesh: no facets"),
    ("PN", "PN Triangles", "Folds ride on curved PN triangles, as in the paper: cheap, nearly smooth"),
    ("LINEAR", "Flat Triangles", "Folds ride on the flat triangles: shows the facets of a coarse mesh"),
)
REST_SHAPES = (
    ("REST_POSE", "Rest Pose", "The mesh without its modifiers is the unwrinkled cloth"),
    ("FRAME", "Frame", "The shape captured at a chosen frame is the unwrinkled cloth"),
    ("SHAPE_KEY", "Shape Key", "A shape key is the unwrinkled cloth"),
)
ADAPTING_REST_SHAPES = REST_SHAPES + (
    ("ADAPTIVE", "Adaptive", "A shape that lasts becomes the unwrinkled cloth: for animation without a good rest pose"),
)
STARTS_FROM = (
    ("REST", "Rest Pose", "The mesh without its modifiers"),
    ("FIRST_FRAME", "First Frame", "The clip's first frame: no rest pose is needed"),
)
OFFSET_SPACES = (
    ("TRIANGLE", "Surface", "Folds turn with the surface: a spinning dancer keeps the same folds"),
    ("WORLD", "World Space", "Folds keep their direction in the world, as the paper has it"),
)
COLLISIONS = (
    ("PLANE", "Plane", "Folds stay outside a plane just inside the surface: fast"),
    ("NEIGHBOURHOOD", "Neighbourhood", "Folds stay outside the nearby triangles of the mesh: better in tight bends"),
    ("NONE", "None", "Folds may go inward as far as outward"),
)


@dataclass
class AdaptiveRest:
    """Settings of adaptive rest shapes (chapter 4 of the Wrinkle Paths' thesis), the same in every system."""

    reference: str = setting("REST", "Starts From", "What counts as unwrinkled before anything has lasted",
                             choices=STARTS_FROM)
    window: float = setting(0.1, "Time Window", "How far back in time a pose is compared with, to tell whether cloth "
                            "is being compressed or stretched", low=0.0, high=2.0, unit="SECONDS")
    relaxation: float = setting(0.01, "Relaxation", "How fast the unwrinkled shape follows a shape that stays "
                                "compressed: the share that it takes over in a thirtieth of a second", low=0.0,
                                high=1.0)
    growth: float = setting(1.05, "Growth", "How much longer than at rest the unwrinkled shape may become, as a factor",
                            low=1.0, high=10.0)

    # self: the settings of a system, which define rest_shape, stateless and base_cloth.
    @property
    def adapts(self: Any) -> bool:
        """Whether the rest shape changes with time. Independent frames have no time, so they use the rest pose."""
        return self.rest_shape == "ADAPTIVE" and not self.stateless

    @property
    def reads_time(self: Any) -> bool:
        """Whether the frames depend on the frame rate."""
        return self.adapts or self.swings

    @property
    def sees_ahead(self: Any) -> bool:
        """Whether a bake may analyse the whole clip first. It cannot with a base cloth, because the positions of the
        cloth are not known before it is solved."""
        return self.adapts and self.base_cloth == "OFF"

    def fill_reference(self, options: Any) -> None:
        """Copy these settings into native settings."""
        for name in ("window", "relaxation", "growth"):
            setattr(options, name, getattr(self, name))
        options.reference = self.reference if self.adapts else "STATIC_REST"


def reference_settings(settings: Any) -> tuple[str, ...]:
    """Names of the settings of adaptive rest shapes that currently have an effect, in the order of panels. settings: of
    Wrinkle Paths, or with an adaptive rest shape; the dataclass or Blender's property group."""
    if settings.stateless:
        return ()
    relaxation = () if settings.reference == "STATIC_REST" else ("relaxation",)
    growth = ("growth",) if settings.reference == "REST" else ()
    # also needed with STATIC_REST, because folds turn as cloth moves
    return ("reference", *relaxation, *growth, "window")


LAYERS = (
    ("ONE", "One", "One fine mesh with folds of one size, as in the paper"),
    ("CLOTH", "Cloth", "Wide folds first, finer ones on them: Drape, Folds and Detail"),
)


@dataclass
class Parts:
    """Settings about which parts of a mesh are cloth, the same in every system."""

    rigid_parts: bool = setting(True, "Rigid Parts", "Loose parts that are small or solid, such as buttons, buckles "
                                "and pouches, are not cloth: they keep their shape and ride on the cloth around them. "
                                "Skin in the mesh of its clothes, such as head and hands, and helmets stay where they "
                                "are animated", affects="MESH")


@dataclass
class MeshSettings(AdaptiveRest, ClothSettings, Parts):
    """Settings of one Wrinkle Mesh. Lengths are metres in world scale unless the unit says otherwise."""

    # Folds of several sizes
    layers: str = setting("ONE", "Layers", "How many sizes of folds there are", choices=LAYERS, affects="MESH")
    drape: float = setting(1.0, "Drape", "The widest folds, of the coarse mesh itself", low=0.0, high=2.0, soft=1.0,
                           unit="FACTOR")
    folds: float = setting(1.0, "Folds", "Folds twice as wide as the detail", low=0.0, high=2.0, soft=1.0,
                           unit="FACTOR")
    detail: float = setting(1.0, "Detail", "The finest folds, as wide as the wavelength", low=0.0, high=2.0, soft=1.0,
                            unit="FACTOR")
    # The fine mesh (section 3 of the paper)
    source: str = setting("SUBDIVISION", "Fine Mesh", "How the fine mesh is made", choices=SOURCES, affects="MESH")
    density: str = setting("WAVELENGTH", "Density By", "What chooses the density", choices=DENSITIES, affects="MESH")
    wavelength: float = setting(0.04, "Wavelength", "Distance from fold to fold. Halving it makes the solve four "
                                "times as heavy", low=0.0001, high=10.0, unit="LENGTH", affects="MESH")
    level: int = setting(2, "Level", "Subdivisions that are solved. Each makes folds half as wide and the solve four "
                         "times as heavy", low=0, high=5, affects="MESH")
    segments: int = setting(4, "Segments", "Pieces along each edge of a triangle", low=1, high=32, affects="MESH")
    edge_length: float = setting(0.01, "Longest Edge", "No edge of the fine mesh is longer", low=0.0001, high=10.0,
                                 unit="LENGTH", affects="MESH")
    display_steps: int = setting(1, "Smoothing Steps", "Subdivisions of the solved mesh that are shown, not solved. "
                                 "One removes the facets; more cost memory", low=0, high=2, affects="MESH")
    weld: bool = setting(True, "Weld Seams", "Join vertices that stand at one place on open edges, so that no seam of "
                         "a game mesh tears", affects="MESH")
    # The rest shape
    rest_shape: str = setting("REST_POSE", "Rest Shape", "What counts as unwrinkled", choices=ADAPTING_REST_SHAPES,
                              affects="MESH")
    # Attachment (section 4)
    attachment: str = setting("LIMIT", "Attach To", "The surface that folds ride on", choices=ATTACHMENTS,
                              affects="MESH")
    # Constraints (sections 3.1 and 4.1)
    radius: float = setting(1.0, "Radius", "How far a point may leave the surface, in lengths of the fine "
                            "edges around it. Higher folds; above 0.5 folds may touch themselves",
                            low=0.0, high=10.0, soft=3.0)
    prestretch: float = setting(1.0, "Pre-Stretch", "Rest length of the fine edges, as a factor. Below 1 "
                                "only strong compression folds; above 1 the cloth is wrinkled even at rest",
                                low=0.5, high=1.5)
    bending: float = setting(0.7, "Bend Stiffness", "0 crumples like paper tissue, 1 makes broad round folds",
                             low=0.0, high=1.0)
    collision: str = setting("PLANE", "Collision", "What keeps folds out of the body", choices=COLLISIONS)
    inside: float = setting(0.4, "Inner Depth", "How far folds may go inward, as a share of the attachment radius. "
                            "0 looks like rubber; at 1 the skin may show through", low=0.0, high=1.0, unit="FACTOR")
    stretch_relief: float = setting(0.3, "Stretch Relief", "Share of the stretch of the mesh that the cloth takes "
                                    "over. 0 pulls diagonal folds strongest, 1 never pulls", low=0.0, high=1.0,
                                    unit="FACTOR")
    buckling_threshold: float = setting(0.0, "Buckling Limit", "Share of its length by which the mesh may be "
                                        "compressed before folds form. A simulated garment is a little compressed "
                                        "everywhere", low=0.0, high=1.0,
                                        soft=0.1, unit="FACTOR")
    compression_limit: float = setting(1.3, "Max Gather Ratio", "How much longer than the compressed mesh the cloth in "
                                       "its folds may be, as a factor. Keeps folds of collapsed knees and elbows low",
                                       low=1.0, high=10.0)
    hem_rings: int = setting(3, "Hem Fade", "Rings of fine vertices at open borders over which folds fade out",
                             low=0, high=20)
    # The solver
    iterations: int = setting(10, "Iterations", "Solver passes per frame. More: sharper folds, more time, less calm",
                              low=0, high=200)
    start_iterations: int = setting(20, "First Iterations", "Solver passes of a frame that starts from no other",
                                    low=0, high=500)
    damping: float = setting(0.3, "Damping", "Share of the previous frame's folds that is kept. Calms fast motion",
                             low=0.0, high=0.95, unit="FACTOR")
    stateless: bool = setting(False, "Independent Frames", "Every frame is solved on its own: the same on any "
                              "machine and in any order, but folds jump more")
    offset_space: str = setting("TRIANGLE", "Folds Turn With", "What folds keep their direction to",
                                choices=OFFSET_SPACES)
    nudge: float = setting(0.02, "Perturbation", "Random offset, in fine edges, from which a flat compressed sheet "
                           "buckles", low=0.0, high=1.0)
    seed: int = setting(0, "Seed", "Of the random numbers: another seed gives other folds", low=0, high=2**31 - 1)

    @property
    def layered(self) -> bool:
        """Whether there are several layers. They need subdivision. An adaptive rest shape supports only one layer."""
        return self.layers == "CLOTH" and self.source == "SUBDIVISION" and self.rest_shape != "ADAPTIVE"

    def structural(self) -> dict[str, Any]:
        """The settings that the shown mesh is made from."""
        return {f.name: getattr(self, f.name) for f in fields(self) if f.metadata["affects"] == "MESH"}


OUTPUTS = (
    ("SHADING", "Shading", "The mesh keeps its triangles: the waves are drawn per pixel by its materials"),
    ("GEOMETRY", "Geometry", "A fine mesh is displaced by the waves: silhouettes, shadows and export"),
)
FIELD_SOURCES = (SOURCES[0], SOURCES[2])
PROFILES = (
    ("SINE", "Sine", "Round crests and round valleys"),
    ("ACCORDION", "Accordion Pleats", "Straight flanks and sharp edges"),
    ("PENCIL_PLEATS", "Pencil Pleats", "Round crests and sharp valleys"),
    ("CURVE", "Curve", "Half a wave that you draw, from crest to valley"),
)
STARTS = (
    ("ALIGNED", "Aligned", "The first waves agree over the whole mesh before they are relaxed"),
    ("RANDOM", "Random", "The first waves are relaxed from random phases, as in the paper: more forks"),
)


@dataclass
class FieldSettings(AdaptiveRest, Draped, ClothSettings, Parts):
    """Settings of one Wrinkle Field. Lengths are metres in world scale unless the unit says otherwise."""

    output: str = setting("SHADING", "Output", "What shows the waves", choices=OUTPUTS, affects="MESH")
    # The waves (sections 4 and 5 of the paper)
    wavelength: float = setting(0.05, "Wavelength", "Distance from fold to fold in the unwrinkled cloth. Folds grow in "
                                "height with it", low=0.0001, high=10.0, unit="LENGTH")
    strength: float = setting(1.0, "Strength", "Height of the folds. 1 keeps the length of the cloth", low=0.0,
                              high=10.0, soft=2.0)
    buckling_threshold: float = setting(0.0, "Buckling Limit", "Share of its length by which cloth may be compressed "
                                        "before waves form. What is painted stays", low=0.0, high=0.9, soft=0.1,
                                        unit="FACTOR")
    keep_length: bool = setting(True, "Keep Length", "Geometry only: limits the height, so that the cloth across the "
                                "folds is no longer than at rest")
    dissolve: bool = setting(True, "Dissolve Forks", "Waves sink where they fork or run across one another, instead of "
                             "breaking into scales")
    profile: str = setting("SINE", "Profile", "The shape of a fold", choices=PROFILES,
                           affects="MESH")
    irregularity: float = setting(0.0, "Irregularity", "0 is tidy cloth, 1 is disturbed like skin: direction and width "
                                  "of the folds wander", low=0.0, high=1.0, unit="FACTOR")
    rate: float = setting(0.5, "Relaxation Rate", "How far a round aligns neighbouring waves. Less: smoother "
                          "motion", low=0.0, high=0.99, unit="FACTOR")
    rounds: int = setting(1, "Rounds", "Relaxation passes per frame. More: waves align sooner, and move more", low=0,
                          high=100)
    start: str = setting("ALIGNED", "Start", "The waves of the first frame, and after a jump", choices=STARTS)
    start_rounds: int = setting(200, "Rounds At Start", "Relaxation passes of a frame that starts from no other",
                                low=0, high=2000)
    seed: int = setting(0, "Seed", "Of the random numbers: another seed gives other folds", low=0, high=2**31 - 1)
    stateless: bool = setting(False, "Independent Frames", "Every frame is solved on its own: the same on any "
                              "machine and in any order, but folds jump")
    # What is painted
    mask: str = setting("Rumple Mask", "Mask", "Vertex group or float attribute: how high folds may be, from 0 to 1",
                        affects="PAINT")
    wavelength_scale: str = setting("Rumple Wavelength", "Wavelength Scale", "Vertex group or float attribute that "
                                    "scales the wavelength", affects="PAINT")
    # The shown mesh
    source: str = setting("SUBDIVISION", "Fine Mesh", "How the fine mesh is made", choices=FIELD_SOURCES,
                          affects="MESH")
    detail: int = setting(8, "Points per Fold", "Points of the fine mesh from fold to fold", low=2, high=32,
                          affects="MESH")
    attachment: str = setting("LIMIT", "Attach To", "The surface that folds ride on", choices=ATTACHMENTS,
                              affects="MESH")
    weld: bool = setting(True, "Weld Seams", "Join vertices that stand at one place on open edges, so that waves run "
                         "on over the seams of a game mesh", affects="MESH")
    rest_shape: str = setting("REST_POSE", "Rest Shape", "What counts as unwrinkled", choices=ADAPTING_REST_SHAPES,
                              affects="MESH")

    def structural(self) -> dict[str, Any]:
        """The settings that the shown mesh depends on. With the output SHADING it is the coarse mesh itself."""
        names = ["output", "weld", "rigid_parts", "rest_shape"]
        if self.output == "GEOMETRY":
            names += ["wavelength", "source", "detail", "attachment"]
        return {name: getattr(self, name) for name in names}


REFERENCES = (
    ("REST", "Adaptive, From Rest", "Starts from the rest shape and slowly takes over shapes that last"),
    ("FIRST_FRAME", "Adaptive, From First Frame", "Starts from the first frame: for animation without a rest pose"),
    ("STATIC_REST", "Rest", "Always the rest shape: every frame measures alike"),
)
DIRECTIONS = (
    ("OUTWARD", "Outward", "Folds stand out of the surface"),
    ("INWARD", "Inward", "Folds are creases in the surface"),
    ("BOTH", "Both", "Every second fold is a crease"),
)
PATH_PROFILES = (
    ("SPLINE", "B-Spline", "Round, as cloth: a quadratic B-spline"),
    ("QUARTIC", "Quartic", "Round crest, flat feet"),
    ("CIRCULAR_ARCS", "Circular Arcs", "Arcs of equal radius at the crest and at both feet"),
    ("SINE", "Sine", "One wave of a cosine"),
)


@dataclass
class PathsSettings(AdaptiveRest, Draped, ClothSettings, Parts):
    """Settings of the Wrinkle Paths. Lengths are metres in world scale unless the unit says otherwise."""

    # Where folds are (chapters 4 and 5 of the thesis)
    width: float = setting(0.02, "Width", "Width of the tightest folds. Weaker compression makes them wider",
                           low=0.0001, high=10.0, unit="LENGTH", affects="MESH")
    threshold: float = setting(1.25, "Threshold", "How strongly the cloth must be compressed for a fold to start: rest "
                               "length divided by length. Nearer to 1: more folds", low=1.01, high=5.0, soft=2.0)
    reach: float = setting(0.25, "Reach", "Share of the starting compression at which a fold ends. Less: longer folds",
                           low=0.0, high=1.0, unit="FACTOR")
    spacing: float = setting(1.12, "Spacing", "Least distance of a new fold from others, in widths", low=0.5, high=10.0)
    alignment: float = setting(0.4, "Turning", "Low: folds stay where they started on the cloth. High: they turn "
                               "across the compression", low=0.0, high=10.0, soft=2.0)
    growth_limit: float = setting(0.15, "Growth Limit", "Most change of a fold's length in a thirtieth of a second",
                                  low=0.0, high=1.0, unit="FACTOR")
    fade: float = setting(0.15, "Fade", "Time in which a fold rises and sinks", low=0.0, high=5.0, unit="SECONDS")
    hem_rings: int = setting(2, "Hem Fade", "Rings of the mesh at open borders over which folds fade out", low=0,
                             high=20)
    seed: int = setting(0, "Seed", "Of the random numbers: another seed gives other folds", low=0, high=2**31 - 1)
    stateless: bool = setting(False, "Independent Frames", "Every frame is traced on its own: the same on any "
                              "machine and in any order, but folds jump")
    # What compression is measured against (section 4.2)
    reference: str = setting("REST", "Measured Against", "What counts as uncompressed", choices=REFERENCES)
    smoothing: float = setting(0.1, "Smoothing", "Time over which compression is smoothed: noise makes no folds",
                               low=0.0, high=2.0, unit="SECONDS")
    # What they look like (chapter 6)
    height: float = setting(1.0, "Height", "Height of the folds. 1 keeps the length of the cloth", low=0.0, high=10.0,
                            soft=2.0)
    direction: str = setting("OUTWARD", "Direction", "The side that folds stand out to", choices=DIRECTIONS)
    profile: str = setting("SPLINE", "Profile", "The shape of a fold", choices=PATH_PROFILES)
    mask: str = setting("Rumple Mask", "Mask", "Vertex group or float attribute: where folds may start, from 0 to 1",
                        affects="PAINT")
    # The shown mesh
    source: str = setting("SUBDIVISION", "Fine Mesh", "How the fine mesh is made", choices=FIELD_SOURCES,
                          affects="MESH")
    detail: int = setting(5, "Edges per Fold", "Edges of the fine mesh across the tightest folds, at least. With "
                          "fewer, crests look sawn; twice as many cost four times the vertices", low=2, high=32,
                          affects="MESH")
    attachment: str = setting("LIMIT", "Attach To", "The surface that folds ride on", choices=ATTACHMENTS,
                              affects="MESH")
    weld: bool = setting(True, "Weld Seams", "Join vertices that stand at one place on open edges, so that folds run "
                         "on over the seams of a game mesh", affects="MESH")
    rest_shape: str = setting("REST_POSE", "Rest Shape", "What counts as unwrinkled", choices=REST_SHAPES,
                              affects="MESH")

    # self: of a system: rest_shape, stateless and base_cloth are its own.
    @property
    def adapts(self: Any) -> bool:
        return self.reference != "STATIC_REST" and not self.stateless

    @property
    def reads_time(self) -> bool:
        return True  # folds move

    def structural(self) -> dict[str, Any]:
        """The settings that the shown mesh is made from."""
        return {f.name: getattr(self, f.name) for f in fields(self) if f.metadata["affects"] == "MESH"}


SystemSettings = MeshSettings | FieldSettings | PathsSettings

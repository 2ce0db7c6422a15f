// SPDX-License-Identifier: GPL-3.0-or-later
// The coarse base mesh, the mesh that is shown in its place, a frame of it, and how a pose is given.
#ifndef RUMPLE_SURFACE_H
#define RUMPLE_SURFACE_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

// ---- the base mesh

// A checked base mesh at rest. Below, n is the number of its vertices, t that of its triangles, and w that of
// its welded vertices: those of a seam at one place count as one.
typedef struct rumple_surface rumple_surface;

// Polygons: number p owns the corners from polygon_start[p] to polygon_start[p + 1] - 1.
typedef struct rumple_surface_plan {
    const float* positions_rest;  // (n, 3), object space, finite
    size_t positions_rest_count;
    const int32_t* polygon_start;  // (polygons + 1), ascending from 0 to the number of corners
    size_t polygon_start_count;
    const int32_t* corner_vertex;  // (corners), 0..n - 1
    size_t corner_vertex_count;
    const int32_t* triangle_corner;  // (t, 3): corners of one polygon each, which has two corners more
    size_t triangle_corner_count;
    bool weld_seams;  // join border vertices that stand at one place
    // Of k edges, those that subdivision rounds less; read by rumple_surface_build(). Where there is no edge
    // of two polygons between the vertices, nothing is creased: borders are sharp as they are.
    const int32_t* crease_edge;  // (k, 2): vertices, 0..n - 1; or none
    size_t crease_edge_count;
    const float* crease_sharpness;  // (k): subdivisions that it stays sharp for, >= 0; from 10 on for ever
    size_t crease_sharpness_count;
} rumple_surface_plan;
RUMPLE_API rumple_surface_plan rumple_surface_plan_default(void);

// A mesh that is no oriented manifold, as one that rumple_surface_build() takes.
typedef struct rumple_healed rumple_healed;

// Needs no more than finite positions, indices in range and polygons of three corners or more. What it does:
// polygons that lie on others are left out; where an edge has more than two, those stay joined that continue
// one another best, and the others are cut off (Gueziec, Taubin, Lazarus and Horn 2001); polygons are wound
// as the larger area of their part, across seams as well where `plan` has them joined; a part with one side
// only is cut. Cost: O(corners log corners).
RUMPLE_API rumple_status rumple_healed_build(const rumple_surface_plan* plan, rumple_healed** healed);
RUMPLE_API void rumple_healed_free(rumple_healed* healed);

// n: its vertices: those of the mesh, then copies of some of them. p: its polygons, c: their corners.
typedef struct rumple_healed_view {
    int32_t vertex_count;    // n
    int32_t polygon_count;   // p
    int32_t corner_count;    // c
    int32_t triangle_count;  // t
    int32_t turned_count;
    int32_t cut_count;
    int32_t doubled_count;
    int32_t repeated_count;

    const int32_t* polygon_start;    // (p + 1)
    const int32_t* corner_vertex;    // (c)
    const int32_t* triangle_corner;  // (t, 3)
    const int32_t* vertex_source;    // (n): vertex of the mesh
    const int32_t* corner_source;    // (c): corner of the mesh
    const int32_t* polygon_source;   // (p): polygon of the mesh

    const int32_t* turned;    // (turned_count): polygons of the mesh that are wound the other way
    const int32_t* cut;       // (cut_count, 2): edges of the mesh at which polygons were cut off
    const int32_t* doubled;   // (doubled_count, 2): a polygon that was left out, and the one it lies on
    const int32_t* repeated;  // (repeated_count): polygons that use a vertex twice
} rumple_healed_view;
RUMPLE_API rumple_status rumple_healed_get_view(const rumple_healed* healed, rumple_healed_view* view);

// Checks a mesh, joins its seams and collects its edges. Refused, with the first bad element named: what is
// not finite, an index out of range, no face, an edge with three polygons, neighbours of opposite winding, a
// vertex twice in a polygon. Tolerated with a warning: loose vertices, bow ties, triangles without area.
// Cost: O(corners log corners).
RUMPLE_API rumple_status rumple_surface_build(const rumple_surface_plan* plan, rumple_surface** surface);
RUMPLE_API void rumple_surface_free(rumple_surface* surface);

typedef struct rumple_surface_view {
    int32_t vertex_count;         // n
    int32_t welded_vertex_count;  // w
    int32_t triangle_count;       // t
    int32_t warning_count;
} rumple_surface_view;
RUMPLE_API rumple_status rumple_surface_get_view(const rumple_surface* surface, rumple_surface_view* view);

// What was tolerated, in words, UTF-8, valid as long as the surface. number: 0..warning_count - 1; else NULL.
RUMPLE_API const char* rumple_surface_warning(const rumple_surface* surface, int32_t number);

// How many openings a garment has, of its connected parts the one with most: open borders that are not the
// outline of a sheet. A shirt has four, a head one, and so have a head, two arms and two feet; a skirt two: a
// wide hem in a part with a waist is no outline. Cost: O(edges log edges).
RUMPLE_API rumple_status rumple_surface_count_openings(const rumple_surface* surface, int32_t* openings);

// Of a garment whose thickness was modelled, its outer side, which is the cloth; what it does, the inner side
// and the rims do with it. outer: (polygons), written: 1 for those of the outer side, and of parts without an
// inner one; thickness: written, object units, the median; 0 where none is modelled, and outer is 1
// everywhere: so is a mesh of which less than three tenths is an inner side. A side lies on the other one at
// less than a fiftieth of the mesh's diagonal. Cost: about 0.5 us a polygon.
RUMPLE_API rumple_status rumple_surface_outer_side(const rumple_surface* surface, uint8_t* outer,
                                                   size_t outer_count, float* thickness);

// How firmly every vertex follows the animation, 0 (free) to 1 (pinned), found from the open borders at rest:
// collars, waistbands, cuffs. up: unit, object space. follow: (n), written. Cost: O(edges log edges).
RUMPLE_API rumple_status rumple_surface_suggest_follow(const rumple_surface* surface, const float up[3],
                                                       float* follow, size_t follow_count);

// ---- a coarse mesh that stands for a dense one

// Its smooth surface runs through the dense mesh: what is wide is solved on few vertices, whatever the
// density that was modelled. Peyre and Cohen 2006. m vertices.
typedef struct rumple_coarse rumple_coarse;

// spacing: about the mean length of its edges, object units, > 0. Refused where the mesh is too small for it.
// Cost: 20 ms for 10,000 vertices.
RUMPLE_API rumple_status rumple_coarse_build(const rumple_surface* dense, float spacing,
                                             rumple_coarse** coarse);
// The same for a part of the dense mesh, as its outer side is: a surface of some of its polygons over all of
// its vertices.
RUMPLE_API rumple_status rumple_coarse_build_of(const rumple_surface* dense, const rumple_surface* part,
                                                float spacing, rumple_coarse** coarse);
RUMPLE_API void rumple_coarse_free(rumple_coarse* coarse);

typedef struct rumple_coarse_view {
    int32_t vertex_count;         // m
    float mean_edge;              // mean length of its edges, object units
    const int32_t* dense_vertex;  // (m): of every vertex a vertex of the dense mesh
} rumple_coarse_view;
RUMPLE_API rumple_status rumple_coarse_get_view(const rumple_coarse* coarse, rumple_coarse_view* view);

// The coarse mesh as a base: triangles.
RUMPLE_API rumple_status rumple_coarse_surface(const rumple_coarse* coarse, rumple_surface** surface);

// positions: (n, 3) of the dense mesh. out: (m, 3), written: such that the smooth surfaces lie on one
// another.
RUMPLE_API rumple_status rumple_coarse_positions(const rumple_coarse* coarse, const float* positions,
                                                 size_t positions_count, float* out, size_t out_count);

// ---- how a fine mesh is made over the base

typedef enum rumple_fine_source {
    RUMPLE_FINE_SUBDIVISION = 0,  // `level` times: Loop for triangles alone, else Catmull and Clark
    RUMPLE_FINE_REGULAR = 1,      // every edge cut into `segments`
    RUMPLE_FINE_EDGE_LENGTH = 2,  // edges are halved until none is longer than `longest_edge`
    RUMPLE_FINE_OBJECT = 3        // a mesh of its own: Wrinkle Mesh only
} rumple_fine_source;

typedef enum rumple_attachment {
    RUMPLE_ATTACH_LINEAR = 0,  // to the triangles
    RUMPLE_ATTACH_PN = 1,      // to PN triangles, Vlachos et al. 2001
    RUMPLE_ATTACH_LIMIT = 2    // to the limit surface of subdivision
} rumple_attachment;

typedef struct rumple_fine_plan {
    int32_t source;         // rumple_fine_source
    int32_t level;          // >= 0
    int32_t segments;       // >= 1
    float longest_edge;     // object units, > 0
    int32_t most_vertices;  // a fine mesh with more is refused
    int32_t attachment;     // rumple_attachment: what the fine vertices are tied to
} rumple_fine_plan;

// ---- the shown mesh

// The mesh that is shown in place of the base: d vertices, q polygons. Borrowed from a model, and valid as
// long as that is. Its source is the base, or the own mesh of RUMPLE_FINE_OBJECT.
typedef struct rumple_shown_mesh rumple_shown_mesh;

typedef struct rumple_shown_mesh_view {
    int32_t vertex_count;   // d
    int32_t polygon_count;  // q
    int32_t corner_count;   // k
    int32_t edge_count;     // e

    const int32_t* polygon_start;    // (q + 1): the first corner of every polygon, then k
    const int32_t* corner_vertex;    // (k)
    const int32_t* polygon_source;   // (q): polygon of the source
    const int32_t* edges;            // (e, 2): vertices of the shown edges that lie on an edge of the source
    const int32_t* edge_sources;     // (e, 2): the vertices of that edge
    const float* positions_rest;     // (d, 3), object space
    const int32_t* triangle_vertex;  // (d, 3): the base's vertices that every shown vertex is embedded in
    const float* barycentric;        // (d, 2): weights of the second and third of them
} rumple_shown_mesh_view;
RUMPLE_API rumple_status rumple_shown_mesh_get_view(const rumple_shown_mesh* mesh,
                                                    rumple_shown_mesh_view* view);

// Values of the source's vertices, (rows, columns), to the shown mesh: linear. out: (d, columns), written.
RUMPLE_API rumple_status rumple_shown_mesh_carry_points(const rumple_shown_mesh* mesh, const float* values,
                                                        size_t values_count, int32_t columns, float* out,
                                                        size_t out_count);
// The same for corners: (rows, columns) of the source's to (k, columns); seams of a UV map stay sharp.
RUMPLE_API rumple_status rumple_shown_mesh_carry_corners(const rumple_shown_mesh* mesh, const float* values,
                                                         size_t values_count, int32_t columns, float* out,
                                                         size_t out_count);

// ---- rigid parts

// The rigid motion that is nearest, in the least squares, to what moved the points of each part: Mueller et
// al. 2016, A Robust Method to Extract the Rotational Part of Deformations. What points leave open (there are
// none, or they lie along a line) is not turned; points that did not move give the identity to the bit.
//   starts: (parts + 1): the first point of each part, ascending from 0, and last the number of points.
//   from, to: (points, 3), finite, one space and one unit.
//   motions: (parts, 12), written: the rotation R, (3, 3) row by row, then the translation t; p goes to
//   R p + t.
// Cost: O(points).
RUMPLE_API rumple_status rumple_rigid_motions(const int32_t* starts, size_t starts_count, const float* from,
                                              size_t from_count, const float* to, size_t to_count,
                                              float* motions, size_t motions_count);

// ---- a frame

// The base in one frame: rumple_X_pose_build() makes the pose of a model of it. What a system does not read
// may be left as it is.
typedef struct rumple_pose {
    const float* positions;  // (n, 3): the deformed base, object space, finite
    size_t positions_count;
    double time;  // s: the frame number over the frame rate; read where a rest shape adapts
    // Of rumple_X_label_clip(): 0 compress, 1 rest, 2 stretch. None: labels are cut in this frame.
    const uint8_t* labels;  // (t), or none
    size_t labels_count;
    const float* next_positions;  // (n, 3): the frame to come, to look ahead when labels are cut; or none
    size_t next_positions_count;
    double next_time;            // s, > time, where there is a next frame
    float world_from_object[9];  // (3, 3); read by the Wrinkle Mesh with RUMPLE_OFFSETS_WORLD
} rumple_pose;
RUMPLE_API rumple_pose rumple_pose_default(void);

// The shown mesh of one frame, of any system.
typedef struct rumple_frame rumple_frame;
RUMPLE_API void rumple_frame_free(rumple_frame* frame);

typedef struct rumple_frame_view {
    int32_t vertex_count;       // d
    const float* positions;     // (d, 3), object space
    const float* local_offset;  // (d, 3): from the linear embedding, in the frame of the deformed triangle
    const float* offset;        // (d, 3): from the unwrinkled surface, object space
    const float* stretch_min;   // (d): smaller principal stretch of the base, 1 at rest
    const float* stretch_max;   // (d): the larger one
    const float* stretch_direction;  // (d, 3): of strongest compression, unit, object space
} rumple_frame_view;
RUMPLE_API rumple_status rumple_frame_get_view(const rumple_frame* frame, rumple_frame_view* view);

// Embeds a frame in other positions of the base, (n, 3): its local_offset anew, where it lies already. For
// what was solved over a base cloth and is shown over the animated mesh. Cost: O(triangles + shown vertices).
RUMPLE_API rumple_status rumple_frame_embed(rumple_frame* frame, const float* positions,
                                            size_t positions_count);

// ---- rest shapes that adapt: Gillette 2015, chapter 4

typedef enum rumple_reference {
    RUMPLE_REFERENCE_REST = 0,         // from the rest pose, adapting
    RUMPLE_REFERENCE_FIRST_FRAME = 1,  // from the first frame, adapting
    RUMPLE_REFERENCE_STATIC_REST = 2   // the rest pose itself
} rumple_reference;

// What compression is measured against. Part of the settings of a system.
typedef struct rumple_reference_settings {
    int32_t reference;  // rumple_reference
    float window;       // labels compare with the pose so long ago, s, 0..10; 0: the previous frame
    float relaxation;   // share per 1/30 s by which compressed reference triangles give in, 0..1
    float growth;       // most length of a reference triangle over the rest pose's, >= 1
    float growth_time;  // in which a reference triangle takes over a longer shape, s, 0..10
} rumple_reference_settings;

// A rest shape that adapts, in a state. All plain values: a stored one continues to the bit.
typedef struct rumple_reference_view {
    double time;            // s
    const uint8_t* labels;  // (t): 0 compress, 1 rest, 2 stretch
    size_t labels_count;
    const float* reference;    // (t, 3): x1, x2, y2 of the edges (x1, 0) and (x2, y2) in the triangle's plane
    size_t reference_count;    // 0: the rest shape does not adapt
    const double* past_times;  // of the poses that labels still need, oldest first, s
    size_t past_times_count;
    const float* past_positions;  // (poses w, 3), object space
    size_t past_positions_count;
} rumple_reference_view;

#ifdef __cplusplus
}
#endif

#endif

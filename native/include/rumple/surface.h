// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes: the coarse base mesh, the shown mesh that replaces it, a frame of the shown mesh, and the pose.
#ifndef RUMPLE_SURFACE_H
#define RUMPLE_SURFACE_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

// ---- the base mesh

// A checked base mesh at rest. Below, n is the number of its vertices, t the number of its triangles, and w
// the number of its welded vertices: vertices of a seam at the same place count as one.
typedef struct rumple_surface rumple_surface;

// The input for a base mesh. Polygon p owns the corners from polygon_start[p] to polygon_start[p + 1] - 1.
typedef struct rumple_surface_plan {
    const float* positions_rest;  // (n, 3), object space, finite
    size_t positions_rest_count;
    const int32_t* polygon_start;  // (polygons + 1), ascending from 0 to the number of corners
    size_t polygon_start_count;
    const int32_t* corner_vertex;  // (corners), 0..n - 1
    size_t corner_vertex_count;
    const int32_t* triangle_corner;  // (t, 3): corners of the same polygon; c corners give c - 2 triangles
    size_t triangle_corner_count;
    bool weld_seams;  // join border vertices at the same place
    // Creases: k edges that subdivision rounds less. Only rumple_surface_build() reads them. A crease without
    // an edge of two polygons has no effect. Borders are always sharp.
    const int32_t* crease_edge;  // (k, 2): vertices, 0..n - 1; or none
    size_t crease_edge_count;
    const float* crease_sharpness;  // (k): number of subdivisions an edge stays sharp, >= 0; >= 10: always
    size_t crease_sharpness_count;
} rumple_surface_plan;
RUMPLE_API rumple_surface_plan rumple_surface_plan_default(void);

// A healed mesh: made from a mesh that is not an oriented manifold, so that rumple_surface_build() accepts
// it.
typedef struct rumple_healed rumple_healed;

// Heals a mesh. It only requires finite positions, indices in range and polygons with at least three corners.
// - Polygons that lie on other polygons are left out.
// - If an edge has more than two polygons, the two that continue each other best stay joined. The others are
//   cut off (Gueziec, Taubin, Lazarus and Horn 2001).
// - All polygons of a part get the winding of its larger area, also across seams if `plan` joins them.
// - A part with only one side, like a Moebius strip, is cut.
// Cost: O(corners log corners).
RUMPLE_API rumple_status rumple_healed_build(const rumple_surface_plan* plan, rumple_healed** healed);
RUMPLE_API void rumple_healed_free(rumple_healed* healed);

// n: vertices of the healed mesh: the vertices of the mesh, then copies of some of them. p: polygons. c:
// corners.
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

    const int32_t* turned;    // (turned_count): polygons of the mesh whose winding was reversed
    const int32_t* cut;       // (cut_count, 2): edges of the mesh at which polygons were cut off
    const int32_t* doubled;   // (doubled_count, 2): a polygon that was left out, and the polygon below it
    const int32_t* repeated;  // (repeated_count): polygons that use a vertex twice
} rumple_healed_view;
RUMPLE_API rumple_status rumple_healed_get_view(const rumple_healed* healed, rumple_healed_view* view);

// Checks a mesh, joins its seams and collects its edges. Refused: values that are not finite, an index out of
// range, a mesh without faces, an edge with three polygons, neighbours with opposite winding, a vertex twice
// in a polygon. The error names the first bad element. Accepted with a warning: loose vertices, bow ties,
// triangles without area. Cost: O(corners log corners).
RUMPLE_API rumple_status rumple_surface_build(const rumple_surface_plan* plan, rumple_surface** surface);
RUMPLE_API void rumple_surface_free(rumple_surface* surface);

typedef struct rumple_surface_view {
    int32_t vertex_count;         // n
    int32_t welded_vertex_count;  // w
    int32_t triangle_count;       // t
    int32_t warning_count;
} rumple_surface_view;
RUMPLE_API rumple_status rumple_surface_get_view(const rumple_surface* surface, rumple_surface_view* view);

// The text of a warning, UTF-8, valid as long as the surface. number: 0..warning_count - 1; otherwise NULL is
// returned.
RUMPLE_API const char* rumple_surface_warning(const rumple_surface* surface, int32_t number);

// The number of openings of the connected part that has most of them. An opening is an open border that is
// not the outline of a sheet. A shirt has four, a skirt two, a head one. Separate heads, arms and feet in one
// mesh also give one. A wide hem is not an outline if its part has a waist. Cost: O(edges log edges).
RUMPLE_API rumple_status rumple_surface_count_openings(const rumple_surface* surface, int32_t* openings);

// Whether more than a tenth of the area lies in polygons narrower than `width`, object units. The width of a
// polygon is its area / its longest side; of a triangle twice that: its height. uneven: written. Cost:
// O(corners).
RUMPLE_API rumple_status rumple_surface_is_uneven(const rumple_surface* surface, float width, bool* uneven);

// The outer side of a garment with modelled thickness. Only the outer side is solved as cloth. The inner side
// and the rims follow it. outer: (polygons), written: 1 for polygons of the outer side, and of parts without
// an inner side. thickness: written, the median, object units. If no thickness is modelled, it is 0, and
// outer is 1 everywhere. This includes meshes of which less than three tenths is an inner side. The distance
// between both sides must be less than a fiftieth of the mesh's diagonal. Cost: about 0.5 us a polygon.
RUMPLE_API rumple_status rumple_surface_outer_side(const rumple_surface* surface, uint8_t* outer,
                                                   size_t outer_count, float* thickness);

// Suggests how firmly every vertex follows the animation, 0 (free) to 1 (pinned). It is derived from the open
// borders at rest: collars, waistbands, cuffs. Parts that are sewn on (below) are pinned, but not on a sheet
// (a cape). up: unit, object space. follow: (n), written. Cost: O(edges log edges).
RUMPLE_API rumple_status rumple_surface_suggest_follow(const rumple_surface* surface, const float up[3],
                                                       float* follow, size_t follow_count);

// Finds the parts that are sewn on other parts of the garment: pockets, lapels, the shirt front in a jacket.
// Nothing of them is held (collar, waistband, cuff), and they lie over or under another part. Alone they
// would fall, so they should move with that part: see `part` of rumple_coarse_as_modelled(). up: as above.
// sewn: (polygons), written: 1 for the polygons of such parts. Cost: O(edges log edges); with such a part O(n
// log n).
RUMPLE_API rumple_status rumple_surface_sewn_on(const rumple_surface* surface, const float up[3],
                                                uint8_t* sewn, size_t sewn_count);

// ---- a coarse mesh in place of the base mesh

// A coarse mesh whose smooth surface passes through that of the base mesh. So wide folds are solved on few
// vertices, with any density of the base mesh. m vertices.
typedef struct rumple_coarse rumple_coarse;

// An even one, of triangles (Peyre and Cohen 2006). spacing: approximate mean edge length, object units, > 0.
// A mesh with edges that are not much shorter is subdivided first. Refused: a mesh that is too small for it.
// Cost: 20 ms for 10,000 vertices.
RUMPLE_API rumple_status rumple_coarse_build(const rumple_surface* base, float spacing,
                                             rumple_coarse** coarse);
// The same for a part of the base mesh, for example its outer side. part: a surface with some of the
// polygons and all vertices of the base mesh.
RUMPLE_API rumple_status rumple_coarse_build_of(const rumple_surface* base, const rumple_surface* part,
                                                float spacing, rumple_coarse** coarse);
// The mesh as it was modelled: quads that were cut into triangles are joined, and subdivisions (of Catmull
// and Clark, or Blender's Simple) taken back until the mean edge is at least least_edge, > 0, and at most a
// tenth of the area is in narrower polygons. If it was modelled with longer edges, it is subdivided until the
// mean edge is at most most_edge, >= 2 x least_edge. Object units. part: as above, or the base mesh itself.
// Refused: a mesh without such a mesh, or if that is the base mesh with all its polygons. Cost: about 2 us a
// polygon.
RUMPLE_API rumple_status rumple_coarse_as_modelled(const rumple_surface* base, const rumple_surface* part,
                                                   float least_edge, float most_edge, rumple_coarse** coarse);
RUMPLE_API void rumple_coarse_free(rumple_coarse* coarse);

typedef struct rumple_coarse_view {
    int32_t vertex_count;        // m
    float mean_edge;             // mean length of its edges, object units
    const int32_t* base_vertex;  // (m): for every vertex the nearest vertex of the base mesh
} rumple_coarse_view;
RUMPLE_API rumple_status rumple_coarse_get_view(const rumple_coarse* coarse, rumple_coarse_view* view);

// The coarse mesh as a base mesh. Of rumple_coarse_build() all its polygons are triangles.
RUMPLE_API rumple_status rumple_coarse_surface(const rumple_coarse* coarse, rumple_surface** surface);

// Positions of the coarse mesh for a pose of the base mesh, so that both smooth surfaces coincide.
// positions: (n, 3) of the base mesh. out: (m, 3), written.
RUMPLE_API rumple_status rumple_coarse_positions(const rumple_coarse* coarse, const float* positions,
                                                 size_t positions_count, float* out, size_t out_count);

// Values that are painted on the base mesh, (n), for the coarse mesh: interpolated linearly if it is a
// subdivision, else those of the nearest vertices. out: (m), written. Cost: 2 ns a vertex.
RUMPLE_API rumple_status rumple_coarse_paint(const rumple_coarse* coarse, const float* values,
                                             size_t values_count, float* out, size_t out_count);

// ---- how a fine mesh is made from the base

typedef enum rumple_fine_source {
    RUMPLE_FINE_SUBDIVISION = 0,  // `level` times: Loop if all polygons are triangles, else Catmull-Clark
    RUMPLE_FINE_REGULAR = 1,      // every edge is cut into `segments`
    RUMPLE_FINE_EDGE_LENGTH = 2,  // edges are halved until none is longer than `longest_edge`
    RUMPLE_FINE_OBJECT = 3        // a separate mesh of the artist: Wrinkle Mesh only
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
    int32_t most_vertices;  // a fine mesh with more vertices is refused
    int32_t attachment;     // rumple_attachment: the surface that fine vertices are attached to
} rumple_fine_plan;

// ---- the shown mesh

// The mesh that is shown instead of the base: d vertices, q polygons. It is borrowed from a model, and valid
// as long as the model. Its source is the base, or the artist's mesh of RUMPLE_FINE_OBJECT.
typedef struct rumple_shown_mesh rumple_shown_mesh;

typedef struct rumple_shown_mesh_view {
    int32_t vertex_count;   // d
    int32_t polygon_count;  // q
    int32_t corner_count;   // k
    int32_t edge_count;     // e
    int32_t solved_count;   // m

    const int32_t* polygon_start;    // (q + 1): the first corner of every polygon, then k
    const int32_t* corner_vertex;    // (k)
    const int32_t* polygon_source;   // (q): polygon of the source
    const int32_t* edges;            // (e, 2): the shown edges that lie on edges of the source
    const int32_t* edge_sources;     // (e, 2): these edges of the source
    const float* positions_rest;     // (d, 3), object space
    const int32_t* triangle_vertex;  // (d, 3): the base triangle that every shown vertex is embedded in
    const float* barycentric;        // (d, 2): weights of its second and third vertex
    const int32_t* solved_start;     // (d + 1): the first entry of every shown vertex, then m
    const int32_t* solved_vertex;    // (m): the solved vertices that its position is made from
    const float* solved_weight;      // (m): their weights
} rumple_shown_mesh_view;
RUMPLE_API rumple_status rumple_shown_mesh_get_view(const rumple_shown_mesh* mesh,
                                                    rumple_shown_mesh_view* view);

// Interpolates values of the source's vertices, (rows, columns), to the shown mesh, linearly. out: (d,
// columns), written.
RUMPLE_API rumple_status rumple_shown_mesh_carry_points(const rumple_shown_mesh* mesh, const float* values,
                                                        size_t values_count, int32_t columns, float* out,
                                                        size_t out_count);
// The same for values of corners. out: (k, columns), written. Seams of a UV map stay sharp.
RUMPLE_API rumple_status rumple_shown_mesh_carry_corners(const rumple_shown_mesh* mesh, const float* values,
                                                         size_t values_count, int32_t columns, float* out,
                                                         size_t out_count);

// ---- rigid parts

// For each part, the rigid motion that fits the movement of its points best in the least-squares sense
// (Mueller et al. 2016, A Robust Method to Extract the Rotational Part of Deformations). If the points do not
// determine a rotation (no points, or points on a line), the undetermined part of it is the identity. Points
// that did not move give exactly the identity.
//   starts: (parts + 1): the first point of each part, ascending from 0, then the number of points.
//   from, to: (points, 3), finite, in the same space and unit.
//   motions: (parts, 12), written: the rotation R, (3, 3) row by row, then the translation t; p goes to
//   R p + t.
// Cost: O(points).
RUMPLE_API rumple_status rumple_rigid_motions(const int32_t* starts, size_t starts_count, const float* from,
                                              size_t from_count, const float* to, size_t to_count,
                                              float* motions, size_t motions_count);

// ---- a frame

// The base in one frame, as input of rumple_X_pose_build(). Fields that a system does not read may keep their
// defaults.
typedef struct rumple_pose {
    const float* positions;  // (n, 3): the deformed base, object space, finite
    size_t positions_count;
    double time;  // s: frame number / frame rate; read by Wrinkle Paths, and with an adaptive rest shape
    // From rumple_X_label_clip(): 0 compress, 1 rest, 2 stretch. None: this frame is labelled by itself.
    const uint8_t* labels;  // (t), or none
    size_t labels_count;
    const float* next_positions;  // (n, 3): the next frame, which labelling looks ahead to; or none
    size_t next_positions_count;
    double next_time;            // s, > time, if there is a next frame
    float world_from_object[9];  // (3, 3); read by the Wrinkle Mesh with RUMPLE_OFFSETS_WORLD
} rumple_pose;
RUMPLE_API rumple_pose rumple_pose_default(void);

// The shown mesh of one frame, of any system.
typedef struct rumple_frame rumple_frame;
RUMPLE_API void rumple_frame_free(rumple_frame* frame);

typedef struct rumple_frame_view {
    int32_t vertex_count;            // d
    const float* positions;          // (d, 3), object space
    const float* local_offset;       // (d, 3): from the linear embedding, in the deformed triangle's frame
    const float* offset;             // (d, 3): from the unwrinkled surface, object space
    const float* stretch_min;        // (d): the smaller principal stretch of the base, 1 at rest
    const float* stretch_max;        // (d): the larger one
    const float* stretch_direction;  // (d, 3): direction of strongest compression, unit, object space
} rumple_frame_view;
RUMPLE_API rumple_status rumple_frame_get_view(const rumple_frame* frame, rumple_frame_view* view);

// Embeds a frame in other positions of the base, (n, 3). The positions of the frame stay, and local_offset is
// computed again. Use it if the frame was solved over a base cloth, but is shown over the animated mesh.
// Cost: O(triangles + shown vertices).
RUMPLE_API rumple_status rumple_frame_embed(rumple_frame* frame, const float* positions,
                                            size_t positions_count);

// ---- adaptive rest shapes: Gillette 2015, chapter 4

typedef enum rumple_reference {
    RUMPLE_REFERENCE_REST = 0,         // adaptive, starts from the rest pose
    RUMPLE_REFERENCE_FIRST_FRAME = 1,  // adaptive, starts from the first frame
    RUMPLE_REFERENCE_STATIC_REST = 2   // not adaptive: the rest pose itself
} rumple_reference;

// The shape that compression is measured against. Part of the settings of a system.
typedef struct rumple_reference_settings {
    int32_t reference;  // rumple_reference
    float window;       // labels compare with the pose this long ago, s, 0..10; 0: the previous frame
    float relaxation;   // share per 1/30 s by which compressed reference triangles shrink, 0..1
    float growth;       // largest length of a reference triangle / length in the rest pose, >= 1
    float growth_time;  // time in which a reference triangle adopts a longer shape, s, 0..10
} rumple_reference_settings;

// An adaptive rest shape, as part of a state. These values are complete: a stored state continues with the
// same bits.
typedef struct rumple_reference_view {
    double time;            // s
    const uint8_t* labels;  // (t): 0 compress, 1 rest, 2 stretch
    size_t labels_count;
    const float* reference;    // (t, 3): x1, x2, y2 of the edges (x1, 0) and (x2, y2) in the triangle's plane
    size_t reference_count;    // 0: the rest shape does not adapt
    const double* past_times;  // times of the poses that labels still need, oldest first, s
    size_t past_times_count;
    const float* past_positions;  // (poses x w, 3), object space
    size_t past_positions_count;
} rumple_reference_view;

#ifdef __cplusplus
}
#endif

#endif

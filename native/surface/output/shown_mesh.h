// SPDX-License-Identifier: GPL-3.0-or-later
// The fine mesh that replaces the base on screen, and the data that it inherits.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "surface/mesh/topology.h"
#include "surface/output/attachments.h"
#include "surface/refine/refinement.h"
#include "surface/strain/deformation.h"

namespace rumple {

// How a fine mesh is made over a base (Mueller and Chentanez 2010, section 3).
struct FineSource {
    enum class Kind { kSubdivision, kRegular, kLongestEdge };
    Kind kind = Kind::kSubdivision;
    Index level = 2;             // kSubdivision
    Index segments = 4;          // kRegular
    float longest_edge = 0.01f;  // kLongestEdge, object units
    Index most_vertices = 4'000'000;
};

// Throws InvalidInput if the fine mesh would have more than most_vertices. steps: further subdivisions of it.
// Cost: the cost of the refinement.
FineMesh refine(const Surface& base, const FineSource& source, Index steps = 0);

// The attachments of a refined mesh. Cost: the cost of the limit stencils.
Attachments attach_refined(const Surface& base, const FineSource& source, const FineMesh& fine,
                           AttachmentKind kind);

// Attachment points on the base at rest.
std::vector<Vec3> attached_at_rest(const Surface& base, const Attachments& attachments);

// Throws InvalidInput before the refinement if a mesh with this number of corners would get too many
// vertices.
void refuse_too_many(double corners, const FineSource& source, Index steps);

// The shown mesh: the solved fine mesh after unsolved subdivision steps, with seams split as on the source
// (the base, or an artist's own mesh).
struct ShownMesh {
    PolygonMesh mesh;
    SparseRows from_solved;                       // smooth positions <- solved vertices
    SparseRows vertex_from_source;                // linear, source vertices (as the artist has them)
    ShiftedRows corner_from_source;               // linear, source corners: UV seams stay sharp
    std::vector<Index> polygon_source;            // source polygon
    std::vector<SurfacePoint> places;             // on the base; kNone for a loose vertex
    std::vector<std::array<Index, 3>> embedding;  // the base's vertices (as the artist has them) around each
    std::vector<Vec3> positions_rest;             // object space
    std::vector<std::array<Index, 2>> edges;      // shown edges that lie on a source edge ...
    std::vector<std::array<Index, 2>> edge_sources;  // ... and that edge's vertices

    // To be called when it is complete.
    void fit() {
        from_solved.fit();
        vertex_from_source.fit();
        rumple::fit(polygon_source, places, embedding, positions_rest, edges, edge_sources);
    }
};

// fine: the solved mesh, made from source.welded. steps: unsolved subdivisions of it. solved_rest: its
// vertices at rest. source: the base itself, or an artist's own mesh that is bound to the base by closest
// points.
ShownMesh show_fine(const Surface& base, const Surface& source, const FineMesh& fine, Index steps,
                    std::span<const Vec3> solved_rest);

// The same for viewports, with viewport_steps; none if these are not fewer than steps.
std::optional<ShownMesh> show_in_viewport(const Surface& base, const Surface& source, const FineMesh& fine,
                                          Index steps, Index viewport_steps,
                                          std::span<const Vec3> solved_rest);

// The shown mesh of a model: in viewports its own mesh for them, if there is one.
template <typename Model>
const ShownMesh& shown_mesh(const Model& model, bool in_viewport) {
    return in_viewport && model.shown_in_viewport ? *model.shown_in_viewport : model.shown;
}

// The base itself with every polygon cut into its triangles. Vertex v is the base's vertex v as the artist
// has it, including loose vertices. Polygon t is triangle t.
ShownMesh show_triangles(const Surface& base);

// The result of a frame that every system shows.
struct ShownFrame {
    std::vector<Vec3> positions;     // per shown vertex, object space
    std::vector<Vec3> local_offset;  // from the linear embedding, in the frame of the deformed base triangle
    std::vector<Vec3> offset;        // from the unwrinkled surface, object space
    StretchField stretch;            // of the base
};

// base_positions, frames: of the deformed base. solved, offset: per solved vertex, object space; offset is
// from the unwrinkled surface. Cost: O(triangles + shown vertices).
void show_frame(const Surface& base, const ShownMesh& mesh, const StretchModel& stretch,
                std::span<const Vec3> base_positions, std::span<const SurfaceFrame> frames,
                std::span<const Vec3> solved, std::span<const Vec3> offset, ShownFrame& out);

// Embeds a frame in other positions of the base's vertices (as the artist has them): computes local_offset
// again. It is for frames that were solved on a base cloth and are shown on the animated mesh. Cost:
// O(triangles + shown vertices).
void embed_frame(const Surface& base, const ShownMesh& mesh, std::span<const Vec3> positions,
                 ShownFrame& frame);

}  // namespace rumple

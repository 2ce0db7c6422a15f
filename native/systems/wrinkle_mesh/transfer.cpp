// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh/transfer.h"

#include <set>

#include "base/expect.h"
#include "base/smooth_step.h"
#include "base/solve_team.h"
#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {
namespace {

// Unit: edges of the coarse mesh. Vertices within kNear of it move fully with it, vertices beyond kFar do not
// move.
constexpr float kNear = 1.0f, kFar = 2.0f;

// Unit: edges of the coarse mesh. Vertices that lie within kBeside of it at rest lie beside it in every pose,
// vertices beyond kApart follow their neighbours.
constexpr float kBeside = 0.15f, kApart = 0.5f;

// Passes in which vertices that are not beside it follow their neighbours.
constexpr int kPasses = 8;

// Corrections of the vertices until the smooth surface passes where they should be.
constexpr int kCorrections = 6;

// The finest layer is as fine as the folds, so an accuracy of a thousandth of its edges is enough.
constexpr Index kFinestLimitLevels = 2;

// The smooth surface of the finest layer at rest, and which part of the dense mesh each triangle stands for.
struct Finest {
    Surface surface;
    std::span<const Vec3> positions_rest;
    std::vector<Index> part;
    float edge;  // of the coarse mesh
};

Finest finest_of(const Layers& layers, const CoarseMesh& coarse, const Surface& dense,
                 std::span<const Index> parts) {
    const Model& finest = *layers.layers.back();
    Finest out{solved_surface(finest), finest.positions_rest, {}, coarse.mean_edge};
    const PolygonMesh& polygons = layers.base.welded;
    // Shown polygons of a solved one follow one another.
    const Index shown = layers.shown.mesh.polygons() / out.surface.welded.polygons();
    for (const Triangle& triangle : out.surface.triangles) {
        const Index polygon = layers.shown.polygon_source[triangle.polygon * shown];
        const Index vertex =
            layers.base.representative[polygons.corner_vertex[polygons.polygon_start[polygon]]];
        out.part.push_back(parts[dense.welded_of[coarse.dense_vertex[vertex]]]);
    }
    return out;
}

// The nearest points of the finest layer's surface.
struct Nearest {
    SparseRows rows;  // <- its vertices
    std::vector<float> distance;
};

// part: of every point; a point only finds its own part, if the coarse mesh has it.
Nearest nearest_on(const Finest& finest, std::span<const Vec3> points, std::span<const Index> part) {
    const std::set<Index> known(finest.part.begin(), finest.part.end());
    std::vector<Index> sought(part.begin(), part.end());
    for (Index& p : sought)
        if (!known.contains(p)) p = kNone;
    Nearest out;
    out.distance.resize(points.size());
    out.rows = limit_stencils(finest.surface,
                              closest_points(finest.surface, points, out.distance, finest.part, sought),
                              kFinestLimitLevels);
    for (Index& vertex : out.rows.index) vertex = finest.surface.representative[vertex];
    return out;
}

// The rows from `first` on, times a share of each that falls from 1 at the distance `near` to 0 at `far`.
SparseRows faded(const Nearest& nearest, Index first, Index count, float near, float far,
                 std::vector<float>* shares = nullptr) {
    SparseRows out;
    for (Index r = first; r < first + count; ++r) {
        const float share = 1.0f - smooth_step(near, far, nearest.distance[r]);
        for (Index k = nearest.rows.start[r]; share > 0.0f && k < nearest.rows.start[r + 1]; ++k)
            out.add(nearest.rows.index[k], share * nearest.rows.weight[k]);
        out.end_row();
        if (shares) shares->push_back(share);
    }
    return out;
}

// The frame of a vertex: its normal, and a tangent towards a neighbour. Zero where these are parallel.
TriangleFrame frame_at(std::span<const Vec3> positions, std::span<const Vec3> normals, Index v, Index along) {
    TriangleFrame frame;
    if (along == kNone) return frame;
    const Vec3 side = positions[along] - positions[v];
    const Vec3 tangent = side - glm::dot(side, normals[v]) * normals[v];
    const float length = glm::length(tangent);
    if (!(length > 0.1f * glm::length(side))) return frame;
    frame.normal = normals[v], frame.tangent = tangent / length;
    frame.bitangent = glm::cross(frame.normal, frame.tangent);
    return frame;
}

// For the vertices with a share below 1: what is left of it, shared out among their neighbours.
void find_neighbours(const Surface& base, Beside& beside) {
    std::vector<std::vector<Index>> around(base.positions_rest.size());
    for (const Edge& e : base.edges) around[e.a].push_back(e.b), around[e.b].push_back(e.a);
    for (Index v = 0; v < Index(around.size()); ++v) {
        beside.along.push_back(around[v].empty() ? kNone : around[v].front());
        if (beside.share[v] >= 1.0f || around[v].empty()) continue;
        beside.partly.push_back(v);
        for (const Index other : around[v])
            beside.from_neighbours.add(other, (1.0f - beside.share[v]) / float(around[v].size()));
        beside.from_neighbours.end_row();
    }
}

// nearest: its rows from `first` on are those of smooth_rest, where the smooth surface passes the vertices.
Beside lies_beside(const Surface& base, SparseRows smooth, std::span<const Vec3> smooth_rest,
                   const Nearest& nearest_all, Index first, const Finest& finest) {
    Beside out;
    out.smooth = std::move(smooth);
    out.nearest = faded(nearest_all, first, Index(smooth_rest.size()), kBeside * finest.edge,
                        kApart * finest.edge, &out.share);
    find_neighbours(base, out);
    std::vector<Vec3> nearest(base.positions_rest.size());
    apply<Vec3>(out.nearest, finest.positions_rest, nearest);
    const std::vector<Vec3> normals = vertex_normals(base, base.positions_rest);
    for (Index v = 0; v < Index(nearest.size()); ++v) {
        const TriangleFrame frame = frame_at(base.positions_rest, normals, v, out.along[v]);
        out.way.push_back(frame.to_local(out.share[v] * smooth_rest[v] - nearest[v]));
    }
    return out;
}

// Adds to vertices with a share below 1 what they take over from their neighbours.
void follow_neighbours(const Beside& beside, std::vector<Vec3>& ways) {
    const std::vector<Vec3> own = ways;
    const SparseRows& rows = beside.from_neighbours;
    for (int pass = 0; pass < kPasses; ++pass) {
        for (Index r = 0; r < rows.rows(); ++r) {
            Vec3 way = own[beside.partly[r]];
            for (Index k = rows.start[r]; k < rows.start[r + 1]; ++k)
                way += rows.weight[k] * ways[rows.index[k]];
            ways[beside.partly[r]] = way;
        }
    }
}

// The ways of vertices by which their smooth surface goes the given ways. Each correction leaves about half
// of the error.
std::vector<Vec3> cage_of(const SparseRows& smooth, const std::vector<Vec3>& ways) {
    std::vector<Vec3> cage = ways, reached(ways.size());
    for (int i = 0; i < kCorrections; ++i) {
        apply<Vec3>(smooth, cage, reached);
        for (size_t v = 0; v < ways.size(); ++v) cage[v] += ways[v] - reached[v];
    }
    return cage;
}

// How far the animated dense mesh is from where it would lie beside the finest layer without folds, per
// welded vertex. Skinning crushes joints in a dense mesh that the layers, on a coarse one, do not have.
std::vector<Vec3> corrections(const Transfer& transfer, std::span<const Vec3> animated,
                              std::span<const Vec3> finest) {
    const Beside& beside = transfer.beside;
    const std::vector<Vec3> normals = vertex_normals(transfer.base, animated);
    std::vector<Vec3> smooth(animated.size()), out(animated.size());
    apply<Vec3>(beside.smooth, animated, smooth);
    apply<Vec3>(beside.nearest, finest, out);
    for (Index v = 0; v < Index(out.size()); ++v) {
        const TriangleFrame frame = frame_at(animated, normals, v, beside.along[v]);
        out[v] += frame.to_object(beside.way[v]) - beside.share[v] * smooth[v];
    }
    follow_neighbours(beside, out);
    return cage_of(beside.smooth, out);
}

// rest: of the moved vertices. smooth: they lie on the limit surface of the dense mesh.
void find_nearest(Transfer& transfer, const CoarseMesh& coarse, const Layers& layers,
                  std::span<const Vec3> rest, bool smooth) {
    const Surface& base = transfer.base;
    const std::vector<Index> parts = connected_parts(base);
    const Finest finest = finest_of(layers, coarse, base, parts);
    SparseRows passes = smooth ? vertex_limit_stencils(base) : identity_rows(base.welded.vertex_count);
    std::vector<Vec3> passed(parts.size()), points(rest.begin(), rest.end());
    apply<Vec3>(passes, base.positions_rest, passed);
    std::vector<Index> part;
    for (const SurfacePoint& place : transfer.attachments.places)
        part.push_back(parts[welded_vertices(base, place.triangle)[0]]);
    points.insert(points.end(), passed.begin(), passed.end());
    part.insert(part.end(), parts.begin(), parts.end());
    const Nearest nearest = nearest_on(finest, points, part);
    const Index moved = static_cast<Index>(rest.size());
    transfer.from_finest = faded(nearest, 0, moved, kNear * finest.edge, kFar * finest.edge);
    transfer.beside = lies_beside(base, std::move(passes), passed, nearest, moved, finest);
}

}  // namespace

std::shared_ptr<const Transfer> build_transfer(Surface base, const CoarseMesh& coarse, const Layers& layers,
                                               Index level, Index display_steps, Index most_vertices,
                                               Index viewport_steps) {
    expect_count("layers", layers.base.display.vertex_count, coarse.dense_vertex.size(), "coarse vertices");
    auto out = std::make_shared<Transfer>();
    out->base = std::move(base);
    FineSource source;
    source.level = level;
    source.most_vertices = most_vertices;
    const FineMesh fine = refine(out->base, source, display_steps);
    // Modelled vertices keep their places.
    out->attachments =
        attach_refined(out->base, source, fine, level > 0 ? AttachmentKind::kLimit : AttachmentKind::kLinear);
    const std::vector<Vec3> rest = attached_at_rest(out->base, out->attachments);
    find_nearest(*out, coarse, layers, rest, level > 0);
    out->shown = show_fine(out->base, out->base, fine, display_steps, rest);
    out->shown_in_viewport =
        show_in_viewport(out->base, out->base, fine, display_steps, viewport_steps, rest);
    out->stretch = build_stretch(out->base);
    return out;
}

void show(const Transfer& transfer, const CoarseMesh& coarse, const Layers& layers,
          std::span<const Vec3> animated, const LayersState& state, Picture& picture, bool in_viewport) {
    const SolveTeam team(0, transfer.attachments.places.size(), kVerticesForTeam);
    std::vector<Vec3> displacements =
        offsets(layers, coarse_positions(coarse, transfer.base, animated), state);
    const std::vector<Vec3> missed = missed_by_limit(layers, layers.layers.size() - 1, displacements);
    std::vector<Vec3> unwrinkled(missed.size());
    for (size_t v = 0; v < missed.size(); ++v) {
        unwrinkled[v] = state.solved[v] - displacements[v];
        displacements[v] += missed[v];
    }
    const std::vector<Vec3> base = weld_positions(transfer.base, animated);
    const std::vector<Vec3> corrected = corrections(transfer, base, unwrinkled);
    const size_t moved = transfer.attachments.places.size();
    std::vector<Vec3> offset(moved), solved(moved), beside(moved);
    apply(transfer.from_finest, to_rows(displacements), offset);
    attach(transfer.base, transfer.attachments, base, {}, solved);
    attach(transfer.base, transfer.attachments, corrected, {}, beside);
    for (size_t v = 0; v < moved; ++v) {
        offset[v] += beside[v];
        solved[v] += offset[v];
    }
    show_frame(transfer.base, shown_mesh(transfer, in_viewport), transfer.stretch, base,
               triangle_frames(transfer.base, base), solved, offset, picture);
}

}  // namespace rumple::wrinkle_mesh

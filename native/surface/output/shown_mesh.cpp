// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/output/shown_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>

#include "base/errors.h"
#include "base/expect.h"
#include "base/parallel.h"
#include "base/solve_team.h"
#include "base/stop.h"
#include "base/tolerances.h"
#include "surface/mesh/positions.h"

namespace rumple {
namespace {

using Pair = std::array<Index, 2>;

// Finds edges that lie on an edge of the source: both ends are made only from the two vertices of the
// source's edge. Calls found(edge, ends of the source's edge).
template <typename Found>
void edges_on_source(const PolygonMesh& mesh, const SparseRows& from, const PolygonMesh& source,
                     Found&& found) {
    const std::vector<Edge> source_edges = collect_edges(source);
    std::vector<Pair> known;
    known.reserve(source_edges.size());
    for (const Edge& e : source_edges) known.push_back({e.a, e.b});
    const auto support = [&](Index v, std::vector<Index>& out) {
        for (Index k = from.start[v]; k < from.start[v + 1]; ++k) {
            if (from.weight[k] > kZeroWeight) out.push_back(from.index[k]);
        }
    };
    std::vector<Index> both;
    for (const Edge& e : collect_edges(mesh)) {
        both.clear();
        support(e.a, both);
        support(e.b, both);
        std::sort(both.begin(), both.end());
        both.erase(std::unique(both.begin(), both.end()), both.end());
        if (both.size() != 2 || !std::binary_search(known.begin(), known.end(), Pair{both[0], both[1]}))
            continue;
        found(e, Pair{both[0], both[1]});
    }
}

void collect_edge_sources(ShownMesh& shown, const PolygonMesh& source) {
    edges_on_source(shown.mesh, shown.vertex_from_source, source, [&](const Edge& edge, const Pair& ends) {
        shown.edges.push_back({edge.a, edge.b});
        shown.edge_sources.push_back(ends);
    });
}

// log2 of a number of pieces, linearly interpolated between powers of two.
float halvings(int pieces) {
    const int whole = std::bit_width(unsigned(pieces)) - 1;
    return float(whole) + float(pieces) / float(1 << whole) - 1.0f;
}

// Creases of a mesh whose edges were split. An infinitely sharp crease stays so in every piece. Other creases
// lose as much sharpness as by the same number of subdivisions.
void split_creases(FineMesh& fine, const PolygonMesh& parent) {
    if (parent.creases.empty()) return;
    std::vector<std::pair<Edge, const Crease*>> pieces;
    std::vector<int> count(parent.creases.size(), 0);
    edges_on_source(fine.mesh, fine.vertex_from_parent, parent, [&](const Edge& edge, const Pair& ends) {
        const auto at = std::lower_bound(parent.creases.begin(), parent.creases.end(), ends,
                                         [](const Crease& c, const Pair& key) {
                                             return Pair{c.a, c.b} < key;
                                         });
        if (at == parent.creases.end() || Pair{at->a, at->b} != ends) return;
        pieces.emplace_back(edge, &*at);
        ++count[size_t(at - parent.creases.begin())];
    });
    for (const auto& [edge, crease] : pieces) {
        const float lost = halvings(count[size_t(crease - parent.creases.data())]);
        const float left = crease->sharpness < kSharp ? crease->sharpness - lost : kSharp;
        if (left > 0.0f) fine.mesh.creases.push_back({edge.a, edge.b, left});
    }
}

void embed(const Surface& base, const ShownMesh& mesh, std::span<const Vec3> welded,
           std::span<const SurfaceFrame> frames, ShownFrame& out) {
    for_each_index(mesh.places.size(), kLeastSteps, [&](size_t v) {
        const SurfacePoint& place = mesh.places[v];
        if (place.triangle == kNone) {  // a loose vertex has no offset from the base
            out.local_offset[v] = Vec3(0.0f);
            return;
        }
        out.local_offset[v] =
            frames[place.triangle].to_local(out.positions[v] - interpolate(base, place, welded));
    });
}

}  // namespace

void refuse_too_many(double corners, const FineSource& source, Index steps) {
    expect_within("display_steps", steps, 0, kMostLevels);
    double per_corner = 1.0;
    if (source.kind == FineSource::Kind::kSubdivision) {
        expect_within("level", source.level, 0, kMostLevels);
        per_corner = std::ldexp(1.0, 2 * source.level);
    }
    if (source.kind == FineSource::Kind::kRegular) {
        expect_within("segments", source.segments, 1, kMostSegments);
        per_corner = double(source.segments) * source.segments;
    }
    const double estimate = std::round(corners / 4.0 * per_corner * std::ldexp(1.0, 2 * steps));
    if (estimate > source.most_vertices) {
        throw InvalidInput("the fine mesh would have about " +
                           std::to_string(std::int64_t(std::min(estimate, 1e15))) + " vertices, more than " +
                           std::to_string(source.most_vertices) +
                           ": raise the wavelength, or lower the number of subdivisions or segments");
    }
}

namespace {

FineMesh refine_by_kind(const Surface& base, const FineSource& source, Index steps) {
    switch (source.kind) {
        case FineSource::Kind::kSubdivision:
            return refine_subdivision(base.welded, source.level);
        case FineSource::Kind::kRegular:
            return refine_regular(base, source.segments);
        case FineSource::Kind::kLongestEdge:
            // The display steps come after it.
            return refine_longest_edge(base, source.longest_edge,
                                       Index(std::ldexp(double(source.most_vertices), -2 * steps)));
    }
    return {};
}

}  // namespace

FineMesh refine(const Surface& base, const FineSource& source, Index steps) {
    refuse_too_many(base.welded.corners(), source, steps);
    FineMesh fine = refine_by_kind(base, source, steps);
    if (source.kind != FineSource::Kind::kSubdivision) split_creases(fine, base.welded);
    return fine;
}

Attachments attach_refined(const Surface& base, const FineSource& source, const FineMesh& fine,
                           AttachmentKind kind) {
    Attachments attachments{kind, locate_on_parents(base, fine), {}};
    if (kind == AttachmentKind::kLimit) {
        attachments.limit = source.kind == FineSource::Kind::kSubdivision
                                ? subdivision_stencils(base.welded, source.level, true)
                                : limit_stencils(base, attachments.places);
        attachments.limit.fit();
    }
    return attachments;
}

std::vector<Vec3> attached_at_rest(const Surface& base, const Attachments& attachments) {
    std::vector<Vec3> rest(attachments.places.size());
    const std::vector<Vec3> normals = vertex_normals(base, base.positions_rest);
    attach(base, attachments, base.positions_rest, normals, rest);
    return rest;
}

namespace {

// Fills in everything that does not depend on solved vertices. Returns, for every shown vertex, its solved
// vertex after the display steps.
std::vector<Index> unweld_and_locate(const Surface& base, const Surface& source, const FineMesh& fine,
                                     Index steps, ShownMesh& shown) {
    FineMesh whole = compose(refine_subdivision(fine.mesh, steps), fine);
    stop_if_asked();
    Unwelded open = unweld(source, whole);
    stop_if_asked();
    if (&source == &base) {
        const std::vector<SurfacePoint> places = locate_on_parents(base, whole);
        for (const Index v : open.fine_vertex) shown.places.push_back(places[v]);
    }
    shown.mesh = std::move(open.mesh);
    shown.vertex_from_source = std::move(open.vertex_from_display);
    shown.corner_from_source = find_alike(whole.corner_from_parent);
    shown.polygon_source = std::move(whole.polygon_parent);
    stop_if_asked();
    collect_edge_sources(shown, source.display);
    return std::move(open.fine_vertex);
}

}  // namespace

ShownMesh show_fine(const Surface& base, const Surface& source, const FineMesh& fine, Index steps,
                    std::span<const Vec3> solved_rest) {
    ShownMesh shown;
    std::vector<Index> solved_vertex;
    SparseRows smooth;
    in_parallel([&] { solved_vertex = unweld_and_locate(base, source, fine, steps, shown); },
                [&] { smooth = subdivision_stencils(fine.mesh, steps, false); });
    stop_if_asked();
    for (const Index v : solved_vertex) shown.from_solved.append_row(smooth, v);
    shown.positions_rest.resize(solved_vertex.size());
    apply<Vec3>(shown.from_solved, solved_rest, shown.positions_rest);
    if (&source != &base) {
        std::vector<float> distance(shown.positions_rest.size());
        shown.places = closest_points(base, shown.positions_rest, distance);
    }
    for (const SurfacePoint& place : shown.places) {
        shown.embedding.push_back(display_vertices(base, place.triangle));
    }
    shown.fit();
    return shown;
}

std::optional<ShownMesh> show_in_viewport(const Surface& base, const Surface& source, const FineMesh& fine,
                                          Index steps, Index viewport_steps,
                                          std::span<const Vec3> solved_rest) {
    expect_within("viewport_steps", viewport_steps, 0, kMostLevels);
    if (viewport_steps >= steps) return std::nullopt;
    return show_fine(base, source, fine, viewport_steps, solved_rest);
}

ShownMesh show_triangles(const Surface& base) {
    ShownMesh shown;
    const Index vertices = base.display.vertex_count;
    shown.mesh.vertex_count = vertices;
    shown.places.resize(vertices);
    for (Index v = 0; v < vertices; ++v) {
        shown.embedding.push_back({v, v, v});
        shown.from_solved.add(base.welded_of[v], 1.0f);
        shown.from_solved.end_row();
        shown.positions_rest.push_back(base.positions_rest[base.welded_of[v]]);
    }
    shown.vertex_from_source = identity_rows(vertices);
    const Index triangles = static_cast<Index>(base.triangles.size());
    SparseRows corners;
    for (Index t = 0; t < triangles; ++t) {
        const std::array<Index, 3> vertex = display_vertices(base, t);
        for (int k = 0; k < 3; ++k) {
            shown.mesh.corner_vertex.push_back(vertex[k]);
            corners.add(base.triangles[t].corner[k], 1.0f);
            corners.end_row();
            SurfacePoint& place = shown.places[vertex[k]];
            if (place.triangle != kNone) continue;
            place = {t, k == 1 ? 1.0f : 0.0f, k == 2 ? 1.0f : 0.0f};
            shown.embedding[vertex[k]] = vertex;
        }
        shown.mesh.polygon_start.push_back(shown.mesh.corners());
        shown.polygon_source.push_back(base.triangles[t].polygon);
    }
    shown.corner_from_source = find_alike(corners);
    collect_edge_sources(shown, base.display);
    shown.fit();
    return shown;
}

void embed_frame(const Surface& base, const ShownMesh& mesh, std::span<const Vec3> positions,
                 ShownFrame& frame) {
    check_frame(base, positions);
    const std::vector<Vec3> welded = weld_positions(base, positions);
    embed(base, mesh, welded, triangle_frames(base, welded), frame);
}

void show_frame(const Surface& base, const ShownMesh& mesh, const StretchModel& stretch,
                std::span<const Vec3> base_positions, std::span<const SurfaceFrame> frames,
                std::span<const Vec3> solved, std::span<const Vec3> offset, ShownFrame& out) {
    const size_t shown = mesh.places.size();
    out.positions.resize(shown);
    out.offset.resize(shown);
    out.local_offset.resize(shown);
    apply(mesh.from_solved, to_rows(solved), out.positions);
    apply(mesh.from_solved, to_rows(offset), out.offset);
    embed(base, mesh, base_positions, frames, out);
    measure_stretch(base, stretch, base_positions, mesh.places, out.stretch);
}

}  // namespace rumple

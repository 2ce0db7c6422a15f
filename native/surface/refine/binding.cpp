// SPDX-License-Identifier: GPL-3.0-or-later
// Positions of fine vertices on the base, and splitting fine vertices at seams.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "base/solve_team.h"
#include "base/stop.h"
#include "base/tolerances.h"
#include "surface/refine/refinement.h"
#include "surface/refine/triangle_tree.h"

namespace rumple {
namespace {

// Fewer queries take only a millisecond or two on one thread.
constexpr size_t kQueriesForTeam = 1'000;

// The triangles of every polygon: polygon p has triangle[start[p]] to triangle[start[p + 1] - 1].
struct PolygonTriangles {
    std::vector<Index> start;
    std::vector<Index> triangle;

    explicit PolygonTriangles(const Surface& surface)
        : start(surface.welded.polygons() + 1, 0), triangle(surface.triangles.size()) {
        for (const Triangle& t : surface.triangles) ++start[t.polygon + 1];
        for (std::size_t p = 1; p < start.size(); ++p) start[p] += start[p - 1];
        std::vector<Index> next(start.begin(), start.end() - 1);
        for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
            triangle[next[surface.triangles[t].polygon]++] = static_cast<Index>(t);
        }
    }
};

// The parent polygon of the first polygon around each fine vertex.
std::vector<Index> find_parents(const FineMesh& fine) {
    std::vector<Index> parent(fine.mesh.vertex_count, kNone);
    for (Index p = 0; p < fine.mesh.polygons(); ++p) {
        for (Index c = fine.mesh.polygon_start[p]; c < fine.mesh.polygon_start[p + 1]; ++c) {
            Index& known = parent[fine.mesh.corner_vertex[c]];
            if (known == kNone) known = fine.polygon_parent[p];
        }
    }
    return parent;
}

// The corners at every vertex, ascending.
struct VertexCorners {
    std::vector<Index> start, corner;

    explicit VertexCorners(const PolygonMesh& mesh)
        : start(size_t(mesh.vertex_count) + 1, 0), corner(mesh.corner_vertex.size()) {
        for (const Index v : mesh.corner_vertex) ++start[v + 1];
        std::partial_sum(start.begin(), start.end(), start.begin());
        std::vector<Index> next(start.begin(), start.end() - 1);
        for (Index c = 0; c < mesh.corners(); ++c) corner[next[mesh.corner_vertex[c]]++] = c;
    }
    std::span<const Index> of(Index v) const {
        return {corner.data() + start[v], corner.data() + start[v + 1]};
    }
};

// Rows: fine corners; columns: display vertices of the base.
SparseRows corners_from_display(const Surface& surface, const FineMesh& fine) {
    SparseRows pick;
    for (Index v : surface.display.corner_vertex) {
        pick.add(v, 1.0f);
        pick.end_row();
    }
    return compose(fine.corner_from_parent, pick);
}

// Whether two rows have weights in the same columns. Columns are ascending.
bool have_same_columns(const SparseRows& rows, Index r, Index s) {
    Index i = rows.start[r], j = rows.start[s];
    while (true) {
        while (i < rows.start[r + 1] && std::abs(rows.weight[i]) <= kZeroWeight) ++i;
        while (j < rows.start[s + 1] && std::abs(rows.weight[j]) <= kZeroWeight) ++j;
        if (i == rows.start[r + 1] || j == rows.start[s + 1])
            return i == rows.start[r + 1] && j == rows.start[s + 1];
        if (rows.index[i++] != rows.index[j++]) return false;
    }
}

}  // namespace

FineMesh compose(const FineMesh& outer, const FineMesh& inner) {
    FineMesh result;
    result.mesh = outer.mesh;
    result.vertex_from_parent = compose(outer.vertex_from_parent, inner.vertex_from_parent);
    result.corner_from_parent = compose(outer.corner_from_parent, inner.corner_from_parent);
    result.polygon_parent.reserve(outer.polygon_parent.size());
    for (Index p : outer.polygon_parent) result.polygon_parent.push_back(inner.polygon_parent[p]);
    return result;
}

std::vector<SurfacePoint> locate_on_parents(const Surface& surface, const FineMesh& fine) {
    std::vector<Vec3> positions(fine.mesh.vertex_count);
    apply<Vec3>(fine.vertex_from_parent, surface.positions_rest, positions);
    const PolygonTriangles triangles(surface);
    const std::vector<Index> parent = find_parents(fine);

    std::vector<SurfacePoint> places(positions.size());
    for (std::size_t v = 0; v < places.size(); ++v) {
        stop_if_asked(v);
        if (parent[v] == kNone) continue;
        double best = std::numeric_limits<double>::infinity();
        for (Index k = triangles.start[parent[v]]; k < triangles.start[parent[v] + 1]; ++k) {
            const TrianglePoint point = closest_point(surface, triangles.triangle[k], positions[v]);
            if (point.squared_distance < best) {
                best = point.squared_distance;
                places[v] = point.place;
            }
        }
    }
    return places;
}

std::vector<SurfacePoint> closest_points(const Surface& surface, std::span<const Vec3> queries,
                                         std::span<float> distance, std::span<const Index> part_of_triangle,
                                         std::span<const Index> part_of_query) {
    assert(distance.size() == queries.size());
    const TriangleTree tree(surface);
    std::vector<SurfacePoint> places(queries.size());
    const SolveTeam team(0, queries.size(), kQueriesForTeam);
    for_each_index(queries.size(), kLeastSearches, [&](size_t i) {
        const Index part = part_of_query.empty() ? kNone : part_of_query[i];
        const TrianglePoint point = tree.closest_within(
            queries[i], std::numeric_limits<double>::infinity(), [](Index) { return false; },
            [&](Index triangle) { return part == kNone || part_of_triangle[triangle] == part; },
            [](const TrianglePoint&) { return true; });
        places[i] = point.place;
        distance[i] = static_cast<float>(std::sqrt(point.squared_distance));
    });
    return places;
}

Unwelded unweld(const Surface& surface, const FineMesh& fine) {
    const SparseRows corner_rows = corners_from_display(surface, fine);
    // Corners of one fine vertex that depend on the same display vertices become one vertex. At a seam the
    // sides depend on different display vertices.
    const VertexCorners corners(fine.mesh);
    Unwelded result;
    result.mesh.polygon_start = fine.mesh.polygon_start;
    result.mesh.corner_vertex.resize(fine.mesh.corner_vertex.size());
    std::vector<Index> differing;  // one corner of every new vertex
    for (Index v = 0; v < fine.mesh.vertex_count; ++v) {
        stop_if_asked(std::size_t(v));
        differing.clear();
        for (Index c : corners.of(v)) {
            const auto same = std::find_if(differing.begin(), differing.end(), [&](Index other) {
                return have_same_columns(corner_rows, other, c);
            });
            if (same != differing.end()) {
                result.mesh.corner_vertex[c] = result.mesh.corner_vertex[*same];
                continue;
            }
            differing.push_back(c);
            result.mesh.corner_vertex[c] = result.mesh.vertex_count++;
            result.fine_vertex.push_back(v);
            result.vertex_from_display.append_row(corner_rows, c);
        }
    }
    return result;
}

}  // namespace rumple

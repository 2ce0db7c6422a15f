// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numeric>
#include <queue>
#include <set>

#include "base/errors.h"
#include "surface/mesh/disjoint_sets.h"
#include "surface/mesh/edge_graph.h"
#include "surface/output/coarse.h"
#include "surface/output/coarse_cage.h"

namespace rumple {
namespace {

// The largest distance of a vertex from its nearest sample / mean edge length of the coarse mesh. Measured on
// shirts, sweaters and trousers.
constexpr float kRadius = 0.7f;

// Cosine: if the direction of a border changes more, the vertex is a corner.
constexpr float kStraight = 0.6f;

// A mesh whose sides are longer than kDense * spacing is subdivided until they are at most kFine * spacing.
// Among fewer vertices to choose from, triangles would be as long and as thin as the polygons of the mesh.
constexpr float kDense = 0.75f, kFine = 0.4f;
constexpr Index kMostSubdivisions = 2;

// A part of the mesh with less area than this times spacing^2 (a button, a torn piece) has no vertices of its
// own. It moves along with the cloth under it, and does not fall.
constexpr float kSmallPart = 4.0f;

// The graph of the sides of triangles, and of both diagonals of quads, so that distances do not depend on how
// a quad is cut.
EdgeGraph build_graph(const Surface& surface) {
    std::vector<std::pair<Index, Index>> sides;
    const auto add = [&](Index a, Index b) { sides.emplace_back(std::min(a, b), std::max(a, b)); };
    for (Index t = 0; t < Index(surface.triangles.size()); ++t) {
        const auto [a, b, c] = welded_vertices(surface, t);
        add(a, b), add(b, c), add(c, a);
    }
    const PolygonMesh& mesh = surface.welded;
    for (Index p = 0; p < mesh.polygons(); ++p) {
        if (mesh.polygon_size(p) != 4) continue;
        const Index* corner = &mesh.corner_vertex[mesh.polygon_start[p]];
        add(corner[0], corner[2]), add(corner[1], corner[3]);
    }
    std::ranges::sort(sides);
    sides.erase(std::unique(sides.begin(), sides.end()), sides.end());
    EdgeGraph graph(mesh.vertex_count);
    for (const auto& [a, b] : sides) connect(surface, a, b, graph);
    return graph;
}

// The nearest sample of every vertex, along the edges.
class Cells {
  public:
    std::vector<Index> samples;  // welded vertices
    std::vector<Index> owner;    // per welded vertex: index of its sample in `samples`

    explicit Cells(const Surface& surface)
        : owner(surface.welded.vertex_count, kNone),
          graph_(build_graph(surface)),
          distance_(graph_.size(), std::numeric_limits<float>::infinity()) {}

    // Adds samples from some vertices until each of them is within the radius of a sample: the farthest
    // vertex first, among equals the lowest. A distance in the queue may be out of date, because distances
    // only decrease.
    void sample(std::span<const Index> among, float radius) {
        using Far = std::pair<float, Index>;
        const auto after = [](const Far& x, const Far& y) {
            return std::pair(x.first, -x.second) < std::pair(y.first, -y.second);
        };
        std::vector<Far> known;
        for (const Index v : among) known.emplace_back(distance_[v], v);
        std::priority_queue<Far, std::vector<Far>, decltype(after)> farthest(after, std::move(known));
        while (!farthest.empty()) {
            const auto [distance, v] = farthest.top();
            farthest.pop();
            if (distance_[v] <= radius) continue;
            if (distance_[v] < distance)
                farthest.emplace(distance_[v], v);
            else
                grow(v);
        }
    }

  private:
    // Makes the cell of a new sample: the vertices that are nearer to it than to all samples before.
    void grow(Index sample) {
        const Index number = static_cast<Index>(samples.size());
        samples.push_back(sample);
        shortest_paths(graph_, std::span(&sample, 1), std::numeric_limits<float>::infinity(), distance_,
                       [&](Index vertex) { owner[vertex] = number; });
    }

    EdgeGraph graph_;
    std::vector<float> distance_;
};

using Corners = std::array<Index, 3>;

// The triangles where three cells meet. Along a ragged border of two cells, a third one may meet them several
// times with opposite windings. Only the excess of one winding counts. A triangle is left out if one of its
// directed sides is already used.
std::vector<Corners> triangles_between(const Surface& surface, std::span<const Index> owner) {
    std::map<Corners, int> meetings;  // sorted corners, and the excess of their winding
    for (Index t = 0; t < Index(surface.triangles.size()); ++t) {
        const auto [u, v, w] = welded_vertices(surface, t);
        const Index a = owner[u], b = owner[v], c = owner[w];
        if (a == b || b == c || c == a) continue;
        Corners sorted{a, b, c};
        std::ranges::sort(sorted);
        const bool even =
            sorted == Corners{a, b, c} || sorted == Corners{b, c, a} || sorted == Corners{c, a, b};
        meetings[sorted] += even ? 1 : -1;
    }
    std::vector<Corners> out;
    std::set<std::pair<Index, Index>> used;  // directed sides
    for (const auto& [corners, excess] : meetings) {
        if (excess == 0) continue;
        auto [a, b, c] = corners;
        if (excess < 0) std::swap(b, c);
        const std::pair<Index, Index> sides[3] = {{a, b}, {b, c}, {c, a}};
        if (std::ranges::any_of(sides, [&](const auto& side) { return used.contains(side); })) continue;
        used.insert(std::begin(sides), std::end(sides));
        out.push_back({a, b, c});
    }
    return out;
}

// Without the triangles of small parts, unless there are no others.
std::vector<Corners> without_small_parts(const std::vector<Corners>& triangles,
                                         std::span<const Vec3> positions, float spacing) {
    DisjointSets sets(static_cast<Index>(positions.size()));
    for (const auto& [a, b, c] : triangles) sets.unite(a, b), sets.unite(b, c);
    std::vector<double> area(positions.size(), 0.0);
    for (const auto& [a, b, c] : triangles) {
        const Vec3 ab = positions[b] - positions[a], ac = positions[c] - positions[a];
        area[sets.find(a)] += 0.5 * double(glm::length(glm::cross(ab, ac)));
    }
    std::vector<Corners> out;
    for (const Corners& triangle : triangles)
        if (area[sets.find(triangle[0])] >= double(kSmallPart * spacing * spacing)) out.push_back(triangle);
    return out.empty() ? triangles : out;
}

PolygonMesh polygons_of(const std::vector<Corners>& triangles) {
    PolygonMesh out;
    for (const auto& triangle : triangles) {
        out.corner_vertex.insert(out.corner_vertex.end(), triangle.begin(), triangle.end());
        out.polygon_start.push_back(out.corners());
    }
    return out;
}

// The mean length of the sides of the triangle around a random point of the surface.
float side_by_area(const Surface& surface) {
    double sum = 0.0, area = 0.0;
    for (Index t = 0; t < Index(surface.triangles.size()); ++t) {
        const auto [u, v, w] = welded_vertices(surface, t);
        const Vec3 a = surface.positions_rest[u], b = surface.positions_rest[v],
                   c = surface.positions_rest[w];
        const double twice = glm::length(glm::cross(b - a, c - a));
        sum += twice * (glm::distance(a, b) + glm::distance(b, c) + glm::distance(c, a)) / 3.0;
        area += twice;
    }
    return area > 0.0 ? float(sum / area) : 0.0f;
}

// The vertices that samples are chosen among: those of the base mesh or, if it is not so dense, of its
// smooth surface.
struct Candidates {
    Surface surface;
    SparseRows from_base;            // positions <- welded vertices of the base mesh
    std::vector<Index> base_vertex;  // the nearest welded vertex of the base mesh
};

// How often the mesh must be subdivided. Both means count: a vertex that strayed far away makes long sides
// around most of the area.
Index levels_for(const Surface& base, float spacing) {
    Index levels = 0;
    float side = std::min(side_by_area(base), mean_edge(base));
    if (side <= kDense * spacing) return levels;
    double corners = base.welded.corners();
    while (side > kFine * spacing && levels < kMostSubdivisions && (corners *= 4.0) <= kMostCorners) {
        side /= 2.0f;
        ++levels;
    }
    return levels;
}

Candidates candidates_of(const Surface& base, float spacing) {
    const Index levels = levels_for(base, spacing);
    std::vector<Index> same(base.welded.vertex_count);
    std::iota(same.begin(), same.end(), 0);
    if (levels == 0) return {base, identity_rows(base.welded.vertex_count), std::move(same)};
    Subdivided fine = subdivide(base, base.welded, same, levels);
    return {surface_of(fine.rest, fine.mesh), std::move(fine.on_surface), std::move(fine.nearest)};
}

// Vertices at which an open border turns sharply. What is outside the coarse mesh moves with the mesh's
// border, but does not rotate with it. Without these vertices, the corner of a flying cape would keep its
// modelled shape.
std::vector<Index> corners_of_borders(const Surface& surface) {
    std::vector<std::vector<Index>> along(surface.welded.vertex_count);
    for (const Edge& e : surface.edges) {
        if (e.right != kNone) continue;
        along[e.a].push_back(e.b);
        along[e.b].push_back(e.a);
    }
    std::vector<Index> out;
    for (Index v = 0; v < Index(along.size()); ++v) {
        if (along[v].size() != 2) continue;
        const Vec3 at = surface.positions_rest[v], to = surface.positions_rest[along[v][0]] - at,
                   from = at - surface.positions_rest[along[v][1]];
        if (glm::dot(to, from) < kStraight * glm::length(to) * glm::length(from)) out.push_back(v);
    }
    return out;
}

}  // namespace

std::shared_ptr<const CoarseMesh> build_coarse(const Surface& base, float spacing) {
    if (!(spacing > 0.0f)) throw InvalidInput("spacing: expected above 0, got " + std::to_string(spacing));
    const Candidates candidates = candidates_of(base, spacing);
    const Surface& fine = candidates.surface;
    Cells cells(fine);
    std::vector<bool> is_loose(fine.welded.vertex_count, true);
    for (const Index v : fine.welded.corner_vertex) is_loose[v] = false;
    std::vector<Index> border, all;
    for (Index v = 0; v < fine.welded.vertex_count; ++v) {
        if (fine.boundary_vertex[v]) border.push_back(v);
        if (!is_loose[v]) all.push_back(v);
    }
    cells.sample(corners_of_borders(fine), kRadius * spacing);
    cells.sample(border, kRadius * spacing);
    cells.sample(all, kRadius * spacing);
    const auto triangles = triangles_between(fine, cells.owner);
    if (triangles.empty())
        throw InvalidInput("the mesh is too small for a spacing of " + std::to_string(spacing));
    auto out = std::make_shared<CoarseMesh>();
    std::vector<Vec3> rest;
    for (const Index v : cells.samples) {
        rest.push_back(fine.positions_rest[v]);
        out->from_base.append_row(candidates.from_base, v);
        out->base_vertex.push_back(base.representative[candidates.base_vertex[v]]);
        out->paint_from_base.add(out->base_vertex.back(), 1.0f);
        out->paint_from_base.end_row();
    }
    out->from_base.fit();
    out->paint_from_base.fit();
    take_cage(rest, polygons_of(without_small_parts(triangles, rest, spacing)), *out);
    return out;
}

}  // namespace rumple

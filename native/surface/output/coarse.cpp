// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/output/coarse.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <queue>
#include <set>

#include "base/expect.h"
#include "surface/mesh/edge_graph.h"
#include "surface/mesh/positions.h"
#include "surface/output/attachments.h"
#include "surface/refine/refinement.h"

namespace rumple {
namespace {

// The largest distance of a vertex from its nearest sample / mean edge length of the coarse mesh. Measured on
// shirts, sweaters and trousers.
constexpr float kRadius = 0.7f;

// Cosine: if the direction of a border changes more, the vertex is a corner.
constexpr float kStraight = 0.6f;

// Number of corrections of the cage until the smooth surface passes through the dense mesh. Each leaves about
// half of the error.
constexpr int kCorrections = 6;

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

Surface surface_of(std::span<const Vec3> positions, const std::vector<Corners>& triangles) {
    std::vector<Index> start{0}, vertex, corner;
    for (const auto& triangle : triangles) {
        for (const Index v : triangle) {
            corner.push_back(static_cast<Index>(vertex.size()));
            vertex.push_back(v);
        }
        start.push_back(static_cast<Index>(vertex.size()));
    }
    return build_surface({positions, start, vertex, corner, false});
}

float mean_edge(const Surface& surface) {
    double sum = 0.0;
    for (const Edge& e : surface.edges)
        sum += glm::distance(surface.positions_rest[e.a], surface.positions_rest[e.b]);
    return float(sum / double(surface.edges.size()));
}

// Moves vertices along their normals until the smooth surface passes through their former positions. They do
// not move along the surface: the smooth surface need not pass a vertex exactly there, and small triangles
// would turn over.
std::vector<Vec3> cage_around(const Surface& surface, const SparseRows& limit, std::span<const Vec3> wanted) {
    const std::vector<Vec3> normals = vertex_normals(surface, wanted);
    std::vector<Vec3> cage(wanted.begin(), wanted.end()), at(wanted.size());
    for (int i = 0; i < kCorrections; ++i) {
        apply<Vec3>(limit, cage, at);
        for (size_t v = 0; v < at.size(); ++v) {
            if (limit.start[v] < limit.start[v + 1])
                cage[v] += glm::dot(wanted[v] - at[v], normals[v]) * normals[v];
        }
    }
    return cage;
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

std::shared_ptr<const CoarseMesh> build_coarse(const Surface& dense, float spacing) {
    if (!(spacing > 0.0f)) throw InvalidInput("spacing: expected above 0, got " + std::to_string(spacing));
    Cells cells(dense);
    std::vector<bool> is_loose(dense.welded.vertex_count, true);
    for (const Index v : dense.welded.corner_vertex) is_loose[v] = false;
    std::vector<Index> border, all;
    for (Index v = 0; v < dense.welded.vertex_count; ++v) {
        if (dense.boundary_vertex[v]) border.push_back(v);
        if (!is_loose[v]) all.push_back(v);
    }
    cells.sample(corners_of_borders(dense), kRadius * spacing);
    cells.sample(border, kRadius * spacing);
    cells.sample(all, kRadius * spacing);
    const auto triangles = triangles_between(dense, cells.owner);
    if (triangles.empty())
        throw InvalidInput("the mesh is too small for a spacing of " + std::to_string(spacing));
    auto out = std::make_shared<CoarseMesh>();
    std::vector<Vec3> rest;
    for (const Index v : cells.samples) {
        rest.push_back(dense.positions_rest[v]);
        out->dense_vertex.push_back(dense.representative[v]);
    }
    const Surface through = surface_of(rest, triangles);
    out->limit = vertex_limit_stencils(through);
    out->surface = surface_of(cage_around(through, out->limit, rest), triangles);
    out->mean_edge = mean_edge(out->surface);
    return out;
}

std::vector<Vec3> coarse_positions(const CoarseMesh& coarse, const Surface& dense,
                                   std::span<const Vec3> positions) {
    check_frame(dense, positions);  // needed also without coarse vertices
    const std::vector<Vec3> welded = weld_positions(dense, positions);
    std::vector<Vec3> wanted;
    for (const Index v : coarse.dense_vertex) wanted.push_back(welded[dense.welded_of[v]]);
    return cage_around(coarse.surface, coarse.limit, wanted);
}

}  // namespace rumple

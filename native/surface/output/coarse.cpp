// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/output/coarse.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numeric>
#include <queue>
#include <set>

#include "base/expect.h"
#include "surface/mesh/disjoint_sets.h"
#include "surface/mesh/edge_graph.h"
#include "surface/mesh/positions.h"
#include "surface/mesh/uneven.h"
#include "surface/output/as_modelled.h"
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

// A mesh whose sides are longer than kDense * spacing is subdivided until they are at most kFine * spacing.
// Among fewer vertices to choose from, triangles would be as long and as thin as the polygons of the mesh.
constexpr float kDense = 0.75f, kFine = 0.4f;
constexpr Index kMostSubdivisions = 2;
constexpr Index kMostCorners = 400'000;  // of the subdivided mesh: about 0.4 s

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

Surface surface_of(std::span<const Vec3> positions, const PolygonMesh& polygons) {
    return build_surface(
        {positions, polygons.polygon_start, polygons.corner_vertex, fan_triangles(polygons), false});
}

PolygonMesh polygons_of(const std::vector<Corners>& triangles) {
    PolygonMesh out;
    for (const auto& triangle : triangles) {
        out.corner_vertex.insert(out.corner_vertex.end(), triangle.begin(), triangle.end());
        out.polygon_start.push_back(out.corners());
    }
    return out;
}

// The column with the largest weight in a row; of equal ones the first.
Index largest(const SparseRows& rows, Index r) {
    const auto from = rows.weight.begin() + rows.start[r];
    return rows.index[std::max_element(from, rows.weight.begin() + rows.start[r + 1]) - rows.weight.begin()];
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

float mean_edge(const Surface& surface) {
    double sum = 0.0;
    for (const Edge& e : surface.edges)
        sum += glm::distance(surface.positions_rest[e.a], surface.positions_rest[e.b]);
    return float(sum / double(surface.edges.size()));
}

// The vertices that samples are chosen among: those of the dense mesh or, if it is not so dense, of its
// smooth surface.
struct Candidates {
    Surface surface;
    SparseRows from_dense;            // positions <- welded vertices of the dense mesh
    std::vector<Index> dense_vertex;  // the nearest welded vertex of the dense mesh
};

// How often the mesh must be subdivided. Both means count: a vertex that strayed far away makes long sides
// around most of the area.
Index levels_for(const Surface& dense, float spacing) {
    Index levels = 0;
    float side = std::min(side_by_area(dense), mean_edge(dense));
    if (side <= kDense * spacing) return levels;
    double corners = dense.welded.corners();
    while (side > kFine * spacing && levels < kMostSubdivisions && (corners *= 4.0) <= kMostCorners) {
        side /= 2.0f;
        ++levels;
    }
    return levels;
}

Candidates candidates_of(const Surface& dense, float spacing) {
    const Index levels = levels_for(dense, spacing);
    if (levels == 0) {
        std::vector<Index> same(dense.welded.vertex_count);
        std::iota(same.begin(), same.end(), 0);
        return {dense, identity_rows(dense.welded.vertex_count), std::move(same)};
    }
    Candidates out;
    const FineMesh fine = refine_subdivision(dense.welded, levels);
    out.from_dense = subdivision_stencils(dense.welded, levels, true);
    std::vector<Vec3> rest(out.from_dense.rows());
    apply<Vec3>(out.from_dense, dense.positions_rest, rest);
    out.surface = surface_of(rest, fine.mesh);
    for (Index v = 0; v < fine.vertex_from_parent.rows(); ++v)
        out.dense_vertex.push_back(largest(fine.vertex_from_parent, v));
    return out;
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

// A mesh whose smooth surface passes through `rest`, the places of its vertices.
void take_cage(std::span<const Vec3> rest, const PolygonMesh& polygons, CoarseMesh& out) {
    const Surface through = surface_of(rest, polygons);
    out.limit = vertex_limit_stencils(through);
    out.surface = surface_of(cage_around(through, out.limit, rest), polygons);
    out.mean_edge = mean_edge(out.surface);
}

}  // namespace

std::shared_ptr<const CoarseMesh> build_as_modelled(const Surface& dense, float least_edge) {
    if (!(least_edge > 0.0f))
        throw InvalidInput("least_edge: expected above 0, got " + std::to_string(least_edge));
    std::vector<Index> vertex(dense.welded.vertex_count);
    std::iota(vertex.begin(), vertex.end(), 0);
    std::optional<MeshBefore> before = joined_triangles(dense);
    if (!before) before = undivided(dense.welded);
    for (; before; before = undivided(before->mesh)) {
        std::vector<Vec3> rest;
        for (Index& v : before->vertex) rest.push_back(dense.positions_rest[v = vertex[v]]);
        vertex = before->vertex;
        const Surface surface = surface_of(rest, before->mesh);
        if (mean_edge(surface) < least_edge) continue;
        if (is_uneven(surface, least_edge)) break;
        auto out = std::make_shared<CoarseMesh>();
        for (const Index v : vertex) {
            out->from_dense.add(v, 1.0f);
            out->from_dense.end_row();
            out->dense_vertex.push_back(dense.representative[v]);
        }
        take_cage(rest, before->mesh, *out);
        return out;
    }
    throw InvalidInput("the mesh was not modelled with even faces of such edges");
}

std::shared_ptr<const CoarseMesh> build_coarse(const Surface& dense, float spacing) {
    if (!(spacing > 0.0f)) throw InvalidInput("spacing: expected above 0, got " + std::to_string(spacing));
    const Candidates candidates = candidates_of(dense, spacing);
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
        out->from_dense.append_row(candidates.from_dense, v);
        out->dense_vertex.push_back(dense.representative[candidates.dense_vertex[v]]);
    }
    out->from_dense.fit();
    take_cage(rest, polygons_of(without_small_parts(triangles, rest, spacing)), *out);
    return out;
}

std::vector<Vec3> coarse_positions(const CoarseMesh& coarse, const Surface& dense,
                                   std::span<const Vec3> positions) {
    check_frame(dense, positions);  // needed also without coarse vertices
    const std::vector<Vec3> welded = weld_positions(dense, positions);
    std::vector<Vec3> wanted(coarse.from_dense.rows());
    apply<Vec3>(coarse.from_dense, welded, wanted);
    return cage_around(coarse.surface, coarse.limit, wanted);
}

}  // namespace rumple

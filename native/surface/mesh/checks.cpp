// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/mesh/checks.h"

#include <OpenMesh/Core/Mesh/PolyConnectivity.hh>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>

#include "base/expect.h"
#include "surface/mesh/disjoint_sets.h"

namespace rumple {
namespace {

std::string text(std::size_t number) {
    return std::to_string(number);
}

std::string edge_name(Index a, Index b) {
    return "edge " + text(a) + "-" + text(b);
}

void check_polygon_start(std::span<const Index> start, std::size_t corners) {
    if (start.size() < 2) throw InvalidInput("polygon_start: the mesh has no faces");
    if (start[0] != 0) throw InvalidInput("polygon_start: must begin with 0, is " + std::to_string(start[0]));
    for (std::size_t p = 0; p + 1 < start.size(); ++p) {
        const std::int64_t size = std::int64_t(start[p + 1]) - start[p];
        if (size < 3) {
            throw InvalidInput("polygon_start: face " + text(p) + " has " + std::to_string(size) +
                               " corners, at least 3 are needed");
        }
    }
    if (static_cast<std::size_t>(start.back()) != corners) {
        throw InvalidInput("polygon_start: ends at " + std::to_string(start.back()) +
                           ", but corner_vertex has " + text(corners) + " corners");
    }
}

void check_corners(std::span<const Index> corner_vertex, std::size_t vertices) {
    for (std::size_t c = 0; c < corner_vertex.size(); ++c) {
        const Index v = corner_vertex[c];
        if (v < 0 || static_cast<std::size_t>(v) >= vertices) {
            throw InvalidInput("corner_vertex: corner " + text(c) + " names vertex " + std::to_string(v) +
                               ", but the mesh has " + text(vertices) + " vertices");
        }
    }
}

// Checks triangle t and returns its polygon.
std::size_t check_triangle(const SurfaceInput& input, std::size_t t) {
    const std::string name = "triangle_corner: triangle " + text(t);
    const auto corner = input.triangle_corner.subspan(3 * t, 3);
    for (Index c : corner) {
        if (c < 0 || static_cast<std::size_t>(c) >= input.corner_vertex.size()) {
            throw InvalidInput(name + " names corner " + std::to_string(c) + ", but the mesh has " +
                               text(input.corner_vertex.size()) + " corners");
        }
    }
    const auto start = input.polygon_start;
    const std::size_t p = std::upper_bound(start.begin(), start.end(), corner[0]) - start.begin() - 1;
    for (Index c : corner) {
        if (c < start[p] || c >= start[p + 1]) {
            throw InvalidInput(name + " takes its corners from more than one face");
        }
    }
    if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) {
        throw InvalidInput(name + " uses one corner twice");
    }
    return p;
}

void check_triangles(const SurfaceInput& input) {
    const auto start = input.polygon_start;
    const std::size_t entries = input.triangle_corner.size();
    if (entries % 3 != 0) {
        throw InvalidInput("triangle_corner: " + text(entries) + " entries, not a multiple of 3");
    }
    std::vector<Index> found(start.size() - 1, 0);
    for (std::size_t t = 0; t < entries / 3; ++t) ++found[check_triangle(input, t)];
    for (std::size_t p = 0; p < found.size(); ++p) {
        const Index expected = start[p + 1] - start[p] - 2;
        if (found[p] != expected) {
            throw InvalidInput("triangle_corner: face " + text(p) + " has " + text(found[p]) +
                               " triangles, expected " + text(expected));
        }
    }
}

void check_creases(const SurfaceInput& input) {
    const std::size_t vertices = input.positions_rest.size();
    for (std::size_t k = 0; k < input.creases.size(); ++k) {
        const Crease& crease = input.creases[k];
        for (const Index v : {crease.a, crease.b}) {
            if (v >= 0 && static_cast<std::size_t>(v) < vertices) continue;
            throw InvalidInput("crease_edge: crease " + text(k) + " names vertex " + std::to_string(v) +
                               ", but the mesh has " + text(vertices) + " vertices");
        }
        if (!(crease.sharpness >= 0.0f))  // false for NaN
            throw InvalidInput("crease_sharpness: expected 0 or more, got " +
                               std::to_string(crease.sharpness) + " at crease " + text(k));
    }
}

}  // namespace

std::vector<EdgeUse> collect_edge_uses(const PolygonMesh& mesh) {
    std::vector<EdgeUse> found;
    found.reserve(mesh.corner_vertex.size());
    std::vector<Index> begin_of(mesh.vertex_count + 1, 0);  // per lower vertex: the index of its first use
    for (Index p = 0; p < mesh.polygons(); ++p) {
        const Index begin = mesh.polygon_start[p], end = mesh.polygon_start[p + 1];
        for (Index c = begin; c < end; ++c) {
            const Index from = mesh.corner_vertex[c];
            const Index to = mesh.corner_vertex[c + 1 < end ? c + 1 : begin];
            found.push_back({std::min(from, to), std::max(from, to), p, c, from < to});
            ++begin_of[found.back().a + 1];
        }
    }
    std::partial_sum(begin_of.begin(), begin_of.end(), begin_of.begin());
    // A vertex has few uses. Grouped by vertex they are sorted much faster than all at once.
    std::vector<EdgeUse> uses(found.size());
    std::vector<Index> next(begin_of.begin(), begin_of.end() - 1);
    for (const EdgeUse& use : found) uses[next[use.a]++] = use;
    for (Index v = 0; v < mesh.vertex_count; ++v) {
        std::sort(uses.begin() + begin_of[v], uses.begin() + begin_of[v + 1],
                  [](const EdgeUse& x, const EdgeUse& y) {
                      return std::tie(x.b, x.corner) < std::tie(y.b, y.corner);
                  });
    }
    return uses;
}

std::size_t edge_run_end(const std::vector<EdgeUse>& uses, std::size_t begin) {
    std::size_t end = begin + 1;
    while (end < uses.size() && uses[end].a == uses[begin].a && uses[end].b == uses[begin].b) ++end;
    return end;
}

void check_arrays(const SurfaceInput& input) {
    expect_finite("positions_rest", input.positions_rest, "vertex");
    check_polygon_start(input.polygon_start, input.corner_vertex.size());
    check_corners(input.corner_vertex, input.positions_rest.size());
    check_triangles(input);
    check_creases(input);
}

std::vector<std::vector<Index>> find_equal_polygons(const PolygonMesh& mesh) {
    std::vector<Index> sorted = mesh.corner_vertex;
    const auto corners_of = [&](Index p) {
        return std::span<const Index>(sorted).subspan(mesh.polygon_start[p], mesh.polygon_size(p));
    };
    for (Index p = 0; p < mesh.polygons(); ++p) {
        std::sort(sorted.begin() + mesh.polygon_start[p], sorted.begin() + mesh.polygon_start[p + 1]);
    }
    std::vector<Index> order(mesh.polygons());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](Index p, Index q) {
        const auto x = corners_of(p), y = corners_of(q);
        if (std::lexicographical_compare(x.begin(), x.end(), y.begin(), y.end())) return true;
        if (std::lexicographical_compare(y.begin(), y.end(), x.begin(), x.end())) return false;
        return p < q;
    });
    std::vector<std::vector<Index>> equal;
    for (std::size_t i = 0, end = 0; i < order.size(); i = end) {
        const auto same = [&](Index p) {
            const auto x = corners_of(order[i]), y = corners_of(p);
            return std::equal(x.begin(), x.end(), y.begin(), y.end());
        };
        for (end = i + 1; end < order.size() && same(order[end]);) ++end;
        if (end - i > 1) equal.emplace_back(order.begin() + i, order.begin() + end);
    }
    std::sort(equal.begin(), equal.end());
    return equal;
}

std::pair<Index, Index> find_duplicate_polygons(const PolygonMesh& mesh) {
    const auto equal = find_equal_polygons(mesh);
    return equal.empty() ? std::pair{kNone, kNone} : std::pair{equal[0][0], equal[0][1]};
}

void check_polygons(const PolygonMesh& mesh) {
    std::vector<Index> seen_in(mesh.vertex_count, kNone);
    for (Index p = 0; p < mesh.polygons(); ++p) {
        for (Index c = mesh.polygon_start[p]; c < mesh.polygon_start[p + 1]; ++c) {
            const Index v = mesh.corner_vertex[c];
            if (seen_in[v] == p)
                throw TopologyError("face " + text(p) + " uses vertex " + text(v) + " twice");
            seen_in[v] = p;
        }
    }
    const auto [p, q] = find_duplicate_polygons(mesh);
    if (p != kNone) {
        throw TopologyError("faces " + text(p) + " and " + text(q) +
                            " use the same vertices; delete one of them");
    }
}

void check_edges(const PolygonMesh& mesh) {
    const std::vector<EdgeUse> uses = collect_edge_uses(mesh);
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
        end = edge_run_end(uses, i);
        const std::string name = edge_name(uses[i].a, uses[i].b);
        if (end - i > 2) {
            throw TopologyError(name + " is used by " + text(end - i) +
                                " faces, at most 2 can meet at an edge");
        }
        if (end - i == 2 && uses[i].forward == uses[i + 1].forward) {
            throw TopologyError("faces " + text(uses[i].polygon) + " and " + text(uses[i + 1].polygon) +
                                " meet at " + name + " with opposite normals; recalculate the normals");
        }
    }
}

PolygonMesh split_fans(const PolygonMesh& mesh, std::vector<Index>& fans) {
    // Two corners of one vertex belong to the same fan if their polygons share an edge at it.
    DisjointSets sets(mesh.corners());
    const std::vector<EdgeUse> uses = collect_edge_uses(mesh);
    std::vector<Index> next(mesh.corners());
    for (Index p = 0; p < mesh.polygons(); ++p) {
        const Index begin = mesh.polygon_start[p], end = mesh.polygon_start[p + 1];
        for (Index c = begin; c < end; ++c) next[c] = c + 1 < end ? c + 1 : begin;
    }
    for (std::size_t i = 0; i + 1 < uses.size(); ++i) {
        const EdgeUse &x = uses[i], &y = uses[i + 1];
        if (x.a != y.a || x.b != y.b) continue;
        sets.unite(x.corner, next[y.corner]);
        sets.unite(y.corner, next[x.corner]);
    }
    PolygonMesh split{0, mesh.polygon_start, std::vector<Index>(mesh.corner_vertex.size())};
    fans.assign(mesh.vertex_count, 0);
    for (Index c = 0; c < mesh.corners(); ++c) {
        const Index root = sets.find(c);
        if (root == c) {  // a root is the lowest corner of its fan, so it is visited first
            split.corner_vertex[c] = split.vertex_count++;
            ++fans[mesh.corner_vertex[c]];
        } else {
            split.corner_vertex[c] = split.corner_vertex[root];
        }
    }
    return split;
}

std::vector<Edge> check_manifold(const PolygonMesh& mesh) {
    using Checker = OpenMesh::PolyConnectivity;  // without points: only connectivity is checked
    // OpenMesh also prints errors. Our own messages replace them.
    [[maybe_unused]] static const bool silenced = (::omerr().disable(), true);
    Checker checker;
    checker.reserve(mesh.vertex_count, mesh.vertex_count + mesh.polygons(), mesh.polygons());
    std::vector<Checker::VertexHandle> vertices(mesh.vertex_count);
    for (auto& vertex : vertices) vertex = checker.new_vertex();
    std::vector<Checker::VertexHandle> face;
    for (Index p = 0; p < mesh.polygons(); ++p) {
        face.clear();
        for (Index c = mesh.polygon_start[p]; c < mesh.polygon_start[p + 1]; ++c) {
            face.push_back(vertices[mesh.corner_vertex[c]]);
        }
        if (checker.add_face(face).is_valid()) continue;
        throw TopologyError("face " + text(p) + " cannot be joined to its neighbours in a manifold");
    }
    std::vector<Edge> edges;
    edges.reserve(checker.n_edges());
    for (const auto edge : checker.edges()) {
        const Index a = edge.v0().idx(), b = edge.v1().idx();
        const Index p = edge.h0().face().idx(), q = edge.h1().face().idx();  // -1 = kNone without a face
        const bool is_border = p == kNone || q == kNone;
        edges.push_back({std::min(a, b), std::max(a, b), is_border ? std::max(p, q) : std::min(p, q),
                         is_border ? kNone : std::max(p, q)});
    }
    return edges;
}

}  // namespace rumple

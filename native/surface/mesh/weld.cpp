// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/mesh/weld.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <unordered_map>

#include "base/tolerances.h"
#include "surface/mesh/checks.h"
#include "surface/mesh/disjoint_sets.h"
#include "surface/query/bounds.h"

namespace rumple {
namespace {

using Cell = std::array<std::int64_t, 3>;

struct CellHash {
    std::size_t operator()(const Cell& cell) const {
        std::uint64_t hash = 0;
        for (std::int64_t x : cell) hash = (hash ^ static_cast<std::uint64_t>(x)) * 0x9E3779B97F4A7C15ull;
        return hash ^ (hash >> 32);
    }
};

// place[v]: the lowest of `vertices` at the same place as v; kNone for others. A vertex joins an earlier
// place within `distance`; its distance to the place's first vertex counts, so places do not form chains.
std::vector<Index> find_places(std::span<const Vec3> positions, const std::vector<Index>& vertices,
                               double distance) {
    std::vector<Index> place(positions.size(), kNone);
    std::unordered_map<Cell, std::vector<Index>, CellHash> places;
    const auto coordinate = [&](float x) { return static_cast<std::int64_t>(std::floor(x / distance)); };
    for (Index v : vertices) {
        const Vec3 p = positions[v];
        const Cell cell{coordinate(p.x), coordinate(p.y), coordinate(p.z)};
        for (int neighbour = 0; neighbour < 27; ++neighbour) {
            const Cell near{cell[0] + neighbour % 3 - 1, cell[1] + neighbour / 3 % 3 - 1,
                            cell[2] + neighbour / 9 - 1};
            const auto found = places.find(near);
            if (found == places.end()) continue;
            for (Index u : found->second) {
                const bool close = glm::length(glm::dvec3(p) - glm::dvec3(positions[u])) <= distance;
                if (close && (place[v] == kNone || u < place[v])) place[v] = u;
            }
        }
        if (place[v] == kNone) {
            place[v] = v;
            places[cell].push_back(v);
        }
    }
    return place;
}

// A boundary edge between two places, a < b.
struct BoundaryEdge {
    Index a, b;
    bool forward;
    Index corner;
    Index vertex[2];  // at a, at b
};

std::vector<BoundaryEdge> collect_boundary_edges(const std::vector<EdgeUse>& uses,
                                                 const std::vector<Index>& place) {
    std::vector<BoundaryEdge> boundary;
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
        end = edge_run_end(uses, i);
        if (end - i != 1) continue;
        Index from = uses[i].a, to = uses[i].b;
        if (!uses[i].forward) std::swap(from, to);
        if (place[from] == place[to]) continue;  // an edge of zero length has no direction for a pair
        const bool forward = place[from] < place[to];
        if (!forward) std::swap(from, to);
        boundary.push_back({place[from], place[to], forward, uses[i].corner, {from, to}});
    }
    std::sort(boundary.begin(), boundary.end(), [](const BoundaryEdge& x, const BoundaryEdge& y) {
        return std::tie(x.a, x.b, x.corner) < std::tie(y.a, y.b, y.corner);
    });
    return boundary;
}

using SeamPair = std::array<BoundaryEdge, 2>;

// Pairs of boundary edges that lie on one another. `crowded` receives a vertex of every place with more than
// two.
std::vector<SeamPair> pair_edges(const std::vector<BoundaryEdge>& boundary, std::vector<Index>& crowded) {
    std::vector<SeamPair> pairs;
    for (std::size_t i = 0, end = 0; i < boundary.size(); i = end) {
        end = i + 1;
        while (end < boundary.size() && boundary[end].a == boundary[i].a &&
               boundary[end].b == boundary[i].b) {
            ++end;
        }
        if (end - i == 2) pairs.push_back({boundary[i], boundary[i + 1]});
        if (end - i > 2) crowded.push_back(std::min(boundary[i].vertex[0], boundary[i + 1].vertex[0]));
    }
    return pairs;
}

// Classes (their lowest vertices) that make the mesh invalid if they are joined.
std::vector<Index> find_broken_classes(const PolygonMesh& mesh, const std::vector<Index>& class_of) {
    PolygonMesh welded = mesh;
    for (Index& v : welded.corner_vertex) v = class_of[v];
    std::vector<Index> broken;
    std::vector<Index> seen_in(mesh.vertex_count, kNone);
    for (Index p = 0; p < welded.polygons(); ++p) {
        for (Index c = welded.polygon_start[p]; c < welded.polygon_start[p + 1]; ++c) {
            const Index v = welded.corner_vertex[c];
            if (seen_in[v] == p) broken.push_back(v);
            seen_in[v] = p;
        }
    }
    if (!broken.empty()) return broken;
    const std::vector<EdgeUse> uses = collect_edge_uses(welded);
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
        end = edge_run_end(uses, i);
        if (end - i > 2 || (end - i == 2 && uses[i].forward == uses[i + 1].forward)) {
            broken.push_back(uses[i].a);
            broken.push_back(uses[i].b);
        }
    }
    const Index twin = find_duplicate_polygons(welded).second;
    for (Index c = 0; twin != kNone && c < welded.polygon_size(twin); ++c) {
        broken.push_back(welded.corner_vertex[welded.polygon_start[twin] + c]);
    }
    return broken;
}

// Vertices with a boundary edge, ascending.
std::vector<Index> find_rim(const std::vector<EdgeUse>& uses) {
    std::vector<Index> rim;
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
        end = edge_run_end(uses, i);
        if (end - i == 1) rim.insert(rim.end(), {uses[i].a, uses[i].b});
    }
    std::sort(rim.begin(), rim.end());
    rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
    return rim;
}

std::vector<Index> places_of_rim(const std::vector<EdgeUse>& uses, std::span<const Vec3> positions) {
    return find_places(positions, find_rim(uses), kWeldDistance * bounding_diagonal(positions));
}

// Joins the seams without a barred vertex. A seam is joined at both ends or not at all: joined at one end,
// its faces would meet only in a point.
std::vector<Index> join_seams(const std::vector<SeamPair>& seams, const std::vector<bool>& barred) {
    DisjointSets classes(static_cast<Index>(barred.size()));
    for (const auto& [x, y] : seams) {
        bool free = true;
        for (const BoundaryEdge& side : {x, y})
            free = free && !barred[side.vertex[0]] && !barred[side.vertex[1]];
        if (!free) continue;
        for (int end = 0; end < 2; ++end) classes.unite(x.vertex[end], y.vertex[end]);
    }
    return classes.roots();
}

}  // namespace

std::vector<std::array<Index, 2>> find_seams(const PolygonMesh& mesh, std::span<const Vec3> positions) {
    const std::vector<EdgeUse> uses = collect_edge_uses(mesh);
    const std::vector<Index> place = places_of_rim(uses, positions);
    std::vector<Index> crowded;
    std::vector<std::array<Index, 2>> corners;
    for (const auto& [x, y] : pair_edges(collect_boundary_edges(uses, place), crowded))
        corners.push_back({x.corner, y.corner});
    return corners;
}

Weld find_weld(const PolygonMesh& mesh, std::span<const Vec3> positions) {
    const std::vector<EdgeUse> uses = collect_edge_uses(mesh);
    const std::vector<Index> place = places_of_rim(uses, positions);
    std::vector<Index> refused;
    std::vector<SeamPair> seams = pair_edges(collect_boundary_edges(uses, place), refused);
    std::erase_if(seams, [&](const SeamPair& pair) {
        const bool overlap = pair[0].forward == pair[1].forward;
        if (overlap) refused.push_back(std::min(pair[0].vertex[0], pair[1].vertex[0]));
        return overlap;
    });

    // Join all classes, then split those that make the mesh invalid. Every round bars a class of two or more
    // vertices permanently, so the loop ends.
    Weld weld;
    std::vector<bool> barred(mesh.vertex_count, false);
    for (bool clean = false; !clean;) {
        weld.class_of = join_seams(seams, barred);
        const std::vector<Index> broken = find_broken_classes(mesh, weld.class_of);
        clean = broken.empty();
        std::vector<bool> is_broken(mesh.vertex_count, false);
        for (Index v : broken) is_broken[v] = true;
        for (Index v = 0; v < mesh.vertex_count; ++v) {
            if (is_broken[weld.class_of[v]]) barred[v] = true;
        }
        refused.insert(refused.end(), broken.begin(), broken.end());
    }
    if (!refused.empty()) {
        const Index first = *std::min_element(refused.begin(), refused.end());
        weld.warnings.push_back(
            "seams: some edges that lie on one another were not joined, because faces "
            "there overlap or face opposite ways; the first is at vertex " +
            std::to_string(first));
    }
    return weld;
}

}  // namespace rumple

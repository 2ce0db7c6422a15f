// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/mesh/heal.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "base/unit_vector.h"
#include "surface/mesh/checks.h"
#include "surface/mesh/disjoint_sets.h"
#include "surface/mesh/heal_winding.h"
#include "surface/mesh/weld.h"

namespace rumple {
namespace {

constexpr double kFoldedBack = -0.9;  // cosine: polygons that meet at a sharper fold are not neighbours
constexpr double kTurned = 0.25;      // penalty on the fit of polygons with opposite winding

using Pair = std::array<Index, 2>;

// ---- the parts of a mesh that are polygons

Index copy_vertex(HealedMesh& healed, Index vertex) {
    healed.vertex_source.push_back(healed.vertex_source[vertex]);
    return healed.mesh.vertex_count++;
}

Pair named(const HealedMesh& healed, Index a, Index b) {
    const auto [low, high] = std::minmax(healed.vertex_source[a], healed.vertex_source[b]);
    return {low, high};
}

// ---- repeated and doubled

void split_repeated_vertices(HealedMesh& healed) {
    PolygonMesh& mesh = healed.mesh;
    std::vector<Index> seen_in(mesh.vertex_count, kNone);
    for (Index p = 0; p < mesh.polygons(); ++p) {
        bool repeats = false;
        for (Index c = mesh.polygon_start[p]; c < mesh.polygon_start[p + 1]; ++c) {
            Index& vertex = mesh.corner_vertex[c];
            if (seen_in[vertex] == p) {
                vertex = copy_vertex(healed, vertex);
                seen_in.push_back(p);
                repeats = true;
            }
            seen_in[vertex] = p;
        }
        if (repeats) healed.repeated.push_back(p);
    }
}

// Whether q has the vertices of p in the same cyclic order, forwards or backwards.
bool has_same_cycle(const PolygonMesh& mesh, Index p, Index q) {
    const auto of = [&](Index polygon) {
        return std::vector<Index>(mesh.corner_vertex.begin() + mesh.polygon_start[polygon],
                                  mesh.corner_vertex.begin() + mesh.polygon_start[polygon + 1]);
    };
    const std::vector<Index> x = of(p), y = of(q);
    const std::size_t size = x.size();
    const std::size_t first = std::find(y.begin(), y.end(), x[0]) - y.begin();
    bool forwards = true, backwards = true;
    for (std::size_t k = 0; k < size; ++k) {
        forwards = forwards && x[k] == y[(first + k) % size];
        backwards = backwards && x[k] == y[(first + size - k) % size];
    }
    return forwards || backwards;
}

void detach_polygon(HealedMesh& healed, Index p) {
    for (Index c = healed.mesh.polygon_start[p]; c < healed.mesh.polygon_start[p + 1]; ++c)
        healed.mesh.corner_vertex[c] = copy_vertex(healed, healed.mesh.corner_vertex[c]);
}

// Removes polygons that lie on another polygon. Polygons that only share its vertices get their own vertices.
void drop_doubled_polygons(HealedMesh& healed) {
    PolygonMesh& mesh = healed.mesh;
    std::vector<bool> dropped(mesh.polygons(), false);
    for (const std::vector<Index>& group : find_equal_polygons(mesh)) {
        for (std::size_t i = 1; i < group.size(); ++i) {
            dropped[group[i]] = has_same_cycle(mesh, group[0], group[i]);
            if (dropped[group[i]]) {
                healed.doubled.push_back({group[i], group[0]});
            } else {
                healed.repeated.push_back(group[i]);
                detach_polygon(healed, group[i]);
            }
        }
    }
    std::sort(healed.doubled.begin(), healed.doubled.end());
    std::sort(healed.repeated.begin(), healed.repeated.end());
    PolygonMesh kept{mesh.vertex_count, {0}, {}};
    std::vector<Index> polygon_source, corner_source;
    for (Index p = 0; p < mesh.polygons(); ++p) {
        if (dropped[p]) continue;
        polygon_source.push_back(p);
        for (Index c = mesh.polygon_start[p]; c < mesh.polygon_start[p + 1]; ++c) {
            kept.corner_vertex.push_back(mesh.corner_vertex[c]);
            corner_source.push_back(c);
        }
        kept.polygon_start.push_back(kept.corners());
    }
    mesh = std::move(kept);
    healed.polygon_source = std::move(polygon_source);
    healed.corner_source = std::move(corner_source);
}

// ---- edges with many polygons

// Joins the uses [begin, end) of one edge in pairs, starting with the pair that continues best.
void join_best(const std::vector<EdgeUse>& uses, std::size_t begin, std::size_t end,
               const std::vector<glm::dvec3>& inward, std::vector<Joint>& joints) {
    struct Choice {
        double fit;
        std::size_t i, j;
    };
    std::vector<Choice> choices;
    for (std::size_t i = begin; i < end; ++i) {
        for (std::size_t j = i + 1; j < end; ++j) {
            const double flat = -glm::dot(inward[i - begin], inward[j - begin]);
            if (uses[i].polygon == uses[j].polygon || flat < kFoldedBack) continue;
            choices.push_back({flat - (uses[i].forward == uses[j].forward ? kTurned : 0.0), i, j});
        }
    }
    std::stable_sort(choices.begin(), choices.end(),
                     [](const Choice& x, const Choice& y) { return x.fit > y.fit; });
    std::vector<bool> taken(end - begin, false);
    for (const auto& [fit, i, j] : choices) {
        if (taken[i - begin] || taken[j - begin]) continue;
        taken[i - begin] = taken[j - begin] = true;
        joints.push_back({{uses[i].corner, uses[j].corner}, uses[i].forward == uses[j].forward});
    }
}

// The direction from an edge into the polygon, at the corner where the edge starts: unit, at right angles to
// the edge; zero without area.
glm::dvec3 way_inward(const HealedMesh& healed, std::span<const Vec3> positions, Index polygon,
                      Index corner) {
    const auto at = [&](Index c) {
        return glm::dvec3(positions[healed.vertex_source[healed.mesh.corner_vertex[c]]]);
    };
    const glm::dvec3 along = at(next_corner(healed.mesh, polygon, corner)) - at(corner);
    return unit_or_zero(glm::cross(area_vector(healed, positions, polygon), along), 0.0);
}

// Determines which polygons stay joined. cut: receives the edges with more than two polygons.
std::vector<Joint> join_polygons(const HealedMesh& healed, std::span<const Vec3> positions,
                                 std::set<Pair>& cut) {
    const std::vector<EdgeUse> uses = collect_edge_uses(healed.mesh);
    std::vector<Joint> joints;
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
        end = edge_run_end(uses, i);
        if (end - i == 2) {
            joints.push_back({{uses[i].corner, uses[i + 1].corner}, uses[i].forward == uses[i + 1].forward});
        } else if (end - i > 2) {
            std::vector<glm::dvec3> inward;
            for (std::size_t k = i; k < end; ++k)
                inward.push_back(way_inward(healed, positions, uses[k].polygon, uses[k].corner));
            join_best(uses, i, end, inward, joints);
            cut.insert({uses[i].a, uses[i].b});
        }
    }
    return joints;
}

// The seams that will be welded, and seams that are not welded only because of their winding. If layers lie
// on one another, neither is turned.
std::vector<Joint> join_seams(const HealedMesh& healed, std::span<const Vec3> positions) {
    std::vector<Vec3> at;
    for (const Index v : healed.vertex_source) at.push_back(positions[v]);
    const std::vector<Index> polygon = polygons_of_corners(healed.mesh);
    const auto along = [&](Index c) {
        const Index next = next_corner(healed.mesh, polygon[c], c);
        return glm::dvec3(at[healed.mesh.corner_vertex[next]] - at[healed.mesh.corner_vertex[c]]);
    };
    std::vector<Joint> joints;
    for (const auto& [c, d] : find_seams(healed.mesh, at)) {
        const bool turned = glm::dot(along(c), along(d)) > 0.0;
        const double fold = glm::dot(way_inward(healed, positions, polygon[c], c),
                                     way_inward(healed, positions, polygon[d], d));
        if (!turned || fold < 0.0) joints.push_back({{c, d}, turned});
    }
    return joints;
}

// ---- cutting

// Splits the vertices of cut edges, so that each fan of still joined polygons has its own vertex.
void split_along(HealedMesh& healed, const std::vector<Joint>& joints, const std::set<Pair>& cut) {
    PolygonMesh& mesh = healed.mesh;
    const std::vector<Index> polygon = polygons_of_corners(mesh);
    DisjointSets fans(mesh.corners());
    for (const auto& [corner, turned] : joints) {
        const Index next[2] = {next_corner(mesh, polygon[corner[0]], corner[0]),
                               next_corner(mesh, polygon[corner[1]], corner[1])};
        fans.unite(corner[0], turned ? corner[1] : next[1]);
        fans.unite(next[0], turned ? next[1] : corner[1]);
    }
    std::vector<bool> is_cut(mesh.vertex_count, false);
    for (const Pair& edge : cut) is_cut[edge[0]] = is_cut[edge[1]] = true;
    std::vector<bool> used(mesh.vertex_count, false);  // whether a fan has already kept the vertex
    std::vector<Index> vertex_of(mesh.corners(), kNone);
    for (Index c = 0; c < mesh.corners(); ++c) {
        Index& vertex = mesh.corner_vertex[c];
        if (!is_cut[vertex]) continue;
        Index& of_fan = vertex_of[fans.find(c)];
        if (of_fan == kNone) of_fan = used[vertex] ? copy_vertex(healed, vertex) : vertex;
        used[vertex] = true;
        vertex = of_fan;
    }
}

void turn_polygons(HealedMesh& healed, const std::vector<bool>& turned) {
    for (Index p = 0; p < healed.mesh.polygons(); ++p) {
        if (!turned[p]) continue;
        const Index begin = healed.mesh.polygon_start[p], end = healed.mesh.polygon_start[p + 1];
        // The first corner does not change.
        std::reverse(healed.mesh.corner_vertex.begin() + begin + 1, healed.mesh.corner_vertex.begin() + end);
        std::reverse(healed.corner_source.begin() + begin + 1, healed.corner_source.begin() + end);
        healed.turned.push_back(healed.polygon_source[p]);
    }
}

// If a cut ends inside a part, all polygons at its last edge are still connected there. The last of these
// polygons gets its own vertices.
void detach_what_is_left(HealedMesh& healed, std::set<Pair>& named_cut) {
    for (bool clean = false; !clean;) {
        clean = true;
        const std::vector<EdgeUse> uses = collect_edge_uses(healed.mesh);
        std::set<Index> detached;
        for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
            end = edge_run_end(uses, i);
            const bool right = end - i == 1 || (end - i == 2 && uses[i].forward != uses[i + 1].forward &&
                                                uses[i].polygon != uses[i + 1].polygon);
            if (right) continue;
            clean = false;
            named_cut.insert(named(healed, uses[i].a, uses[i].b));
            detached.insert(uses[end - 1].polygon);
        }
        for (const Index p : detached) detach_polygon(healed, p);
    }
}

// The triangles of the remaining polygons, with the current indices of their corners.
std::vector<Index> triangles_of(const HealedMesh& healed, const SurfaceInput& input,
                                const std::vector<bool>& turned) {
    std::vector<Index> place(input.corner_vertex.size(), kNone);
    for (Index c = 0; c < healed.mesh.corners(); ++c) place[healed.corner_source[c]] = c;
    const std::vector<Index> polygon = polygons_of_corners(healed.mesh);
    std::vector<Index> triangle_corner;
    for (std::size_t k = 0; k < input.triangle_corner.size(); k += 3) {
        std::array<Index, 3> corner;
        for (int i = 0; i < 3; ++i) corner[i] = place[input.triangle_corner[k + i]];
        if (corner[0] == kNone) continue;
        if (turned[polygon[corner[0]]]) std::swap(corner[1], corner[2]);
        triangle_corner.insert(triangle_corner.end(), corner.begin(), corner.end());
    }
    return triangle_corner;
}

}  // namespace

HealedMesh heal_mesh(const SurfaceInput& input) {
    check_arrays(input);
    HealedMesh healed;
    healed.mesh = {static_cast<Index>(input.positions_rest.size()),
                   {input.polygon_start.begin(), input.polygon_start.end()},
                   {input.corner_vertex.begin(), input.corner_vertex.end()}};
    healed.vertex_source.resize(healed.mesh.vertex_count);
    std::iota(healed.vertex_source.begin(), healed.vertex_source.end(), 0);
    const std::span<const Vec3> positions = input.positions_rest;

    split_repeated_vertices(healed);
    drop_doubled_polygons(healed);
    std::set<Pair> cut;
    std::vector<Joint> joints = join_polygons(healed, positions, cut);
    std::vector<Joint> seams;
    if (input.weld_seams) seams = join_seams(healed, positions);
    const std::vector<bool> turned = wind_polygons(healed, positions, joints, seams, cut);
    split_along(healed, joints, cut);
    turn_polygons(healed, turned);
    std::set<Pair> named_cut;
    for (const auto& [a, b] : cut) named_cut.insert(named(healed, a, b));
    detach_what_is_left(healed, named_cut);
    healed.cut.assign(named_cut.begin(), named_cut.end());
    healed.triangle_corner = triangles_of(healed, input, turned);
    return healed;
}

}  // namespace rumple

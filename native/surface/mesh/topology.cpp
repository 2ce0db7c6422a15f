// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/mesh/topology.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <tuple>

#include "base/errors.h"
#include "base/stop.h"
#include "base/tolerances.h"
#include "surface/mesh/checks.h"
#include "surface/mesh/disjoint_sets.h"
#include "surface/mesh/weld.h"
#include "surface/query/bounds.h"

namespace rumple {
namespace {

// Reports "WHAT: 3 <things>, the first is NAME" if there is at least one.
class Tally {
  public:
    void add(const std::string& name) {
        if (count_++ == 0) first_ = name;
    }
    void report(const std::string& things, std::vector<std::string>& warnings) const {
        if (count_ == 0) return;
        warnings.push_back(things + ": " + std::to_string(count_) + ", the first is " + first_);
    }

  private:
    Index count_ = 0;
    std::string first_;
};

void join_vertices(Surface& surface, const std::vector<Index>& class_of) {
    surface.welded_of.resize(class_of.size());
    for (Index v = 0; v < surface.display.vertex_count; ++v) {
        if (class_of[v] == v) {  // the lowest of its class, so it is visited first
            surface.welded_of[v] = static_cast<Index>(surface.representative.size());
            surface.representative.push_back(v);
        } else {
            surface.welded_of[v] = surface.welded_of[class_of[v]];
        }
    }
    surface.welded = surface.display;
    surface.welded.vertex_count = static_cast<Index>(surface.representative.size());
    for (Index& v : surface.welded.corner_vertex) v = surface.welded_of[v];
}

// OpenMesh needs one vertex per fan of polygons. Two fans at one vertex (a bow tie) are allowed: OpenSubdiv
// treats such a vertex as a sharp corner, and the solver only uses edges. The edges that OpenMesh finds are
// those of the surface.
void join_fans(Surface& surface) {
    std::vector<Index> fans;
    const PolygonMesh split = split_fans(surface.welded, fans);
    surface.edges = check_manifold(split);
    std::vector<Index> vertex_of(split.vertex_count);
    for (Index c = 0; c < split.corners(); ++c)
        vertex_of[split.corner_vertex[c]] = surface.welded.corner_vertex[c];
    for (Edge& edge : surface.edges) {
        const auto [a, b] = std::minmax({vertex_of[edge.a], vertex_of[edge.b]});
        edge.a = a;
        edge.b = b;
    }
    std::sort(surface.edges.begin(), surface.edges.end(),
              [](const Edge& x, const Edge& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
    Tally loose, bow_ties;
    for (Index w = 0; w < surface.welded.vertex_count; ++w) {
        const std::string name = "vertex " + std::to_string(surface.representative[w]);
        if (fans[w] == 0) loose.add(name);
        if (fans[w] > 1) bow_ties.add(name);
    }
    loose.report("vertices without a face", surface.warnings);
    bow_ties.report("vertices at which faces meet only in a point", surface.warnings);
}

void copy_triangles(Surface& surface, const SurfaceInput& input) {
    const auto& start = surface.display.polygon_start;
    surface.triangles.reserve(input.triangle_corner.size() / 3);
    for (std::size_t k = 0; k < input.triangle_corner.size(); k += 3) {
        const Index c = input.triangle_corner[k];
        const auto polygon = std::upper_bound(start.begin(), start.end(), c) - start.begin() - 1;
        surface.triangles.push_back(
            {{c, input.triangle_corner[k + 1], input.triangle_corner[k + 2]}, static_cast<Index>(polygon)});
    }
}

// Converts creases from the caller's vertices to the welded mesh.
void keep_creases(Surface& surface, std::span<const Crease> given) {
    std::vector<Crease> creases;
    for (const Crease& crease : given) {
        const auto [a, b] = std::minmax({surface.welded_of[crease.a], surface.welded_of[crease.b]});
        const auto at = std::lower_bound(
            surface.edges.begin(), surface.edges.end(), std::pair(a, b),
            [](const Edge& e, const std::pair<Index, Index>& key) { return std::pair(e.a, e.b) < key; });
        const bool is_edge = at != surface.edges.end() && at->a == a && at->b == b && at->right != kNone;
        if (is_edge && crease.sharpness > 0.0f) creases.push_back({a, b, std::min(crease.sharpness, kSharp)});
    }
    std::sort(creases.begin(), creases.end(), [](const Crease& x, const Crease& y) {
        return std::tuple(x.a, x.b, -x.sharpness) < std::tuple(y.a, y.b, -y.sharpness);
    });
    const auto same = [](const Crease& x, const Crease& y) { return x.a == y.a && x.b == y.b; };
    creases.erase(std::unique(creases.begin(), creases.end(), same), creases.end());
    surface.welded.creases = std::move(creases);
}

void mark_border(Surface& surface) {
    surface.boundary_vertex.assign(surface.welded.vertex_count, false);
    for (const Edge& edge : surface.edges) {
        if (edge.right != kNone) continue;
        surface.boundary_vertex[edge.a] = true;
        surface.boundary_vertex[edge.b] = true;
    }
}

void warn_about_sizes(Surface& surface, double diagonal) {
    const auto position = [&](Index w) { return glm::dvec3(surface.positions_rest[w]); };
    Tally short_edges, flat_triangles;
    for (const Edge& edge : surface.edges) {
        if (glm::length(position(edge.a) - position(edge.b)) > kZeroLength * diagonal) continue;
        short_edges.add("edge " + std::to_string(surface.representative[edge.a]) + "-" +
                        std::to_string(surface.representative[edge.b]));
    }
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        const Triangle& triangle = surface.triangles[t];
        glm::dvec3 x[3];
        for (int i = 0; i < 3; ++i) x[i] = position(surface.welded.corner_vertex[triangle.corner[i]]);
        const glm::dvec3 e0 = x[1] - x[0], e1 = x[2] - x[1], e2 = x[0] - x[2];
        const double longest = std::max({glm::dot(e0, e0), glm::dot(e1, e1), glm::dot(e2, e2)});
        if (glm::length(glm::cross(e0, e1)) > kZeroArea * longest) continue;
        flat_triangles.add("triangle " + std::to_string(t) + " of face " + std::to_string(triangle.polygon));
    }
    short_edges.report("edges of zero length", surface.warnings);
    flat_triangles.report("triangles of zero area", surface.warnings);
}

}  // namespace

std::vector<Edge> collect_edges(const PolygonMesh& mesh) {
    const std::vector<EdgeUse> uses = collect_edge_uses(mesh);
    std::vector<Edge> edges;
    edges.reserve(uses.size() / 2);
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
        end = edge_run_end(uses, i);
        edges.push_back({uses[i].a, uses[i].b, uses[i].polygon, end - i > 1 ? uses[i + 1].polygon : kNone});
    }
    return edges;
}

Surface build_surface(const SurfaceInput& input) {
    check_arrays(input);
    const double diagonal = bounding_diagonal(input.positions_rest);
    if (diagonal == 0.0) throw InvalidInput("positions_rest: all vertices stand at one place");

    Surface surface;
    surface.display.vertex_count = static_cast<Index>(input.positions_rest.size());
    surface.display.polygon_start.assign(input.polygon_start.begin(), input.polygon_start.end());
    surface.display.corner_vertex.assign(input.corner_vertex.begin(), input.corner_vertex.end());
    // Before welding, so that errors have the caller's vertex numbers. find_weld() joins nothing that would
    // cause such an error.
    check_polygons(surface.display);
    check_edges(surface.display);
    stop_if_asked();

    Weld weld;
    if (input.weld_seams) {
        weld = find_weld(surface.display, input.positions_rest);
    } else {
        weld.class_of.resize(surface.display.vertex_count);
        std::iota(weld.class_of.begin(), weld.class_of.end(), 0);
    }
    surface.warnings = weld.warnings;
    stop_if_asked();
    join_vertices(surface, weld.class_of);
    stop_if_asked();
    join_fans(surface);
    stop_if_asked();

    surface.positions_rest = weld_positions(surface, input.positions_rest);
    copy_triangles(surface, input);
    keep_creases(surface, input.creases);
    mark_border(surface);
    warn_about_sizes(surface, diagonal);
    return surface;
}

std::vector<Index> fan_triangles(const PolygonMesh& mesh) {
    std::vector<Index> triangle_corner;
    for (Index p = 0; p < mesh.polygons(); ++p) {
        const Index first = mesh.polygon_start[p];
        for (Index k = 1; k + 1 < mesh.polygon_size(p); ++k)
            triangle_corner.insert(triangle_corner.end(), {first, first + k, first + k + 1});
    }
    return triangle_corner;
}

OneRings one_rings(const Surface& surface) {
    std::vector<std::vector<Index>> around(surface.welded.vertex_count);
    for (Index t = 0; t < static_cast<Index>(surface.triangles.size()); ++t) {
        const std::array<Index, 3> corners = welded_vertices(surface, t);
        for (int k = 0; k < 3; ++k) {
            const Index a = corners[k], b = corners[(k + 1) % 3];
            around[a].push_back(b);
            around[b].push_back(a);
        }
    }
    OneRings rings;
    for (std::vector<Index>& ring : around) {
        std::sort(ring.begin(), ring.end());
        ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
        rings.vertex.insert(rings.vertex.end(), ring.begin(), ring.end());
        rings.start.push_back(static_cast<Index>(rings.vertex.size()));
    }
    return rings;
}

std::vector<Index> connected_parts(const Surface& surface) {
    DisjointSets sets(surface.welded.vertex_count);
    for (const Edge& edge : surface.edges) sets.unite(edge.a, edge.b);
    return sets.roots();
}

NearTriangles near_triangles(const Surface& surface) {
    const Index triangles = static_cast<Index>(surface.triangles.size());
    const auto vertex = [&](Index t, int k) {
        return surface.welded.corner_vertex[surface.triangles[t].corner[k]];
    };
    std::vector<std::vector<Index>> around(surface.welded.vertex_count);
    for (Index t = 0; t < triangles; ++t) {
        for (int k = 0; k < 3; ++k) around[vertex(t, k)].push_back(t);
    }
    NearTriangles out;
    for (Index t = 0; t < triangles; ++t) {
        std::vector<Index> near;
        for (int k = 0; k < 3; ++k)
            near.insert(near.end(), around[vertex(t, k)].begin(), around[vertex(t, k)].end());
        std::sort(near.begin(), near.end());
        near.erase(std::unique(near.begin(), near.end()), near.end());
        out.triangle.insert(out.triangle.end(), near.begin(), near.end());
        out.start.push_back(static_cast<Index>(out.triangle.size()));
    }
    return out;
}

std::array<Index, 3> display_vertices(const Surface& surface, Index triangle) {
    const Triangle& t = surface.triangles[triangle];
    const std::vector<Index>& vertex = surface.display.corner_vertex;
    return {vertex[t.corner[0]], vertex[t.corner[1]], vertex[t.corner[2]]};
}

void weld_positions(const Surface& surface, std::span<const Vec3> display, std::span<Vec3> welded) {
    assert(display.size() == surface.welded_of.size());
    assert(welded.size() == surface.representative.size());
    if (welded.size() == display.size()) {  // nothing is joined
        for (std::size_t w = 0; w < welded.size(); ++w)
            welded[w] = display[surface.representative[w]] + 0.0f;  // 0 for -0, as the mean of two
        return;
    }
    // In double precision, so that the mean of equal positions is exactly this position.
    std::vector<glm::dvec3> sum(welded.size(), glm::dvec3(0.0));
    std::vector<Index> count(welded.size(), 0);
    for (std::size_t v = 0; v < display.size(); ++v) {
        sum[surface.welded_of[v]] += glm::dvec3(display[v]);
        ++count[surface.welded_of[v]];
    }
    for (std::size_t w = 0; w < welded.size(); ++w) welded[w] = Vec3(sum[w] / static_cast<double>(count[w]));
}

std::vector<Vec3> weld_positions(const Surface& surface, std::span<const Vec3> display) {
    std::vector<Vec3> welded(surface.representative.size());
    weld_positions(surface, display, welded);
    return welded;
}

}  // namespace rumple

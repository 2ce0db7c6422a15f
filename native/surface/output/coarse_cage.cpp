// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/output/coarse_cage.h"

#include <algorithm>
#include <numeric>

#include "surface/mesh/normals.h"
#include "surface/mesh/positions.h"
#include "surface/refine/refinement.h"

namespace rumple {
namespace {

// Number of corrections of the cage until the smooth surface passes through the base mesh. Each leaves about
// half of the error.
constexpr int kCorrections = 6;

// The column with the largest weight in a row; of equal ones the first.
Index largest(const SparseRows& rows, Index r) {
    const auto from = rows.weight.begin() + rows.start[r];
    return rows.index[std::max_element(from, rows.weight.begin() + rows.start[r + 1]) - rows.weight.begin()];
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

}  // namespace

Subdivided subdivide(const Surface& base, const PolygonMesh& mesh, std::span<const Index> vertex,
                     Index levels) {
    FineMesh fine = refine_subdivision(mesh, levels);
    Subdivided out;
    out.on_surface =
        levels == 0 ? identity_rows(mesh.vertex_count) : subdivision_stencils(mesh, levels, true);
    out.linear = std::move(fine.vertex_from_parent);
    for (SparseRows* rows : {&out.on_surface, &out.linear})
        for (Index& column : rows->index) column = vertex[column];
    for (Index v = 0; v < out.linear.rows(); ++v) out.nearest.push_back(largest(out.linear, v));
    out.rest.resize(out.on_surface.rows());
    apply<Vec3>(out.on_surface, base.positions_rest, out.rest);
    out.mesh = std::move(fine.mesh);
    return out;
}

Surface surface_of(std::span<const Vec3> positions, const PolygonMesh& polygons) {
    return build_surface(
        {positions, polygons.polygon_start, polygons.corner_vertex, fan_triangles(polygons), false});
}

float mean_edge(const Surface& surface) {
    double sum = 0.0;
    for (const Edge& e : surface.edges)
        sum += glm::distance(surface.positions_rest[e.a], surface.positions_rest[e.b]);
    return float(sum / double(surface.edges.size()));
}

void take_cage(std::span<const Vec3> rest, const PolygonMesh& polygons, CoarseMesh& out) {
    const Surface through = surface_of(rest, polygons);
    out.limit = vertex_limit_stencils(through);
    out.surface = surface_of(cage_around(through, out.limit, rest), polygons);
    out.mean_edge = mean_edge(out.surface);
}

std::shared_ptr<const CoarseMesh> of_whole_base(const CoarseMesh& of_part, const Surface& part,
                                                const Surface& base) {
    auto out = std::make_shared<CoarseMesh>(of_part);
    for (Index& welded : out->from_base.index) welded = base.welded_of[part.representative[welded]];
    return out;
}

std::vector<Vec3> coarse_positions(const CoarseMesh& coarse, const Surface& base,
                                   std::span<const Vec3> positions) {
    check_frame(base, positions);  // needed also without coarse vertices
    const std::vector<Vec3> welded = weld_positions(base, positions);
    std::vector<Vec3> wanted(coarse.from_base.rows());
    apply<Vec3>(coarse.from_base, welded, wanted);
    return cage_around(coarse.surface, coarse.limit, wanted);
}

}  // namespace rumple

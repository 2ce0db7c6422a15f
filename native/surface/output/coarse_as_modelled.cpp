// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/errors.h"
#include "surface/mesh/uneven.h"
#include "surface/output/as_modelled.h"
#include "surface/output/coarse_cage.h"

namespace rumple {
namespace {

Surface surface_at_rest(const Surface& base, const MeshBefore& mesh) {
    std::vector<Vec3> rest;
    for (const Index v : mesh.vertex) rest.push_back(base.positions_rest[v]);
    return surface_of(rest, mesh.mesh);
}

// The base with triangles joined to quads, and with subdivisions taken back while its edges or many faces are
// shorter than least_edge. `vertex` of the result is of the base. Throws InvalidInput if there is no such
// mesh.
MeshBefore modelled(const Surface& base, float least_edge) {
    std::optional<MeshBefore> mesh = joined_triangles(base);
    if (!mesh) mesh = without_loose_vertices(base.welded);
    while (mesh) {
        const Surface surface = surface_at_rest(base, *mesh);
        if (mean_edge(surface) >= least_edge && !is_uneven(surface, least_edge)) return *mesh;
        std::optional<MeshBefore> before = undivided(mesh->mesh);
        if (before)
            for (Index& v : before->vertex) v = mesh->vertex[v];
        mesh = std::move(before);
    }
    throw InvalidInput("the mesh was not modelled with even faces of such edges");
}

// How often a mesh is subdivided until its mean edge is at most most_edge.
Index levels_for(const Surface& mesh, float most_edge) {
    Index levels = 0;
    double corners = mesh.welded.corners();
    for (float edge = mean_edge(mesh); edge > most_edge && (corners *= 4.0) <= kMostCorners; edge /= 2.0f)
        ++levels;
    return levels;
}

void expect_edges(float least_edge, float most_edge) {
    if (!(least_edge > 0.0f))
        throw InvalidInput("least_edge: expected above 0, got " + std::to_string(least_edge));
    if (!(most_edge >= 2.0f * least_edge))  // else a subdivision that was taken back would be made again
        throw InvalidInput("most_edge: expected at least twice least_edge, got " + std::to_string(most_edge));
}

}  // namespace

std::shared_ptr<const CoarseMesh> build_as_modelled(const Surface& base, float least_edge, float most_edge,
                                                    bool may_be_base) {
    expect_edges(least_edge, most_edge);
    const MeshBefore mesh = modelled(base, least_edge);
    const Index levels = levels_for(surface_at_rest(base, mesh), most_edge);
    if (!may_be_base && levels == 0 && mesh.mesh.polygons() == base.welded.polygons())
        throw InvalidInput("the mesh was modelled with such edges: it needs no other");
    Subdivided fine = subdivide(base, mesh.mesh, mesh.vertex, levels);
    auto out = std::make_shared<CoarseMesh>();
    for (const Index v : fine.nearest) out->base_vertex.push_back(base.representative[v]);
    for (Index& v : fine.linear.index) v = base.representative[v];
    out->from_base = std::move(fine.on_surface);
    out->paint_from_base = std::move(fine.linear);
    take_cage(fine.rest, fine.mesh, *out);
    return out;
}

}  // namespace rumple

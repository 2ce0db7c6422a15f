// SPDX-License-Identifier: GPL-3.0-or-later
// What every coarse mesh is made of (surface/output/coarse.h).
#pragma once

#include <vector>

#include "surface/output/coarse.h"

namespace rumple {

// What a base is subdivided to has at most so many corners of polygons: about 0.4 s.
inline constexpr Index kMostCorners = 400'000;

// A subdivision of polygons whose vertices are those of the base mesh.
struct Subdivided {
    PolygonMesh mesh;
    SparseRows on_surface;       // where the smooth surface is <- welded vertices of the base
    SparseRows linear;           // values, linearly <- the same
    std::vector<Index> nearest;  // the welded vertex with the largest weight; of equal ones the first
    std::vector<Vec3> rest;      // places of its vertices on the smooth surface
};

// mesh: every vertex has a polygon. vertex: per vertex of it, the welded vertex of the base. levels: 0 keeps
// the places of the vertices. Cost: as subdivision_stencils().
Subdivided subdivide(const Surface& base, const PolygonMesh& mesh, std::span<const Index> vertex,
                     Index levels);

// A surface with these polygons. The triangles of a polygon meet at its first corner.
Surface surface_of(std::span<const Vec3> positions, const PolygonMesh& polygons);

// Of all edges at rest, object units.
float mean_edge(const Surface& surface);

// Completes a coarse mesh with these polygons: its smooth surface passes through `rest`, the places of its
// vertices.
void take_cage(std::span<const Vec3> rest, const PolygonMesh& polygons, CoarseMesh& out);

}  // namespace rumple

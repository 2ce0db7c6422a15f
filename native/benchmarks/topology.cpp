// SPDX-License-Identifier: GPL-3.0-or-later
// The topology of a surface's triangles, with our flat arrays and with OpenMesh: the time to build it once at
// rest, and the time of walks over it. docs/architecture.md has the numbers and our choice.
#include "surface/mesh/topology.h"

#include <benchmark/benchmark.h>

#include <OpenMesh/Core/Mesh/TriConnectivity.hh>
#include <algorithm>

#include "surface/mesh/triangle_net.h"
#include "tests/meshes.h"

namespace rumple {
namespace {

using HalfEdgeMesh = OpenMesh::TriConnectivity;  // a mesh without points

// side x side x 2 triangles.
Surface sheet(const benchmark::State& bench) {
    const Index side = Index(bench.range(0));
    return tests::build(tests::triangulated(tests::grid(side, side, 0.01f)));
}

HalfEdgeMesh half_edge_mesh(const Surface& surface) {
    HalfEdgeMesh mesh;
    const size_t vertices = surface.positions_rest.size(), triangles = surface.triangles.size();
    mesh.reserve(vertices, vertices + triangles, triangles);
    std::vector<OpenMesh::VertexHandle> handles(vertices);
    for (auto& handle : handles) handle = mesh.new_vertex();
    for (Index t = 0; t < Index(triangles); ++t) {
        const std::array<Index, 3> corners = welded_vertices(surface, t);
        const OpenMesh::VertexHandle face[] = {handles[corners[0]], handles[corners[1]], handles[corners[2]]};
        mesh.add_face(face, 3);
    }
    return mesh;
}

void report(benchmark::State& bench, const Surface& surface) {
    bench.counters["triangles"] = double(surface.triangles.size());
}

// ---- built at rest

void build_edges(benchmark::State& bench) {
    const Surface surface = sheet(bench);
    for (auto _ : bench) benchmark::DoNotOptimize(collect_edges(surface.welded).data());
    report(bench, surface);
}

void build_half_edges(benchmark::State& bench) {
    const Surface surface = sheet(bench);
    for (auto _ : bench) benchmark::DoNotOptimize(build_net(surface).twin.data());
    report(bench, surface);
}

void build_rings(benchmark::State& bench) {
    const Surface surface = sheet(bench);
    for (auto _ : bench) benchmark::DoNotOptimize(one_rings(surface).vertex.data());
    report(bench, surface);
}

// The steps that build a surface: the mesh is checked, welded and connected.
void build_all(benchmark::State& bench) {
    const auto mesh = tests::triangulated(tests::grid(Index(bench.range(0)), Index(bench.range(0)), 0.01f));
    for (auto _ : bench) benchmark::DoNotOptimize(tests::build(mesh).edges.data());
    report(bench, tests::build(mesh));
}

// All three of the above in one.
void build_open_mesh(benchmark::State& bench) {
    const Surface surface = sheet(bench);
    for (auto _ : bench) benchmark::DoNotOptimize(half_edge_mesh(surface).n_edges());
    report(bench, surface);
}

// The step from this mesh to one_rings(). Neighbours need a fixed order, so that every machine gives the same
// bits.
void rings_of_open_mesh(benchmark::State& bench) {
    const Surface surface = sheet(bench);
    const HalfEdgeMesh mesh = half_edge_mesh(surface);
    for (auto _ : bench) {
        OneRings rings;
        rings.vertex.reserve(2 * mesh.n_edges());
        for (const auto vertex : mesh.vertices()) {
            for (const auto other : mesh.vv_range(vertex)) rings.vertex.push_back(other.idx());
            std::sort(rings.vertex.begin() + rings.start.back(), rings.vertex.end());
            rings.start.push_back(Index(rings.vertex.size()));
        }
        benchmark::DoNotOptimize(rings.vertex.data());
    }
    report(bench, surface);
}

// ---- walks: all one-rings; all vertices on a border; all triangles around every vertex

void walk_rings(benchmark::State& bench) {
    const Surface surface = sheet(bench);
    const OneRings rings = one_rings(surface);
    for (auto _ : bench) {
        std::int64_t sum = 0;
        for (size_t v = 0; v + 1 < rings.start.size(); ++v) {
            for (Index i = rings.start[v]; i < rings.start[v + 1]; ++i) sum += rings.vertex[i];
        }
        benchmark::DoNotOptimize(sum);
    }
    report(bench, surface);
}

void walk_rings_of_open_mesh(benchmark::State& bench) {
    const Surface surface = sheet(bench);
    const HalfEdgeMesh mesh = half_edge_mesh(surface);
    for (auto _ : bench) {
        std::int64_t sum = 0;
        for (const auto vertex : mesh.vertices()) {
            for (const auto other : mesh.vv_range(vertex)) sum += other.idx();
        }
        benchmark::DoNotOptimize(sum);
    }
    report(bench, surface);
}

void walk_border(benchmark::State& bench) {
    const Surface surface = sheet(bench);
    for (auto _ : bench) {
        std::int64_t sum = 0;
        for (const bool on_border : surface.boundary_vertex) sum += on_border;
        benchmark::DoNotOptimize(sum);
    }
    report(bench, surface);
}

void walk_border_of_open_mesh(benchmark::State& bench) {
    const Surface surface = sheet(bench);
    const HalfEdgeMesh mesh = half_edge_mesh(surface);
    for (auto _ : bench) {
        std::int64_t sum = 0;
        for (const auto vertex : mesh.vertices()) sum += mesh.is_boundary(vertex);
        benchmark::DoNotOptimize(sum);
    }
    report(bench, surface);
}

// Walks over the triangles as in Wrinkle Paths: across every edge.
void walk_half_edges(benchmark::State& bench) {
    const Surface surface = sheet(bench);
    const TriangleNet net = build_net(surface);
    for (auto _ : bench) {
        std::int64_t sum = 0;
        for (Index h = 0; h < Index(net.twin.size()); ++h) {
            if (net.twin[h] != kNone) sum += triangle_of(net.twin[next_in_triangle(h)]);
        }
        benchmark::DoNotOptimize(sum);
    }
    report(bench, surface);
}

void walk_half_edges_of_open_mesh(benchmark::State& bench) {
    const Surface surface = sheet(bench);
    const HalfEdgeMesh mesh = half_edge_mesh(surface);
    for (auto _ : bench) {
        std::int64_t sum = 0;
        for (const auto half_edge : mesh.halfedges()) {
            if (mesh.is_boundary(half_edge)) continue;
            sum +=
                mesh.face_handle(mesh.opposite_halfedge_handle(mesh.next_halfedge_handle(half_edge))).idx();
        }
        benchmark::DoNotOptimize(sum);
    }
    report(bench, surface);
}

void sizes(benchmark::internal::Benchmark* bench) {
    bench->Unit(benchmark::kMicrosecond)->Arg(27)->Arg(127)->Arg(707);  // 1,458, 32,258 and 999,698 triangles
}

BENCHMARK(build_edges)->Name("Topology/Build/Edges")->Apply(sizes);
BENCHMARK(build_half_edges)->Name("Topology/Build/HalfEdges")->Apply(sizes);
BENCHMARK(build_rings)->Name("Topology/Build/OneRings")->Apply(sizes);
BENCHMARK(build_all)->Name("Topology/Build/Surface")->Apply(sizes);
BENCHMARK(build_open_mesh)->Name("Topology/Build/OpenMesh")->Apply(sizes);
BENCHMARK(rings_of_open_mesh)->Name("Topology/Build/OneRingsOfOpenMesh")->Apply(sizes);
BENCHMARK(walk_rings)->Name("Topology/Walk/OneRings")->Apply(sizes);
BENCHMARK(walk_rings_of_open_mesh)->Name("Topology/Walk/OneRingsOfOpenMesh")->Apply(sizes);
BENCHMARK(walk_border)->Name("Topology/Walk/Border")->Apply(sizes);
BENCHMARK(walk_border_of_open_mesh)->Name("Topology/Walk/BorderOfOpenMesh")->Apply(sizes);
BENCHMARK(walk_half_edges)->Name("Topology/Walk/HalfEdges")->Apply(sizes);
BENCHMARK(walk_half_edges_of_open_mesh)->Name("Topology/Walk/HalfEdgesOfOpenMesh")->Apply(sizes);

}  // namespace
}  // namespace rumple

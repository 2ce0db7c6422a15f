// SPDX-License-Identifier: GPL-3.0-or-later
// Linear weights of refined corners and vertices. OpenSubdiv's tables for them take ten times as long.
#include <algorithm>

#include "base/stop.h"
#include "surface/refine/subdivider.h"

namespace rumple {
namespace {

// The faces of one level: the polygon that contains each face, and for each corner of the face a weight for
// every corner of this polygon.
struct Corners {
    std::vector<Index> polygon;
    std::vector<std::size_t> start;  // per face: index of its first weight
    std::vector<double> weight;
};

Corners unrefined(const PolygonMesh& mesh) {
    Corners out;
    for (Index p = 0; p < mesh.polygons(); ++p) {
        const Index n = mesh.polygon_size(p);
        out.polygon.push_back(p);
        out.start.push_back(out.weight.size());
        out.weight.resize(out.weight.size() + std::size_t(n) * n, 0.0);
        for (Index i = 0; i < n; ++i) out.weight[out.start.back() + std::size_t(i) * (n + 1)] = 1.0;
    }
    return out;
}

// A corner of a refined face is at a corner, in the middle of a side, or in the centre of its parent.
void add_corner(const Far::TopologyLevel& parents, int face, int child, const double* weights, Index n,
                std::vector<double>& out) {
    const Far::ConstIndexArray vertices = parents.GetFaceVertices(face), sides = parents.GetFaceEdges(face);
    const int m = vertices.size();
    const std::size_t at = out.size();
    out.resize(at + n, 0.0);
    const auto add = [&](int corner, double share) {
        for (Index k = 0; k < n; ++k) out[at + k] += share * weights[std::size_t(corner) * n + k];
    };
    for (int i = 0; i < m; ++i) {
        if (parents.GetVertexChildVertex(vertices[i]) == child) return add(i, 1.0);
        if (parents.GetEdgeChildVertex(sides[i]) == child) return add(i, 0.5), add((i + 1) % m, 0.5);
    }
    for (int i = 0; i < m; ++i) add(i, 1.0 / m);
}

Corners refined(const Far::TopologyRefiner& refiner, int level, const Corners& before,
                const PolygonMesh& mesh) {
    const Far::TopologyLevel &parents = refiner.GetLevel(level - 1), &faces = refiner.GetLevel(level);
    Corners out;
    for (int f = 0; f < faces.GetNumFaces(); ++f) {
        stop_if_asked(std::size_t(f));
        const int parent = faces.GetFaceParentFace(f);
        const Index p = before.polygon[parent];
        out.polygon.push_back(p);
        out.start.push_back(out.weight.size());
        for (const int vertex : faces.GetFaceVertices(f))
            add_corner(parents, parent, vertex, &before.weight[before.start[parent]], mesh.polygon_size(p),
                       out.weight);
    }
    return out;
}

// Converts the weights of one corner to vertices of the mesh: sorted, one entry per column, without zeros.
void add_row(std::vector<std::pair<Index, double>>& entries, SparseRows& rows) {
    std::ranges::sort(entries);
    for (std::size_t k = 0; k < entries.size();) {
        const Index column = entries[k].first;
        double sum = 0.0;
        for (; k < entries.size() && entries[k].first == column; ++k) sum += entries[k].second;
        if (sum != 0.0) rows.add(column, static_cast<float>(sum));
    }
    rows.end_row();
}

}  // namespace

LinearRows linear_rows(const Far::TopologyRefiner& refiner, const PolygonMesh& mesh) {
    Corners last = unrefined(mesh);
    for (int l = 1; l <= refiner.GetMaxLevel(); ++l) last = refined(refiner, l, last, mesh);
    const Far::TopologyLevel& level = refiner.GetLevel(refiner.GetMaxLevel());
    LinearRows out;
    std::vector<const double*> at_vertex(level.GetNumVertices(), nullptr);  // weights of a corner
    std::vector<Index> polygon_at(level.GetNumVertices(), kNone);
    for (int f = 0; f < level.GetNumFaces(); ++f) {
        stop_if_asked(std::size_t(f));
        const Index p = last.polygon[f], n = mesh.polygon_size(p);
        const double* weight = &last.weight[last.start[f]];
        for (const int vertex : level.GetFaceVertices(f)) {
            for (Index k = 0; k < n; ++k)
                if (weight[k] != 0.0)
                    out.corner.add(mesh.polygon_start[p] + k, static_cast<float>(weight[k]));
            out.corner.end_row();
            at_vertex[vertex] = weight;
            polygon_at[vertex] = p;
            weight += n;
        }
    }
    std::vector<std::pair<Index, double>> entries;
    for (std::size_t v = 0; v < at_vertex.size(); ++v) {
        stop_if_asked(v);
        const Index p = polygon_at[v];
        entries.clear();
        for (Index k = 0; k < mesh.polygon_size(p); ++k)
            entries.emplace_back(mesh.corner_vertex[mesh.polygon_start[p] + k], at_vertex[v][k]);
        add_row(entries, out.vertex);
    }
    out.polygon = std::move(last.polygon);
    return out;
}

}  // namespace rumple

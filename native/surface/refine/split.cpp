// SPDX-License-Identifier: GPL-3.0-or-later
// "Subdividing each triangle regularly into a fixed number of similar
// sub-triangles" (section 3 of the paper).
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "base/errors.h"
#include "surface/refine/split_parts.h"

namespace rumple {
namespace {

// Fine vertices of a regularly split triangle, with index (i, j): i steps towards corner 1 and j steps
// towards corner 2, of n.
class RegularSplit {
  public:
    RegularSplit(const Surface& surface, Index n, FineMesh& fine)
        : surface_(surface),
          n_(n),
          fine_(fine),
          triangles_(surface, fine),
          base_(add_base_vertices(surface, fine)) {}

    void split(Index t) {
        const Triangle& triangle = surface_.triangles[t];
        for (int k = 0; k < 3; ++k) edge_start_[k] = edge_points(edge_key(surface_, triangle, k));
        add_inner_points(triangle);
        for (Index j = 0; j < n_; ++j) {
            for (Index i = 0; i + j < n_; ++i) {
                add(t, {{i, j}, {i + 1, j}, {i, j + 1}});
                if (i + j + 1 < n_) add(t, {{i + 1, j}, {i + 1, j + 1}, {i, j + 1}});
            }
        }
    }

  private:
    struct Step {
        Index i, j;
    };

    // The first of n - 1 vertices along the edge, from a to b; created at the first call.
    Index edge_points(const EdgeKey& key) {
        const auto [found, fresh] = edges_.try_emplace(key, fine_.mesh.vertex_count);
        for (Index k = 1; fresh && k < n_; ++k) {
            fine_.vertex_from_parent.add(key.a, static_cast<float>(n_ - k) / n_);
            fine_.vertex_from_parent.add(key.b, static_cast<float>(k) / n_);
            fine_.vertex_from_parent.end_row();
            ++fine_.mesh.vertex_count;
        }
        return found->second;
    }

    void add_inner_points(const Triangle& triangle) {
        Index column[3];
        for (int k = 0; k < 3; ++k) column[k] = surface_.welded.corner_vertex[triangle.corner[k]];
        inner_start_ = fine_.mesh.vertex_count;
        for (Index j = 1; j < n_; ++j) {
            for (Index i = 1; i + j < n_; ++i) {
                add_row(fine_.vertex_from_parent, column, weights({i, j}));
                ++fine_.mesh.vertex_count;
            }
        }
    }

    glm::dvec3 weights(Step s) const {
        return glm::dvec3(n_ - s.i - s.j, s.i, s.j) / static_cast<double>(n_);
    }

    Index on_edge(const Triangle& triangle, int k, Index step) const {
        const Index a = surface_.welded.corner_vertex[triangle.corner[k]];
        const Index b = surface_.welded.corner_vertex[triangle.corner[(k + 1) % 3]];
        return edge_start_[k] + (a < b ? step : n_ - step) - 1;
    }

    Index vertex(const Triangle& triangle, Step s) const {
        const auto base = [&](int k) { return base_[surface_.welded.corner_vertex[triangle.corner[k]]]; };
        if (s.i == n_) return base(1);
        if (s.j == n_) return base(2);
        if (s.i == 0 && s.j == 0) return base(0);
        if (s.j == 0) return on_edge(triangle, 0, s.i);
        if (s.i + s.j == n_) return on_edge(triangle, 1, s.j);
        if (s.i == 0) return on_edge(triangle, 2, n_ - s.j);
        const Index before = (s.j - 1) * (n_ - 1) - s.j * (s.j - 1) / 2;  // inner points in rows below j
        return inner_start_ + before + s.i - 1;
    }

    void add(Index t, const Step (&steps)[3]) {
        Index vertices[3];
        glm::dvec3 corner_weights[3];
        for (int k = 0; k < 3; ++k) {
            vertices[k] = vertex(surface_.triangles[t], steps[k]);
            corner_weights[k] = weights(steps[k]);
        }
        triangles_.add(t, vertices, corner_weights);
    }

    const Surface& surface_;
    const Index n_;
    FineMesh& fine_;
    FineTriangles triangles_;
    std::vector<Index> base_;
    std::map<EdgeKey, Index> edges_;
    Index edge_start_[3] = {};
    Index inner_start_ = 0;
};

}  // namespace

FineMesh refine_regular(const Surface& surface, Index segments) {
    if (segments < 1) throw InvalidInput("segments: expected at least 1, got " + std::to_string(segments));
    const double corners = 3.0 * segments * segments * static_cast<double>(surface.triangles.size());
    if (4.0 * corners > std::numeric_limits<Index>::max()) {
        throw InvalidInput("segments: " + std::to_string(segments) +
                           " make more corners than can be counted");
    }
    FineMesh fine;
    RegularSplit splitter(surface, segments, fine);
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) splitter.split(static_cast<Index>(t));
    return fine;
}

}  // namespace rumple

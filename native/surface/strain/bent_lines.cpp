// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/strain/bent_lines.h"

#include <algorithm>
#include <cmath>

#include "base/formulas.h"
#include "base/smooth_step.h"
#include "base/tolerances.h"

namespace rumple {
namespace {

// Weight of the squared second derivatives in the fit (ridge). It makes them 0 if too few vertices are around
// a vertex, as at a border.
constexpr double kRidge = 1e-2;
// The radius on which all lines bear a fold / the radius on which none do.
constexpr float kFreeRadius = 4.0f;
// Share of the squared length: every vertex counts as if it had this much more cloth to spare.
constexpr float kLeastSpare = 0.01f;
// A larger compression gives no more cloth to spare.
constexpr float kLeastStretch = 0.05f;

using Row5 = std::array<double, 5>;

// The other vertices of the polygons around every vertex, ascending.
std::vector<std::vector<Index>> polygon_rings(const PolygonMesh& mesh) {
    std::vector<std::vector<Index>> rings(size_t(mesh.vertex_count));
    for (Index p = 0; p < mesh.polygons(); ++p) {
        for (Index i = mesh.polygon_start[p]; i < mesh.polygon_start[p + 1]; ++i) {
            for (Index j = mesh.polygon_start[p]; j < mesh.polygon_start[p + 1]; ++j) {
                if (i != j) rings[mesh.corner_vertex[i]].push_back(mesh.corner_vertex[j]);
            }
        }
    }
    for (std::vector<Index>& ring : rings) {
        std::sort(ring.begin(), ring.end());
        ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    }
    return rings;
}

// Computes the Cholesky factor of a positive definite matrix, in its lower half. Returns false if the matrix
// is not positive definite.
bool factorise(std::array<Row5, 5>& m) {
    for (size_t i = 0; i < 5; ++i) {
        for (size_t j = 0; j <= i; ++j) {
            double sum = m[i][j];
            for (size_t k = 0; k < j; ++k) sum -= m[i][k] * m[j][k];
            if (i != j) {
                m[i][j] = sum / m[j][j];
            } else if (sum > 1e-9) {
                m[i][i] = std::sqrt(sum);
            } else {
                return false;
            }
        }
    }
    return true;
}

Row5 solved(const std::array<Row5, 5>& factor, Row5 x) {
    for (size_t i = 0; i < 5; ++i) {
        for (size_t k = 0; k < i; ++k) x[i] -= factor[i][k] * x[k];
        x[i] /= factor[i][i];
    }
    for (size_t i = 5; i-- > 0;) {
        for (size_t k = i + 1; k < 5; ++k) x[i] -= factor[k][i] * x[k];
        x[i] /= factor[i][i];
    }
    return x;
}

// Derivatives of the position by two coordinates along the surface, x and y, and along a line in the
// direction t in these coordinates.
struct Derivatives {
    Vec3 x, y, xx, xy, yy;

    Vec3 first(const Vec2& t) const { return t.x * x + t.y * y; }
    Vec3 second(const Vec2& t) const { return t.x * t.x * xx + 2.0f * t.x * t.y * xy + t.y * t.y * yy; }
};

// The first kCount of the derivatives x, y, xx, xy, yy of the positions around a vertex.
template <size_t kCount>
std::array<Vec3, kCount> derivatives(const BentLinesModel& model, std::span<const Vec3> positions,
                                     size_t vertex) {
    std::array<Vec3, kCount> out{};
    for (Index i = model.start[vertex]; i < model.start[vertex + 1]; ++i) {
        const auto& [other, weight] = model.around[i];
        const Vec3 displacement = positions[other] - positions[vertex];
        for (size_t k = 0; k < kCount; ++k) out[k] += weight[k] * displacement;
    }
    return out;
}

}  // namespace

FirstDerivatives first_derivatives(const BentLinesModel& model, std::span<const Vec3> positions,
                                   size_t vertex) {
    const auto [x, y] = derivatives<2>(model, positions, vertex);
    return {x, y};
}

BentLinesModel build_bent_lines(const Surface& surface) {
    BentLinesModel model;
    const std::vector<Vec3>& p = surface.positions_rest;
    const std::vector<Vec3> normals = vertex_normals(surface, p);
    const std::vector<std::vector<Index>> rings = polygon_rings(surface.welded);
    for (size_t v = 0; v < rings.size(); ++v) {
        const std::vector<Index>& ring = rings[v];
        double size = 0.0;
        for (const Index n : ring) size += glm::distance(p[n], p[v]) / double(ring.size());
        const Vec3 tangent = formulas::any_tangent(normals[v]), bitangent = glm::cross(normals[v], tangent);
        std::vector<Row5> rows;
        std::array<Row5, 5> normal_equations{};
        for (size_t k = 2; k < 5; ++k) normal_equations[k][k] = kRidge;
        for (const Index n : ring) {
            const double x = glm::dot(p[n] - p[v], tangent) / size,
                         y = glm::dot(p[n] - p[v], bitangent) / size;
            rows.push_back({x, y, 0.5 * x * x, x * y, 0.5 * y * y});
            for (size_t i = 0; i < 5; ++i)
                for (size_t j = 0; j < 5; ++j) normal_equations[i][j] += rows.back()[i] * rows.back()[j];
        }
        if (size > kShortestEdge && glm::dot(normals[v], normals[v]) > 0.0f && factorise(normal_equations)) {
            for (size_t i = 0; i < ring.size(); ++i) {
                const Row5 weights = solved(normal_equations, rows[i]);
                BentLinesModel::Around around{ring[i], {}};
                for (size_t k = 0; k < 5; ++k)
                    around.weight[k] = static_cast<float>(weights[k] / (k < 2 ? size : size * size));
                model.around.push_back(around);
            }
        }
        model.start.push_back(static_cast<Index>(model.around.size()));
    }
    return model;
}

std::vector<SpareCloth> spare_cloth(const Surface& surface, const BentLinesModel& model,
                                    std::span<const Vec3> positions, float radius) {
    std::vector<SpareCloth> out(surface.welded.vertex_count);
    for (size_t v = 0; v < out.size(); ++v) {
        const auto [x, y, xx, xy, yy] = derivatives<5>(model, positions, v);
        const Derivatives d{x, y, xx, xy, yy};
        const Vec3 normal = glm::cross(d.x, d.y);
        const float area = glm::length(normal);
        if (area <= kShortestEdge) continue;
        const Vec2 small =
            principal({glm::dot(d.x, d.x), glm::dot(d.x, d.y), glm::dot(d.y, d.y)}).small_direction;
        for (const Vec2& line : {small, Vec2(-small.y, small.x)}) {
            const Vec3 along = d.first(line);
            const float length = glm::length(along);
            if (!std::isfinite(length) || length <= kShortestEdge) continue;
            const Vec3 side = glm::cross(normal / area, along / length);
            const float curvature = std::abs(glm::dot(d.second(line), side)) / (length * length);
            // The stretch at right angles to the line.
            const float across = std::max(area / length, kLeastStretch);
            const float spare = kLeastSpare + std::max(1.0f / (across * across) - 1.0f, 0.0f);
            out[v].all.add(spare, side);
            out[v].without_place.add(spare * smooth_step(1.0f / kFreeRadius, 1.0f, radius * curvature), side);
        }
    }
    return out;
}

}  // namespace rumple

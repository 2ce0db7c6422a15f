// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/curvature.h"

#include <algorithm>
#include <cmath>

#include "base/tolerances.h"
#include "surface/output/attachments.h"

namespace rumple {
namespace {

constexpr float kReach = 0.1f;      // of the diagonal: over this length normals and curvature are smoothed
constexpr double kMostSteps = 8.0;  // edges that this may be: what is denser is smoothed over less

float length_of(const Surface& surface, const Edge& edge) {
    return glm::distance(surface.positions_rest[edge.a], surface.positions_rest[edge.b]);
}

float diagonal_of(const Surface& surface) {
    if (surface.positions_rest.empty()) return 0.0f;
    Vec3 low = surface.positions_rest.front(), high = low;
    for (const Vec3& p : surface.positions_rest) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    return glm::distance(low, high);
}

// Each pass means over a vertex and its neighbours, and reaches farther by about the length of an edge, as a
// random walk does.
int passes_for(const Surface& surface) {
    double sum = 0.0;
    for (const Edge& edge : surface.edges) sum += double(length_of(surface, edge));
    if (!(sum > 0.0)) return 0;
    const double steps = double(kReach * diagonal_of(surface)) * double(surface.edges.size()) / sum;
    const double few = steps < kMostSteps ? steps : kMostSteps;  // no number, of lengths beyond floats: these
    return std::max(static_cast<int>(few * few + 0.5), 1);
}

template <typename Value>
void smooth(const Surface& surface, int passes, std::vector<Value>& values) {
    std::vector<float> count(values.size(), 1.0f);
    for (const Edge& edge : surface.edges) {
        count[edge.a] += 1.0f;
        count[edge.b] += 1.0f;
    }
    std::vector<Value> sum;
    for (int pass = 0; pass < passes; ++pass) {
        sum = values;
        for (const Edge& edge : surface.edges) {
            sum[edge.a] += values[edge.b];
            sum[edge.b] += values[edge.a];
        }
        for (size_t v = 0; v < values.size(); ++v) values[v] = sum[v] / count[v];
    }
}

}  // namespace

std::vector<float> curvature_at_rest(const Surface& surface) {
    const size_t vertices = surface.welded.vertex_count;
    const int passes = passes_for(surface);
    std::vector<Vec3> normal(vertices);
    vertex_normals(surface, surface.positions_rest, normal);
    smooth(surface, passes, normal);
    for (Vec3& n : normal) {
        const float length = glm::length(n);
        n = length > kShortestNormal ? n / length : Vec3(0.0f);
    }
    // Of a tube, edges around it have the whole curvature and those along it none: of the squares twice the
    // mean.
    std::vector<float> squares(vertices, 0.0f), weight(vertices, 0.0f);
    for (const Edge& edge : surface.edges) {
        const float length = length_of(surface, edge);
        if (length < kShortestEdge) continue;
        const Vec3 turned = normal[edge.b] - normal[edge.a];
        for (const Index v : {edge.a, edge.b}) {
            squares[v] += glm::dot(turned, turned) / length;
            weight[v] += length;
        }
    }
    for (size_t v = 0; v < vertices; ++v)
        squares[v] = weight[v] > 0.0f ? 2.0f * squares[v] / weight[v] : 0.0f;
    smooth(surface, passes, squares);
    for (float& square : squares) square = std::sqrt(square);
    return squares;
}

}  // namespace rumple

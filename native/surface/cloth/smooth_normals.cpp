// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/smooth_normals.h"

#include <algorithm>
#include <cmath>

#include "surface/output/attachments.h"
#include "surface/query/bounds.h"

namespace rumple {
namespace {

constexpr float kReach = 0.1f;      // of the diagonal: the length over which normals are smoothed
constexpr double kMostSteps = 8.0;  // limit of this length, in edges; a denser mesh is smoothed over less

float length_of(const Surface& surface, const Edge& edge) {
    return glm::distance(surface.positions_rest[edge.a], surface.positions_rest[edge.b]);
}

// One pass takes the mean of a vertex and its neighbours. n passes reach over sqrt(n) edges.
int passes_for(const Surface& surface) {
    double sum = 0.0;
    for (const Edge& edge : surface.edges) sum += double(length_of(surface, edge));
    if (!(sum > 0.0)) return 0;
    const double steps =
        double(kReach) * bounding_diagonal(surface.positions_rest) * double(surface.edges.size()) / sum;
    const double few = steps < kMostSteps ? steps : kMostSteps;  // no number, of lengths beyond floats: these
    return std::max(static_cast<int>(std::lround(few * few)), 1);
}

}  // namespace

void average_with_neighbours(const Surface& surface, int times, std::span<const float> share,
                             std::vector<Vec3>& values) {
    std::vector<float> count(values.size(), 1.0f);
    for (const Edge& edge : surface.edges) {
        count[edge.a] += 1.0f;
        count[edge.b] += 1.0f;
    }
    std::vector<Vec3> sum;
    for (int i = 0; i < times; ++i) {
        sum = values;
        for (const Edge& edge : surface.edges) {
            sum[edge.a] += values[edge.b];
            sum[edge.b] += values[edge.a];
        }
        for (size_t v = 0; v < values.size(); ++v)
            values[v] = (share.empty() ? 1.0f : share[v]) * sum[v] / count[v];
    }
}

std::vector<Vec3> smooth_normals_at_rest(const Surface& surface) {
    std::vector<Vec3> normals = vertex_normals(surface, surface.positions_rest);
    average_with_neighbours(surface, passes_for(surface), {}, normals);
    for (Vec3& n : normals) n = direction_of_normals(n);
    return normals;
}

}  // namespace rumple

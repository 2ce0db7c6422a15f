// SPDX-License-Identifier: GPL-3.0-or-later
// Section 5.2.1 of Gillette 2015: a path stays on its edges and slides along them.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/elementary.h"
#include "base/tolerances.h"
#include "systems/wrinkle_paths/lifecycle.h"

namespace rumple::wrinkle_paths {
namespace {

using glm::dvec3;
using Points = std::vector<PathPoint>;

// Limit of the seconds between frames. With a larger weight, rounding would lose the other squares.
constexpr double kLongest = 3600.0;

// A sum of squares of residuals. Each is linear in at most three consecutive unknowns, so the matrix has band
// width 2.
class BandedSquares {
  public:
    explicit BandedSquares(size_t unknowns) : band_(unknowns, {0.0, 0.0, 0.0}), right_(unknowns, 0.0) {}

    struct Slope {
        Index unknown;  // a constant if outside of 0 .. unknowns - 1
        double value;
    };
    // Adds (residual + sum of slopes * unknowns)^2.
    void add(double residual, std::initializer_list<Slope> slopes) {
        for (const Slope& a : slopes) {
            if (!holds(a.unknown)) continue;
            right_[a.unknown] -= a.value * residual;
            for (const Slope& b : slopes) {
                if (holds(b.unknown) && b.unknown >= a.unknown)
                    band_[a.unknown][b.unknown - a.unknown] += a.value * b.value;
            }
        }
    }
    // Banded Cholesky factorisation L D L^T.
    std::vector<double> solve() {
        const size_t n = right_.size();
        for (size_t i = 0; i < n; ++i) {
            for (size_t j = 1; j <= 2 && i + j < n; ++j) {
                const double factor = band_[i][j] / band_[i][0];
                for (size_t k = j; k <= 2 && i + k < n; ++k) band_[i + j][k - j] -= factor * band_[i][k];
                right_[i + j] -= factor * right_[i];
            }
        }
        for (size_t i = n; i-- > 0;) {
            for (size_t j = 1; j <= 2 && i + j < n; ++j) right_[i] -= band_[i][j] * right_[i + j];
            right_[i] /= band_[i][0];
        }
        return right_;
    }

  private:
    bool holds(Index i) const { return i >= 0 && i < static_cast<Index>(right_.size()); }

    std::vector<std::array<double, 3>> band_;  // A(i, i), A(i, i + 1), A(i, i + 2)
    std::vector<double> right_;
};

dvec3 edge_vector(const Model& model, const std::vector<Vec3>& positions, const PathPoint& p) {
    const Index h = half_edge(p);
    return dvec3(positions[model.triangles.net.vertex[next_in_triangle(h)]]) -
           dvec3(positions[model.triangles.net.vertex[h]]);
}

// The rotation of a triangle between two poses: the rotation of its deformation (polar decomposition). So a
// pure compression, which turns every edge, gives no rotation.
glm::dmat3 turn_of(const Pose& before, const Pose& now, Index t) {
    const glm::dvec2 turn = rotation(before.base.shapes[t], now.base.shapes[t]);
    const double c = turn.x, s = turn.y;
    const auto frame = [](const SurfaceFrame& f) { return glm::dmat3(f.tangent, f.bitangent, f.normal); };
    return frame(now.frames[t]) * glm::dmat3(c, s, 0, -s, c, 0, 0, 0, 1) *
           glm::transpose(frame(before.frames[t]));
}

// ... the mean for the triangles at a point of a path.
glm::dmat3 turn_at(const Model& model, const Pose& before, const Pose& now, const PathPoint& p) {
    const glm::dmat3 turn = turn_of(before, now, p.triangle);
    if (p.edge == kNone) return turn;
    return 0.5 * (turn + turn_of(before, now, triangle_of(twin_of(model, p))));
}

// p_i - (p_i-1 + p_i+1) / 2, with p_-1 = p_1 and p_n+1 = p_n-1.
dvec3 bend(const std::vector<Vec3>& p, size_t i) {
    const size_t before = i == 0 ? 1 : i - 1, after = i + 1 == p.size() ? i - 1 : i + 1;
    return dvec3(p[i]) - 0.5 * (dvec3(p[before]) + dvec3(p[after]));
}

// Minimises equation 5.2 over the change of every t_i. Its terms are squared lengths.
std::vector<double> slide(const PathContext& context, const Pose& before, const Settings& settings,
                          double seconds, const Points& points) {
    const Model& model = context.model;
    const PathSurface stood{model, before};
    const std::vector<Vec3> now = positions(context, points), then = positions(stood, points);
    const size_t last = points.size() - 1;
    std::vector<dvec3> edge(points.size(), dvec3(0.0));  // dp_i / dt_i; the ends do not move on the cloth
    for (size_t i = 1; i < last; ++i) edge[i] = edge_vector(model, context.pose.base.positions, points[i]);
    const auto unknown = [](size_t i) { return static_cast<Index>(i) - 1; };

    BandedSquares squares(last - 1);
    const double per_frame = 30.0 * std::min(seconds, kLongest);
    for (size_t i = 0; i < last; ++i) {  // alignment across the compression
        const Index t = segment_triangle(model, points, i);
        const double certain =
            std::clamp(double(context.compression[t] - 1.0f) / double(settings.threshold - 1.0f), 0.0, 1.0);
        const double weight = std::sqrt(settings.alignment * per_frame * certain * context.activity[t]);
        const dvec3 e = weight * dvec3(context.across(t));
        squares.add(glm::dot(dvec3(now[i + 1]) - dvec3(now[i]), e),
                    {{unknown(i), -glm::dot(edge[i], e)}, {unknown(i + 1), glm::dot(edge[i + 1], e)}});
    }
    for (size_t i = 1; i < last; ++i)
        squares.add(0.0, {{unknown(i), std::max(glm::length(edge[i]), double(kShortestEdge))}});  // position
    for (size_t i = 0; i <= last; ++i) {                                                          // shape
        const dvec3 change = bend(now, i) - turn_at(model, before, context.pose, points[i]) * bend(then, i);
        const double side = i == 0 || i == last ? 1.0 : 0.5;
        for (int c = 0; c < 3; ++c) {
            if (i == 0 || i == last) {
                const size_t beside = i == 0 ? 1 : last - 1;
                squares.add(change[c], {{unknown(beside), -side * edge[beside][c]}});
            } else {
                squares.add(change[c], {{unknown(i - 1), -side * edge[i - 1][c]},
                                        {unknown(i), edge[i][c]},
                                        {unknown(i + 1), -side * edge[i + 1][c]}});
            }
        }
    }
    return squares.solve();
}

// Whether a half-edge starts or ends at a vertex.
bool touches(const Model& model, Index half_edge, Index vertex) {
    return model.triangles.net.vertex[half_edge] == vertex ||
           model.triangles.net.vertex[next_in_triangle(half_edge)] == vertex;
}

// The other one of the triangle's two half-edges at a vertex.
Index other_spoke(const Model& model, Index half_edge, Index vertex) {
    return model.triangles.net.vertex[half_edge] == vertex ? previous_in_triangle(half_edge)
                                                           : next_in_triangle(half_edge);
}

// The spokes around a vertex from one triangle to another, starting away from half-edge `not_by` of the
// first. False at an open border.
bool spokes_between(const Model& model, Index vertex, Index not_by, Index to_triangle,
                    std::vector<Index>& spokes) {
    Index h = other_spoke(model, not_by, vertex);
    while (triangle_of(h) != to_triangle) {
        spokes.push_back(h);
        const Index twin = model.triangles.net.twin[h];
        if (twin == kNone || spokes.size() > 64) return false;
        h = other_spoke(model, twin, vertex);
    }
    return true;
}

// Places points where the straight line between the points before and after crosses the spokes, unfolded
// around the vertex. They are not farther from the vertex than `beyond`, the distance by which the path
// passed it.
void place_on_spokes(const PathContext& context, Index vertex, const Vec3& before, const Vec3& after,
                     double beyond, const std::vector<Index>& spokes, Points& out) {
    const dvec3 centre(context.pose.base.positions[vertex]);
    const auto ray = [&](Index h) {
        const Index tip = context.model.triangles.net.vertex[h] == vertex ? next_in_triangle(h) : h;
        return dvec3(context.vertex(tip)) - centre;
    };
    const auto angle = [](const dvec3& a, const dvec3& b) {
        return elementary::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
    };
    std::vector<double> angles;
    dvec3 last = dvec3(before) - centre;
    double sum = 0.0;
    for (const Index h : spokes) {
        sum += angle(last, ray(h));
        angles.push_back(sum);
        last = ray(h);
    }
    sum += angle(last, dvec3(after) - centre);
    const double a = glm::length(dvec3(before) - centre), b = glm::length(dvec3(after) - centre);
    for (size_t i = 0; i < spokes.size(); ++i) {
        const Index h = spokes[i];
        double radius = beyond;
        if (sum < std::numbers::pi) {
            const double straight = a * b * elementary::sin(sum);
            const double spread = a * elementary::sin(angles[i]) + b * elementary::sin(sum - angles[i]);
            radius = std::min(radius, spread > 0.0 ? straight / spread : 0.0);
        }
        const double fraction =
            std::clamp(radius / std::max(glm::length(ray(h)), 1e-30), kEdgeMargin, 1.0 - kEdgeMargin);
        const bool outwards = context.model.triangles.net.vertex[h] == vertex;
        out.push_back({triangle_of(h), h % 3, Vec2(float(outwards ? fraction : 1.0 - fraction), 0.0f)});
    }
}

// The distance of a point from a vertex of its edge, negative if it has passed the vertex.
double distance_from(const PathContext& context, const PathPoint& p, Index vertex) {
    const bool from = context.model.triangles.net.vertex[half_edge(p)] == vertex;
    return glm::length(edge_vector(context.model, context.pose.base.positions, p)) *
           (from ? p.at.x : 1.0 - p.at.x);
}

// Point i left its edge over a vertex, so the path now passes the vertex on the other side. It stays on its
// side at a border, or if the mean of the points on this vertex's edges is still on it.
void pass_vertex(const PathContext& context, Points& points, size_t i) {
    const Model& model = context.model;
    const Index h = half_edge(points[i]);
    const Index vertex = model.triangles.net.vertex[points[i].at.x < 0.0f ? h : next_in_triangle(h)];
    size_t first = i, last = i;  // consecutive points on edges at this vertex
    while (first > 1 && touches(model, half_edge(points[first - 1]), vertex)) --first;
    while (last + 2 < points.size() && touches(model, half_edge(points[last + 1]), vertex)) ++last;
    double side = 0.0;
    for (size_t k = first; k <= last; ++k)
        side += distance_from(context, points[k], vertex) / double(last - first + 1);
    std::vector<Index> spokes;
    const Index to = triangle_of(twin_of(model, points[last]));
    if (side > 0.0 || !spokes_between(model, vertex, half_edge(points[first]), to, spokes)) {
        points[i].at.x = float(std::clamp(double(points[i].at.x), kEdgeMargin, 1.0 - kEdgeMargin));
        return;
    }
    Points around;
    place_on_spokes(context, vertex, position(context, points[first - 1]),
                    position(context, points[last + 1]), -side, spokes, around);
    points.erase(points.begin() + first, points.begin() + last + 1);
    points.insert(points.begin() + first, around.begin(), around.end());
}

// Removes pairs of points where a path crosses an edge and directly returns.
void drop_returns(const Model& model, Points& points) {
    for (size_t i = 1; i + 2 < points.size();) {
        if (twin_of(model, points[i]) != half_edge(points[i + 1])) {
            ++i;
            continue;
        }
        points.erase(points.begin() + i, points.begin() + i + 2);
        i = std::max<size_t>(i - 1, 1);
    }
}

}  // namespace

void follow(const PathContext& context, const Pose& before, const Settings& settings, double seconds,
            Points& points, std::vector<float>& moved) {
    if (points.size() < 3) return;
    const std::vector<double> change = slide(context, before, settings, seconds, points);
    std::vector<float> lengths;
    for (size_t i = 0; i < change.size(); ++i)
        lengths.push_back(
            float(std::abs(change[i]) *
                  glm::length(edge_vector(context.model, context.pose.base.positions, points[i + 1]))));
    // If all movements are too small to be visible, nothing moves, so that a standing figure stays the same
    // to the bit.
    const bool still = *std::max_element(lengths.begin(), lengths.end()) < kStill * settings.width;
    for (size_t i = 0; i < change.size(); ++i) {
        moved.push_back(still ? 0.0f : lengths[i]);
        if (!still) points[i + 1].at.x += float(change[i]);
    }
    if (still) return;
    for (size_t i = 1; i + 1 < points.size(); ++i) {
        if (points[i].at.x < 0.0f || points[i].at.x > 1.0f) pass_vertex(context, points, i);
    }
    drop_returns(context.model, points);
    for (size_t i = 1; i + 1 < points.size(); ++i)
        points[i].at.x = float(std::clamp(double(points[i].at.x), kEdgeMargin, 1.0 - kEdgeMargin));
}

}  // namespace rumple::wrinkle_paths

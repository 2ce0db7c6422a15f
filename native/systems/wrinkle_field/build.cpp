// SPDX-License-Identifier: GPL-3.0-or-later
// Section 3 of Loviscach 2006: the data that depends only on the rest pose. Also the profiles of section 6.3.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <tuple>

#include "base/elementary.h"
#include "base/expect.h"
#include "base/random.h"
#include "systems/wrinkle_field/wrinkle_field.h"

namespace rumple::wrinkle_field {
namespace {

Profile profile(float (*height)(float), float (*slope)(float)) {
    Profile out;
    for (int i = 0; i <= kProfileIntervals; ++i) {
        const float phase = std::numbers::pi_v<float> * float(i) / float(kProfileIntervals);
        out.height[i] = height(phase);
        out.slope[i] = slope(phase);
    }
    return out;
}

void collect_neighbours(Model& model) {
    OneRings rings = one_rings(model.base);
    model.neighbour_start = std::move(rings.start);
    for (const Index n : rings.vertex) model.neighbours.push_back({n, Vec2(0.0f)});
}

// Computes the rest frames of section 4.2 and the constant part of equation (1).
void regress_at_rest(Model& model) {
    const std::vector<Vec3>& rest = model.base.positions_rest;
    const std::vector<Vec3> normals = vertex_normals(model.base, rest);
    model.tangent_rest.assign(rest.size(), Vec3(0.0f));
    model.bitangent_rest = model.tangent_rest;
    for (size_t v = 0; v < rest.size(); ++v) {
        const Index begin = model.neighbour_start[v], end = model.neighbour_start[v + 1];
        if (begin == end || normals[v] == Vec3(0.0f)) continue;
        const Vec3 t = formulas::tangent_towards(rest[model.neighbours[begin].vertex] - rest[v], normals[v]);
        const Vec3 b = glm::cross(normals[v], t);
        model.tangent_rest[v] = t;
        model.bitangent_rest[v] = b;
        glm::mat2 moments(0.0f);
        for (Index i = begin; i < end; ++i) {
            Model::Neighbour& n = model.neighbours[i];
            n.gradient = formulas::tangent_space(rest[n.vertex] - rest[v], t, b, model.true_lengths);
            moments += glm::outerProduct(n.gradient, n.gradient);
        }
        for (Index i = begin; i < end; ++i) {
            Vec2& gradient = model.neighbours[i].gradient;
            gradient = formulas::regression_gradient(moments, gradient);
        }
    }
}

// The column with the k-th neighbours of vertices from `first` on.
void add_column(Model& model, size_t first, size_t how_many, Index k) {
    LaneIndices vertex{};
    Vec2Lanes gradient;
    for (size_t lane = 0; lane < how_many; ++lane) {
        const Index i = model.neighbour_start[first + lane] + k;
        if (i >= model.neighbour_start[first + lane + 1]) continue;
        vertex[lane] = model.neighbours[i].vertex;
        gradient.set(int(lane), model.neighbours[i].gradient);
    }
    model.columns.vertex.push_back(vertex);
    model.columns.gradient.push_back(gradient);
}

void arrange_in_columns(Model& model) {
    NeighbourColumns& columns = model.columns;
    for_each_four(model.tangent_rest.size(), [&](size_t first, size_t how_many) {
        Lanes count{};
        LaneMask has_frame{};
        Index most = 0;
        for (size_t lane = 0; lane < how_many; ++lane) {
            const size_t v = first + lane;
            const Index neighbours = model.neighbour_start[v + 1] - model.neighbour_start[v];
            most = std::max(most, neighbours);
            count[lane] = float(neighbours);
            has_frame[lane] = model.tangent_rest[v] == Vec3(0.0f) ? 0 : -1;
        }
        for (Index k = 0; k < most; ++k) add_column(model, first, how_many, k);
        columns.start.push_back(static_cast<Index>(columns.vertex.size()));
        columns.count.push_back(count);
        columns.has_frame.push_back(has_frame);
    });
    fit(columns.start, columns.vertex, columns.gradient, columns.count, columns.has_frame);
}

// The frames of `stretch` and the rest frames have the same normal, except for rounding errors.
void turn_frames(Model& model) {
    for (size_t v = 0; v < model.tangent_rest.size(); ++v) {
        const Vec3& x = model.stretch.vertex_tangent[v];
        const Vec2 turn(glm::dot(x, model.tangent_rest[v]), glm::dot(x, model.bitangent_rest[v]));
        const float length = glm::length(turn);
        model.vertex_turn.push_back(length > 0.0f ? turn / length : Vec2(1.0f, 0.0f));
    }
}

// Identifies vertices by position, so that their order and number do not change phases.
void identify(Model& model) {
    for (const Vec3& p : model.base.positions_rest) {
        std::uint32_t hash = 0;
        for (int i = 0; i < 3; ++i)
            hash = hashed(hash, std::bit_cast<std::uint32_t>(p[i] + 0.0f));  // -0 becomes 0
        model.identity.push_back(hash);
    }
}

// Corners with the same vertex and uv share their gradient of uv, so that it is continuous over edges.
// Mirrored parts of the texture have separate gradients.
void collect_uv_fans(Model& model, std::span<const Vec2> uv) {
    using Fan = std::tuple<Index, float, float, bool>;
    std::map<Fan, Index> fans;
    for (const Triangle& triangle : model.base.triangles) {
        const Vec2 a = uv[triangle.corner[0]], b = uv[triangle.corner[1]] - a, c = uv[triangle.corner[2]] - a;
        const bool mirrored = b.x * c.y - b.y * c.x < 0.0f;
        for (const Index corner : triangle.corner) {
            const Fan fan{model.base.welded.corner_vertex[corner], uv[corner].x, uv[corner].y, mirrored};
            model.uv.push_back(uv[corner]);
            model.uv_fan.push_back(fans.try_emplace(fan, static_cast<Index>(fans.size())).first->second);
        }
    }
}

void displace_fine_mesh(Model& model, const Plan& plan) {
    const FineMesh fine = refine(model.base, plan.fine);
    model.attachments = attach_refined(model.base, plan.fine, fine, plan.attachment);
    const std::vector<Vec3> rest = attached_at_rest(model.base, model.attachments);
    model.shown = show_fine(model.base, model.base, fine, 0, rest);
}

// For a profile: the square of df/dphi between consecutive entries of its table.
using SquaredSlopes = std::array<double, kProfileIntervals>;

SquaredSlopes squared_slopes(const Profile& profile) {
    SquaredSlopes out;
    for (int i = 0; i < kProfileIntervals; ++i) {
        const double slope = (double(profile.height[i + 1]) - double(profile.height[i])) *
                             (kProfileIntervals / std::numbers::pi);
        out[i] = slope * slope;
    }
    return out;
}

// length_ratio() and its derivative with respect to s.
struct LengthRatio {
    double value = 0.0;
    double slope = 0.0;
};
LengthRatio length_ratio(const SquaredSlopes& slopes, double s) {
    LengthRatio out;
    for (const double square : slopes) {
        const double root = std::sqrt(1.0 + s * s * square);
        out.value += root;
        out.slope += s * square / root;
    }
    return {out.value / kProfileIntervals, out.slope / kProfileIntervals};
}

// For steepness(): relative error, and a number of steps that always reaches it (five from the accordion's
// s).
constexpr double kSteepnessError = 1e-6;
constexpr int kNewtonSteps = 50;

// s of straight flanks for this length ratio. It is larger than s of any other profile with the same range,
// because their chords are shorter.
double steepness_of_accordion(double ratio) {
    return 0.5 * std::numbers::pi * std::sqrt(ratio * ratio - 1.0);
}

// steepness() by Newton's method on a convex increasing function. From a larger s it decreases monotonically
// to the root.
double steepness_from(const SquaredSlopes& slopes, double ratio, double s) {
    for (int step = 0; step < kNewtonSteps; ++step) {
        const LengthRatio at = length_ratio(slopes, s);
        if (at.slope <= 0.0)
            return std::numeric_limits<double>::infinity();  // a flat profile is never too long
        const double correction = (at.value - ratio) / at.slope;
        s -= correction;
        if (std::abs(correction) <= kSteepnessError * s) break;
    }
    return s;
}

// steepness() of a profile / steepness() of the accordion. This hardly changes with the ratio: a table over 1
// / ratio, with linear interpolation. The relative error is less than 1e-4 for sine and pleats.
class SteepnessTable {
  public:
    explicit SteepnessTable(const SquaredSlopes& slopes) {
        double s = steepness_of_accordion(kIntervals);
        for (int i = 1; i < kIntervals; ++i) {
            const double ratio = double(kIntervals) / i;
            s = steepness_from(slopes, ratio, s);  // the former s is larger than the root
            share_[i] = s / steepness_of_accordion(ratio);
        }
        share_[0] = share_[1];  // constant for longer waves
        // For small s the ratio is 1 + s^2 / 2 * the mean of the squares.
        double sum = 0.0;
        for (const double square : slopes) sum += square;
        share_[kIntervals] = 2.0 * std::numbers::inv_pi / std::sqrt(sum / kProfileIntervals);
    }
    // ratio: > 1.
    double at(double ratio) const {
        const double x = kIntervals / ratio;
        const int i = std::min(int(x), kIntervals - 1);
        return (share_[i] + (x - i) * (share_[i + 1] - share_[i])) * steepness_of_accordion(ratio);
    }

  private:
    static constexpr int kIntervals = 128;
    std::array<double, kIntervals + 1> share_;
};

}  // namespace

Profile sine() {
    return profile([](float phase) { return elementary::cos(phase); },
                   [](float phase) { return -elementary::sin(phase); });
}

Profile accordion() {
    return profile([](float phase) { return 1.0f - 2.0f * std::numbers::inv_pi_v<float> * phase; },
                   [](float) { return -2.0f * std::numbers::inv_pi_v<float>; });
}

Profile pencil_pleats() {
    return profile([](float phase) { return 2.0f * elementary::cos(0.5f * phase) - 1.0f; },
                   [](float phase) { return -elementary::sin(0.5f * phase); });
}

Profile drawn(std::span<const float> height) {
    expect_count("profile", height.size(), kProfileIntervals + 1, "values");
    Profile out;
    const float interval = std::numbers::pi_v<float> / float(kProfileIntervals);
    for (int i = 0; i <= kProfileIntervals; ++i) {
        expect_within("profile value " + std::to_string(i), height[i], -1.0, 1.0);
        out.height[i] = height[i];
        // One-sided differences at the ends preserve a kink drawn there.
        const int before = std::max(i - 1, 0), after = std::min(i + 1, kProfileIntervals);
        out.slope[i] = (height[after] - height[before]) / (interval * float(after - before));
    }
    return out;
}

double length_ratio(const Profile& profile, double s) {
    return length_ratio(squared_slopes(profile), s).value;
}

double steepness(const Profile& profile, double ratio) {
    if (!(ratio > 1.0)) return 0.0;
    return steepness_from(squared_slopes(profile), ratio, steepness_of_accordion(ratio));
}

void keep_length(const Profile& profile, Waves& waves) {
    const SquaredSlopes slopes = squared_slopes(profile);
    if (*std::max_element(slopes.begin(), slopes.end()) <= 0.0) return;  // flat profile
    const SteepnessTable steepest(slopes);
    for (size_t v = 0; v < waves.height.size(); ++v) {
        if (waves.height[v] <= 0.0f) continue;
        const double ratio = waves.gather[v], length = glm::length(waves.wave_vector[v]);
        const double most = ratio > 1.0 ? steepest.at(ratio) / length : 0.0;
        waves.height[v] = static_cast<float>(std::min(double(waves.height[v]), most));
    }
}

std::shared_ptr<const Model> build(Surface base, const Plan& plan) {
    auto model = std::make_shared<Model>();
    model->base = std::move(base);
    model->output = plan.output;
    model->true_lengths = plan.true_lengths;
    collect_neighbours(*model);
    regress_at_rest(*model);
    arrange_in_columns(*model);
    identify(*model);
    model->stretch = build_stretch(model->base);
    model->bent_lines = build_bent_lines(model->base);
    model->triangles = build_reference(model->base);
    turn_frames(*model);
    if (plan.output == Output::kGeometry) {
        displace_fine_mesh(*model, plan);
        return model;
    }
    if (!plan.uv.empty()) {
        expect_count("uv", plan.uv.size(), model->base.display.corners(), "corners");
        expect_finite("uv", plan.uv, "corner");
        collect_uv_fans(*model, plan.uv);
    }
    model->shown = show_triangles(model->base);
    return model;
}

std::vector<float> random_phases(const Model& model, std::uint32_t seed) {
    std::vector<float> phases;
    for (const std::uint32_t identity : model.identity) {
        phases.push_back(formulas::wrapped(std::numbers::pi_v<float> * noise(seed, identity)));
    }
    return phases;
}

}  // namespace rumple::wrinkle_field

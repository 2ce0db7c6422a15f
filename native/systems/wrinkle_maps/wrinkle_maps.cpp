// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_maps/wrinkle_maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "base/errors.h"
#include "base/expect.h"
#include "base/tolerances.h"

namespace rumple::wrinkle_maps {
namespace {

// A bone as one point of six coordinates; what is not tracked is the origin.
using Point = std::array<double, 6>;

Point tracked_point(const Bone& bone, Tracked tracked) {
    Point point{};
    for (int c = 0; c < 3; ++c) {
        if (tracked != Tracked::kTail) point[c] = bone.head[c];
        if (tracked != Tracked::kHead) point[c + 3] = bone.tail[c];
    }
    return point;
}

Point operator-(const Point& a, const Point& b) {
    Point difference;
    for (size_t c = 0; c < a.size(); ++c) difference[c] = a[c] - b[c];
    return difference;
}

double dot(const Point& a, const Point& b) {
    double sum = 0.0;
    for (size_t c = 0; c < a.size(); ++c) sum += a[c] * b[c];
    return sum;
}

void check_bones(const Rig& rig, std::span<const Bone> bones, const std::string& of) {
    expect_count(of, bones.size(), rig.names.size(), "bones");
    for (size_t i = 0; i < bones.size(); ++i) {
        if (is_finite(bones[i].head) && is_finite(bones[i].tail)) continue;
        throw InvalidInput(of + ": the " + (is_finite(bones[i].head) ? "tail" : "head") + " of bone " +
                           rig.names[i] + " is not finite");
    }
}

void check_rig(const Rig& rig) {
    expect_count("tracked", rig.tracked.size(), rig.names.size(), "bones");
    expect_count("group", rig.group.size(), rig.names.size(), "bones");
    check_bones(rig, rig.neutral, "the neutral pose");
    if (rig.poses.size() > size_t(kMostPoses)) {
        throw InvalidInput("poses: expected at most " + std::to_string(kMostPoses) + ", got " +
                           std::to_string(rig.poses.size()));
    }
    for (const ReferencePose& pose : rig.poses) check_bones(rig, pose.bones, "pose " + pose.name);
}

// The largest distance from the root of anything that is tracked.
double extent(const Rig& rig) {
    double farthest = 0.0;
    const auto include = [&](std::span<const Bone> bones) {
        for (const Bone& bone : bones) {
            for (const Vec3& p : {bone.head, bone.tail})
                farthest = std::max(farthest, double(glm::length(p)));
        }
    };
    include(rig.neutral);
    for (const ReferencePose& pose : rig.poses) include(pose.bones);
    return farthest;
}

// How far every bone is in one pose from where it is in another.
std::vector<double> displacements(const Rig& rig, std::span<const Bone> from, std::span<const Bone> to) {
    std::vector<double> lengths(from.size());
    for (size_t i = 0; i < from.size(); ++i) {
        const Point in_pose = tracked_point(to[i], rig.tracked[i]) - tracked_point(from[i], rig.tracked[i]);
        lengths[i] = std::sqrt(dot(in_pose, in_pose));
    }
    return lengths;
}

double longest(const std::vector<double>& lengths) {
    return lengths.empty() ? 0.0 : *std::max_element(lengths.begin(), lengths.end());
}

// The lengths of the ways from P_0, a row for every pose. Throws where a pose has none or another's.
std::vector<std::vector<double>> displacements_to_poses(const Rig& rig, double still) {
    std::vector<std::vector<double>> lengths;
    for (size_t k = 0; k < rig.poses.size(); ++k) {
        const ReferencePose& pose = rig.poses[k];
        lengths.push_back(displacements(rig, rig.neutral, pose.bones));
        if (longest(lengths[k]) <= still)
            throw InvalidInput("pose " + pose.name + ": no bone moves in it: it is the neutral pose");
        for (size_t other = 0; other < k; ++other) {
            if (longest(displacements(rig, rig.poses[other].bones, pose.bones)) > still) continue;
            throw InvalidInput("pose " + pose.name + ": every bone stands as in pose " +
                               rig.poses[other].name);
        }
    }
    return lengths;
}

// "0 if J_iP0 = J_iPk": equal but for what is too short to be compared with.
void find_moves(Model& model) {
    const Index poses = model.poses(), bones = model.bones();
    const double still = kStillBone * extent(model.rig);
    const std::vector<std::vector<double>> lengths = displacements_to_poses(model.rig, still);
    std::vector<double> farthest(bones, 0.0);  // of each bone, in any pose
    for (const std::vector<double>& of_pose : lengths) {
        for (Index i = 0; i < bones; ++i) farthest[i] = std::max(farthest[i], of_pose[i]);
    }
    model.moves.assign(size_t(bones) * poses, 0);
    for (Index k = 0; k < poses; ++k) {
        const double shortest = std::max(still, kShortWay * longest(lengths[k]));
        const auto mark = [&](double passed_by) {
            bool any = false;
            for (Index i = 0; i < bones; ++i) {
                const bool moves = lengths[k][i] > shortest && lengths[k][i] >= passed_by * farthest[i];
                model.moves[size_t(i) * poses + k] = moves;
                any = any || moves;
            }
            return any;
        };
        if (!mark(kPassedBy)) mark(0.0);  // a faint copy of another pose is still a pose
    }
}

void find_groups(Model& model) {
    std::map<Index, std::vector<Index>> members;
    for (Index i = 0; i < model.bones(); ++i) {
        if (model.rig.group[i] != kNone) members[model.rig.group[i]].push_back(i);
    }
    model.active = model.moves;
    for (const auto& [number, group] : members) {
        if (group.size() < 2) continue;
        model.groups.push_back(group);
        for (Index k = 0; k < model.poses(); ++k) {
            const bool moves = std::any_of(group.begin(), group.end(),
                                           [&](Index i) { return model.moves[i * model.poses() + k] != 0; });
            for (Index i : group) model.active[i * model.poses() + k] = moves;
        }
    }
}

void check_weights(const SparseRows& weights, Index bones) {
    const bool starts = !weights.start.empty() && weights.start.front() == 0 &&
                        size_t(weights.start.back()) == weights.index.size() &&
                        std::is_sorted(weights.start.begin(), weights.start.end());
    if (!starts || weights.index.size() != weights.weight.size()) {
        throw InvalidInput("weights: expected ascending starts from 0 to the number of bones and of weights");
    }
    for (Index v = 0; v < weights.rows(); ++v) {
        for (Index e = weights.start[v]; e < weights.start[v + 1]; ++e) {
            const std::string at = "weights: vertex " + std::to_string(v) + ": ";
            if (weights.index[e] < kNone || weights.index[e] >= bones) {
                throw InvalidInput(at + "expected a bone of 0 to " + std::to_string(bones - 1) +
                                   " or -1, got " + std::to_string(weights.index[e]));
            }
            if (!(weights.weight[e] >= 0.0f) || !std::isfinite(weights.weight[e])) {
                throw InvalidInput(at + "expected a weight >= 0, got " + std::to_string(weights.weight[e]));
            }
        }
    }
}

// Convex rows, without the bones that are not in the rig: "we assume that skinning weights are convex".
void take_weights(Model& model, const SparseRows& given) {
    for (Index v = 0; v < given.rows(); ++v) {
        double sum = 0.0;
        for (Index e = given.start[v]; e < given.start[v + 1]; ++e) sum += given.weight[e];
        if (sum > 0.0) {
            model.unnormalised += std::abs(sum - 1.0) > kWeightSum;
            for (Index e = given.start[v]; e < given.start[v + 1]; ++e) {
                const auto weight = static_cast<float>(given.weight[e] / sum);
                if (given.index[e] != kNone && weight > 0.0f) model.weights.add(given.index[e], weight);
            }
        } else {
            ++model.unbound;
        }
        model.weights.end_row();
    }
}

void find_reach(Model& model) {
    const Index poses = model.poses();
    model.reach.assign(size_t(model.vertices()) * poses, 0.0f);
    for (Index v = 0; v < model.vertices(); ++v) {
        for (Index e = model.weights.start[v]; e < model.weights.start[v + 1]; ++e) {
            const std::uint8_t* active = model.active.data() + size_t(model.weights.index[e]) * poses;
            for (Index k = 0; k < poses; ++k) {
                if (active[k]) model.reach[size_t(v) * poses + k] += model.weights.weight[e];
            }
        }
    }
}

// Poses are handled four at a time, so that the compiler can use vectors.
constexpr Index kLane = 4;

// Sums of weight x influence over a vertex's bones, for kLanes x kLane poses.
template <Index kLanes>
void sum_influences(const Model& model, const std::vector<float>& influence, Index v, float* sums) {
    constexpr Index kWidth = kLanes * kLane;
    std::array<float, kWidth> sum{};
    for (Index e = model.weights.start[v]; e < model.weights.start[v + 1]; ++e) {
        const float weight = model.weights.weight[e];
        const float* row = &influence[size_t(model.weights.index[e]) * kWidth];
        for (Index k = 0; k < kWidth; ++k) sum[k] += weight * row[k];
    }
    std::copy(sum.begin(), sum.end(), sums);
}

// factor(v, k): what the sum is multiplied by.
template <Index kLanes, typename Factor>
void fill_masks(const Model& model, const std::vector<float>& influence, const Factor& factor,
                std::vector<float>& out) {
    const Index vertices = model.vertices();
    std::array<float, kLanes * kLane> sum;
    for (Index v = 0; v < vertices; ++v) {
        sum_influences<kLanes>(model, influence, v, sum.data());
        for (Index k = 0; k < model.poses(); ++k) {
            out[size_t(k) * vertices + v] = std::min(factor(v, k) * sum[k], 1.0f);
        }
    }
}

template <typename Factor>
void fill_masks(const Model& model, const std::vector<float>& influence, const Factor& factor,
                std::vector<float>& out) {
    static_assert(kMostPoses == 4 * kLane);
    switch ((model.poses() + kLane - 1) / kLane) {
        case 1:
            return fill_masks<1>(model, influence, factor, out);
        case 2:
            return fill_masks<2>(model, influence, factor, out);
        case 3:
            return fill_masks<3>(model, influence, factor, out);
        case 4:
            return fill_masks<4>(model, influence, factor, out);
    }
}

// b x o influences times strengths, rows padded to whole lanes.
std::vector<float> padded(const Model& model, const Settings& settings, const Influences& influences) {
    const Index poses = model.poses(), width = (poses + kLane - 1) / kLane * kLane;
    std::vector<float> rows(size_t(model.bones()) * width, 0.0f);
    for (Index i = 0; i < model.bones(); ++i) {
        for (Index k = 0; k < poses; ++k) {
            const float strength = settings.strength.empty() ? 1.0f : settings.strength[k];
            rows[size_t(i) * width + k] = strength * influences.pose[size_t(i) * poses + k];
        }
    }
    return rows;
}

}  // namespace

void check(const Settings& settings, Index poses) {
    expect_within("gain", settings.gain, 0.1f, 100.0f);
    if (settings.strength.empty()) return;
    expect_count("strength", settings.strength.size(), size_t(poses), "values");
    for (size_t k = 0; k < settings.strength.size(); ++k) {
        expect_within("strength " + std::to_string(k), settings.strength[k], 0.0, 1.0);
    }
}

std::shared_ptr<const Model> build(const Rig& rig, const SparseRows& weights) {
    check_rig(rig);
    check_weights(weights, static_cast<Index>(rig.names.size()));
    auto model = std::make_shared<Model>();
    model->rig = rig;
    find_moves(*model);
    find_groups(*model);
    take_weights(*model, weights);
    find_reach(*model);
    return model;
}

std::vector<Bone> in_root_space(const glm::mat4& root, std::span<const Bone> bones) {
    const glm::dmat4 matrix(root);
    const double determinant = glm::determinant(matrix);
    if (!std::isfinite(determinant)) throw InvalidInput("root: its matrix is not finite");
    if (determinant == 0.0) throw InvalidInput("root: its matrix has no inverse: a scale is zero");
    const glm::dmat4 inverse = glm::inverse(matrix);
    const auto moved = [&](const Vec3& p) { return Vec3(glm::dvec3(inverse * glm::dvec4(p, 1.0))); };
    std::vector<Bone> out;
    out.reserve(bones.size());
    for (const Bone& bone : bones) out.push_back({moved(bone.head), moved(bone.tail)});
    return out;
}

Influences evaluate(const Model& model, std::span<const Bone> bones) {
    const Rig& rig = model.rig;
    check_bones(rig, bones, "the present pose");
    const Index poses = model.poses();
    Influences out{std::vector<float>(model.moves.size(), 0.0f), std::vector<float>(bones.size())};
    for (Index i = 0; i < model.bones(); ++i) {
        const Point neutral = tracked_point(rig.neutral[i], rig.tracked[i]);
        const Point displacement = tracked_point(bones[i], rig.tracked[i]) - neutral;
        for (Index k = 0; k < poses; ++k) {
            if (!model.moves[i * poses + k]) continue;
            const Point in_pose = tracked_point(rig.poses[k].bones[i], rig.tracked[i]) - neutral;
            // Printed over ||way||; over its square alpha is a fraction, and exactly 1 at the pose.
            const double alpha = dot(displacement, in_pose) / dot(in_pose, in_pose);
            out.pose[i * poses + k] = static_cast<float>(std::clamp(alpha, 0.0, 1.0));
        }
    }
    for (const std::vector<Index>& group : model.groups) {
        for (Index k = 0; k < poses; ++k) {
            double sum = 0.0;
            int moving = 0;
            for (Index i : group) {
                sum += out.pose[i * poses + k];
                moving += model.moves[i * poses + k];
            }
            if (moving == 0) continue;
            for (Index i : group) out.pose[i * poses + k] = static_cast<float>(sum / moving);
        }
    }
    for (Index i = 0; i < model.bones(); ++i) {
        double sum = 0.0;
        for (Index k = 0; k < poses; ++k) sum += out.pose[i * poses + k];
        out.rest[i] = static_cast<float>(std::max(0.0, 1.0 - sum));
    }
    return out;
}

std::vector<float> presence(const Model& model, const Influences& influences) {
    const Index poses = model.poses();
    std::vector<float> out(poses, 0.0f);
    for (Index k = 0; k < poses; ++k) {
        double sum = 0.0;
        int active = 0;
        for (Index i = 0; i < model.bones(); ++i) {
            sum += influences.pose[i * poses + k];
            active += model.active[i * poses + k];
        }
        out[k] = static_cast<float>(sum / active);  // build() refuses poses in which nothing moves
    }
    return out;
}

std::vector<float> masks(const Model& model, const Settings& settings, const Influences& influences) {
    check(settings, model.poses());
    expect_count("influences", influences.pose.size(), model.moves.size(), "values");
    std::vector<float> out(size_t(model.poses()) * model.vertices());
    const std::vector<float> rows = padded(model, settings, influences);
    if (settings.gain == 1.0f) {
        fill_masks(
            model, rows, [](Index, Index) { return 1.0f; }, out);
        return out;
    }
    // The mean influence of the active bones around the vertex, times the share that their weight gets.
    fill_masks(
        model, rows,
        [&](Index v, Index k) {
            const float reach = model.reach[size_t(v) * model.poses() + k];
            return reach > 0.0f ? gained(reach, settings.gain) / reach : 0.0f;
        },
        out);
    return out;
}

Vec3 blend(Maps maps, const Vec3& neutral, std::span<const Vec3> wrinkles, std::span<const float> masks) {
    Vec3 sum(0.0f);
    float total = 0.0f;
    for (size_t k = 0; k < wrinkles.size(); ++k) {
        sum += masks[k] * wrinkles[k];
        total += masks[k];
    }
    return maps == Maps::kWhole ? formulas::blend_whole(sum, total, neutral)
                                : formulas::blend_wrinkles(sum, total, neutral);
}

}  // namespace rumple::wrinkle_maps

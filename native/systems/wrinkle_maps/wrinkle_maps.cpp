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

// A bone as one point with six coordinates. An end that is not tracked is the origin.
using Point = std::array<double, 6>;

Point tracked_point(const Bone& bone, Tracked tracked) {
    Point point{};
    if (tracked == Tracked::kKey) {
        point[0] = bone.head.x;
        return point;
    }
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

bool is_key(const Rig& rig, Index i) {
    return i != kNone && rig.tracked[i] == Tracked::kKey;
}

bool has_keys(const Rig& rig) {
    return std::any_of(rig.tracked.begin(), rig.tracked.end(),
                       [](Tracked tracked) { return tracked == Tracked::kKey; });
}

// Lengths of bones and values of keys cannot be compared, so there is a measure for each kind.
struct Measures {
    double bones = 0.0, keys = 0.0;

    double& of(Tracked tracked) { return tracked == Tracked::kKey ? keys : bones; }
    double of(Tracked tracked) const { return tracked == Tracked::kKey ? keys : bones; }
};

// The largest distance of a tracked bone from the root, and the largest value of a key.
Measures extent(const Rig& rig) {
    Measures farthest;
    const auto include = [&](std::span<const Bone> bones) {
        for (size_t i = 0; i < bones.size(); ++i) {
            double& of_kind = farthest.of(rig.tracked[i]);
            if (rig.tracked[i] == Tracked::kKey) {
                of_kind = std::max(of_kind, std::abs(double(bones[i].head.x)));
                continue;
            }
            for (const Vec3& p : {bones[i].head, bones[i].tail})
                of_kind = std::max(of_kind, double(glm::length(p)));
        }
    };
    include(rig.neutral);
    for (const ReferencePose& pose : rig.poses) include(pose.bones);
    return farthest;
}

// The distance of every bone between two poses.
std::vector<double> displacements(const Rig& rig, std::span<const Bone> from, std::span<const Bone> to) {
    std::vector<double> lengths(from.size());
    for (size_t i = 0; i < from.size(); ++i) {
        const Point apart = tracked_point(to[i], rig.tracked[i]) - tracked_point(from[i], rig.tracked[i]);
        lengths[i] = std::sqrt(dot(apart, apart));
    }
    return lengths;
}

Measures longest(const Rig& rig, const std::vector<double>& lengths) {
    Measures most;
    for (size_t i = 0; i < lengths.size(); ++i)
        most.of(rig.tracked[i]) = std::max(most.of(rig.tracked[i]), lengths[i]);
    return most;
}

bool within(const Measures& lengths, const Measures& still) {
    return lengths.bones <= still.bones && lengths.keys <= still.keys;
}

// The distances from P_0, a row for every pose. Throws if a pose equals P_0 or another pose.
std::vector<std::vector<double>> displacements_to_poses(const Rig& rig, const Measures& still) {
    const bool keys = has_keys(rig);
    std::vector<std::vector<double>> lengths;
    for (size_t k = 0; k < rig.poses.size(); ++k) {
        const ReferencePose& pose = rig.poses[k];
        lengths.push_back(displacements(rig, rig.neutral, pose.bones));
        if (within(longest(rig, lengths[k]), still))
            throw InvalidInput("pose " + pose.name + ": no bone " + (keys ? "and no shape key " : "") +
                               "moves in it: it is the neutral pose");
        for (size_t other = 0; other < k; ++other) {
            const auto apart = displacements(rig, rig.poses[other].bones, pose.bones);
            if (!within(longest(rig, apart), still)) continue;
            throw InvalidInput("pose " + pose.name + ": every bone " + (keys ? "and shape key " : "") +
                               "stands as in pose " + rig.poses[other].name);
        }
    }
    return lengths;
}

// "0 if J_iP0 = J_iPk": equal within a tolerance.
void find_moves(Model& model) {
    const Index poses = model.poses(), bones = model.bones();
    Measures still = extent(model.rig);
    still.bones *= kStillBone;
    still.keys *= kStillBone;
    const std::vector<std::vector<double>> lengths = displacements_to_poses(model.rig, still);
    std::vector<double> farthest(bones, 0.0);  // of each bone, over all poses
    for (const std::vector<double>& of_pose : lengths) {
        for (Index i = 0; i < bones; ++i) farthest[i] = std::max(farthest[i], of_pose[i]);
    }
    model.moves.assign(size_t(bones) * poses, 0);
    for (Index k = 0; k < poses; ++k) {
        const Measures most = longest(model.rig, lengths[k]);
        const auto mark = [&](double passed_by) {
            bool any = false;
            for (Index i = 0; i < bones; ++i) {
                const Tracked kind = model.rig.tracked[i];
                const double shortest = std::max(still.of(kind), kShortWay * most.of(kind));
                const bool moves = lengths[k][i] > shortest && lengths[k][i] >= passed_by * farthest[i];
                model.moves[size_t(i) * poses + k] = moves;
                any = any || moves;
            }
            return any;
        };
        if (!mark(kPassedBy)) mark(0.0);  // a weaker copy of another pose is also a pose
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

void check_weights(const SparseRows& weights, const Rig& rig) {
    const auto bones = static_cast<Index>(rig.names.size());
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
                throw InvalidInput(at + "expected a weight >= 0, got " + short_text(weights.weight[e]));
            }
            if (is_key(rig, weights.index[e]) && weights.weight[e] > 1.0f) {
                throw InvalidInput(at + "expected a weight of 0 to 1 for shape key " +
                                   rig.names[weights.index[e]] + ", got " + short_text(weights.weight[e]));
            }
        }
    }
}

// Convex rows, without the bones that are not in the rig: "we assume that skinning weights are convex".
// Weights of shape keys do not add up to a whole, so they are not changed.
void take_weights(Model& model, const SparseRows& given) {
    for (Index v = 0; v < given.rows(); ++v) {
        double sum = 0.0, keys = 0.0;
        for (Index e = given.start[v]; e < given.start[v + 1]; ++e)
            (is_key(model.rig, given.index[e]) ? keys : sum) += given.weight[e];
        model.unnormalised += sum > 0.0 && std::abs(sum - 1.0) > kWeightSum;
        model.unbound += !(sum > 0.0) && !(keys > 0.0);
        for (Index e = given.start[v]; e < given.start[v + 1]; ++e) {
            const bool key = is_key(model.rig, given.index[e]);
            if (!key && !(sum > 0.0)) continue;
            const auto weight = key ? given.weight[e] : static_cast<float>(given.weight[e] / sum);
            if (given.index[e] != kNone && weight > 0.0f) model.weights.add(given.index[e], weight);
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
    model.overlaps = has_keys(model.rig) && std::any_of(model.reach.begin(), model.reach.end(),
                                                        [](float reach) { return reach > 1.0f; });
}

}  // namespace

std::shared_ptr<const Model> build(const Rig& rig, const SparseRows& weights) {
    check_rig(rig);
    check_weights(weights, rig);
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
            // The paper divides by ||in_pose||. Divided by its square, alpha is a share, and exactly 1 in the
            // pose.
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

}  // namespace rumple::wrinkle_maps

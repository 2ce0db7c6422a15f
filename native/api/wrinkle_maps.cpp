// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_maps/wrinkle_maps.h"

#include <algorithm>

#include "api/call.h"
#include "api/sound.h"

using namespace rumple;
using namespace rumple::api;
using namespace rumple::wrinkle_maps;

static_assert(kMostPoses == RUMPLE_MOST_POSES);

struct rumple_wrinkle_maps {
    std::shared_ptr<const Model> model;
};

namespace {

// Limit for a component of a given normal: of a map of unit normals, possibly filtered.
constexpr double kMostNormal = 1e3;

Floats floats_in(std::span<const Vec3> vectors) {
    return {reinterpret_cast<const float*>(vectors.data()), 3 * vectors.size()};
}

std::span<const Bone> bones_in(const float* data, size_t count, const char* name) {
    return rows<Bone>(data, count, name);
}

Rig rig_of(const rumple_wrinkle_maps_plan& plan) {
    Rig rig;
    for (const char* name : values(plan.names, plan.names_count, "names"))
        rig.names.emplace_back(&given(name, "names"));
    for (const int32_t tracked : values(plan.tracked, plan.tracked_count, "tracked"))
        rig.tracked.push_back(choice(tracked, Tracked::kKey, "tracked"));
    rig.group = copied(values(plan.group, plan.group_count, "group"));
    rig.neutral = copied(bones_in(plan.neutral, plan.neutral_count, "neutral"));
    for (const rumple_wrinkle_maps_pose& pose : values(plan.poses, plan.poses_count, "poses")) {
        const char* name = &given(pose.name, "poses.name");
        rig.poses.push_back({name, copied(bones_in(pose.bones, pose.bones_count, name))});
    }
    return rig;
}

// Influences with valid counts, because presence() does not check them.
Influences influences_of(const Model& model, const float* pose, size_t pose_count, const float* rest,
                         size_t rest_count) {
    expect_rows("pose", pose_count, size_t(model.bones()) * size_t(model.poses()));
    expect_rows("rest", rest_count, size_t(model.bones()));
    Influences at{copied(values(pose, pose_count, "pose")), copied(values(rest, rest_count, "rest"))};
    expect_range("pose", at.pose, 0.0, 1.0);
    expect_range("rest", at.rest, 0.0, 1.0);
    return at;
}

}  // namespace

rumple_status rumple_wrinkle_maps_build(const rumple_wrinkle_maps_plan* plan, rumple_wrinkle_maps** model) {
    return made(model, "model", [&] {
        const rumple_wrinkle_maps_plan& from = given(plan, "plan");
        const SparseRows weights{copied(values(from.weight_start, from.weight_start_count, "weight_start")),
                                 copied(values(from.weight_bone, from.weight_bone_count, "weight_bone")),
                                 copied(values(from.weight, from.weight_count, "weight"))};
        return new rumple_wrinkle_maps{build(rig_of(from), weights)};
    });
}

void rumple_wrinkle_maps_free(rumple_wrinkle_maps* model) {
    delete model;
}

rumple_status rumple_wrinkle_maps_get_view(const rumple_wrinkle_maps* model, rumple_wrinkle_maps_view* view) {
    return guarded([&] {
        const Model& m = *given(model, "model").model;
        given(view, "view") = {m.vertices(),
                               m.poses(),
                               m.bones(),
                               count(m.weights.index),
                               m.unnormalised,
                               m.unbound,
                               m.moves.data(),
                               m.reach.data(),
                               m.weights.start.data(),
                               m.weights.index.data(),
                               m.weights.weight.data()};
    });
}

rumple_status rumple_bones_in_root_space(const float root[16], const float* bones, size_t bones_count,
                                         float* out, size_t out_count) {
    return guarded([&] {
        given(root, "root");
        glm::mat4 matrix;
        for (int r = 0; r < 4; ++r) {
            for (int c = 0; c < 4; ++c) matrix[c][r] = root[4 * r + c];
        }
        const auto to = output<Bone>(out, out_count, bones_count, "out");
        write(sound(in_root_space(matrix, bones_in(bones, bones_count, "bones"))), to);
    });
}

rumple_status rumple_wrinkle_maps_evaluate(const rumple_wrinkle_maps* model, const float* bones,
                                           size_t bones_count, float* pose, size_t pose_count, float* rest,
                                           size_t rest_count) {
    return guarded([&] {
        const Model& m = *given(model, "model").model;
        const auto to_pose = output<float>(pose, pose_count, size_t(m.bones()) * size_t(m.poses()), "pose");
        const auto to_rest = output<float>(rest, rest_count, size_t(m.bones()), "rest");
        const Influences at = evaluate(m, bones_in(bones, bones_count, "bones"));
        if (!all_finite(at.pose) || !all_finite(at.rest)) refuse_unsound();
        write(at.pose, to_pose);
        write(at.rest, to_rest);
    });
}

rumple_status rumple_wrinkle_maps_presence(const rumple_wrinkle_maps* model, const float* pose,
                                           size_t pose_count, const float* rest, size_t rest_count,
                                           float* presences, size_t presence_count) {
    return guarded([&] {
        const Model& m = *given(model, "model").model;
        const auto out = output<float>(presences, presence_count, size_t(m.poses()), "presence");
        write(sound(presence(m, influences_of(m, pose, pose_count, rest, rest_count))), out);
    });
}

rumple_wrinkle_maps_settings rumple_wrinkle_maps_settings_default(void) {
    return {Settings{}.gain, nullptr, 0};
}

rumple_status rumple_wrinkle_maps_masks(const rumple_wrinkle_maps* model,
                                        const rumple_wrinkle_maps_settings* settings, const float* pose,
                                        size_t pose_count, const float* rest, size_t rest_count, float* out,
                                        size_t out_count) {
    return guarded([&] {
        const Model& m = *given(model, "model").model;
        const rumple_wrinkle_maps_settings& from = given(settings, "settings");
        const Settings options{from.gain, copied(values(from.strength, from.strength_count, "strength"))};
        const auto to = output<float>(out, out_count, size_t(m.poses()) * size_t(m.vertices()), "masks");
        write(sound(masks(m, options, influences_of(m, pose, pose_count, rest, rest_count))), to);
    });
}

rumple_status rumple_wrinkle_maps_blend(int32_t kind, const float* neutral, size_t neutral_count,
                                        const float* const* wrinkles, const float* const* masks_of_poses,
                                        size_t poses, float* out, size_t out_count) {
    return guarded([&] {
        const Maps maps = choice(kind, Maps::kWrinkles, "maps");
        const auto normals = vectors(neutral, neutral_count, "neutral");
        expect_range("neutral", floats_in(normals), -kMostNormal, kMostNormal);
        const auto to = output<Vec3>(out, out_count, neutral_count, "out");
        const auto maps_in = values(wrinkles, poses, "wrinkles"),
                   masks_in = values(masks_of_poses, poses, "masks");
        for (size_t k = 0; k < poses; ++k) {
            expect_range("wrinkles", floats_in(vectors(maps_in[k], neutral_count, "wrinkles")), -kMostNormal,
                         kMostNormal);
            expect_range("masks", values(masks_in[k], neutral_count, "masks"), 0.0, 1.0);
        }
        std::vector<Vec3> w(poses);
        std::vector<float> m(poses);
        for (size_t p = 0; p < normals.size(); ++p) {
            for (size_t k = 0; k < poses; ++k) {
                w[k] = {maps_in[k][3 * p], maps_in[k][3 * p + 1], maps_in[k][3 * p + 2]};
                m[k] = masks_in[k][p];
            }
            to[p] = blend(maps, normals[p], w, m);
        }
    });
}

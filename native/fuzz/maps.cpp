// SPDX-License-Identifier: GPL-3.0-or-later
// Wrinkle Maps: bones, reference poses, weights.
#include "world.h"

namespace rumple::fuzz {
namespace {

std::vector<float> skeleton(size_t bones, Bytes& bytes) {
    std::vector<float> out;
    for (size_t b = 0; b < bones; ++b) {
        for (int k = 0; k < 6; ++k)
            out.push_back(float(b) + 0.3f * float(k) + 0.5f * float(bytes.byte() % 4));
    }
    if (bytes.hostile() && !out.empty()) out[size_t(bytes.below(int(out.size())))] = bytes.real(-2.0f, 2.0f);
    return out;
}

void build_model(World& world, Bytes& bytes) {
    const auto bones = size_t(bytes.below(5)), poses = size_t(bytes.below(4)),
               vertices = size_t(bytes.below(6));
    const std::vector<const char*> names(bones, bytes.hostile() ? nullptr : "bone");
    std::vector<std::int32_t> tracked(bones, bytes.whole(0, 3)), group, start{0}, bone;
    for (size_t b = 0; b < bones; ++b) {
        const int number = bytes.whole(-1, 2);
        group.push_back(number);
        if (number == 2) tracked[b] = RUMPLE_TRACKED_KEY;
    }
    for (size_t v = 0; v < vertices; ++v) {
        for (int k = bytes.below(3); k > 0; --k) bone.push_back(bytes.whole(-1, int(bones)));
        start.push_back(std::int32_t(bone.size()));
    }
    if (bytes.hostile()) start[size_t(bytes.below(int(start.size())))] = bytes.whole(0, 9);
    const Floats neutral(skeleton(bones, bytes), 6, bytes),
        weight(values(bone.size(), 0.0f, 1.0f, bytes), 1, bytes);
    const Numbers bone_of(bone, 1, bytes), starts(start, 1, bytes);
    std::vector<std::vector<float>> posed;
    for (size_t o = 0; o < poses; ++o) posed.push_back(skeleton(bones, bytes));
    std::vector<rumple_wrinkle_maps_pose> reference;
    for (const auto& pose : posed) reference.push_back({"pose", pose.data(), bones});
    const rumple_wrinkle_maps_plan plan{names.data(),     names.size(),     tracked.data(),  tracked.size(),
                                        group.data(),     group.size(),     neutral.pointer, neutral.count,
                                        reference.data(), reference.size(), starts.pointer,  starts.count,
                                        bone_of.pointer,  bone_of.count,    weight.pointer,  weight.count};
    auto base = std::make_shared<Base>();
    const auto* model =
        world.maps.add(MAKE(rumple_wrinkle_maps, rumple_wrinkle_maps_build, &plan), std::move(base), 0);
    rumple_wrinkle_maps_view view;
    if (!model || CALL(rumple_wrinkle_maps_get_view, model->handle, &view) != RUMPLE_OK) return;
    expect_finite("reach", view.reach, size_t(view.vertex_count) * size_t(view.pose_count));
    expect_finite("weight", view.weight, size_t(view.weight_count));
    expect_starts("weights", view.weight_start, size_t(view.vertex_count) + 1, view.weight_count);
    expect_within("weight bone", view.weight_bone, size_t(view.weight_count), 0, view.bone_count - 1);
}

void evaluate(World& world, Bytes& bytes) {
    const auto model = world.maps.pick(bytes);
    rumple_wrinkle_maps_view view{};
    CALL(rumple_wrinkle_maps_get_view, model.handle, &view);
    const auto bones = size_t(view.bone_count), poses = size_t(view.pose_count);
    const Floats posed(skeleton(bones, bytes), 6, bytes);
    Written pose(bones * poses, 1, bytes), rest(bones, 1, bytes), presence(poses, 1, bytes),
        masks(poses * size_t(view.vertex_count), 1, bytes);
    const rumple_status status = CALL(rumple_wrinkle_maps_evaluate, model.handle, posed.pointer, posed.count,
                                      pose.pointer(), pose.count, rest.pointer(), rest.count);
    pose.check(status, "influence");
    rest.check(status, "rest influence");
    if (bytes.hostile() && pose.count > 0) pose.data[0] = bytes.real(0.0f, 1.0f);
    presence.check(CALL(rumple_wrinkle_maps_presence, model.handle, pose.pointer(), pose.count,
                        rest.pointer(), rest.count, presence.pointer(), presence.count),
                   "presence");
    rumple_wrinkle_maps_settings settings = CALL(rumple_wrinkle_maps_settings_default);
    const Floats strength(values(poses, 0.0f, 1.0f, bytes), 1, bytes);
    settings.gain = bytes.real(0.1f, 10.0f);
    settings.strength = strength.pointer;
    settings.strength_count = bytes.byte() % 2 == 1 ? strength.count : 0;
    masks.check(CALL(rumple_wrinkle_maps_masks, model.handle, &settings, pose.pointer(), pose.count,
                     rest.pointer(), rest.count, masks.pointer(), masks.count),
                "masks");
}

void to_root(World&, Bytes& bytes) {
    float root[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    for (int k = bytes.below(4); k > 0; --k) root[bytes.below(16)] = bytes.real(-2.0f, 2.0f);
    const Floats bones(skeleton(2, bytes), 6, bytes);
    Written out(2, 6, bytes);
    out.check(CALL(rumple_bones_in_root_space, bytes.hostile() ? nullptr : root, bones.pointer, bones.count,
                   out.pointer(), out.count),
              "bones");
}

void blend(World&, Bytes& bytes) {
    const std::vector<float> normals = values(9, -1.0f, 1.0f, bytes), mask = values(3, 0.0f, 1.0f, bytes);
    const Floats neutral(values(9, -1.0f, 1.0f, bytes), 3, bytes);
    const float* const wrinkles[2] = {normals.data(), bytes.hostile() ? nullptr : normals.data()};
    const float* const masks[2] = {mask.data(), mask.data()};
    Written out(3, 3, bytes);
    out.check(CALL(rumple_wrinkle_maps_blend, bytes.whole(0, 1), neutral.pointer, neutral.count, wrinkles,
                   masks, size_t(bytes.below(3)), out.pointer(), out.count),
              "blended");
}

void free_one(World& world, Bytes& bytes) {
    world.maps.free_one(bytes);
}

}  // namespace

const std::vector<Operation> kMaps = {build_model, evaluate, to_root, blend, free_one};

}  // namespace rumple::fuzz

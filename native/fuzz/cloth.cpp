// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies, the base cloth and its cover.
#include "damage.h"
#include "world.h"

namespace rumple::fuzz {
namespace {

rumple_base_cloth_settings cloth_settings(Bytes& bytes) {
    rumple_base_cloth_settings s = CALL(rumple_base_cloth_settings_default);
    bytes.vary(s.stretch, s.strain_limit, s.shear, s.compression, s.compression_limit, s.folded, s.smoothing,
               s.slack, s.follow, s.room, s.gravity, s.thickness, s.unknown, s.reach, s.depth, s.spread,
               s.steps, s.start_steps, s.most_cg_iterations, s.slide_room, s.friction, s.hang, s.tube_radius,
               s.flat_share, s.hem_share);
    return s;
}

rumple_base_cloth_swing cloth_swing(Bytes& bytes) {
    rumple_base_cloth_swing s = CALL(rumple_base_cloth_swing_default);
    bytes.vary(s.seconds, s.longest_step, s.newton_steps, s.damping, s.locomotion, s.drag, s.wind, s.shift);
    if (bytes.byte() % 8 == 7) s.matrix[bytes.below(9)] = bytes.real(-2.0f, 2.0f);
    return s;
}

void build_collider(World& world, Bytes& bytes) {
    const Mesh from = mesh(bytes);
    std::vector<std::int32_t> triangle;
    for (const std::int32_t c : from.triangle)
        triangle.push_back(c >= 0 && size_t(c) < from.corner.size() ? from.corner[size_t(c)] : c);
    const Floats positions(from.positions, 3, bytes);
    const Numbers triangles(triangle, 3, bytes);
    const Floats rest(bytes.byte() % 2 ? from.positions : std::vector<float>(), 3, bytes);
    auto* collider =
        MAKE(rumple_collider, rumple_collider_build, positions.pointer, positions.count, triangles.pointer,
             triangles.count, rest.pointer, rest.count, bytes.real(0.0f, 1.0f));
    auto base = std::make_shared<Base>();
    base->rest = from.positions;
    base->vertices = CALL(rumple_collider_vertex_count, collider);
    base->rest.resize(size_t(base->vertices) * 3);
    base->triangles = std::int32_t(triangles.count);
    world.colliders.add(collider, std::move(base), 0);
}

void build_cloth(World& world, Bytes& bytes) {
    const auto surface = world.surfaces.pick(bytes);
    world.cloths.add(MAKE(rumple_base_cloth, rumple_base_cloth_build, surface.handle), surface.base, 0);
}

void paint_cloth(World& world, Bytes& bytes) {
    const auto model = world.cloths.pick(bytes);
    const size_t vertices = model.base ? size_t(model.base->vertices) : 3;
    const Floats follow(values(vertices, 0.0f, 1.0f, bytes), 1, bytes),
        room(values(vertices, 0.0f, 1.0f, bytes), 1, bytes);
    const rumple_base_cloth_painted painted{follow.pointer, follow.count, room.pointer,
                                            bytes.byte() % 2 == 1 ? room.count : 0};
    world.cloth_paints.add(
        MAKE(rumple_base_cloth_paint, rumple_base_cloth_paint_build, model.handle, &painted), model.base,
        model.id ? model.model : 1);
}

void keep_state(World& world, rumple_base_cloth_state* state, const Entry<rumple_base_cloth>& model) {
    rumple_base_cloth_state_view view;
    const auto* kept = world.cloth_states.add(state, model.base, model.model);
    if (!kept || CALL(rumple_base_cloth_state_get_view, kept->handle, &view) != RUMPLE_OK) return;
    const auto vertices = size_t(view.vertex_count);
    expect_finite("cloth positions", view.positions, 3 * vertices);
    expect_finite("gap", view.gap, vertices);
    expect_finite("velocity", view.velocity, 3 * size_t(view.velocity_count));
    expect_finite("cloth offset", view.offset, 3 * size_t(view.offset_count));
    expect_finite("clearance", view.clearance, size_t(view.clearance_count));
    expect_within("body hint", view.body_hint, size_t(view.body_hint_count), -1, 6000);
    require(view.vertex_count == model.base->vertices || view.vertex_count == 0, "vertices",
            "rumple_base_cloth_state_get_view");
}

// Fields at every vertex, chosen by the bits of a byte, so that kept inputs read no additional byte.
struct Acting {
    std::vector<float> air, push, resist;

    Acting(size_t vertices, int bits, rumple_base_cloth_swing& swing) {
        give(air, 3 * vertices * ((bits >> 1) & 1), swing.air);
        give(push, 3 * vertices * ((bits >> 2) & 1), swing.push);
        give(resist, 2 * vertices * ((bits >> 3) & 1), swing.resist);
        swing.air_count = air.size() / 3;
        swing.push_count = push.size() / 3;
        swing.resist_count = resist.size() / 2;
        if (bits >> 4 == 14 && swing.push_count > 0) --swing.push_count;
        if (bits >> 4 == 15 && !resist.empty()) resist.back() = kHostileReals[bits & 3];
    }

  private:
    static void give(std::vector<float>& values, size_t count, const float*& place) {
        for (size_t i = 0; i < count; ++i) values.push_back(0.5f * float(i % 7));
        place = values.empty() ? nullptr : values.data();
    }
};

void solve_cloth(World& world, Bytes& bytes) {
    const auto model = world.cloths.pick(bytes);
    const auto settings = cloth_settings(bytes);
    auto swing = cloth_swing(bytes);
    const auto paint = world.cloth_paints.pick_of(model.model, bytes);
    const auto before = world.cloth_states.pick_of(model.model, bytes);
    std::vector<float> keep;
    const rumple_bodies worn_over = bodies(world, keep, bytes);
    const Floats positions(model.base ? pose_of(model.base->rest, bytes) : std::vector<float>(9), 3, bytes);
    rumple_base_cloth_report report;
    rumple_base_cloth_state* state = nullptr;
    const int bits = bytes.byte();
    const bool swings = bits % 2 == 1;
    const Acting acting(model.base ? size_t(model.base->vertices) : 3, bits, swing);
    const auto* on = bytes.byte() % 2 == 1 ? &worn_over : nullptr;
    if (swings) {
        state = MAKE(rumple_base_cloth_state, rumple_base_cloth_swing_solve, model.handle, &settings, &swing,
                     paint.handle, positions.pointer, positions.count, on, before.handle, &report);
    } else {
        state = MAKE(rumple_base_cloth_state, rumple_base_cloth_solve, model.handle, &settings, paint.handle,
                     positions.pointer, positions.count, on, before.handle, &report);
    }
    expect_of_model(state ? RUMPLE_OK : RUMPLE_INVALID, model.model, "cloth", paint, before);
    if (state) expect_finite("cloth report", &report.moved, 6);
    keep_state(world, state, model);
}

// Restores a state as from a file: a copy of a state, possibly damaged, for a model that may be another one.
void restore_cloth(World& world, Bytes& bytes) {
    const auto from = world.cloth_states.pick(bytes);
    const auto model = world.cloths.pick(bytes);
    rumple_base_cloth_kept kept{};
    if (CALL(rumple_base_cloth_state_get_kept, from.handle, &kept) != RUMPLE_OK) return;
    static_assert(sizeof kept == 29 * 8, "a new array? damage it as well");
    Damage damage(bytes);
    kept.push = kept.velocity;  // any values of the right size
    kept.push_count = kept.velocity_count;
    damage(kept.offset, kept.offset_count, 3);
    damage(kept.length, kept.length_count);
    damage(kept.clearance, kept.clearance_count);
    damage(kept.ahead_height, kept.ahead_height_count);
    damage(kept.body_hint, kept.body_hint_count);
    damage(kept.contact_hint, kept.contact_hint_count);
    damage(kept.position, kept.position_count, 3);
    damage(kept.velocity, kept.velocity_count, 3);
    damage(kept.animated, kept.animated_count, 3);
    damage(kept.animated_before, kept.animated_before_count, 3);
    damage(kept.air, kept.air_count, 3);
    damage(kept.push, kept.push_count, 3);
    bytes.vary(kept.moved, kept.seconds, kept.fastest, kept.gravity, kept.wind);
    keep_state(world,
               MAKE(rumple_base_cloth_state, rumple_base_cloth_state_build, model.handle,
                    bytes.hostile() ? nullptr : &kept),
               model);
}

rumple_force_field force_field(Bytes& bytes) {
    rumple_force_field f = CALL(rumple_force_field_default);
    f.kind = bytes.whole(0, 5);
    f.shape = bytes.whole(0, 2);
    f.falloff = bytes.whole(0, 2);
    bytes.vary(f.side, f.location, f.axis, f.strength, f.damping, f.size, f.flow, f.noise, f.seed);
    bytes.vary(f.power, f.least, f.most, f.ends, f.radial_power, f.radial_least, f.radial_most, f.radial_ends,
               f.inverse_square, f.in_world);
    return f;
}

void evaluate_fields(Bytes& bytes) {
    std::vector<rumple_force_field> fields;
    for (int k = bytes.below(4); k > 0; --k) fields.push_back(force_field(bytes));
    const size_t points = size_t(bytes.below(6));
    std::vector<float> places(3 * points, 0.0f);
    for (float& place : places) place = bytes.real(-3.0f, 3.0f);
    const Floats positions(places, 3, bytes);
    Written air(points, 3, bytes), push(points, 3, bytes), resist(points, 2, bytes);
    const rumple_status status = CALL(rumple_force_fields_evaluate, fields.data(), fields.size(),
                                      bytes.whole(0, 9), positions.pointer, positions.count, air.pointer(),
                                      air.count, push.pointer(), push.count, resist.pointer(), resist.count);
    air.check(status, "air");
    push.check(status, "push");
    resist.check(status, "resist");
}

void activate_cloth(World& world, Bytes& bytes) {
    const auto state = world.cloth_states.pick(bytes);
    world.cloth_states.add(MAKE(rumple_base_cloth_state, rumple_base_cloth_state_activated, state.handle),
                           state.base, state.model);
    restore_cloth(world, bytes);
    evaluate_fields(bytes);
}

void lift_cover(World& world, Bytes& bytes) {
    const auto surface = world.surfaces.pick(bytes);
    const auto* cover = world.covers.add(MAKE(rumple_cloth_cover, rumple_cloth_cover_build, surface.handle),
                                         surface.base, surface.id);
    rumple_cloth_cover_settings settings = CALL(rumple_cloth_cover_settings_default);
    bytes.vary(settings.thickness, settings.depth);
    std::vector<float> keep;
    const rumple_bodies worn_over = bodies(world, keep, bytes);
    const size_t vertices = cover ? size_t(cover->base->vertices) : 3;
    const Floats positions(cover ? pose_of(cover->base->rest, bytes) : std::vector<float>(9), 3, bytes);
    std::vector<std::int32_t> near(vertices, 0);
    for (int k = bytes.below(4); k > 0; --k) near[size_t(bytes.below(int(vertices)))] = bytes.whole(-1, 4);
    const Numbers hints(near, 1, bytes);
    Written lifts(vertices, 3, bytes), room(vertices, 1, bytes);
    const rumple_status status = CALL(rumple_cloth_cover_lift, cover ? cover->handle : nullptr, &settings,
                                      &worn_over, positions.pointer, positions.count, hints.pointer,
                                      hints.count, lifts.pointer(), lifts.count, room.pointer(), room.count);
    lifts.check(status, "lifts");
    room.check(status, "room");
}

void untangle_cloth(World& world, Bytes& bytes) {
    const auto surface = world.surfaces.pick(bytes);
    const size_t vertices = surface.handle ? size_t(surface.base->vertices) : 3;
    const auto pose = [&] {
        return surface.handle ? pose_of(surface.base->rest, bytes) : std::vector<float>(9);
    };
    const Floats animated(pose(), 3, bytes), positions(pose(), 3, bytes);
    Written untangled(vertices, 3, bytes);
    untangled.check(CALL(rumple_cloth_untangle, surface.handle, animated.pointer, animated.count,
                         positions.pointer, positions.count, untangled.pointer(), untangled.count),
                    "untangled");
}

void free_one(World& world, Bytes& bytes) {
    free_one_of(bytes, world.cloths, world.cloth_states, world.colliders, world.covers);
}

}  // namespace

rumple_bodies bodies(const World& world, std::vector<float>& keep, Bytes& bytes) {
    const auto collider = world.colliders.pick(bytes);
    if (!collider.handle) return {};
    keep = pose_of(collider.base->rest, bytes);
    return {collider.handle, keep.data(), keep.size() / 3 - (bytes.hostile() ? 1 : 0)};
}

const std::vector<Operation> kCloth = {build_cloth, build_collider, paint_cloth,    solve_cloth, solve_cloth,
                                       lift_cover,  activate_cloth, untangle_cloth, free_one};

}  // namespace rumple::fuzz

// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/base_cloth.h"

#include <cmath>
#include <limits>
#include <utility>

#include "base/expect.h"
#include "base/tolerances.h"
#include "surface/cloth/equilibrium.h"

namespace rumple::base_cloth {
namespace {

constexpr int kContactEvery = 2;  // Newton steps, from a given state: see Schedule::contact_every
// A limb that straightens makes springs taut one after another. If a step stopped at the first of them, it
// would be a tenth as long as possible. So a step may overshoot: springs that are taut after it are in the
// Hessian of the next step, which goes back where needed (a non-monotone line search: Grippo, Lampariello and
// Lucidi, SIAM Journal on Numerical Analysis 23, 1986).
constexpr double kOvershoot = 50.0;
// Share of the whole spread of the vertices that a flat garment has across itself.
constexpr double kFlatSpread = 1e-6;

bool fits(const Model& model, const State* state) {
    return state && state->offset.size() == model.area.size() && matches(model, *state);
}

// The way in which a frame is solved.
struct Schedule {
    bool held = false;      // the state before does not change
    int most_steps = 0;     // largest number of Newton steps
    int contact_every = 1;  // number of steps between two searches for the nearest inner surface
    float settled = 0.0f;   // a step that moves every vertex by less than this is the last one, object units
    float no_nearer = std::numeric_limits<float>::infinity();  // for has_settled(), object units
};

// A step that moves every vertex by less than this is the last one of a frame in which the pose changes.
float solved_within(const Model& model) {
    return kSettledCloth * static_cast<float>(mean_length(model));
}

// Gravity in the frame of the rest shape: R^T g for a pose that is the rest shape turned by R. In other poses
// it is the regression of the heights of the animated vertices over their places at rest.
Vec3 gravity_at_rest(const Model& model, const Settings& settings, const Pose& pose) {
    const std::vector<Vec3>& rest = model.surface.positions_rest;
    glm::dvec3 middle_at_rest(0.0), middle(0.0);
    double area = 0.0;
    for (size_t v = 0; v < rest.size(); ++v) {
        middle_at_rest += double(model.area[v]) * glm::dvec3(rest[v]);
        middle += double(model.area[v]) * glm::dvec3(pose.animated[v]);
        area += double(model.area[v]);
    }
    if (area <= 0.0) return settings.gravity;
    const glm::dvec3 gravity(settings.gravity);
    glm::dmat3 spread(0.0);
    glm::dvec3 fall(0.0);
    for (size_t v = 0; v < rest.size(); ++v) {
        const glm::dvec3 from_middle = glm::dvec3(rest[v]) - middle_at_rest / area;
        spread += glm::outerProduct(double(model.area[v]) * from_middle, from_middle);
        fall += double(model.area[v]) * glm::dot(glm::dvec3(pose.animated[v]) - middle / area, gravity) *
                from_middle;
    }
    const double least = kFlatSpread * (spread[0][0] + spread[1][1] + spread[2][2]);
    const Vec3 found(glm::inverse(spread + glm::dmat3(least)) * fall);
    return std::isfinite(found.x + found.y + found.z) ? found : settings.gravity;
}

// Whether nothing that acts on the cloth has changed since a state was solved, but for rounding. If the cloth
// turns as a whole, all lengths and distances stay, but its weight pulls it another way.
bool acts_as_before(const Model& model, const Settings& settings, const Pose& pose, const Vec3& gravity,
                    const State& state) {
    return glm::distance(gravity, state.motion.gravity) <= kHeldStrain * glm::length(settings.gravity) &&
           same_pose(model, pose, state, kHeldStrain * settings.room);
}

Schedule schedule_of(const Model& model, const Settings& settings, const Pose& pose, const Vec3& gravity,
                     const State* before) {
    if (!before) return {false, settings.start_steps, 1, 0.0f};
    if (!acts_as_before(model, settings, pose, gravity, *before))
        return {false, settings.steps, kContactEvery, solved_within(model)};
    const float at_rest = kStillCloth * settings.room;
    const bool held = before->moved <= at_rest;
    return {held, held ? 0 : settings.steps, kContactEvery, at_rest, 0.5f * before->moved};
}

// Whether cloth in a held pose stays from now on. Contacts and friction limits come from the step before, so
// the cloth may slip back and forth between them for ever. Small steps that are more than half as long as in
// the frame before do not lead to rest.
bool has_settled(const Model& model, const Schedule& schedule, float moved) {
    return moved >= schedule.no_nearer && moved < solved_within(model);
}

}  // namespace

SolveTeam team_for(const Model& model) {
    return {0, model.area.size(), kLeastSearches};
}

void check(const Settings& settings) {
    expect_within("stretch", settings.stretch, 1e-9, 1e12);
    expect_within("strain_limit", settings.strain_limit, 0.0, 1e3);
    expect_within("shear", settings.shear, 0.0, 1e12);
    expect_within("compression", settings.compression, 0.0, 1e12);
    expect_within("compression_limit", settings.compression_limit, 0.0, 1.0);
    expect_within("folded", settings.folded, 0.0, 1e12);
    expect_within("smoothing", settings.smoothing, 0.0, 1e12);
    expect_within("tube_radius", settings.tube_radius, 1e-9, 1e9);
    expect_within("flat_share", settings.flat_share, 0.0, 1.0);
    expect_within("hem_share", settings.hem_share, 0.0, 1.0);
    expect_within("slack", settings.slack, 1e-3, 1e3);
    expect_within("hang", glm::length(settings.hang), 0.0, 1.0 + 1e-5);
    expect_within("follow", settings.follow, 1e-6, 1e9);
    expect_within("room", settings.room, 0.0, 1e9);
    expect_within("slide_room", settings.slide_room, 0.0, 1e9);
    expect_within("friction", settings.friction, 0.0, 1e3);
    expect_finite<Vec3>("gravity", {&settings.gravity, 1}, "value");
    expect_within("thickness", settings.clearance.thickness, 0.0, 1e9);
    expect_within("unknown", settings.clearance.unknown, 0.0, 1e9);
    expect_within("reach", settings.clearance.reach, 1e-9, 1e9);
    expect_within("depth", settings.clearance.depth, 1e-9, 1e9);
    expect_within("spread", settings.clearance.spread, 1e-9, 1e9);
    expect_within("steps", settings.steps, 0, 1e6);
    expect_within("start_steps", settings.start_steps, 0, 1e6);
    expect_within("most_cg_iterations", settings.most_cg_iterations, 0, 1e6);
}

Result solve(const Model& model, const Settings& settings, const Paint& paint,
             std::span<const Vec3> positions, const PosedCollider* bodies, const State* before) {
    check(settings);
    const SolveTeam team = team_for(model);
    if (!fits(model, before)) before = nullptr;
    std::vector<Index> body_hint = before ? before->body_hint : std::vector<Index>();
    const Pose pose = make_pose(model, settings, paint, positions, bodies, body_hint);
    return solve_pose(model, settings, pose, bodies != nullptr, std::move(body_hint), before);
}

Result solve_pose(const Model& model, const Settings& settings, const Pose& pose, bool has_bodies,
                  std::vector<Index> body_hint, const State* before) {
    const size_t vertices = model.area.size();
    Result out;
    out.state.body_hint = std::move(body_hint);
    out.state.contact_hint = before ? before->contact_hint : model.triangle_of;
    std::vector<Vec3> x = pose.animated;
    for (size_t v = 0; before && v < vertices; ++v) x[v] += pose.frame[v].to_object(before->offset[v]);
    std::vector<Plane> planes(vertices);
    look_for_contacts(model, pose, x, out.state.contact_hint, planes);
    const Vec3 gravity = gravity_at_rest(model, settings, pose);
    const Schedule schedule = schedule_of(model, settings, pose, gravity, before);
    for (bool last = schedule.most_steps == 0; !last;) {
        last = ++out.report.steps == schedule.most_steps;
        NewtonProblem problem{model, settings, pose, planes};
        if (!last) problem.overshoot = kOvershoot;
        out.report.moved = newton_step(problem, x, out.report);
        last = last || out.report.moved < schedule.settled;
        if (last || out.report.steps % schedule.contact_every == 0)
            look_for_contacts(model, pose, x, out.state.contact_hint, planes);
    }
    for (size_t v = 0; v < vertices; ++v) {
        out.state.offset.push_back(schedule.held ? before->offset[v]
                                                 : pose.frame[v].to_local(x[v] - pose.animated[v]));
    }
    keep_pose(pose, schedule.held ? before : nullptr, out.state);
    out.state.motion.gravity = schedule.held ? before->motion.gravity : gravity;
    out.state.moved = has_settled(model, schedule, out.report.moved) ? 0.0f : out.report.moved;
    // The state keeps the equilibrium, not the projected positions. A solve that started from projected
    // positions would leave its equilibrium in every frame.
    finish(model, settings, pose, planes, has_bodies, x, out);
    return out;
}

}  // namespace rumple::base_cloth

// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/swing.h"

#include <algorithm>
#include <cmath>

#include "base/expect.h"
#include "base/tolerances.h"
#include "surface/cloth/equilibrium.h"
#include "surface/cloth/locomotion.h"

namespace rumple::base_cloth {
namespace {

constexpr double kStepSlack = 1e-3;    // share by which a time step may exceed the longest one
constexpr float kTurning = 1.0f / 30;  // s: speed gained in this time counts too: turning cloth is slow
constexpr double kMostSteps = 64;      // in a frame; if it needs more, all of them are longer

bool fits(const Model& model, const State* state) {
    return state && state->motion.position.size() == model.area.size() && matches(model, *state);
}

// Fields that act on every welded vertex, in addition to gravity and the wind. Each may be empty.
struct Acting {
    std::vector<Vec3> air, push, resist;  // as in Swing; resist: z is unused

    Vec3 air_at(const Swing& swing, Index v) const { return air.empty() ? swing.wind : swing.wind + air[v]; }
    // The mean over a triangle. If its corners are equal, it is exactly their value.
    Vec3 air_at(const Swing& swing, const std::array<Index, 3>& corner) const {
        const Vec3 first = air_at(swing, corner[0]);
        if (air.empty()) return first;
        return first + (air_at(swing, corner[1]) - first + (air_at(swing, corner[2]) - first)) / 3.0f;
    }
};

std::vector<Vec3> welded(const Model& model, std::span<const Vec3> display) {
    return display.empty() ? std::vector<Vec3>() : weld_positions(model.surface, display);
}

Acting acting_on(const Model& model, const Swing& swing) {
    std::vector<Vec3> resist;
    for (const Vec2& r : swing.resist) resist.emplace_back(r, 0.0f);
    return {welded(model, swing.air), welded(model, swing.push), welded(model, resist)};
}

// What all time steps of a frame have in common.
struct Frame {
    const Model& model;
    const Settings& settings;
    const Swing& swing;
    const Pose& pose;  // at its end
    Acting acting;
};

// ---------------------------------------------------------------- locomotion
// The motion of the frame before, in the object space of this one. The part of the garment's own motion that
// causes no inertia is applied to it. In these coordinates Newton's laws hold for the whole frame.
Motion carried(const Frame& frame, Motion motion) {
    const Swing& swing = frame.swing;
    for (size_t v = 0; v < motion.position.size(); ++v) {
        motion.position[v] = swing.placement.of_point(motion.position[v]);
        motion.animated[v] = swing.placement.of_point(motion.animated[v]);
        motion.animated_before[v] = swing.placement.of_point(motion.animated_before[v]);
        motion.velocity[v] = swing.placement.matrix * motion.velocity[v];
    }
    const RigidMotion part = part_of(rigid_motion(frame.model.area, motion.animated, frame.pose.animated),
                                     1.0 - double(swing.locomotion));
    for (size_t v = 0; v < motion.position.size(); ++v) {
        motion.position[v] = part.of_point(motion.position[v]);
        motion.animated[v] = part.of_point(motion.animated[v]);
        motion.animated_before[v] = part.of_point(motion.animated_before[v]);
        motion.velocity[v] = part.of_direction(motion.velocity[v]);
    }
    return motion;
}

Vec3 at_or_none(const std::vector<Vec3>& of, size_t v) {
    return of.empty() ? Vec3(0.0f) : of[v];
}

// Whether the forces on every vertex have changed by at most `most`, object units / s^2.
bool acts_as_before(const Frame& frame, const Motion& was, float most) {
    const Swing& swing = frame.swing;
    const Acting& acting = frame.acting;
    if (was.wind != swing.wind) return false;
    for (size_t v = 0; v < was.position.size(); ++v) {
        const Vec3 air = swing.wind + at_or_none(acting.air, v),
                   air_before = was.wind + at_or_none(was.air, v);
        const float speeds = glm::length(air) + glm::length(air_before);
        if (swing.drag * speeds * glm::distance(air, air_before) > most) return false;
        if (glm::distance(at_or_none(acting.push, v), at_or_none(was.push, v)) > most) return false;
    }
    return true;
}

// Whether everything that acts on the cloth is the same but for rounding, and the cloth had come to rest.
// Then it does not change at all.
bool holds(const Frame& frame, const Motion& was, const State& state) {
    const Pose& pose = frame.pose;
    const float length = static_cast<float>(mean_length(frame.model)), still = kHeldStrain * length;
    if (was.fastest > kStillSwing * length) return false;
    if (was.gravity != frame.settings.gravity) return false;
    // A smaller change moves no vertex by more than `still` against the pull back alone.
    if (!acts_as_before(frame, was, still * frame.settings.follow)) return false;
    if (!same_pose(frame.model, pose, state, still)) return false;
    for (size_t v = 0; v < pose.animated.size(); ++v) {
        if (glm::distance(pose.animated[v], was.animated[v]) > still) return false;
    }
    return true;
}

// ---------------------------------------------------------------- a time step
struct TimeStep {
    const Pose& pose;  // at its end
    float h;           // s
};

// Per vertex: the coefficient of air drag, area / s. A triangle is pushed along its normal by the square of
// the speed of the air relative to it. One of the two factors is the speed at the beginning of the step.
std::vector<glm::mat3> drag_of(const Frame& frame, const Motion& motion) {
    const Surface& surface = frame.model.surface;
    const std::vector<Vec3>&x = motion.position, &velocity = motion.velocity;
    std::vector<glm::mat3> out(x.size(), glm::mat3(0.0f));
    if (frame.swing.drag <= 0.0f) return out;
    for (Index t = 0; t < static_cast<Index>(surface.triangles.size()); ++t) {
        const std::array<Index, 3> v = welded_vertices(surface, t);
        const Vec3 normal = glm::cross(x[v[1]] - x[v[0]], x[v[2]] - x[v[0]]);
        const float twice_area = glm::length(normal);
        if (twice_area < kSmallestArea) continue;
        const Vec3 n = normal / twice_area;
        const Vec3 met =
            frame.acting.air_at(frame.swing, v) - (velocity[v[0]] + velocity[v[1]] + velocity[v[2]]) / 3.0f;
        const float drag = twice_area / 6.0f * frame.swing.drag * std::abs(glm::dot(met, n));
        const glm::mat3 along = drag * glm::outerProduct(n, n);
        for (const Index corner : v) out[corner] += along;
    }
    return out;
}

// The displacement of every vertex by inertia. It ends at the edge of the room.
std::vector<Vec3> inertial_displacements(const TimeStep& step, const Motion& motion) {
    std::vector<Vec3> out;
    for (size_t v = 0; v < motion.position.size(); ++v) {
        const Vec3 displacement = step.h * motion.velocity[v], there = motion.position[v] + displacement;
        const Vec3 kept = step.pose.within_room(v, there);
        out.push_back(kept == there ? displacement : kept - motion.position[v]);
    }
    return out;
}

// Pinned vertices start at the animation, free vertices where inertia moves them. Otherwise most iterations
// of conjugate gradients would be for the pins.
std::vector<Vec3> first_guess(const TimeStep& step, const Motion& motion,
                              std::span<const Vec3> displacement) {
    const auto& [pose, h] = step;
    std::vector<Vec3> out;
    for (size_t v = 0; v < displacement.size(); ++v) {
        const float pull = pose.follow[v] * h * h;
        const Vec3 animated_displacement = pose.animated[v] - motion.animated[v];
        out.push_back(motion.position[v] + (displacement[v] + pull * animated_displacement) / (1.0f + pull));
    }
    return out;
}

// Half of A |x - y|^2 / h^2, y = from + displacement (Gast 2015), and the forces that depend on velocity, as
// functions whose slope is the force at the end of the step. Damping: A d / (2 h) |(x - from) - (displacement
// of the animation)|^2. Air: h / 2 u . D u, u = wind - (x - from) / h. Push: -A push . x. Resistance: A r /
// (2 h) |x - from|^2.
Inertia inertia_of(const Frame& frame, const TimeStep& step, const Motion& motion,
                   std::span<const Vec3> displacement) {
    const auto& [pose, h] = step;
    const Swing& swing = frame.swing;
    const Acting& acting = frame.acting;
    const std::vector<float>& area = frame.model.area;
    Inertia out{motion.position, {}, drag_of(frame, motion)};
    for (size_t v = 0; v < displacement.size(); ++v) {
        const float mass = area[v] / h;
        const Vec3 animated_displacement = pose.animated[v] - motion.animated[v];
        out.push.push_back(mass * (displacement[v] / h + swing.damping * animated_displacement) +
                           out.resist[v] * acting.air_at(swing, Index(v)));
        if (!acting.push.empty()) out.push[v] += area[v] * acting.push[v];
        if (!acting.resist.empty()) {
            const Vec3& resist = acting.resist[v];
            out.resist[v] += glm::mat3(area[v] * (resist.x + resist.y * glm::length(motion.velocity[v])));
        }
        out.resist[v] = glm::mat3(mass * (1.0f / h + swing.damping)) + out.resist[v] / h;
    }
    return out;
}

// Takes one time step. motion: receives the motion at its end. Returns the speed that decides whether the
// cloth is at rest.
float take_step(const Frame& frame, const TimeStep& step, Motion& motion, std::vector<Plane>& planes,
                Result& out) {
    const auto& [pose, h] = step;
    const std::vector<Vec3> displacement = inertial_displacements(step, motion);
    std::vector<Vec3> x = first_guess(step, motion, displacement);
    look_for_contacts(frame.model, pose, x, out.state.contact_hint, planes);
    const Inertia inertia = inertia_of(frame, step, motion, displacement);
    for (int newton = 0; newton < frame.swing.newton_steps; ++newton)
        newton_step({frame.model, frame.settings, pose, planes, &inertia}, x, out.report);
    float fastest = 0.0f;
    for (size_t v = 0; v < x.size(); ++v) {
        const Vec3 velocity = (x[v] - motion.position[v]) / h;
        const Vec3 gained = (velocity - motion.velocity[v]) * (kTurning / h);
        fastest = std::max({fastest, glm::length(velocity), glm::length(gained)});
        out.report.moved = std::max(out.report.moved, h * glm::length(velocity));
        motion.velocity[v] = velocity;
    }
    out.report.steps += frame.swing.newton_steps;
    motion.position = std::move(x);
    motion.animated = pose.animated;
    return fastest;
}

// The animated positions at a fraction of the frame: a parabola through this pose and the two frames before.
// Linear interpolation would jerk the cloth at every frame, at 24 frames per second more than at 60.
std::vector<Vec3> animated_at(const Pose& pose, const Motion& was, float seconds, float fraction) {
    const float before = was.seconds > 0.0f ? was.seconds / seconds : 1.0f;
    std::vector<Vec3> out;
    for (size_t v = 0; v < was.animated.size(); ++v) {
        const Vec3 displacement = pose.animated[v] - was.animated[v];
        const Vec3 displacement_before = (was.animated[v] - was.animated_before[v]) / before;
        out.push_back(was.animated[v] + fraction * displacement +
                      fraction * (fraction - 1.0f) / (1.0f + before) * (displacement - displacement_before));
    }
    return out;
}

// The time steps of a frame. was: from carried(). Returns the motion at its end.
Motion step_through(const Frame& frame, const Motion& was, std::vector<Plane>& planes, Result& out) {
    const Swing& swing = frame.swing;
    const double wanted = std::ceil(double(swing.seconds) / double(swing.longest_step) - kStepSlack);
    const int steps = int(std::min(wanted, kMostSteps));
    const float h = swing.seconds / float(std::max(steps, 1));
    Motion motion = was;
    if (steps > 0) motion.fastest = 0.0f;
    Pose pose_between = steps > 1 ? frame.pose : Pose{};
    for (int i = 1; i <= steps; ++i) {
        const bool last = i == steps;
        const float fraction = float(i) / float(steps);
        if (!last)
            move_to(frame.model, frame.pose, animated_at(frame.pose, was, swing.seconds, fraction),
                    pose_between);
        motion.fastest = std::max(
            motion.fastest, take_step(frame, {last ? frame.pose : pose_between, h}, motion, planes, out));
    }
    return motion;
}

// ---------------------------------------------------------------- a frame
// The equilibrium of the pose, with zero velocity.
Result from_rest(Frame frame, bool has_bodies, std::vector<Index> body_hint) {
    const Pose& pose = frame.pose;
    Result out = solve_pose(frame.model, frame.settings, pose, has_bodies, std::move(body_hint), nullptr);
    Motion& motion = out.state.motion;
    motion.position = motion.animated = motion.animated_before = pose.animated;
    motion.velocity.assign(pose.animated.size(), Vec3(0.0f));
    motion.gravity = frame.settings.gravity;
    motion.wind = frame.swing.wind;
    motion.air = std::move(frame.acting.air);
    motion.push = std::move(frame.acting.push);
    for (size_t v = 0; v < pose.animated.size(); ++v)
        motion.position[v] += pose.frame[v].to_object(out.state.offset[v]);
    out.state.offset.clear();
    return out;
}

// Checks for one value per vertex, or none.
void check_vectors(const char* name, std::span<const Vec3> values, size_t vertices) {
    if (!values.empty()) expect_count(name, values.size(), vertices, "vertices");
    for (const Vec3& value : values) {
        for (int k = 0; k < 3; ++k) expect_within(name, value[k], -kFarthestCoordinate, kFarthestCoordinate);
    }
}

}  // namespace

void check(const Swing& swing, size_t vertices) {
    expect_within("seconds", swing.seconds, 0.0, 1e9);
    expect_within("longest_step", swing.longest_step, 1e-5, 1e3);
    expect_within("newton_steps", swing.newton_steps, 1, 1e6);
    expect_within("damping", swing.damping, 0.0, 1e6);
    expect_within("locomotion", swing.locomotion, 0.0, 1.0);
    expect_within("drag", swing.drag, 0.0, 1e9);
    expect_finite<Vec3>("wind", {&swing.wind, 1}, "value");
    const auto& [matrix, shift] = swing.placement;
    expect_finite<Vec3>("placement", std::array{matrix[0], matrix[1], matrix[2], shift}, "column");
    check_vectors("air", swing.air, vertices);
    check_vectors("push", swing.push, vertices);
    if (!swing.resist.empty()) expect_count("resist", swing.resist.size(), vertices, "vertices");
    for (const Vec2& resist : swing.resist) {
        expect_within("resist", resist.x, 0.0, kFarthestCoordinate);
        expect_within("resist", resist.y, 0.0, kFarthestCoordinate);
    }
}

State activated(State state) {
    state.moved = kFarthestCoordinate;        // without inertia
    state.motion.fastest = Motion{}.fastest;  // with inertia
    return state;
}

Result solve_swing(const Model& model, const Settings& settings, const Swing& swing, const Paint& paint,
                   std::span<const Vec3> positions, const PosedCollider* bodies, const State* before) {
    check(settings);
    check(swing, model.surface.welded_of.size());
    const SolveTeam team = team_for(model);
    if (!fits(model, before)) before = nullptr;
    std::vector<Index> body_hint = before ? before->body_hint : std::vector<Index>();
    const Pose pose = make_pose(model, settings, paint, positions, bodies, body_hint);
    Frame frame{model, settings, swing, pose, acting_on(model, swing)};
    if (!before) return from_rest(std::move(frame), bodies != nullptr, std::move(body_hint));
    Result out;
    out.state.body_hint = std::move(body_hint);
    out.state.contact_hint = before->contact_hint;
    const Motion was = carried(frame, before->motion);
    std::vector<Plane> planes(model.area.size());
    const bool held = holds(frame, was, *before);
    Motion motion = held ? was : step_through(frame, was, planes, out);
    look_for_contacts(model, pose, motion.position, out.state.contact_hint, planes);
    keep_pose(pose, held ? before : nullptr, out.state);
    motion.animated_before = was.animated;
    motion.seconds = swing.seconds;
    motion.gravity = settings.gravity;
    motion.wind = swing.wind;
    if (!held) {
        motion.air = std::move(frame.acting.air);
        motion.push = std::move(frame.acting.push);
    }
    out.state.motion = std::move(motion);
    std::vector<Vec3> x = out.state.motion.position;
    finish(model, settings, pose, planes, bodies != nullptr, x, out);
    return out;
}

}  // namespace rumple::base_cloth

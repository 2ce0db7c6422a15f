// SPDX-License-Identifier: GPL-3.0-or-later
// Minimises the energy of docs/base_cloth.md by Newton's method. Vertices and springs are computed four at a
// time and added up in their order, so that every sum has the same bits as one by one.
#include "surface/cloth/equilibrium.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/lanes.h"
#include "base/tolerances.h"
#include "surface/cloth/hessian.h"

namespace rumple::base_cloth {
namespace {

constexpr float kBeyondLimit = 10.0f;     // stiffness beyond the strain limit
constexpr float kRoomStiffening = 15.0f;  // of the pull back: factor at the edge of the room
constexpr float kContact = 2e4f;          // stiffness of the inner surface, 1/s^2
constexpr float kSlip = 1.0f / 6.0f;      // share of the room: from this distance on the whole friction acts
constexpr int kShortenings = 4;           // most shortenings of a step that is too long

using FourRows = std::array<Row, kLanes>;

std::span<Row, kLanes> four_of(std::vector<Row>& rows, size_t four) {
    return four_from(rows, four * kLanes);
}

// The pose for the computation, four vertices at a time. Rows end with at least one vertex without weight.
struct PackedPose {
    struct Plane {
        Vec3Lanes point, normal;

        Lanes height_of(const Vec3Lanes& p) const { return dot(p - point, normal); }
    };
    struct Vertices {
        Vec3Lanes animated, normal;
        Lanes area, follow, room, slide_share;
        Lanes grip;  // largest friction force, from the contact at the start of the Newton step
        Plane under_plane, ahead_plane;  // of the inner surface, and of a body in front

        // Force / depth that presses a vertex out of each surface.
        Lanes contact_stiffness() const { return area * most(all_lanes(kContact), follow); }
    };
    const Model& model;
    const Settings& settings;
    std::vector<Row> animated;
    std::vector<Vertices> vertices;
    std::span<const float> rest_length, compression_scale, smoothing;  // as in Pose
    struct Inertia {
        Row from, push;
        Matrix resist;
    };
    std::vector<Inertia> inertia;  // empty: none

    PackedPose(const NewtonProblem& problem, std::vector<Row>& x);

    std::vector<Row> rows() const { return std::vector<Row>(animated.size()); }
};

std::vector<Row> rows_with_a_spare(std::span<const Vec3> vectors) {
    std::vector<Row> rows = to_rows(vectors);
    rows.resize(in_fours(vectors.size() + 1));
    return rows;
}

PackedPose::PackedPose(const NewtonProblem& problem, std::vector<Row>& x)
    : model(problem.model),
      settings(problem.settings),
      animated(rows_with_a_spare(problem.pose.animated)),
      vertices(animated.size() / kLanes),
      rest_length(problem.pose.rest_length),
      compression_scale(problem.pose.compression_scale),
      smoothing(problem.pose.smoothing) {
    const Pose& pose = problem.pose;
    for (size_t v = 0; v < pose.animated.size(); ++v) {
        Vertices& four = vertices[v / kLanes];
        const int k = static_cast<int>(v % kLanes);
        four.animated.set(k, pose.animated[v]);
        four.normal.set(k, pose.normal[v]);
        four.area[k] = model.area[v];
        four.follow[k] = pose.follow[v];
        four.room[k] = pose.room[v];
        four.slide_share[k] = pose.slide_share[v];
        four.under_plane.point.set(k, problem.planes[v].point);
        four.under_plane.normal.set(k, problem.planes[v].normal);
        four.ahead_plane.point.set(k, pose.ahead[v].point);
        four.ahead_plane.normal.set(k, pose.ahead[v].normal);
    }
    for (size_t four = 0; four < vertices.size(); ++four) {
        const Lanes inward = -vertices[four].under_plane.height_of(columns(four_of(x, four)));
        vertices[four].grip = settings.friction * vertices[four].contact_stiffness() * most(inward, Lanes{});
    }
    if (!problem.inertia) return;
    inertia.resize(animated.size());
    for (size_t v = 0; v < pose.animated.size(); ++v) {
        const glm::mat3& resist = problem.inertia->resist[v];
        inertia[v] = {problem.inertia->from[v], problem.inertia->push[v], {resist[0], resist[1], resist[2]}};
    }
}

Vec3Lanes ends_apart(const Model::SpringFour& springs, const std::vector<Row>& x) {
    FourRows out;
    for (int k = 0; k < kLanes; ++k) out[k].xyz = x[springs.b[k]].xyz - x[springs.a[k]].xyz;
    return columns(out);
}

// At least the length of the shortest edge.
Lanes length_of(const Vec3Lanes& v) {
    return most(square_root(dot(v, v)), all_lanes(kShortestEdge));
}
Vec3Lanes direction_of(const Vec3Lanes& v) {
    const Lanes length = length_of(v);
    return {v.x / length, v.y / length, v.z / length};
}

void pull_together(const Model::SpringFour& springs, const Vec3Lanes& pull, std::vector<Row>& force) {
    FourRows rows;
    store_rows(pull, rows);
    for (int k = 0; k < kLanes; ++k) {
        force[springs.a[k]].xyz += rows[k].xyz;
        force[springs.b[k]].xyz -= rows[k].xyz;
    }
}

// Force along springs / weight (positive towards the other end), and its slope: figure 6 of the paper.
struct Tension {
    Lanes force;
    Lanes slope;
};
Tension tension(const Settings& settings, const LaneMask& diagonal, const Lanes& compression_scale,
                const Lanes& length, const Lanes& rest) {
    const Lanes zero{};
    const Lanes longer = length - rest;
    const Lanes k = diagonal ? all_lanes(settings.shear) : all_lanes(settings.stretch);
    const Lanes beyond = length - (1.0f + settings.strain_limit) * rest;
    const LaneMask within = beyond <= zero;
    const Lanes taut = k * longer;
    const Lanes very_taut = taut + (kBeyondLimit - 1.0f) * k * beyond;
    const Lanes folded = length - settings.compression_limit * rest;
    const LaneMask weak = folded >= zero;
    const Lanes k1 = settings.compression * compression_scale, k2 = settings.folded * compression_scale;
    const Lanes pushed = k1 * longer;
    const Lanes folding = pushed + (k2 - k1) * folded;
    const Lanes slope = weak ? k1 : k2;
    return {longer > zero ? (within ? taut : very_taut)
            : diagonal    ? zero
                          : (weak ? pushed : folding),
            longer > zero ? (within ? k : kBeyondLimit * k)
            : diagonal    ? zero
                          : slope};
}

// ---- forces on four vertices: terms of the energy in docs/base_cloth.md

using Vertices = PackedPose::Vertices;

// The pull back to the animated place. A displacement along the surface uses only a share s of the room:
// S = s I + (1 - s) n n^T, and S S = s^2 I + (1 - s^2) n n^T.
struct RoomPull {
    Lanes follow_stiffness, normal_stiffness;  // in all directions, and in addition along the normal
    Lanes height;                              // of the displacement, along the normal
    Vec3Lanes counted;                         // S S displacement
    Lanes room_used;                           // |S displacement|^2 / room^2
};
RoomPull room_pull(const Vertices& cloth, const Vec3Lanes& displacement) {
    const Lanes zero{}, s2 = cloth.slide_share * cloth.slide_share;
    RoomPull out;
    out.height = dot(cloth.normal, displacement);
    out.counted = s2 * displacement + (1.0f - s2) * out.height * cloth.normal;
    out.room_used = cloth.room > zero ? dot(out.counted, displacement) / (cloth.room * cloth.room) : zero;
    const Lanes wall = kRoomStiffening * out.room_used * out.room_used;
    out.follow_stiffness = cloth.area * cloth.follow * (1.0f + wall * s2);
    out.normal_stiffness = cloth.area * cloth.follow * wall * (1.0f - s2);
    return out;
}

// Pushes out of a plane. Above it there is no force.
struct Contact {
    Lanes stiffness;
    Lanes force;  // along the normal
};
Contact contact(const PackedPose::Plane& plane, const Vec3Lanes& at, const Lanes& stiffness) {
    const Lanes zero{}, depth = -plane.height_of(at);
    const Lanes acting = depth > zero ? stiffness : zero;
    return {acting, acting * depth};
}

// Acts against sliding along the inner surface away from the animated place: Coulomb's law, smooth for short
// distances (f_1 of M. Li et al., "Incremental Potential Contact", SIGGRAPH 2020).
struct FrictionPull {
    Lanes friction_stiffness;  // force / distance slid
    Vec3Lanes slid;
};
FrictionPull friction_pull(const Vertices& cloth, const Vec3Lanes& displacement) {
    const Vec3Lanes& normal = cloth.under_plane.normal;
    const Vec3Lanes slid = displacement - dot(normal, displacement) * normal;
    const Lanes slip = kSlip * cloth.room, distance = square_root(dot(slid, slid)), zero{};
    const Lanes share = distance < slip ? (2.0f - distance / slip) / slip : 1.0f / distance;
    return {cloth.grip > zero && slip > zero ? cloth.grip * share : zero, slid};
}

// Computes the diagonal blocks of the Hessian for these four vertices. Gravity has no part in them.
void store_blocks(const Vertices& cloth, const RoomPull& pull, const Contact& under, const Contact& ahead,
                  const Lanes& friction_stiffness, std::span<Matrix, kLanes> blocks) {
    const Lanes growth = 4.0f * cloth.area * cloth.follow * kRoomStiffening * pull.room_used;
    const Vec3Lanes wall =
        choose(pull.room_used > Lanes{}, square_root(growth) / cloth.room * pull.counted, {});
    FourRows normals, walls, under_normals, ahead_normals;
    store_rows(cloth.normal, normals);
    store_rows(wall, walls);
    store_rows(cloth.under_plane.normal, under_normals);
    store_rows(cloth.ahead_plane.normal, ahead_normals);
    for (int k = 0; k < kLanes; ++k) {
        Matrix block = scaled_identity(pull.follow_stiffness[k] + friction_stiffness[k]);
        add_outer_product(pull.normal_stiffness[k], normals[k], block);
        add_outer_product(1.0f, walls[k], block);
        add_outer_product(under.stiffness[k] - friction_stiffness[k], under_normals[k], block);
        add_outer_product(ahead.stiffness[k], ahead_normals[k], block);
        blocks[k] = block;
    }
}

void add_inertia(const PackedPose& pose, const std::vector<Row>& x, std::vector<Row>& out, Hessian* hessian) {
    for (size_t v = 0; v < pose.inertia.size(); ++v) {
        const auto& [from, push, resist] = pose.inertia[v];
        out[v].xyz += push.xyz - resist * Row(x[v].xyz - from.xyz);
        if (hessian) add(resist, hessian->diagonal[v]);
    }
}

// The forces at x, and also the Hessian if it is not nullptr.
void forces_at_vertices(const PackedPose& pose, std::vector<Row>& x, std::vector<Row>& out,
                        Hessian* hessian) {
    const Vec3Lanes gravity(pose.settings.gravity);
    for (size_t four = 0; four < pose.vertices.size(); ++four) {
        const Vertices& cloth = pose.vertices[four];
        const Vec3Lanes at = columns(four_of(x, four)), displacement = at - cloth.animated;
        const Lanes contact_stiffness = cloth.contact_stiffness();
        const RoomPull pull = room_pull(cloth, displacement);
        const Contact under = contact(cloth.under_plane, at, contact_stiffness);
        const Contact ahead = contact(cloth.ahead_plane, at, contact_stiffness);
        const auto [friction_stiffness, slid] = friction_pull(cloth, displacement);
        store_rows(cloth.area * gravity - pull.follow_stiffness * displacement +
                       under.force * cloth.under_plane.normal + ahead.force * cloth.ahead_plane.normal -
                       pull.normal_stiffness * pull.height * cloth.normal - friction_stiffness * slid,
                   four_of(out, four));
        if (hessian) {
            const std::span<Matrix, kLanes> blocks(&hessian->diagonal[four * kLanes], kLanes);
            store_blocks(cloth, pull, under, ahead, friction_stiffness, blocks);
        }
    }
    add_inertia(pose, x, out, hessian);
}

// ---- forces on vertices and springs

void forces(const PackedPose& pose, std::vector<Row>& x, std::vector<Row>& out, Hessian* hessian) {
    forces_at_vertices(pose, x, out, hessian);
    const Settings& settings = pose.settings;
    for (size_t s = 0; s < pose.model.spring_fours.size(); ++s) {
        const Model::SpringFour& springs = pose.model.spring_fours[s];
        const Vec3Lanes displacement = ends_apart(springs, x);
        const Lanes length = length_of(displacement);
        const Vec3Lanes n = direction_of(displacement);
        const Lanes compression_scale = load_lanes(&pose.compression_scale[s * kLanes]);
        const Tension t = tension(settings, springs.diagonal, compression_scale, length,
                                  load_lanes(&pose.rest_length[s * kLanes]));
        const Lanes smooth = springs.diagonal ? Lanes{} : load_lanes(&pose.smoothing[s * kLanes]);
        // The rotation of the spring away from its animated direction. It is computed from the difference, so
        // that it is exactly zero at rest.
        const Vec3Lanes animated = ends_apart(springs, pose.animated), aim = direction_of(animated);
        const Vec3Lanes moved = displacement - animated, turned = moved - dot(aim, moved) * aim;
        pull_together(springs, springs.weight * (t.force * n + smooth * turned), out);
        if (!hessian) continue;
        // An approximation with the animated direction, because the spring hardly ever turns far from it.
        const Lanes across = most(t.force / length, Lanes{}) + smooth;
        const Lanes along = springs.weight * (t.slope - across), wide = springs.weight * across;
        FourRows directions;
        store_rows(n, directions);
        const size_t count = std::min<size_t>(hessian->springs.size() - s * kLanes, kLanes);
        for (size_t k = 0; k < count; ++k)
            hessian->springs[s * kLanes + k] = {directions[k], along[int(k)], wide[int(k)]};
    }
}

}  // namespace

float newton_step(const NewtonProblem& problem, std::span<Vec3> x, Report& report) {
    std::vector<Row> at = rows_with_a_spare(x);
    const PackedPose pose(problem, at);
    std::vector<Row> force = pose.rows(), step = pose.rows(), tried = pose.rows(), there = pose.rows();
    Hessian hessian;
    hessian.springs.resize(problem.model.springs.size());
    hessian.diagonal.resize(at.size());
    forces(pose, at, force, &hessian);
    report.cg_iterations +=
        conjugate_gradients(problem.model, hessian, force, problem.settings.most_cg_iterations, step);
    const double slope = inner_product(force, step);
    float fraction = 1.0f;
    for (int i = 0; i < kShortenings; ++i) {
        for (size_t v = 0; v < at.size(); ++v) tried[v].xyz = at[v].xyz + fraction * step[v].xyz;
        forces(pose, tried, there, nullptr);
        const double slope_there = inner_product(there, step);
        if (slope_there >= -problem.overshoot * slope) break;
        fraction *= static_cast<float>(std::max(slope / (slope - slope_there), 0.1));
    }
    float farthest = 0.0f;
    for (size_t v = 0; v < x.size(); ++v) {
        x[v] = Row(at[v].xyz + fraction * step[v].xyz).vec();
        farthest = std::max(farthest, glm::length(step[v].vec()));
    }
    return farthest;
}

}  // namespace rumple::base_cloth

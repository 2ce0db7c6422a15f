// SPDX-License-Identifier: GPL-3.0-or-later
// The least energy of docs/base_cloth.md: Newton's method. Vertices and springs are computed four at a time
// and summed up in their order, so that every sum has the bits of one after the other.
#include "surface/cloth/equilibrium.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/lanes.h"
#include "base/tolerances.h"
#include "surface/cloth/hessian.h"

namespace rumple::base_cloth {
namespace {

constexpr float kBeyondLimit = 10.0f;  // stiffness beyond the strain limit
constexpr float kWall = 15.0f;         // how much the pull back grows towards the edge of the room
constexpr float kContact = 2e4f;       // stiffness of the inner surface, 1/s^2
constexpr float kSlip = 1.0f / 6.0f;   // of the room: what has slid farther is held by the whole friction
constexpr int kShortenings = 4;        // of a step that went too far

using FourRows = std::array<Row, kLanes>;

std::span<Row, kLanes> four_of(std::vector<Row>& rows, size_t four) {
    return four_from(rows, four * kLanes);
}

// A frame of the cloth as it is computed. Rows end with one vertex, or more, of no weight.
struct Frame {
    struct Plane {
        Vec3Lanes point, normal;

        Lanes height_of(const Vec3Lanes& p) const { return dot(p - point, normal); }
    };
    struct Vertices {
        Vec3Lanes animated, normal;
        Lanes area, follow, room, slide_share;
        Lanes grip;  // most force of friction: by the contact that the Newton step begins with
        Plane under, ahead;

        // How firmly each is pressed out of what it is in.
        Lanes firm() const { return area * most(all_lanes(kContact), follow); }
    };
    const Model& model;
    const Settings& settings;
    std::vector<Row> animated;
    std::vector<Vertices> vertices;
    std::span<const float> cut, firmness;  // as of Pose
    struct Inertia {
        Row from, push;
        Matrix resist;
    };
    std::vector<Inertia> inertia;  // empty: none

    Frame(const Cloth& cloth, std::vector<Row>& x);

    std::vector<Row> rows() const { return std::vector<Row>(animated.size()); }
};

std::vector<Row> rows_with_a_spare(std::span<const Vec3> vectors) {
    std::vector<Row> rows = to_rows(vectors);
    rows.resize(in_fours(vectors.size() + 1));
    return rows;
}

Frame::Frame(const Cloth& cloth, std::vector<Row>& x)
    : model(cloth.model),
      settings(cloth.settings),
      animated(rows_with_a_spare(cloth.pose.animated)),
      vertices(animated.size() / kLanes),
      cut(cloth.pose.cut),
      firmness(cloth.pose.firmness) {
    const Pose& pose = cloth.pose;
    for (size_t v = 0; v < pose.animated.size(); ++v) {
        Vertices& four = vertices[v / kLanes];
        const int k = static_cast<int>(v % kLanes);
        four.animated.set(k, pose.animated[v]);
        four.normal.set(k, pose.normal[v]);
        four.area[k] = model.area[v];
        four.follow[k] = pose.follow[v];
        four.room[k] = pose.room[v];
        four.slide_share[k] = pose.slide_share[v];
        four.under.point.set(k, cloth.planes[v].point);
        four.under.normal.set(k, cloth.planes[v].normal);
        four.ahead.point.set(k, pose.ahead[v].point);
        four.ahead.normal.set(k, pose.ahead[v].normal);
    }
    for (size_t four = 0; four < vertices.size(); ++four) {
        const Lanes inward = -vertices[four].under.height_of(columns(four_of(x, four)));
        vertices[four].grip = settings.friction * vertices[four].firm() * most(inward, Lanes{});
    }
    if (!cloth.inertia) return;
    inertia.resize(animated.size());
    for (size_t v = 0; v < pose.animated.size(); ++v) {
        const glm::mat3& resist = cloth.inertia->resist[v];
        inertia[v] = {cloth.inertia->from[v], cloth.inertia->push[v], {resist[0], resist[1], resist[2]}};
    }
}

Vec3Lanes ends_apart(const Model::SpringFour& springs, const std::vector<Row>& x) {
    FourRows out;
    for (int k = 0; k < kLanes; ++k) out[k].xyz = x[springs.b[k]].xyz - x[springs.a[k]].xyz;
    return columns(out);
}

// At least that of the shortest edge.
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

// Force along springs over their weight (towards the other end is positive), and its slope: figure 6 of the
// paper.
struct Tension {
    Lanes force;
    Lanes slope;
};
Tension tension(const Settings& settings, const LaneMask& diagonal, const Lanes& firmness,
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
    const Lanes k1 = settings.compression * firmness, k2 = settings.folded * firmness;
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

// Force of friction over the way slid: Coulomb's law, smooth where the way is short (f_1 of M. Li et al.,
// "Incremental Potential Contact", SIGGRAPH 2020).
Lanes friction(const Lanes& grip, const Lanes& slip, const Vec3Lanes& slid) {
    const Lanes way = square_root(dot(slid, slid)), zero{};
    const Lanes share = way < slip ? (2.0f - way / slip) / slip : 1.0f / way;
    return grip > zero && slip > zero ? grip * share : zero;
}

// The forces at x; the Hessian too, where one is asked for.
void forces_at_vertices(const Frame& frame, std::vector<Row>& x, std::vector<Row>& out, Hessian* hessian) {
    const Settings& settings = frame.settings;
    const Lanes zero{};
    const Vec3Lanes gravity(settings.gravity);
    for (size_t four = 0; four < frame.vertices.size(); ++four) {
        const Frame::Vertices& cloth = frame.vertices[four];
        const auto& [animated, normal, area, follow, room, slide_share, grip, under, before] = cloth;
        const Vec3Lanes at = columns(four_of(x, four)), away = at - animated;
        // Along the surface a way counts by a share s against the room: S = s I + (1 - s) n n^T, and S S is
        // s^2 I + (1 - s^2) n n^T.
        const Lanes s2 = slide_share * slide_share, height = dot(normal, away);
        const Vec3Lanes counted = s2 * away + (1.0f - s2) * height * normal;  // S S away
        const Lanes room_used = room > zero ? dot(counted, away) / (room * room) : zero;
        const Lanes wall_used = kWall * room_used * room_used;
        const Lanes back = area * follow * (1.0f + wall_used * s2);
        const Lanes off = area * follow * wall_used * (1.0f - s2);
        const Lanes firm = cloth.firm();
        const Lanes inward = -under.height_of(at), beyond = -before.height_of(at);
        const Lanes contact = inward > zero ? firm : zero, ahead = beyond > zero ? firm : zero;
        const Vec3Lanes slid = away - dot(under.normal, away) * under.normal;
        const Lanes rub = friction(grip, kSlip * room, slid);
        store_rows(area * gravity - back * away + contact * inward * under.normal +
                       ahead * beyond * before.normal - off * height * normal - rub * slid,
                   four_of(out, four));
        if (!hessian) continue;
        const Lanes growth = 4.0f * area * follow * kWall * room_used;
        const Vec3Lanes wall = choose(room_used > zero, square_root(growth) / room * counted, {});
        FourRows surface_normals, walls, normals, normals_ahead;
        store_rows(normal, surface_normals);
        store_rows(wall, walls);
        store_rows(under.normal, normals);
        store_rows(before.normal, normals_ahead);
        for (int k = 0; k < kLanes; ++k) {
            Matrix& block = hessian->diagonal[four * kLanes + k];
            block = scaled_identity(back[k] + rub[k]);
            add_outer_product(off[k], surface_normals[k], block);
            add_outer_product(1.0f, walls[k], block);
            add_outer_product(contact[k] - rub[k], normals[k], block);
            add_outer_product(ahead[k], normals_ahead[k], block);
        }
    }
    for (size_t v = 0; v < frame.inertia.size(); ++v) {
        const auto& [from, push, resist] = frame.inertia[v];
        out[v].xyz += push.xyz - resist * Row(x[v].xyz - from.xyz);
        if (hessian) add(resist, hessian->diagonal[v]);
    }
}

void forces(const Frame& frame, std::vector<Row>& x, std::vector<Row>& out, Hessian* hessian) {
    forces_at_vertices(frame, x, out, hessian);
    const Settings& settings = frame.settings;
    for (size_t s = 0; s < frame.model.spring_fours.size(); ++s) {
        const Model::SpringFour& springs = frame.model.spring_fours[s];
        const Vec3Lanes displacement = ends_apart(springs, x);
        const Lanes length = length_of(displacement);
        const Vec3Lanes n = direction_of(displacement);
        const Lanes firmness = load_lanes(&frame.firmness[s * kLanes]);
        const Tension t =
            tension(settings, springs.diagonal, firmness, length, load_lanes(&frame.cut[s * kLanes]));
        const Lanes smooth = springs.diagonal ? Lanes{} : settings.smoothing * firmness;
        // What turns it away from its animated direction. Of the difference, so that what is at rest has
        // none.
        const Vec3Lanes animated = ends_apart(springs, frame.animated), aim = direction_of(animated);
        const Vec3Lanes moved = displacement - animated, turned = moved - dot(aim, moved) * aim;
        pull_together(springs, springs.weight * (t.force * n + smooth * turned), out);
        if (!hessian) continue;
        // As if the spring had its animated direction: it hardly ever turns far from it.
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

float newton_step(const Cloth& cloth, std::span<Vec3> x, Report& report) {
    std::vector<Row> at = rows_with_a_spare(x);
    const Frame frame(cloth, at);
    std::vector<Row> force = frame.rows(), step = frame.rows(), tried = frame.rows(), there = frame.rows();
    Hessian hessian;
    hessian.springs.resize(cloth.model.springs.size());
    hessian.diagonal.resize(at.size());
    forces(frame, at, force, &hessian);
    report.cg_iterations +=
        conjugate_gradients(cloth.model, hessian, force, cloth.settings.most_cg_iterations, step);
    const double slope = inner_product(force, step);
    float fraction = 1.0f;
    for (int i = 0; i < kShortenings; ++i) {
        for (size_t v = 0; v < at.size(); ++v) tried[v].xyz = at[v].xyz + fraction * step[v].xyz;
        forces(frame, tried, there, nullptr);
        const double slope_there = inner_product(there, step);
        if (slope_there >= -cloth.overshoot * slope) break;
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

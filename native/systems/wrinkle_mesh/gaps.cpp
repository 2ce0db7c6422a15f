// SPDX-License-Identifier: GPL-3.0-or-later
// How far cloth is above what is worn under it.
#include <algorithm>

#include "base/expect.h"
#include "base/smooth_step.h"
#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {
namespace {

// Unit: thicknesses. If cloth is this far above the surface worn under it, all of its extra width is
// available for folds.
constexpr float kRoomToSpare = 3.0f;

// Largest rise of the extra width, as a share of the length, over one Settings::bend_radius. All of it beside
// cloth that lies on a body would stand out as a knob, as between the legs of trousers that fit the hips. By
// the eye, for fabrics from silk to leather.
constexpr float kSteepestSpare = 0.07f;

// Unit: fine edges. A body is searched within this distance around a vertex.
constexpr float kBodyReach = 2.0f;

// How far a vertex may move inwards over a body; `unknown` if the body gives no bound. A border of the body
// must stay below the cloth between its vertices. Within an edge of the border the bound is as over skin;
// farther away it falls at 45 degrees.
float gap_above(const BodyContact& body, float thickness, float edge, float unknown) {
    const float above = body.distance - thickness;
    if (!body.border) return glm::mix(unknown, above, body.weight);
    const float cone = std::min(above + std::max(body.beside - edge, 0.0f), unknown);
    return glm::mix(unknown, cone, smooth_step(-edge, -0.5f * edge, body.distance));
}

// The gap of a vertex: that of the base, or the gap over a body near it. Fills in its Pose::body and floor.
float find_gap(const Model& model, const Input& input, size_t v, float of_base, Pose& pose) {
    const SurfacePoint& place = model.attachments.places[v];
    const Index hint = input.bodies ? hint_at(model.base, place.triangle, input.body_hint) : kNone;
    if (hint == kNone) return of_base;
    const float off = input.thickness + input.inner;
    const float reach = kBodyReach * model.local_edge[v] + off;
    const BodyContact body =
        input.bodies->closest_around(pose.attachment[v], pose.normal[v], reach, hint,
                                     interpolate(model.base, place, model.base.positions_rest));
    pose.body[v] = body.triangle;
    if (body.triangle == kNone) return of_base;
    // The normal of the body replaces the cloth's own normal. Otherwise cloth that slides over a heel would
    // enter it.
    if (!body.border) pose.floor[v] = glm::normalize(glm::mix(pose.normal[v], body.normal, body.weight));
    return gap_above(body, off, model.local_edge[v], of_base);
}

// Share of the thickness: how much lower the shown surface may be between vertices and still be off a body.
constexpr float kMostSunk = 0.5f;

// If vertices are off a convex body, the surface between them may still enter it. On a body of radius R, the
// middle of the side between two vertices at an angle t is lower by R t^2 / 8, and the smooth surface is
// lower than its vertices by R t^2 / 6. The part of it above half of the thickness is added to the vertices'
// distance.
void lower_gaps_of_surface(const Model& model, float thickness, Pose& pose) {
    std::vector<float> sunk(pose.attachment.size(), 0.0f);
    for_each_pair(model.distance, [&](size_t, Index a, Index b) {
        if (pose.body[a] == kNone || pose.body[b] == kNone) return;
        const Vec3 side = pose.attachment[b] - pose.attachment[a];
        const float of_side = glm::dot(side, pose.floor[b] - pose.floor[a]) / 6.0f;
        for (const Index v : {a, b}) sunk[v] = std::max(sunk[v], of_side);
    });
    for_each_index(sunk.size(), kLeastSteps,
                   [&](size_t v) { pose.gap[v] -= std::max(sunk[v] - kMostSunk * thickness, 0.0f); });
}

// Least cosine between cloth and body. At a smaller one, a vertex does not move out any farther.
constexpr float kMostAslant = 0.5f;

// Moves attachments that are inside a body out of it. A gap is measured along the body's normal, but cloth
// may move out in another direction, and then it moves farther. This is not needed if the next layer searches
// again, or if the layer below was already put out of bodies.
void move_out(const Input& input, Pose& pose) {
    const bool only_look = input.bodies && input.shown && !input.looked_below;
    for_each_index(pose.attachment.size(), kLeastSteps, [&](size_t v) {
        const float gap = pose.gap[v];
        const float out = only_look ? std::max(glm::dot(pose.normal[v], pose.floor[v]), kMostAslant) : 1.0f;
        if (gap < 0.0f) pose.attachment[v] -= gap / out * pose.normal[v];
        pose.gap[v] = std::max(gap, 0.0f);
    });
}

// Lowers shares so that they rise by at most 1 over this length along the edges at rest.
void rise_over(const Surface& base, float length, std::span<float> share) {
    for (bool lowered = true; lowered;) {
        lowered = false;
        for (const Edge& edge : base.edges) {
            float& a = share[edge.a];
            float& b = share[edge.b];
            if (a == b) continue;
            const float rise =
                glm::distance(base.positions_rest[edge.a], base.positions_rest[edge.b]) / length;
            lowered = lowered || a > b + rise || b > a + rise;
            a = std::min(a, b + rise);
            b = std::min(b, a + rise);
        }
    }
}

}  // namespace

void find_gaps(const Model& model, const Input& input, Pose& pose) {
    if (input.gap.empty()) return;
    expect_count("gap", input.gap.size(), model.base.display.vertex_count, "values");
    if (input.bodies) {
        expect_count("body_hint", input.body_hint.size(), model.base.display.vertex_count, "values");
        pose.body.assign(pose.attachment.size(), kNone);
        pose.floor = pose.normal;
    }
    pose.gap.assign(pose.attachment.size(), 0.0f);
    const std::vector<float> of_base = gaps_at(model.base, model.attachments, input.gap);
    for_each_index(pose.attachment.size(), input.bodies ? kLeastSearches : kLeastSteps, [&](size_t v) {
        if (model.attachments.places[v].triangle != kNone)
            pose.gap[v] = find_gap(model, input, v, of_base[v], pose);
    });
    if (input.bodies && input.shown) lower_gaps_of_surface(model, input.thickness, pose);
    move_out(input, pose);
}

std::vector<float> share_to_spare(const Surface& base, const Input& input, float length) {
    if (!input.bodies || input.gap.empty()) return {};
    const float room = std::max(kRoomToSpare * input.thickness, kShortestEdge);
    std::vector<float> share(base.welded.vertex_count, 1.0f);
    for (size_t v = 0; v < input.gap.size(); ++v) {
        if (input.body_hint[v] == kNone) continue;
        float& of_welded = share[base.welded_of[v]];
        of_welded = std::min(of_welded, smooth_step(0.0f, room, input.gap[v]));
    }
    if (length > 0.0f) rise_over(base, length, share);
    std::vector<float> out(input.gap.size());
    for (size_t v = 0; v < out.size(); ++v) out[v] = share[base.welded_of[v]];
    return out;
}

float length_to_spare(std::span<const Settings> layers) {
    float excess = 0.0f;
    for (const Settings& of_layer : layers) excess = std::max(excess, of_layer.prestretch - 1.0f);
    return excess / kSteepestSpare * layers[0].bend_radius;
}

}  // namespace rumple::wrinkle_mesh

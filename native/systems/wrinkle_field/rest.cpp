// SPDX-License-Identifier: GPL-3.0-or-later
// An adaptive rest shape: compression relative to the reference triangles around a vertex. Not in the paper.
// The reference is chapter 4 of Gillette 2015 (surface/strain/adaptive_reference.h).
#include <cmath>

#include "base/expect.h"
#include "systems/wrinkle_field/wrinkle_field.h"

namespace rumple::wrinkle_field {
namespace {

// F^T F - E of a triangle relative to its reference, in its rest frame. The reference's own frame has u1
// along x. Rotated back by the rotation between rest and reference, it is the stretched rest frame.
Tensor2 strain(const FlatTriangle& rest, const FlatTriangle& reference, const FlatTriangle& now) {
    const Tensor2 c = metric(reference, now);
    const Vec2 turn(rotation(rest, reference));
    return rotated({c.xx - 1.0f, c.xy, c.yy - 1.0f}, {turn.x, -turn.y});
}

// The symmetric square root of C = E + strain, by the Cayley-Hamilton theorem.
Vec3 root(const Tensor2& strain) {
    const float xx = 1.0f + strain.xx, yy = 1.0f + strain.yy;
    const float det = std::sqrt(std::max(xx * yy - strain.xy * strain.xy, 0.0f));  // determinant of the root
    const float trace = std::sqrt(std::max(xx + yy + 2.0f * det, 0.0f));
    if (trace <= 0.0f) return Vec3(0.0f);
    return Vec3(xx + det, strain.xy, yy + det) / trace;
}

}  // namespace

std::vector<Vec3> reference_stretches(const Model& model, const ReferenceState& reference,
                                      std::span<const Vec3> positions) {
    if (reference.empty()) return {};
    return reference_stretches(model, reference, weld_pose(model, positions));
}

std::vector<Vec3> reference_stretches(const Model& model, const ReferenceState& reference, const Pose& at) {
    if (reference.empty()) return {};
    expect_count("state.reference", reference.reference.size(), model.triangles.rest.size(), "triangles");
    const FlatPose pose = flat_pose(model.triangles.net, at.positions);
    std::vector<Tensor2> strains;
    for (size_t t = 0; t < pose.shapes.size(); ++t)
        strains.push_back(strain(model.triangles.rest[t], reference.reference[t], pose.shapes[t]));
    const std::vector<Tensor2> mean = at_vertices(model.stretch, strains);
    std::vector<Vec3> stretches;
    for (size_t v = 0; v < mean.size(); ++v)
        stretches.push_back(root(rotated(mean[v], model.vertex_turn[v])));
    return stretches;
}

}  // namespace rumple::wrinkle_field

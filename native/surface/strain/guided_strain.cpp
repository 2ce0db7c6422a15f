// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/strain/guided_strain.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/errors.h"
#include "base/expect.h"
#include "base/formulas.h"
#include "base/tolerances.h"

namespace rumple {
namespace {

// Largest length of a direction. The excess over 1 allows for rounding.
constexpr float kLongest = 1.0f + 1e-4f;
// Limits of squared stretches. Beyond them the mesh has collapsed, and its strain is unknown.
constexpr float kLeastSquare = 0.01f, kMostSquare = 100.0f;
// Largest factor on a rest length.
constexpr float kMostScale = 3.0f;

// The inverse of a tensor in the plane of u and v.
Tensor3 inverse_in(const Tensor2& left, const Vec3& u, const Vec3& v) {
    const Principal p = principal(left);
    const auto square = [](float value) { return std::clamp(value, kLeastSquare, kMostSquare); };
    const Vec2 e = p.small_direction;
    Tensor3 out;
    out.add(1.0f / square(p.small), e.x * u + e.y * v);
    out.add(1.0f / square(p.large), e.x * v - e.y * u);
    return out;
}

}  // namespace

Tensor2 turned(const Tensor2& left, const Vec2& along) {
    const float weight = std::min(glm::length(along), 1.0f);
    if (!(weight > 0.0f) || !has_squares(left)) return left;
    const Principal p = principal(left);
    const Vec2 t = along / glm::length(along);
    const auto mix = [&](float as_is, float across, float with) {
        return as_is + weight * (p.small * across + p.large * with - as_is);
    };
    return {mix(left.xx, t.y * t.y, t.x * t.x), mix(left.xy, -t.x * t.y, t.x * t.y),
            mix(left.yy, t.x * t.x, t.y * t.y)};
}

void check_along(const Surface& surface, std::span<const Vec3> along) {
    expect_count("along", along.size(), surface.welded_of.size(), "vertices");
    expect_finite("along", along, "vertex");
    for (size_t v = 0; v < along.size(); ++v) {
        const float length = glm::length(along[v]);
        if (length <= kLongest) continue;
        throw InvalidInput("along: vertex " + std::to_string(v) + " has length " + std::to_string(length) +
                           ", expected at most 1");
    }
}

std::shared_ptr<const GuideLines> build_guide_lines(const Surface& surface, std::span<const Vec3> along) {
    check_along(surface, along);
    auto out = std::make_shared<GuideLines>();
    out->around = build_bent_lines(surface);
    const std::vector<Vec3> normals = vertex_normals(surface, surface.positions_rest);
    for (size_t w = 0; w < normals.size(); ++w) {
        const Vec3 tangent = formulas::any_tangent(normals[w]), asked = along[surface.representative[w]];
        out->along.emplace_back(glm::dot(tangent, asked), glm::dot(glm::cross(normals[w], tangent), asked));
    }
    return out;
}

float GuidedStrain::rest_scale(const Vec3& e) const {
    const float before = quadratic(as_is, e), after = quadratic(turned, e);
    if (before <= 0.0f || after <= 0.0f) return 1.0f;
    return std::clamp(std::sqrt(after / before), 1.0f / kMostScale, kMostScale);
}

std::vector<GuidedStrain> guided_strain(const GuideLines& guide, std::span<const Vec3> positions) {
    std::vector<GuidedStrain> out(guide.along.size());
    for (size_t w = 0; w < out.size(); ++w) {
        const auto [x, y] = first_derivatives(guide.around, positions, w);
        const Vec3 normal = glm::cross(x, y);
        const float area = glm::length(normal), length = glm::length(x);
        if (!std::isfinite(area) || area <= kShortestEdge || length <= kShortestEdge) continue;
        const Vec3 u = x / length, v = glm::cross(normal / area, u);
        // F in the plane of u and v: columns (length, 0) and b.
        const Vec2 b(glm::dot(y, u), glm::dot(y, v));
        const Tensor2 left{length * length + b.x * b.x, b.x * b.y, b.y * b.y};
        if (!has_squares(left)) continue;
        out[w].as_is = out[w].turned = inverse_in(left, u, v);
        const Vec2 asked = guide.along[w];
        const float weight = std::min(glm::length(asked), 1.0f);
        const Vec2 along = asked.x * Vec2(length, 0.0f) + asked.y * b;
        const float stretched = glm::length(along);
        if (weight <= 0.0f || stretched <= kShortestEdge) continue;
        const Vec2 line = along / stretched;
        out[w].turned = inverse_in(turned(left, weight * line), u, v);
        out[w].weight = weight;
        out[w].place.all.add(weight, u);
        out[w].place.all.add(weight, v);
        out[w].place.without_place.add(weight, line.x * u + line.y * v);
    }
    return out;
}

SpareCloth spared_along(const SpareCloth& spare, const GuidedStrain& guided) {
    if (guided.weight <= 0.0f) return spare;
    const Vec3& all = spare.all.diagonal;
    return (1.0f - guided.weight) * spare + 0.5f * (all.x + all.y + all.z) * guided.place;
}

}  // namespace rumple

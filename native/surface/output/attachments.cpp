// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/output/attachments.h"

#include <algorithm>

#include "base/formulas.h"
#include "base/solve_team.h"

namespace rumple {

Vec3 pn_triangle(const Vec3 p[3], const Vec3 n[3], float b0, float b1) {
    return formulas::pn_point(p[0], p[1], p[2], n[0], n[1], n[2], b0, b1);
}

void attach(const Surface& surface, const Attachments& attachments, std::span<const Vec3> positions,
            std::span<const Vec3> normals, std::span<Vec3> out) {
    const bool on_limit = attachments.kind == AttachmentKind::kLimit;
    const std::vector<Row> rows = to_rows(on_limit ? positions : std::span<const Vec3>());
    for_each_index(out.size(), kLeastSteps, [&](size_t i) {
        const SurfacePoint& place = attachments.places[i];
        if (place.triangle == kNone) {
            out[i] = Vec3(0.0f);
        } else if (attachments.kind == AttachmentKind::kLinear) {
            out[i] = interpolate(surface, place, positions);
        } else if (attachments.kind == AttachmentKind::kPnTriangle) {
            Vec3 p[3], n[3];
            const std::array<Index, 3> v = welded_vertices(surface, place.triangle);
            for (int k = 0; k < 3; ++k) {
                p[k] = positions[v[k]];
                n[k] = normals[v[k]];
            }
            out[i] = pn_triangle(p, n, place.b0, place.b1);
        } else {
            out[i] = Row(weighted_sum(attachments.limit, static_cast<Index>(i), rows)).vec();
        }
    });
}

std::vector<float> gaps_at(const Surface& surface, const Attachments& attachments,
                           std::span<const float> gap) {
    std::vector<float> out(attachments.places.size(), 0.0f);
    if (attachments.kind == AttachmentKind::kLimit) {
        std::vector<float> welded;
        for (const Index v : surface.representative) welded.push_back(gap[v]);
        apply<float>(attachments.limit, welded, out);
        for (float& g : out) g = std::max(g, 0.0f);
        return out;
    }
    for (size_t v = 0; v < out.size(); ++v) {
        const SurfacePoint& place = attachments.places[v];
        if (place.triangle == kNone) continue;
        const std::array<Index, 3> corners = display_vertices(surface, place.triangle);
        out[v] = place.interpolate([&](int k) { return gap[corners[k]]; });
    }
    return out;
}

Index hint_at(const Surface& surface, Index triangle, std::span<const Index> hints) {
    const auto [a, b, c] = display_vertices(surface, triangle);
    return std::max({hints[a], hints[b], hints[c]});
}

}  // namespace rumple

// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/expect.h"
#include "surface/mesh/border_rings.h"
#include "systems/wrinkle_paths/context.h"

namespace rumple::wrinkle_paths {
namespace {

// 4 sqrt(3) area / the sum of squared edges: 1 for an equilateral triangle.
float quality_of(const FlatTriangle& t) {
    if (!t.has_area()) return 0.0f;
    const Vec2 u1(t.x1, 0.0f), u2(t.x2, t.y2);
    const float squares = glm::dot(u1, u1) + glm::dot(u2, u2) + glm::dot(u2 - u1, u2 - u1);
    return 4.0f * std::sqrt(3.0f) * t.area() / squares;
}

void sort_by_triangle(Model& model) {
    const std::vector<SurfacePoint>& places = model.attachments.places;
    model.fine_start.assign(model.triangles.rest.size() + 1, 0);
    for (const SurfacePoint& place : places) ++model.fine_start[place.triangle + 1];
    std::partial_sum(model.fine_start.begin(), model.fine_start.end(), model.fine_start.begin());
    model.fine_vertex.resize(places.size());
    std::vector<Index> end = model.fine_start;
    for (size_t v = 0; v < places.size(); ++v) model.fine_vertex[end[places[v].triangle]++] = Index(v);
}

// The rings of the welded vertices from the border, along edges of triangles.
std::vector<Index> rings_over(const Surface& surface, const TriangleNet& net) {
    std::vector<std::array<Index, 2>> edges;
    edges.reserve(net.vertex.size());
    for (Index h = 0; h < Index(net.vertex.size()); ++h)
        edges.push_back({net.vertex[h], net.vertex[next_in_triangle(h)]});
    return border_rings(edges, surface.boundary_vertex);
}

}  // namespace

void check(const Settings& s) {
    constexpr double kMost = 1e6;
    check_reference(s.rest);
    expect_within("smoothing", s.smoothing, 0.0, 10.0);
    expect_above("threshold", s.threshold, 1.0, kMost);
    expect_within("reach", s.reach, 0.0, 1.0);
    expect_above("width", s.width, 0.0, kMost);
    expect_above("spacing", s.spacing, 0.0, kMost);
    expect_within("alignment", s.alignment, 0.0, kMost);
    expect_within("growth_limit", s.growth_limit, 0.0, kMost);
    expect_within("fade", s.fade, 0.0, kMost);
    expect_within("bend_radius", s.bend_radius, 0.0, kFarthestCoordinate);
    expect_within("hem_rings", s.hem_rings, 0.0, kMost);
    expect_within("height", s.height, 0.0, kMost);
    expect_within("threads", s.threads, 0.0, 1024.0);
}

std::shared_ptr<const Model> build(Surface base, const FineSource& source, AttachmentKind attachment) {
    auto model = std::make_shared<Model>();
    model->base = std::move(base);
    model->triangles = build_reference(model->base);
    for (const FlatTriangle& t : model->triangles.rest) model->quality.push_back(quality_of(t));
    model->border_ring = rings_over(model->base, model->triangles.net);
    const FineMesh fine = refine(model->base, source);
    model->attachments = attach_refined(model->base, source, fine, attachment);
    if (attachment == AttachmentKind::kLimit) model->vertex_limit = limit_of_all_vertices(model->base);
    model->positions_rest = attached_at_rest(model->base, model->attachments);
    sort_by_triangle(*model);
    model->stretch = build_stretch(model->base);
    model->bent_lines = build_bent_lines(model->base);
    model->shown = show_fine(model->base, model->base, fine, 0, model->positions_rest);
    return model;
}

}  // namespace rumple::wrinkle_paths

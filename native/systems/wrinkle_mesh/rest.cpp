// SPDX-License-Identifier: GPL-3.0-or-later
// A rest shape that adapts. The rest length of every pair comes from the reference triangles in which it
// lies. Not in the paper; the reference is chapter 4 of Gillette 2015 (surface/strain/adaptive_reference.h).
#include <algorithm>
#include <cmath>

#include "base/errors.h"
#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {
namespace {

// Unit: none (barycentric weight). A place that is closer to an edge of its triangle lies on the edge.
constexpr float kOnEdge = 1e-4f;

// The triangles of a place: one inside, two on an edge, all around a vertex. Ascending.
class TrianglesAt {
  public:
    TrianglesAt(const TriangleNet& net, Index vertices) : net_(net), around_(size_t(vertices)) {
        for (Index h = 0; h < Index(net.vertex.size()); ++h) around_[net.vertex[h]].push_back(triangle_of(h));
    }

    std::vector<Index> operator()(const SurfacePoint& place) const {
        const std::array<float, 3> weight = place.weights();
        std::vector<Index> found{place.triangle};
        for (Index k = 0; k < 3; ++k) {
            const Index half_edge = 3 * place.triangle + k;
            if (weight[k] >= 1.0f - 2.0f * kOnEdge) return around_[net_.vertex[half_edge]];
            const Index across = net_.twin[next_in_triangle(half_edge)];  // of the edge opposite corner k
            if (weight[k] <= kOnEdge && across != kNone) found.push_back(triangle_of(across));
        }
        std::sort(found.begin(), found.end());
        return found;
    }

  private:
    const TriangleNet& net_;
    std::vector<std::vector<Index>> around_;
};

bool are_neighbours(const TriangleNet& net, Index t, Index other) {
    for (Index k = 0; k < 3; ++k) {
        const Index twin = net.twin[3 * t + k];
        if (twin != kNone && triangle_of(twin) == other) return true;
    }
    return false;
}

// The triangles that contain both ends: one, or two if the pair lies along their edge. Otherwise two
// neighbours between which it crosses. Otherwise, for a longer pair, the triangles of its ends.
std::array<Index, 2> triangles_of_pair(const TriangleNet& net, const std::vector<Index>& at_a,
                                       const std::vector<Index>& at_b, std::array<Index, 2> bound) {
    std::vector<Index> both;
    std::set_intersection(at_a.begin(), at_a.end(), at_b.begin(), at_b.end(), std::back_inserter(both));
    if (!both.empty()) return {both.front(), both.back()};
    for (const Index t : at_a) {
        for (const Index other : at_b) {
            if (are_neighbours(net, t, other)) return {t, other};
        }
    }
    return bound;
}

// |F e|^2 from F^T F.
float square_of(const Tensor2& metric, const Vec2& e) {
    return metric.xx * e.x * e.x + 2.0f * metric.xy * e.x * e.y + metric.yy * e.y * e.y;
}

// F^T F of all triangles relative to their shape at rest.
std::vector<Tensor2> metrics_of(const Model& model, const std::vector<FlatTriangle>& shapes) {
    std::vector<Tensor2> metrics;
    for (size_t t = 0; t < shapes.size(); ++t)
        metrics.push_back(metric(model.adaptive->triangles.rest[t], shapes[t]));
    return metrics;
}

// Length of every pair in `some` shapes of the triangles / its length in others.
std::vector<float> longer(const Model& model, const std::vector<Tensor2>& some,
                          const std::vector<Tensor2>& others) {
    std::vector<float> out;
    for (const Adaptive::Place& place : model.adaptive->pairs) {
        const auto in = [&](int k) {
            const Index t = place.triangle[k];
            const float length = square_of(some[t], place.along[k]);
            const float other = square_of(others[t], place.along[k]);
            return length > 0.0f && other > 0.0f ? std::sqrt(length / other)
                                                 : 1.0f;  // 0: across the triangle
        };
        out.push_back(0.5f * (in(0) + in(1)));
    }
    return out;
}

}  // namespace

Adaptive place_pairs(const Model& model) {
    Adaptive out{build_reference(model.base), {}};
    const TrianglesAt triangles_at(out.triangles.net, model.base.welded.vertex_count);
    const std::vector<SurfacePoint>& places = model.attachments.places;
    std::vector<std::vector<Index>> at;
    at.reserve(places.size());
    for (const SurfacePoint& place : places) at.push_back(triangles_at(place));
    const std::vector<SurfaceFrame> frames = triangle_frames(model.base, model.base.positions_rest);
    for (const Pairs* pairs : {&model.distance, &model.bending}) {
        for (size_t i = 0; i < pairs->size(); ++i) {
            const Index a = pairs->a[i], b = pairs->b[i];
            Adaptive::Place place;
            place.triangle =
                triangles_of_pair(out.triangles.net, at[a], at[b], {places[a].triangle, places[b].triangle});
            const Vec3 displacement = model.positions_rest[b] - model.positions_rest[a];
            for (int k = 0; k < 2; ++k)
                place.along[k] = Vec2(frames[place.triangle[k]].to_local(displacement));
            out.pairs.push_back(place);
        }
    }
    return out;
}

ReferenceState adapt_rest(const Model& model, const Settings& settings, const Input& input, const Pose& pose,
                          const State* before) {
    if (settings.rest.reference == Reference::kStaticRest) return {};
    if (!model.adaptive) throw InvalidInput("reference: the model was built for a rest shape that stays");
    return adapt(model.base, model.adaptive->triangles, settings.rest, input.frame_time, pose.base,
                 before ? before->reference : ReferenceState{});
}

namespace {

std::vector<float> scales_of_reference(const Model& model, const Settings& settings,
                                       const ReferenceState& reference, const Pose& pose,
                                       std::span<const float> lengths) {
    if (reference.empty() || !model.adaptive) return {};
    const std::vector<FlatTriangle>& rest = model.adaptive->triangles.rest;
    if (settings.rest.reference != Reference::kFirstFrame)
        return longer(model, metrics_of(model, reference.reference), metrics_of(model, rest));
    // A triangle without area in either shape counts as unchanged.
    std::vector<FlatTriangle> then = reference.reference,
                              now = flat_pose(model.adaptive->triangles.net, pose.base).shapes;
    for (size_t t = 0; t < now.size(); ++t) {
        if (!then[t].has_area() || !now[t].has_area()) then[t] = now[t] = rest[t];
    }
    std::vector<float> scales = longer(model, metrics_of(model, then), metrics_of(model, now));
    const auto to_rest = [&](const Pairs& pairs, size_t first) {
        for (size_t i = 0; i < pairs.size(); ++i)
            scales[first + i] *= lengths[first + i] / std::max(pairs.rest[i], kShortestEdge);
    };
    to_rest(model.distance, 0);
    to_rest(model.bending, model.distance.size());
    return scales;
}

// Scales pairs by their vectors without folds, for the painted directions.
void scale_by_guides(const Model& model, const Pose& pose, std::vector<float>& scales) {
    if (pose.guided.empty()) return;
    const std::vector<Vec3>& at = pose.unwrinkled.empty() ? pose.attachment : pose.unwrinkled;
    if (scales.empty()) scales.assign(model.distance.size() + model.bending.size(), 1.0f);
    size_t number = 0;
    for (const Pairs* pairs : {&model.distance, &model.bending}) {
        for (size_t i = 0; i < pairs->size(); ++i) {
            const Index a = pairs->a[i], b = pairs->b[i];
            scales[number++] *= (pose.guided[a] + pose.guided[b]).rest_scale(at[b] - at[a]);
        }
    }
}

}  // namespace

std::vector<float> rest_scales(const Model& model, const Settings& settings, const ReferenceState& reference,
                               const Pose& pose, std::span<const float> lengths) {
    std::vector<float> scales = scales_of_reference(model, settings, reference, pose, lengths);
    scale_by_guides(model, pose, scales);
    return scales;
}

}  // namespace rumple::wrinkle_mesh

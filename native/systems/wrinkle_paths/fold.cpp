// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_paths/fold.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "base/smooth_step.h"
#include "base/tolerances.h"
#include "base/unit_vector.h"
#include "systems/wrinkle_paths/lifecycle.h"

namespace rumple::wrinkle_paths {
namespace {

// Number of pieces of a smoothed segment per width L_min, and its limit.
constexpr float kPiecesPerWidth = 2.0f;
constexpr int kMostPieces = 16;

// Standard deviation of the Gaussian that smooths a path / L_min.
constexpr float kStiffness = 1.0f;

// Length over which the ends of a fold taper / full width. A short fold tapers over half of its length.
constexpr float kTaper = 2.0f;

// The compression is averaged over this distance to both sides / full width.
constexpr float kBlur = 0.75f;

using formulas::FoldEnd;

// Arc lengths of points from the first one.
std::vector<float> lengths_along(const std::vector<FoldEnd>& ends) {
    std::vector<float> arc_length{0.0f};
    for (size_t i = 0; i + 1 < ends.size(); ++i)
        arc_length.push_back(arc_length.back() + glm::distance(ends[i].at, ends[i + 1].at));
    return arc_length;
}

// An unsmoothed point of a path, and the normal of the triangle after it.
struct RawPoint {
    Vec3 at, normal;
};

// The Gaussian mean of a line around its point i, over arc length; the ends stay. Only the tangential part is
// used. Around a bend the mean is beside the surface, so a fold there would be too low.
Vec3 smoothed(const std::vector<RawPoint>& points, const std::vector<float>& arc_length, size_t i,
              float most) {
    const Vec3& at = points[i].at;
    const float sigma = std::min(most, 0.5f * std::min(arc_length[i], arc_length.back() - arc_length[i]));
    if (sigma <= kShortestEdge) return at;
    Vec3 sum(0.0f), normals(0.0f);
    float weights = 0.0f;
    const auto add = [&](size_t j) {
        const float x = (arc_length[j] - arc_length[i]) / sigma;
        const float span = arc_length[std::min(j + 1, arc_length.size() - 1)] - arc_length[j > 0 ? j - 1 : 0];
        const float weight = elementary::exp(-0.5f * x * x) * span;
        sum += weight * points[j].at;
        normals += weight * points[j].normal;
        weights += weight;
    };
    for (size_t j = i; j < arc_length.size() && arc_length[j] - arc_length[i] <= 3.0f * sigma; ++j) add(j);
    for (size_t j = i; j-- > 0 && arc_length[i] - arc_length[j] <= 3.0f * sigma;) add(j);
    const Vec3 shift = sum / weights - at, normal = unit_or_zero(normals, kShortestEdge);
    return at + shift - glm::dot(shift, normal) * normal;
}

// Section 6.2: smooths a path, because a fold cannot bend within its own width.
void smooth(const FoldContext& context, const Settings& settings, const Path& path, Fold& fold) {
    const std::vector<Vec3> points = positions(context, path.points);
    std::vector<RawPoint> raw;
    for (size_t i = 0; i + 1 < points.size(); ++i) {
        const float size = glm::distance(points[i], points[i + 1]);
        const float wanted = std::ceil(kPiecesPerWidth * size / settings.width);
        const int pieces = wanted >= 1.0f ? int(std::min(wanted, float(kMostPieces))) : 1;
        const Vec3& normal = context.pose.frames[segment_triangle(context.model, path.points, i)].normal;
        fold.first.push_back(static_cast<Index>(raw.size()));
        for (int k = 0; k < pieces; ++k)
            raw.push_back({glm::mix(points[i], points[i + 1], float(k) / float(pieces)), normal});
    }
    fold.first.push_back(static_cast<Index>(raw.size()));
    raw.push_back({points.back(), Vec3(0.0f)});
    for (const RawPoint& point : raw) fold.ends.push_back({point.at, 0.0f, {}, 0.0f});
    const std::vector<float> arc_length = lengths_along(fold.ends);
    const float most = kStiffness * settings.width;
    for (size_t i = 1; i + 1 < raw.size(); ++i) fold.ends[i].at = smoothed(raw, arc_length, i, most);
}

float signed_side(Direction direction, Index id) {
    const bool inward = direction == Direction::kInward || (direction == Direction::kBoth && id % 2 == 1);
    return inward ? -1.0f : 1.0f;
}

// The share of the compression that becomes a fold: 0 at the compression down to which paths grow, 1 from tau
// on. The cloth absorbs the rest in its plane, as everywhere below tau without a fold.
float folded_share(const Settings& settings, float compression) {
    const float least = reach_threshold(settings);
    return smooth_step(0.0f, 1.0f, (compression - least) / std::max(settings.threshold - least, 1e-6f));
}

// A value of the triangles as a function of arc length along a path. It has a step at every edge. Its mean
// over an interval is continuous.
class AlongPath {
  public:
    // value_of: the value of a triangle.
    template <typename Value>
    AlongPath(const FoldContext& context, const Path& path, const Fold& fold,
              const std::vector<float>& arc_length, Value&& value_of) {
        for (size_t i = 0; i + 1 < path.points.size(); ++i)
            add(arc_length[fold.first[i + 1]], value_of(segment_triangle(context.model, path.points, i)));
    }
    float mean(float arc_length, float reach) const {
        const float from = std::max(arc_length - reach, 0.0f), to = std::min(arc_length + reach, end_.back());
        return to > from ? (sum(to) - sum(from)) / (to - from) : value_.back();
    }

  private:
    void add(float end, float value) {
        sum_.push_back(sum_.back() + value * (end - end_.back()));
        end_.push_back(end);
        value_.push_back(value);
    }
    float sum(float arc_length) const {  // integral from the start
        const auto above = std::upper_bound(end_.begin() + 1, end_.end() - 1, arc_length);
        const size_t i = size_t(above - end_.begin()) - 1;
        return sum_[i] + value_[i] * (arc_length - end_[i]);
    }

    std::vector<float> end_{0.0f}, sum_{0.0f}, value_;
};

// Section 6.1: a fold is L_max wide and flat at its ends, and as narrow as the compression requires between
// them. Below tau its height decreases, to zero at the compression down to which paths grow.
void shape(const FoldContext& context, const Settings& settings, const Path& path, Fold& fold) {
    std::vector<FoldEnd>& ends = fold.ends;
    const std::vector<float> arc_length = lengths_along(ends);
    const float most = kMostRatio * settings.width;  // s = L_max, if no smaller width is painted
    const float taper = std::max(std::min(0.5f * arc_length.back(), kTaper * most), kShortestEdge);
    const float rise =
        settings.height * smooth_step(0.0f, 1.0f, path.fade) * signed_side(settings.direction, path.id);
    const AlongPath compressions(context, path, fold, arc_length, [&](Index t) {
        return std::min(weighted_compression(context, t), kMostRatio);
    });
    const AlongPath widths(context, path, fold, arc_length, [&](Index t) { return context.width(t); });
    for (size_t i = 0; i < ends.size(); ++i) {
        FoldEnd& end = ends[i];
        const float compression = compressions.mean(arc_length[i], kBlur * most);
        const float widest = context.widths.empty() ? most : most * widths.mean(arc_length[i], kBlur * most);
        const float from_end = std::min(arc_length[i], arc_length.back() - arc_length[i]);
        const float middle = smooth_step(0.0f, taper, from_end);
        end.width = glm::mix(widest, widest / std::max(compression, 1.0f), middle);
        end.height = rise * folded_share(settings, compression) * end.width *
                     height_table(settings.profile).height_over_width(widest / end.width);
        const Vec3 before = i > 0 ? unit_or_zero(end.at - ends[i - 1].at, kShortestEdge) : Vec3(0.0f);
        const Vec3 after =
            i + 1 < ends.size() ? unit_or_zero(ends[i + 1].at - end.at, kShortestEdge) : Vec3(0.0f);
        end.along = unit_or_zero(before + after, kShortestEdge);
    }
}

}  // namespace

Fold make_fold(const FoldContext& context, const Settings& settings, const Path& path) {
    Fold fold;
    smooth(context, settings, path, fold);
    shape(context, settings, path, fold);
    return fold;
}

}  // namespace rumple::wrinkle_paths

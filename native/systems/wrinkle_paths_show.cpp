// SPDX-License-Identifier: GPL-3.0-or-later
// Chapters 6 to 8 of Gillette 2015: the shape of the folds, and whom they reach.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/expect.h"
#include "base/tolerances.h"
#include "systems/wrinkle_paths_life.h"

namespace rumple::wrinkle_paths {
namespace {

// Pieces that a smoothed segment is cut into, to the width L_min, and at most.
constexpr float kPiecesPerWidth = 2.0f;
constexpr int kMostPieces = 16;

// Of the Gaussian that smooths a path, in L_min.
constexpr float kStiffness = 1.0f;

// The ends of a fold taper over so many full widths, or over half of it where it is shorter.
constexpr float kTaper = 2.0f;

// A fold's compression is its mean over so many full widths to both sides.
constexpr float kBlur = 0.75f;

// A bound is so much wider than what it is computed from.
constexpr float kRounding = 1.0f + 1e-5f;

using formulas::FoldEnd;
using formulas::FoldHeight;

// A path smoothed (section 6.2) and cut into pieces.
struct Fold {
    std::vector<FoldEnd> ends;  // of the pieces
    std::vector<Index> first;   // segments + 1, into pieces
};

Vec3 unit(const Vec3& v) {
    const float size = glm::length(v);
    return size > kShortestEdge ? v / size : Vec3(0.0f);
}

// Lengths along a line of points from its first.
std::vector<float> lengths_along(const std::vector<FoldEnd>& ends) {
    std::vector<float> way{0.0f};
    for (size_t i = 0; i + 1 < ends.size(); ++i)
        way.push_back(way.back() + glm::distance(ends[i].at, ends[i + 1].at));
    return way;
}

// The mean of a line around its point i, by a Gaussian of its length; nothing at the ends.
Vec3 smoothed(const std::vector<FoldEnd>& ends, const std::vector<float>& way, size_t i, float most) {
    const float sigma = std::min(most, 0.5f * std::min(way[i], way.back() - way[i]));
    if (sigma <= kShortestEdge) return ends[i].at;
    Vec3 sum(0.0f);
    float weights = 0.0f;
    const auto add = [&](size_t j) {
        const float x = (way[j] - way[i]) / sigma;
        const float span = way[std::min(j + 1, way.size() - 1)] - way[j > 0 ? j - 1 : 0];
        const float weight = std::exp(-0.5f * x * x) * span;
        sum += weight * ends[j].at;
        weights += weight;
    };
    for (size_t j = i; j < way.size() && way[j] - way[i] <= 3.0f * sigma; ++j) add(j);
    for (size_t j = i; j-- > 0 && way[i] - way[j] <= 3.0f * sigma;) add(j);
    return sum / weights;
}

// Section 6.2: a fold cannot bend within its own width.
void smooth(const Settings& settings, const std::vector<Vec3>& points, Fold& fold) {
    std::vector<FoldEnd> raw;
    for (size_t i = 0; i + 1 < points.size(); ++i) {
        const float size = glm::distance(points[i], points[i + 1]);
        const int pieces =
            std::clamp(int(std::ceil(kPiecesPerWidth * size / settings.width)), 1, kMostPieces);
        fold.first.push_back(static_cast<Index>(raw.size()));
        for (int k = 0; k < pieces; ++k)
            raw.push_back({glm::mix(points[i], points[i + 1], float(k) / float(pieces)), 0.0f, {}, 0.0f});
    }
    fold.first.push_back(static_cast<Index>(raw.size()));
    raw.push_back({points.back(), 0.0f, {}, 0.0f});
    fold.ends = raw;
    const std::vector<float> way = lengths_along(raw);
    const float most = kStiffness * settings.width;
    for (size_t i = 1; i + 1 < raw.size(); ++i) fold.ends[i].at = smoothed(raw, way, i, most);
}

float signed_side(Direction direction, Index id) {
    const bool inward = direction == Direction::kInward || (direction == Direction::kBoth && id % 2 == 1);
    return inward ? -1.0f : 1.0f;
}

float ease(float x) {
    x = std::clamp(x, 0.0f, 1.0f);
    return x * x * (3.0f - 2.0f * x);
}

// Of the compression, what the fold takes up: nothing at what paths reach to, all from tau on. The rest the
// cloth takes up in its plane, as it does below tau where there is no fold.
float folded_share(const Settings& settings, float compression) {
    const float least = reach_threshold(settings);
    return ease((compression - least) / std::max(settings.threshold - least, 1e-6f));
}

// The compression of the triangles that a path runs through, at `way` from its start. It has a step at every
// edge; its mean over a stretch of the path has none.
class AlongPath {
  public:
    AlongPath(const Ground& ground, const Path& path, const Fold& fold, const std::vector<float>& way) {
        for (size_t i = 0; i + 1 < path.points.size(); ++i) {
            const float compression =
                weighted_compression(ground, segment_triangle(ground.model, path.points, i));
            add(way[fold.first[i + 1]], std::min(compression, kMostRatio));
        }
    }
    float mean(float way, float reach) const {
        const float from = std::max(way - reach, 0.0f), to = std::min(way + reach, end_.back());
        return to > from ? (sum(to) - sum(from)) / (to - from) : value_.back();
    }

  private:
    void add(float end, float value) {
        sum_.push_back(sum_.back() + value * (end - end_.back()));
        end_.push_back(end);
        value_.push_back(value);
    }
    float sum(float way) const {  // from the start
        const auto above = std::upper_bound(end_.begin() + 1, end_.end() - 1, way);
        const size_t i = size_t(above - end_.begin()) - 1;
        return sum_[i] + value_[i] * (way - end_[i]);
    }

    std::vector<float> end_{0.0f}, sum_{0.0f}, value_;
};

// Section 6.1: L_max wide and flat at the ends, as narrow as the compression asks for between them. Where
// that falls below tau the fold sinks, down to nothing at the compression that paths reach to.
void shape(const Ground& ground, const Settings& settings, const Path& path, Fold& fold) {
    std::vector<FoldEnd>& ends = fold.ends;
    const std::vector<float> way = lengths_along(ends);
    const float widest = kMostRatio * settings.width;  // s = L_max
    const float taper = std::max(std::min(0.5f * way.back(), kTaper * widest), kShortestEdge);
    const float rise = settings.height * ease(path.fade) * signed_side(settings.direction, path.id);
    const AlongPath along(ground, path, fold, way);
    for (size_t i = 0; i < ends.size(); ++i) {
        FoldEnd& end = ends[i];
        const float compression = along.mean(way[i], kBlur * widest);
        const float middle = ease(std::min(way[i], way.back() - way[i]) / taper);
        end.width = glm::mix(widest, widest / std::max(compression, 1.0f), middle);
        end.height = rise * folded_share(settings, compression) * end.width *
                     height_table(settings.profile).height_over_width(widest / end.width);
        const Vec3 before = i > 0 ? unit(end.at - ends[i - 1].at) : Vec3(0.0f);
        const Vec3 after = i + 1 < ends.size() ? unit(ends[i + 1].at - end.at) : Vec3(0.0f);
        end.along = unit(before + after);
    }
}

Fold make_fold(const Ground& ground, const Settings& settings, const Path& path) {
    Fold fold;
    smooth(settings, positions(ground, path.points), fold);
    shape(ground, settings, path, fold);
    return fold;
}

// The least distance between two segments in space.
float segment_distance(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const Vec3 u = b - a, v = d - c, w = a - c;
    const float uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v), uw = glm::dot(u, w),
                vw = glm::dot(v, w), area = uu * vv - uv * uv;
    float s = area > 0.0f ? std::clamp((uv * vw - vv * uw) / area, 0.0f, 1.0f) : 0.0f;
    const float t = vv > 0.0f ? std::clamp((uv * s + vw) / vv, 0.0f, 1.0f) : 0.0f;
    s = uu > 0.0f ? std::clamp((uv * t - uw) / uu, 0.0f, 1.0f) : 0.0f;
    return glm::length(w + s * u - t * v);
}

// Chapter 8: triangles within reach of a segment, walking outwards from its own.
class Reach {
  public:
    explicit Reach(const Ground& ground) : ground_(ground), seen_(ground.model.rest.size(), 0) {}

    template <typename Visit>
    void visit(Index triangle, const Vec3& a, const Vec3& b, float radius, Visit&& found) {
        front_.assign(1, triangle);
        seen_[triangle] = ++query_;
        while (!front_.empty()) {
            const Index t = front_.back();
            front_.pop_back();
            found(t);
            for (Index h = 3 * t; h < 3 * t + 3; ++h) {
                const Index twin = ground_.model.net.twin[h];
                if (twin == kNone || seen_[triangle_of(twin)] == query_) continue;
                if (segment_distance(a, b, ground_.vertex(h), ground_.vertex(next_in_triangle(h))) > radius)
                    continue;
                seen_[triangle_of(twin)] = query_;
                front_.push_back(triangle_of(twin));
            }
        }
    }

  private:
    const Ground& ground_;
    std::vector<Index> seen_;
    std::vector<Index> front_;
    Index query_ = 0;
};

// How far the smoothed pieces leave the straight segment: instead of the bounding ellipse of section 8.1.
float deviation(const Fold& fold, Index begin, Index end) {
    float most = 0.0f;
    for (Index i = begin + 1; i < end; ++i) {
        const Vec3 p = fold.ends[i].at;
        most = std::max(most, segment_distance(fold.ends[begin].at, fold.ends[end].at, p, p));
    }
    return most;
}

struct Reached {
    Index triangle;
    std::array<Index, 2> pieces;
};

// Sorted into lists by triangle; ranges that follow one another become one.
void sort_by_triangle(std::vector<Reached>& reached, Index triangles, Packed& out) {
    std::stable_sort(reached.begin(), reached.end(),
                     [](const Reached& a, const Reached& b) { return a.triangle < b.triangle; });
    size_t next = 0;
    for (Index t = 0; t < triangles; ++t) {
        const size_t first = out.ranges.size();
        for (; next < reached.size() && reached[next].triangle == t; ++next) {
            const std::array<Index, 2>& pieces = reached[next].pieces;
            if (out.ranges.size() > first && out.ranges.back()[1] == pieces[0]) {
                out.ranges.back()[1] = pieces[1];
            } else {
                out.ranges.push_back(pieces);
            }
        }
        out.triangle_start.push_back(static_cast<Index>(out.ranges.size()));
    }
}

Packed pack(const Ground& ground, const Settings& settings, const std::vector<Path>& paths) {
    Packed out;
    Reach reach(ground);
    std::vector<Reached> reached;
    for (const Path& path : paths) {
        const Fold fold = make_fold(ground, settings, path);
        const Index base = static_cast<Index>(out.ends.size());
        for (size_t i = 0; i + 1 < path.points.size(); ++i) {
            const Index begin = fold.first[i], end = fold.first[i + 1];
            const float radius = 0.5f * kMostRatio * settings.width + deviation(fold, begin, end);
            reach.visit(segment_triangle(ground.model, path.points, i), fold.ends[begin].at,
                        fold.ends[end].at, radius, [&](Index t) {
                            reached.push_back({t, {base + begin, base + end}});
                        });
        }
        out.ends.insert(out.ends.end(), fold.ends.begin(), fold.ends.end());
    }
    sort_by_triangle(reached, ground.model.net.triangles(), out);
    return out;
}

float hem_weight_at(const Model& model, const Settings& settings, const SurfacePoint& place) {
    const auto corner = [&](Index k) {
        return hem_weight(model, settings, model.net.vertex[3 * place.triangle + k]);
    };
    return (1.0f - place.b0 - place.b1) * corner(0) + place.b0 * corner(1) + place.b1 * corner(2);
}

// Beyond it a piece's height is zero: most points of the triangles that it reaches are.
struct Ball {
    Vec3 middle{0.0f};
    float radius = 0.0f;  // 0: of a piece without height
};

std::vector<Ball> balls_around(const std::vector<FoldEnd>& ends) {
    std::vector<Ball> balls(ends.size());
    for (size_t i = 0; i + 1 < ends.size(); ++i) {
        const FoldEnd &a = ends[i], &b = ends[i + 1];
        if (a.height == 0.0f && b.height == 0.0f) continue;
        const float size = glm::distance(a.at, b.at) + std::max(a.width, b.width);
        balls[i] = {0.5f * (a.at + b.at), 0.5f * kRounding * size};
    }
    return balls;
}

bool may_reach(const Ball& ball, const Vec3& p, float radius) {
    const Vec3 way = p - ball.middle;
    const float reach = ball.radius + radius;
    return glm::dot(way, way) <= reach * reach;
}

// The pieces that are not flat at the points of one triangle.
void pieces_at(const Ground& ground, const Packed& packed, const std::vector<Ball>& balls, Index triangle,
               std::vector<Index>& pieces) {
    const Vec3 a = ground.vertex(3 * triangle), b = ground.vertex(3 * triangle + 1),
               c = ground.vertex(3 * triangle + 2), middle = (a + b + c) / 3.0f;
    const float radius =
        kRounding * std::max({glm::distance(middle, a), glm::distance(middle, b), glm::distance(middle, c)});
    pieces.clear();
    for (Index r = packed.triangle_start[triangle]; r < packed.triangle_start[triangle + 1]; ++r) {
        for (Index i = packed.ranges[r][0]; i < packed.ranges[r][1]; ++i) {
            if (balls[i].radius > 0.0f && may_reach(balls[i], middle, radius)) pieces.push_back(i);
        }
    }
}

// Section 7.5: the highest of the pieces at a point.
float height_at(const Packed& packed, const std::vector<Ball>& balls, const std::vector<Index>& pieces,
                Profile kind, const Vec3& p) {
    float best = 0.0f;
    for (const Index i : pieces) {
        if (!may_reach(balls[i], p, 0.0f)) continue;
        const float height = formulas::fold_height(int(kind), packed.ends[i], packed.ends[i + 1], p).height;
        if (std::abs(height) > std::abs(best)) best = height;
    }
    return best;
}

std::vector<float> fine_heights(const Ground& ground, const Settings& settings, const Packed& packed) {
    const Model& model = ground.model;
    const std::vector<Ball> balls = balls_around(packed.ends);
    std::vector<float> height(model.attachments.places.size(), 0.0f);
    std::vector<Index> pieces;
    for (Index t = 0; t < model.net.triangles(); ++t) {
        if (packed.triangle_start[t] == packed.triangle_start[t + 1]) continue;
        pieces_at(ground, packed, balls, t, pieces);
        if (pieces.empty()) continue;
        for (Index k = model.fine_start[t]; k < model.fine_start[t + 1]; ++k) {
            const Index v = model.fine_vertex[k];
            const SurfacePoint& place = model.attachments.places[v];
            const Vec3 p = interpolate(model.base, place, ground.pose.positions);
            height[v] = height_at(packed, balls, pieces, settings.profile, p);
            if (height[v] != 0.0f) height[v] *= hem_weight_at(model, settings, place);
        }
    }
    return height;
}

void check_shown(const Model& model, const Input& input, const State& state) {
    check_positions(model, input.positions, "positions");
    expect_count("state.compression", state.compression.size(), model.rest.size(), "triangles");
    const std::string wrong = fault(model, state.paths);
    if (!wrong.empty()) throw InvalidInput("state.paths: " + wrong);
}

}  // namespace

void show(const Model& model, const Settings& settings, const Input& input, const State& state,
          Picture& picture) {
    check(settings);
    check_shown(model, input, state);
    const Pose pose = make_pose(model, input.positions);
    const Ground ground{model, pose, {}, state.compression, {}};
    const std::vector<float> height = fine_heights(ground, settings, pack(ground, settings, state.paths));
    std::vector<Vec3> normals(pose.positions.size());
    vertex_normals(model.base, pose.positions, normals);
    std::vector<Vec3> lifted(height.size()), offset(height.size(), Vec3(0.0f));
    attach(model.base, model.attachments, pose.positions, normals, lifted, 0, height.size());
    for (size_t v = 0; v < height.size(); ++v) {
        if (height[v] == 0.0f) continue;
        offset[v] = height[v] * unit(interpolate(model.base, model.attachments.places[v], normals));
        lifted[v] += offset[v];
    }
    show_frame(model.base, model.shown, model.stretch, pose.positions, pose.frames, lifted, offset, picture);
    picture.height.resize(model.shown.places.size());
    apply<float>(model.shown.from_solved, height, picture.height);
}

Packed pack(const Model& model, const Settings& settings, const Input& input, const State& state) {
    check(settings);
    check_shown(model, input, state);
    const Pose pose = make_pose(model, input.positions);
    return pack(Ground{model, pose, {}, state.compression, {}}, settings, state.paths);
}

Curves curves(const Model& model, const Settings& settings, const Input& input, const State& state) {
    check(settings);
    check_shown(model, input, state);
    const Pose pose = make_pose(model, input.positions);
    const Ground ground{model, pose, {}, state.compression, {}};
    Curves out;
    for (const Path& path : state.paths) {
        const Fold fold = make_fold(ground, settings, path);
        out.id.push_back(path.id);
        for (const FoldEnd& end : fold.ends) {
            out.positions.push_back(end.at);
            out.width.push_back(end.width);
            out.height.push_back(end.height);
        }
        for (size_t i = 0; i + 1 < path.points.size(); ++i)
            out.triangle.resize(out.triangle.size() + fold.first[i + 1] - fold.first[i],
                                segment_triangle(model, path.points, i));
        out.triangle.push_back(out.triangle.back());
        out.start.push_back(static_cast<Index>(out.positions.size()));
    }
    return out;
}

}  // namespace rumple::wrinkle_paths

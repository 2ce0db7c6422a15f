// SPDX-License-Identifier: GPL-3.0-or-later
// Chapters 7 and 8 of Gillette 2015: the triangles that folds reach, and the heights of the folds.
#include <algorithm>
#include <array>
#include <cmath>

#include "base/expect.h"
#include "base/solve_team.h"
#include "base/tolerances.h"
#include "base/unit_vector.h"
#include "systems/wrinkle_paths/flood.h"
#include "systems/wrinkle_paths/fold.h"

namespace rumple::wrinkle_paths {
namespace {

// Below this number of fine vertices one thread is faster: a frame takes only a few milliseconds.
constexpr size_t kVerticesForThreads = 50'000;

// Factor on bounds, so that rounding errors do not make them too small.
constexpr float kRounding = 1.0f + 1e-5f;

using formulas::FoldEnd;

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

// The largest distance of the smoothed pieces from the straight segment. It replaces the bounding ellipse of
// section 8.1.
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

// Sorts ranges into lists by triangle, and joins consecutive ranges.
void sort_by_triangle(std::vector<Reached>& reached, Index triangles, TriangleLists& out) {
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

TriangleLists build_triangle_lists(const FoldContext& context, const Settings& settings,
                                   const std::vector<Path>& paths) {
    TriangleLists out;
    TriangleFlood flood(context);
    std::vector<Reached> reached;
    for (const Path& path : paths) {
        const Fold fold = make_fold(context, settings, path);
        const Index base = static_cast<Index>(out.ends.size());
        for (size_t i = 0; i + 1 < path.points.size(); ++i) {
            const Index begin = fold.first[i], end = fold.first[i + 1];
            const float radius = 0.5f * kMostRatio * settings.width + deviation(fold, begin, end);
            const Vec3 &from = fold.ends[begin].at, &to = fold.ends[end].at;
            flood.visit(
                segment_triangle(context.model, path.points, i),
                [&](const Vec3& a, const Vec3& b) { return segment_distance(from, to, a, b) <= radius; },
                [&](Index t) {
                    reached.push_back({t, {base + begin, base + end}});
                    return false;
                });
        }
        out.ends.insert(out.ends.end(), fold.ends.begin(), fold.ends.end());
    }
    sort_by_triangle(reached, context.model.triangles.net.triangles(), out);
    return out;
}

// A piece's height is zero outside of its ball. Most points of the triangles that it reaches are outside.
struct Ball {
    Vec3 middle{0.0f};
    float radius = 0.0f;  // 0: piece without height
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
    const Vec3 displacement = p - ball.middle;
    const float reach = ball.radius + radius;
    return glm::dot(displacement, displacement) <= reach * reach;
}

// Collects the pieces that are not flat somewhere in a triangle.
void pieces_at(const FoldContext& context, const TriangleLists& lists, const std::vector<Ball>& balls,
               Index triangle, std::vector<Index>& pieces) {
    const Vec3 a = context.vertex(3 * triangle), b = context.vertex(3 * triangle + 1),
               c = context.vertex(3 * triangle + 2), middle = (a + b + c) / 3.0f;
    const float radius =
        kRounding * std::max({glm::distance(middle, a), glm::distance(middle, b), glm::distance(middle, c)});
    pieces.clear();
    for (Index r = lists.triangle_start[triangle]; r < lists.triangle_start[triangle + 1]; ++r) {
        for (Index i = lists.ranges[r][0]; i < lists.ranges[r][1]; ++i) {
            if (balls[i].radius > 0.0f && may_reach(balls[i], middle, radius)) pieces.push_back(i);
        }
    }
}

// Section 7.5: the height of the highest piece at a point.
float height_at(const TriangleLists& lists, const std::vector<Ball>& balls, const std::vector<Index>& pieces,
                Profile kind, const Vec3& p) {
    float best = 0.0f;
    for (const Index i : pieces) {
        if (!may_reach(balls[i], p, 0.0f)) continue;
        const float height = formulas::fold_height(int(kind), lists.ends[i], lists.ends[i + 1], p).height;
        if (std::abs(height) > std::abs(best)) best = height;
    }
    return best;
}

// Heights of the fine vertices in a range of triangles.
void fine_heights(const FoldContext& context, const Settings& settings, const TriangleLists& lists,
                  const std::vector<Ball>& balls, Team::Range triangles, std::vector<float>& height) {
    const Model& model = context.model;
    std::vector<Index> pieces;
    for (Index t = Index(triangles.begin); t < Index(triangles.end); ++t) {
        if (lists.triangle_start[t] == lists.triangle_start[t + 1]) continue;
        pieces_at(context, lists, balls, t, pieces);
        if (pieces.empty()) continue;
        for (Index k = model.fine_start[t]; k < model.fine_start[t + 1]; ++k) {
            const Index v = model.fine_vertex[k];
            const SurfacePoint& place = model.attachments.places[v];
            const Vec3 p = interpolate(model.base, place, context.pose.base.positions);
            height[v] = height_at(lists, balls, pieces, settings.profile, p);
            if (height[v] != 0.0f) height[v] *= hem_weight(model, settings, place);
        }
    }
}

// Fine vertices on the smooth surface, displaced along its normals.
struct Lifted {
    std::vector<float> height;
    std::vector<Vec3> offset;
    std::vector<Vec3> positions;
};

// Every fine vertex is in one triangle, so no two threads write the same one.
Lifted lift(const FoldContext& context, const Settings& settings, const TriangleLists& lists) {
    const Model& model = context.model;
    const std::vector<Vec3>& base = context.pose.base.positions;
    const size_t vertices = model.attachments.places.size();
    Lifted out{std::vector<float>(vertices, 0.0f), std::vector<Vec3>(vertices, Vec3(0.0f)),
               std::vector<Vec3>(vertices)};
    const std::vector<Vec3> normals = vertex_normals(model.base, base);
    const std::vector<Ball> balls = balls_around(lists.ends);
    const SolveTeam team(settings.threads, vertices, kVerticesForThreads);
    for_each_part(model.triangles.rest.size(), kLeastSearches, [&](size_t begin, size_t end) {
        fine_heights(context, settings, lists, balls, {begin, end}, out.height);
    });
    attach(model.base, model.attachments, base, normals, out.positions);
    for_each_index(vertices, kLeastSteps, [&](size_t v) {
        if (out.height[v] == 0.0f) return;
        out.offset[v] =
            out.height[v] *
            unit_or_zero(interpolate(model.base, model.attachments.places[v], normals), kShortestEdge);
        out.positions[v] += out.offset[v];
    });
    return out;
}

// The context of a state's paths in a pose. Checks its arguments.
FoldContext shown_context(const Model& model, const Settings& settings, const Pose& pose,
                          const State& state) {
    check(settings);
    expect_count("state.compression", state.compression.size(), model.triangles.rest.size(), "triangles");
    if (!state.width.empty())
        expect_count("state.width", state.width.size(), model.triangles.rest.size(), "triangles");
    const std::string wrong = validate(model, state.paths);
    if (!wrong.empty()) throw InvalidInput("state.paths: " + wrong);
    return {{model, pose}, state.compression, state.width};
}

}  // namespace

void show(const Model& model, const Settings& settings, const Pose& pose, const State& state,
          Picture& picture) {
    const FoldContext context = shown_context(model, settings, pose, state);
    const Lifted lifted = lift(context, settings, build_triangle_lists(context, settings, state.paths));
    show_frame(model.base, model.shown, model.stretch, pose.base.positions, pose.frames, lifted.positions,
               lifted.offset, picture);
    picture.height.resize(model.shown.places.size());
    apply<float>(model.shown.from_solved, lifted.height, picture.height);
}

TriangleLists build_triangle_lists(const Model& model, const Settings& settings, const Pose& pose,
                                   const State& state) {
    return build_triangle_lists(shown_context(model, settings, pose, state), settings, state.paths);
}

Curves curves(const Model& model, const Settings& settings, const Pose& pose, const State& state) {
    const FoldContext context = shown_context(model, settings, pose, state);
    Curves out;
    for (const Path& path : state.paths) {
        const Fold fold = make_fold(context, settings, path);
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

// SPDX-License-Identifier: GPL-3.0-or-later
// Section 5.1 of Gillette 2015: where folds start, and how they are first traced.
#include <algorithm>
#include <cmath>

#include "base/expect.h"
#include "base/random.h"
#include "base/tolerances.h"
#include "systems/wrinkle_paths/lifecycle.h"

namespace rumple::wrinkle_paths {
namespace {

using glm::dvec2;

// Number of places where folds may start, per area of spacing x spacing.
constexpr float kSeedsPerSpacing = 4.0f;

// With more seeds a frame takes minutes. The usual cause is a width in the wrong unit.
constexpr size_t kMostSeeds = 100'000;

// A uniform number in 0..1. It depends only on the seed, the triangle and the sample.
float random(std::uint32_t seed, std::uint32_t triangle, std::uint32_t sample) {
    const std::uint32_t x =
        mixed_bits(triangle * 0x9E3779B9u ^ (seed + 0x7F4A7C15u) * 0x85EBCA6Bu ^ (sample + 1u) * 0xC2B2AE35u);
    return float(x >> 8) / 16777216.0f;
}

struct Seed {
    Index triangle;
    PathPoint at;
    float compression;  // weighted by the shape of the triangle
};

// The same places on the cloth in every frame. They are sampled by area, so that the density of the mesh does
// not matter.
std::vector<Seed> seeds(const PathContext& context, const Settings& settings) {
    std::vector<Seed> out;
    for (Index t = 0; t < context.model.triangles.net.triangles(); ++t) {
        const float compression = weighted_compression(context, t);
        if (compression < settings.threshold) continue;
        auto draw = [&, n = 0u]() mutable { return random(settings.seed, std::uint32_t(t), n++); };
        const float cell = settings.spacing * settings.width * context.width(t);
        const float expected = kSeedsPerSpacing * context.model.triangles.rest[t].area() / (cell * cell);
        const int count = int(std::min(expected + draw(), 1000.0f));
        if (out.size() + size_t(count) > kMostSeeds) {
            throw InvalidInput("width: folds of " + short_text(settings.width) + " can start at more than " +
                               std::to_string(kMostSeeds) +
                               " places of this mesh, and a frame would take minutes: raise the width");
        }
        for (int i = 0; i < count; ++i) {
            float u = draw(), v = draw();
            if (u + v > 1.0f) {
                u = 1.0f - u;
                v = 1.0f - v;
            }
            out.push_back({t, {t, kNone, {u, v}}, compression});
        }
    }
    std::stable_sort(out.begin(), out.end(),
                     [](const Seed& a, const Seed& b) { return a.compression > b.compression; });
    return out;
}

// Traces a path in both directions from the seed, at right angles to the compression. Empty if the
// compression has no direction.
std::vector<PathPoint> trace(const PathContext& context, const Settings& settings, const SegmentMap& map,
                             const Seed& seed) {
    const Stretch& s = context.stretch[seed.triangle];
    if (s.compression * s.stretch < 1.0f + kEvenStretch) return {};
    WalkLimits limits;
    limits.compression = reach_threshold(settings);
    limits.length = kLongestPath * settings.width;
    limits.others = &map;
    std::vector<Index> visited{seed.triangle};
    const dvec2 at = flat_in(context, seed.triangle, seed.at), along(-s.direction.y, s.direction.x);
    const Walk ahead = walk(context, seed.triangle, at, along, limits, visited);
    limits.turned = -ahead.turned;  // the first half of the path is now behind, in the opposite direction
    const Walk back = walk(context, seed.triangle, at, -along, limits, visited);
    std::vector<PathPoint> points = reversed(context.model, back.points);
    points.insert(points.end(), ahead.points.begin(), ahead.points.end());
    return points;
}

// Moves every point half way to the crossing of its edge with the shortest line between its neighbours, all
// at the same time (figure 5.1).
void smooth(const PathContext& context, std::vector<PathPoint>& points) {
    const std::vector<PathPoint> old = points;
    for (size_t i = 1; i + 1 < old.size(); ++i) {
        const auto beside = [&](Index half_edge, const PathPoint& p) {  // (along, away from) the edge
            const Index t = triangle_of(half_edge);
            const dvec2 from = context.corner(t, half_edge % 3);
            const dvec2 edge = context.corner(t, (half_edge + 1) % 3) - from,
                        displacement = flat_in(context, t, p) - from;
            const double size = glm::length(edge);
            return dvec2(glm::dot(displacement, edge) / size,
                         std::abs(displacement.x * edge.y - displacement.y * edge.x) / size) /
                   size;
        };
        const Index h = half_edge(old[i]);
        const dvec2 a = beside(h, old[i - 1]), b = beside(context.model.triangles.net.twin[h], old[i + 1]);
        if (a.y + b.y <= 0.0) continue;
        const double straight = glm::mix(a.x, 1.0 - b.x, a.y / (a.y + b.y));
        points[i].at.x = float(std::clamp(0.5 * (old[i].at.x + straight), kEdgeMargin, 1.0 - kEdgeMargin));
    }
}

}  // namespace

float overlap(const PathContext& context, const SegmentMap& map, const std::vector<PathPoint>& points,
              float radius) {
    const std::vector<Vec3> at = positions(context, points);
    double inside = 0.0, all = 0.0;
    for (size_t i = 0; i + 1 < at.size(); ++i) {
        const Index triangle = segment_triangle(context.model, points, i);
        const double part = glm::distance(at[i], at[i + 1]) / 3.0;
        for (const float fraction : {1.0f / 6.0f, 0.5f, 5.0f / 6.0f}) {
            all += part;
            if (map.has_near(triangle, glm::mix(at[i], at[i + 1], fraction), radius)) inside += part;
        }
    }
    return all > 0.0 ? float(inside / all) : 1.0f;
}

float strongest(const PathContext& context, const std::vector<PathPoint>& points) {
    float most = 1.0f;
    for (size_t i = 0; i + 1 < points.size(); ++i)
        most = std::max(most, weighted_compression(context, segment_triangle(context.model, points, i)));
    return most;
}

void spawn(const PathContext& context, const Settings& settings, bool grown, State& state, SegmentMap& map,
           Report& report) {
    for (const Seed& seed : seeds(context, settings)) {
        if (state.next_id >= kMostPathIds) return;
        const float width = settings.width * context.width(seed.triangle);
        const float spacing = settings.spacing * width;
        if (map.has_near(seed.triangle, position(context, seed.at), spacing)) continue;
        std::vector<PathPoint> points = trace(context, settings, map, seed);
        if (points.size() < 2) continue;
        smooth(context, points);
        if (length(context, points) < kShortestPath * width) continue;
        if (overlap(context, map, points, kCrowdDistance * width) > kMostOverlapAtBirth) continue;
        map.add(points);
        state.paths.push_back({state.next_id++, grown ? 1.0f : 0.0f, std::move(points)});
        ++report.born;
    }
}

std::string validate(const Model& model, const std::vector<Path>& paths) {
    const Index triangles = model.triangles.net.triangles();
    for (const Path& path : paths) {
        const auto say = [&](size_t i, const char* what) {
            return "path " + std::to_string(path.id) + ", point " + std::to_string(i) + ": " + what;
        };
        const std::vector<PathPoint>& points = path.points;
        if (points.size() < 2) return say(0, "alone");
        for (size_t i = 0; i < points.size(); ++i) {
            const PathPoint& p = points[i];
            const bool end = i == 0 || i + 1 == points.size();
            if (p.triangle < 0 || p.triangle >= triangles) return say(i, "in no triangle");
            if (p.edge < kNone || p.edge > 2 || end != (p.edge == kNone))
                return say(i, end ? "an end that is on an edge" : "not on an edge");
            if (!std::isfinite(p.at.y)) return say(i, "not finite");  // points on an edge do not use it
            if (!end && (!(p.at.x >= 0.0f) || p.at.x > 1.0f)) return say(i, "beyond its edge");
            if (end && (!(p.at.x >= 0.0f) || !(p.at.y >= 0.0f) || p.at.x + p.at.y > 1.0f + 1e-6f))
                return say(i, "outside of its triangle");
            if (!end && twin_of(model, p) == kNone) return say(i, "on an open border");
            if (i > 0 && segment_triangle(model, points, i - 1) != p.triangle)
                return say(i, "in another triangle than the point before");
        }
    }
    return {};
}

}  // namespace rumple::wrinkle_paths

// SPDX-License-Identifier: GPL-3.0-or-later
// Chapters 6 to 8 of Gillette 2015: the shape of the folds, and whom they reach.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/errors.h"
#include "base/tolerances.h"
#include "systems/wrinkle_paths_walk.h"

namespace rumple::wrinkle_paths {
namespace {

// Pieces that a smoothed segment is cut into, to the width L_min, and at most.
constexpr float kPiecesPerWidth = 1.0f;
constexpr int kMostPieces = 16;

// The ends of a fold taper over so many full widths, or over half of it where it is shorter.
constexpr float kTaper = 2.0f;

// A path smoothed (section 6.2) and cut into pieces, with its shape at every piece's ends.
struct Fold {
    std::vector<Vec3> at;
    std::vector<Vec3> along;    // mean direction of the pieces beside, unit: s_i of eq. 7.1
    std::vector<float> width;   // L
    std::vector<float> height;  // signed
    std::vector<Index> first;   // segments + 1, into pieces
};

Vec3 unit(const Vec3& v) {
    const float size = glm::length(v);
    return size > kShortestEdge ? v / size : Vec3(0.0f);
}

// Bezier segments whose directions at the edges are the mean of the segments beside (section 6.2).
void smooth(const Settings& settings, const std::vector<Vec3>& points, Fold& fold) {
    const size_t segments = points.size() - 1;
    std::vector<Vec3> direction(points.size());
    for (size_t i = 0; i < points.size(); ++i) {
        const Vec3 before = i > 0 ? unit(points[i] - points[i - 1]) : Vec3(0.0f);
        const Vec3 after = i < segments ? unit(points[i + 1] - points[i]) : Vec3(0.0f);
        direction[i] = unit(before + after);
    }
    for (size_t i = 0; i < segments; ++i) {
        const float size = glm::distance(points[i], points[i + 1]);
        const Vec3 a = points[i], d = points[i + 1];
        const Vec3 b = a + size / 3.0f * direction[i], c = d - size / 3.0f * direction[i + 1];
        const int pieces =
            std::clamp(int(std::ceil(kPiecesPerWidth * size / settings.width)), 2, kMostPieces);
        fold.first.push_back(static_cast<Index>(fold.at.size()));
        for (int k = 0; k < pieces; ++k) {
            const float t = float(k) / float(pieces), u = 1.0f - t;
            fold.at.push_back(u * u * u * a + 3.0f * u * u * t * b + 3.0f * u * t * t * c + t * t * t * d);
        }
    }
    fold.first.push_back(static_cast<Index>(fold.at.size()));
    fold.at.push_back(points.back());
}

float signed_side(Direction direction, Index id) {
    const bool inward = direction == Direction::kInward || (direction == Direction::kBoth && id % 2 == 1);
    return inward ? -1.0f : 1.0f;
}

float ease(float x) {
    x = std::clamp(x, 0.0f, 1.0f);
    return x * x * (3.0f - 2.0f * x);
}

// Section 6.1: L_max wide and flat at the ends, as narrow as the compression asks for in the middle.
void shape(const Settings& settings, const Path& path, Fold& fold) {
    std::vector<float> way{0.0f};
    for (size_t i = 0; i + 1 < fold.at.size(); ++i)
        way.push_back(way.back() + glm::distance(fold.at[i], fold.at[i + 1]));
    const float widest = kMostRatio * settings.width;  // s = L_max
    const float taper = std::max(std::min(0.5f * way.back(), kTaper * widest), kShortestEdge);
    const float narrow = widest / std::clamp(path.compression, 1.0f, kMostRatio);
    const float rise = settings.height * ease(path.fade) * signed_side(settings.direction, path.id);
    for (size_t i = 0; i < fold.at.size(); ++i) {
        const float middle = ease(std::min(way[i], way.back() - way[i]) / taper);
        const float width = glm::mix(widest, narrow, middle);
        fold.width.push_back(width);
        fold.height.push_back(rise * width *
                              height_table(settings.profile).height_over_width(widest / width));
        const Vec3 before = i > 0 ? unit(fold.at[i] - fold.at[i - 1]) : Vec3(0.0f);
        const Vec3 after = i + 1 < fold.at.size() ? unit(fold.at[i + 1] - fold.at[i]) : Vec3(0.0f);
        fold.along.push_back(unit(before + after));
    }
}

Fold make_fold(const Ground& ground, const Settings& settings, const Path& path) {
    Fold fold;
    smooth(settings, positions(ground, path.points), fold);
    shape(settings, path, fold);
    return fold;
}

// Roots in [0, 1] of a x^2 + b x + c; returns how many.
int roots(double a, double b, double c, double (&out)[2]) {
    int count = 0;
    const auto take = [&](double x) {
        if (x >= 0.0 && x <= 1.0) out[count++] = x;
    };
    const double square = b * b - 4.0 * a * c;
    if (square < 0.0) return 0;
    const double q = -0.5 * (b + std::copysign(std::sqrt(square), b));
    if (q != 0.0) take(c / q);
    if (a != 0.0) take(q / a);
    return count;
}

// The height that pieces of a fold give a point: projected as eq. 7.1 to 7.3, so that neighbouring pieces
// agree at the lines between them.
float height_at(const Fold& fold, const Settings& settings, Index begin, Index end, const Vec3& p) {
    float best = 0.0f;
    for (Index i = begin; i < end; ++i) {
        const glm::dvec3 z0(fold.at[i + 1] - fold.at[i]), z1(fold.at[i] - p), s1(fold.along[i]),
            s0(fold.along[i + 1]);
        double root[2];
        const int count =
            roots(glm::dot(z0, s0 - s1), glm::dot(z0, s1) + glm::dot(z1, s0 - s1), glm::dot(z1, s1),
                  root);  // (7.3)
        for (int r = 0; r < count; ++r) {
            const float share = float(root[r]);
            const float width = glm::mix(fold.width[i], fold.width[i + 1], share);
            const float far = float(glm::length(z1 + root[r] * z0));
            const float height = glm::mix(fold.height[i], fold.height[i + 1], share) *
                                 profile(settings.profile, 2.0f * far / width);
            if (std::abs(height) > std::abs(best)) best = height;
        }
    }
    return best;
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

// How far the smoothed pieces leave the straight segment.
float deviation(const Fold& fold, Index begin, Index end) {
    float most = 0.0f;
    for (Index i = begin + 1; i < end; ++i)
        most = std::max(most, segment_distance(fold.at[begin], fold.at[end], fold.at[i], fold.at[i]));
    return most;
}

float hem_weight_at(const Model& model, const Settings& settings, const SurfacePoint& place) {
    const auto corner = [&](Index k) {
        return hem_weight(model, settings, model.net.vertex[3 * place.triangle + k]);
    };
    return (1.0f - place.b0 - place.b1) * corner(0) + place.b0 * corner(1) + place.b1 * corner(2);
}

// Section 7.5: the highest of all folds that reach a fine vertex.
std::vector<float> fine_heights(const Ground& ground, const Settings& settings,
                                const std::vector<Path>& paths) {
    const Model& model = ground.model;
    std::vector<float> height(model.attachments.places.size(), 0.0f);
    Reach reach(ground);
    for (const Path& path : paths) {
        const Fold fold = make_fold(ground, settings, path);
        for (size_t i = 0; i + 1 < path.points.size(); ++i) {
            const Index begin = fold.first[i], end = fold.first[i + 1];
            const float radius = 0.5f * kMostRatio * settings.width + deviation(fold, begin, end);
            const auto lift = [&](Index t) {
                for (Index k = model.fine_start[t]; k < model.fine_start[t + 1]; ++k) {
                    const Index v = model.fine_vertex[k];
                    const Vec3 p =
                        interpolate(model.base, model.attachments.places[v], ground.pose.positions);
                    const float given = height_at(fold, settings, begin, end, p);
                    if (std::abs(given) > std::abs(height[v])) height[v] = given;
                }
            };
            reach.visit(segment_triangle(model, path.points, i), fold.at[begin], fold.at[end], radius, lift);
        }
    }
    for (size_t v = 0; v < height.size(); ++v) {
        if (height[v] != 0.0f) height[v] *= hem_weight_at(model, settings, model.attachments.places[v]);
    }
    return height;
}

void check_shown(const Model& model, const Input& input, const State& state) {
    check_positions(model, input.positions, "positions");
    const std::string wrong = fault(model, state.paths);
    if (!wrong.empty()) throw InvalidInput("state.paths: " + wrong);
}

}  // namespace

void show(const Model& model, const Settings& settings, const Input& input, const State& state,
          Picture& picture) {
    check(settings);
    check_shown(model, input, state);
    const Pose pose = make_pose(model, input.positions);
    const Ground ground{model, pose, {}, {}, {}};
    const std::vector<float> height = fine_heights(ground, settings, state.paths);
    std::vector<Vec3> normals(pose.positions.size());
    vertex_normals(model.base, pose.positions, normals);
    std::vector<Vec3> smooth_surface(height.size()), offset(height.size()), lifted(height.size());
    attach(model.base, model.attachments, pose.positions, normals, smooth_surface, 0, height.size());
    for (size_t v = 0; v < height.size(); ++v) {
        offset[v] = height[v] * unit(interpolate(model.base, model.attachments.places[v], normals));
        lifted[v] = smooth_surface[v] + offset[v];
    }
    const ShownMesh& mesh = model.shown;
    const size_t shown = mesh.places.size();
    picture.positions.resize(shown);
    picture.offset.resize(shown);
    picture.height.resize(shown);
    picture.local_offset.resize(shown);
    apply<Vec3>(mesh.from_solved, lifted, picture.positions);
    apply<Vec3>(mesh.from_solved, offset, picture.offset);
    apply<float>(mesh.from_solved, height, picture.height);
    for (size_t v = 0; v < shown; ++v) {
        const SurfacePoint& place = mesh.places[v];
        const Vec3 embedded = interpolate(model.base, place, pose.positions);
        picture.local_offset[v] = pose.frames[place.triangle].to_local(picture.positions[v] - embedded);
    }
    measure_stretch(model.base, model.stretch, pose.positions, mesh.places, picture.stretch);
}

Curves curves(const Model& model, const Settings& settings, const Input& input, const State& state) {
    check(settings);
    check_shown(model, input, state);
    const Pose pose = make_pose(model, input.positions);
    const Ground ground{model, pose, {}, {}, {}};
    Curves out;
    for (const Path& path : state.paths) {
        const Fold fold = make_fold(ground, settings, path);
        out.id.push_back(path.id);
        out.positions.insert(out.positions.end(), fold.at.begin(), fold.at.end());
        out.width.insert(out.width.end(), fold.width.begin(), fold.width.end());
        out.height.insert(out.height.end(), fold.height.begin(), fold.height.end());
        out.start.push_back(static_cast<Index>(out.positions.size()));
    }
    return out;
}

}  // namespace rumple::wrinkle_paths

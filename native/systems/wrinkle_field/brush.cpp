// SPDX-License-Identifier: GPL-3.0-or-later
// The brush: rest-pose wrinkles of section 7 of Loviscach 2006.
#include "systems/wrinkle_field/brush.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "base/elementary.h"
#include "base/expect.h"
#include "base/smooth_step.h"
#include "base/unit_vector.h"
#include "surface/refine/triangle_tree.h"
#include "systems/wrinkle_field/frames.h"

namespace rumple::wrinkle_field {
namespace {

// Erasing and smoothing make shorter vectors zero. They would be invisible, but still have a line in the
// overlay.
constexpr float kUnpainted = 1e-3f;

// Unit: none. A mean of directions, or a direction transformed back through a collapsed neighbourhood, is
// noise if its length is less than this share of the input's.
constexpr float kNoDirection = 1e-3f;

// Unit: none (cosine). The paint fades out between this slope and the silhouette, because the stroke has no
// clear place on the surface there.
constexpr float kGrazing = 0.2f;

// For scatter(): the part of the noise's range over which the wrinkles fade out.
constexpr float kScatterFade = 0.35f;

// For scatter(): distance over which the direction changes / size of the patches.
constexpr float kScatterCoherence = 2.0f;

// p and -p mean the same, so |p| exp(2 i angle) is averaged.
using Director = std::complex<float>;

Director director(const Vec2& v) {
    const float length = glm::length(v);
    if (length == 0.0f) return {};
    const Director z(v.x, v.y);
    return z * z / length;
}

// A vector of the length of z in the direction of its square root with a real part >= 0. Not std::sqrt(z),
// because it uses the system's cosine.
Vec2 undirected(const Director& z) {
    const float length = elementary::hypot(z.real(), z.imag());
    if (length == 0.0f) return Vec2(0.0f);
    const float longer = std::sqrt(0.5f * (length + std::abs(z.real())));
    const float shorter = std::abs(0.5f * z.imag()) / longer;
    const Vec2 root = z.real() >= 0.0f ? Vec2(longer, shorter) : Vec2(shorter, longer);
    return std::sqrt(length) * Vec2(root.x, std::copysign(root.y, z.imag()));
}

Vec3 in_rest_space(const Model& model, size_t v, const Vec2& q) {
    return q.x * model.tangent_rest[v] + q.y * model.bitangent_rest[v];
}

// The rest vector in the vertex's frame, with its full length: it is rotated into this tangent plane, not
// projected.
Vec2 carried(const Model& model, size_t v, const Vec3& rest) {
    const Vec2 flat = in_rest_frame(model, v, rest);
    const float length = glm::length(flat);
    return length > formulas::kNoTangent * glm::length(rest) ? flat * (glm::length(rest) / length)
                                                             : Vec2(0.0f);
}

float falloff(Falloff kind, float distance) {
    const float t = std::clamp(1.0f - distance, 0.0f, 1.0f);
    switch (kind) {
        case Falloff::kSmooth:
            return smooth_step(0.0f, 1.0f, t);
        case Falloff::kSharp:
            return t * t;
        case Falloff::kLinear:
            return t;
        case Falloff::kConstant:
            return distance < 1.0f ? 1.0f : 0.0f;
    }
    return 0.0f;
}

// The change that a dab makes at a vertex.
struct Request {
    float weight = 0.0f;   // 0..1
    Vec2 direction{0.0f};  // of the compression, unit, rest frame; zero: undefined
};

// k of the rest pose whose folds, deformed, are along (or across) the visible stroke. Folds transform as k' =
// (M^-1)^T k (section 5.1), so k = M^T k' needs no inverse.
Vec2 pulled_back(const Canvas& canvas, const Dab& dab, size_t v) {
    const Vec3 seen = glm::cross(canvas.normals[v], glm::cross(dab.view, dab.direction));  // tangential
    const Vec3 compression = dab.across ? seen : glm::cross(canvas.normals[v], seen);
    const Vec2 k(glm::dot(canvas.tangent[v], compression), glm::dot(canvas.bitangent[v], compression));
    const float most =
        glm::length(compression) * (glm::length(canvas.tangent[v]) + glm::length(canvas.bitangent[v]));
    return unit_or_zero(k, kNoDirection * most);
}

std::vector<Request> ask(const Canvas& canvas, const Dab& dab) {
    std::vector<Request> requests(canvas.positions.size());
    const Vec3 view = glm::normalize(dab.view) * (glm::dot(dab.normal, dab.view) < 0.0f ? -1.0f : 1.0f);
    for (size_t v = 0; v < requests.size(); ++v) {
        const float distance = glm::distance(canvas.positions[v], dab.centre) / dab.radius;
        const float slope = glm::dot(canvas.normals[v], view);
        const float facing =
            dab.touch == Touch::kPaint ? smooth_step(0.0f, kGrazing, slope) : float(slope > 0.0f);
        if (distance >= 1.0f || facing <= 0.0f) continue;
        requests[v] = {dab.strength * facing * falloff(dab.falloff, distance), pulled_back(canvas, dab, v)};
    }
    return requests;
}

// The change by the mirror image of the dab at a vertex: the mirrored change by the dab at the vertex's twin.
Request mirrored(const Model& model, std::span<const Request> requests, const SurfacePoint& twin, size_t v) {
    Request out;
    if (twin.triangle == kNone) return out;
    const std::array<float, 3> fraction = twin.weights();
    Director sum;
    for (int k = 0; k < 3; ++k) {
        const Index corner = model.base.triangles[twin.triangle].corner[k];
        const Index from = model.base.welded.corner_vertex[corner];
        const Vec3 there = in_rest_space(model, from, requests[from].direction);
        out.weight += fraction[k] * requests[from].weight;
        sum +=
            fraction[k] * requests[from].weight * director(carried(model, v, {-there.x, there.y, there.z}));
    }
    out.direction = unit_or_zero(undirected(sum), kNoDirection * out.weight);
    return out;
}

// Combines a dab and its mirror image, which meet near the plane. Both have the same priority.
Request both(const Request& a, const Request& b) {
    Request out{std::max(a.weight, b.weight), {}};
    const Vec2 direction = undirected(a.weight * director(a.direction) + b.weight * director(b.direction));
    out.direction = unit_or_zero(direction, kNoDirection * out.weight);
    return out;
}

std::vector<Request> with_mirror(const Model& model, std::vector<Request> requests,
                                 std::span<const SurfacePoint> twins) {
    if (twins.empty()) return requests;
    std::vector<Request> out(requests.size());
    for (size_t v = 0; v < out.size(); ++v)
        out[v] = both(requests[v], mirrored(model, requests, twins[v], v));
    return out;
}

Vec3 painted_over(const Model& model, size_t v, const Vec3& p, const Request& request, float length) {
    if (request.direction == Vec2(0.0f)) return p;
    Vec3 wanted = length * in_rest_space(model, v, request.direction);
    if (glm::dot(wanted, p) < 0.0f) wanted = -wanted;
    return p + request.weight * (wanted - p);
}

Vec3 erased(const Vec3& p, float weight) {
    const Vec3 rest = (1.0f - weight) * p;
    return glm::length(rest) < kUnpainted ? Vec3(0.0f) : rest;
}

Vec3 smoothed(const Model& model, std::span<const Vec3> painted, size_t v, float weight) {
    const Index begin = model.neighbour_start[v], end = model.neighbour_start[v + 1];
    if (begin == end) return painted[v];
    Director sum;
    for (Index i = begin; i < end; ++i) {
        sum += director(carried(model, v, painted[model.neighbours[i].vertex]));
    }
    const Director mean = sum / static_cast<float>(end - begin);
    const Vec2 q = undirected((1.0f - weight) * director(carried(model, v, painted[v])) + weight * mean);
    const Vec3 p = glm::length(q) < kUnpainted ? Vec3(0.0f) : in_rest_space(model, v, q);
    return glm::dot(p, painted[v]) < 0.0f ? -p : p;
}

void check_dab(const Dab& dab) {
    expect_within("radius", dab.radius, 1e-9, 1e9);
    expect_within("strength", dab.strength, 0.0, 1.0);
    expect_within("length", dab.length, 0.0, kLongestPainted);
    const Vec3 vectors[] = {dab.centre, dab.normal, dab.view, dab.direction};
    const char* names[] = {"centre", "normal", "view", "direction"};
    for (int i = 0; i < 4; ++i) {
        if (!is_finite(vectors[i])) throw InvalidInput(std::string(names[i]) + ": it is not finite");
    }
    if (dab.view == Vec3(0.0f)) throw InvalidInput("view: it has no length");
}

// The value of every welded vertex. If display vertices have different values, the first is used.
std::vector<Vec3> of_welded(const Surface& surface, std::span<const Vec3> painted) {
    std::vector<Vec3> out;
    for (const Index v : surface.representative) out.push_back(painted[v]);
    return out;
}

float mean_edge(const Model& model, std::span<const Vec3> positions, size_t v) {
    const Index begin = model.neighbour_start[v], end = model.neighbour_start[v + 1];
    float sum = 0.0f;
    for (Index i = begin; i < end; ++i)
        sum += glm::distance(positions[v], positions[model.neighbours[i].vertex]);
    return begin == end ? 0.0f : sum / static_cast<float>(end - begin);
}

Vec3 noise3(const Vec3& place, std::uint32_t seed) {
    return {smooth_noise(place, seed, 0), smooth_noise(place, seed, 1), smooth_noise(place, seed, 2)};
}

// The value that this share of all values exceeds.
float exceeded_by(std::vector<float> values, float fraction) {
    const size_t above = static_cast<size_t>(std::lround(double(fraction) * double(values.size())));
    if (above == 0) return *std::max_element(values.begin(), values.end());
    const auto place = values.end() - static_cast<std::ptrdiff_t>(above);
    std::nth_element(values.begin(), place, values.end());
    return std::nextafter(*place, -2.0f);  // so that the found value also exceeds it
}

}  // namespace

Canvas lay_out(const Model& model, std::span<const Vec3> positions) {
    Pose pose = make_pose(model, positions);
    const size_t vertices = pose.positions.size();
    Canvas canvas{std::move(pose.positions), std::move(pose.normals), {}, {}};
    canvas.tangent.assign(vertices, Vec3(0.0f));
    canvas.bitangent.assign(vertices, Vec3(0.0f));
    for (size_t v = 0; v < vertices; ++v) {
        const Neighbourhoods& around = pose.around[v / kLanes];
        const int lane = int(v % kLanes);
        if (!around.exist[lane]) continue;
        const glm::mat2 m = at_lane(around.m, lane);
        const Vec3 tangent = around.tangent.at(lane), bitangent = around.bitangent.at(lane);
        canvas.tangent[v] = m[0][0] * tangent + m[0][1] * bitangent;
        canvas.bitangent[v] = m[1][0] * tangent + m[1][1] * bitangent;
    }
    return canvas;
}

std::vector<SurfacePoint> find_twins(const Model& model) {
    const TriangleTree tree(model.base);
    const std::vector<Vec3>& rest = model.base.positions_rest;
    std::vector<SurfacePoint> twins;
    for (size_t v = 0; v < rest.size(); ++v) {
        const TrianglePoint found = tree.closest({-rest[v].x, rest[v].y, rest[v].z});
        const double near = 0.5 * mean_edge(model, rest, v);
        twins.push_back(found.squared_distance <= near * near ? found.place
                                                              : SurfacePoint{kNone, 0.0f, 0.0f});
    }
    return twins;
}

void apply(const Model& model, const Canvas& canvas, const Dab& dab, std::span<const SurfacePoint> twins,
           std::span<Vec3> painted) {
    check_dab(dab);
    check_rest_wrinkle(model, painted);
    if (!twins.empty()) expect_count("twins", twins.size(), canvas.positions.size(), "welded vertices");
    const std::vector<Request> requests = with_mirror(model, ask(canvas, dab), twins);
    const std::vector<Vec3> before = of_welded(model.base, painted);
    const auto touched = [&](size_t v) {
        switch (dab.touch) {
            case Touch::kErase:
                return erased(before[v], requests[v].weight);
            case Touch::kSmooth:
                return smoothed(model, before, v, requests[v].weight);
            default:
                return painted_over(model, v, before[v], requests[v], dab.length);
        }
    };
    for (size_t v = 0; v < painted.size(); ++v) {
        const size_t w = static_cast<size_t>(model.base.welded_of[v]);
        if (requests[w].weight > 0.0f) painted[v] = touched(w);
    }
}

std::vector<Vec3> scatter(const Model& model, const Scatter& settings) {
    expect_within("density", settings.density, 0.0, 1.0);
    expect_within("size", settings.size, 1e-6, 1e6);
    expect_within("length", settings.length, 0.0, kLongestPainted);
    const std::vector<Vec3>& rest = model.base.positions_rest;
    std::vector<float> cover;
    cover.reserve(rest.size());
    for (const Vec3& p : rest) cover.push_back(noise3(p / settings.size, hashed(settings.seed, 1)).x);
    const float bar = exceeded_by(cover, settings.density);
    std::vector<Vec3> field(rest.size(), Vec3(0.0f));
    for (size_t v = 0; v < rest.size(); ++v) {
        // If the noise vector is at right angles to the surface, it has no direction there, so the wrinkles
        // fade out.
        const Vec2 q = in_rest_frame(
            model, v, noise3(rest[v] / (kScatterCoherence * settings.size), hashed(settings.seed, 2)));
        const float amount = glm::length(q);
        if (cover[v] <= bar || amount == 0.0f) continue;
        const float strength = smooth_step(0.0f, kScatterFade, std::min(cover[v] - bar, amount));
        field[v] = in_rest_space(model, v, settings.length * strength * q / amount);
    }
    std::vector<Vec3> painted;
    for (const Index w : model.base.welded_of) painted.push_back(field[w]);
    return painted;
}

Lines draw(const Model& model, const Canvas& canvas, std::span<const Vec3> painted, bool across) {
    expect_count("painted", painted.size(), model.base.welded_of.size(), "vertices");
    const std::vector<Vec3> welded = of_welded(model.base, painted);
    Lines lines;
    for (size_t v = 0; v < welded.size(); ++v) {
        const Vec2 p = in_rest_frame(model, v, welded[v]);
        const float strength = glm::length(p);
        // Folds are at right angles to p in the rest pose, and deform with the cloth.
        const Vec3 fold = -p.y * canvas.tangent[v] + p.x * canvas.bitangent[v];
        const float fold_length = glm::length(fold);
        if (!(strength >= kUnpainted) || !(fold_length > 0.0f)) continue;
        const Vec3 along = fold / fold_length;
        const float edge = mean_edge(model, canvas.positions, v);
        const Vec3 half = 0.5f * strength * edge * (across ? glm::cross(canvas.normals[v], along) : along);
        if (!is_finite(half)) continue;  // its square, or the line, overflows
        lines.ends.push_back(canvas.positions[v] - half);
        lines.ends.push_back(canvas.positions[v] + half);
        lines.strength.push_back(strength);
    }
    return lines;
}

}  // namespace rumple::wrinkle_field

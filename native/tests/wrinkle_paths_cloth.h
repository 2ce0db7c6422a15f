// SPDX-License-Identifier: GPL-3.0-or-later
// A base with its folds, and poses for it.
#pragma once

#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <vector>

#include "systems/wrinkle_paths/walk.h"
#include "tests/meshes.h"

namespace rumple::tests {

using Pose3 = std::vector<Vec3>;

struct PathCloth {
    MeshData mesh;
    std::shared_ptr<const wrinkle_paths::Model> model;
    wrinkle_paths::Settings settings;
    double frame_rate = 30.0;

    explicit PathCloth(MeshData data, Index level = 0) : mesh(std::move(data)) {
        FineSource source;
        source.level = level;
        model = wrinkle_paths::build(tests::build(mesh), source, AttachmentKind::kLinear);
        settings.hem_rings = 0;
        settings.width = 0.02f;
    }

    wrinkle_paths::State solve(const Pose3& pose, const wrinkle_paths::State* before = nullptr,
                               wrinkle_paths::Report* report = nullptr) const {
        wrinkle_paths::Report unused;
        wrinkle_paths::Input input;
        input.positions = pose;
        input.frame_time.time = before ? before->reference.time + 1.0 / frame_rate : 0.0;
        return wrinkle_paths::solve(*model, settings, {}, input, make_pose(*model, pose), before,
                                    report ? *report : unused);
    }
    // frames of pose(seconds), from rest; visit(state, report) after each.
    template <typename PoseAt, typename Visit>
    wrinkle_paths::State play(double seconds, PoseAt&& pose, Visit&& visit) const {
        wrinkle_paths::State state = solve(pose(0.0));
        for (int f = 1; f <= int(std::lround(seconds * frame_rate)); ++f) {
            wrinkle_paths::Report report;
            state = solve(pose(f / frame_rate), &state, &report);
            visit(state, report);
        }
        return state;
    }
    template <typename PoseAt>
    wrinkle_paths::State play(double seconds, PoseAt&& pose) const {
        return play(seconds, pose, [](const auto&, const auto&) {});
    }
    wrinkle_paths::Picture show(const Pose3& pose, const wrinkle_paths::State& state) const {
        wrinkle_paths::Picture picture;
        wrinkle_paths::show(*model, settings, make_pose(*model, pose), state, picture);
        return picture;
    }
    wrinkle_paths::Curves curves(const Pose3& pose, const wrinkle_paths::State& state) const {
        return wrinkle_paths::curves(*model, settings, make_pose(*model, pose), state);
    }
    std::string validate(const wrinkle_paths::State& state) const {
        return wrinkle_paths::validate(*model, state.paths);
    }

    template <typename Move>
    Pose3 moved(Move&& move) const {
        Pose3 pose = mesh.positions;
        for (Vec3& p : pose) p = move(p);
        return pose;
    }
    Pose3 squeezed(float x, float y = 1.0f) const {
        return moved([=](Vec3 p) { return Vec3(x * p.x, y * p.y, p.z); });
    }
    // A tube along x bent to `angle` over its middle half: an elbow, as skinning would bend it.
    Pose3 bent(float angle, float length) const {
        return moved([=](const Vec3& p) {
            const float x = std::clamp((p.x / length - 0.25f) * 2.0f, 0.0f, 1.0f), a = angle * x;
            const float centre = 0.5f * length, way = p.x - centre;
            return Vec3(centre + way * std::cos(a) - p.z * std::sin(a), p.y,
                        way * std::sin(a) + p.z * std::cos(a));
        });
    }
};

// Every triangle of a 4 x 4 grid squeezed along x: a fold from (1.6, 1.2) runs along y to both hems.
struct Squeezed : PathCloth {
    wrinkle_paths::Pose pose;
    wrinkle_paths::PathContext context;
    explicit Squeezed(float x = 0.5f)
        : PathCloth(grid(4, 4, 1.0f)),
          pose(wrinkle_paths::make_pose(*model, squeezed(x))),
          context(wrinkle_paths::make_context(*model, settings, {}, pose, pose.base.shapes,
                                              model->triangles.rest, std::vector<Stretch>(32))) {}
    Index triangle_at(const Vec3& p) const {
        for (Index t = 0; t < model->triangles.net.triangles(); ++t) {
            const glm::dvec2 at = context.to_flat(t, p), u1 = context.corner(t, 1), u2 = context.corner(t, 2);
            const double y = at.y / u2.y, x = (at.x - y * u2.x) / u1.x;
            if (x > 1e-6 && y > 1e-6 && x + y < 1.0 - 1e-6) return t;
        }
        return kNone;
    }
    std::vector<Vec3> walk_from(const Vec3& p, const Vec3& direction,
                                const wrinkle_paths::WalkLimits& limits) const {
        const Index t = triangle_at(p);
        std::vector<Index> visited{t};
        const glm::dvec2 to = context.to_flat(t, p + direction);
        const glm::dvec2 at = context.to_flat(t, p);
        return wrinkle_paths::positions(context,
                                        wrinkle_paths::walk(context, t, at, to - at, limits, visited).points);
    }
};

inline bool same_bits(const std::vector<wrinkle_paths::Path>& a, const std::vector<wrinkle_paths::Path>& b) {
    if (a.size() != b.size()) return false;
    for (size_t i = 0; i < a.size(); ++i) {
        if (a[i].id != b[i].id || a[i].points.size() != b[i].points.size()) return false;
        if (std::memcmp(&a[i].fade, &b[i].fade, sizeof(float)) != 0) return false;
        if (std::memcmp(a[i].points.data(), b[i].points.data(),
                        a[i].points.size() * sizeof(wrinkle_paths::PathPoint)) != 0)
            return false;
    }
    return true;
}

inline bool same_bits(const wrinkle_paths::State& a, const wrinkle_paths::State& b) {
    const auto same = [](const auto& x, const auto& y) {
        return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0;
    };
    return same_bits(a.paths, b.paths) && same(a.reference.reference, b.reference.reference) &&
           same(a.shapes, b.shapes) && same(a.compression, b.compression) &&
           same(a.reference.labels, b.reference.labels) &&
           same(a.reference.past_positions, b.reference.past_positions) && a.next_id == b.next_id;
}

inline float total_length(const wrinkle_paths::Curves& curves) {
    float sum = 0.0f;
    for (size_t c = 0; c + 1 < curves.start.size(); ++c) {
        for (Index i = curves.start[c]; i + 1 < curves.start[c + 1]; ++i)
            sum += glm::distance(curves.positions[i], curves.positions[i + 1]);
    }
    return sum;
}

}  // namespace rumple::tests

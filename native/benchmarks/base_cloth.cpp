// SPDX-License-Identifier: GPL-3.0-or-later
// A sleeve of 1,500 coarse vertices that bends over a body of 20,000 triangles, by stage: the search for
// bodies, the base cloth (Hang, Swing), the wide layers on it (Drape and Folds) without and with the bound by
// their own cloth, all three layers of the first click, and the shown mesh. The time of a stage contains the
// stages before it. Measured on one core, and on all cores (the rows with "on_all_threads").
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "surface/cloth/swing.h"
#include "systems/wrinkle_mesh/layers.h"
#include "tests/meshes.h"

namespace rumple {
namespace {

constexpr Index kAround = 30, kAlong = 50;
constexpr float kLength = 0.9f, kRadius = 0.1f;
constexpr int kFrames = 24;

std::vector<Vec3> bent(const std::vector<Vec3>& rest, float angle) {
    std::vector<Vec3> out;
    for (const Vec3& p : rest) {
        const float turn = angle * std::clamp((p.x - 0.35f * kLength) / (0.3f * kLength), 0.0f, 1.0f);
        const float x = p.x - 0.5f * kLength;
        out.push_back(
            {x * std::cos(turn) - p.z * std::sin(turn), p.y, x * std::sin(turn) + p.z * std::cos(turn)});
    }
    return out;
}

struct Scene {
    tests::MeshData sleeve = tests::tube(kAround, kAlong, kRadius, kLength);
    tests::MeshData body = tests::tube(100, 100, kRadius - 0.01f, kLength);
    std::shared_ptr<const base_cloth::Model> cloth;
    std::shared_ptr<const wrinkle_mesh::Layers> layers;
    std::unique_ptr<Collider> collider;
    std::vector<std::vector<Vec3>> poses, body_poses;

    explicit Scene(Index levels) {
        const Surface surface = tests::build(sleeve);
        cloth = base_cloth::build(surface);
        layers = wrinkle_mesh::build_layers(surface, levels, 1, 1'000'000);
        const Surface under = tests::build(body);
        std::vector<std::array<Index, 3>> triangles;
        for (const Triangle& t : under.triangles) {
            triangles.push_back({body.corner_vertex[t.corner[0]], body.corner_vertex[t.corner[1]],
                                 body.corner_vertex[t.corner[2]]});
        }
        collider = std::make_unique<Collider>(body.positions, triangles);
        for (int frame = 0; frame < kFrames; ++frame) {
            const float angle =
                0.7f - 0.7f * std::cos(2.0f * std::numbers::pi_v<float> * float(frame) / float(kFrames));
            poses.push_back(bent(sleeve.positions, angle));
            body_poses.push_back(bent(body.positions, angle));
        }
    }
};

enum Stage { kBody, kHang, kSwing, kWideLayers, kBoundLayers, kThreeLayers, kShown };

wrinkle_mesh::Settings layer_settings(Stage stage) {
    wrinkle_mesh::Settings out{.inside = 0.6f, .tangential_pull = 0.2f, .normal_pull = 0.02f};
    if (stage >= kBoundLayers) out.apart = out.slide = 0.45f;
    return out;
}

void frames(benchmark::State& bench, Stage until, bool on_all_threads = false) {
    std::optional<SolveTeam> alone;
    if (!on_all_threads) alone.emplace(1, 1, 1);
    const Scene scene(until >= kThreeLayers ? 2 : 1);
    const std::vector<wrinkle_mesh::Settings> settings(scene.layers->layers.size(), layer_settings(until));
    const std::vector<wrinkle_mesh::Paint> paint(settings.size());
    base_cloth::State cloth_state;
    wrinkle_mesh::LayersState layers_state;
    wrinkle_mesh::Picture picture;
    bool first = true;
    size_t frame = 0;
    for (auto _ : bench) {
        const size_t at = frame++ % kFrames;
        const PosedCollider bodies(*scene.collider, scene.body_poses[at]);
        benchmark::DoNotOptimize(&bodies);
        if (until == kBody) continue;
        const base_cloth::State* before = first ? nullptr : &cloth_state;
        base_cloth::Result cloth =
            until == kSwing
                ? base_cloth::solve_swing(*scene.cloth, {}, {}, {}, scene.poses[at], &bodies, before)
                : base_cloth::solve(*scene.cloth, {}, {}, scene.poses[at], &bodies, before);
        cloth_state = std::move(cloth.state);
        if (until >= kWideLayers) {
            wrinkle_mesh::Input input{cloth.positions};
            input.gap = cloth.gap;
            input.bodies = &bodies;
            input.body_hint = cloth.body_hint;
            input.thickness = 0.003f;
            std::vector<wrinkle_mesh::Report> reports;
            layers_state = wrinkle_mesh::solve(*scene.layers, settings, paint, input,
                                               first ? nullptr : &layers_state, reports);
        }
        if (until == kShown) {
            wrinkle_mesh::show(*scene.layers, scene.poses[at], cloth.positions, layers_state, picture);
            benchmark::DoNotOptimize(picture.positions.data());
        }
        first = false;
    }
}

BENCHMARK_CAPTURE(frames, body, kBody)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frames, body_and_base_cloth, kHang)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frames, body_and_base_cloth_that_swings, kSwing)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frames, body_base_cloth_and_wide_layers, kWideLayers)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frames, body_base_cloth_and_bound_layers, kBoundLayers)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frames, body_base_cloth_and_three_layers, kThreeLayers)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frames, body_base_cloth_three_layers_shown, kShown)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frames, body_and_base_cloth_on_all_threads, kHang, true)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frames, body_base_cloth_three_layers_shown_on_all_threads, kShown, true)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rumple

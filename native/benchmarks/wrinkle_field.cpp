// SPDX-License-Identifier: GPL-3.0-or-later
// Crush and relax at the sizes of the paper's models and beyond. The shirt of Table 1 has 455 vertices. Model
// "B" of Table 2 has 5,977, with 1.83 ms and 1.75 ms on a GeForce 6800.
#include "systems/wrinkle_field/wrinkle_field.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <thread>

#include "tests/meshes.h"

namespace rumple {
namespace {

using namespace wrinkle_field;

struct Scene {
    tests::MeshData mesh;
    std::shared_ptr<const Model> model;
    std::vector<Vec3> pose;
    Settings settings;

    Scene(Index nx, Index ny, int threads, const Plan& plan = {})
        : mesh(tests::triangulated(tests::grid(nx, ny, 0.01f))) {
        model = wrinkle_field::build(tests::build(mesh), plan);
        pose = mesh.positions;
        for (Vec3& p : pose) p = Vec3(0.7f * p.x, p.y, 0.02f * std::sin(6.0f * p.x));
        settings.threads = threads > 0 ? threads : static_cast<int>(std::thread::hardware_concurrency());
    }

    State solve(const std::vector<Vec3>& positions, const State* before = nullptr) const {
        Report unused;
        return wrinkle_field::solve(*model, settings, {}, make_pose(*model, positions), before, unused);
    }
};

void report(benchmark::State& bench, const Scene& scene) {
    const auto vertices = static_cast<std::int64_t>(scene.model->base.positions_rest.size());
    bench.counters["vertices"] = double(vertices);
    bench.SetItemsProcessed(vertices * bench.iterations());
}

void estimate_step(benchmark::State& bench) {
    const Scene scene(Index(bench.range(0)), Index(bench.range(1)), int(bench.range(2)));
    for (auto _ : bench) {
        const Waves waves = estimate_waves(*scene.model, scene.settings, {}, scene.pose, {});
        benchmark::DoNotOptimize(waves.height.data());
    }
    report(bench, scene);
}

// One round, as in a frame with default settings, with its preparation.
void relax_step(benchmark::State& bench) {
    const Scene scene(Index(bench.range(0)), Index(bench.range(1)), int(bench.range(2)));
    const Waves waves = estimate_waves(*scene.model, scene.settings, {}, scene.pose, {});
    std::vector<float> phase = random_phases(*scene.model, 0);
    for (auto _ : bench) {
        relax(*scene.model, scene.settings, waves, 1, phase);
        benchmark::DoNotOptimize(phase.data());
    }
    report(bench, scene);
}

// A frame of a clip: estimate and ten rounds from the state of the frame before. The pose alternates between
// two. The second one shears, which turns the waves, so that no vertex is asleep; or the pose is held, so
// that all are.
void solve_ten_rounds(benchmark::State& bench, float shear) {
    Scene scene(Index(bench.range(0)), Index(bench.range(1)), int(bench.range(2)));
    scene.settings.rounds = 10;
    std::vector<Vec3> poses[2] = {scene.pose, scene.pose};
    for (Vec3& p : poses[1]) p.x += shear * p.y;
    State state = scene.solve(scene.pose);
    size_t frame = 0;
    for (auto _ : bench) {
        state = scene.solve(poses[++frame % 2], &state);
        benchmark::DoNotOptimize(state.phase.data());
    }
    report(bench, scene);
}

void solve_moved(benchmark::State& bench) {
    solve_ten_rounds(bench, 0.2f);
}
void solve_held(benchmark::State& bench) {
    solve_ten_rounds(bench, 0.0f);
}

// As in the add-on, with keep_length and dissolve: only the field, or also the fine mesh.
void shown_frame(benchmark::State& bench, bool fine_mesh) {
    Plan plan;
    plan.output = Output::kGeometry;
    plan.fine.level = fine_mesh ? 2 : 0;
    const Scene scene(Index(bench.range(0)), Index(bench.range(1)), int(bench.range(2)), plan);
    const State state = scene.solve(scene.pose);
    for (auto _ : bench) {
        const Waves waves = shown_waves(*scene.model, scene.settings, sine(), {}, scene.pose, state);
        benchmark::DoNotOptimize(waves.height.data());
        if (fine_mesh)
            benchmark::DoNotOptimize(show(*scene.model, waves, sine(), scene.pose, state).positions.data());
    }
    report(bench, scene);
}
void shown_waves_frame(benchmark::State& bench) {
    shown_frame(bench, false);
}
void show_geometry(benchmark::State& bench) {
    shown_frame(bench, true);
}

// The part of the time that keep_length() takes.
void keep_length_step(benchmark::State& bench) {
    const Scene scene(Index(bench.range(0)), Index(bench.range(1)), int(bench.range(2)));
    const Waves asked = estimate_waves(*scene.model, scene.settings, {}, scene.pose, {});
    Waves waves = asked;
    for (auto _ : bench) {
        waves.height = asked.height;
        keep_length(sine(), waves);
        benchmark::DoNotOptimize(waves.height.data());
    }
    report(bench, scene);
}

void one_thread(benchmark::internal::Benchmark* bench) {
    bench->Unit(benchmark::kMicrosecond);
    for (const auto& [nx, ny] : {std::pair{12, 34}, {42, 138}, {315, 316}, {999, 999}})
        bench->Args({nx, ny, 1});
}
void fine_mesh(benchmark::internal::Benchmark* bench) {
    bench->Unit(benchmark::kMicrosecond);
    for (const auto& [nx, ny] : {std::pair{12, 34}, {42, 138}}) bench->Args({nx, ny, 1});
}
void all_threads(benchmark::internal::Benchmark* bench) {
    bench->Unit(benchmark::kMicrosecond)->UseRealTime();
    for (const auto& [nx, ny] : {std::pair{315, 316}, {999, 999}}) bench->Args({nx, ny, 0});
}

BENCHMARK(estimate_step)->Name("WrinkleField/EstimateWaves/OneThread")->Apply(one_thread);
BENCHMARK(estimate_step)->Name("WrinkleField/EstimateWaves/AllThreads")->Apply(all_threads);
BENCHMARK(relax_step)->Name("WrinkleField/RelaxOneRound/OneThread")->Apply(one_thread);
BENCHMARK(relax_step)->Name("WrinkleField/RelaxOneRound/AllThreads")->Apply(all_threads);
BENCHMARK(solve_moved)->Name("WrinkleField/SolveTenRounds/OneThread")->Apply(one_thread);
BENCHMARK(solve_held)->Name("WrinkleField/SolveHeldPose/OneThread")->Apply(one_thread);
BENCHMARK(keep_length_step)->Name("WrinkleField/KeepLength/OneThread")->Apply(one_thread);
BENCHMARK(shown_waves_frame)->Name("WrinkleField/ShownWaves/OneThread")->Apply(fine_mesh);
BENCHMARK(show_geometry)->Name("WrinkleField/ShowGeometry/OneThread")->Apply(fine_mesh);

}  // namespace
}  // namespace rumple

// SPDX-License-Identifier: GPL-3.0-or-later
// Table 9.1 of Gillette 2015 row by row, on one core: a sleeve that bends back and forth, with the same
// number of triangles and the thesis's tau and L_min (per cent of a character's height, 1.8 m). The times in
// the thesis are from a Core i7-3930K, for modelling from the GPU. A separate benchmark has 10,000 triangles.
#include "systems/wrinkle_paths/wrinkle_paths.h"

#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>

#include "systems/wrinkle_paths/context.h"
#include "tests/wrinkle_paths_cloth.h"

namespace rumple {
namespace {

using namespace wrinkle_paths;

constexpr int kFrames = 60;
constexpr float kHeight = 1.8f;  // of the character, metres

struct Row {
    const char* name;
    float threshold;      // tau
    float width_percent;  // L_min, per cent of the character's height
    int triangles;
    double reference_ms, tracing_ms, modelling_ms;  // times in the thesis
};
constexpr Row kTable[] = {
    {"a", 1.4f, 0.5f, 734, 1.69, 5.33, 8.30}, {"b", 1.3f, 0.5f, 602, 1.69, 3.92, 5.53},
    {"c", 1.4f, 0.5f, 534, 1.74, 2.46, 4.68}, {"d", 1.4f, 0.5f, 628, 1.57, 3.77, 6.55},
    {"e", 1.2f, 1.0f, 356, 0.92, 4.84, 8.95}, {"f", 1.4f, 0.5f, 602, 1.72, 5.69, 9.78},
};
constexpr Row kDense{"dense", 1.25f, 0.67f, 10000, 0.0, 0.0, 0.0};

struct Sleeve {
    tests::PathCloth cloth;
    std::vector<tests::Pose3> poses;
    std::vector<State> states;  // of the second round

    Sleeve(const Row& row, Index level) : cloth(make_mesh(row.triangles), level) {
        cloth.settings.width = 0.01f * row.width_percent * kHeight;
        cloth.settings.threshold = row.threshold;
        for (int f = 0; f < kFrames; ++f)
            poses.push_back(cloth.bent(1.1f - 1.1f * std::cos(6.2831853f * float(f) / kFrames), 0.6f));
        State state = cloth.solve(poses[0]);
        for (int f = 1; f < 2 * kFrames; ++f) {
            state = cloth.solve(poses[f % kFrames], &state);
            if (f >= kFrames) states.push_back(state);
        }
    }
    static tests::MeshData make_mesh(int triangles) {
        const int around = std::max(8, int(std::sqrt(0.35 * triangles)));
        return tests::shaken(tests::tube(around, triangles / (2 * around), 0.06f, 0.6f), 0.002f, 1);
    }
    Input input(int f) const {
        Input in;
        in.positions = poses[(f + 1) % kFrames];
        in.frame_time.time = states[f].reference.time + 1.0 / 30.0;
        return in;
    }
};

// Adds the milliseconds that work() takes.
template <typename Work>
void timed(double& sum, Work&& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    sum += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// A frame of the sleeve: reference (chapter 4), tracing with persistence (chapter 5), and modelling (chapters
// 6 to 8: heights of a fine mesh; the viewport computes the normals).
void frame(benchmark::State& bench, const Row& row, Index level) {
    const Sleeve sleeve(row, level);
    const tests::PathCloth& cloth = sleeve.cloth;
    double reference = 0.0, solving = 0.0, modelling = 0.0;
    int f = 0;
    Picture picture;
    for (auto _ : bench) {
        const State& before = sleeve.states[f];
        const Input input = sleeve.input(f);
        State after;
        std::vector<Stretch> changes;
        timed(reference, [&] {
            const Pose pose = make_pose(*cloth.model, input.positions);
            benchmark::DoNotOptimize(adapt(cloth.model->base, cloth.model->triangles, cloth.settings.rest,
                                           input.frame_time, pose.base, &before.reference, changes));
        });
        Report report;
        const auto pose = [&] { return make_pose(*cloth.model, input.positions); };
        timed(solving,
              [&] { after = solve(*cloth.model, cloth.settings, {}, input, pose(), &before, report); });
        timed(modelling, [&] { show(*cloth.model, cloth.settings, pose(), after, picture); });
        f = (f + 1) % kFrames;
    }
    double paths = 0.0;
    for (const State& s : sleeve.states) paths += double(s.paths.size()) / kFrames;
    const double frames = double(bench.iterations());
    bench.counters["triangles"] = double(cloth.model->triangles.net.triangles());
    bench.counters["fine_vertices"] = double(picture.positions.size());
    bench.counters["paths"] = paths;
    bench.counters["1_reference_ms"] = reference / frames;
    bench.counters["2_tracing_ms"] = (solving - reference) / frames;
    bench.counters["3_modelling_ms"] = modelling / frames;
    bench.counters["frames_a_second"] = 1e3 * frames / (solving + modelling);
    if (row.reference_ms <= 0.0) return;
    bench.counters["1_thesis_ms"] = row.reference_ms;
    bench.counters["2_thesis_ms"] = row.tracing_ms;
    bench.counters["3_thesis_ms"] = row.modelling_ms;
}

const int registered = [] {
    for (const Row& row : kTable) {
        benchmark::RegisterBenchmark((std::string("paths_table_9_1/") + row.name).c_str(),
                                     [&row](benchmark::State& bench) { frame(bench, row, 3); })
            ->Unit(benchmark::kMillisecond);
    }
    benchmark::RegisterBenchmark("paths_10000_triangles", [](benchmark::State& bench) {
        frame(bench, kDense, 2);
    })->Unit(benchmark::kMillisecond);
    return 0;
}();

}  // namespace
}  // namespace rumple

// SPDX-License-Identifier: GPL-3.0-or-later
// Table 9.1 of Gillette 2015: 356 to 734 triangles took 0.92 to 1.74 ms for the reference shape, 2.46 to 5.69
// ms for tracing and 4.68 to 9.78 ms for modelling (on the GPU) on a Core i7-3930K. Here a sleeve that bends
// to and fro, of as many triangles and of more.
#include "systems/wrinkle_paths.h"

#include <benchmark/benchmark.h>

#include <cmath>

#include "systems/wrinkle_paths_ground.h"
#include "tests/wrinkle_paths_cloth.h"

namespace rumple {
namespace {

using namespace wrinkle_paths;

constexpr int kFrames = 60;

struct Sleeve {
    tests::PathCloth cloth;
    std::vector<tests::Pose3> poses;
    std::vector<State> states;  // of the second round

    Sleeve(int triangles, Index level) : cloth(make_mesh(triangles), level) {
        cloth.settings.width = 0.012f;
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
        in.time = states[f].time + 1.0 / 30.0;
        return in;
    }
    void count(benchmark::State& bench) const {
        double paths = 0.0;
        for (const State& s : states) paths += double(s.paths.size()) / kFrames;
        bench.counters["paths"] = paths;
        bench.counters["triangles"] = double(cloth.model->net.triangles());
    }
};

void paths_reference(benchmark::State& bench) {
    const Sleeve sleeve(int(bench.range(0)), 0);
    const tests::PathCloth& cloth = sleeve.cloth;
    int f = 0;
    for (auto _ : bench) {
        const State& state = sleeve.states[f];
        const Input input = sleeve.input(f);
        const Pose pose = make_pose(*cloth.model, input.positions);
        std::vector<Stretch> changes;
        benchmark::DoNotOptimize(
            adapt(cloth.model->base, *cloth.model, cloth.settings, input, pose, &state, changes));
        f = (f + 1) % kFrames;
    }
    sleeve.count(bench);
}

void paths_solve(benchmark::State& bench) {
    const Sleeve sleeve(int(bench.range(0)), 0);
    int f = 0;
    for (auto _ : bench) {
        Report report;
        benchmark::DoNotOptimize(solve(*sleeve.cloth.model, sleeve.cloth.settings, {}, sleeve.input(f),
                                       &sleeve.states[f], report));
        f = (f + 1) % kFrames;
    }
    sleeve.count(bench);
}

// Heights on a fine mesh of 3/8 L_min edges and less.
void paths_show(benchmark::State& bench) {
    const Sleeve sleeve(int(bench.range(0)), bench.range(0) > 2000 ? 2 : 3);
    int f = 0;
    Picture picture;
    for (auto _ : bench) {
        Input input;
        input.positions = sleeve.poses[f];
        show(*sleeve.cloth.model, sleeve.cloth.settings, input, sleeve.states[f], picture);
        f = (f + 1) % kFrames;
    }
    sleeve.count(bench);
    bench.counters["fine_vertices"] = double(picture.positions.size());
}

BENCHMARK(paths_reference)->Arg(356)->Arg(734)->Arg(10000)->Unit(benchmark::kMillisecond);
BENCHMARK(paths_solve)->Arg(356)->Arg(734)->Arg(10000)->Unit(benchmark::kMillisecond);
BENCHMARK(paths_show)->Arg(356)->Arg(734)->Arg(10000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rumple

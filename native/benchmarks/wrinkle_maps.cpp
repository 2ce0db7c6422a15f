// SPDX-License-Identifier: GPL-3.0-or-later
// One frame of the Wrinkle Maps: influences and masks. The paper's model has 9,040 triangles, 21 bones and
// two poses.
#include "systems/wrinkle_maps/wrinkle_maps.h"

#include <benchmark/benchmark.h>

#include "tests/wrinkle_maps_rig.h"

namespace rumple {
namespace {

using namespace wrinkle_maps;

void frame(benchmark::State& bench) {
    const auto triangles = bench.range(0);
    const auto bones = static_cast<Index>(bench.range(1)), poses = static_cast<Index>(bench.range(2));
    Settings settings;
    settings.gain = static_cast<float>(bench.range(3));
    tests::RandomRig random(0);
    const Rig rig = random.rig(bones, poses);
    const auto model = build(rig, random.weights(static_cast<Index>(triangles / 2), bones));
    const std::vector<Bone> posed = random.moved(rig.neutral, 0.01f);
    for (auto _ : bench) {
        const Influences at = evaluate(*model, in_root_space(glm::mat4(1.0f), posed));
        benchmark::DoNotOptimize(masks(*model, settings, at).data());
    }
}
BENCHMARK(frame)
    ->Name("wrinkle_maps")
    ->ArgNames({"triangles", "bones", "poses", "gain"})
    ->Args({9'040, 21, 2, 1})
    ->Args({50'000, 100, 8, 1})
    ->Args({50'000, 100, 8, 3})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rumple

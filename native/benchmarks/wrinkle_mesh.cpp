// SPDX-License-Identifier: GPL-3.0-or-later
// The paper's scene: 2,048 base triangles, 32,768 fine ones, 10 iterations, attachments and normals included.
// Mueller and Chentanez report 5 ms on one core of a Core 2 at 2.4 GHz (2010).
#include "systems/wrinkle_mesh.h"

#include <benchmark/benchmark.h>

#include <cmath>

#include "tests/meshes.h"

namespace rumple {
namespace {

using namespace wrinkle_mesh;

struct Scene {
    tests::MeshData mesh = tests::triangulated(tests::grid(32, 32, 0.03f));
    std::shared_ptr<const Model> model;
    std::vector<std::vector<Vec3>> poses;

    explicit Scene(AttachmentKind kind) {
        Source source;
        source.kind = Source::Kind::kRegular;
        source.segments = 4;
        model = wrinkle_mesh::build(tests::build(mesh), source, kind, 0);
        for (int frame = 0; frame < 16; ++frame) {
            poses.push_back(mesh.positions);
            const float phase = 0.4f * float(frame);
            for (Vec3& p : poses.back()) {
                p = Vec3(p.x * (0.85f + 0.05f * std::sin(phase)), p.y, 0.05f * std::sin(6.0f * p.x + phase));
            }
        }
    }
};

void solve_step(benchmark::State& bench, AttachmentKind kind) {
    const Scene scene(kind);
    Settings settings;
    settings.threads = static_cast<int>(bench.range(0));
    Report report;
    State state = solve(*scene.model, settings, {}, {scene.poses[0]}, nullptr, report);
    std::vector<Vec3> normals(scene.model->base.welded.vertex_count);
    size_t frame = 0;
    for (auto _ : bench) {
        const std::vector<Vec3>& pose = scene.poses[++frame % scene.poses.size()];
        state = solve(*scene.model, settings, {}, {pose}, &state, report);
        vertex_normals(scene.model->base, pose, normals);
        benchmark::DoNotOptimize(state.offset.data());
    }
    bench.counters["triangles"] = double(scene.model->triangles.size());
    bench.counters["pairs"] = double(scene.model->distance.size() + scene.model->bending.size());
    bench.SetLabel("paper, 2010: 5 ms");
}
BENCHMARK_CAPTURE(solve_step, linear, AttachmentKind::kLinear)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve_step, limit, AttachmentKind::kLimit)
    ->Arg(1)
    ->Arg(2)
    ->Arg(4)
    ->Unit(benchmark::kMillisecond);

void build_step(benchmark::State& bench) {
    for (auto _ : bench) benchmark::DoNotOptimize(Scene(AttachmentKind::kLinear).model.get());
}
BENCHMARK(build_step)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rumple

// SPDX-License-Identifier: GPL-3.0-or-later
// The paper's scene: 2,048 base triangles, 32,768 fine ones, 10 iterations, with attachments and normals.
// Mueller and Chentanez report 5 ms on one core of a Core 2 at 2.4 GHz (2010).
#include "systems/wrinkle_mesh/wrinkle_mesh.h"

#include <benchmark/benchmark.h>

#include <cmath>

#include "tests/meshes.h"

namespace rumple {
namespace {

using namespace wrinkle_mesh;

struct Scene {
    tests::MeshData mesh;
    std::shared_ptr<const Model> model;
    std::vector<std::vector<Vec3>> poses;

    explicit Scene(AttachmentKind kind, Index squares = 32)
        : mesh(tests::triangulated(tests::grid(squares, squares, 0.03f))) {
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

// The shown mesh as a surface, for its normals.
Surface shown_surface(const Model& model) {
    const PolygonMesh& mesh = model.shown.mesh;
    std::vector<Index> triangle_corner;
    for (Index p = 0; p < mesh.polygons(); ++p) {
        const Index begin = mesh.polygon_start[p];
        for (Index k = 1; k + 1 < mesh.polygon_size(p); ++k) {
            triangle_corner.insert(triangle_corner.end(), {begin, begin + k, begin + k + 1});
        }
    }
    return build_surface(
        {model.shown.positions_rest, mesh.polygon_start, mesh.corner_vertex, triangle_corner});
}

enum Stages { kSolve, kSolveAndNormals, kWholeFrame };

// kSolveAndNormals is the part that the paper times: attachments, 10 iterations and the normals for drawing.
// kWholeFrame also computes the shown frame: stretch attributes and offsets for shaders.
void solve_step(benchmark::State& bench, AttachmentKind kind, Stages stages) {
    const Scene scene(kind);
    const Surface shown = shown_surface(*scene.model);
    Settings settings;
    settings.threads = static_cast<int>(bench.range(0));
    Report report;
    State state = solve(*scene.model, settings, {}, {scene.poses[0]}, nullptr, report);
    Picture picture;
    show(*scene.model, settings, {scene.poses[0]}, state, picture);
    std::vector<Vec3> normals(shown.welded.vertex_count);
    size_t frame = 0;
    double active = 0.0;
    for (auto _ : bench) {
        const std::vector<Vec3>& pose = scene.poses[++frame % scene.poses.size()];
        state = solve(*scene.model, settings, {}, {pose}, &state, report);
        if (report.iterations != 10) bench.SkipWithError("the pose was held");
        if (stages == kWholeFrame) show(*scene.model, settings, {pose}, state, picture);
        if (stages >= kSolveAndNormals) vertex_normals(shown, picture.positions, normals);
        active += report.active;
        benchmark::DoNotOptimize(state.offset.data());
        benchmark::DoNotOptimize(normals.data());
    }
    bench.counters["triangles"] = double(scene.model->triangles.size());
    bench.counters["pairs"] = double(scene.model->distance.size() + scene.model->bending.size());
    bench.counters["active"] = active / double(bench.iterations());
    if (stages == kSolveAndNormals) {
        bench.SetLabel("section 5: attachments + 10 iterations + normals, 32K triangles: 5 ms (2010)");
    }
}
BENCHMARK_CAPTURE(solve_step, paper_linear, AttachmentKind::kLinear, kSolveAndNormals)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve_step, paper_pn, AttachmentKind::kPnTriangle, kSolveAndNormals)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve_step, paper_limit, AttachmentKind::kLimit, kSolveAndNormals)
    ->Arg(1)
    ->Arg(2)
    ->Arg(4)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve_step, only_solve_limit, AttachmentKind::kLimit, kSolve)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve_step, whole_frame_limit, AttachmentKind::kLimit, kWholeFrame)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond);

// Solves on a smooth surface with a number of squares per side, each with 32 triangles, on a number of
// threads.
void solve_on_threads(benchmark::State& bench) {
    const Scene scene(AttachmentKind::kLimit, static_cast<Index>(bench.range(0)));
    Settings settings;
    settings.threads = static_cast<int>(bench.range(1));
    Report report;
    State state = solve(*scene.model, settings, {}, {scene.poses[0]}, nullptr, report);
    size_t frame = 0;
    for (auto _ : bench)
        state =
            solve(*scene.model, settings, {}, {scene.poses[++frame % scene.poses.size()]}, &state, report);
    bench.counters["triangles"] = double(scene.model->triangles.size());
}
BENCHMARK(solve_on_threads)
    ->ArgsProduct({{8, 16, 32, 64, 177, 354}, {1, 2}})
    ->ArgNames({"squares", "threads"})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void build_step(benchmark::State& bench) {
    const auto kind = static_cast<AttachmentKind>(bench.range(0));
    for (auto _ : bench) benchmark::DoNotOptimize(Scene(kind).model.get());
}
BENCHMARK(build_step)
    ->Arg(static_cast<int>(AttachmentKind::kLinear))
    ->Arg(static_cast<int>(AttachmentKind::kLimit))
    ->ArgName("kind")
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rumple

// SPDX-License-Identifier: GPL-3.0-or-later
// Bullet's cloth (btSoftBody) on the scene of wrinkle_mesh.cpp: the same number of nodes, distance and
// bending pairs as links, 10 iterations. It has no attachments, planes or radii. Compiled if Debian's
// libbullet-dev is installed.
#include <BulletSoftBody/btSoftBody.h>
#include <benchmark/benchmark.h>

#include "systems/wrinkle_mesh/wrinkle_mesh.h"
#include "tests/meshes.h"

namespace rumple {
namespace {

using namespace wrinkle_mesh;

void bullet_cloth(benchmark::State& bench) {
    Source source;
    source.kind = Source::Kind::kRegular;
    source.segments = 4;
    const auto model = wrinkle_mesh::build(tests::build(tests::triangulated(tests::grid(32, 32, 0.03f))),
                                           source, AttachmentKind::kLimit, 0);
    btSoftBodyWorldInfo world;
    world.m_gravity.setZero();
    std::vector<btVector3> nodes;
    for (const Vec3& p : model->positions_rest) nodes.emplace_back(p.x, p.y, p.z);
    const std::vector<btScalar> masses(nodes.size(), 1.0f);
    btSoftBody cloth(&world, static_cast<int>(nodes.size()), nodes.data(), masses.data());
    for (const Pairs* pairs : {&model->distance, &model->bending})
        for (size_t i = 0; i < pairs->size(); ++i) cloth.appendLink(pairs->a[i], pairs->b[i]);
    cloth.m_cfg.piterations = 10;
    for (int n = 0; n < cloth.m_nodes.size(); ++n)
        cloth.m_nodes[n].m_x.setX(0.85f * cloth.m_nodes[n].m_x.x());
    for (auto _ : bench) {
        cloth.predictMotion(1.0f / 30.0f);
        cloth.solveConstraints();
        benchmark::DoNotOptimize(cloth.m_nodes[0].m_x);
    }
    bench.counters["links"] = double(cloth.m_links.size());
}
BENCHMARK(bullet_cloth)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rumple

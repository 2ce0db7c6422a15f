// SPDX-License-Identifier: GPL-3.0-or-later
// How far a Wrinkle Mesh may go inwards over a body.
#include <gtest/gtest.h>

#include "systems/wrinkle_mesh/bounds.h"
#include "systems/wrinkle_mesh/pose.h"
#include "tests/contact_bodies.h"
#include "tests/meshes.h"
#include "tests/wrinkle_mesh_stack.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;

// The layers of a stack over a body that is known to be near all of it. gap: how far the cloth may go
// inwards.
LayersState solved_over(const Stack& stack, const Body& body, const Pose3& pose, float gap, float thickness) {
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    const std::vector<float> gaps(pose.size(), gap);
    const std::vector<Index> hint(pose.size(), 0);
    Input input{pose};
    input.gap = gaps;
    input.bodies = &posed;
    input.body_hint = hint;
    input.thickness = thickness;
    return stack.solve(input, alike(stack.count()));
}

float apart(const Pose3& a, const Pose3& b) {
    float most = 0.0f;
    for (size_t v = 0; v < a.size(); ++v) most = std::max(most, glm::distance(a[v], b[v]));
    return most;
}

// The least distance from the x axis of the middles of sides and polygons between x = low and high.
float least_radius(const PolygonMesh& mesh, const std::vector<Vec3>& positions, float low, float high) {
    float least = 1e9f;
    for (Index p = 0; p < mesh.polygons(); ++p) {
        Vec3 middle(0.0f);
        for (Index k = 0, size = mesh.polygon_size(p); k < size; ++k) {
            const auto at = [&](Index c) {
                return positions[mesh.corner_vertex[mesh.polygon_start[p] + c % size]];
            };
            middle += at(k) / float(size);
            const Vec3 side = 0.5f * (at(k) + at(k + 1));
            if (side.x > low && side.x < high) least = std::min(least, std::hypot(side.y, side.z));
        }
        if (middle.x > low && middle.x < high) least = std::min(least, std::hypot(middle.y, middle.z));
    }
    return least;
}

// Skin that ends under a shirt showed as a slit: the vertices beside its end went in as far as where there is
// no body, and the cloth between them cut through it.
TEST(WrinkleMeshBody, TheEndOfABodyStaysBelowTheClothBetweenItsVertices) {
    const MeshData mesh = grid(12, 4, 0.02f);
    Source source;
    source.level = 1;
    const auto model = wrinkle_mesh::build(tests::build(mesh), source, AttachmentKind::kLimit, 0);
    Body body = body_of(grid(10, 10, 0.05f));  // ends at x = 0.1, 8 mm below
    for (Vec3& p : body.positions) p += Vec3(-0.4f, -0.2f, -0.008f);
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    const std::vector<float> gap(mesh.positions.size(), 0.03f);
    const std::vector<Index> hint(mesh.positions.size(), 0);
    Input input{mesh.positions};
    input.gap = gap;
    input.bodies = &posed;
    input.body_hint = hint;
    input.thickness = 0.003f;
    const Pose pose = make_pose(*model, input);
    int over = 0, within = 0, beyond = 0;
    for (size_t v = 0; v < pose.gap.size(); ++v) {
        const float edge = model->local_edge[v], beside = pose.attachment[v].x - 0.1f;
        const float reach = 2.0f * edge + input.thickness;
        if (std::hypot(std::max(beside, 0.0f), 0.008f) > 0.99f * reach) continue;
        const float cone = std::max(beside - edge, 0.0f);
        EXPECT_NEAR(pose.gap[v], 0.005f + cone, 1e-6f) << beside;
        ++(beside <= 0.0f ? over : cone > 0.0f ? beyond : within);
    }
    for (const int count : {over, within, beyond}) EXPECT_GT(count, 4);
}

// A trouser leg slid along itself into the heel, which is not parallel to it: the floor was parallel to the
// cloth.
TEST(WrinkleMeshBody, ClothThatSlidesStaysOffABodyThatIsNotParallel) {
    const Stack stack(grid(12, 6, 0.02f));
    const Vec3 normal =
        glm::normalize(Vec3(-0.6f, 0.0f, 0.8f));  // rises towards +x, and meets z = 0 at x = 0.25
    Body body = body_of(grid(30, 30, 0.02f));
    for (Vec3& p : body.positions)
        p = Vec3(0.25f, -0.2f, 0.0f) + (p.x - 0.5f) * Vec3(0.8f, 0.0f, 0.6f) + Vec3(0, p.y, 0);
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    const std::vector<float> gap(stack.mesh.positions.size(), 0.02f);
    const std::vector<Index> hint(gap.size(), 0);
    Input input{stack.mesh.positions};
    input.gap = gap;
    input.bodies = &posed;
    input.body_hint = hint;
    input.thickness = 0.002f;
    Settings settings;
    settings.inside = 1.0f;
    settings.hem_rings = 0;
    const Model& model = *stack.layers->layers[1];
    input.positions = stack.mesh.positions;
    const Pose pose = make_pose(model, input);
    const Bounds bounds(model, settings, {}, pose);
    int looked_at = 0;
    for (size_t v = 0; v < pose.attachment.size(); ++v) {
        if (pose.body[v] == kNone || pose.gap[v] > 0.01f) continue;
        Vec3 p = pose.attachment[v] + Vec3(0.9f * model.local_edge[v], 0.0f, -pose.gap[v]);
        bounds.project(v, p);
        EXPECT_GT(glm::dot(p - Vec3(0.25f, 0.0f, 0.0f), normal), input.thickness - 1e-5f);
        ++looked_at;
    }
    EXPECT_GT(looked_at, 5);
}

// A garment from a game is cut at its seams: over a body it was refused, as the layers have a vertex for each
// of the welded ones, and the body was told of each of the garment's own.
TEST(WrinkleMeshBody, SeamsAndLooseVerticesChangeNoBit) {
    const MeshData whole = tube(12, 10, 0.06f, 0.3f);
    MeshData cut = whole;
    for (Index j = 0; j <= 10; ++j) cut.positions.push_back(whole.positions[12 * j]);
    for (size_t p = 0; p + 1 < cut.polygon_start.size(); ++p) {
        Index* corner = &cut.corner_vertex[cut.polygon_start[p]];
        if (std::none_of(corner, corner + 4, [](Index v) { return v % 12 == 11; })) continue;
        for (int k = 0; k < 4; ++k)
            if (corner[k] % 12 == 0) corner[k] = 132 + corner[k] / 12;
    }
    cut.positions.insert(cut.positions.begin(), whole.positions[5]);  // loose
    for (Index& v : cut.corner_vertex) ++v;
    const Body body = body_of(tube(12, 10, 0.055f, 0.3f));
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    std::vector<Vec3> solved[2];
    for (const bool is_cut : {false, true}) {
        const Stack stack(is_cut ? cut : whole);
        const Pose3 pose = stack.squeezed(0.85f);
        const std::vector<float> gap(pose.size(), 0.004f);
        const std::vector<Index> hint(pose.size(), 0);
        Input input{pose};
        input.gap = gap;
        input.bodies = &posed;
        input.body_hint = hint;
        input.thickness = 0.002f;
        solved[is_cut] = stack.solve(input, alike(stack.count())).solved;
    }
    EXPECT_EQ(solved[0], solved[1]);
}

// A leather sleeve has wide folds, so few vertices: these were off the forearm, which showed between them.
TEST(WrinkleMeshBody, WhatLiesBetweenVerticesThatAreShownIsOffTheBodyToo) {
    const float radius = 0.04f, thickness = 0.003f;
    const Body body = body_of(tube(120, 60, radius, 0.4f));
    for (const Index around : {5, 6}) {
        const MeshData mesh = tube(around, 12, 0.05f, 0.4f);
        const Stack stack(mesh, 1);
        const LayersState state = solved_over(stack, body, mesh.positions, 0.0f, thickness);
        const PolygonMesh &finest = stack.layers->layers.back()->solved, &shown = stack.layers->shown.mesh;
        const Picture picture = stack.show(mesh.positions, mesh.positions, state);
        // Half of the thickness, but for what is of fourth order in the angle between vertices.
        const float off = radius + 0.45f * thickness;
        EXPECT_GT(least_radius(finest, state.solved, 0.08f, 0.32f), off) << around;
        EXPECT_GT(least_radius(shown, picture.positions, 0.08f, 0.32f), off) << around;
    }
}

// Cloth goes out along its own normal, by what is missing along the body's: on a forearm that is turned in
// its sleeve that was too little.
TEST(WrinkleMeshBody, ClothThatGoesOutOfABodyAslantIsOut) {
    const MeshData mesh = grid(12, 12, 0.02f);
    const Stack stack(mesh, 1);
    const float thickness = 0.003f;
    for (const float angle : {0.0f, 0.5f, 0.8f}) {
        const Vec3 normal(-std::sin(angle), 0.0f, std::cos(angle)), through(0.1f, 0.0f, 0.0f);
        Body body = body_of(grid(30, 30, 0.03f));
        for (Vec3& p : body.positions)
            p = through + (p.x - 0.45f) * Vec3(normal.z, 0.0f, -normal.x) + Vec3(0.0f, p.y - 0.3f, 0.0f);
        const LayersState state = solved_over(stack, body, mesh.positions, 0.02f, thickness);
        int put_out = 0;
        float least = 1e9f;
        for (size_t v = 0; v < state.solved.size(); ++v) {
            const float before = glm::dot(stack.layers->layers[1]->positions_rest[v] - through, normal);
            if (before > 0.0f || before < -0.01f) continue;
            least = std::min(least, glm::dot(state.solved[v] - through, normal));
            ++put_out;
        }
        EXPECT_GT(least, 0.99f * thickness) << angle;
        EXPECT_GT(put_out, 20) << angle;
    }
}

// Trousers that were cut wider had a knob on the front at rest: cloth that lies on hips is no wider than
// these.
TEST(WrinkleMeshBody, ClothThatLiesOnABodyHasNothingToSpareUntilItIsPressedTogether) {
    const Stack stack(tube(20, 24, 0.06f, 0.5f));
    const Body body = body_of(tube(20, 24, 0.055f, 0.5f));
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    const auto solved = [&](const Pose3& pose, float gap, Index hint, float prestretch) {
        const std::vector<float> gaps(pose.size(), gap);
        const std::vector<Index> hints(pose.size(), hint);
        Input input{pose};
        input.gap = gaps;
        input.bodies = &posed;
        input.body_hint = hints;
        input.thickness = 0.002f;
        Settings settings;
        settings.prestretch = prestretch;
        return stack.solve(input, alike(stack.count(), settings)).solved;
    };
    const auto changes = [&](const Pose3& pose, float gap, Index hint) {
        return apart(solved(pose, gap, hint, 1.04f), solved(pose, gap, hint, 1.0f));
    };
    const Pose3 rest = stack.mesh.positions, squeezed = stack.squeezed(0.85f);
    EXPECT_EQ(changes(rest, 0.0f, 0), 0.0f);
    EXPECT_GT(changes(rest, 0.006f, 0), 1e-3f);    // three thicknesses: all of it
    EXPECT_GT(changes(rest, 0.0f, kNone), 1e-3f);  // nothing is known of the body there
    EXPECT_LT(changes(rest, 0.002f, 0), changes(rest, 0.006f, 0));
    // Cloth that is tighter than the body stays so.
    EXPECT_GT(apart(solved(squeezed, 0.0f, 0, 0.9f), solved(squeezed, 0.0f, 0, 1.0f)), 1e-3f);
    Settings flat;
    flat.radius = 0.0f;
    const Pose3 unfolded = stack.solve({squeezed}, alike(stack.count(), flat)).solved;
    EXPECT_GT(apart(solved(squeezed, 0.0f, 0, 1.0f), unfolded), 1e-3f);
}

// Fabrics that are cut wide had a knob between the legs: cloth that fits the hips had all of the extra width
// a few centimetres below.
TEST(WrinkleMeshBody, ExtraWidthRisesSlowlyBesideClothThatLiesOnABody) {
    const Stack stack(grid(8, 4, 0.1f), 0);
    const Body body = body_of(grid(8, 4, 0.1f));
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    const Pose3& rest = stack.mesh.positions;
    std::vector<float> gaps(rest.size());
    for (size_t v = 0; v < rest.size(); ++v) gaps[v] = rest[v].x - rest[0].x < 0.05f ? 0.0f : 0.05f;
    const std::vector<Index> hints(rest.size(), 0);
    Input input{rest};
    input.gap = gaps;
    input.bodies = &posed;
    input.body_hint = hints;
    input.thickness = 0.002f;
    const std::vector<float> share = share_to_spare(stack.layers->base, input, 0.4f);
    const std::vector<float> at_once = share_to_spare(stack.layers->base, input, 0.0f);
    for (size_t v = 0; v < rest.size(); ++v) {
        const float from_touch = rest[v].x - rest[0].x;
        EXPECT_NEAR(share[v], std::min(from_touch / 0.4f, 1.0f), 1e-6f);
        EXPECT_EQ(at_once[v], from_touch < 0.05f ? 0.0f : 1.0f);
    }

    std::vector<Settings> layers(2);
    layers[0].bend_radius = 0.2f;
    layers[1].prestretch = 1.14f;
    EXPECT_NEAR(length_to_spare(layers), 0.4f, 1e-6f);  // 7 % over every bend radius
    layers[0].bend_radius = 0.0f;
    EXPECT_EQ(length_to_spare(layers), 0.0f);
    layers[0].bend_radius = 0.2f;
    layers[1].prestretch = 0.9f;
    EXPECT_EQ(length_to_spare(layers), 0.0f);

    // The layers use it: beside cloth that lies on the body they change less.
    const auto changed = [&](float bend_radius) {
        Settings settings;
        settings.bend_radius = bend_radius;
        const Pose3 as_cut = stack.solve(input, alike(stack.count(), settings)).solved;
        settings.prestretch = 1.01f;
        const Pose3 wide = stack.solve(input, alike(stack.count(), settings)).solved;
        float sum = 0.0f;
        for (size_t v = 0; v < rest.size(); ++v)
            if (rest[v].x - rest[0].x < 0.15f) sum += glm::distance(wide[v], as_cut[v]);
        return sum;
    };
    EXPECT_LT(changed(2.8f), 0.7f * changed(0.0f));
}

// Hips of trousers had the wide folds of their legs. A wide fold has no room where cloth touches what is
// under it.
TEST(WrinkleMeshBody, ClothThatTouchesABodyGathersItsShareAndAllOfItWithRoomForAnEdge) {
    const Stack stack(grid(10, 8, 0.04f), 0);
    const Pose3 pose = stack.squeezed(0.5f);
    const auto solved = [&](float gap, float limit, float contact_gather) {
        const std::vector<float> gaps(pose.size(), gap);
        Input input{pose};
        input.gap = gaps;
        Settings settings;
        settings.compression_limit = limit;
        settings.contact_gather = contact_gather;
        return stack.solve(input, alike(stack.count(), settings)).solved;
    };
    EXPECT_EQ(solved(0.0f, 1.5f, 0.5f), solved(0.0f, 1.25f, 1.0f));
    EXPECT_EQ(solved(0.0f, 1.5f, 0.0f), solved(0.0f, 1.0f, 1.0f));
    EXPECT_EQ(solved(0.05f, 1.5f, 0.5f), solved(0.05f, 1.5f, 1.0f));
    const auto least = solved(0.01f, 1.25f, 1.0f), most = solved(0.01f, 1.5f, 1.0f);
    const auto between = solved(0.01f, 1.5f, 0.5f);
    EXPECT_GT(apart(between, least), 1e-3f);
    EXPECT_GT(apart(between, most), 1e-3f);
}

// The inner side of thick cloth stays off the body by the thickness, so the cloth by so much more.
TEST(WrinkleMeshBody, AnInnerSideStaysOffTheBodyToo) {
    const Stack stack(tube(20, 24, 0.06f, 0.5f), 1);
    const Body body = body_of(tube(40, 24, 0.058f, 0.5f));
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    const std::vector<float> gaps(stack.mesh.positions.size(), 0.0f);
    const std::vector<Index> hints(stack.mesh.positions.size(), 0);
    for (const float inner : {0.0f, 0.01f}) {
        Input input{stack.mesh.positions};
        input.gap = gaps;
        input.bodies = &posed;
        input.body_hint = hints;
        input.thickness = 0.002f;
        input.inner = inner;
        const Pose3 solved = stack.solve(input, alike(stack.count())).solved;
        float least = 1e9f;
        for (const Vec3& p : solved)
            if (p.x > 0.1f && p.x < 0.4f) least = std::min(least, std::hypot(p.y, p.z));
        EXPECT_GT(least, 0.058f + inner + 0.001f) << inner;
        EXPECT_LT(least, 0.058f + inner + 0.006f) << inner;
    }
}

// Bodies below and ahead, and the cloth itself, are looked for on threads.
TEST(WrinkleMeshBody, ThreadsThatLookForItChangeNoBit) {
    const Stack stack(tube(20, 24, 0.06f, 0.5f));
    Body body = body_of(tube(20, 24, 0.055f, 0.5f));
    const Body beside = body_of(tube(20, 24, 0.02f, 0.5f));
    const Index first = static_cast<Index>(body.positions.size());
    for (const Vec3& p : beside.positions) body.positions.push_back(p + Vec3(0.0f, 0.085f, 0.0f));
    for (const auto& [a, b, c] : beside.triangles)
        body.triangles.push_back({a + first, b + first, c + first});
    const Collider collider = body.collider();
    const PosedCollider posed(collider, body.positions);
    const Pose3 pose = stack.squeezed(0.85f);
    const std::vector<float> gap(pose.size(), 0.004f);
    const std::vector<Index> hint(pose.size(), 0);
    Input input{pose};
    input.gap = gap;
    input.bodies = &posed;
    input.body_hint = hint;
    input.thickness = 0.002f;
    std::vector<Vec3> alone;
    for (const int threads : {1, 2, 3, 5}) {
        wrinkle_mesh::Settings settings{.threads = threads};
        settings.apart = settings.slide = 0.45f;
        std::vector<Report> reports;
        const LayersState state = stack.solve(input, alike(stack.count(), settings), nullptr, &reports);
        EXPECT_GT(reports.back().kept_apart, 0);
        if (threads == 1) alone = state.solved;
        EXPECT_EQ(state.solved, alone) << threads;
    }
}

}  // namespace
}  // namespace rumple::tests

// SPDX-License-Identifier: GPL-3.0-or-later
// Where a vertex of the Wrinkle Mesh may be: within its radius, before its plane, and nowhere that is not a
// number.
#include <gtest/gtest.h>

#include "base/random.h"
#include "systems/wrinkle_mesh/bounds.h"
#include "tests/wrinkle_mesh_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;

// A held vertex is put back when it leaves its bounds by more than this share of its radius.
constexpr float kSlack = 1.1e-3f;

struct Attached {
    Pose3 points;
    Pose3 normals;
};

Attached attachments_of(const Model& model, const Pose3& pose) {
    Pose3 base(model.base.welded.vertex_count), base_normals(base.size());
    weld_positions(model.base, pose, base);
    vertex_normals(model.base, base, base_normals);
    Attached out;
    out.points.resize(model.attached.size());
    attach(model.base, model.attachments, base, base_normals, out.points);
    for (const SurfacePoint& place : model.attachments.places) {
        const Vec3 normal = interpolate(model.base, place, base_normals);
        out.normals.push_back(glm::length(normal) > 1e-3f ? glm::normalize(normal) : Vec3(0.0f));
    }
    return out;
}

// Without seams and display steps the picture is the solved mesh.
void expect_within_bounds(const Cloth& cloth, const Settings& settings, const Pose3& pose, const State& state,
                          const glm::mat3& world_from_object = glm::mat3(1.0f)) {
    Picture picture;
    show(*cloth.model, settings, {pose, world_from_object}, state, picture);
    const Attached at = attachments_of(*cloth.model, pose);
    for (size_t v = 0; v < picture.positions.size(); ++v) {
        const float radius = settings.radius * cloth.model->local_edge[v];
        const Vec3 offset = picture.positions[v] - at.points[v];
        ASSERT_LE(glm::length(offset), (1.0f + kSlack) * radius + kRounding) << "vertex " << v;
        const float depth = settings.inside * radius;
        ASSERT_GE(glm::dot(offset, at.normals[v]), -depth - kSlack * radius - kRounding) << "vertex " << v;
    }
}

class EveryAttachmentBounds : public testing::TestWithParam<AttachmentKind> {};

TEST_P(EveryAttachmentBounds, NoVertexLeavesItsRadiusOrItsPlaneInAnyPose) {
    for (const MeshData& mesh : {tube(12, 10, 0.1f, 0.5f), grid(10, 6, 0.05f)}) {
        const Cloth cloth(mesh, 2, GetParam());
        Settings settings;
        settings.hem_rings = 0;
        for (const float inside : {0.0f, 0.4f}) {
            settings.inside = inside;
            State warm = cloth.solve(mesh.positions, settings);
            for (const Pose3& pose :
                 {cloth.squeezed(0.8f), cloth.squeezed(0.6f, 2.0f), cloth.sheared(0.7f),
                  cloth.folded(0.25f, 1.2f), cloth.folded(0.25f, 2.6f), cloth.folded(0.25f, -2.0f)}) {
                expect_within_bounds(cloth, settings, pose, cloth.solve(pose, settings));
                warm = cloth.solve(pose, settings, &warm);
                expect_within_bounds(cloth, settings, pose, warm);
            }
        }
    }
}

// The pairs of a held vertex keep their length, and yet its normal turns when the base bends beside it.
TEST_P(EveryAttachmentBounds, AHeldVertexDoesNotFallBehindAPlaneThatTurns) {
    const Cloth cloth(grid(4, 4, 0.1f), 3, GetParam());
    Settings settings;
    settings.hem_rings = 0;
    const Pose3 squeezed = cloth.squeezed(0.75f);
    State state = cloth.solve(squeezed, settings);
    bool some_held = false;
    for (int step = 1; step <= 12; ++step) {
        Pose3 pose = squeezed;
        for (Vec3& p : pose) {
            const float x = std::max(p.x - 0.15f, 0.0f), angle = 0.15f * float(step);
            p = {p.x - x + x * std::cos(angle), p.y, x * std::sin(angle)};
        }
        Report report;
        state = cloth.solve(pose, settings, &state, &report);
        some_held |= report.active < 1.0f;
        expect_within_bounds(cloth, settings, pose, state);
    }
    EXPECT_TRUE(some_held);
}

TEST_P(EveryAttachmentBounds, ASmallerRadiusHoldsInAHeldPoseToo) {
    const Cloth cloth(tube(12, 10, 0.1f, 0.5f), 2, GetParam());
    Settings settings;
    settings.hem_rings = 0;
    const Pose3 pose = cloth.squeezed(0.75f);
    State state = cloth.solve(pose, settings);
    settings.radius = 0.3f;
    state = cloth.solve(pose, settings, &state);
    expect_within_bounds(cloth, settings, pose, state);
}

INSTANTIATE_TEST_SUITE_P(WrinkleMesh, EveryAttachmentBounds,
                         testing::Values(AttachmentKind::kLinear, AttachmentKind::kPnTriangle,
                                         AttachmentKind::kLimit));

TEST(WrinkleMeshBounds, OffsetsInWorldSpaceStayBeforeThePlaneOfATurningObject) {
    const Cloth cloth(tube(12, 10, 0.1f, 0.5f));
    Settings settings;
    settings.hem_rings = 0;
    settings.offset_space = OffsetSpace::kWorld;
    const Pose3 pose = cloth.squeezed(0.75f);
    Report report;
    State state;
    for (int step = 0; step < 7; ++step) {
        const float angle = 0.5f * float(step);
        const glm::mat3 world(1, 0, 0, 0, std::cos(angle), std::sin(angle), 0, -std::sin(angle),
                              std::cos(angle));
        state = solve(*cloth.model, settings, {}, {pose, world}, step ? &state : nullptr, report);
        expect_within_bounds(cloth, settings, pose, state, world);
    }
    EXPECT_GT(largest(state.offset), 1e-3f);
}

TEST(WrinkleMeshBounds, NeighbourhoodCollisionStaysAboveItsFloor) {
    const Cloth cloth(grid(8, 8, 0.05f), 2, AttachmentKind::kLinear);
    Settings settings;
    settings.collision = Collision::kNeighbourhood;
    settings.inside = 0.2f;
    const State state = cloth.solve(cloth.squeezed(0.8f), settings);
    float deepest = 0.0f;
    for (size_t v = 0; v < state.offset.size(); ++v) {
        EXPECT_GE(state.offset[v].z, -0.2f * cloth.model->local_edge[v] - kRounding);
        deepest = std::min(deepest, state.offset[v].z);
    }
    EXPECT_LT(deepest, 0.0f);
}

// The bound by the cloth itself pushes vertices below their floor; were they left there, a held vertex would
// be pushed to and fro in every frame.
TEST(WrinkleMeshBounds, AVertexPutWithinItsBoundsIsWithinAllOfThem) {
    const Cloth cloth(tube(12, 10, 0.1f, 0.5f));
    const Model& model = *cloth.model;
    const SelfContactMesh mesh(model.positions_rest, model.triangles);
    Settings settings;
    settings.apart = settings.slide = 0.45f;
    for (const Collision collision : {Collision::kPlane, Collision::kNeighbourhood}) {
        settings.collision = collision;
        int moved = 0, bounded = 0;
        for (const Pose3& base :
             {cloth.squeezed(0.6f, 2.0f), cloth.folded(0.25f, 2.6f), cloth.folded(0.25f, -2.0f)}) {
            Pose pose = make_pose(model, {base});
            const PosedSelfContactMesh posed(mesh, pose.attachment);
            std::vector<float> reach = attachment_radii(model, settings, {});
            for (float& r : reach) r /= settings.apart;
            pose.self_contact = posed.facing(reach);
            pose.heights = posed.heights();
            const Bounds bounds(model, settings, {}, pose);
            for (size_t v = 0; v < pose.attachment.size(); ++v) {
                for (std::uint32_t n = 0; n < 20; ++n) {
                    const auto random = [&](std::uint32_t axis) { return noise(axis, 20 * Index(v) + n); };
                    const Vec3 asked = pose.attachment[v] +
                                       1.2f * model.local_edge[v] * Vec3(random(0), random(1), random(2));
                    Vec3 p = asked;
                    bounds.project(v, p);
                    moved += p != asked;
                    ASSERT_FALSE(bounds.push_back(v, p)) << v << ", " << n;
                    // Where the cloth touches or crosses itself, a layer adds nothing.
                    const float most = settings.apart * pose.self_contact[v].in_any_direction;
                    ASSERT_LE(glm::distance(p, pose.attachment[v]), most + kRounding) << v << ", " << n;
                    bounded += std::isfinite(most);
                }
            }
        }
        EXPECT_GT(moved, 1000);
        EXPECT_GT(bounded, 1000);
    }
}

TEST(WrinkleMeshBounds, WithoutCollisionFoldsGoToBothSidesAlike) {
    const Cloth cloth(grid(12, 12, 0.05f), 2, AttachmentKind::kLinear);
    Settings settings;
    settings.collision = Collision::kNone;
    float low = 0.0f, high = 0.0f;
    for (const Vec3& o : cloth.solve(cloth.squeezed(0.8f), settings).offset) {
        low = std::min(low, o.z);
        high = std::max(high, o.z);
    }
    EXPECT_NEAR(-low / high, 1.0f, 0.2f);
}

TEST(WrinkleMeshBounds, PaintOfZeroHoldsAVertexAtItsAttachment) {
    const Cloth cloth(tube(12, 10, 0.1f, 0.5f));
    Paint paint;
    paint.radius.assign(cloth.model->attached.size(), 1.0f);
    for (size_t v = 40; v < 400; v += 7) paint.radius[v] = 0.0f;
    Report report;
    State state = solve(*cloth.model, Settings{}, paint, {cloth.squeezed(0.75f)}, nullptr, report);
    EXPECT_GT(largest(state.offset), 1e-3f);
    for (size_t v = 40; v < 400; v += 7) EXPECT_EQ(state.offset[v], Vec3(0.0f)) << v;
    state = solve(*cloth.model, Settings{}, paint, {cloth.squeezed(0.65f)}, &state, report);
    for (size_t v = 40; v < 400; v += 7) EXPECT_EQ(state.offset[v], Vec3(0.0f)) << v;
}

// A float attribute from 0 to 1, carried to the finest layer, was -1e-17 in places: bounds whose ends had
// changed places made positions that are no numbers.
TEST(WrinkleMeshBounds, PaintBelowZeroIsZero) {
    const Cloth cloth(tube(12, 10, 0.1f, 0.5f));
    Settings settings;
    settings.slide = 0.45f;
    settings.apart = 0.45f;
    settings.tangential_pull = 0.2f;
    std::vector<Vec3> offset[2];
    for (int below = 0; below < 2; ++below) {
        Paint paint;
        paint.radius.assign(cloth.model->attached.size(), 1.0f);
        for (size_t v = 40; v < 400; v += 7) paint.radius[v] = below ? -1.4e-17f : 0.0f;
        Report report;
        offset[below] = solve(*cloth.model, settings, paint, {cloth.squeezed(0.75f)}, nullptr, report).offset;
    }
    EXPECT_TRUE(all_finite(offset[1]));
    EXPECT_GT(largest(offset[1]), 1e-3f);
    EXPECT_EQ(offset[0], offset[1]);
}

void expect_finite(const Cloth& cloth, const Settings& settings, const Pose3& pose, const State& state) {
    const Picture picture = cloth.show(pose, settings, state);
    ASSERT_TRUE(all_finite(state.offset));
    ASSERT_TRUE(all_finite(picture.positions));
    ASSERT_TRUE(all_finite(picture.offset));
    ASSERT_TRUE(all_finite(picture.local_offset));
    ASSERT_TRUE(all_finite(picture.stretch.direction));
    for (size_t v = 0; v < picture.positions.size(); ++v) {
        ASSERT_TRUE(std::isfinite(picture.stretch.minimum[v]) && std::isfinite(picture.stretch.maximum[v]));
    }
    const Measures measures = measure(*cloth.model, settings, {}, {pose}, state);
    EXPECT_TRUE(std::isfinite(measures.edge_error_after_rms) &&
                std::isfinite(measures.compressed_area_after));
}

TEST(WrinkleMeshBounds, CollapsedPosesGiveFiniteResultsAndAreLeftAgain) {
    for (const AttachmentKind kind :
         {AttachmentKind::kLinear, AttachmentKind::kPnTriangle, AttachmentKind::kLimit}) {
        const Cloth cloth(grid(4, 4, 0.1f), 2, kind, 1);
        Pose3 pinched = cloth.mesh.positions, needle = pinched;
        pinched[6] = pinched[7];  // a zero-length edge, a collapsed triangle
        const Pose3 point = cloth.moved([](const Vec3&) { return Vec3(1.0f, 2.0f, 3.0f); });
        for (Vec3& p : needle) p.y = 0.0f;
        for (const Collision collision : {Collision::kPlane, Collision::kNeighbourhood}) {
            for (const OffsetSpace space : {OffsetSpace::kTriangle, OffsetSpace::kWorld}) {
                Settings settings;
                settings.collision = collision;
                settings.offset_space = space;
                for (const Pose3& pose : {pinched, point, needle}) {
                    Report report;
                    State state = cloth.solve(pose, settings, nullptr, &report);
                    EXPECT_GT(report.collapsed_triangles, 0);
                    EXPECT_TRUE(std::isfinite(report.error_before) && std::isfinite(report.largest_error));
                    expect_finite(cloth, settings, pose, state);
                    state = cloth.solve(cloth.squeezed(0.8f), settings, &state);
                    expect_finite(cloth, settings, cloth.squeezed(0.8f), state);
                    state = cloth.solve(pose, settings, &state);
                    expect_finite(cloth, settings, pose, state);
                }
            }
        }
    }
}

TEST(WrinkleMeshBounds, ACollapsedRestPoseGivesFiniteResults) {
    MeshData mesh = grid(4, 4, 0.1f);
    mesh.positions[6] = mesh.positions[7];
    const Surface own = tests::build(grid(9, 9, 0.045f));
    Source source;
    source.own = &own;
    for (const AttachmentKind kind :
         {AttachmentKind::kLinear, AttachmentKind::kPnTriangle, AttachmentKind::kLimit}) {
        for (const Cloth& cloth : {Cloth(mesh, 2, kind), Cloth(mesh, source, kind)}) {
            for (const Pose3& pose : {mesh.positions, cloth.squeezed(0.8f), grid(4, 4, 0.1f).positions}) {
                expect_finite(cloth, Settings{}, pose, cloth.solve(pose, Settings{}));
            }
        }
    }
}

}  // namespace
}  // namespace rumple::tests

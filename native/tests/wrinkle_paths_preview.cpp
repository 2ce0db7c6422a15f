// SPDX-License-Identifier: GPL-3.0-or-later
// What the viewport draws: chapter 7 of Gillette 2015.
#include <gtest/gtest.h>

#include <bit>

#include "systems/wrinkle_paths/preview.h"
#include "tests/wrinkle_paths_cloth.h"

namespace rumple::tests {
namespace {

using wrinkle_paths::Drawing;
using wrinkle_paths::Drawn;
using wrinkle_paths::State;

constexpr float kLength = 0.5f;

MeshData sleeve_of_quads() {
    return tube(24, 20, 0.06f, kLength);
}

// The same with every seventh quad as two triangles.
MeshData sleeve_with_triangles() {
    const MeshData quads = sleeve_of_quads();
    MeshData mesh;
    mesh.positions = quads.positions;
    for (size_t c = 0; c < quads.corner_vertex.size(); c += 4) {
        const Index* v = &quads.corner_vertex[c];
        if (c % 28 == 0) {
            mesh.add_polygon({v[0], v[1], v[2]});
            mesh.add_polygon({v[0], v[2], v[3]});
        } else {
            mesh.add_polygon({v[0], v[1], v[2], v[3]});
        }
    }
    return mesh;
}

// A bent sleeve with folds at its elbow.
struct BentSleeve {
    MeshData mesh;
    std::shared_ptr<const wrinkle_paths::Model> model;
    wrinkle_paths::Settings settings;
    Pose3 pose;
    State state;
    Drawing drawing;

    explicit BentSleeve(AttachmentKind attachment = AttachmentKind::kLimit, MeshData of = sleeve_of_quads())
        : mesh(std::move(of)) {
        const PathCloth cloth(mesh);
        FineSource source;
        source.level = 2;
        model = wrinkle_paths::build(tests::build(mesh), source, attachment);
        settings = cloth.settings;
        settings.hem_rings = 2;
        const auto at = [&](double t) { return cloth.bent(1.5f * float(std::min(t, 1.0)), kLength); };
        wrinkle_paths::Report report;
        wrinkle_paths::Input input;
        for (int f = 0; f <= 40; ++f) {
            pose = at(f / 30.0);
            input.positions = pose;
            input.frame_time.time = f / 30.0;
            state = wrinkle_paths::solve(*model, settings, {}, input, make_pose(*model, pose),
                                         f ? &state : nullptr, report);
        }
        drawing = draw(*model, settings, input, make_pose(*model, pose), state);
    }
    wrinkle_paths::Picture show() const {
        wrinkle_paths::Picture picture;
        wrinkle_paths::show(*model, settings, make_pose(*model, pose), state, picture);
        return picture;
    }
    Drawn at(const SurfacePoint& place) const { return drawn_at(*model, settings, drawing, place); }
    bool folds(Index triangle) const {
        return drawing.lists.triangle_start[triangle] < drawing.lists.triangle_start[triangle + 1];
    }
};

// The place at `share` of a half-edge of the net.
SurfacePoint on_edge(Index half_edge, float fraction) {
    const float b[3] = {1.0f - fraction, fraction, 0.0f};
    const Index k = half_edge % 3;
    return {half_edge / 3, b[(4 - k) % 3], b[(5 - k) % 3]};
}

TEST(PathPreview, HasTheHeightsOfTheFineMeshToTheBit) {
    const BentSleeve sleeve;
    ASSERT_GT(sleeve.state.paths.size(), 2u);
    const wrinkle_paths::Picture picture = sleeve.show();
    const auto& places = sleeve.model->attachments.places;
    ASSERT_EQ(picture.height.size(), places.size());
    for (size_t v = 0; v < places.size(); ++v) EXPECT_EQ(sleeve.at(places[v]).height, picture.height[v]) << v;
}

TEST(PathPreview, OnFlatTrianglesIsTheFineMesh) {
    for (const AttachmentKind kind : {AttachmentKind::kLinear, AttachmentKind::kPnTriangle}) {
        const BentSleeve sleeve(kind);
        const wrinkle_paths::Picture picture = sleeve.show();
        const auto& places = sleeve.model->attachments.places;
        for (size_t v = 0; v < places.size(); ++v)
            EXPECT_LT(glm::distance(sleeve.at(places[v]).position, picture.positions[v]), 1e-6f) << v;
    }
}

TEST(PathPreview, OnTheLimitSurfaceIsNearTheFineMesh) {
    struct Case {
        MeshData mesh;
        float most_mean;  // object units; edges are 2 cm long
    };
    for (const auto& [mesh, most_mean] :
         {Case{sleeve_of_quads(), 5e-4f}, Case{sleeve_with_triangles(), 6e-4f}}) {
        const BentSleeve sleeve(AttachmentKind::kLimit, mesh);
        const wrinkle_paths::Picture picture = sleeve.show();
        const auto& places = sleeve.model->attachments.places;
        float sum = 0.0f;
        for (size_t v = 0; v < places.size(); ++v) {
            const float off = glm::distance(sleeve.at(places[v]).position, picture.positions[v]);
            const bool corner = std::ranges::max(places[v].weights()) == 1.0f;
            if (corner) {  // the limit of a coarse vertex is exact
                EXPECT_LT(off, 1e-6f) << v;
            }
            sum += off;
        }
        EXPECT_LT(sum / float(places.size()), most_mean);
    }
}

TEST(PathPreview, TheStandInIsTheSmoothSurfaceAtTheVertices) {
    const BentSleeve sleeve;
    for (size_t v = 0; v < sleeve.pose.size(); ++v)
        EXPECT_EQ(sleeve.drawing.proxy_offset[v], sleeve.drawing.smooth[v] - sleeve.pose[v]);
}

TEST(PathPreview, NeighboursCutTheirEdgeIntoTheSameParts) {
    const BentSleeve sleeve;
    const auto& net = sleeve.model->triangles.net;
    const auto parts = [&](Index h) { return sleeve.drawing.parts[size_t(h / 3)].edges[size_t(h % 3)]; };
    for (Index h = 0; h < Index(net.twin.size()); ++h) {
        EXPECT_TRUE(std::has_single_bit(unsigned(parts(h))));
        EXPECT_LE(parts(h), sleeve.drawing.parts[size_t(h / 3)].triangle);
        if (net.twin[h] != kNone) {
            EXPECT_EQ(parts(h), parts(net.twin[h])) << h;
        }
    }
}

TEST(PathPreview, TrianglesAreCutSmallEnoughWhereFoldsAreAndOnlyThere) {
    const BentSleeve sleeve(AttachmentKind::kLinear);
    const auto& net = sleeve.model->triangles.net;
    Index cut = 0;
    for (Index t = 0; t < net.triangles(); ++t) {
        const auto& parts = sleeve.drawing.parts[size_t(t)];
        cut += parts.triangle > 1;
        if (!sleeve.folds(t)) {
            EXPECT_EQ(parts.triangle, 1) << t;
        }
        for (Index k = 0; k < 3; ++k) {
            const Index h = 3 * t + k, twin = net.twin[h];
            const bool both = sleeve.folds(t) && (twin == kNone || sleeve.folds(twin / 3));
            const Vec3 a = sleeve.drawing.flat[net.vertex[h]],
                       b = sleeve.drawing.flat[net.vertex[next_in_triangle(h)]];
            if (!both) {
                EXPECT_EQ(parts.edges[size_t(k)], 1);
            } else if (parts.edges[size_t(k)] < wrinkle_paths::kMostParts) {
                const float longest = 3.0f / 8.0f * sleeve.settings.width;  // section 7.3
                EXPECT_LE(glm::distance(a, b) / float(parts.edges[size_t(k)]), 1.001f * longest);
            }
        }
    }
    EXPECT_GT(cut, 20);
    EXPECT_LT(cut, net.triangles() / 2);
}

TEST(PathPreview, BothSidesOfAnEdgeHaveTheSamePoints) {
    const BentSleeve sleeve;
    const auto& net = sleeve.model->triangles.net;
    float highest = 0.0f;
    for (Index h = 0; h < Index(net.twin.size()); ++h) {
        if (net.twin[h] == kNone) continue;
        const bool border = sleeve.folds(h / 3) != sleeve.folds(net.twin[h] / 3);
        for (const float fraction : {0.25f, 0.5f}) {
            const Drawn here = sleeve.at(on_edge(h, fraction)),
                        there = sleeve.at(on_edge(net.twin[h], 1.0f - fraction));
            EXPECT_LT(glm::distance(here.position, there.position), 1e-6f) << h;
            if (border) {  // nothing to tear
                EXPECT_LT(std::abs(here.height), 1e-6f) << h;
            }
            highest = std::max(highest, here.height);
        }
    }
    EXPECT_GT(highest, 0.1f * sleeve.settings.width);
}

TEST(PathPreview, TheNormalOfOneFoldIsSquareToIt) {
    const BentSleeve sleeve;
    int seen = 0;
    for (Index t = 0; t < sleeve.model->triangles.net.triangles(); ++t) {
        const auto& lists = sleeve.drawing.lists;
        const SurfacePoint place{t, 0.3f, 0.4f};
        const Drawn drawn = sleeve.at(place);
        EXPECT_NEAR(glm::length(drawn.normal), 1.0f, 1e-5f);
        const Vec3 p = interpolate(sleeve.model->base, place, sleeve.drawing.flat),
                   n = glm::normalize(interpolate(sleeve.model->base, place, sleeve.drawing.normal));
        int folds = 0;
        Vec3 gradient(0.0f);
        for (Index r = lists.triangle_start[t]; r < lists.triangle_start[t + 1]; ++r) {
            for (Index i = lists.ranges[r][0]; i < lists.ranges[r][1]; ++i) {
                const auto fold = formulas::fold_height(0, lists.ends[i], lists.ends[i + 1], p);
                if (fold.height == 0.0f) continue;
                ++folds;
                gradient = fold.gradient;
            }
        }
        if (folds == 0) {
            EXPECT_LT(glm::distance(drawn.normal, n), 1e-6f);
        }
        if (folds != 1 || drawn.height < 1e-4f) continue;
        ++seen;
        gradient -= glm::dot(gradient, n) * n;
        // Up the slope the surface rises by the gradient's length.
        const Vec3 uphill = gradient + glm::dot(gradient, gradient) * n;
        EXPECT_NEAR(glm::dot(drawn.normal, uphill), 0.0f, 1e-5f);
    }
    EXPECT_GT(seen, 10);
}

TEST(PathPreview, NormalsOfFoldsAreAveragedByTheirHeights) {
    const Vec3 up(0.0f, 0.0f, 1.0f);
    const formulas::FoldHeight east{3.0f, Vec3(1.0f, 0.0f, 0.0f)}, north{-1.0f, Vec3(0.0f, 1.0f, 0.5f)};
    const auto blend =
        formulas::with_fold(formulas::with_fold(formulas::no_folds(), east, up, 1.0f), north, up, 1.0f);
    EXPECT_EQ(blend.height, 3.0f);
    const Vec3 mean(-3.0f, -1.0f, 4.0f);  // of (-1, 0, 1) three times and (0, -1, 1) once: both as long
    EXPECT_LT(glm::distance(formulas::blended_normal(blend, up), glm::normalize(mean)), 1e-6f);
    EXPECT_EQ(formulas::blended_normal(formulas::no_folds(), up), up);
}

}  // namespace
}  // namespace rumple::tests

// SPDX-License-Identifier: GPL-3.0-or-later
// Bad input to the Wrinkle Mesh: refused, with a message that names what is bad.
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "base/expect.h"
#include "tests/refusals.h"
#include "tests/wrinkle_mesh_cloth.h"

namespace rumple::tests {
namespace {

using namespace wrinkle_mesh;

struct Range {
    const char* name;
    std::function<void(Settings&, float)> set;
    float low;
    float high;
    bool whole;  // takes whole numbers only
};

const std::vector<Range> kRanges = {
    {"radius", [](Settings& s, float x) { s.radius = x; }, 0.0f, 1e6f, false},
    {"prestretch", [](Settings& s, float x) { s.prestretch = x; }, 1e-3f, 1e3f, false},
    {"bending", [](Settings& s, float x) { s.bending = x; }, 0.0f, 1.0f, false},
    {"inside", [](Settings& s, float x) { s.inside = x; }, 0.0f, 1.0f, false},
    {"stretch_relief", [](Settings& s, float x) { s.stretch_relief = x; }, 0.0f, 1.0f, false},
    {"buckling_threshold", [](Settings& s, float x) { s.buckling_threshold = x; }, 0.0f, 1.0f, false},
    {"compression_limit", [](Settings& s, float x) { s.compression_limit = x; }, 1.0f, 1e6f, false},
    {"contact_gather", [](Settings& s, float x) { s.contact_gather = x; }, 0.0f, 1.0f, false},
    {"damping", [](Settings& s, float x) { s.damping = x; }, 0.0f, 1.0f, false},
    {"nudge", [](Settings& s, float x) { s.nudge = x; }, 0.0f, 1e3f, false},
    {"hem_rings", [](Settings& s, float x) { s.hem_rings = int(x); }, 0.0f, 1e6f, true},
    {"iterations", [](Settings& s, float x) { s.iterations = int(x); }, 0.0f, 1e6f, true},
    {"start_iterations", [](Settings& s, float x) { s.start_iterations = int(x); }, 0.0f, 1e6f, true},
    {"threads", [](Settings& s, float x) { s.threads = int(x); }, 0.0f, 1024.0f, true},
};

TEST(WrinkleMeshInput, EverySettingIsTakenUpToTheEndsOfItsRange) {
    EXPECT_NO_THROW(check(Settings{}));
    for (const Range& range : kRanges) {
        for (const float value : {range.low, range.high}) {
            Settings settings;
            range.set(settings, value);
            EXPECT_NO_THROW(check(settings)) << range.name << " = " << value;
        }
    }
}

TEST(WrinkleMeshInput, ASettingOutOfItsRangeIsNamedWithItsRangeAndValue) {
    const Cloth cloth(grid(2, 2, 0.1f));
    const State state = cloth.solve(cloth.mesh.positions, Settings{});
    for (const Range& range : kRanges) {
        std::vector<float> bad{range.low - 1.0f, range.high + std::ceil(1e-3f * range.high)};
        if (!range.whole) bad.insert(bad.end(), {kNan, kInfinity, -kInfinity});
        for (const float value : bad) {
            Settings settings;
            range.set(settings, value);
            const std::string begins = std::string(range.name) + ": expected ";
            expect_refused([&] { check(settings); },
                           {begins, short_text(range.low), "got " + short_text(value)});
            expect_refused([&] { cloth.solve(cloth.mesh.positions, settings); }, {begins});
            // Its errors were no numbers once.
            expect_refused([&] { measure(*cloth.model, settings, {}, {cloth.mesh.positions}, state); },
                           {begins});
        }
    }
}

TEST(WrinkleMeshInput, APoseThatIsNotFiniteNamesItsFirstBadVertex) {
    const Cloth cloth(grid(2, 2, 0.1f));
    const State state = cloth.solve(cloth.mesh.positions, Settings{});
    for (const float bad : {kNan, kInfinity, -kInfinity}) {
        for (int axis = 0; axis < 3; ++axis) {
            Pose3 pose = cloth.mesh.positions;
            pose[5][axis] = pose[7][axis] = bad;
            expect_refused([&] { cloth.solve(pose, Settings{}); }, {"positions", "vertex 5 "});
            expect_refused([&] { cloth.show(pose, Settings{}, state); }, {"positions", "vertex 5 "});
            expect_refused([&] { measure(*cloth.model, Settings{}, {}, {pose}, state); }, {"vertex 5 "});
        }
    }
}

TEST(WrinkleMeshInput, APoseOfAnotherMeshNamesBothCounts) {
    const Cloth cloth(grid(2, 2, 0.1f));
    for (const size_t count : {size_t(0), size_t(8), size_t(10)}) {
        const Pose3 pose(count, Vec3(0.0f));
        expect_refused([&] { cloth.solve(pose, Settings{}); },
                       {"positions", "expected 9 ", "got " + std::to_string(count)});
    }
}

TEST(WrinkleMeshInput, PaintOfAnotherMeshIsNamed) {
    const Cloth cloth(grid(2, 2, 0.1f));
    const size_t vertices = cloth.model->attached.size();
    const std::pair<const char*, std::vector<float> Paint::*> all[] = {{"radius", &Paint::radius},
                                                                       {"prestretch", &Paint::prestretch},
                                                                       {"bending", &Paint::bending},
                                                                       {"inside", &Paint::inside}};
    for (const auto& [name, values] : all) {
        Paint paint;
        (paint.*values).assign(vertices - 1, 1.0f);
        Report report;
        expect_refused([&] { solve(*cloth.model, {}, paint, {cloth.mesh.positions}, nullptr, report); },
                       {std::string("paint.") + name, "expected " + std::to_string(vertices),
                        "got " + std::to_string(vertices - 1)});
        expect_refused(
            [&] {
                measure(*cloth.model, {}, paint, {cloth.mesh.positions},
                        cloth.solve(cloth.mesh.positions, {}));
            },
            {std::string("paint.") + name});
        (paint.*values).assign(vertices, 1.0f);
        EXPECT_NO_THROW(solve(*cloth.model, {}, paint, {cloth.mesh.positions}, nullptr, report));
    }
}

TEST(WrinkleMeshInput, AStateOfAnotherMeshIsNotShown) {
    const Cloth cloth(grid(2, 2, 0.1f)), other(grid(3, 3, 0.1f));
    const State foreign = other.solve(other.mesh.positions, Settings{});
    expect_refused([&] { cloth.show(cloth.mesh.positions, Settings{}, foreign); }, {"state: expected "});
    expect_refused([&] { measure(*cloth.model, {}, {}, {cloth.mesh.positions}, foreign); },
                   {"state: expected "});
}

TEST(WrinkleMeshInput, AnOwnMeshTooFarAwayNamesItsFirstBadVertex) {
    const MeshData base = tube(12, 8, 0.1f, 0.5f);
    MeshData own = tube(24, 16, 0.1f, 0.5f);
    own.positions[77] += Vec3(0.0f, 1.0f, 0.0f);
    const Surface own_surface = tests::build(own);
    Source source;
    source.own = &own_surface;
    source.farthest = 0.05f;
    expect_refused([&] { Cloth(base, source, AttachmentKind::kLinear); }, {"vertex 77 ", "own mesh", "0.05"});
    source.farthest = 0.0f;
    EXPECT_NO_THROW(Cloth(base, source, AttachmentKind::kLinear));
}

TEST(WrinkleMeshInput, TooManyFineVerticesAreRefusedBeforeTheyAreMade) {
    Source source;
    source.level = 8;
    source.most_vertices = 10'000;
    expect_refused([&] { Cloth(grid(64, 64, 0.01f), source, AttachmentKind::kLinear); },
                   {"fine mesh", "more than 10000"});
    source.kind = Source::Kind::kLongestEdge;
    source.longest_edge = 1e-4f;
    expect_refused([&] { Cloth(grid(64, 64, 0.01f), source, AttachmentKind::kLinear); }, {"10000"});
}

}  // namespace
}  // namespace rumple::tests

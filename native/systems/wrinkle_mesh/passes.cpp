// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh/passes.h"

#include <algorithm>

#include "base/errors.h"
#include "base/random.h"
#include "surface/mesh/normals.h"
#include "surface/mesh/positions.h"
#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {
namespace {

void refuse_unsupported(const Model& model, const Settings& settings, const Paint& paint) {
    if (!model.rest_offset.empty()) throw InvalidInput("model: expected one without an own mesh");
    if (settings.collision == Collision::kNeighbourhood)
        throw InvalidInput("settings.collision: expected none or a plane");
    if (paint.guide) throw InvalidInput("paint.along: expected none");
}

void add_attachments(const Model& model, Passes& out) {
    out.curved = model.attachments.kind == AttachmentKind::kPnTriangle;
    for (const Index v : model.vertex_of_row) {
        const SurfacePoint& place = model.attachments.places[size_t(v)];
        out.base_vertices.push_back(welded_vertices(model.base, place.triangle));
        out.weights.emplace_back(place.b0, place.b1);
        if (model.attachments.kind == AttachmentKind::kLimit)
            out.limit.append_row(model.attachments.limit, v);
    }
}

void add_bounds(const Model& model, const Settings& settings, const Paint& paint, Passes& out) {
    const std::vector<float> radii = attachment_radii(model, settings, paint);
    for (const Index row_vertex : model.vertex_of_row) {
        const auto v = size_t(row_vertex);
        const bool has_plane = settings.collision == Collision::kPlane;
        out.radius.push_back(radii[v]);
        out.depth.push_back(has_plane ? settings.inside * painted(paint.inside, v) * radii[v]
                                      : kFarthestCoordinate);
        out.push.push_back(settings.nudge * model.local_edge[v]);
        out.noise.push_back(noise(settings.seed, static_cast<std::uint32_t>(v)));
    }
}

// Numbers the passes of an iteration in the order of relax_by_blocks(): all pairs within blocks, then all
// pairs between blocks, each time distance before bending, one colour after the other.
void number_passes(const Model& model, Passes& out) {
    out.pass.resize(model.distance.size() + model.bending.size());
    for (const size_t between : {0, 1}) {
        size_t first = 0;
        for (const Pairs* pairs : {&model.distance, &model.bending}) {
            Index most = 0;
            for (size_t group = between; group + 1 < pairs->group_start.size(); group += 2) {
                const Index begin = pairs->group_start[group], end = pairs->group_start[group + 1];
                for (Index run = begin; run < end; ++run) {
                    std::fill(out.pass.begin() + std::ptrdiff_t(first) + pairs->run_start[run],
                              out.pass.begin() + std::ptrdiff_t(first) + pairs->run_start[run + 1],
                              out.count + run - begin);
                }
                most = std::max(most, end - begin);
            }
            out.count += most;
            first += pairs->size();
        }
    }
}

void add_pairs(const Model& model, const Settings& settings, const Paint& paint, Passes& out) {
    out.distance_count = static_cast<Index>(model.distance.size());
    for (const Pairs* pairs : {&model.distance, &model.bending}) {
        for (size_t i = 0; i < pairs->size(); ++i) out.pairs.push_back({pairs->row_a[i], pairs->row_b[i]});
        out.rest.insert(out.rest.end(), pairs->rest.begin(), pairs->rest.end());
        const std::vector<float> stretched = stretched_lengths(settings, paint, *pairs);
        out.stretched.insert(out.stretched.end(), stretched.begin(), stretched.end());
    }
    out.stiffness.assign(model.distance.size(), 1.0f);
    const std::vector<float> bending = bending_stiffness(model, settings, paint);
    out.stiffness.insert(out.stiffness.end(), bending.begin(), bending.end());
    number_passes(model, out);
}

}  // namespace

Passes collect_passes(const Model& model, const Settings& settings, const Paint& paint) {
    check(settings);
    check(model, paint);
    refuse_unsupported(model, settings, paint);
    Passes out;
    for (Index t = 0; t < Index(model.base.triangles.size()); ++t)
        out.triangles.push_back(welded_vertices(model.base, t));
    out.vertex = model.vertex_of_row;
    add_attachments(model, out);
    add_bounds(model, settings, paint, out);
    add_pairs(model, settings, paint, out);
    return out;
}

WeldedPose weld_pose(const Model& model, std::span<const Vec3> positions) {
    check_frame(model.base, positions);
    WeldedPose pose;
    pose.positions = weld_positions(model.base, positions);
    pose.normals = vertex_normals(model.base, pose.positions);
    pose.smooth = pose.positions;
    if (model.attachments.kind == AttachmentKind::kLimit)
        apply<Vec3>(model.vertex_limit, pose.positions, pose.smooth);
    return pose;
}

}  // namespace rumple::wrinkle_mesh

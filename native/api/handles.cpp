// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/handles.h"

#include <algorithm>

#include "api/sound.h"
#include "base/expect.h"

using namespace rumple;

namespace {

// 1 + the index of the last column of a linear map.
size_t columns(const SparseRows& rows) {
    const auto last = std::max_element(rows.index.begin(), rows.index.end());
    return last == rows.index.end() ? 0 : size_t(*last) + 1;
}

}  // namespace

rumple_shown_mesh::rumple_shown_mesh(const ShownMesh& shown)
    : mesh(shown),
      source_vertices(columns(shown.vertex_from_source)),
      source_corners(size_t(shown.corner_from_source.columns())) {
    barycentric.reserve(shown.places.size());
    for (const SurfacePoint& place : shown.places) barycentric.push_back({place.b0, place.b1});
}

std::shared_ptr<const PosedCollider> rumple_collider::in(std::span<const Vec3> positions) const {
    std::shared_ptr<const PosedCollider> last;
    {
        const std::lock_guard lock(mutex_);
        last = last_;
    }
    if (last && last->is_at(positions)) return last;
    auto posed = std::make_shared<const PosedCollider>(collider, positions);
    const std::lock_guard lock(mutex_);
    return last_ = std::move(posed);
}

namespace rumple::api {

FineSource fine_source(const rumple_fine_plan& plan) {
    FineSource source;
    source.kind = choice(plan.source, FineSource::Kind::kLongestEdge, "source");
    source.level = plan.level;
    source.segments = plan.segments;
    source.longest_edge = plan.longest_edge;
    source.most_vertices = plan.most_vertices;
    return source;
}

AttachmentKind attachment_kind(const rumple_fine_plan& plan) {
    return choice(plan.attachment, AttachmentKind::kLimit, "attachment");
}

rumple_fine_plan fine_plan(const FineSource& source) {
    return {int32_t(source.kind), source.level,         source.segments,
            source.longest_edge,  source.most_vertices, RUMPLE_ATTACH_LIMIT};
}

std::shared_ptr<const PosedCollider> posed(const rumple_bodies* bodies) {
    if (!bodies || !bodies->collider) return nullptr;
    return bodies->collider->in(vectors(bodies->positions, bodies->positions_count, "bodies.positions"));
}

std::span<const Vec3> positions_of(const rumple_pose* pose) {
    const rumple_pose& from = given(pose, "frame");
    return vectors(from.positions, from.positions_count, "positions");
}

FrameTime frame_time_of(const rumple_pose* pose) {
    FrameTime frame_time;
    frame_time.time = given(pose, "frame").time;
    frame_time.labels = values(pose->labels, pose->labels_count, "labels");
    frame_time.next_positions = vectors(pose->next_positions, pose->next_positions_count, "next_positions");
    frame_time.next_time = pose->next_time;
    return frame_time;
}

FrameArrays::FrameArrays(const rumple_pose* frame)
    : positions(copied(positions_of(frame))),
      next_positions(copied(frame_time_of(frame).next_positions)),
      labels(copied(frame_time_of(frame).labels)),
      world_from_object(matrix_of(frame->world_from_object)),
      time(frame->time),
      next_time(frame->next_time) {}

glm::mat3 matrix_of(const float (&rows)[9]) {
    glm::mat3 matrix;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) matrix[c][r] = rows[3 * r + c];
    }
    return matrix;
}

std::vector<float> painted(const float* data, size_t count, const Surface& base, const char* name,
                           double least, double most) {
    const std::span<const float> from = values(data, count, name);
    if (!from.empty()) expect_count(name, from.size(), size_t(base.display.vertex_count), "values");
    expect_range(name, from, least, most);
    return copied(from);
}

rumple_reference_view view_of(const ReferenceState& state) {
    return {state.time,
            state.labels.data(),
            state.labels.size(),
            flat<float>(state.reference),
            state.reference.size(),
            state.past_times.data(),
            state.past_times.size(),
            flat<float>(state.past_positions),
            state.past_positions.size()};
}

ReferenceState state_of(const rumple_reference_view& arrays) {
    ReferenceState state;
    state.time = arrays.time;
    state.labels = copied(values(arrays.labels, arrays.labels_count, "labels"));
    state.reference = copied(rows<FlatTriangle>(arrays.reference, arrays.reference_count, "reference"));
    state.past_times = copied(values(arrays.past_times, arrays.past_times_count, "past_times"));
    state.past_positions =
        copied(vectors(arrays.past_positions, arrays.past_positions_count, "past_positions"));
    return state;
}

void label(const Surface& base, const ReferenceModel& model, const ReferenceSettings& settings,
           const Clip& clip, std::uint8_t* labels, size_t labels_count) {
    const auto times = values(clip.times, clip.times_count, "times");
    const auto positions = vectors(clip.positions, clip.positions_count, "positions");
    const auto out =
        output<std::uint8_t>(labels, labels_count, times.size() * base.triangles.size(), "labels");
    write(label_clip(base, model, settings, times, positions, clip.raw), out);
}

}  // namespace rumple::api

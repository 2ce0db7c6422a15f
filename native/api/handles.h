// SPDX-License-Identifier: GPL-3.0-or-later
// The types behind the handles that several systems use.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <variant>

#include "api/settings.h"
#include "surface/contact/collider.h"
#include "surface/output/shown_mesh.h"
#include "surface/strain/adaptive_reference.h"
#include "systems/wrinkle_field/wrinkle_field.h"
#include "systems/wrinkle_paths/wrinkle_paths.h"

struct rumple_surface {
    explicit rumple_surface(std::shared_ptr<const rumple::Surface> of)
        : shared(std::move(of)), surface(*shared) {}

    std::shared_ptr<const rumple::Surface> shared;
    const rumple::Surface& surface;
};

// Part of a model's handle. It also stores arrays for views that the model has in another format.
struct rumple_shown_mesh {
    explicit rumple_shown_mesh(const rumple::ShownMesh& shown);

    const rumple::ShownMesh& mesh;
    std::vector<rumple::Vec2> barycentric;
    size_t source_vertices;  // number of source vertices that are read: 1 + the last one
    size_t source_corners;
};

struct rumple_collider {
    explicit rumple_collider(rumple::Collider&& of) : collider(std::move(of)) {}

    // The collider in the pose of a frame. If the positions equal those of the last call bit for bit, its
    // result is reused, because the base cloth and the layers of a frame need the same. Thread-safe.
    std::shared_ptr<const rumple::PosedCollider> in(std::span<const rumple::Vec3> positions) const;

    const rumple::Collider collider;

  private:
    mutable std::mutex mutex_;
    mutable std::shared_ptr<const rumple::PosedCollider> last_;
};

struct rumple_frame {
    std::shared_ptr<const void> model;  // keeps base and mesh
    const rumple::Surface& base;
    const rumple::ShownMesh& mesh;
    std::variant<rumple::ShownFrame, rumple::wrinkle_field::Picture, rumple::wrinkle_paths::Picture> picture;

    rumple::ShownFrame& shown() {
        return std::visit([](auto& of_system) -> rumple::ShownFrame& { return of_system; }, picture);
    }
    const rumple::ShownFrame& shown() const { return const_cast<rumple_frame*>(this)->shown(); }
};

namespace rumple::api {

// The shown mesh of a model, and the one for viewports if it has one.
struct ShownMeshes {
    template <typename Model>
    explicit ShownMeshes(const Model& model) : in_renders(model.shown) {
        if (model.shown_in_viewport) in_viewports.emplace(*model.shown_in_viewport);
    }
    const rumple_shown_mesh* in(bool in_viewport) const {
        return in_viewport && in_viewports ? &*in_viewports : &in_renders;
    }

    rumple_shown_mesh in_renders;
    std::optional<rumple_shown_mesh> in_viewports;
};

// A frame that was made for a model. It keeps the model alive.
template <typename Model, typename Picture>
rumple_frame* new_frame(const std::shared_ptr<const Model>& model, Picture&& picture) {
    return new rumple_frame{model, model->base, model->shown, std::forward<Picture>(picture)};
}

// The same for a model with two shown meshes.
template <typename Model>
rumple_frame* new_frame(const std::shared_ptr<const Model>& model, ShownFrame&& frame, bool in_viewport) {
    return new rumple_frame{model, model->base, shown_mesh(*model, in_viewport), std::move(frame)};
}

FineSource fine_source(const rumple_fine_plan& plan);
AttachmentKind attachment_kind(const rumple_fine_plan& plan);
rumple_fine_plan fine_plan(const FineSource& source);

// Bodies of a frame, posed; none for none. The collider must outlive them.
std::shared_ptr<const PosedCollider> posed(const rumple_bodies* bodies);

// Positions and time of a frame.
std::span<const Vec3> positions_of(const rumple_pose* pose);
FrameTime frame_time_of(const rumple_pose* pose);

// Copies of a frame's arrays, because a pose outlives the call that made it.
struct FrameArrays {
    explicit FrameArrays(const rumple_pose* frame);
    FrameTime frame_time() const { return {time, labels, next_positions, next_time}; }

    std::vector<Vec3> positions, next_positions;
    std::vector<std::uint8_t> labels;
    glm::mat3 world_from_object;
    double time, next_time;
};
glm::mat3 matrix_of(const float (&rows)[9]);

// rumple_X_pose_build() of a system. make(model, arrays) -> its Pose.
template <typename Handle, typename Model, typename Make>
rumple_status made_pose(const Model* model, const rumple_pose* frame, Handle** pose, Make&& make) {
    return made(pose, "pose", [&] {
        const Model& of = given(model, "model");
        FrameArrays arrays(frame);
        auto at = make(*of.model, arrays);
        return new Handle{of.model, std::move(arrays), std::move(at)};
    });
}

// A painted factor of the base's vertices, least..most, or none.
std::vector<float> painted(const float* data, size_t count, const Surface& base, const char* name,
                           double least = 0.0, double most = 1.0);

// The settings and the state of an adaptive rest shape.
template <typename Pair>
void pair_reference(rumple_reference_settings& c, ReferenceSettings& native, const Pair& pair) {
    pair.choose("reference", c.reference, native.reference, Reference::kStaticRest);
    pair(c.window, native.window);
    pair(c.relaxation, native.relaxation);
    pair(c.growth, native.growth);
    pair(c.growth_time, native.growth_time);
}
rumple_reference_view view_of(const ReferenceState& state);
ReferenceState state_of(const rumple_reference_view& arrays);

// rumple_X_label_clip() of a system.
struct Clip {
    const double* times;
    size_t times_count;
    const float* positions;
    size_t positions_count;
    bool raw;
};
void label(const Surface& base, const ReferenceModel& model, const ReferenceSettings& settings,
           const Clip& clip, std::uint8_t* labels, size_t labels_count);

}  // namespace rumple::api

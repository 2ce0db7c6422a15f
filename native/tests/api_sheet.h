// SPDX-License-Identifier: GPL-3.0-or-later
// One quad, of 1 x 1 times its size, through the C library, for its tests.
#pragma once

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "rumple.h"

namespace rumple::api {

class Sheet {
  public:
    explicit Sheet(float size = 1.0f) {
        std::vector<float> rest(kRest, kRest + 12);
        for (std::vector<float>* lengths : {&rest, &positions}) {
            for (float& x : *lengths) x *= size;
        }
        rumple_surface_plan plan = rumple_surface_plan_default();
        plan.positions_rest = rest.data();
        plan.positions_rest_count = 4;
        plan.polygon_start = kPolygonStart;
        plan.polygon_start_count = 2;
        plan.corner_vertex = kCornerVertex;
        plan.corner_vertex_count = 4;
        plan.triangle_corner = kTriangleCorner;
        plan.triangle_corner_count = 2;
        EXPECT_EQ(rumple_surface_build(&plan, &surface_), RUMPLE_OK) << rumple_error();
        rumple_wrinkle_mesh_plan fine = rumple_wrinkle_mesh_plan_default();
        EXPECT_EQ(rumple_wrinkle_mesh_build(surface_, &fine, &model_), RUMPLE_OK) << rumple_error();
        const rumple_pose in_frame = frame();
        EXPECT_EQ(rumple_wrinkle_mesh_pose_build(model_, &in_frame, &pose_), RUMPLE_OK) << rumple_error();
    }
    ~Sheet() {
        rumple_wrinkle_mesh_pose_free(pose_);
        rumple_wrinkle_mesh_free(model_);
        rumple_surface_free(surface_);
    }
    Sheet(const Sheet&) = delete;
    Sheet& operator=(const Sheet&) = delete;

    const rumple_surface* surface() const { return surface_; }
    const rumple_wrinkle_mesh* model() const { return model_; }
    const rumple_wrinkle_mesh_pose* pose() const { return pose_; }
    rumple_pose frame() const {
        rumple_pose frame = rumple_pose_default();
        frame.positions = positions.data();
        frame.positions_count = 4;
        return frame;
    }

    rumple_wrinkle_mesh_state* solve(const rumple_wrinkle_mesh_state* before = nullptr) const {
        const rumple_wrinkle_mesh_settings settings = rumple_wrinkle_mesh_settings_default();
        rumple_wrinkle_mesh_state* state = nullptr;
        EXPECT_EQ(rumple_wrinkle_mesh_solve(model_, &settings, nullptr, pose_, before, nullptr, &state),
                  RUMPLE_OK)
            << rumple_error();
        return state;
    }

    std::vector<float> positions{0.0f, 0.0f, 0.0f, 0.8f, 0.0f, 0.0f, 0.8f, 1.0f, 0.0f, 0.0f, 1.0f, 0.0f};

  private:
    static constexpr float kRest[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    static constexpr int32_t kPolygonStart[] = {0, 4}, kCornerVertex[] = {0, 1, 2, 3},
                             kTriangleCorner[] = {0, 1, 2, 0, 2, 3};

    rumple_surface* surface_ = nullptr;
    rumple_wrinkle_mesh* model_ = nullptr;
    rumple_wrinkle_mesh_pose* pose_ = nullptr;
};

}  // namespace rumple::api

// SPDX-License-Identifier: GPL-3.0-or-later
// The types behind the handles of the Wrinkle Paths.
#pragma once

#include <mutex>

#include "api/handles.h"

struct rumple_wrinkle_paths {
    std::shared_ptr<const rumple::wrinkle_paths::Model> model;
    rumple_shown_mesh shown;
};
struct rumple_wrinkle_paths_pose {
    std::shared_ptr<const rumple::wrinkle_paths::Model> model;
    rumple::api::FrameArrays arrays;
    rumple::wrinkle_paths::Pose pose;
};
struct rumple_wrinkle_paths_paint {
    std::shared_ptr<const rumple::wrinkle_paths::Model> model;
    rumple::wrinkle_paths::Paint paint;
};

// The paths of a state as flat arrays.
struct PathArrays {
    std::vector<rumple::Index> id, start{0}, triangle_edge;
    std::vector<float> fade;
    std::vector<rumple::Vec2> at;
};

struct rumple_wrinkle_paths_state {
    rumple_wrinkle_paths_state(std::shared_ptr<const rumple::wrinkle_paths::Model> of,
                               rumple::wrinkle_paths::State from)
        : model(std::move(of)), state(std::move(from)) {}

    std::shared_ptr<const rumple::wrinkle_paths::Model> model;
    rumple::wrinkle_paths::State state;

    // Made by the first thread that needs them.
    const PathArrays& arrays() const;

  private:
    mutable std::once_flag flattened_;
    mutable PathArrays arrays_;
};

namespace rumple::api {

wrinkle_paths::Settings paths_settings(const rumple_wrinkle_paths_settings* settings);
wrinkle_paths::Input input_of(const FrameArrays& arrays);

}  // namespace rumple::api

// SPDX-License-Identifier: GPL-3.0-or-later
// The types behind the handles of the Wrinkle Field, for its brush.
#pragma once

#include "api/handles.h"

struct rumple_wrinkle_field {
    explicit rumple_wrinkle_field(std::shared_ptr<const rumple::wrinkle_field::Model> built);

    std::shared_ptr<const rumple::wrinkle_field::Model> model;
    rumple_shown_mesh shown;
    // Arrays for views that the model has in another format.
    std::vector<rumple::Index> neighbours;
    std::vector<rumple::Vec2> gradients;
    std::vector<rumple::Index> triangles;
    std::vector<rumple::Vec2> first_directions;
};
struct rumple_wrinkle_field_pose {
    std::shared_ptr<const rumple::wrinkle_field::Model> model;
    rumple::api::FrameArrays arrays;
    rumple::wrinkle_field::Pose pose;
};
struct rumple_wrinkle_field_paint {
    std::shared_ptr<const rumple::wrinkle_field::Model> model;
    rumple::wrinkle_field::Paint paint;
};
struct rumple_wrinkle_field_state {
    std::shared_ptr<const rumple::wrinkle_field::Model> model;
    rumple::wrinkle_field::State state;
};
struct rumple_waves {
    std::shared_ptr<const rumple::wrinkle_field::Model> model;
    rumple::wrinkle_field::Waves waves;
};

namespace rumple::api {

wrinkle_field::Settings field_settings(const rumple_wrinkle_field_settings* settings);
wrinkle_field::Profile profile_in(const rumple_wrinkle_field_profile* profile);
// NULL: no paint.
const wrinkle_field::Paint& paint_in(const rumple_wrinkle_field& model,
                                     const rumple_wrinkle_field_paint* paint);

}  // namespace rumple::api

// SPDX-License-Identifier: GPL-3.0-or-later
// What stays the same in all rounds of a relaxation. Internal to wrinkle_field.
#pragma once

#include <memory>
#include <vector>

#include "systems/wrinkle_field/wrinkle_field.h"

namespace rumple::wrinkle_field {

// A column of neighbours in relaxation.
struct Pull {
    Lanes weight;  // attenuation of the neighbours' amplitudes; zero where a neighbour is missing
    lane_formulas::Link link;
};

// Of all columns of a model, for the waves of a frame.
class Pulls {
  public:
    Pulls(const Model& model, const Settings& settings, const Waves& waves);

    const Pull& operator[](Index column) const { return pulls_[column]; }

    // Calls act(i, weight, link) for every neighbour i of a vertex, in their order.
    template <typename Act>
    void for_each_of(size_t vertex, Act&& act) const {
        const Index begin = model_.neighbour_start[vertex], end = model_.neighbour_start[vertex + 1];
        const Pull* pull = pulls_.get() + model_.columns.start[vertex / kLanes];
        const size_t lane = vertex % kLanes;
        for (Index i = begin; i < end; ++i, ++pull)
            act(i, pull->weight[lane], formulas::link_of(pull->link.flip[lane], pull->link.offset[lane]));
    }

  private:
    const Model& model_;
    std::unique_ptr<Pull[]> pulls_;  // not a vector, which would write zeros first
};

}  // namespace rumple::wrinkle_field

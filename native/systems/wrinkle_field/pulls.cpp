// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_field/pulls.h"

#include "systems/wrinkle_field/frames.h"

namespace rumple::wrinkle_field {

Pulls::Pulls(const Model& model, const Settings& settings, const Waves& waves)
    : model_(model), pulls_(new Pull[model.columns.vertex.size()]) {
    const NeighbourColumns& columns = model.columns;
    const std::vector<Row> positions = to_rows(waves.positions), wave_vectors = to_rows(waves.wave_vector);
    for_each_four_vertices(settings, waves.height.size(), [&](size_t first, size_t) {
        const size_t four = first / kLanes;
        const Vec3Lanes position = columns_from(positions, first), wave = columns_from(wave_vectors, first);
        for (Index c = columns.start[four]; c < columns.start[four + 1]; ++c) {
            const LaneIndices& n = columns.vertex[c];
            const LaneMask exist = columns.count[four] > float(c - columns.start[four]);
            const Lanes weight = exist ? lane_formulas::attenuation(gathered(waves.fullness, n)) : 0.0f;
            pulls_[c] = {weight, lane_formulas::link_waves(wave, gathered(wave_vectors, n),
                                                           gathered(positions, n) - position)};
        }
    });
}

}  // namespace rumple::wrinkle_field

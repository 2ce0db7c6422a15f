// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh/relax.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "base/solve_team.h"
#include "base/tolerances.h"

namespace rumple::wrinkle_mesh {
namespace {

// Equations (3) to (5), multiplied by a stiffness.
inline void project_pair(Row& p1, Row& p2, float target, float stiffness) {
    const Row difference{p2.xyz - p1.xyz};
    const float length = square_root(dot(difference, difference));
    if (length < kShortestEdge) return;
    const Lanes half = 0.5f * stiffness * (length - target) / length * difference.xyz;
    p1.xyz += half;
    p2.xyz -= half;
}

// The same for four pairs that share no vertex.
inline void project_four(const Index* a, const Index* b, const Lanes& target, const Lanes& stiffness,
                         std::span<Row> positions) {
    std::array<Row, kLanes> difference;
    for (int k = 0; k < kLanes; ++k) difference[k].xyz = positions[b[k]].xyz - positions[a[k]].xyz;
    const Vec3Lanes d = columns(difference);
    const Lanes length = square_root(dot(d, d));
    const Lanes share = 0.5f * stiffness * (length - target) / length;
    const LaneMask too_short = length < all_lanes(kShortestEdge);
    const bool all_move = bits_of(too_short) == 0;
    for (int k = 0; k < kLanes; ++k) {
        if (!all_move && too_short[k]) continue;
        const Lanes half = share[k] * difference[k].xyz;
        positions[a[k]].xyz += half;
        positions[b[k]].xyz -= half;
    }
}

// One pass over pairs [begin, end), which share no vertex.
void sweep_run(const Pairs& pairs, std::span<const float> target, std::span<const float> stiffness,
               std::span<Row> positions, size_t begin, size_t end) {
    size_t i = begin;
    for (; i + kLanes <= end; i += kLanes) {
        project_four(&pairs.row_a[i], &pairs.row_b[i], load_lanes(&target[i]),
                     stiffness.empty() ? all_lanes(1.0f) : load_lanes(&stiffness[i]), positions);
    }
    for (; i < end; ++i) {
        project_pair(positions[pairs.row_a[i]], positions[pairs.row_b[i]], target[i],
                     stiffness.empty() ? 1.0f : stiffness[i]);
    }
}

void sweep_group(const Pairs& pairs, size_t group, std::span<const float> target,
                 std::span<const float> stiffness, std::span<Row> positions) {
    for (Index run = pairs.group_start[group]; run < pairs.group_start[group + 1]; ++run) {
        sweep_run(pairs, target, stiffness, positions, size_t(pairs.run_start[run]),
                  size_t(pairs.run_start[run + 1]));
    }
}

std::vector<Row> to_sweep(const Model& model, std::span<const Vec3> positions) {
    std::vector<Row> rows(in_fours(positions.size()));
    for_each_index(positions.size(), kLeastSteps,
                   [&](size_t r) { rows[r] = positions[size_t(model.vertex_of_row[r])]; });
    return rows;
}
void from_sweep(const Model& model, std::span<const Row> rows, std::span<Vec3> positions) {
    for_each_index(positions.size(), kLeastSteps,
                   [&](size_t v) { positions[v] = rows[size_t(model.row_of[v])].vec(); });
}

std::vector<size_t> natural_order(const Pairs& pairs) {
    std::vector<size_t> order(pairs.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](size_t i, size_t j) {
        return std::tuple(pairs.a[i], pairs.b[i], i) < std::tuple(pairs.a[j], pairs.b[j], j);
    });
    return order;
}

}  // namespace

void relax_by_blocks(const Model& model, const Targets& targets, const Bounds& bounds, int iterations,
                     std::span<Vec3> positions) {
    std::vector<Row> rows = to_sweep(model, positions);
    const size_t blocks = model.block_row.size() - 1;
    const auto sweep = [&](size_t group) {
        sweep_group(model.distance, group, targets.distance, {}, rows);
        sweep_group(model.bending, group, targets.bending, targets.stiffness, rows);
    };
    for (int i = 0; i < iterations; ++i) {
        for_each_block(blocks, kLeastBlocks, [&](size_t block) { sweep(2 * block); });
        for_each_block(blocks, kLeastBlocks, [&](size_t block) { sweep(2 * block + 1); });
        for_each_block(blocks, kLeastBlocks, [&](size_t block) {
            const auto end = size_t(model.block_row[block + 1]);
            for (auto row = size_t(model.block_row[block]); row < end; row += kLanes)
                bounds.pull_and_project_four(row / kLanes, four_from(rows, row));
        });
    }
    from_sweep(model, rows, positions);
}

void relax_in_order(const Model& model, const Targets& targets, const Bounds& bounds, int iterations,
                    std::span<Vec3> positions) {
    const std::vector<size_t> distance = natural_order(model.distance),
                              bending = natural_order(model.bending);
    std::vector<Row> rows = to_sweep(model, positions);
    for (int i = 0; i < iterations; ++i) {
        for (const size_t c : distance)
            project_pair(rows[model.distance.row_a[c]], rows[model.distance.row_b[c]], targets.distance[c],
                         1.0f);
        for (const size_t c : bending) {
            project_pair(rows[model.bending.row_a[c]], rows[model.bending.row_b[c]], targets.bending[c],
                         targets.stiffness[c]);
        }
        for (size_t four = 0; four < rows.size() / kLanes; ++four)
            bounds.pull_and_project_four(four, four_from(rows, kLanes * four));
    }
    from_sweep(model, rows, positions);
}

}  // namespace rumple::wrinkle_mesh

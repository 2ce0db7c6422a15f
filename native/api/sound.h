// SPDX-License-Identifier: GPL-3.0-or-later
// Checks that results are finite. If not, the call fails, so that a bad frame never gets into a stored state.
// The caller keeps the state before it, and continues from there.
#pragma once

#include <span>
#include <string>

#include "surface/cloth/base_cloth.h"
#include "surface/output/coarse.h"
#include "systems/wrinkle_field/wrinkle_field.h"
#include "systems/wrinkle_maps/wrinkle_maps.h"
#include "systems/wrinkle_mesh/layers.h"
#include "systems/wrinkle_paths/curves.h"
#include "systems/wrinkle_paths/preview.h"

namespace rumple::api {

using Floats = std::span<const float>;

template <typename Row>
Floats floats_of(const std::vector<Row>& rows) {
    static_assert(std::is_trivially_copyable_v<Row> && sizeof(Row) % sizeof(float) == 0);
    return {reinterpret_cast<const float*>(rows.data()), rows.size() * sizeof(Row) / sizeof(float)};
}

bool all_finite(Floats values);

// The floats of a result.
std::vector<Floats> floats_in(const base_cloth::Result& of);
std::vector<Floats> floats_in(const wrinkle_mesh::State& of);
std::vector<Floats> floats_in(const wrinkle_mesh::LayersState& of);
std::vector<Floats> floats_in(const wrinkle_field::State& of);
std::vector<Floats> floats_in(const wrinkle_paths::State& of);
std::vector<Floats> floats_in(const ShownFrame& of);
std::vector<Floats> floats_in(const wrinkle_field::Picture& of);
std::vector<Floats> floats_in(const wrinkle_paths::Picture& of);
std::vector<Floats> floats_in(const wrinkle_field::Waves& of);
std::vector<Floats> floats_in(const wrinkle_paths::Curves& of);
std::vector<Floats> floats_in(const wrinkle_paths::RidingCurves& of);
std::vector<Floats> floats_in(const wrinkle_paths::Drawing& of);
template <typename Row>
std::vector<Floats> floats_in(const std::vector<Row>& of) {
    return {floats_of(of)};
}

// Throws InvalidInput.
[[noreturn]] void refuse_unsound();

template <typename T>
bool is_sound(const T& value) {
    for (const Floats floats : floats_in(value)) {
        if (!all_finite(floats)) return false;
    }
    return true;
}

// The value itself, if it is finite.
template <typename T>
T sound(T value) {
    if (!is_sound(value)) refuse_unsound();
    return value;
}

// Solves a frame from the state before it. solve(before): NULL is the canonical start. A finite state may
// lead to a result that is not finite, for example if one bad vertex made cloth fly away. Then the frame is
// solved from the canonical start, so that later frames can be solved again.
template <typename State, typename Solve>
auto sound_from(const State* before, Solve&& solve) {
    auto solved = solve(before);
    if (is_sound(solved)) return solved;
    if (!before) refuse_unsound();
    return sound(solve(static_cast<const State*>(nullptr)));
}

// Checks input: throws InvalidInput about the first element that is not within [low, high], unless infinity
// is allowed and it is infinite.
void expect_range(const std::string& name, Floats values, double low, double high);
void expect_numbers(const std::string& name, Floats values);

}  // namespace rumple::api

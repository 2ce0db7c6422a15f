// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sound.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "base/expect.h"

namespace rumple::api {
namespace {

void append(std::vector<Floats>& to, const std::vector<Floats>& more) {
    to.insert(to.end(), more.begin(), more.end());
}

std::vector<Floats> floats_in(const ReferenceState& of) {
    return {floats_of(of.reference), floats_of(of.past_positions)};
}

}  // namespace

// It tests bits without a branch, so that a compiler can vectorise it.
bool all_finite(Floats values) {
    constexpr std::uint32_t kExponent = 0x7f800000u;
    std::uint32_t found = 0;
    for (const float value : values)
        found |= (std::bit_cast<std::uint32_t>(value) & kExponent) == kExponent ? 1u : 0u;
    return found == 0;
}

std::vector<Floats> floats_in(const base_cloth::Result& of) {
    const base_cloth::State& s = of.state;
    return {floats_of(of.positions),      floats_of(of.gap),
            floats_of(s.offset),          floats_of(s.length),
            floats_of(s.clearance),       floats_of(s.ahead_height),
            floats_of(s.motion.position), floats_of(s.motion.velocity),
            floats_of(s.motion.animated), floats_of(s.motion.animated_before),
            floats_of(s.motion.air),      floats_of(s.motion.push),
            Floats(&s.moved, 1)};
}

std::vector<Floats> floats_in(const wrinkle_mesh::State& of) {
    std::vector<Floats> all = floats_in(of.reference);
    append(all, {floats_of(of.offset), floats_of(of.solved_length)});
    return all;
}

std::vector<Floats> floats_in(const wrinkle_mesh::LayersState& of) {
    std::vector<Floats> all{floats_of(of.solved)};
    for (const wrinkle_mesh::State& layer : of.layers) append(all, floats_in(layer));
    return all;
}

// solved_offset is left out, because it is infinite for vertices that were never relaxed.
std::vector<Floats> floats_in(const wrinkle_field::State& of) {
    std::vector<Floats> all = floats_in(of.reference);
    append(all, {floats_of(of.phase), floats_of(of.direction)});
    return all;
}

std::vector<Floats> floats_in(const wrinkle_paths::State& of) {
    std::vector<Floats> all = floats_in(of.reference);
    append(all, {floats_of(of.shapes), floats_of(of.compression)});
    for (const wrinkle_paths::Path& path : of.paths) {
        all.emplace_back(&path.fade, 1);
        for (const wrinkle_paths::PathPoint& point : path.points) all.emplace_back(&point.at.x, 2);
    }
    return all;
}

std::vector<Floats> floats_in(const ShownFrame& of) {
    return {floats_of(of.positions),       floats_of(of.local_offset),    floats_of(of.offset),
            floats_of(of.stretch.minimum), floats_of(of.stretch.maximum), floats_of(of.stretch.direction)};
}

std::vector<Floats> floats_in(const wrinkle_field::Picture& of) {
    std::vector<Floats> all = floats_in(static_cast<const ShownFrame&>(of));
    append(all,
           {floats_of(of.amplitude), floats_of(of.direction), floats_of(of.phase), floats_of(of.corner_phase),
            floats_of(of.corner_weight), floats_of(of.corner_u_gradient), floats_of(of.corner_v_gradient)});
    for (const auto& vectors : of.corner_wave_vector) all.push_back(floats_of(vectors));
    return all;
}

std::vector<Floats> floats_in(const wrinkle_paths::Picture& of) {
    std::vector<Floats> all = floats_in(static_cast<const ShownFrame&>(of));
    all.push_back(floats_of(of.height));
    return all;
}

std::vector<Floats> floats_in(const wrinkle_field::Waves& of) {
    return {floats_of(of.positions), floats_of(of.normals),  floats_of(of.wave_vector),
            floats_of(of.height),    floats_of(of.fullness), floats_of(of.compression),
            floats_of(of.gather),    floats_of(of.direction)};
}

std::vector<Floats> floats_in(const wrinkle_paths::Curves& of) {
    return {floats_of(of.positions), floats_of(of.width), floats_of(of.height)};
}

std::vector<Floats> floats_in(const wrinkle_paths::RidingCurves& of) {
    std::vector<Floats> all = floats_in(of.curves);
    append(all, {floats_of(of.weights), floats_of(of.local_offset)});
    return all;
}

std::vector<Floats> floats_in(const wrinkle_paths::Drawing& of) {
    return {floats_of(of.flat), floats_of(of.smooth),       floats_of(of.normal),
            floats_of(of.hem),  floats_of(of.proxy_offset), floats_of(of.lists.ends)};
}

void refuse_unsound() {
    throw InvalidInput(
        "positions: the frame is so far from the rest shape, or a setting so extreme, that its result is not "
        "finite");
}

void expect_range(const std::string& name, Floats values, double low, double high) {
    expect_each_within(name, values, low, high, "number");
}

void expect_numbers(const std::string& name, Floats values) {
    const auto bad =
        std::find_if(values.begin(), values.end(), [](float value) { return std::isnan(value); });
    if (bad != values.end()) {
        throw InvalidInput(name + ": number " + std::to_string(bad - values.begin()) + " is not a number");
    }
}

}  // namespace rumple::api

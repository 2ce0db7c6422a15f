// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/cloth/force_fields.h"

#include "api/settings.h"
#include "rumple.h"

using namespace rumple;
using namespace rumple::api;
using force_fields::Field;

// See api/settings.h. In no namespace, so that it is found by the types of its arguments.
template <typename Pair>
static void pair_fields(rumple_force_field& c, Field& native, const Pair& pair) {
    pair.choose("kind", c.kind, native.kind, force_fields::Kind::kTurbulence);
    pair.choose("shape", c.shape, native.shape, force_fields::Shape::kPlane);
    pair.choose("falloff", c.falloff, native.falloff, force_fields::Falloff::kCone);
    pair.choose("side", c.side, native.side, force_fields::Side::kBelow);
    pair(c.location, native.location);
    pair(c.axis, native.axis);
    pair(c.strength, native.strength);
    pair(c.damping, native.damping);
    pair(c.size, native.size);
    pair(c.flow, native.flow);
    pair(c.noise, native.noise);
    pair(c.seed, native.seed);
    pair(c.power, native.along.power);
    pair(c.least, native.along.least);
    pair(c.most, native.along.most);
    pair(c.ends, native.along.ends);
    pair(c.radial_power, native.across.power);
    pair(c.radial_least, native.across.least);
    pair(c.radial_most, native.across.most);
    pair(c.radial_ends, native.across.ends);
    pair(c.inverse_square, native.inverse_square);
    pair(c.in_world, native.in_world);
}

rumple_force_field rumple_force_field_default(void) {
    return default_of<rumple_force_field, Field>();
}

rumple_status rumple_force_fields_evaluate(const rumple_force_field* fields, size_t fields_count,
                                           int32_t frame, const float* positions, size_t positions_count,
                                           float* air, size_t air_count, float* push, size_t push_count,
                                           float* resist, size_t resist_count) {
    return guarded([&] {
        std::vector<Field> all;
        for (const rumple_force_field& field : rows<rumple_force_field>(fields, fields_count, "fields"))
            all.push_back(native_of<Field>(&field, "fields"));
        const auto points = vectors(positions, positions_count, "positions");
        const auto blows = output<Vec3>(air, air_count, points.size(), "air");
        const auto pushes = output<Vec3>(push, push_count, points.size(), "push");
        const auto resists = output<Vec2>(resist, resist_count, points.size(), "resist");
        const auto effects = force_fields::effects(all, frame, points);
        for (size_t i = 0; i < effects.size(); ++i) {
            blows[i] = effects[i].air;
            pushes[i] = effects[i].push;
            resists[i] = effects[i].resist;
        }
    });
}

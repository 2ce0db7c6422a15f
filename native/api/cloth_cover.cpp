// SPDX-License-Identifier: GPL-3.0-or-later
// The surface of the base cloth as it is shown: kept off bodies, without polygons that have turned over.
#include "api/handles.h"
#include "api/sound.h"
#include "rumple.h"
#include "surface/cloth/cover.h"
#include "surface/cloth/untangle.h"

using namespace rumple;
using namespace rumple::api;

struct rumple_cloth_cover {
    Surface surface;
    CoverModel cover;
};

template <typename Pair>
static void pair_fields(rumple_cloth_cover_settings& c, CoverSettings& native, const Pair& pair) {
    pair(c.thickness, native.thickness);
    pair(c.depth, native.depth);
}

rumple_status rumple_cloth_cover_build(const rumple_surface* surface, rumple_cloth_cover** cover) {
    return made(cover, "cover", [&] {
        const Surface& s = given(surface, "surface").surface;
        return new rumple_cloth_cover{s, build_cover(s)};
    });
}

void rumple_cloth_cover_free(rumple_cloth_cover* cover) {
    delete cover;
}

rumple_cloth_cover_settings rumple_cloth_cover_settings_default(void) {
    return default_of<rumple_cloth_cover_settings, CoverSettings>();
}

rumple_status rumple_cloth_cover_lift(const rumple_cloth_cover* cover,
                                      const rumple_cloth_cover_settings* settings,
                                      const rumple_bodies* bodies, const float* positions,
                                      size_t positions_count, const int32_t* hints, size_t hints_count,
                                      float* lifts, size_t lifts_count, float* room, size_t room_count) {
    return guarded([&] {
        const rumple_cloth_cover& c = given(cover, "cover");
        const auto options = native_of<CoverSettings>(settings, "settings");
        given(given(bodies, "bodies").collider, "bodies.collider");
        const auto worn_over = posed(bodies);
        const auto points = vectors(positions, positions_count, "positions");
        const auto near = values(hints, hints_count, "hints");
        const auto out = output<Vec3>(lifts, lifts_count, points.size(), "lifts");
        const auto room_out = output<float>(room, room_count, points.size(), "room");
        const Cover found = cover_over(c.surface, c.cover, options, *worn_over, points, near);
        write(sound(found.lifts), out);
        write(found.room, room_out);
    });
}

rumple_status rumple_cloth_untangle(const rumple_surface* surface, const float* animated,
                                    size_t animated_count, const float* positions, size_t positions_count,
                                    float* untangled_positions, size_t untangled_count) {
    return guarded([&] {
        const Surface& s = given(surface, "surface").surface;
        const auto from = vectors(animated, animated_count, "animated");
        const auto points = vectors(positions, positions_count, "positions");
        const auto out = output<Vec3>(untangled_positions, untangled_count, points.size(), "untangled");
        write(sound(untangled(s, from, points)), out);
    });
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Blends Wrinkle Maps by the influences of the bones of each vertex. UV2.x is the number of the vertex.
shader_type spatial;

const int WIDTH = 4096;               // texels of a row of the two tables
uniform sampler2D weights;            // of each vertex for each bone; filter off, as of the next one
uniform sampler2D influences;         // of each frame for each bone and pose, times the strength of the pose
uniform sampler2DArray maps;          // a layer for each pose; not sRGB
uniform sampler2D neutral_map;        // not sRGB
uniform int bones = 0;
uniform int poses = 0;                // at most 8: what varies is two vectors
uniform int frames = 1;
uniform float frame = 0.0;            // from 0 to frames - 1; parts of frames are mixed
uniform bool whole = false;           // "maps" of the JSON
uniform vec4 colour : hint_color = vec4(0.75, 0.6, 0.55, 1.0);
uniform bool show_normals = false;    // for the test: world space, Blender's axes

varying vec4 first_masks;
varying vec4 other_masks;

// Godot 3 has no other index of a vector than a constant.
vec4 unit(int number) {
    return vec4(number == 0 ? 1.0 : 0.0, number == 1 ? 1.0 : 0.0, number == 2 ? 1.0 : 0.0, number == 3 ? 1.0 : 0.0);
}

void vertex() {
    int number = int(UV2.x + 0.5);
    float at = clamp(frame, 0.0, float(frames - 1));
    int before = int(at) * bones * poses;
    int after = min(int(at) + 1, frames - 1) * bones * poses;
    first_masks = vec4(0.0);
    other_masks = vec4(0.0);
    for (int bone = 0; bone < bones; bone++) {
        int place = number * bones + bone;
        float weight = texelFetch(weights, ivec2(place % WIDTH, place / WIDTH), 0).r;
        for (int pose = 0; pose < poses; pose++) {
            int one = before + bone * poses + pose;
            int two = after + bone * poses + pose;
            float influence = mix(texelFetch(influences, ivec2(one % WIDTH, one / WIDTH), 0).r,
                                  texelFetch(influences, ivec2(two % WIDTH, two / WIDTH), 0).r, fract(at));
            first_masks += unit(pose) * weight * influence;
            other_masks += unit(pose - 4) * weight * influence;
        }
    }
}

// blend_wrinkles() and blend_whole() of shaders/shared/wrinkle_maps.glsl.
vec3 blended(vec3 sum, float total, vec3 neutral, bool is_whole) {
    float rest = max(0.0, 1.0 - total);
    if (is_whole) {
        return normalize(sum + rest * neutral);
    }
    vec3 wrinkles = normalize(sum + vec3(0.0, 0.0, rest));
    return normalize(vec3(wrinkles.xy + neutral.xy, wrinkles.z * neutral.z));
}

void fragment() {
    vec3 sum = vec3(0.0);
    float total = 0.0;
    for (int pose = 0; pose < poses; pose++) {
        float mask = dot(first_masks, unit(pose)) + dot(other_masks, unit(pose - 4));
        sum += mask * (2.0 * texture(maps, vec3(UV, float(pose))).rgb - 1.0);
        total += mask;
    }
    vec3 normal = blended(sum, total, 2.0 * texture(neutral_map, UV).rgb - 1.0, whole);
    NORMALMAP = 0.5 * normal + 0.5;
    NORMALMAP_DEPTH = 1.0;
    ALBEDO = colour.rgb;
    ROUGHNESS = 0.6;
    if (show_normals) {
        ALBEDO = vec3(0.0);
        vec3 shown = normalize(TANGENT * normal.x + BINORMAL * normal.y + NORMAL * normal.z);
        vec3 world = (CAMERA_MATRIX * vec4(shown, 0.0)).xyz;
        vec3 values = vec3(world.x, -world.z, world.y) * 0.5 + 0.5; // Blender's z is up
        // The picture is written as sRGB.
        EMISSION = mix(values / 12.92, pow((values + 0.055) / 1.055, vec3(2.4)), step(vec3(0.04045), values));
        SPECULAR = 0.0;
    }
}

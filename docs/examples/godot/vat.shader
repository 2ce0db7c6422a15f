// SPDX-License-Identifier: GPL-3.0-or-later
// Plays a vertex animation texture in OpenVAT's layout. UV2 has the texel of each vertex at the first frame.
shader_type spatial;
render_mode cull_disabled;

uniform sampler2D positions; // filter and mipmaps off, not sRGB; the same of normals
uniform sampler2D normals;
uniform vec3 least;          // os-remap: Min and Max
uniform vec3 most;
uniform int frames = 1;      // os-remap: Frames
uniform float frame = 0.0;   // from 0 to frames - 1; parts of frames are mixed
uniform vec4 colour : hint_color = vec4(0.45, 0.55, 0.7, 1.0);
uniform bool show_normals = false; // for the test: object space, Blender's axes

varying vec3 shown_normal;

void vertex() {
    ivec2 texel = ivec2(floor(UV2 * vec2(textureSize(positions, 0))));
    float at = clamp(frame, 0.0, float(frames - 1));
    ivec2 before = texel + ivec2(0, int(at));
    ivec2 after = texel + ivec2(0, min(int(at) + 1, frames - 1));
    vec3 share = mix(texelFetch(positions, before, 0).rgb, texelFetch(positions, after, 0).rgb, fract(at));
    vec3 moved = least + share * (most - least);
    vec3 normal = 2.0 * mix(texelFetch(normals, before, 0).rgb, texelFetch(normals, after, 0).rgb, fract(at)) - 1.0;
    VERTEX += vec3(moved.x, moved.z, -moved.y); // Blender's z is up
    NORMAL = normalize(vec3(normal.x, normal.z, -normal.y));
    shown_normal = normal;
}

void fragment() {
    ALBEDO = colour.rgb;
    ROUGHNESS = 0.9;
    if (show_normals) {
        ALBEDO = vec3(0.0);
        vec3 values = normalize(shown_normal) * 0.5 + 0.5;
        // The picture is written as sRGB.
        EMISSION = mix(values / 12.92, pow((values + 0.055) / 1.055, vec3(2.4)), step(vec3(0.04045), values));
        SPECULAR = 0.0;
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
// The four lights of Blender's Solid shading, like in its Workbench engine (workbench_world_light_lib.glsl), so that
// the preview looks like the rest of the viewport. View space.

// 1 / x by bit operations like Workbench, up to 12 % too small. An exact quotient would look different.
vec4 rough_reciprocal(vec4 x) { return intBitsToFloat(0x7eef370b - floatBitsToInt(x)); }

vec4 wrapped_light(vec4 facing, vec4 wrap) {
    vec4 wider = wrap + 1.0;
    return clamp((facing + wrap) * rough_reciprocal(wider * wider), 0.0, 1.0);
}

// n: unit normal; v: unit, towards the viewer. Returns a scene-linear colour.
vec3 lit(vec3 base, vec3 n, vec3 v) {
    vec4 wrap = vec4(preview.diffuse[0].w, preview.diffuse[1].w, preview.diffuse[2].w, preview.diffuse[3].w);
    vec4 facing = vec4(dot(preview.direction[0].xyz, n), dot(preview.direction[1].xyz, n),
                       dot(preview.direction[2].xyz, n), dot(preview.direction[3].xyz, n));
    vec4 diffuse = wrapped_light(facing, wrap);
    vec3 diffuse_light = preview.ambient.rgb;
    for (int i = 0; i < 4; ++i) diffuse_light += diffuse[i] * preview.diffuse[i].rgb;
    if (preview.specular_on <= 0.0) return diffuse_light * base;

    vec3 mirrored = reflect(-v, n);
    vec4 gloss = vec4(1.0 - preview.roughness) * (1.0 - wrap);
    vec4 shininess = exp2(10.0 * gloss + 1.0);
    vec4 half_way, along_mirror;
    for (int i = 0; i < 4; ++i) {
        vec3 l = preview.direction[i].xyz;
        half_way[i] = clamp(dot(normalize(l + v), n), 0.0, 1.0);
        along_mirror[i] = dot(l, mirrored);
    }
    vec4 highlight = pow(half_way, shininess) * clamp(facing, 0.0, 1.0) * (shininess * 0.125 + 1.0);
    vec4 surround = wrapped_light(along_mirror, mix(wrap, vec4(1.0), preview.roughness));
    vec4 specular = mix(highlight, surround, wrap * wrap);
    vec3 specular_light = preview.ambient.rgb;
    for (int i = 0; i < 4; ++i) specular_light += specular[i] * preview.specular[i].rgb;

    vec3 specular_color = mix(vec3(0.05), base, preview.metallic);
    float fresnel = exp2(-8.35 * clamp(dot(n, v), 0.0, 1.0)) * (1.0 - preview.roughness);
    specular_color = mix(specular_color, vec3(1.0), fresnel);
    vec3 diffuse_color = mix(base, vec3(0.0), preview.metallic);
    return diffuse_light * diffuse_color * (1.0 - dot(specular_color, vec3(0.33333))) + specular_light * specular_color;
}

// normal, place: object space; the normal need not be a unit vector.
vec4 drawn_color(vec3 base, vec3 normal, vec3 place) {
    vec3 shaded = mat3(preview.normal_to_view) * normal;
    shaded = normalize(gl_FrontFacing ? shaded : -shaded);
    vec3 to_viewer = preview.viewer.w > 0.0
                         ? -normalize((preview.model_view * vec4(place, 1.0)).xyz) : vec3(0.0, 0.0, 1.0);
    return vec4(lit(base, shaded, to_viewer), 1.0);
}

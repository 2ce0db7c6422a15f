// SPDX-License-Identifier: GPL-3.0-or-later
// "Render" (section 6), fragment stage: analytic normals, parallax, the viewport's studio light.

struct Wrinkle {
    float height;   // equation (5)
    vec3 gradient;  // equation (8)
};

// Waves finer than pixels would become noise, so waves fade out between 4 pixels and 2 pixels per wave.
float visible(float phase_here) { return clamp(2.0 - 4.0 * fwidth(phase_here) / kTwoPi, 0.0, 1.0); }

void add_wave(inout Wrinkle wrinkle, float phase_here, float weight_here, vec3 wave_vector) {
    ProfilePlace at = profile_place(phase_here);
    vec2 profile_here = mix(TEXEL(profile, at.index).xy, TEXEL(profile, at.index + 1).xy, at.fraction);
    weight_here *= visible(phase_here);
    wrinkle.height += weight_here * profile_here.x;
    wrinkle.gradient += weight_here * at.sign * profile_here.y * wave_vector;
}

void main() {
    Wrinkle wrinkle;
    wrinkle.height = 0.0;
    wrinkle.gradient = vec3(0.0);
    add_wave(wrinkle, phase.x, weight.x, vector_a);
    add_wave(wrinkle, phase.y, weight.y, vector_b);
    add_wave(wrinkle, phase.z, weight.z, vector_c);
    float length_squared = dot(normal, normal);
    vec3 n = length_squared > 0.0 ? normal * inversesqrt(length_squared) : vec3(0.0, 0.0, 1.0);
    vec3 base = preview.color.rgb;
    vec3 viewer = preview.viewer.w > 0.0 ? preview.viewer.xyz - place : preview.viewer.xyz;
    if (preview.has_image > 0.0) {
        vec3 shift = wrinkle.height * parallax(viewer, n);  // equation (10)
        base = texture(image, image_uv + vec2(dot(u_slope, shift), dot(v_slope, shift))).rgb;  // equation (11)
    }
    vec4 color = drawn_color(base, n - wrinkle.gradient, place);  // equation (7)
    out_color = under_overlays(color, ivec2(gl_FragCoord.xy - vec2(preview.left, preview.bottom)));
}

// SPDX-License-Identifier: GPL-3.0-or-later
// The parameters of a drawing besides textures. blender/viewport/preview.py fills them in, in this order.
struct Preview {
    mat4 model_view;
    mat4 projection;
    mat4 normal_to_view;
    vec4 viewer;        // object space: the eye with w = 1, or the direction to it with w = 0
    vec4 color;         // scene linear
    vec4 direction[4];  // of the lights, view space, unit
    vec4 diffuse[4];    // w: how far the light wraps round
    vec4 specular[4];
    vec4 ambient;
    float metallic;
    float roughness;
    float specular_on;
    float has_image;
    float nearer;  // share of the distance (perspective) or object units (orthographic)
    float left;    // of the viewport in its frame buffer, pixels
    float bottom;
    float unused;
};

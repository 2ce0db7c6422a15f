// SPDX-License-Identifier: GPL-3.0-or-later
// gl_Position of a place in object space, a little nearer than Blender's own drawing there. It moves towards the
// viewer, so it stays in the same pixel.
vec4 on_screen(vec3 place) {
    vec4 view = preview.model_view * vec4(place, 1.0);
    vec4 position = preview.projection * view;
    vec4 nearer = preview.projection * (preview.viewer.w > 0.0 ? vec4(view.xyz * (1.0 - preview.nearer), 1.0)
                                                               : view + vec4(0.0, 0.0, preview.nearer, 0.0));
    position.z = nearer.z / nearer.w * position.w;
    return position;
}

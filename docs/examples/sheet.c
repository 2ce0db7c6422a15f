/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * A square metre of cloth is squeezed by a fifth, in ten frames; the folded sheet is written as an OBJ.
 *
 *     cc -std=c11 -Inative/include docs/examples/sheet.c -Lbuild/release/python -lrumple -o sheet
 *     LD_LIBRARY_PATH=build/release/python ./sheet sheet.obj
 */
#include <stdio.h>
#include <stdlib.h>

#include "rumple.h"

enum { SIDE = 5, VERTICES = SIDE * SIDE, QUADS = (SIDE - 1) * (SIDE - 1), FRAMES = 10 };

static void check(rumple_status status) {
    if (status == RUMPLE_OK) return;
    fprintf(stderr, "rumple: %s\n", rumple_error());
    exit(EXIT_FAILURE);
}

static rumple_surface* make_surface(void) {
    static float positions[VERTICES][3];
    static int32_t polygon_start[QUADS + 1], corner_vertex[4 * QUADS], triangle_corner[2 * QUADS][3];
    for (int v = 0; v < VERTICES; ++v) {
        positions[v][0] = (float)(v % SIDE) / (SIDE - 1);
        positions[v][1] = (float)(v / SIDE) / (SIDE - 1);
    }
    for (int q = 0; q < QUADS; ++q) {
        const int first = q / (SIDE - 1) * SIDE + q % (SIDE - 1);
        const int corners[4] = {first, first + 1, first + 1 + SIDE, first + SIDE};
        polygon_start[q + 1] = 4 * (q + 1);
        for (int k = 0; k < 4; ++k) corner_vertex[4 * q + k] = corners[k];
        for (int k = 0; k < 3; ++k) {
            triangle_corner[2 * q][k] = 4 * q + k;
            triangle_corner[2 * q + 1][k] = 4 * q + (k + 2) % 4;
        }
    }
    rumple_surface_plan plan = rumple_surface_plan_default();
    plan.positions_rest = positions[0];
    plan.positions_rest_count = VERTICES;
    plan.polygon_start = polygon_start;
    plan.polygon_start_count = QUADS + 1;
    plan.corner_vertex = corner_vertex;
    plan.corner_vertex_count = 4 * QUADS;
    plan.triangle_corner = triangle_corner[0];
    plan.triangle_corner_count = 2 * QUADS;
    rumple_surface* surface = NULL;
    check(rumple_surface_build(&plan, &surface));
    return surface;
}

/* The sheet in a frame. */
static void squeeze(int frame, float positions[VERTICES][3]) {
    const float left = 1.0f - 0.2f * (float)frame / FRAMES;
    for (int v = 0; v < VERTICES; ++v) {
        positions[v][0] = left * (float)(v % SIDE) / (SIDE - 1);
        positions[v][1] = (float)(v / SIDE) / (SIDE - 1);
        positions[v][2] = 0.0f;
    }
}

static void write_obj(const char* path, const rumple_wrinkle_mesh* model, const rumple_frame* frame) {
    rumple_shown_mesh_view mesh;
    rumple_frame_view shown;
    check(rumple_shown_mesh_get_view(rumple_wrinkle_mesh_shown(model, false), &mesh));
    check(rumple_frame_get_view(frame, &shown));
    FILE* file = fopen(path, "w");
    if (!file) {
        perror(path);
        exit(EXIT_FAILURE);
    }
    for (int32_t v = 0; v < shown.vertex_count; ++v) {
        const float* p = shown.positions + 3 * v;
        fprintf(file, "v %.6g %.6g %.6g\n", (double)p[0], (double)p[1], (double)p[2]);
    }
    for (int32_t q = 0; q < mesh.polygon_count; ++q) {
        fputs("f", file);
        for (int32_t k = mesh.polygon_start[q]; k < mesh.polygon_start[q + 1]; ++k)
            fprintf(file, " %d", (int)mesh.corner_vertex[k] + 1);
        fputs("\n", file);
    }
    fclose(file);
    printf("%s: %d vertices, %d polygons\n", path, (int)shown.vertex_count, (int)mesh.polygon_count);
}

int main(int argc, char** argv) {
    if (argc != 2) {
        fprintf(stderr, "sheet FILE.obj\n");
        return EXIT_FAILURE;
    }
    rumple_surface* surface = make_surface();

    rumple_wrinkle_mesh_plan plan = rumple_wrinkle_mesh_plan_default();
    plan.fine.level = 3;
    rumple_wrinkle_mesh* model = NULL;
    check(rumple_wrinkle_mesh_build(surface, &plan, &model));
    rumple_surface_free(surface); /* what the model needs of it, it keeps */

    const rumple_wrinkle_mesh_settings settings = rumple_wrinkle_mesh_settings_default();
    rumple_wrinkle_mesh_state* state = NULL;
    rumple_wrinkle_mesh_report report = {0};
    float positions[VERTICES][3];
    rumple_wrinkle_mesh_pose* pose = NULL;
    rumple_pose at = rumple_pose_default();
    at.positions = positions[0];
    at.positions_count = VERTICES;
    for (int frame = 1; frame <= FRAMES; ++frame) {
        squeeze(frame, positions);
        rumple_wrinkle_mesh_state* next = NULL;
        rumple_wrinkle_mesh_pose_free(pose);
        check(rumple_wrinkle_mesh_pose_build(model, &at, &pose));
        check(rumple_wrinkle_mesh_solve(model, &settings, NULL, pose, state, &report, &next));
        rumple_wrinkle_mesh_state_free(state);
        state = next;
    }
    printf("edge length error %.3f before, %.3f after\n", (double)report.error_before,
           (double)report.error_after);

    rumple_frame* frame = NULL;
    check(rumple_wrinkle_mesh_show(model, &settings, pose, state, false, &frame));
    write_obj(argv[1], model, frame);

    rumple_frame_free(frame);
    rumple_wrinkle_mesh_pose_free(pose);
    rumple_wrinkle_mesh_state_free(state);
    rumple_wrinkle_mesh_free(model);
    return EXIT_SUCCESS;
}

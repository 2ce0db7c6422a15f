/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * Plays a clip through every system, by the C library alone, and prints a hash of all that came out:
 *
 *     rumple_clip [THREADS]
 *
 * The same bits come out on every system and with any number of threads. So the clip itself must be made of
 * nothing but + - * / and square roots.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rumple.h"

enum { FRAMES = 24, AROUND = 20, ALONG = 28, SIDE = 6, MOST_VERTICES = 1024 };

typedef struct garment {
    int32_t vertices, polygons, corners, triangles;
    float rest[MOST_VERTICES][3];
    int32_t polygon_start[2 * MOST_VERTICES + 1], corner_vertex[8 * MOST_VERTICES];
    int32_t triangle_corner[4 * MOST_VERTICES][3];
} garment;

static void check(rumple_status status) {
    if (status == RUMPLE_OK) return;
    fprintf(stderr, "rumple: %s\n", rumple_error());
    exit(EXIT_FAILURE);
}

/* ---- hashes: FNV-1a of bytes */

static uint64_t hash_of_all = 14695981039346656037u;

static uint64_t add_bytes(uint64_t hash, const void* data, size_t size) {
    const unsigned char* bytes = data;
    for (size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211u;
    return hash;
}

static void add_floats(uint64_t* hash, const float* values, size_t count) {
    *hash = add_bytes(*hash, values, count * sizeof(float));
}

static void print_hash(const char* name, uint64_t hash) {
    hash_of_all = add_bytes(hash_of_all, &hash, sizeof hash);
    printf("%-28s %016llx\n", name, (unsigned long long)hash);
}

/* ---- the garments */

/* A point of the unit circle; turn 0..4 in quarter turns. */
static void circle(float turn, float* x, float* y) {
    const int quarter = (int)turn;
    const float t = 0.4142136f * (2.0f * (turn - (float)quarter) - 1.0f); /* tan of half the angle */
    const float c = (1.0f - t * t) / (1.0f + t * t), s = 2.0f * t / (1.0f + t * t);
    const float u = 0.70710678f * (c - s), v = 0.70710678f * (c + s);
    const float points[4][2] = {{u, v}, {-v, u}, {-u, -v}, {v, -u}};
    *x = points[quarter % 4][0];
    *y = points[quarter % 4][1];
}

static void add_polygon(garment* g, int count, const int32_t* vertices) {
    const int32_t first = g->corners;
    for (int k = 0; k < count; ++k) g->corner_vertex[g->corners++] = vertices[k];
    for (int k = 0; k + 2 < count; ++k) {
        g->triangle_corner[g->triangles][0] = first;
        g->triangle_corner[g->triangles][1] = first + k + 1;
        g->triangle_corner[g->triangles++][2] = first + k + 2;
    }
    g->polygon_start[++g->polygons] = g->corners;
}

/* A tube along x. */
static void make_sleeve(garment* g, float radius) {
    memset(g, 0, sizeof *g);
    for (int ring = 0; ring <= ALONG; ++ring) {
        for (int k = 0; k < AROUND; ++k) {
            float* p = g->rest[g->vertices++];
            circle(4.0f * (float)k / AROUND, &p[1], &p[2]);
            p[0] = 0.7f * (float)ring / ALONG;
            p[1] *= radius;
            p[2] *= radius;
        }
    }
    for (int ring = 0; ring < ALONG; ++ring) {
        for (int k = 0; k < AROUND; ++k) {
            const int32_t a = ring * AROUND + k, b = ring * AROUND + (k + 1) % AROUND;
            const int32_t quad[4] = {a, b, b + AROUND, a + AROUND};
            add_polygon(g, 4, quad);
        }
    }
}

/* A closed cushion: the faces of a cube, each SIDE by SIDE, welded where they meet. Its corners have three
 * polygons; cut into triangles, from three to eight. */
static void make_cushion(garment* g, bool triangles) {
    memset(g, 0, sizeof *g);
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2, first = g->vertices;
        const float side = face % 2 ? 1.0f : -1.0f;
        for (int j = 0; j <= SIDE; ++j) {
            for (int i = 0; i <= SIDE; ++i) {
                float* p = g->rest[g->vertices++];
                const float x = 2.0f * (float)i / SIDE - 1.0f, y = 2.0f * (float)j / SIDE - 1.0f;
                p[axis] = 0.25f * side;
                p[(axis + 1) % 3] = 0.5f * side * x;
                p[(axis + 2) % 3] = 0.5f * y;
                if (axis != 0) p[0] *= 0.5f;
            }
        }
        for (int j = 0; j < SIDE; ++j) {
            for (int i = 0; i < SIDE; ++i) {
                const int32_t a = first + j * (SIDE + 1) + i;
                const int32_t quad[4] = {a, a + 1, a + SIDE + 2, a + SIDE + 1};
                const int32_t half[3] = {a, a + SIDE + 2, a + SIDE + 1};
                add_polygon(g, triangles ? 3 : 4, quad);
                if (triangles) add_polygon(g, 3, half);
            }
        }
    }
}

static rumple_surface* surface_of(const garment* g) {
    rumple_surface_plan plan = rumple_surface_plan_default();
    rumple_surface* surface = NULL;
    plan.positions_rest = g->rest[0];
    plan.positions_rest_count = (size_t)g->vertices;
    plan.polygon_start = g->polygon_start;
    plan.polygon_start_count = (size_t)g->polygons + 1;
    plan.corner_vertex = g->corner_vertex;
    plan.corner_vertex_count = (size_t)g->corners;
    plan.triangle_corner = g->triangle_corner[0];
    plan.triangle_corner_count = (size_t)g->triangles;
    plan.weld_seams = true;
    check(rumple_surface_build(&plan, &surface));
    return surface;
}

/* The garment in a frame: bent about the y axis at its middle, smoothly, and twisted a little. */
static void pose_of(const garment* g, int frame, float positions[MOST_VERTICES][3]) {
    const float bend = 0.6f * (float)frame / FRAMES; /* tan of half the angle at the far end */
    for (int v = 0; v < g->vertices; ++v) {
        const float* p = g->rest[v];
        float share = (p[0] - 0.2f) / 0.3f;
        share = share < 0.0f ? 0.0f : share > 1.0f ? 1.0f : share;
        const float t = bend * share * share * (3.0f - 2.0f * share);
        const float c = (1.0f - t * t) / (1.0f + t * t), s = 2.0f * t / (1.0f + t * t);
        const float twist = 0.2f * t, tc = 1.0f / sqrtf(1.0f + twist * twist), ts = twist * tc;
        const float y = tc * p[1] - ts * p[2], z = ts * p[1] + tc * p[2];
        positions[v][0] = 0.35f + c * (p[0] - 0.35f) - s * z;
        positions[v][1] = y;
        positions[v][2] = s * (p[0] - 0.35f) + c * z;
    }
}

static rumple_pose pose_at(int frame, const garment* g, const float* positions) {
    rumple_pose pose = rumple_pose_default();
    pose.positions = positions;
    pose.positions_count = (size_t)g->vertices;
    pose.time = (double)frame / 24.0;
    return pose;
}

static void add_frame(uint64_t* hash, rumple_frame* frame) {
    rumple_frame_view view;
    check(rumple_frame_get_view(frame, &view));
    add_floats(hash, view.positions, 3 * (size_t)view.vertex_count);
    add_floats(hash, view.local_offset, 3 * (size_t)view.vertex_count);
    add_floats(hash, view.stretch_min, (size_t)view.vertex_count);
    rumple_frame_free(frame);
}

/* ---- the systems */

static void play_mesh(const char* name, const garment* g, int threads, bool adaptive,
                      float clip[FRAMES][MOST_VERTICES][3]) {
    uint64_t hash = 0;
    rumple_surface* surface = surface_of(g);
    rumple_wrinkle_mesh_plan plan = rumple_wrinkle_mesh_plan_default();
    rumple_wrinkle_mesh_settings settings = rumple_wrinkle_mesh_settings_default();
    rumple_wrinkle_mesh* model = NULL;
    rumple_wrinkle_mesh_state *state = NULL, *next = NULL;
    plan.fine.source = RUMPLE_FINE_SUBDIVISION;
    plan.fine.level = 2;
    plan.fine.attachment = RUMPLE_ATTACH_LIMIT;
    plan.adaptive = adaptive;
    settings.rest.reference = adaptive ? RUMPLE_REFERENCE_FIRST_FRAME : RUMPLE_REFERENCE_STATIC_REST;
    settings.collision = RUMPLE_COLLISION_NEIGHBOURHOOD;
    settings.threads = threads;
    check(rumple_wrinkle_mesh_build(surface, &plan, &model));
    for (int frame = 0; frame < FRAMES; ++frame) {
        const rumple_pose at = pose_at(frame, g, clip[frame][0]);
        rumple_wrinkle_mesh_pose* pose = NULL;
        rumple_frame* shown = NULL;
        check(rumple_wrinkle_mesh_pose_build(model, &at, &pose));
        check(rumple_wrinkle_mesh_solve(model, &settings, NULL, pose, state, NULL, &next));
        rumple_wrinkle_mesh_state_free(state);
        state = next;
        check(rumple_wrinkle_mesh_show(model, &settings, pose, state, false, &shown));
        rumple_wrinkle_mesh_pose_free(pose);
        add_frame(&hash, shown);
    }
    print_hash(name, hash);
    rumple_wrinkle_mesh_state_free(state);
    rumple_wrinkle_mesh_free(model);
    rumple_surface_free(surface);
}

static void play_field(const char* name, const garment* g, int threads,
                       float clip[FRAMES][MOST_VERTICES][3]) {
    uint64_t hash = 0;
    rumple_surface* surface = surface_of(g);
    rumple_wrinkle_field_plan plan = rumple_wrinkle_field_plan_default();
    rumple_wrinkle_field_settings settings = rumple_wrinkle_field_settings_default();
    rumple_wrinkle_field_profile profile;
    rumple_wrinkle_field* model = NULL;
    rumple_wrinkle_field_state *state = NULL, *next = NULL;
    plan.output = RUMPLE_FIELD_GEOMETRY;
    plan.fine.source = RUMPLE_FINE_SUBDIVISION;
    plan.fine.level = 2;
    settings.wavelength = 0.06f;
    settings.irregularity = 0.4f;
    settings.dissolve = true;
    settings.threads = threads;
    check(rumple_wrinkle_field_profile_build(RUMPLE_PROFILE_PENCIL_PLEATS, NULL, 0, &profile));
    check(rumple_wrinkle_field_build(surface, &plan, &model));
    for (int frame = 0; frame < FRAMES; ++frame) {
        const rumple_pose at = pose_at(frame, g, clip[frame][0]);
        rumple_wrinkle_field_pose* pose = NULL;
        rumple_waves* waves = NULL;
        rumple_frame* shown = NULL;
        check(rumple_wrinkle_field_pose_build(model, &at, &pose));
        check(rumple_wrinkle_field_solve(model, &settings, NULL, pose, state, NULL, &waves, &next));
        rumple_wrinkle_field_state_free(state);
        state = next;
        check(
            rumple_wrinkle_field_show(model, &settings, &profile, NULL, pose, NULL, 0, waves, state, &shown));
        rumple_waves_free(waves);
        rumple_wrinkle_field_pose_free(pose);
        add_frame(&hash, shown);
    }
    print_hash(name, hash);
    rumple_wrinkle_field_state_free(state);
    rumple_wrinkle_field_free(model);
    rumple_surface_free(surface);
}

static void play_paths(const char* name, const garment* g, int threads, int profile,
                       float clip[FRAMES][MOST_VERTICES][3]) {
    uint64_t hash = 0;
    int32_t paths = 0;
    rumple_surface* surface = surface_of(g);
    rumple_fine_plan plan = rumple_wrinkle_paths_plan_default();
    rumple_wrinkle_paths_settings settings = rumple_wrinkle_paths_settings_default();
    rumple_wrinkle_paths* model = NULL;
    rumple_wrinkle_paths_state *state = NULL, *next = NULL;
    plan.source = RUMPLE_FINE_EDGE_LENGTH;
    plan.longest_edge = 0.02f;
    settings.width = 0.04f;
    settings.profile = profile;
    settings.threads = threads;
    check(rumple_wrinkle_paths_build(surface, &plan, &model));
    for (int frame = 0; frame < FRAMES; ++frame) {
        const rumple_pose at = pose_at(frame, g, clip[frame][0]);
        rumple_wrinkle_paths_pose* pose = NULL;
        rumple_wrinkle_paths_report report = {0};
        rumple_frame* shown = NULL;
        check(rumple_wrinkle_paths_pose_build(model, &at, &pose));
        check(rumple_wrinkle_paths_solve(model, &settings, NULL, pose, state, &report, &next));
        rumple_wrinkle_paths_state_free(state);
        state = next;
        paths += report.paths;
        check(rumple_wrinkle_paths_show(model, &settings, pose, state, &shown));
        rumple_wrinkle_paths_pose_free(pose);
        add_frame(&hash, shown);
    }
    if (paths == 0) {
        fprintf(stderr, "%s: no path was traced\n", name);
        exit(EXIT_FAILURE);
    }
    print_hash(name, hash);
    rumple_wrinkle_paths_state_free(state);
    rumple_wrinkle_paths_free(model);
    rumple_surface_free(surface);
}

/* The clip of the garment as cloth that swings around its animation, over a thinner tube. */
static void play_cloth(const char* name, const garment* g, float clip[FRAMES][MOST_VERTICES][3]) {
    static garment arm;
    static float arm_positions[MOST_VERTICES][3];
    uint64_t hash = 0;
    rumple_surface* surface = surface_of(g);
    rumple_base_cloth* model = NULL;
    rumple_base_cloth_state *state = NULL, *next = NULL;
    rumple_base_cloth_settings settings = rumple_base_cloth_settings_default();
    rumple_base_cloth_swing swing = rumple_base_cloth_swing_default();
    rumple_collider* collider = NULL;
    make_sleeve(&arm, 0.06f);
    int32_t triangles[4 * MOST_VERTICES][3];
    for (int t = 0; t < arm.triangles; ++t)
        for (int k = 0; k < 3; ++k) triangles[t][k] = arm.corner_vertex[arm.triangle_corner[t][k]];
    check(rumple_collider_build(arm.rest[0], (size_t)arm.vertices, triangles[0], (size_t)arm.triangles, NULL,
                                0, 0.0f, &collider));
    check(rumple_base_cloth_build(surface, &model));
    swing.seconds = 1.0f / 24.0f;
    for (int frame = 0; frame < FRAMES; ++frame) {
        rumple_base_cloth_state_view view;
        pose_of(&arm, frame, arm_positions);
        const rumple_bodies bodies = {collider, arm_positions[0], (size_t)arm.vertices};
        check(rumple_base_cloth_swing_solve(model, &settings, &swing, NULL, clip[frame][0],
                                            (size_t)g->vertices, &bodies, state, NULL, &next));
        rumple_base_cloth_state_free(state);
        state = next;
        check(rumple_base_cloth_state_get_view(state, &view));
        add_floats(&hash, view.positions, 3 * (size_t)view.vertex_count);
        memcpy(clip[frame], view.positions, 3 * (size_t)view.vertex_count * sizeof(float));
    }
    print_hash(name, hash);
    rumple_base_cloth_state_free(state);
    rumple_base_cloth_free(model);
    rumple_collider_free(collider);
    rumple_surface_free(surface);
}

static void play_maps(const char* name) {
    enum { BONES = 4, POSES = 2, VERTICES = 9 };
    uint64_t hash = 0;
    const char* const names[BONES] = {"jaw", "brow", "lip", "cheek"};
    const int32_t tracked[BONES] = {RUMPLE_TRACKED_BOTH, RUMPLE_TRACKED_HEAD, RUMPLE_TRACKED_TAIL, 2};
    const int32_t group[BONES] = {-1, 0, 0, -1};
    float neutral[BONES][6], posed[POSES][BONES][6], bones[BONES][6];
    int32_t weight_start[VERTICES + 1] = {0}, weight_bone[2 * VERTICES];
    float weight[2 * VERTICES], pose[BONES * POSES], rest[BONES], masks[POSES * VERTICES];
    for (int b = 0; b < BONES; ++b) {
        for (int k = 0; k < 6; ++k) {
            neutral[b][k] = (float)(b * 6 + k) / 7.0f;
            for (int p = 0; p < POSES; ++p)
                posed[p][b][k] = neutral[b][k] + (float)((b + 2 * k + 3 * p) % 5) / 11.0f;
        }
    }
    for (int v = 0; v < VERTICES; ++v) {
        weight_start[v + 1] = 2 * (v + 1);
        weight_bone[2 * v] = v % BONES;
        weight_bone[2 * v + 1] = (v + 1) % BONES;
        weight[2 * v] = (float)(v + 1) / 13.0f;
        weight[2 * v + 1] = 1.0f - weight[2 * v];
    }
    const rumple_wrinkle_maps_pose poses[POSES] = {{"smile", posed[0][0], BONES},
                                                   {"frown", posed[1][0], BONES}};
    const rumple_wrinkle_maps_plan plan = {
        names, BONES, tracked,      BONES,        group,       BONES,        neutral[0], BONES,
        poses, POSES, weight_start, VERTICES + 1, weight_bone, 2 * VERTICES, weight,     2 * VERTICES};
    rumple_wrinkle_maps* model = NULL;
    const rumple_wrinkle_maps_settings settings = rumple_wrinkle_maps_settings_default();
    check(rumple_wrinkle_maps_build(&plan, &model));
    for (int frame = 0; frame < FRAMES; ++frame) {
        const float share = (float)frame / FRAMES;
        for (int b = 0; b < BONES; ++b)
            for (int k = 0; k < 6; ++k)
                bones[b][k] = neutral[b][k] + share * (posed[frame % POSES][b][k] - neutral[b][k]);
        check(rumple_wrinkle_maps_evaluate(model, bones[0], BONES, pose, BONES * POSES, rest, BONES));
        check(rumple_wrinkle_maps_masks(model, &settings, pose, BONES * POSES, rest, BONES, masks,
                                        POSES * VERTICES));
        add_floats(&hash, pose, BONES * POSES);
        add_floats(&hash, masks, POSES * VERTICES);
    }
    print_hash(name, hash);
    rumple_wrinkle_maps_free(model);
}

int main(int argc, char** argv) {
    static garment sleeve, cushion;
    static float clip[FRAMES][MOST_VERTICES][3];
    const int threads = argc > 1 ? atoi(argv[1]) : 0;
    make_sleeve(&sleeve, 0.1f);
    for (int frame = 0; frame < FRAMES; ++frame) pose_of(&sleeve, frame, clip[frame]);
    play_cloth("base cloth, swinging", &sleeve, clip);
    play_mesh("wrinkle mesh on it", &sleeve, threads, false, clip);
    play_mesh("wrinkle mesh, adapting", &sleeve, threads, true, clip);
    play_field("wrinkle field on it", &sleeve, threads, clip);
    play_paths("wrinkle paths on it, spline", &sleeve, threads, RUMPLE_FOLD_SPLINE, clip);
    play_paths("wrinkle paths on it, arcs", &sleeve, threads, RUMPLE_FOLD_CIRCULAR_ARCS, clip);
    for (int triangles = 0; triangles < 2; ++triangles) {
        make_cushion(&cushion, triangles != 0);
        for (int frame = 0; frame < FRAMES; ++frame) pose_of(&cushion, frame, clip[frame]);
        play_mesh(triangles ? "wrinkle mesh, triangles" : "wrinkle mesh, polygons", &cushion, threads, false,
                  clip);
        play_field(triangles ? "wrinkle field, triangles" : "wrinkle field, polygons", &cushion, threads,
                   clip);
    }
    play_maps("wrinkle maps");
    printf("CLIP %016llx\n", (unsigned long long)hash_of_all);
    return EXIT_SUCCESS;
}

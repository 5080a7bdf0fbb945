/* Checks, and a world with a cube, for the programs of tests. */

#pragma once

#include "overcoat.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define UNUSED __attribute__((unused))

static int failures = 0;

#define CHECK(what)                                                         \
    do {                                                                    \
        if (!(what)) {                                                      \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #what);      \
            failures++;                                                     \
        }                                                                   \
    } while (0)

/* Status and the beginning of the message. */
UNUSED static void expect(overcoat *o, overcoat_status status, overcoat_status wanted, const char *part, int line) {
    if (status != wanted || !strstr(overcoat_message(o), part)) {
        fprintf(stderr, "%s:%d: %d '%s', not %d '%s'\n", __FILE__, line, (int)status, overcoat_message(o), (int)wanted, part);
        failures++;
    }
}
#define OK(call) expect(o, (call), OVERCOAT_OK, "", __LINE__)
#define FAILS(call, status, part) expect(o, (call), (status), (part), __LINE__)

static const float CUBE[] = {
    -1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1,
};
static const uint32_t FACES[] = {
    0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 2, 3, 7, 2, 7, 6, 1, 2, 6, 1, 6, 5, 0, 4, 7, 0, 7, 3,
};

UNUSED static overcoat_mesh cube(void) {
    overcoat_mesh mesh;
    OVERCOAT_INIT(mesh);
    mesh.positions = CUBE;
    mesh.vertex_count = 8;
    mesh.indices = FACES;
    mesh.triangle_count = 12;
    return mesh;
}

UNUSED static overcoat_picture small_picture(void) {
    overcoat_picture picture;
    OVERCOAT_INIT(picture);
    picture.width = 64;
    picture.height = 48;
    picture.quality = OVERCOAT_QUALITY_DRAFT;
    picture.settings = "{\"ground\": \"none\"}";
    return picture;
}

UNUSED static overcoat_target target_of(void *pixels, size_t length, uint32_t format) {
    overcoat_target target;
    OVERCOAT_INIT(target);
    target.pixels = pixels;
    target.length = length;
    target.format = format;
    return target;
}

/* A world with one cube of six colours. */
UNUSED static uint64_t cube_world(overcoat *o, uint64_t *instance, uint64_t *material) {
    uint64_t world = 0, mesh = 0;
    uint8_t colors[12 * 4];
    for (int face = 0; face < 12; face++) {
        const uint8_t color[4] = {(uint8_t)(40 + 40 * (face / 2)), 90, (uint8_t)(240 - 40 * (face / 2)), 255};
        memcpy(colors + 4 * face, color, 4);
    }
    overcoat_mesh own = cube();
    own.face_colors = colors;
    overcoat_material paint;
    OVERCOAT_INIT(paint);
    OK(overcoat_world_new(o, &world));
    OK(overcoat_add_mesh(o, world, &own, &mesh));
    OK(overcoat_add_material(o, world, &paint, material));
    OK(overcoat_add_instance(o, world, mesh, *material, NULL, instance));
    return world;
}

/* The hash of a small picture of a world. */
UNUSED static void hash_of(overcoat *o, uint64_t world, char *hash) {
    overcoat_picture picture = small_picture();
    picture.wants_hash = true;
    static uint8_t pixels[64 * 48 * 4];
    overcoat_target target = target_of(pixels, sizeof pixels, OVERCOAT_RGBA8);
    overcoat_result result;
    OVERCOAT_INIT(result);
    OK(overcoat_render(o, world, NULL, &picture, &target, &result));
    strcpy(hash, result.hash);
}

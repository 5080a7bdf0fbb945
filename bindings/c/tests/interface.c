/* The interface as a program uses it: rightly, wrongly, and from several threads.
 *
 *     interface MODEL HASH
 *
 * MODEL is a file; HASH is what `overcoat render MODEL --size 96x64 --json` says of it. */

#include "overcoat.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "check.h"

static void draws_the_picture_of_the_command(overcoat *o, const char *path, const char *hash) {
    uint64_t world, model;
    OK(overcoat_world_new(o, &world));
    OK(overcoat_load_file(o, world, path, NULL, NULL, NULL, &model));
    overcoat_picture picture;
    OVERCOAT_INIT(picture);
    picture.width = 96;
    picture.height = 64;
    picture.wants_hash = true;
    static uint8_t pixels[96 * 64 * 4];
    overcoat_target target = target_of(pixels, sizeof pixels, OVERCOAT_RGBA8);
    overcoat_result result;
    OVERCOAT_INIT(result);
    OK(overcoat_render(o, world, NULL, &picture, &target, &result));
    if (strcmp(result.hash, hash) != 0) {
        fprintf(stderr, "hash %s, not %s\n", result.hash, hash);
        failures++;
    }
    CHECK(result.samples == 8 && result.quality == OVERCOAT_QUALITY_FAST && result.is_final && result.triangles > 0);
    /* The same from memory. */
    FILE *file = fopen(path, "rb");
    fseek(file, 0, SEEK_END);
    size_t length = (size_t)ftell(file);
    rewind(file);
    uint8_t *bytes = malloc(length);
    CHECK(fread(bytes, 1, length, file) == length);
    fclose(file);
    uint64_t again, copy;
    OK(overcoat_world_new(o, &again));
    OK(overcoat_load_memory(o, again, bytes, length, "glb", NULL, NULL, NULL, &copy));
    free(bytes);
    OVERCOAT_INIT(result);
    OK(overcoat_render(o, again, NULL, &picture, &target, &result));
    CHECK(strcmp(result.hash, hash) == 0);
    size_t count = 0;
    OK(overcoat_model_instances(o, again, copy, NULL, 0, &count));
    CHECK(count > 0);
    OK(overcoat_remove_model(o, again, copy));
    FAILS(overcoat_set_pose(o, again, copy, 0.0), OVERCOAT_GONE, "model is not there");
    OK(overcoat_world_free(o, again));
    OK(overcoat_world_free(o, world));
}

static void formats_and_parts_agree(overcoat *o) {
    uint64_t instance, material, world = cube_world(o, &instance, &material);
    overcoat_picture picture = small_picture();
    static uint8_t whole[64 * 48 * 4], other[64 * 48 * 4 + 7 * 48];
    overcoat_target target = target_of(whole, sizeof whole, OVERCOAT_RGBA8);
    OK(overcoat_render(o, world, NULL, &picture, &target, NULL));
    int colours = 0;
    for (size_t k = 0; k < sizeof whole; k += 4) colours += whole[k + 3] == 255;
    CHECK(colours > 300);
    target = target_of(other, sizeof other, OVERCOAT_BGRA8);
    target.stride = 64 * 4 + 7;
    memset(other, 0xab, sizeof other);
    OK(overcoat_render(o, world, NULL, &picture, &target, NULL));
    for (size_t y = 0; y < 48; y++) {
        const uint8_t *row = other + y * target.stride;
        for (size_t x = 0; x < 64; x++) {
            const uint8_t *a = whole + 4 * (64 * y + x), *b = row + 4 * x;
            CHECK(a[0] == b[2] && a[1] == b[1] && a[2] == b[0] && a[3] == b[3]);
        }
        for (size_t x = 64 * 4; x < target.stride; x++) CHECK(y == 47 || row[x] == 0xab);
    }
    uint8_t part[10 * 6 * 4];
    target = target_of(part, sizeof part, OVERCOAT_RGBA8);
    const uint32_t region[4] = {27, 20, 10, 6};
    memcpy(target.region, region, sizeof region);
    OK(overcoat_render(o, world, NULL, &picture, &target, NULL));
    for (size_t y = 0; y < 6; y++) CHECK(memcmp(part + 40 * y, whole + 4 * (64 * (20 + y) + 27), 40) == 0);

    /* What does not fit. */
    target = target_of(whole, sizeof whole - 1, OVERCOAT_RGBA8);
    FAILS(overcoat_render(o, world, NULL, &picture, &target, NULL), OVERCOAT_INVALID_ARGUMENT, "buffer: 12287 bytes");
    target = target_of(NULL, 64, OVERCOAT_RGBA8);
    FAILS(overcoat_render(o, world, NULL, &picture, &target, NULL), OVERCOAT_INVALID_ARGUMENT, "pixels: null");
    target = target_of(whole, sizeof whole, 7);
    FAILS(overcoat_render(o, world, NULL, &picture, &target, NULL), OVERCOAT_INVALID_ARGUMENT, "format: 7");
    target = target_of(whole, sizeof whole, OVERCOAT_RGBA8);
    target.stride = 3;
    FAILS(overcoat_render(o, world, NULL, &picture, &target, NULL), OVERCOAT_INVALID_ARGUMENT, "stride");
    target.stride = 0;
    picture.settings = "{\"qualty\": \"best\"}";
    FAILS(overcoat_render(o, world, NULL, &picture, &target, NULL), OVERCOAT_INVALID_ARGUMENT, "settings: ");
    picture = small_picture();
    picture.samples = 3;
    FAILS(overcoat_render(o, world, NULL, &picture, &target, NULL), OVERCOAT_OUT_OF_RANGE, "samples");
    picture = small_picture();
    picture.shading = "cel";
    FAILS(overcoat_render(o, world, NULL, &picture, &target, NULL), OVERCOAT_INVALID_ARGUMENT, "shading: 'cel'");
    picture = small_picture();
    picture.width = 1000000;
    CHECK(overcoat_render(o, world, NULL, &picture, &target, NULL) != OVERCOAT_OK);
    picture.size = 0;
    FAILS(overcoat_render(o, world, NULL, &picture, &target, NULL), OVERCOAT_INVALID_ARGUMENT, "picture: null, or its size");
    /* A program that knows less of the structure: the rest is 0. */
    picture = small_picture();
    picture.size = offsetof(overcoat_picture, samples);
    picture.samples = 77;
    OK(overcoat_render(o, world, NULL, &picture, &target, NULL));
    OK(overcoat_world_free(o, world));
}

static void picks_and_changes(overcoat *o) {
    uint64_t instance, material, world = cube_world(o, &instance, &material);
    overcoat_picture picture = small_picture();
    overcoat_camera camera;
    OVERCOAT_INIT(camera);
    const float front[3] = {0, 0, 1};
    OK(overcoat_frame(o, world, front, 64.0f / 48.0f, &camera));
    CHECK(camera.eye[2] > 2 && fabsf(camera.eye[0]) < 1e-5f && camera.fov_y > 0);
    overcoat_hit hit;
    OVERCOAT_INIT(hit);
    OK(overcoat_pick(o, world, &camera, &picture, 32, 24, &hit));
    CHECK(hit.instance == instance && hit.model == 0 && (hit.triangle == 2 || hit.triangle == 3));
    CHECK(fabs(hit.position[2] - 1) < 1e-6 && fabsf(hit.depth - (camera.eye[2] - 1)) < 1e-4f);
    CHECK(fabsf(hit.barycentric[0] + hit.barycentric[1] + hit.barycentric[2] - 1) < 1e-5f);
    OK(overcoat_pick(o, world, &camera, &picture, 0, 0, &hit));
    CHECK(hit.instance == 0);
    FAILS(overcoat_pick(o, world, &camera, &picture, 64, 0, &hit), OVERCOAT_OUT_OF_RANGE, "pixel");

    double matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 9, 0, 0, 1};
    OK(overcoat_set_transform(o, world, instance, matrix));
    OK(overcoat_pick(o, world, &camera, &picture, 32, 24, &hit));
    CHECK(hit.instance == 0);
    matrix[12] = NAN;
    FAILS(overcoat_set_transform(o, world, instance, matrix), OVERCOAT_OUT_OF_RANGE, "transform is not a finite number");
    OK(overcoat_set_transform(o, world, instance, NULL));
    OK(overcoat_set_visible(o, world, instance, false));
    OK(overcoat_pick(o, world, &camera, &picture, 32, 24, &hit));
    CHECK(hit.instance == 0);
    OK(overcoat_set_visible(o, world, instance, true));

    overcoat_material paint;
    OVERCOAT_INIT(paint);
    CHECK(paint.base_color[3] == 1 && paint.roughness == 1 && paint.size == sizeof paint);
    paint.coat = 2;
    FAILS(overcoat_set_material(o, world, material, &paint), OVERCOAT_OUT_OF_RANGE, "coat");
    paint.coat = 1;
    paint.shading = "stacklit";
    OK(overcoat_set_material(o, world, material, &paint));
    FAILS(overcoat_remove_material(o, world, material), OVERCOAT_IN_USE, "material is in use, by instance 0");

    overcoat_light light;
    OVERCOAT_INIT(light);
    CHECK(light.intensity == 1 && light.direction[1] == -1 && light.size == sizeof light);
    uint64_t sun;
    OK(overcoat_add_light(o, world, &light, &sun));
    light.intensity = -1;
    FAILS(overcoat_set_light(o, world, sun, &light), OVERCOAT_OUT_OF_RANGE, "light intensity");
    OK(overcoat_remove_light(o, world, sun));
    FAILS(overcoat_remove_light(o, world, sun), OVERCOAT_GONE, "light");
    OK(overcoat_set_environment(o, world, OVERCOAT_ENVIRONMENT_NONE, NULL, 0, 0, 1));
    FAILS(overcoat_set_environment(o, world, 9, NULL, 0, 0, 1), OVERCOAT_INVALID_ARGUMENT, "kind: 9");
    FAILS(overcoat_set_environment(o, world, OVERCOAT_ENVIRONMENT_MEMORY, "junk", 4, 0, 1), OVERCOAT_MALFORMED, "neither");
    OK(overcoat_set_environment(o, world, OVERCOAT_ENVIRONMENT_STUDIO, NULL, 0, 30, 1));

    /* Another world's, and what is gone. */
    uint64_t elsewhere;
    OK(overcoat_world_new(o, &elsewhere));
    FAILS(overcoat_set_visible(o, elsewhere, instance, true), OVERCOAT_GONE, "another world");
    OK(overcoat_remove_instance(o, world, instance));
    FAILS(overcoat_remove_instance(o, world, instance), OVERCOAT_GONE, "instance");
    FAILS(overcoat_set_visible(o, world, 0, true), OVERCOAT_GONE, "");
    FAILS(overcoat_set_visible(o, world, UINT64_MAX, true), OVERCOAT_GONE, "");
    OK(overcoat_world_free(o, world));
    FAILS(overcoat_world_free(o, world), OVERCOAT_GONE, "world is not there");
    FAILS(overcoat_set_visible(o, world, instance, true), OVERCOAT_GONE, "world");
    OK(overcoat_world_free(o, elsewhere));
}

static void materials_have_texts(overcoat *o) {
    /* A red and a blue pixel. */
    static const uint8_t png[] = {
        137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 2, 0, 0, 0, 1, 8, 2, 0, 0, 0, 123, 64,
        232, 221, 0, 0, 0, 13, 73, 68, 65, 84, 120, 156, 99, 248, 207, 0, 4, 255, 1, 7, 0, 1, 255, 226, 35, 158, 89,
        0, 0, 0, 0, 73, 69, 78, 68, 174, 66, 96, 130};
    uint64_t instance, material, world = cube_world(o, &instance, &material);
    char plain[33], candy[33], same[33], dark[33], coated[33];
    hash_of(o, world, plain);
    OK(overcoat_set_material_text(o, world, material, "candy-red", NULL, 0));
    hash_of(o, world, candy);
    CHECK(strcmp(plain, candy) != 0);
    OK(overcoat_set_material_text(o, world, material, "over = true\ncoat_extinction = [0.1, 4, 4]", NULL, 0));
    hash_of(o, world, dark);
    CHECK(strcmp(candy, dark) != 0);
    uint64_t other;
    OK(overcoat_add_material_text(o, world, "base_color = [0.2, 0.3, 0.4]\nmodel = \"openpbr\"\ncoat = 1\ncoat_ior = 1.7", NULL, 0, &other));
    OK(overcoat_set_instance_material(o, world, instance, other));
    hash_of(o, world, coated);
    CHECK(strcmp(coated, dark) != 0);

    /* Textures come from memory; a second file stands where the size of the first says. */
    overcoat_file files[2];
    for (int k = 0; k < 2; k++) {
        OVERCOAT_INIT(files[k]);
        files[k].name = k ? "colors.png" : "unused.png";
        files[k].bytes = png;
        files[k].length = sizeof png;
    }
    const char *textured = "base_color_texture = \"colors.png\"\nroughness = 0.5";
    OK(overcoat_set_material_text(o, world, other, textured, files, 2));
    hash_of(o, world, same);
    CHECK(strcmp(same, coated) != 0);
    FAILS(overcoat_set_material_text(o, world, other, textured, files, 1), OVERCOAT_MALFORMED, "colors.png");
    FAILS(overcoat_set_material_text(o, world, other, textured, NULL, 2), OVERCOAT_INVALID_ARGUMENT, "files: null");
    FAILS(overcoat_set_material_text(o, world, other, textured, files, SIZE_MAX), OVERCOAT_INVALID_ARGUMENT, "files: null, too many");
    files[0].size = 0;
    FAILS(overcoat_set_material_text(o, world, other, textured, files, 2), OVERCOAT_INVALID_ARGUMENT, "their size is not set");
    files[0].size = sizeof files[0];
    files[1].name = NULL;
    FAILS(overcoat_set_material_text(o, world, other, textured, files, 2), OVERCOAT_INVALID_ARGUMENT, "name is null");
    FAILS(overcoat_set_material_text(o, world, other, "rougness = 1", NULL, 0), OVERCOAT_MALFORMED, "roughness");
    FAILS(overcoat_set_material_text(o, world, other, "coat = 7", NULL, 0), OVERCOAT_MALFORMED, "coat");
    FAILS(overcoat_set_material_text(o, world, other, NULL, NULL, 0), OVERCOAT_INVALID_ARGUMENT, "text: null");
    FAILS(overcoat_set_material_text(o, world, 77777, "coat = 1", NULL, 0), OVERCOAT_GONE, "material");
    FAILS(overcoat_add_material_text(o, 77777, "coat = 1", NULL, 0, &other), OVERCOAT_GONE, "world");
    hash_of(o, world, coated);
    CHECK(strcmp(same, coated) == 0);
    OK(overcoat_world_free(o, world));
}

static void bad_meshes_and_files_are_refused(overcoat *o) {
    uint64_t world, mesh, model;
    OK(overcoat_world_new(o, &world));
    overcoat_mesh own = cube();
    own.positions = NULL;
    FAILS(overcoat_add_mesh(o, world, &own, &mesh), OVERCOAT_INVALID_ARGUMENT, "positions: null");
    own = cube();
    own.vertex_count = 7;
    FAILS(overcoat_add_mesh(o, world, &own, &mesh), OVERCOAT_OUT_OF_RANGE, "refers to vertex 7 of 7");
    own = cube();
    own.indices = NULL;
    FAILS(overcoat_add_mesh(o, world, &own, &mesh), OVERCOAT_INVALID_ARGUMENT, "8 vertices without indices");
    own = cube();
    own.vertex_count = SIZE_MAX / 4;
    FAILS(overcoat_add_mesh(o, world, &own, &mesh), OVERCOAT_INVALID_ARGUMENT, "positions: ");
    own = cube();
    own.position_stride = 13;
    FAILS(overcoat_add_mesh(o, world, &own, &mesh), OVERCOAT_INVALID_ARGUMENT, "position_stride: 13");
    float positions[9] = {0, 0, 0, 1, 0, 0, 0, NAN, 0};
    own = cube();
    own.positions = positions;
    own.vertex_count = 3;
    own.indices = NULL;
    FAILS(overcoat_add_mesh(o, world, &own, &mesh), OVERCOAT_OUT_OF_RANGE, "position is not a finite number");
    FAILS(overcoat_add_mesh(o, world, NULL, &mesh), OVERCOAT_INVALID_ARGUMENT, "mesh: null");
    const uint8_t junk[] = "no model at all";
    FAILS(overcoat_load_memory(o, world, junk, sizeof junk, NULL, NULL, NULL, NULL, &model), OVERCOAT_MALFORMED, "format is not known");
    FAILS(overcoat_load_memory(o, world, junk, sizeof junk, "jpg", NULL, NULL, NULL, &model), OVERCOAT_INVALID_ARGUMENT, "format: 'jpg'");
    FAILS(overcoat_load_memory(o, world, NULL, 9, NULL, NULL, NULL, NULL, &model), OVERCOAT_INVALID_ARGUMENT, "bytes: null");
    FAILS(overcoat_load_file(o, world, "/nowhere/x.glb", NULL, NULL, NULL, &model), OVERCOAT_IO, "/nowhere/x.glb: ");
    FAILS(overcoat_load_file(o, world, "\xff", NULL, NULL, NULL, &model), OVERCOAT_INVALID_ARGUMENT, "UTF-8");
    OK(overcoat_world_free(o, world));
}

static void refines_to_the_end(overcoat *o) {
    uint64_t instance, material, world = cube_world(o, &instance, &material);
    overcoat_picture picture = small_picture();
    picture.quality = OVERCOAT_QUALITY_GOOD;
    static uint8_t pixels[64 * 48 * 4], at_once[64 * 48 * 4];
    overcoat_target target = target_of(pixels, sizeof pixels, OVERCOAT_XRGB8);
    for (int round = 0; round < 2; round++) {
        for (uint32_t quality = OVERCOAT_QUALITY_DRAFT; quality <= OVERCOAT_QUALITY_GOOD; quality++) {
            bool drawn = false;
            overcoat_result result;
            OVERCOAT_INIT(result);
            OK(overcoat_refine(o, world, NULL, &picture, &target, &drawn, &result));
            CHECK(drawn && result.quality == quality && result.is_final == (quality == OVERCOAT_QUALITY_GOOD));
        }
        bool drawn = true;
        OK(overcoat_refine(o, world, NULL, &picture, &target, &drawn, NULL));
        CHECK(!drawn);
        double matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.25, 0, 0, 1};
        if (round == 0) OK(overcoat_set_transform(o, world, instance, matrix));
    }
    target.pixels = at_once;
    OK(overcoat_render(o, world, NULL, &picture, &target, NULL));
    CHECK(memcmp(pixels, at_once, sizeof pixels) == 0);
    OK(overcoat_world_free(o, world));
}

struct draw {
    overcoat *o;
    uint64_t world;
    overcoat_status status;
    volatile bool ended;
};

static void *draw_long(void *argument) {
    struct draw *own = argument;
    overcoat_picture picture = small_picture();
    picture.width = picture.height = 2048;
    picture.quality = OVERCOAT_QUALITY_BEST;
    picture.samples = 16;
    void *pixels = malloc(2048 * 2048 * 4);
    overcoat_target target = target_of(pixels, 2048 * 2048 * 4, OVERCOAT_RGBA8);
    own->status = overcoat_render(own->o, own->world, NULL, &picture, &target, NULL);
    free(pixels);
    own->ended = true;
    return NULL;
}

static void a_picture_is_stopped_from_elsewhere(overcoat *o) {
    uint64_t instance, material, world = cube_world(o, &instance, &material);
    struct draw own = {o, world, OVERCOAT_OK, false};
    pthread_t thread;
    CHECK(pthread_create(&thread, NULL, draw_long, &own) == 0);
    /* It may not have begun: until it has ended. */
    for (int k = 0; k < 100000 && !own.ended; k++) {
        overcoat_cancel(o);
        usleep(1000);
    }
    pthread_join(thread, NULL);
    CHECK(own.status == OVERCOAT_CANCELLED);
    /* And what comes after is drawn. */
    overcoat_picture picture = small_picture();
    static uint8_t pixels[64 * 48 * 4];
    overcoat_target target = target_of(pixels, sizeof pixels, OVERCOAT_RGBA8);
    OK(overcoat_render(o, world, NULL, &picture, &target, NULL));
    OK(overcoat_world_free(o, world));
}

static void encodes_png(overcoat *o) {
    uint8_t pixels[2 * 3 * 4], *bytes = NULL;
    size_t length = 0;
    memset(pixels, 200, sizeof pixels);
    OK(overcoat_encode_png(o, pixels, 2, 3, 0, &bytes, &length));
    CHECK(length > 40 && memcmp(bytes, "\x89PNG\r\n\x1a\n", 8) == 0);
    overcoat_bytes_free(bytes, length);
    overcoat_bytes_free(NULL, 9);
    FAILS(overcoat_encode_png(o, pixels, 0, 3, 0, &bytes, &length), OVERCOAT_INVALID_ARGUMENT, "0 x 3");
    FAILS(overcoat_encode_png(o, NULL, 2, 3, 0, &bytes, &length), OVERCOAT_INVALID_ARGUMENT, "pixels: null");
}

int main(int count, char **arguments) {
    if (count != 3) {
        fprintf(stderr, "usage: interface MODEL HASH\n");
        return 2;
    }
    CHECK(overcoat_version() >= 100);
    overcoat *o = NULL;
    overcoat_options options;
    OVERCOAT_INIT(options);
    options.threads = 1000;
    CHECK(overcoat_new(&options, &o) == OVERCOAT_OUT_OF_RANGE && o == NULL);
    CHECK(overcoat_new(NULL, NULL) == OVERCOAT_INVALID_ARGUMENT);
    options.threads = 2;
    CHECK(overcoat_new(&options, &o) == OVERCOAT_OK && o != NULL);
    draws_the_picture_of_the_command(o, arguments[1], arguments[2]);
    formats_and_parts_agree(o);
    picks_and_changes(o);
    materials_have_texts(o);
    bad_meshes_and_files_are_refused(o);
    refines_to_the_end(o);
    a_picture_is_stopped_from_elsewhere(o);
    encodes_png(o);
    overcoat_free(&o);
    CHECK(o == NULL);
    overcoat_free(&o);
    overcoat_free(NULL);
    /* After it is freed. */
    uint64_t world;
    CHECK(overcoat_world_new(o, &world) == OVERCOAT_INVALID_ARGUMENT);
    CHECK(strcmp(overcoat_message(o), "there is no overcoat") == 0);
    overcoat_cancel(o);
    if (failures == 0) printf("all is well\n");
    return failures != 0;
}

/* Materials by name, textures of pixels, planes, cameras, lines, points, encoders and the floating-point mode: rightly and wrongly. */

#include "overcoat.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include "check.h"

static void set(overcoat *o, uint64_t world, uint64_t material, const char *name, float value) {
    OK(overcoat_material_set(o, world, material, name, &value, 1));
}

/* Parameters that were set are told by the same names, in as much memory as there is. */
static void parameters_are_told(overcoat *o) {
    uint64_t instance, material, world = cube_world(o, &instance, &material);
    const float red[4] = {0.5f, 0.02f, 0.1f, 0.75f};
    float found[5] = {9, 9, 9, 9, 9};
    char text[40];
    size_t count = 0;
    OK(overcoat_set_material_text(o, world, material, "description = \"\"", NULL, 0));
    OK(overcoat_material_set(o, world, material, "base_color", red, 4));
    set(o, world, material, "roughness", 0.3f);
    set(o, world, material, "double_sided", 1);
    set(o, world, material, "anisotropy_rotation", 30);
    set(o, world, material, "options.stacklit_newest", 1);
    OK(overcoat_material_set_text(o, world, material, "alpha_mode", "blend"));

    OK(overcoat_material_get(o, world, material, "base_color", NULL, 0, &count));
    CHECK(count == 4);
    OK(overcoat_material_get(o, world, material, "base_color", found, 2, &count));
    CHECK(count == 4 && found[0] == red[0] && found[1] == red[1] && found[2] == 9);
    OK(overcoat_material_get(o, world, material, "base_color", found, 5, &count));
    CHECK(count == 4 && memcmp(found, red, sizeof red) == 0 && found[4] == 9);
    OK(overcoat_material_get(o, world, material, "roughness", found, 5, NULL));
    CHECK(found[0] == 0.3f);
    OK(overcoat_material_get(o, world, material, "anisotropy_rotation", found, 5, &count));
    CHECK(count == 1 && fabsf(found[0] - 30) < 1e-5f);
    OK(overcoat_material_get(o, world, material, "double_sided", found, 5, &count));
    CHECK(count == 1 && found[0] == 1);
    OK(overcoat_material_get(o, world, material, "options.stacklit_newest", found, 5, &count));
    CHECK(count == 1 && found[0] == 1);
    OK(overcoat_material_get(o, world, material, "base_color_texture", found, 5, &count));
    CHECK(count == 1 && found[0] == 0);
    /* Never set: what it is without. */
    OK(overcoat_material_get(o, world, material, "ior", found, 5, &count));
    CHECK(count == 1 && found[0] == 1.5f);

    OK(overcoat_material_get_text(o, world, material, "alpha_mode", text, sizeof text, &count));
    CHECK(count == 5 && strcmp(text, "blend") == 0);
    OK(overcoat_material_get_text(o, world, material, "alpha_mode", text, 3, &count));
    CHECK(count == 5 && strcmp(text, "bl") == 0);
    OK(overcoat_material_get_text(o, world, material, "alpha_mode", NULL, 0, &count));
    CHECK(count == 5);
    OK(overcoat_material_get_text(o, world, material, "base_color", text, sizeof text, &count));
    CHECK(strcmp(text, "[0.5, 0.02, 0.1, 0.75]") == 0 && count == strlen(text));
    OK(overcoat_material_get_text(o, world, material, "double_sided", text, sizeof text, NULL));
    CHECK(strcmp(text, "true") == 0);

    FAILS(overcoat_material_get(o, world, material, "cot", found, 5, &count), OVERCOAT_INVALID_ARGUMENT, "no parameter 'cot'");
    FAILS(overcoat_material_get(o, world, material, "over", found, 5, &count), OVERCOAT_INVALID_ARGUMENT, "no parameter 'over'");
    FAILS(overcoat_material_get(o, world, material, "alpha_mode", found, 5, &count), OVERCOAT_INVALID_ARGUMENT, "overcoat_material_get_text()");
    FAILS(overcoat_material_get(o, world, material, "coat", NULL, 1, &count), OVERCOAT_INVALID_ARGUMENT, "values_out: null");
    FAILS(overcoat_material_get(o, world, material, NULL, found, 1, &count), OVERCOAT_INVALID_ARGUMENT, "name: null");
    FAILS(overcoat_material_get(o, world, 999, "coat", found, 1, &count), OVERCOAT_GONE, "material");
    FAILS(overcoat_material_get_text(o, world, material, "cot", text, 9, &count), OVERCOAT_INVALID_ARGUMENT, "no parameter 'cot'");
    FAILS(overcoat_material_get_text(o, world, material, "coat", NULL, 9, &count), OVERCOAT_INVALID_ARGUMENT, "text_out: null");
    OK(overcoat_world_free(o, world));
}

static void parameters_have_names(overcoat *o) {
    uint64_t instance, material, by_text, world = cube_world(o, &instance, &material);
    char one_by_one[33], at_once[33], json[33];
    const float red[3] = {0.5f, 0.02f, 0.02f}, clear[4] = {0.5f, 0.02f, 0.02f, 1};
    /* All that there is before is left: the defaults of materials by text. */
    OK(overcoat_set_material_text(o, world, material, "description = \"\"", NULL, 0));
    OK(overcoat_material_set(o, world, material, "base_color", red, 3));
    set(o, world, material, "metallic", 0.25f);
    set(o, world, material, "roughness", 0.3f);
    set(o, world, material, "coat", 1);
    set(o, world, material, "double_sided", 1);
    OK(overcoat_material_set(o, world, material, "coat_color", clear, 3));
    set(o, world, material, "anisotropy_rotation", 30);
    set(o, world, material, "options.stacklit_newest", 1);
    OK(overcoat_material_set_text(o, world, material, "model", "stacklit"));
    hash_of(o, world, one_by_one);
    const char *lines =
        "base_color = [0.5, 0.02, 0.02]\nmetallic = 0.25\nroughness = 0.3\ncoat = 1\ncoat_color = [0.5, 0.02, 0.02]\n"
        "double_sided = true\nanisotropy_rotation = 30\nmodel = \"stacklit\"\n[options]\nstacklit_newest = true";
    OK(overcoat_add_material_text(o, world, lines, NULL, 0, &by_text));
    OK(overcoat_set_instance_material(o, world, instance, by_text));
    hash_of(o, world, at_once);
    CHECK(strcmp(one_by_one, at_once) == 0);
    const char *object =
        "  {\"base_color\": [0.5, 0.02, 0.02], \"metallic\": 0.25, \"roughness\": 0.3, \"coat\": 1, \"double_sided\": true,"
        "\"coat_color\": [0.5, 0.02, 0.02], \"anisotropy_rotation\": 30, \"model\": \"stacklit\", \"options\": {\"stacklit_newest\": true}}";
    OK(overcoat_set_material_text(o, world, by_text, object, NULL, 0));
    hash_of(o, world, json);
    CHECK(strcmp(json, at_once) == 0);
    OK(overcoat_material_set_text(o, world, by_text, "base_color", "#00ff00"));
    hash_of(o, world, json);
    CHECK(strcmp(json, at_once) != 0);

    const float two = 2, nan = NAN;
    FAILS(overcoat_material_set(o, world, material, "cot", &two, 1), OVERCOAT_INVALID_ARGUMENT, "no parameter 'cot'");
    FAILS(overcoat_material_set(o, world, material, "over", &two, 1), OVERCOAT_INVALID_ARGUMENT, "no parameter 'over'");
    FAILS(overcoat_material_set(o, world, material, "coat", &two, 1), OVERCOAT_MALFORMED, "coat: 2.0 is out of range, 0 to 1");
    FAILS(overcoat_material_set(o, world, material, "coat", &nan, 1), OVERCOAT_OUT_OF_RANGE, "not finite");
    FAILS(overcoat_material_set(o, world, material, "coat", red, 3), OVERCOAT_MALFORMED, "coat: expected a number");
    FAILS(overcoat_material_set(o, world, material, "base_color", &two, 1), OVERCOAT_MALFORMED, "base_color: ");
    FAILS(overcoat_material_set(o, world, material, "double_sided", &two, 1), OVERCOAT_INVALID_ARGUMENT, "true or false");
    FAILS(overcoat_material_set(o, world, material, "alpha_mode", &two, 1), OVERCOAT_INVALID_ARGUMENT, "opaque, mask, blend");
    FAILS(overcoat_material_set(o, world, material, "coat", NULL, 1), OVERCOAT_INVALID_ARGUMENT, "values: null");
    FAILS(overcoat_material_set(o, world, material, "coat", red, 5), OVERCOAT_INVALID_ARGUMENT, "not 1 to 4");
    FAILS(overcoat_material_set(o, world, material, NULL, red, 1), OVERCOAT_INVALID_ARGUMENT, "name: null");
    FAILS(overcoat_material_set(o, world, 999, "coat", red, 1), OVERCOAT_GONE, "material");
    FAILS(overcoat_material_set_text(o, world, material, "model", "cel"), OVERCOAT_MALFORMED, "'cel' is not known");
    FAILS(overcoat_material_set_text(o, world, material, "coat_texture", "a.png"), OVERCOAT_INVALID_ARGUMENT, "set_texture");
    OK(overcoat_set_instance_material(o, world, instance, material));
    hash_of(o, world, json);
    CHECK(strcmp(one_by_one, json) == 0);
    OK(overcoat_world_free(o, world));
}

static void textures_are_pixels(overcoat *o) {
    uint64_t material, mesh, instance, world = 0;
    static const float corners[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, up[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    static const float uvs[8] = {0, 1, 1, 1, 1, 0, 0, 0};
    static const uint32_t faces[6] = {0, 1, 2, 0, 2, 3};
    overcoat_mesh plane;
    OVERCOAT_INIT(plane);
    plane.positions = corners;
    plane.normals = up;
    plane.uvs = uvs;
    plane.vertex_count = 4;
    plane.indices = faces;
    plane.triangle_count = 2;
    OK(overcoat_world_new(o, &world));
    OK(overcoat_add_mesh(o, world, &plane, &mesh));
    OK(overcoat_add_material_text(o, world, "{\"roughness\": 0.6}", NULL, 0, &material));
    OK(overcoat_add_instance(o, world, mesh, material, NULL, &instance));
    char plain[33], bytes[33], floats[33], bumpy[33], again[33];
    hash_of(o, world, plain);
    /* Two by two, with three bytes of padding a row; and the same as floats. */
    const uint8_t rgb[2 * 9] = {255, 0, 0, 0, 255, 0, 7, 7, 7, 0, 0, 255, 255, 255, 255, 7, 7, 7};
    const float colors[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    overcoat_texture texture;
    OVERCOAT_INIT(texture);
    texture.format = OVERCOAT_TEXTURE_RGB8;
    texture.texels = rgb;
    texture.length = sizeof rgb;
    texture.stride = 9;
    texture.width = texture.height = 2;
    texture.filter = 1;
    OK(overcoat_material_set_texture(o, world, material, "base_color_texture", &texture));
    hash_of(o, world, bytes);
    CHECK(strcmp(plain, bytes) != 0);
    texture.format = OVERCOAT_TEXTURE_RGB_F32;
    texture.texels = colors;
    texture.length = sizeof colors;
    texture.stride = 0;
    OK(overcoat_material_set_texture(o, world, material, "base_color_texture", &texture));
    hash_of(o, world, floats);
    CHECK(strcmp(bytes, floats) == 0);
    /* A map of normals, for which the mesh has tangents. */
    const uint8_t slant[4] = {200, 128, 220, 255};
    overcoat_texture normals;
    OVERCOAT_INIT(normals);
    normals.format = OVERCOAT_TEXTURE_RGBA8;
    normals.texels = slant;
    normals.length = 4;
    normals.width = normals.height = 1;
    OK(overcoat_material_set_texture(o, world, material, "normal_texture", &normals));
    hash_of(o, world, bumpy);
    CHECK(strcmp(bumpy, floats) != 0);
    OK(overcoat_material_set_texture(o, world, material, "normal_texture", NULL));
    hash_of(o, world, again);
    CHECK(strcmp(again, floats) == 0);
    OK(overcoat_material_set_texture(o, world, material, "base_color_texture", NULL));
    hash_of(o, world, again);
    CHECK(strcmp(again, plain) == 0);

    texture.length--;
    FAILS(overcoat_material_set_texture(o, world, material, "base_color_texture", &texture), OVERCOAT_INVALID_ARGUMENT, "texels: 2 x 2 in rows of 24 bytes are not in 47 bytes");
    texture.length++;
    texture.width = UINT32_MAX;
    FAILS(overcoat_material_set_texture(o, world, material, "base_color_texture", &texture), OVERCOAT_INVALID_ARGUMENT, "texels: ");
    texture.width = 2;
    texture.wrap_v = 3;
    FAILS(overcoat_material_set_texture(o, world, material, "base_color_texture", &texture), OVERCOAT_INVALID_ARGUMENT, "wrap_v: 3");
    texture.wrap_v = 0;
    texture.format = 9;
    FAILS(overcoat_material_set_texture(o, world, material, "base_color_texture", &texture), OVERCOAT_INVALID_ARGUMENT, "format: 9");
    texture.format = OVERCOAT_TEXTURE_FILE;
    FAILS(overcoat_material_set_texture(o, world, material, "base_color_texture", &texture), OVERCOAT_MALFORMED, "base_color_texture: ");
    FAILS(overcoat_material_set_texture(o, world, material, "roughness", &texture), OVERCOAT_INVALID_ARGUMENT, "roughness: takes 0 to 1");
    OK(overcoat_world_free(o, world));
}

static void planes_and_cameras_agree(overcoat *o) {
    uint64_t instance, material, world = cube_world(o, &instance, &material);
    overcoat_picture picture = small_picture();
    overcoat_camera camera;
    OVERCOAT_INIT(camera);
    camera.eye[0] = 1.5f;
    camera.eye[1] = 2;
    camera.eye[2] = 4;
    camera.up[1] = 1;
    const double k[4] = {70, 62, 30.25, 25.5};
    memcpy(camera.intrinsics, k, sizeof k);
    camera.near = 0.5f;
    camera.far = 50;
    overcoat_view view;
    OVERCOAT_INIT(view);
    OK(overcoat_picture_camera(o, world, &camera, &picture, &view));
    CHECK(view.projection == OVERCOAT_PERSPECTIVE && view.width == 64 && view.height == 48 && view.near == 0.5f && view.far == 50);
    CHECK(memcmp(view.intrinsics, k, sizeof k) == 0 && fabs(view.camera_to_world[14] - 4) < 1e-9);

    overcoat_plane planes[4];
    const char *names[4] = {"depth", "position", "instance-id", "base-color"};
    for (int n = 0; n < 4; n++) {
        OVERCOAT_INIT(planes[n]);
        planes[n].name = names[n];
    }
    OK(overcoat_render_planes(o, world, &camera, &picture, planes, 4));
    CHECK(planes[0].channels == 1 && planes[1].channels == 3 && planes[0].width == 64 && planes[0].height == 48);
    CHECK(planes[2].kind == OVERCOAT_PLANE_UINT32 && planes[0].kind == OVERCOAT_PLANE_FLOAT);
    static float depth[64 * 48], position[64 * 48 * 3], apart[48][70], color[64 * 48 * 3];
    static uint32_t ids[64 * 48];
    void *memory[4] = {depth, position, ids, color};
    const size_t lengths[4] = {sizeof depth, sizeof position, sizeof ids, sizeof color};
    for (int n = 0; n < 4; n++) {
        planes[n].data = memory[n];
        planes[n].length = lengths[n];
    }
    /* Geometry alone, and with what is shaded. */
    OK(overcoat_render_planes(o, world, &camera, &picture, planes, 3));
    static float once_more[64 * 48];
    memcpy(once_more, depth, sizeof depth);
    OK(overcoat_render_planes(o, world, &camera, &picture, planes, 4));
    CHECK(memcmp(once_more, depth, sizeof depth) == 0);
    int seen = 0;
    double worst = 0;
    for (int y = 0; y < 48; y++) {
        for (int x = 0; x < 64; x++) {
            const float z = depth[64 * y + x];
            CHECK((z > 0) == (ids[64 * y + x] != 0));
            if (z == 0) continue;
            seen++;
            CHECK(color[3 * (64 * y + x)] > 0);
            /* Down and forward in the convention of OpenCV. */
            const double local[3] = {z * (x + 0.5 - k[2]) / k[0], -z * (y + 0.5 - k[3]) / k[1], -z};
            for (int row = 0; row < 3; row++) {
                double at = view.camera_to_world[12 + row];
                for (int axis = 0; axis < 3; axis++) at += view.camera_to_world[4 * axis + row] * local[axis];
                worst = fmax(worst, fabs(at - position[3 * (64 * y + x) + row]) / z);
            }
        }
    }
    CHECK(seen > 300 && worst < 1e-6);
    uint64_t found = 0;
    OK(overcoat_instance_of_id(o, world, ids[64 * 25 + 30], &found));
    CHECK(found == instance);
    OK(overcoat_instance_of_id(o, world, 0, &found));
    CHECK(found == 0);
    FAILS(overcoat_instance_of_id(o, world, UINT32_MAX, &found), OVERCOAT_GONE, "no instance has the number 4294967295");
    /* Rows that lie apart. */
    planes[0].data = apart;
    planes[0].stride = sizeof apart[0];
    planes[0].length = sizeof apart;
    memset(apart, 0xab, sizeof apart);
    OK(overcoat_render_planes(o, world, &camera, &picture, planes, 1));
    for (int y = 0; y < 48; y++) {
        CHECK(memcmp(apart[y], depth + 64 * y, 64 * sizeof(float)) == 0);
        CHECK(((uint8_t *)apart[y])[64 * 4] == 0xab);
    }
    planes[0].length = 47 * sizeof apart[0] + 64 * 4 - 1;
    FAILS(overcoat_render_planes(o, world, &camera, &picture, planes, 1), OVERCOAT_INVALID_ARGUMENT, "plane depth: 13415 bytes in rows of 280, expected 13416");
    planes[0].name = "deep";
    FAILS(overcoat_render_planes(o, world, &camera, &picture, planes, 1), OVERCOAT_INVALID_ARGUMENT, "'deep' is not one of depth");
    FAILS(overcoat_render_planes(o, world, &camera, &picture, NULL, 1), OVERCOAT_INVALID_ARGUMENT, "planes: null");
    OK(overcoat_render_planes(o, world, &camera, &picture, NULL, 0));

    /* Degrees are the radians of older headers. */
    memset(camera.intrinsics, 0, sizeof camera.intrinsics);
    camera.fov_y = 40 * 3.14159265f / 180;
    OK(overcoat_picture_camera(o, world, &camera, &picture, &view));
    const double focal = view.intrinsics[1];
    camera.fov_y = 0;
    camera.fov_y_degrees = 40;
    OK(overcoat_picture_camera(o, world, &camera, &picture, &view));
    CHECK(fabs(view.intrinsics[1] - focal) < 1e-4 && fabs(focal - 24 / tan(20 * 3.14159265 / 180)) < 1e-3);
    camera.fov_y_degrees = 200;
    FAILS(overcoat_picture_camera(o, world, &camera, &picture, &view), OVERCOAT_OUT_OF_RANGE, "field of view");
    camera.fov_y_degrees = 0;
    camera.orthographic_height = 4;
    OK(overcoat_picture_camera(o, world, &camera, &picture, &view));
    CHECK(view.projection == OVERCOAT_ORTHOGRAPHIC && view.intrinsics[0] == 12 && view.intrinsics[1] == 12);
    camera.intrinsics[0] = NAN;
    FAILS(overcoat_picture_camera(o, world, &camera, &picture, &view), OVERCOAT_OUT_OF_RANGE, "fx");
    /* The camera that shows all. */
    OK(overcoat_picture_camera(o, world, NULL, &picture, &view));
    CHECK(view.intrinsics[2] == 32 && view.intrinsics[3] == 24 && isinf(view.far));
    OK(overcoat_world_free(o, world));
}

/* Pixels that a world of one mesh covers. */
static int covered(overcoat *o, const overcoat_mesh *mesh) {
    uint64_t world, handle, material, instance;
    OK(overcoat_world_new(o, &world));
    OK(overcoat_add_material_text(o, world, "unlit = true\ndouble_sided = true", NULL, 0, &material));
    OK(overcoat_add_mesh(o, world, mesh, &handle));
    OK(overcoat_add_instance(o, world, handle, material, NULL, &instance));
    overcoat_picture picture = small_picture();
    picture.settings = "{\"ground\": \"none\", \"line_width\": 2, \"point_size\": 6, \"edges\": \"none\"}";
    overcoat_camera camera;
    OVERCOAT_INIT(camera);
    camera.eye[2] = 5;
    camera.up[1] = 1;
    camera.orthographic_height = 4;
    static uint8_t pixels[64 * 48 * 4];
    overcoat_target target = target_of(pixels, sizeof pixels, OVERCOAT_RGBA8);
    OK(overcoat_render(o, world, &camera, &picture, &target, NULL));
    int count = 0;
    for (size_t at = 3; at < sizeof pixels; at += 4) count += pixels[at] > 127;
    OK(overcoat_world_free(o, world));
    return count;
}

static void lines_and_points_are_drawn(overcoat *o) {
    static const float corners[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    static const uint32_t around[8] = {0, 1, 1, 2, 2, 3, 3, 0}, some[2] = {1, 3};
    overcoat_mesh mesh;
    OVERCOAT_INIT(mesh);
    mesh.positions = corners;
    mesh.vertex_count = 4;
    mesh.primitives = OVERCOAT_LINES;
    mesh.indices = around;
    mesh.triangle_count = 4;
    /* A square of 24 x 24 pixels, with sides 2 pixels wide. */
    const int square = covered(o, &mesh);
    CHECK(square > 150 && square < 230);
    mesh.indices = NULL;
    const int sides = covered(o, &mesh);
    CHECK(sides > 70 && sides < 120);
    mesh.primitives = OVERCOAT_POINTS;
    const int four = covered(o, &mesh);
    CHECK(four > 4 * 20 && four < 4 * 36);
    mesh.indices = some;
    mesh.triangle_count = 2;
    CHECK(abs(2 * covered(o, &mesh) - four) < 8);
    mesh.primitives = 3;
    uint64_t world, handle;
    OK(overcoat_world_new(o, &world));
    FAILS(overcoat_add_mesh(o, world, &mesh, &handle), OVERCOAT_INVALID_ARGUMENT, "primitives: 3 is not 0 to 2");
    mesh.primitives = OVERCOAT_LINES;
    mesh.indices = NULL;
    mesh.vertex_count = 3;
    FAILS(overcoat_add_mesh(o, world, &mesh, &handle), OVERCOAT_INVALID_ARGUMENT, "3 vertices without indices are no lines");
    mesh.vertex_count = 4;
    mesh.primitives = OVERCOAT_TRIANGLES;
    mesh.indices = around;
    mesh.triangle_count = 2;
    mesh.crease_degrees = 181;
    FAILS(overcoat_add_mesh(o, world, &mesh, &handle), OVERCOAT_OUT_OF_RANGE, "crease_degrees: 181");
    mesh.crease_degrees = 60;
    OK(overcoat_add_mesh(o, world, &mesh, &handle));
    OK(overcoat_world_free(o, world));
}

static void cones_are_degrees(overcoat *o) {
    uint64_t instance, material, lamp, world = cube_world(o, &instance, &material);
    overcoat_light light;
    OVERCOAT_INIT(light);
    light.kind = OVERCOAT_LIGHT_SPOT;
    light.position[1] = 3;
    light.intensity = 30;
    light.inner_cone_cosine = cosf(20 * 3.14159265f / 180);
    light.outer_cone_cosine = cosf(35 * 3.14159265f / 180);
    OK(overcoat_set_environment(o, world, OVERCOAT_ENVIRONMENT_NONE, NULL, 0, 0, 1));
    OK(overcoat_add_light(o, world, &light, &lamp));
    static uint8_t by_cosine[64 * 48 * 4], by_degrees[64 * 48 * 4];
    overcoat_picture picture = small_picture();
    overcoat_target target = target_of(by_cosine, sizeof by_cosine, OVERCOAT_RGBA8);
    OK(overcoat_render(o, world, NULL, &picture, &target, NULL));
    light.inner_cone_degrees = 20;
    light.outer_cone_degrees = 35;
    light.inner_cone_cosine = light.outer_cone_cosine = 1;
    OK(overcoat_set_light(o, world, lamp, &light));
    target = target_of(by_degrees, sizeof by_degrees, OVERCOAT_RGBA8);
    OK(overcoat_render(o, world, NULL, &picture, &target, NULL));
    int lit = 0;
    for (size_t at = 0; at < sizeof by_cosine; at++) {
        CHECK(abs(by_cosine[at] - by_degrees[at]) <= 1);
        lit += at % 4 != 3 && by_degrees[at] > 100;
    }
    CHECK(lit > 100);
    light.outer_cone_degrees = 95;
    FAILS(overcoat_set_light(o, world, lamp, &light), OVERCOAT_OUT_OF_RANGE, "a cone of 95 degrees is not 0 to 90");
    light.outer_cone_degrees = 10;
    FAILS(overcoat_set_light(o, world, lamp, &light), OVERCOAT_OUT_OF_RANGE, "outer cone");
    OK(overcoat_world_free(o, world));
}

static void encodes_every_format(overcoat *o) {
    static uint8_t pixels[5 * 20], other[5 * 20];
    static float linear[4 * 5 * 4];
    for (int k = 0; k < 100; k++) {
        pixels[k] = (uint8_t)(k % 4 == 3 ? 255 : 2 * k);
        other[k] = (uint8_t)(255 - 2 * k);
    }
    for (int k = 0; k < 80; k++) linear[k] = k % 4 == 3 ? 1 : (float)k / 10;
    overcoat_encoding encoding;
    OVERCOAT_INIT(encoding);
    encoding.width = 4;
    encoding.height = 5;
    encoding.stride = 20;
    static const struct {
        const char *name, *magic;
        uint32_t pixel_format;
    } formats[] = {
        {"png", "\x89PNG", OVERCOAT_RGBA8}, {"webp", "RIFF", OVERCOAT_RGBA8}, {"jpg", "\xff\xd8\xff", OVERCOAT_RGBA8},
        {"gif", "GIF89a", OVERCOAT_RGBA8}, {"exr", "v/1\x01", OVERCOAT_RGBA_F32_PREMULTIPLIED},
        {"hdr", "#?RADIANCE", OVERCOAT_RGBA_F32_PREMULTIPLIED},
    };
    uint8_t *bytes = NULL;
    size_t length = 0, half = 0;
    for (size_t k = 0; k < sizeof formats / sizeof *formats; k++) {
        const bool is_linear = formats[k].pixel_format != OVERCOAT_RGBA8;
        encoding.format = formats[k].name;
        encoding.pixel_format = formats[k].pixel_format;
        encoding.stride = is_linear ? 64 : 20;
        const void *from = is_linear ? (const void *)linear : (const void *)pixels;
        OK(overcoat_encode(o, from, &encoding, &bytes, &length));
        CHECK(length > 20 && memcmp(bytes, formats[k].magic, strlen(formats[k].magic)) == 0);
        overcoat_bytes_free(bytes, length);
        if (k == 4) half = length;
        encoding.pixel_format = is_linear ? OVERCOAT_RGBA8 : OVERCOAT_RGBA_F32_PREMULTIPLIED;
        encoding.stride = 0;
        FAILS(overcoat_encode(o, linear, &encoding, &bytes, &length), OVERCOAT_INVALID_ARGUMENT, "pixel_format: ");
    }
    encoding.format = "exr";
    encoding.pixel_format = OVERCOAT_RGBA_F32_PREMULTIPLIED;
    encoding.full_floats = true;
    OK(overcoat_encode(o, linear, &encoding, &bytes, &length));
    CHECK(length > half);
    overcoat_bytes_free(bytes, length);
    linear[5] = INFINITY;
    FAILS(overcoat_encode(o, linear, &encoding, &bytes, &length), OVERCOAT_OUT_OF_RANGE, "not finite");
    encoding.pixel_format = OVERCOAT_RGBA8;
    encoding.format = "tga";
    FAILS(overcoat_encode(o, pixels, &encoding, &bytes, &length), OVERCOAT_INVALID_ARGUMENT, "'tga' is not one of png");
    encoding.format = "jpg";
    encoding.jpeg_quality = 101;
    FAILS(overcoat_encode(o, pixels, &encoding, &bytes, &length), OVERCOAT_OUT_OF_RANGE, "jpeg_quality: 101");
    encoding.width = 0;
    FAILS(overcoat_encode(o, pixels, &encoding, &bytes, &length), OVERCOAT_INVALID_ARGUMENT, "0 x 5");
    encoding.width = 4;
    FAILS(overcoat_encode(o, NULL, &encoding, &bytes, &length), OVERCOAT_INVALID_ARGUMENT, "pixels: null");
    FAILS(overcoat_encode(o, pixels, NULL, &bytes, &length), OVERCOAT_INVALID_ARGUMENT, "encoding: null");

    /* Moving pictures. */
    const void *frames[3] = {pixels, other, pixels};
    static const char *moving[3] = {"png", "webp", "gif"};
    for (int k = 0; k < 3; k++) {
        encoding.format = moving[k];
        OK(overcoat_encode_movie(o, frames, 3, &encoding, 12, &bytes, &length));
        CHECK(length > 100);
        overcoat_bytes_free(bytes, length);
    }
    FAILS(overcoat_encode_movie(o, frames, 3, &encoding, 0, &bytes, &length), OVERCOAT_OUT_OF_RANGE, "frames_per_second: 0");
    FAILS(overcoat_encode_movie(o, frames, 0, &encoding, 12, &bytes, &length), OVERCOAT_INVALID_ARGUMENT, "no pictures");
    frames[1] = NULL;
    FAILS(overcoat_encode_movie(o, frames, 3, &encoding, 12, &bytes, &length), OVERCOAT_INVALID_ARGUMENT, "pixels: null");
    encoding.format = "exr";
    FAILS(overcoat_encode_movie(o, frames, 3, &encoding, 12, &bytes, &length), OVERCOAT_INVALID_ARGUMENT, "of which pictures move");
}

/* A thread that flushes subnormal numbers draws the same, and goes on flushing. */
static void arithmetic_is_set_and_put_back(overcoat *o) {
#if defined(__SSE__)
    uint64_t instance, material, world = cube_world(o, &instance, &material);
    char usual[33], flushing[33];
    hash_of(o, world, usual);
    const unsigned before = _mm_getcsr(), odd = (before | 0x8040u) ^ 0x2000u;
    _mm_setcsr(odd);
    overcoat *second = NULL;
    CHECK(overcoat_new(NULL, &second) == OVERCOAT_OK);
    hash_of(o, world, flushing);
    CHECK((_mm_getcsr() & 0xffc0u) == (odd & 0xffc0u));
    CHECK(strcmp(usual, flushing) == 0);
    uint64_t other_instance, other_material, other = cube_world(second, &other_instance, &other_material);
    hash_of(second, other, flushing);
    CHECK((_mm_getcsr() & 0xffc0u) == (odd & 0xffc0u));
    _mm_setcsr(before);
    CHECK(strcmp(usual, flushing) == 0);
    overcoat_free(&second);
    OK(overcoat_world_free(o, world));
#else
    (void)o;
#endif
}

int main(void) {
    overcoat *o = NULL;
    CHECK(overcoat_new(NULL, &o) == OVERCOAT_OK);
    parameters_have_names(o);
    parameters_are_told(o);
    textures_are_pixels(o);
    planes_and_cameras_agree(o);
    lines_and_points_are_drawn(o);
    cones_are_degrees(o);
    encodes_every_format(o);
    arithmetic_is_set_and_put_back(o);
    overcoat_free(&o);
    if (failures == 0) printf("all is well\n");
    return failures != 0;
}

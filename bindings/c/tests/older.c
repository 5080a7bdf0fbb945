/* A program that may be compiled against an older header, whose materials, lights, meshes and cameras have fewer fields: prints the hash of a red cube. */
#include <overcoat.h>
#include <stdio.h>

#define OK(call) \
    do { \
        if ((call) != OVERCOAT_OK) { \
            fprintf(stderr, "%s: %s\n", #call, overcoat_message(o)); \
            return 1; \
        } \
    } while (0)

int main(void) {
    overcoat *o = NULL;
    uint64_t world, mesh, material, light, instance;
    static const float corners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    static const uint32_t faces[12][3] = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                                          {3, 6, 2}, {3, 7, 6}, {0, 7, 3}, {0, 4, 7}, {1, 2, 6}, {1, 6, 5}};
    static uint8_t pixels[64 * 64 * 4];
    if (overcoat_new(NULL, &o) != OVERCOAT_OK) return 1;
    overcoat_mesh cube;
    OVERCOAT_INIT(cube);
    cube.positions = corners[0];
    cube.vertex_count = 8;
    cube.indices = faces[0];
    cube.triangle_count = 12;
    overcoat_material red;
    OVERCOAT_INIT(red);
    red.base_color[1] = red.base_color[2] = 0.05f;
    overcoat_light sun;
    OVERCOAT_INIT(sun);
    sun.kind = OVERCOAT_LIGHT_SPOT;
    sun.position[1] = 3;
    sun.intensity = 20;
    OK(overcoat_world_new(o, &world));
    OK(overcoat_add_mesh(o, world, &cube, &mesh));
    OK(overcoat_add_material(o, world, &red, &material));
    OK(overcoat_add_light(o, world, &sun, &light));
    OK(overcoat_add_instance(o, world, mesh, material, NULL, &instance));
    overcoat_picture picture;
    OVERCOAT_INIT(picture);
    picture.width = picture.height = 64;
    picture.wants_hash = true;
    overcoat_camera camera;
    OVERCOAT_INIT(camera);
    OK(overcoat_frame(o, world, NULL, 1, &camera));
    camera.fov_y *= 1.25f;
    overcoat_target target;
    OVERCOAT_INIT(target);
    target.pixels = pixels;
    target.length = sizeof pixels;
    overcoat_result result;
    OVERCOAT_INIT(result);
    OK(overcoat_render(o, world, &camera, &picture, &target, &result));
    printf("%zu %zu %zu %zu %s\n", sizeof red, sizeof sun, sizeof cube, sizeof camera, result.hash);
    overcoat_free(&o);
    return 0;
}

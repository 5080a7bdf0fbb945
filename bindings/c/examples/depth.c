/* Where the middle of a picture is: its depth and its instance, put back into the world by the picture's camera; and what is drawn, as
 * OpenEXR with linear light.
 *
 *     depth MODEL EXR
 */

#include <overcoat.h>

#include <stdio.h>

enum { WIDTH = 160, HEIGHT = 120 };

static int fail(overcoat *o) {
    fprintf(stderr, "%s\n", overcoat_message(o));
    overcoat_free(&o);
    return 1;
}

int main(int count, char **arguments) {
    if (count != 3) {
        fprintf(stderr, "usage: depth MODEL EXR\n");
        return 2;
    }
    overcoat *o = NULL;
    uint64_t world, model, instance;
    if (overcoat_new(NULL, &o)) return 1;
    if (overcoat_world_new(o, &world) || overcoat_load_file(o, world, arguments[1], NULL, NULL, NULL, &model)) return fail(o);

    overcoat_picture picture;
    OVERCOAT_INIT(picture);
    picture.width = WIDTH;
    picture.height = HEIGHT;
    picture.settings = "{\"ground\": \"none\"}";

    static float depth[WIDTH * HEIGHT], linear[WIDTH * HEIGHT * 4];
    static uint32_t ids[WIDTH * HEIGHT];
    overcoat_plane planes[2];
    OVERCOAT_INIT(planes[0]);
    OVERCOAT_INIT(planes[1]);
    planes[0].name = "depth";
    planes[0].data = depth;
    planes[0].length = sizeof depth;
    planes[1].name = "instance-id";
    planes[1].data = ids;
    planes[1].length = sizeof ids;
    overcoat_view view;
    OVERCOAT_INIT(view);
    if (overcoat_render_planes(o, world, NULL, &picture, planes, 2)) return fail(o);
    if (overcoat_picture_camera(o, world, NULL, &picture, &view)) return fail(o);

    const int x = WIDTH / 2, y = HEIGHT / 2, at = WIDTH * y + x;
    if (overcoat_instance_of_id(o, world, ids[at], &instance)) return fail(o);
    /* Up and backward, in the convention of OpenGL. */
    const double z = depth[at], *m = view.camera_to_world, *k = view.intrinsics;
    const double local[3] = {z * (x + 0.5 - k[2]) / k[0], -z * (y + 0.5 - k[3]) / k[1], -z};
    double point[3];
    for (int row = 0; row < 3; row++) point[row] = m[row] * local[0] + m[4 + row] * local[1] + m[8 + row] * local[2] + m[12 + row];
    printf("%.4f m away, at %.4f %.4f %.4f, %s\n", z, point[0], point[1], point[2], instance ? "of the model" : "nothing");

    overcoat_target target;
    OVERCOAT_INIT(target);
    target.format = OVERCOAT_RGBA_F32_PREMULTIPLIED;
    target.pixels = (uint8_t *)linear;
    target.length = sizeof linear;
    overcoat_encoding encoding;
    OVERCOAT_INIT(encoding);
    encoding.pixel_format = OVERCOAT_RGBA_F32_PREMULTIPLIED;
    encoding.width = WIDTH;
    encoding.height = HEIGHT;
    encoding.format = "exr";
    uint8_t *bytes = NULL;
    size_t length = 0;
    if (overcoat_render(o, world, NULL, &picture, &target, NULL)) return fail(o);
    if (overcoat_encode(o, linear, &encoding, &bytes, &length)) return fail(o);
    FILE *file = fopen(arguments[2], "wb");
    int written = file && fwrite(bytes, 1, length, file) == length;
    if (file) written = fclose(file) == 0 && written;
    overcoat_bytes_free(bytes, length);
    if (!written) perror(arguments[2]);
    overcoat_free(&o);
    return written ? 0 : 2;
}

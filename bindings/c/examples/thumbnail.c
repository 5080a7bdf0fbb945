/* A thumbnail of a model file.
 *
 *     thumbnail MODEL PNG [SIZE]
 */

#include <overcoat.h>

#include <stdio.h>
#include <stdlib.h>

static void warn(void *user, const char *message) {
    fprintf(stderr, "%s: warning: %s\n", (const char *)user, message);
}

static int draw(overcoat *o, const char *model, const char *png, uint32_t size) {
    uint64_t world, handle;
    if (overcoat_world_new(o, &world)) return 1;
    if (overcoat_load_file(o, world, model, NULL, warn, (void *)model, &handle)) return 1;

    overcoat_picture picture;
    OVERCOAT_INIT(picture);
    picture.width = picture.height = size;

    size_t length = (size_t)size * size * 4;
    uint8_t *pixels = malloc(length);
    if (!pixels) return 1;
    overcoat_target target;
    OVERCOAT_INIT(target);
    target.format = OVERCOAT_RGBA8;
    target.pixels = pixels;
    target.length = length;

    uint8_t *bytes = NULL;
    size_t count = 0;
    overcoat_status status = overcoat_render(o, world, NULL, &picture, &target, NULL);
    if (!status) status = overcoat_encode_png(o, pixels, size, size, 0, &bytes, &count);
    free(pixels);
    if (status) return 1;

    FILE *file = fopen(png, "wb");
    int written = file && fwrite(bytes, 1, count, file) == count;
    if (file) written = fclose(file) == 0 && written;
    overcoat_bytes_free(bytes, count);
    if (!written) perror(png);
    return written ? 0 : 2;
}

int main(int count, char **arguments) {
    uint32_t size = count == 4 ? (uint32_t)strtoul(arguments[3], NULL, 10) : 256;
    if (count < 3 || count > 4 || size == 0 || size > 4096) {
        fprintf(stderr, "usage: thumbnail MODEL PNG [SIZE]\n");
        return 2;
    }
    overcoat *o = NULL;
    if (overcoat_new(NULL, &o)) return 1;
    int failed = draw(o, arguments[1], arguments[2], size);
    if (failed == 1) fprintf(stderr, "%s: %s\n", arguments[1], overcoat_message(o));
    overcoat_free(&o);
    return failed;
}

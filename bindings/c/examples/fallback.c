/* A picture of a model by OpenGL ES where there is a GPU, and by the processor where there is none, or where it is lost.
 *
 *     fallback MODEL PNG [gpu|processor]
 *
 * The program links no library of the system: that of EGL is looked for when it runs. OpenGL in software (llvmpipe, SwiftShader) is not
 * taken for a GPU: it takes several times the processor time.
 */

#include <overcoat.h>

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 640, HEIGHT = 360 };

/* Scene of the application. */
typedef struct {
    const char *model;
    overcoat *o;
    uint64_t world;
} scene;

/* Something that draws: each function returns NULL, or the reason why it does not. */
typedef struct {
    const char *name;
    const char *(*open)(scene *of);
    const char *(*draw)(scene *of, uint8_t *pixels);
    void (*close)(void);
} backend;

/* --- OpenGL ES, by EGL */

static struct {
    void *library, *display, *surface, *context;
    int (*make_current)(void *, void *, void *, void *);
    int (*terminate)(void *);
    void (*clear_color)(float, float, float, float);
    void (*clear)(unsigned);
    void (*read_pixels)(int, int, int, int, unsigned, unsigned, void *);
    unsigned (*get_error)(void);
} gl;

static void gpu_close(void) {
    if (gl.display && gl.terminate) gl.terminate(gl.display);
    if (gl.library) dlclose(gl.library);
    memset(&gl, 0, sizeof(gl));
}

static const char *gpu_open(scene *of) {
    (void)of;
    gl.library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!gl.library) return "there is no libEGL.so.1";
    void *(*get_display)(void *);
    int (*initialize)(void *, int *, int *);
    int (*choose_config)(void *, const int *, void **, int, int *);
    void *(*create_context)(void *, void *, void *, const int *);
    void *(*create_pbuffer)(void *, void *, const int *);
    void *(*get_proc_address)(const char *);
    const uint8_t *(*get_string)(unsigned);
    /* Pointers to functions and to objects are of one size where there is dlsym. */
    struct { const char *name; void *to; } in_egl[] = {
        {"eglGetDisplay", &get_display},
        {"eglInitialize", &initialize},
        {"eglChooseConfig", &choose_config},
        {"eglCreateContext", &create_context},
        {"eglCreatePbufferSurface", &create_pbuffer},
        {"eglMakeCurrent", &gl.make_current},
        {"eglTerminate", &gl.terminate},
        {"eglGetProcAddress", &get_proc_address},
    };
    for (size_t k = 0; k < sizeof(in_egl) / sizeof(*in_egl); k++) {
        void *found = dlsym(gl.library, in_egl[k].name);
        if (!found) return "libEGL.so.1 lacks a function";
        memcpy(in_egl[k].to, &found, sizeof(found));
    }
    const int config[] = {0x3033 /* surface type */, 1 /* pbuffer */, 0x3040 /* renderable type */, 4 /* ES 2 */,
                          0x3024 /* red */, 8, 0x3023 /* green */, 8, 0x3022 /* blue */, 8, 0x3038};
    const int version[] = {0x3098 /* client version */, 2, 0x3038};
    const int size[] = {0x3057 /* width */, WIDTH, 0x3056 /* height */, HEIGHT, 0x3038};
    void *chosen = NULL;
    int count = 0;
    gl.display = get_display(NULL);
    if (!gl.display) return "EGL has no display";
    if (!initialize(gl.display, NULL, NULL)) return "EGL cannot be initialized";
    if (!choose_config(gl.display, config, &chosen, 1, &count) || count == 0) return "EGL has no OpenGL ES 2";
    gl.surface = create_pbuffer(gl.display, chosen, size);
    gl.context = create_context(gl.display, chosen, NULL, version);
    if (!gl.surface || !gl.context || !gl.make_current(gl.display, gl.surface, gl.surface, gl.context)) {
        return "EGL makes no context";
    }
    struct { const char *name; void *to; } in_gl[] = {
        {"glGetString", &get_string}, {"glClearColor", &gl.clear_color}, {"glClear", &gl.clear},
        {"glReadPixels", &gl.read_pixels}, {"glGetError", &gl.get_error},
    };
    for (size_t k = 0; k < sizeof(in_gl) / sizeof(*in_gl); k++) {
        void *found = get_proc_address(in_gl[k].name);
        if (!found) return "OpenGL ES lacks a function";
        memcpy(in_gl[k].to, &found, sizeof(found));
    }
    const char *renderer = (const char *)get_string(0x1F01);
    const char *software[] = {"llvmpipe", "softpipe", "swrast", "Software", "SwiftShader"};
    for (size_t k = 0; renderer && k < sizeof(software) / sizeof(*software); k++) {
        if (strstr(renderer, software[k])) return "OpenGL is drawn in software";
    }
    return renderer ? NULL : "OpenGL ES does not say what draws";
}

/* Stands for the renderer that the application has already: it fills the picture. */
static const char *gpu_draw(scene *of, uint8_t *pixels) {
    (void)of;
    gl.clear_color(0.2f, 0.25f, 0.3f, 1.0f);
    gl.clear(0x4000);
    gl.read_pixels(0, 0, WIDTH, HEIGHT, 0x1908, 0x1401, pixels);
    return gl.get_error() ? "the GPU is lost" : NULL;
}

/* --- the processor, by overcoat */

static void warn(void *user, const char *message) {
    fprintf(stderr, "%s: warning: %s\n", (const char *)user, message);
}

static const char *processor_open(scene *of) {
    if (overcoat_new(NULL, &of->o)) return "no memory";
    if (overcoat_world_new(of->o, &of->world)) return overcoat_message(of->o);
    uint64_t handle;
    int failed = overcoat_load_file(of->o, of->world, of->model, NULL, warn, (void *)of->model, &handle);
    return failed ? overcoat_message(of->o) : NULL;
}

static const char *processor_draw(scene *of, uint8_t *pixels) {
    overcoat_picture picture;
    OVERCOAT_INIT(picture);
    picture.width = WIDTH;
    picture.height = HEIGHT;
    overcoat_target target;
    OVERCOAT_INIT(target);
    target.format = OVERCOAT_RGBA8;
    target.pixels = pixels;
    target.length = (size_t)WIDTH * HEIGHT * 4;
    return overcoat_render(of->o, of->world, NULL, &picture, &target, NULL) ? overcoat_message(of->o) : NULL;
}

static void processor_close(void) {}

/* --- the application */

static const backend BACKENDS[] = {
    {"gpu", gpu_open, gpu_draw, gpu_close},
    {"processor", processor_open, processor_draw, processor_close},
};

/* Draws with the first of the backends that can, or with the one that is asked for. Returns its name. */
static const char *draw(scene *of, const char *only, uint8_t *pixels) {
    for (size_t k = 0; k < sizeof(BACKENDS) / sizeof(*BACKENDS); k++) {
        const backend *with = &BACKENDS[k];
        if (only && strcmp(only, with->name)) continue;
        const char *reason = with->open(of);
        if (!reason) reason = with->draw(of, pixels);
        /* Before it is closed, which may take the message along. */
        if (reason) fprintf(stderr, "%s: %s\n", with->name, reason);
        with->close();
        if (!reason) return with->name;
    }
    return NULL;
}

static int write_png(overcoat *o, const uint8_t *pixels, const char *path) {
    uint8_t *bytes = NULL;
    size_t count = 0;
    if (overcoat_encode_png(o, pixels, WIDTH, HEIGHT, 0, &bytes, &count)) return 0;
    FILE *file = fopen(path, "wb");
    int written = file && fwrite(bytes, 1, count, file) == count;
    if (file) written = fclose(file) == 0 && written;
    overcoat_bytes_free(bytes, count);
    if (!written) perror(path);
    return written;
}

int main(int count, char **arguments) {
    if (count < 3 || count > 4) {
        fprintf(stderr, "usage: fallback MODEL PNG [gpu|processor]\n");
        return 2;
    }
    scene of = {arguments[1], NULL, 0};
    uint8_t *pixels = malloc((size_t)WIDTH * HEIGHT * 4);
    const char *by = pixels ? draw(&of, count == 4 ? arguments[3] : NULL, pixels) : NULL;
    if (by) printf("drawn by the %s\n", by);
    int ready = by && (of.o || !overcoat_new(NULL, &of.o));
    int written = ready && write_png(of.o, pixels, arguments[2]);
    free(pixels);
    overcoat_free(&of.o);
    return written ? 0 : 1;
}

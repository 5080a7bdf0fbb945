/* overcoat: models and meshes in memory to pictures in the caller's memory, by the processor alone.
 *
 * Everything belongs to an `overcoat` that overcoat_new() makes: threads, worlds, what is in them. There is no other state. One
 * thread uses it at a time, any thread; several may have one each. overcoat_cancel() may be called by any thread at any time.
 *
 * What is in it is named by numbers that are never 0. A number whose thing has been removed, or that is of another world, is
 * OVERCOAT_GONE and never another thing.
 *
 * Functions return OVERCOAT_OK or what is wrong, and then change nothing; overcoat_message() says it in a sentence. Nothing that
 * is passed in is kept. Structures begin with their size, as the program that uses them knows it: OVERCOAT_INIT(structure) sets
 * it and gives all else its default, which is said at each. Fields that a program does not know yet have their default too.
 *
 * Units are metres and degrees (but overcoat_camera.fov_y, in radians, and cosines of lights, which have a field in degrees beside
 * them); +Y is up, colours are linear Rec. 709 unless they are said to be sRGB. Matrices are column by column, as glTF, OpenGL and
 * Eigen have them.
 *
 * The calling thread may flush subnormal numbers to zero or round otherwise (-ffast-math): functions set its arithmetic right while
 * they work, for pictures that are the same everywhere, and put it back.
 *
 * Made from src/ by cbindgen; see README.md for five minutes with it.
 */

#ifndef OVERCOAT_H
#define OVERCOAT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Gives a structure of this header its defaults, and says how large it is. C before C11 has no way to tell structures apart:
 * there overcoat_material_defaults() and overcoat_light_defaults() have to follow. */
#if defined(__cplusplus)
#define OVERCOAT_INIT(structure) overcoat_init(structure)
#elif defined(__STDC_VERSION__) && __STDC_VERSION__ >= 201112L
#define OVERCOAT_INIT(structure) \
    (memset(&(structure), 0, sizeof(structure)), (structure).size = sizeof(structure), \
     _Generic((structure), overcoat_material: overcoat_material_defaults, overcoat_light: overcoat_light_defaults, \
              default: overcoat_nothing)((void *)&(structure)))
#else
#define OVERCOAT_INIT(structure) (memset(&(structure), 0, sizeof(structure)), (structure).size = sizeof(structure))
#endif


/*
 Status that a function returns.
 */
typedef enum {
  /*
   It is done.
   */
  OVERCOAT_OK = 0,
  /*
   An argument is null, too short, no UTF-8 or no value of its kind.
   */
  OVERCOAT_INVALID_ARGUMENT = 1,
  /*
   The object of a number has been removed, never existed, or is of another world.
   */
  OVERCOAT_GONE = 2,
  /*
   Something else needs it.
   */
  OVERCOAT_IN_USE = 3,
  /*
   A number is not finite or outside of its range.
   */
  OVERCOAT_OUT_OF_RANGE = 4,
  /*
   A file cannot be read.
   */
  OVERCOAT_IO = 5,
  /*
   A file is damaged, or of no format that is known.
   */
  OVERCOAT_MALFORMED = 6,
  /*
   It would take more than the limits allow.
   */
  OVERCOAT_LIMIT = 7,
  /*
   overcoat_cancel() was called.
   */
  OVERCOAT_CANCELLED = 8,
  /*
   Threads flush subnormal numbers to zero or do not round to nearest: pictures would differ from other machines. On x86 and
   64-bit ARM functions set the calling thread's arithmetic right on entry and put it back on return: there it does not happen.
   */
  OVERCOAT_FLOATING_POINT_MODE = 9,
  /*
   A mistake of this library. What it was called for is in an unknown state; only overcoat_free() is left.
   */
  OVERCOAT_INTERNAL = 10,
} overcoat_status;

/*
 Layout of a pixel in memory.
 */
typedef enum {
  /*
   Bytes R, G, B, A: sRGB with straight alpha.
   */
  OVERCOAT_RGBA8 = 0,
  /*
   The same with R, G and B multiplied by alpha as they are encoded.
   */
  OVERCOAT_RGBA8_PREMULTIPLIED = 1,
  /*
   Bytes B, G, R, A: sRGB with straight alpha.
   */
  OVERCOAT_BGRA8 = 2,
  /*
   The same with B, G and R multiplied by alpha as they are encoded: ARGB32 of Cairo and Qt on little-endian machines.
   */
  OVERCOAT_BGRA8_PREMULTIPLIED = 3,
  /*
   A uint32_t 0x00RRGGBB. Without a background what is behind the picture is black.
   */
  OVERCOAT_XRGB8 = 4,
  /*
   Four floats: linear light with straight alpha.
   */
  OVERCOAT_RGBA_F32 = 5,
  /*
   The same with colours multiplied by alpha.
   */
  OVERCOAT_RGBA_F32_PREMULTIPLIED = 6,
} overcoat_pixel_format;

/*
 Quality of a picture: what blocks light, and how often surfaces are shaded.
 */
typedef enum {
  /*
   Quality of the settings, or else fast.
   */
  OVERCOAT_QUALITY_DEFAULT = 0,
  /*
   Nothing blocks light.
   */
  OVERCOAT_QUALITY_DRAFT = 1,
  /*
   Shadows from small depth maps.
   */
  OVERCOAT_QUALITY_FAST = 2,
  /*
   Larger maps, rays for light of other surfaces, four shadings a pixel where they show.
   */
  OVERCOAT_QUALITY_GOOD = 3,
  /*
   Maps, rays and shadings of good, with more of each.
   */
  OVERCOAT_QUALITY_BEST = 4,
} overcoat_quality;

/*
 Source of the environment's light.
 */
typedef enum {
  /*
   The built-in studio.
   */
  OVERCOAT_ENVIRONMENT_STUDIO = 0,
  /*
   No environment.
   */
  OVERCOAT_ENVIRONMENT_NONE = 1,
  /*
   A Radiance HDR, OpenEXR, JPEG, PNG or WebP file: an equirectangular picture.
   */
  OVERCOAT_ENVIRONMENT_FILE = 2,
  /*
   Such a file in memory.
   */
  OVERCOAT_ENVIRONMENT_MEMORY = 3,
  /*
   One that belongs to the program: studio, car-studio, sky or none.
   */
  OVERCOAT_ENVIRONMENT_NAMED = 4,
} overcoat_environment_kind;

/*
 Kind of a light, which decides what its position and direction mean, and the unit of its intensity.
 */
typedef enum {
  /*
   A sun: direction; intensity in lux.
   */
  OVERCOAT_LIGHT_DIRECTIONAL = 0,
  /*
   A bulb: position, range; intensity in candela.
   */
  OVERCOAT_LIGHT_POINT = 1,
  /*
   A spot: position, direction, range, cones; intensity in candela.
   */
  OVERCOAT_LIGHT_SPOT = 2,
} overcoat_light_kind;

/*
 Shapes that the vertices of a mesh are joined to.
 */
typedef enum {
  /*
   Triangles, of three vertices each.
   */
  OVERCOAT_TRIANGLES = 0,
  /*
   Lines, of two vertices each, as wide as the setting "line_width" says, in pixels.
   */
  OVERCOAT_LINES = 1,
  /*
   Points, of one vertex each, drawn as discs of the setting "point_size" in pixels, or by default as large as their distances ask
   for.
   */
  OVERCOAT_POINTS = 2,
} overcoat_primitives;

/*
 Texels of a texture in memory.
 */
typedef enum {
  /*
   A file: PNG, JPEG, WebP or another one that models may have. Width, height and stride do not count.
   */
  OVERCOAT_TEXTURE_FILE = 0,
  /*
   Bytes R, G, B, A.
   */
  OVERCOAT_TEXTURE_RGBA8 = 1,
  /*
   Bytes R, G, B.
   */
  OVERCOAT_TEXTURE_RGB8 = 2,
  /*
   One byte, for all of red, green and blue.
   */
  OVERCOAT_TEXTURE_R8 = 3,
  /*
   Four floats, 0 to 1, which become bytes.
   */
  OVERCOAT_TEXTURE_RGBA_F32 = 4,
  /*
   Three floats, likewise.
   */
  OVERCOAT_TEXTURE_RGB_F32 = 5,
  /*
   One float, likewise.
   */
  OVERCOAT_TEXTURE_R_F32 = 6,
} overcoat_texture_format;

/*
 Kind of a camera's projection.
 */
typedef enum {
  /*
   Projection of a pinhole.
   */
  OVERCOAT_PERSPECTIVE = 0,
  /*
   A parallel projection.
   */
  OVERCOAT_ORTHOGRAPHIC = 1,
} overcoat_projection;

/*
 Kind of the numbers of a plane.
 */
typedef enum {
  /*
   float.
   */
  OVERCOAT_PLANE_FLOAT = 0,
  /*
   uint32_t: identities.
   */
  OVERCOAT_PLANE_UINT32 = 1,
} overcoat_plane_kind;

/*
 Context of all calls: owns the threads, the worlds, and what is in them.
 */
typedef struct overcoat overcoat;

/*
 Options of overcoat_new().
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   Worker threads, up to 256; 0: one for each processor. With 1 there are none: all is done by the calling thread.
   */
  uint32_t threads;
  /*
   Bytes of a file, and of what it unpacks to, at most; 0: 1 GiB.
   */
  uint64_t input_bytes;
  /*
   Triangles of a world at most; 0: as many as the library allows by default.
   */
  uint64_t triangles;
  /*
   Pixels of a picture at most; 0: as many as the library allows by default.
   */
  uint64_t output_pixels;
} overcoat_options;

/*
 Called with each thing that a file asks for and that is left out, in a sentence.
 */
typedef void (*overcoat_warning)(void *user, const char *message);

/*
 Triangles, lines or points in memory. Lists that may be null are said to.
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   Bytes from one position to the next: at least 12, a multiple of 4; 0: 12.
   */
  uint32_t position_stride;
  /*
   x, y and z of each vertex, three floats.
   */
  const float *positions;
  /*
   Number of vertices.
   */
  size_t vertex_count;
  /*
   Three vertices of each triangle, counter-clockwise seen from the front, or as `primitives` says. Null: each three vertices are
   a triangle.
   */
  const uint32_t *indices;
  /*
   Number of triangles, lines or points; without indices that of the vertices counts.
   */
  size_t triangle_count;
  /*
   Three floats a vertex, of any length but zero; null: by crease_degrees.
   */
  const float *normals;
  /*
   Two floats a vertex, (0, 0) is the upper left of a texture; null: none.
   */
  const float *uvs;
  /*
   R, G, B, A of each vertex: sRGB with straight alpha, which multiplies the material's base colour; null: white.
   */
  const uint8_t *vertex_colors;
  /*
   R, G, B, A of each triangle, in place of those of vertices; null: none.
   */
  const uint8_t *face_colors;
  /*
   An overcoat_primitives. Default OVERCOAT_TRIANGLES.
   */
  uint32_t primitives;
  /*
   Without normals: the angle from which on faces that meet have an edge between them, and below which they are smooth, up to
   180; 0, the default: faces are flat.
   */
  float crease_degrees;
} overcoat_mesh;

/*
 Material of a surface. OVERCOAT_INIT and overcoat_material_defaults() fill it; overcoat_material_set() and
 overcoat_add_material_text() know all parameters.
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   0: opaque, 1: holes where alpha is below alpha_cutoff, 2: blended by alpha. Default 0.
   */
  uint32_t alpha_mode;
  /*
   Linear colour and alpha, 0 to 1. Default 1.
   */
  float base_color[4];
  /*
   0 to 1. Default 0.
   */
  float metallic;
  /*
   Perceptual roughness, 0 to 1. Default 1.
   */
  float roughness;
  /*
   Index of refraction, 1 or more, or 0. Default 1.5.
   */
  float ior;
  /*
   Strength of the clear coat, 0 to 1. Default 0.
   */
  float coat;
  /*
   Perceptual roughness of the clear coat, 0 to 1. Default 0.
   */
  float coat_roughness;
  /*
   Emitted light, linear. Default 0.
   */
  float emissive[3];
  /*
   Alpha below which alpha_mode 1 makes holes. Default 0.5.
   */
  float alpha_cutoff;
  /*
   Seen from behind too. Default false.
   */
  bool double_sided;
  /*
   Has its colour whatever the light. Default false.
   */
  bool unlit;
  /*
   Name of the shading model that is used where the picture chooses none ("gltf", "urp-mobile", ...); null: the default.
   */
  const char *shading;
} overcoat_material;

/*
 A light beside the environment. OVERCOAT_INIT and overcoat_light_defaults() fill it.
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   An overcoat_light_kind. Default OVERCOAT_LIGHT_DIRECTIONAL.
   */
  uint32_t kind;
  /*
   In metres. Default 0.
   */
  float position[3];
  /*
   In which the light travels, of any length but zero. Default 0, -1, 0.
   */
  float direction[3];
  /*
   Linear. Default 1.
   */
  float color[3];
  /*
   Lux or candela. Default 1.
   */
  float intensity;
  /*
   Distance in metres at which it has faded out; 0, the default: never.
   */
  float range;
  /*
   Cosine of the half angle inside which a spot is full, unless inner_cone_degrees is set. Default 0.9.
   */
  float inner_cone_cosine;
  /*
   Cosine of the half angle outside which it is dark, unless outer_cone_degrees is set. Default 0.8.
   */
  float outer_cone_cosine;
  /*
   Half angle in degrees inside which a spot is full, below outer_cone_degrees. Counts if that is set. Default 0.
   */
  float inner_cone_degrees;
  /*
   Half angle in degrees outside which it is dark, up to 90. Default 0: the cosines count.
   */
  float outer_cone_degrees;
} overcoat_light;

/*
 File in memory that a text refers to.
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   Name by which the text refers to it.
   */
  const char *name;
  /*
   Contents of the file.
   */
  const uint8_t *bytes;
  /*
   Number of bytes.
   */
  size_t length;
} overcoat_file;

/*
 A texture in memory. As in files its numbers are sRGB in slots of colours and linear in all others, whatever their type.
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   An overcoat_texture_format.
   */
  uint32_t format;
  /*
   First byte of the first texel of the first row, or of the file. It need not be aligned.
   */
  const void *texels;
  /*
   Bytes that there are.
   */
  size_t length;
  /*
   Bytes from one row to the next; 0: as many as a row takes.
   */
  size_t stride;
  /*
   Width in texels.
   */
  uint32_t width;
  /*
   Height in texels.
   */
  uint32_t height;
  /*
   Beyond 0 to 1, across: 0 repeats it, 1 mirrors it, 2 clamps to its edge.
   */
  uint32_t wrap_u;
  /*
   The same, down.
   */
  uint32_t wrap_v;
  /*
   0: linear filters, 1: the nearest texel.
   */
  uint32_t filter;
  /*
   Channel that is read, of slots that read one: 1 red, 2 green, 3 blue, 4 alpha; 0: the usual one.
   */
  uint32_t channel;
  /*
   Texture coordinates are multiplied by this; 0, 0: by 1, 1.
   */
  float scale[2];
  /*
   And then turned by this about (0, 0), as KHR_texture_transform does, in degrees.
   */
  float rotation_degrees;
  /*
   And then moved by this.
   */
  float offset[2];
} overcoat_texture;

/*
 Camera of a picture. overcoat_frame() makes one that shows a whole world.
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   Position of the camera, in metres.
   */
  float eye[3];
  /*
   Point in the middle of the picture, in metres.
   */
  float target[3];
  /*
   Upward direction, of any length but zero.
   */
  float up[3];
  /*
   Vertical field of view in radians, for programs of older headers: fov_y_degrees and intrinsics, if they are set, count in its
   place. All of them 0: a parallel projection.
   */
  float fov_y;
  /*
   Height of the view in metres, of a parallel projection.
   */
  float orthographic_height;
  /*
   Distance in metres before which nothing is drawn; 0: a thousandth of that to the target.
   */
  float near;
  /*
   Vertical field of view in degrees, below 180; 0: fov_y counts.
   */
  float fov_y_degrees;
  /*
   Distance in metres beyond which no surface is drawn; 0 or infinity: no limit.
   */
  float far;
  /*
   fx, fy, cx, cy of the matrix K = [fx 0 cx; 0 fy cy; 0 0 1] in pixels of the picture, whose upper left corner is (0, 0) and whose
   first pixel has its centre at (0.5, 0.5): a calibrated camera, whose principal point looks at `target`. All 0: by field of view.
   */
  double intrinsics[4];
} overcoat_camera;

/*
 Options of a picture.
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   Width in pixels; 0: that of the settings, or else 512.
   */
  uint32_t width;
  /*
   Height in pixels; 0: that of the settings, or else 512.
   */
  uint32_t height;
  /*
   Coverage samples a pixel, 1, 4, 8 or 16; 0: those of the settings, or else 8.
   */
  uint32_t samples;
  /*
   An overcoat_quality.
   */
  uint32_t quality;
  /*
   Name of the shading model of all materials ("gltf", "urp-mobile", "stacklit", ...); null: that of the settings or the materials.
   */
  const char *shading;
  /*
   All other settings, as a JSON object with the keys of scene files ({"tone_mapping": "agx", "ground": "none"}); null: their
   defaults. The model, the environment and lights are the world's, whatever stands there.
   */
  const char *settings;
  /*
   Units of work, about a nanosecond of one thread each, that a picture may take: it is drawn as well as that allows, by what
   the pictures before have taken. The same on every machine. 0: no bound.
   */
  uint64_t work_budget;
  /*
   Makes overcoat_result.hash, for tests: that takes a picture more.
   */
  bool wants_hash;
} overcoat_picture;

/*
 Camera of a picture as programs that compute with it need it.
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   An overcoat_projection.
   */
  uint32_t projection;
  /*
   Width of the picture in pixels.
   */
  uint32_t width;
  /*
   Height of the picture in pixels.
   */
  uint32_t height;
  /*
   fx, fy, cx, cy of the matrix K = [fx 0 cx; 0 fy cy; 0 0 1] in pixels: a point of the camera (x right, y down, z forward) is seen at
   u = fx x / z + cx, v = fy y / z + cy, where the first pixel's centre is (0.5, 0.5); of a parallel projection without "/ z".
   */
  double intrinsics[4];
  /*
   World to camera, column by column, in the convention of OpenCV: x right, y down, z forward.
   */
  double world_to_camera[16];
  /*
   Camera to world, column by column, in the convention of OpenGL: x right, y up, z backward; the last column is the position.
   */
  double camera_to_world[16];
  /*
   Distance in metres before which nothing is drawn.
   */
  float near;
  /*
   Distance in metres beyond which no surface is drawn; infinity without a limit.
   */
  float far;
} overcoat_view;

/*
 Memory that a picture, or a part of one, is drawn into.
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   An overcoat_pixel_format.
   */
  uint32_t format;
  /*
   The first byte of the first pixel. It need not be aligned.
   */
  uint8_t *pixels;
  /*
   Bytes that there are.
   */
  size_t length;
  /*
   Bytes from one row to the next; 0: as many as a row takes.
   */
  size_t stride;
  /*
   Left column, top row, width and height in pixels of the part of the picture that it holds; all 0: all of it.
   */
  uint32_t region[4];
} overcoat_target;

/*
 Report on a picture.
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   The overcoat_quality that it was drawn with.
   */
  uint32_t quality;
  /*
   Samples a pixel that it was drawn with.
   */
  uint32_t samples;
  /*
   True if overcoat_refine() has no better one.
   */
  bool is_final;
  /*
   Triangles that went in.
   */
  uint64_t triangles;
  /*
   Surface fragments that were shaded.
   */
  uint64_t fragments;
  /*
   XXH3-128 of the linear picture, 32 hexadecimal digits and a 0, as the overcoat command prints it; empty if not wanted.
   */
  char hash[33];
} overcoat_result;

/*
 Surface that is seen in a pixel.
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   Number of the triangle in the mesh; of meshes with colours by face, of the face.
   */
  uint32_t triangle;
  /*
   The instance; 0: nothing is seen.
   */
  uint64_t instance;
  /*
   The model that it came with; 0: none.
   */
  uint64_t model;
  /*
   Weights of the triangle's vertices, of sum 1.
   */
  float barycentric[3];
  /*
   Distance along the view in metres.
   */
  float depth;
  /*
   Position of that point in the world, in metres.
   */
  double position[3];
} overcoat_hit;

/*
 A plane of the G-buffer and the memory that it is drawn into.
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   Returned: numbers a pixel, 1 to 3.
   */
  uint32_t channels;
  /*
   Name of the quantity: "depth" (metres along the view), "position", "normal", "camera-normal", "object-id", "instance-id",
   "material-id", "base-color" and others, as `overcoat render --aov` takes them.
   */
  const char *name;
  /*
   Memory that is drawn into, row by row from the top, of floats or uint32_t as `kind` says; null: only the returned fields are
   wanted. It need not be aligned. 0 where no surface is.
   */
  void *data;
  /*
   Bytes that there are.
   */
  size_t length;
  /*
   Bytes from one row to the next; 0: as many as a row takes.
   */
  size_t stride;
  /*
   Returned: width in pixels.
   */
  uint32_t width;
  /*
   Returned: height in pixels.
   */
  uint32_t height;
  /*
   Returned: an overcoat_plane_kind.
   */
  uint32_t kind;
} overcoat_plane;

/*
 Pixels to be encoded, and how.
 */
typedef struct {
  /*
   Size of this structure in bytes, see OVERCOAT_INIT.
   */
  uint32_t size;
  /*
   The overcoat_pixel_format of the pixels: OVERCOAT_RGBA8 or OVERCOAT_BGRA8 for files of 8 bits, OVERCOAT_RGBA_F32_PREMULTIPLIED for
   those of linear light.
   */
  uint32_t pixel_format;
  /*
   Width in pixels.
   */
  uint32_t width;
  /*
   Height in pixels.
   */
  uint32_t height;
  /*
   Bytes from one row to the next; 0: as many as a row takes.
   */
  size_t stride;
  /*
   Name of the file format, as file name extensions have it: "png", "webp", "jpg" or "gif", of 8 bits; "exr" or "hdr", of linear light.
   Null: "png".
   */
  const char *format;
  /*
   Quality of JPEG, 1 to 100; 0: 90. JPEG has no transparency: the picture is laid over white.
   */
  uint32_t jpeg_quality;
  /*
   Numbers of OpenEXR have 32 bits in place of 16. Default false.
   */
  bool full_floats;
} overcoat_encoding;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 The version of the library, 10000 * major + 100 * minor + patch.
 */
uint32_t overcoat_version(void);

/*
 Makes an overcoat, with its threads. `options` may be null: all defaults. There is no message if that fails.
 */
overcoat_status overcoat_new(const overcoat_options *options, overcoat **overcoat_out);

/*
 Frees an overcoat with all that belongs to it, and sets the pointer to null, which all functions take for an invalid argument.
 Null, or a pointer to null, is left alone.
 */
void overcoat_free(overcoat **overcoat);

/*
 Error message of the last call with this overcoat, a sentence without a line break; empty if the call succeeded. The
 text stays until the next call with it.
 */
const char *overcoat_message(const overcoat *overcoat);

/*
 Stops the picture that another thread draws with this overcoat: that call returns OVERCOAT_CANCELLED soon. Without one, nothing
 happens.
 */
void overcoat_cancel(const overcoat *overcoat);

/*
 Adds an empty world under the studio environment.
 */
overcoat_status overcoat_world_new(overcoat *overcoat, uint64_t *world_out);

/*
 Frees a world with all that is in it.
 */
overcoat_status overcoat_world_free(overcoat *overcoat, uint64_t world);

/*
 Adds the model in a file (glTF, GLB, OBJ, STL, PLY, 3MF, FBX, COLLADA and others, told by its content) at a place: `matrix` may be null. Files that it
 refers to are read from its folder alone. Its first animation can be played by overcoat_set_pose(). `warning` may be null.
 */
overcoat_status overcoat_load_file(overcoat *overcoat,
                                   uint64_t world,
                                   const char *path,
                                   const double *matrix,
                                   overcoat_warning warning,
                                   void *user,
                                   uint64_t *model_out);

/*
 As overcoat_load_file(), from `length` bytes in memory. Other files that it refers to are not looked for. `format` is a file
 name extension ("glb") for what content does not tell, or null.
 */
overcoat_status overcoat_load_memory(overcoat *overcoat,
                                     uint64_t world,
                                     const uint8_t *bytes,
                                     size_t length,
                                     const char *format,
                                     const double *matrix,
                                     overcoat_warning warning,
                                     void *user,
                                     uint64_t *model_out);

/*
 Brings a model to a time of its animation, in seconds; beyond the end it begins again. One without an animation stays as it is.
 */
overcoat_status overcoat_set_pose(overcoat *overcoat,
                                  uint64_t world,
                                  uint64_t model,
                                  double seconds);

/*
 Moves a model with all of its parts.
 */
overcoat_status overcoat_set_model_transform(overcoat *overcoat,
                                             uint64_t world,
                                             uint64_t model,
                                             const double *matrix);

/*
 Hides a model's instances, or shows them again.
 */
overcoat_status overcoat_set_model_visible(overcoat *overcoat, uint64_t world, uint64_t model, bool visible);

/*
 Removes a model with all of its parts.
 */
overcoat_status overcoat_remove_model(overcoat *overcoat, uint64_t world, uint64_t model);

/*
 Surrounds a world. `kind` is an overcoat_environment_kind; of a file `data` is its path, of a named one its name, and `length` does not count; of
 memory they are its bytes; else null. It is turned about +Y by `rotation_degrees` and its light multiplied by `intensity` (1: as it is).
 */
overcoat_status overcoat_set_environment(overcoat *overcoat,
                                         uint64_t world,
                                         uint32_t kind,
                                         const char *data,
                                         size_t length,
                                         float rotation_degrees,
                                         float intensity);

/*
 Adds a mesh; it is copied. overcoat_add_instance() places it.
 */
overcoat_status overcoat_add_mesh(overcoat *overcoat,
                                  uint64_t world,
                                  const overcoat_mesh *mesh,
                                  uint64_t *mesh_out);

/*
 Puts another mesh in the place of one, in every instance of it.
 */
overcoat_status overcoat_set_mesh(overcoat *overcoat,
                                  uint64_t world,
                                  uint64_t mesh,
                                  const overcoat_mesh *with);

/*
 Removes a mesh of which there is no instance.
 */
overcoat_status overcoat_remove_mesh(overcoat *overcoat, uint64_t world, uint64_t mesh);

/*
 Fills a material with its defaults.
 */
void overcoat_material_defaults(overcoat_material *material);

/*
 Adds a material.
 */
overcoat_status overcoat_add_material(overcoat *overcoat,
                                      uint64_t world,
                                      const overcoat_material *material,
                                      uint64_t *material_out);

/*
 Puts another material in the place of one, in everything that is made of it. It has no textures.
 */
overcoat_status overcoat_set_material(overcoat *overcoat,
                                      uint64_t world,
                                      uint64_t material,
                                      const overcoat_material *with);

/*
 Removes a material that nothing is made of.
 */
overcoat_status overcoat_remove_material(overcoat *overcoat, uint64_t world, uint64_t material);

/*
 Fills a light with its defaults.
 */
void overcoat_light_defaults(overcoat_light *light);

/*
 Adds a light.
 */
overcoat_status overcoat_add_light(overcoat *overcoat,
                                   uint64_t world,
                                   const overcoat_light *light,
                                   uint64_t *light_out);

/*
 Puts another light in the place of one.
 */
overcoat_status overcoat_set_light(overcoat *overcoat,
                                   uint64_t world,
                                   uint64_t light,
                                   const overcoat_light *with);

/*
 Removes a light.
 */
overcoat_status overcoat_remove_light(overcoat *overcoat, uint64_t world, uint64_t light);

/*
 Removes all lights of a world, those of its models too.
 */
overcoat_status overcoat_clear_lights(overcoat *overcoat, uint64_t world);

/*
 Adds the material of a text: the name of a built-in material ("candy-red"), or a material file, which sets any parameter of any
 shading model ("base_color = [0.5, 0.02, 0.02]\ncoat = 1", one a line; `overcoat materials --keys` lists them), or a JSON object with
 the same keys ({"base_color": [0.5, 0.02, 0.02], "coat": 1}). Its textures are taken from `files`, which may be null, and from
 nowhere else; they go with it.
 */
overcoat_status overcoat_add_material_text(overcoat *overcoat,
                                           uint64_t world,
                                           const char *text,
                                           const overcoat_file *files,
                                           size_t file_count,
                                           uint64_t *material_out);

/*
 Puts the material of a text, as of overcoat_add_material_text(), in the place of one, in everything that is made of it. With
 "over = true" among its lines, or "over": true, all other parameters and textures stay.
 */
overcoat_status overcoat_set_material_text(overcoat *overcoat,
                                           uint64_t world,
                                           uint64_t material,
                                           const char *text,
                                           const overcoat_file *files,
                                           size_t file_count);

/*
 Sets a parameter of a material in everything that is made of it; all other parameters stay. `name` is one of any shading model
 ("coat", "coat_color", "sheen_color", "options.stacklit_newest", ...; `overcoat materials --keys` lists them with their ranges and units):
 one number, or 0 or 1 of a switch, three of a colour, which is linear, or four with its alpha.
 */
overcoat_status overcoat_material_set(overcoat *overcoat,
                                      uint64_t world,
                                      uint64_t material,
                                      const char *name,
                                      const float *values,
                                      size_t count);

/*
 Sets a parameter of a material that is a name ("alpha_mode" to "blend", "model" to "openpbr") or a colour as sRGB ("base_color" to
 "#c01020"), as overcoat_material_set().
 */
overcoat_status overcoat_material_set_text(overcoat *overcoat,
                                           uint64_t world,
                                           uint64_t material,
                                           const char *name,
                                           const char *value);

/*
 Tells a parameter of a material by its name, in the units of overcoat_material_set(): the count of its numbers goes to `count_out`, and as
 many of them as `capacity` has room for to `values_out`, which may be null if that is 0. A switch has one, 0 or 1, and so has a
 texture: 1 if there is one. "emissive" is multiplied by "emissive_strength", which is 1 therefore.
 */
overcoat_status overcoat_material_get(overcoat *overcoat,
                                      uint64_t world,
                                      uint64_t material,
                                      const char *name,
                                      float *values_out,
                                      size_t capacity,
                                      size_t *count_out);

/*
 Tells a parameter of a material by its name as text: a name without quotes ("blend"), everything else as JSON has it ("0.25",
 "[0.5, 0.02, 0.02]", "true"). The length of the text goes to `length_out`, and as much of it as `capacity` has room for, ended by a 0,
 to `text_out`, which may be null if that is 0.
 */
overcoat_status overcoat_material_get_text(overcoat *overcoat,
                                           uint64_t world,
                                           uint64_t material,
                                           const char *name,
                                           char *text_out,
                                           size_t capacity,
                                           size_t *length_out);

/*
 Sets a texture of a material ("base_color_texture", "normal_texture", "coat_texture", ...), as overcoat_material_set(). Null takes it away.
 It is copied. Of "metallic_texture" and "roughness_texture" the one that is not set is gone: "metallic_roughness_texture" has both.
 */
overcoat_status overcoat_material_set_texture(overcoat *overcoat,
                                              uint64_t world,
                                              uint64_t material,
                                              const char *name,
                                              const overcoat_texture *texture);

/*
 Places a mesh, made of a material. `matrix` may be null: as it is.
 */
overcoat_status overcoat_add_instance(overcoat *overcoat,
                                      uint64_t world,
                                      uint64_t mesh,
                                      uint64_t material,
                                      const double *matrix,
                                      uint64_t *instance_out);

/*
 Moves an instance: where it is in the world or, of a model's instance, in its model.
 */
overcoat_status overcoat_set_transform(overcoat *overcoat,
                                       uint64_t world,
                                       uint64_t instance,
                                       const double *matrix);

/*
 Hides an instance, or shows it again.
 */
overcoat_status overcoat_set_visible(overcoat *overcoat, uint64_t world, uint64_t instance, bool visible);

/*
 Makes an instance one of another material.
 */
overcoat_status overcoat_set_instance_material(overcoat *overcoat,
                                               uint64_t world,
                                               uint64_t instance,
                                               uint64_t material);

/*
 Removes an instance. Its mesh and its material stay.
 */
overcoat_status overcoat_remove_instance(overcoat *overcoat, uint64_t world, uint64_t instance);

/*
 The number of a model's instances goes to `count_out`, and as many of their names as `capacity` has room for to `instances_out`,
 which may be null if that is 0.
 */
overcoat_status overcoat_model_instances(overcoat *overcoat,
                                         uint64_t world,
                                         uint64_t model,
                                         uint64_t *instances_out,
                                         size_t capacity,
                                         size_t *count_out);

/*
 Makes a camera that shows all of a world in a picture of that aspect (width over height). `direction` is three floats from the
 world to the camera, or null: from where most is seen. Its field of view is in fov_y; fov_y_degrees, if it is set then, counts
 in its place.
 */
overcoat_status overcoat_frame(overcoat *overcoat,
                               uint64_t world,
                               const float *direction,
                               float aspect,
                               overcoat_camera *camera_out);

/*
 Tells the camera of the picture that overcoat_render() draws of the same arguments, without drawing it: the given one, that of
 the settings, or the one that shows all.
 */
overcoat_status overcoat_picture_camera(overcoat *overcoat,
                                        uint64_t world,
                                        const overcoat_camera *camera,
                                        const overcoat_picture *picture,
                                        overcoat_view *view_out);

/*
 Draws a world into memory of the caller, at once. `camera` may be null: that of the settings, or one that shows all.
 `result_out` may be null. After an error the memory may hold parts of the picture.
 */
overcoat_status overcoat_render(overcoat *overcoat,
                                uint64_t world,
                                const overcoat_camera *camera,
                                const overcoat_picture *picture,
                                const overcoat_target *target,
                                overcoat_result *result_out);

/*
 Draws the next better picture of what was drawn last, from draft to the quality that is asked for; from draft again if anything
 has changed. `drawn_out` becomes false if there is no better one: then the memory is left alone. The work budget does not count.
 */
overcoat_status overcoat_refine(overcoat *overcoat,
                                uint64_t world,
                                const overcoat_camera *camera,
                                const overcoat_picture *picture,
                                const overcoat_target *target,
                                bool *drawn_out,
                                overcoat_result *result_out);

/*
 Finds what is seen in column `x` and row `y` of a picture, without drawing it. After a picture of the same it takes a few
 microseconds. Splats, the floor and the environment are not found.
 */
overcoat_status overcoat_pick(overcoat *overcoat,
                              uint64_t world,
                              const overcoat_camera *camera,
                              const overcoat_picture *picture,
                              uint32_t x,
                              uint32_t y,
                              overcoat_hit *hit_out);

/*
 Draws planes of the G-buffer of the picture of the same arguments into memory of the caller, all of them at once. Width, height,
 channels and kind are written into each of `planes`, of which one without memory (`data` null) is only told, not drawn. Depth,
 directions, places and identities are those at the centres of pixels and no means; other quantities are means of a pixel.
 */
overcoat_status overcoat_render_planes(overcoat *overcoat,
                                       uint64_t world,
                                       const overcoat_camera *camera,
                                       const overcoat_picture *picture,
                                       overcoat_plane *planes,
                                       size_t plane_count);

/*
 Finds the instance of a number in the plane "instance-id" of the world as it is now; 0 for 0, where nothing is.
 */
overcoat_status overcoat_instance_of_id(overcoat *overcoat,
                                        uint64_t world,
                                        uint32_t id,
                                        uint64_t *instance_out);

/*
 Encodes pixels as a file of a format. `bytes_out` is to be given to overcoat_bytes_free().
 */
overcoat_status overcoat_encode(overcoat *overcoat,
                                const void *pixels,
                                const overcoat_encoding *encoding,
                                uint8_t **bytes_out,
                                size_t *length_out);

/*
 Encodes pictures of 8 bits and one size as a moving picture that begins again and again: "png" (animated), "webp" or "gif".
 `pixels` points to the first pixel of each of `count` pictures, all as `encoding` says; each is shown for 1 / `frames_per_second` s.
 */
overcoat_status overcoat_encode_movie(overcoat *overcoat,
                                      const void *const *pixels,
                                      size_t count,
                                      const overcoat_encoding *encoding,
                                      double frames_per_second,
                                      uint8_t **bytes_out,
                                      size_t *length_out);

/*
 Encodes pixels in OVERCOAT_RGBA8 as PNG, for thumbnails in files. `bytes_out` is to be given to overcoat_bytes_free().
 */
overcoat_status overcoat_encode_png(overcoat *overcoat,
                                    const uint8_t *pixels,
                                    uint32_t width,
                                    uint32_t height,
                                    size_t stride,
                                    uint8_t **bytes_out,
                                    size_t *length_out);

/*
 Frees what overcoat_encode(), overcoat_encode_movie() or overcoat_encode_png() has made, of the length that it said. Null is left alone.
 */
void overcoat_bytes_free(uint8_t *bytes,
                         size_t length);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* OVERCOAT_H */

#ifndef OVERCOAT_DEFAULTS_H
#define OVERCOAT_DEFAULTS_H
#if defined(__cplusplus)
template <class Structure> inline void overcoat_init(Structure &structure)
{
    memset(&structure, 0, sizeof structure);
    structure.size = sizeof structure;
}
template <> inline void overcoat_init(overcoat_material &structure)
{
    memset(&structure, 0, sizeof structure);
    structure.size = sizeof structure;
    overcoat_material_defaults(&structure);
}
template <> inline void overcoat_init(overcoat_light &structure)
{
    memset(&structure, 0, sizeof structure);
    structure.size = sizeof structure;
    overcoat_light_defaults(&structure);
}
#else
static inline void overcoat_nothing(void *structure)
{
    (void)structure;
}
#endif
#endif  /* OVERCOAT_DEFAULTS_H */

#!/usr/bin/env python3
"""A hand-written clear coat shader on Mesa's llvmpipe, through moderngl.

What a good programmer gets out of OpenGL in software, not what a renderer does in general: the formulas are those of
Unity's URP (as `overcoat --shading urp-desktop`), everything that is constant over the mesh is worked out on the
processor beforehand, and the environment is a mip-mapped picture that is filtered by averaging, not by the lobe.
Three environment terms: spherical harmonics for diffuse, a blurred lookup for the base and a sharp one for the coat.
"""

import os

os.environ.setdefault("LIBGL_ALWAYS_SOFTWARE", "1")
os.environ.setdefault("EGL_PLATFORM", "surfaceless")

import json
import math
import struct
import sys
import time

import common

try:
    import moderngl
    import numpy
except ImportError as error:
    common.missing(f"{error} (pip install moderngl numpy)")

STARTUP = time.process_time()

VERTEX = """
#version 330 core
uniform mat4 clip_from_world;
in vec3 position;
in vec3 normal;
out vec3 world;
out vec3 direction;
void main() {
    world = position;
    direction = normal;
    gl_Position = clip_from_world * vec4(position, 1.0);
}
"""

# What depends on roughness alone comes from Python; see `lobe` below.
FRAGMENT = """
uniform vec3 eye;
uniform vec3 light;
uniform vec3 light_color;
uniform vec3 diffuse_color;
uniform vec3 specular_color;
uniform float grazing;
uniform vec4 base_lobe;
uniform vec4 coat_lobe;
uniform float coat;
in vec3 world;
in vec3 direction;
out vec4 color;

#if ENVIRONMENT
uniform sampler2D surroundings;
uniform vec3 harmonics[9];

vec3 irradiance(vec3 n) {
    return harmonics[0] + harmonics[1] * n.y + harmonics[2] * n.z + harmonics[3] * n.x
        + harmonics[4] * (n.x * n.y) + harmonics[5] * (n.y * n.z) + harmonics[6] * (3.0 * n.z * n.z - 1.0)
        + harmonics[7] * (n.x * n.z) + harmonics[8] * (n.x * n.x - n.y * n.y);
}

// The sphere unfolded on a square: no dearer than a lookup by angles, and without poles.
vec2 unfolded(vec3 d) {
    d /= abs(d.x) + abs(d.y) + abs(d.z);
    vec2 low = (1.0 - abs(d.zx)) * vec2(d.x < 0.0 ? -1.0 : 1.0, d.z < 0.0 ? -1.0 : 1.0);
    return (d.y < 0.0 ? low : d.xz) * 0.5 + 0.5;
}
#endif

// x: roughness squared less one, y: roughness squared, z: four times roughness plus two.
float lobe(vec4 l, float n_h, float l_h) {
    float d = n_h * n_h * l.x + 1.00001;
    return l.y / (d * d * max(0.1, l_h * l_h) * l.z);
}

void main() {
    vec3 n = normalize(direction);
    vec3 v = normalize(eye - world);
    float n_v = clamp(dot(n, v), 0.0, 1.0);
    float n_l = clamp(dot(n, light), 0.0, 1.0);
    vec3 h = normalize(light + v);
    float n_h = clamp(dot(n, h), 0.0, 1.0);
    float l_h = clamp(dot(light, h), 0.0, 1.0);
    float rim = 1.0 - n_v;
    rim *= rim;
    rim *= rim;
    float covered = coat * (0.04 + 0.96 * rim);

    vec3 base = diffuse_color + specular_color * lobe(base_lobe, n_h, l_h);
    vec3 sum = (base * (1.0 - covered) + coat * 0.04 * lobe(coat_lobe, n_h, l_h)) * light_color * n_l;
#if ENVIRONMENT
    vec2 mirrored = unfolded(reflect(-v, n));
    vec3 blurred = textureLod(surroundings, mirrored, base_lobe.w).rgb;
    vec3 sharp = textureLod(surroundings, mirrored, coat_lobe.w).rgb;
    vec3 around = diffuse_color * irradiance(n)
        + blurred * mix(specular_color, vec3(grazing), rim) / (base_lobe.y + 1.0);
    sum += around * (1.0 - covered) + coat * sharp * mix(0.04, 1.0, rim) / (coat_lobe.y + 1.0);
#endif

    // Khronos PBR neutral, then the curve of sRGB as a power.
    float low = min(sum.r, min(sum.g, sum.b));
    sum -= low < 0.08 ? low - 6.25 * low * low : 0.04;
    float peak = max(sum.r, max(sum.g, sum.b));
    if (peak > 0.76) {
        float pressed = 1.0 - 0.0576 / (peak - 0.52);
        float gray = 1.0 / (0.15 * (peak - pressed) + 1.0);
        sum = mix(vec3(pressed), sum * (pressed / peak), gray);
    }
    color = vec4(pow(sum, vec3(1.0 / 2.2)), 1.0);
}
"""

# Pixels of a side; its smallest mip levels are not used, in which the sphere would be a few texels.
UNFOLDED = 256


def read_glb(path):
    """Positions, normals, indices and the material of the first primitive, without copies."""
    with open(path, "rb") as file:
        data = file.read()
    length = struct.unpack_from("<12xI", data)[0]
    document = json.loads(data[20 : 20 + length])
    start = 20 + length + 8
    primitive = document["meshes"][0]["primitives"][0]

    def accessor(index):
        a = document["accessors"][index]
        view = document["bufferViews"][a["bufferView"]]
        kind = {5126: "<f4", 5123: "<u2", 5125: "<u4"}[a["componentType"]]
        count = a["count"] * (3 if a["type"] == "VEC3" else 1)
        return numpy.frombuffer(data, kind, count, start + view["byteOffset"])

    attributes = primitive["attributes"]
    return (
        accessor(attributes["POSITION"]),
        accessor(attributes["NORMAL"]),
        accessor(primitive["indices"]),
        document["materials"][primitive["material"]],
    )


def read_hdr(path):
    """Height x width x 3 of a Radiance picture with unpacked scanlines, as inputs.py writes them."""
    with open(path, "rb") as file:
        data = file.read()
    head = data.index(b"\n\n") + 2
    end = data.index(b"\n", head)
    _, height, _, width = data[head:end].split()
    pixels = numpy.frombuffer(data, numpy.uint8, offset=end + 1).reshape(int(height), int(width), 4)
    scale = numpy.ldexp(numpy.float32(1.0), pixels[..., 3].astype(numpy.int32) - 136)
    return pixels[..., :3] * scale[..., None]


def longitude_of(x, z):
    """Fraction of the picture's width: its middle is seen along +X, its three quarters along +Z, as in overcoat."""
    return 0.5 + numpy.arctan2(z, x) / math.tau


def unfold(picture):
    """The environment on a square whose middle is up and whose corners are down."""
    height, width = picture.shape[:2]
    side = (numpy.arange(UNFOLDED, dtype=numpy.float32) + 0.5) * (2.0 / UNFOLDED) - 1.0
    x, z = numpy.meshgrid(side, side)
    y = 1.0 - abs(x) - abs(z)
    fold = numpy.maximum(-y, 0.0)
    x = x - numpy.copysign(fold, x)
    z = z - numpy.copysign(fold, z)
    length = numpy.sqrt(x * x + y * y + z * z)
    column = (longitude_of(x, z) * width).astype(numpy.int32) % width
    row = numpy.minimum((numpy.arccos(y / length) * (height / math.pi)).astype(numpy.int32), height - 1)
    return picture[row, column].astype("f4")


def harmonics(picture):
    """Nine coefficients of the irradiance divided by pi, with all constants folded in."""
    small = picture.reshape(32, picture.shape[0] // 32, 64, picture.shape[1] // 64, 3).mean((1, 3))
    polar = (numpy.arange(32) + 0.5) * (math.pi / 32)
    azimuth = ((numpy.arange(64) + 0.5) / 64 - 0.5) * math.tau
    sin = numpy.sin(polar)[:, None]
    x, z = sin * numpy.cos(azimuth), sin * numpy.sin(azimuth)
    y = numpy.broadcast_to(numpy.cos(polar)[:, None], x.shape)
    weight = sin * (math.pi / 32) * (math.tau / 64)
    basis = (numpy.ones_like(x), y, z, x, x * y, y * z, 3.0 * z * z - 1.0, x * z, x * x - y * y)
    # Squared normalization of each function times the cosine lobe over pi: 1, 2/3, 1/4.
    factors = [0.25 / math.pi] + 3 * [0.5 / math.pi]
    factors += [15.0 / (16.0 * math.pi), 15.0 / (16.0 * math.pi), 5.0 / (64.0 * math.pi)]
    factors += [15.0 / (16.0 * math.pi), 15.0 / (64.0 * math.pi)]
    return [f * numpy.einsum("ijc,ij->c", small, b * weight) for f, b in zip(factors, basis)]


def lobe(perceptual, levels):
    """What the shader wants to know of a roughness."""
    roughness = max(perceptual * perceptual, 0.0078125)
    square = roughness * roughness
    level = perceptual * (1.7 - 0.7 * perceptual) * (levels - 3)
    return (square - 1.0, square, 4.0 * roughness + 2.0, level)


def material_uniforms(material):
    """URP's clear coat: what lies under a coat reflects less and looks rougher."""
    pbr = material["pbrMetallicRoughness"]
    layer = material.get("extensions", {}).get("KHR_materials_clearcoat", {})
    coat = layer.get("clearcoatFactor", 0.0)
    color, metallic = numpy.array(pbr["baseColorFactor"][:3]), pbr["metallicFactor"]
    reflectivity = 0.04 + 0.96 * metallic
    f0 = 0.04 * (1.0 - metallic) + color * metallic
    root = numpy.sqrt(f0)
    under = numpy.clip(((1.0 - 5.0 * root) / (5.0 - root)) ** 2, 0.0, 1.0)
    index_ratio = 1.0 + coat * (1.0 / 1.5 - 1.0)
    variance = (2.0 / (pbr["roughnessFactor"] ** 4 + 1e-7) - 2.0) ** -1.0 * index_ratio**2
    perceptual = (2.0 / (1.0 / variance + 2.0)) ** 0.25
    levels = math.log2(UNFOLDED) + 1
    return {
        "diffuse_color": tuple(color * (1.0 - reflectivity)),
        "specular_color": tuple(f0 + (under - f0) * coat),
        "grazing": min(1.0 - pbr["roughnessFactor"] + reflectivity, 1.0),
        "base_lobe": lobe(perceptual, levels),
        "coat_lobe": lobe(layer.get("clearcoatRoughnessFactor", 0.0), levels),
        "coat": coat,
    }


def clip_from_world(position, aspect):
    """Column-major matrix of a camera that looks at the origin."""
    p = numpy.array(position)
    back = p / numpy.linalg.norm(p)
    right = numpy.cross((0.0, 1.0, 0.0), back)
    right /= numpy.linalg.norm(right)
    view = numpy.identity(4)
    view[:3, :3] = (right, numpy.cross(back, right), back)
    view[:3, 3] = -view[:3, :3] @ p
    scale = 1.0 / math.tan(math.radians(common.FIELD_OF_VIEW) / 2.0)
    near, far = common.NEAR, common.FAR
    projection = numpy.zeros((4, 4))
    projection[0, 0], projection[1, 1] = scale / aspect, scale
    projection[2, 2:] = (far + near) / (near - far), 2.0 * far * near / (near - far)
    projection[3, 2] = -1.0
    return (projection @ view).T.astype("f4").tobytes()


class Program:
    """The OpenGL objects that stay while models come and go."""

    def __init__(self, args):
        self.size = (args.width, args.height)
        try:
            self.context = moderngl.create_context(standalone=True, backend="egl", require=330)
        except Exception as error:
            common.missing(f"no OpenGL context through EGL: {error} (apt install libegl1 libgl1-mesa-dri)")
        info = self.context.info
        self.version = f"{info['GL_RENDERER']}, {info['GL_VERSION']}, moderngl {moderngl.__version__}"
        if "llvmpipe" not in info["GL_RENDERER"]:
            common.missing(f"OpenGL is {info['GL_RENDERER']}, not llvmpipe")
        if args.mode == "probe":
            return
        lit = f"#version 330 core\n#define ENVIRONMENT {int(bool(args.environment))}\n"
        self.program = self.context.program(VERTEX, lit + FRAGMENT)
        light = numpy.array(common.LIGHT)
        self.set(light=tuple(light / numpy.linalg.norm(light)), light_color=(LIGHT_SCALE,) * 3)
        if args.environment:
            picture = read_hdr(args.environment)
            self.texture = self.context.texture((UNFOLDED, UNFOLDED), 3, unfold(picture).tobytes(), dtype="f4",
                                                internal_format=0x881B)
            self.texture.build_mipmaps()
            self.texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
            self.texture.repeat_x = self.texture.repeat_y = False
            self.texture.use(0)
            self.program["harmonics"].write(numpy.array(harmonics(picture), "f4").tobytes())
        self.resolved = self.context.framebuffer([self.context.renderbuffer(self.size, 4)],
                                                 self.context.depth_renderbuffer(self.size))
        self.target = self.resolved
        if args.samples > 1:
            self.target = self.context.framebuffer(
                [self.context.renderbuffer(self.size, 4, samples=args.samples)],
                self.context.depth_renderbuffer(self.size, samples=args.samples),
            )
        self.context.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self.pixels = bytearray(4 * args.width * args.height)
        self.objects = []

    def set(self, **uniforms):
        for name, value in uniforms.items():
            # A shader without the environment has dropped some.
            if name in self.program:
                self.program[name].value = value

    def load(self, path):
        for thing in self.objects:
            thing.release()
        positions, normals, indices, material = read_glb(path)
        buffers = [self.context.buffer(data) for data in (positions, normals, indices)]
        self.mesh = self.context.vertex_array(
            self.program,
            [(buffers[0], "3f", "position"), (buffers[1], "3f", "normal")],
            buffers[2],
            index_element_size=indices.itemsize,
        )
        self.objects = [self.mesh, *buffers]
        self.set(**material_uniforms(material))

    def frame(self, k, n):
        position = common.eye(k, n)
        self.program["eye"].value = position
        self.program["clip_from_world"].write(clip_from_world(position, self.size[0] / self.size[1]))
        self.target.use()
        self.target.clear(*common.BACKGROUND, 1.0)
        self.mesh.render()
        if self.target is not self.resolved:
            self.context.copy_framebuffer(self.resolved, self.target)
        self.resolved.read_into(self.pixels, components=4)


# Radiance of the light in URP's sense, which leaves out the division by pi.
LIGHT_SCALE = 3.0 / math.pi


def main():
    args = common.arguments(__doc__)
    program = Program(args)
    if args.mode == "probe":
        common.finish({"peer": "llvmpipe", "version": program.version})
        return
    if args.mode != "models":
        program.load(args.model[0])

    def picture(path):
        program.frame(0, 1)
        common.write_png(path, *program.size, program.pixels)

    def model(path):
        program.load(path)
        program.frame(0, 1)

    common.run(args, "llvmpipe", program.version, STARTUP, picture, program.frame, model)


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""A hand-written clear coat shader on Mesa's llvmpipe, through moderngl.

What a good programmer gets out of OpenGL in software, not what a renderer does in general: the formulas are those of
Unity's URP (as `overcoat --shading urp-desktop`), everything that is constant over the mesh is worked out on the
processor beforehand, and the environment is a mip-mapped picture that is filtered by averaging, not by the lobe.
Three environment terms: spherical harmonics for diffuse, a blurred lookup for the base and a sharp one for the coat.
Textures, if the model has them, are those of `knot_textured.glb`: base colour, normal, and occlusion with roughness and
metallic, filtered trilinearly.
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
import llvmpipe_shader
import pictures

try:
    import moderngl
    import numpy
except ImportError as error:
    common.missing(f"{error} (pip install moderngl numpy)")

STARTUP = time.process_time()

# Pixels of a side of the environment.
UNFOLDED = 256

# Names of OpenGL.
RGBA8, RGB16F, SRGB8_ALPHA8 = 0x8058, 0x881B, 0x8C43


class Model:
    """The first primitive of a GLB, without copies, and its material."""

    def __init__(self, path):
        with open(path, "rb") as file:
            self.data = file.read()
        length = struct.unpack_from("<12xI", self.data)[0]
        self.document = json.loads(self.data[20 : 20 + length])
        self.start = 20 + length + 8
        primitive = self.document["meshes"][0]["primitives"][0]
        attributes = primitive["attributes"]
        self.positions = self.accessor(attributes["POSITION"])
        self.normals = self.accessor(attributes["NORMAL"])
        self.indices = self.accessor(primitive["indices"])
        self.material = self.document["materials"][primitive["material"]]
        if is_textured(self.material):
            self.coordinates = self.accessor(attributes["TEXCOORD_0"])

    def accessor(self, index):
        a = self.document["accessors"][index]
        view = self.document["bufferViews"][a["bufferView"]]
        kind = {5126: "<f4", 5123: "<u2", 5125: "<u4"}[a["componentType"]]
        count = a["count"] * {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[a["type"]]
        return numpy.frombuffer(self.data, kind, count, self.start + view["byteOffset"])

    def picture(self, texture):
        """Size and RGBA bytes, the upper row first, of a texture with its index."""
        image = self.document["images"][self.document["textures"][texture["index"]]["source"]]
        view = self.document["bufferViews"][image["bufferView"]]
        start = self.start + view["byteOffset"]
        width, height, channels, rows = pictures.decode(self.data[start : start + view["byteLength"]])
        pixels = numpy.full((height, width, 4), 255, numpy.uint8)
        pixels[..., :channels] = numpy.frombuffer(b"".join(rows), numpy.uint8).reshape(height, width, channels)
        return (width, height), pixels.tobytes()

    def tangents(self):
        """Unit vector along u and the side of the one along v for each vertex, from the triangles around it."""
        corners = self.indices.reshape(-1, 3).astype(numpy.int64)
        p, uv = (a.reshape(-1, n)[corners].astype("f8") for a, n in ((self.positions, 3), (self.coordinates, 2)))
        edges, steps = p[:, 1:] - p[:, :1], uv[:, 1:] - uv[:, :1]
        area = steps[:, 0, 0] * steps[:, 1, 1] - steps[:, 0, 1] * steps[:, 1, 0]
        side = numpy.sign(area)[:, None]
        u = (edges[:, 0] * steps[:, 1, 1, None] - edges[:, 1] * steps[:, 0, 1, None]) * side
        sums, sides = numpy.zeros((len(self.positions) // 3, 3)), numpy.zeros(len(self.positions) // 3)
        normals = self.normals.reshape(-1, 3)
        faces = (numpy.cross(edges[:, 0], edges[:, 1]) * normals[corners[:, 0]]).sum(1)
        for k in range(3):
            numpy.add.at(sums, corners[:, k], u)
            # Rows of a picture run down and the green of a normal map up.
            numpy.add.at(sides, corners[:, k], -side[:, 0] * numpy.sign(faces))
        sums /= numpy.maximum(numpy.linalg.norm(sums, axis=1), 1e-12)[:, None]
        return numpy.column_stack((sums, numpy.where(sides < 0.0, -1.0, 1.0))).astype("f4")


def is_textured(material):
    return "baseColorTexture" in material["pbrMetallicRoughness"]


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


def lobe(perceptual):
    """What the shader wants to know of a roughness."""
    roughness = max(perceptual * perceptual, 0.0078125)
    square = roughness * roughness
    level = perceptual * (1.7 - 0.7 * perceptual) * llvmpipe_shader.ROUGHNESS_LEVELS
    return (square - 1.0, square, 4.0 * roughness + 2.0, level)


def material_uniforms(material):
    """URP's clear coat: what lies under a coat reflects less and looks rougher."""
    pbr = material["pbrMetallicRoughness"]
    layer = material.get("extensions", {}).get("KHR_materials_clearcoat", {})
    coat = layer.get("clearcoatFactor", 0.0)
    uniforms = {"coat_lobe": lobe(layer.get("clearcoatRoughnessFactor", 0.0)), "coat": coat}
    if is_textured(material):
        return uniforms
    color, metallic = numpy.array(pbr["baseColorFactor"][:3]), pbr["metallicFactor"]
    reflectivity = 0.04 + 0.96 * metallic
    f0 = 0.04 * (1.0 - metallic) + color * metallic
    root = numpy.sqrt(f0)
    under = numpy.clip(((1.0 - 5.0 * root) / (5.0 - root)) ** 2, 0.0, 1.0)
    index_ratio = 1.0 + coat * (1.0 / 1.5 - 1.0)
    variance = (2.0 / (pbr["roughnessFactor"] ** 4 + 1e-7) - 2.0) ** -1.0 * index_ratio**2
    perceptual = (2.0 / (1.0 / variance + 2.0)) ** 0.25
    return {
        **uniforms,
        "diffuse_color": tuple(color * (1.0 - reflectivity)),
        "specular_color": tuple(f0 + (under - f0) * coat),
        "grazing": min(1.0 - pbr["roughnessFactor"] + reflectivity, 1.0),
        "base_lobe": lobe(perceptual),
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
        self.textured = is_textured(common.paint(args.model[0]))
        self.program = self.context.program(
            llvmpipe_shader.vertex(self.textured),
            llvmpipe_shader.fragment(bool(args.environment), self.textured),
        )
        light = numpy.array(common.LIGHT)
        self.set(light=tuple(light / numpy.linalg.norm(light)), light_color=(LIGHT_SCALE,) * 3)
        if args.environment:
            picture = read_hdr(args.environment)
            self.texture = self.context.texture((UNFOLDED, UNFOLDED), 3, unfold(picture).tobytes(), dtype="f4",
                                                internal_format=RGB16F)
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
        model = Model(path)
        if is_textured(model.material) != self.textured:
            common.missing("either all models have textures or none has")
        vertices = [(model.positions, "3f", "position"), (model.normals, "3f", "normal")]
        if self.textured:
            vertices += [(model.coordinates, "2f", "coordinates"), (model.tangents(), "4f", "tangent")]
        buffers = [self.context.buffer(data) for data, _, _ in vertices]
        indices = self.context.buffer(model.indices)
        self.mesh = self.context.vertex_array(
            self.program,
            [(buffer, form, name) for buffer, (_, form, name) in zip(buffers, vertices)],
            indices,
            index_element_size=model.indices.itemsize,
        )
        self.objects = [self.mesh, indices, *buffers]
        self.set(**material_uniforms(model.material))
        if self.textured:
            self.objects += self.load_textures(model)

    def load_textures(self, model):
        """Into the units after the environment's."""
        pbr = model.material["pbrMetallicRoughness"]
        maps = {
            "base_color_map": (pbr["baseColorTexture"], SRGB8_ALPHA8),
            "normal_map": (model.material["normalTexture"], RGBA8),
            "packed_map": (pbr["metallicRoughnessTexture"], RGBA8),
        }
        textures = []
        for unit, (name, (texture, form)) in enumerate(maps.items(), 1):
            size, pixels = model.picture(texture)
            texture = self.context.texture(size, 4, pixels, internal_format=form)
            texture.build_mipmaps()
            texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
            texture.use(unit)
            self.set(**{name: unit})
            textures.append(texture)
        return textures

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

#!/usr/bin/env python3
"""Makes the models and the environment that every renderer of the comparison draws.

Models are GLB files with positions, normals and one car paint (metallic, rough, KHR_materials_clearcoat), and one
directional light (KHR_lights_punctual). Every model is centred and fills the unit sphere, so that one camera suits
all. One knot more has three textures in place of the paint's numbers. Only the standard library is used, without random
numbers: the same Python writes the same bytes.
"""

import argparse
import json
import math
import struct
import sys
from array import array
from pathlib import Path

from common import png

# Turns around the axis, turns around the ring, radii of ring, lift and tube.
KNOT = (2, 3, 1.0, 0.42, 0.19)
# Name, steps along the knot, steps around it. Two triangles for each cell.
KNOTS = {
    "5k": (125, 20),
    "100k": (625, 80),
    "1m": (2500, 200),
    "5m": (6250, 400),
}
# Side of the textured knot's textures, and how often they are laid along the knot and around it: texels are about as
# long as wide.
TEXTURE_SIZE = 2048
TEXTURE_REPEATS = (3.0, 0.25)
MODELS = 24
FEWEST, MOST = 3_000, 40_000

# Towards the light, before it is normalized; lux.
LIGHT = (0.4, 0.8, 0.45)
LIGHT_INTENSITY = 3.0

ENVIRONMENT_SIZE = (512, 256)
PAINT = {"color": (0.72, 0.03, 0.04), "metallic": 0.25, "roughness": 0.45, "coat": 1.0, "coat_roughness": 0.06}


def knot_rows(turns, windings, ring, lift, tube, along, around):
    """Rows of (position, normal) around a tube that follows a torus knot.

    The knot lies on a torus with radii `ring` and `lift`. The torus' normal is at right angles to the knot, so with
    the tangent it makes a frame that closes after one turn, and the normals are exact.
    """
    circle = [(math.cos(v), math.sin(v)) for v in (math.tau * k / around for k in range(around))]
    for step in range(along):
        t = math.tau * step / along
        cos_p, sin_p = math.cos(turns * t), math.sin(turns * t)
        cos_q, sin_q = math.cos(windings * t), math.sin(windings * t)
        radius = ring + lift * cos_q
        center = (radius * cos_p, radius * sin_p, lift * sin_q)
        normal = (cos_q * cos_p, cos_q * sin_p, sin_q)
        fall = -lift * windings * sin_q
        tangent = (
            fall * cos_p - radius * turns * sin_p,
            fall * sin_p + radius * turns * cos_p,
            lift * windings * cos_q,
        )
        other = normalized(cross(tangent, normal))
        row = []
        for c, s in circle:
            n = (
                c * normal[0] + s * other[0],
                c * normal[1] + s * other[1],
                c * normal[2] + s * other[2],
            )
            row.append(((center[0] + tube * n[0], center[1] + tube * n[1], center[2] + tube * n[2]), n))
        yield row


def surface_rows(point, along, around):
    """Rows of (position, normal) of a closed surface given by a function of two angles; normals by differences."""
    step = 1e-4
    for j in range(along):
        u = math.tau * j / along
        row = []
        for i in range(around):
            v = math.tau * i / around
            du = difference(point(u + step, v), point(u - step, v))
            dv = difference(point(u, v + step), point(u, v - step))
            row.append((point(u, v), normalized(cross(du, dv))))
        yield row


def fluted_torus(flutes, depth, tube):
    """A torus whose tube swells and shrinks along the way."""

    def point(u, v):
        r = tube * (1.0 + depth * math.sin(flutes * u) * math.cos(2.0 * v))
        return ((1.0 + r * math.cos(v)) * math.cos(u), (1.0 + r * math.cos(v)) * math.sin(u), r * math.sin(v))

    return point


def folded_ring(folds, height, tube):
    """A ring that waves up and down."""

    def point(u, v):
        r = 1.0 + tube * math.cos(v)
        return (r * math.cos(u), r * math.sin(u), tube * math.sin(v) + height * math.sin(folds * u))

    return point


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def difference(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def normalized(a):
    length = math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
    return (a[0] / length, a[1] / length, a[2] / length)


def fit(rows):
    """Centre of the bounding box and the radius around it."""
    points = [p for row in rows for p, _ in row]
    low = [min(p[k] for p in points) for k in range(3)]
    high = [max(p[k] for p in points) for k in range(3)]
    center = tuple((a + b) / 2.0 for a, b in zip(low, high))
    return center, max(math.dist(p, center) for p in points)


def mesh(rows, along, around, center, radius, closed=True):
    """Arrays of positions, normals and indices of rows, of `around` vertices each.

    They close in both directions; or the first row and the first of each row come again at the end.
    """
    scale = 1.0 / radius
    cx, cy, cz = center
    positions, normals = array("f"), array("f")
    for row in rows:
        flat, directions = [], []
        for (x, y, z), n in row:
            flat += ((x - cx) * scale, (y - cy) * scale, (z - cz) * scale)
            directions += n
        positions.extend(flat)
        normals.extend(directions)
    indices = array("I" if along * around > 0xFFFF else "H")
    outwards = faces_outwards(positions, normals, around)
    for j in range(along if closed else along - 1):
        here, there = j * around, (j + 1) % along * around
        cells = []
        for i in range(around if closed else around - 1):
            k = (i + 1) % around
            a, b, c, d = here + i, there + i, there + k, here + k
            cells += (a, b, c, a, c, d) if outwards else (a, c, b, a, d, c)
        indices.extend(cells)
    return positions, normals, indices


def faces_outwards(positions, normals, around):
    """Whether here, next row, next row's neighbour turn counter-clockwise seen from outside."""
    a, b, c = (tuple(positions[3 * k : 3 * k + 3]) for k in (0, around, around + 1))
    n = cross(difference(b, a), difference(c, a))
    return sum(n[k] * normals[k] for k in range(3)) > 0.0


def rotation_towards(direction):
    """Quaternion (x, y, z, w) that turns +Z to a direction: glTF lights shine along their -Z."""
    x, y, z = normalized(direction)
    return [v / math.sqrt(2.0 + 2.0 * z) for v in (-y, x, 0.0, 1.0 + z)]


def little_endian(values):
    if sys.byteorder == "big":
        values = array(values.typecode, values)
        values.byteswap()
    return values.tobytes()


def write_glb(path, parts, paint, texture_coordinates=None, textures=()):
    """A GLB file; `textures` are PNG files: base colour, normal, and occlusion with roughness and metallic."""
    positions, normals, indices = parts
    blobs = [little_endian(positions), little_endian(normals), little_endian(indices)]
    blobs[2] += bytes(-len(blobs[2]) % 4)
    offsets = [0, len(blobs[0]), len(blobs[0]) + len(blobs[1])]
    vertices = len(positions) // 3
    document = {
        "asset": {"version": "2.0", "generator": "overcoat benches/peers"},
        "extensionsUsed": ["KHR_materials_clearcoat", "KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": LIGHT_INTENSITY}]}},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"mesh": 0},
            {"rotation": rotation_towards(LIGHT), "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]}],
        "materials": [
            {
                "name": "paint",
                "pbrMetallicRoughness": {
                    "baseColorFactor": [*paint["color"], 1.0],
                    "metallicFactor": paint["metallic"],
                    "roughnessFactor": paint["roughness"],
                },
                "extensions": {
                    "KHR_materials_clearcoat": {
                        "clearcoatFactor": paint["coat"],
                        "clearcoatRoughnessFactor": paint["coat_roughness"],
                    }
                },
            }
        ],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "type": "VEC3",
                "count": vertices,
                "min": [min(positions[k::3]) for k in range(3)],
                "max": [max(positions[k::3]) for k in range(3)],
            },
            {"bufferView": 1, "componentType": 5126, "type": "VEC3", "count": vertices},
            {
                "bufferView": 2,
                "componentType": 5123 if indices.typecode == "H" else 5125,
                "type": "SCALAR",
                "count": len(indices),
            },
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": offset, "byteLength": len(blob), "target": target}
            for offset, blob, target in zip(offsets, blobs, (34962, 34962, 34963))
        ],
    }
    if textures:
        add_textures(document, blobs, texture_coordinates, textures)
    document["buffers"] = [{"byteLength": sum(map(len, blobs))}]
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary = sum(map(len, blobs))
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + binary))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", binary, b"BIN\0"))
        for blob in blobs:
            file.write(blob)


def add_textures(document, blobs, texture_coordinates, textures):
    """Texture coordinates for the one mesh of a document, and textures in place of its paint's numbers."""

    def view(blob):
        views = document["bufferViews"]
        views.append({"buffer": 0, "byteOffset": sum(map(len, blobs)), "byteLength": len(blob)})
        blobs.append(blob + bytes(-len(blob) % 4))
        return len(views) - 1

    coordinates = view(little_endian(texture_coordinates))
    count = len(texture_coordinates) // 2
    document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = len(document["accessors"])
    document["accessors"].append({"bufferView": coordinates, "componentType": 5126, "type": "VEC2", "count": count})
    document["images"] = [{"bufferView": view(picture), "mimeType": "image/png"} for picture in textures]
    # Linear within a level and between levels.
    document["samplers"] = [{"magFilter": 9729, "minFilter": 9987}]
    document["textures"] = [{"source": k, "sampler": 0} for k in range(3)]
    material = document["materials"][0]
    material["pbrMetallicRoughness"] = {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 2}}
    material["normalTexture"] = {"index": 1}
    material["occlusionTexture"] = {"index": 2}


def waves(size, low, high, counts):
    """Bytes from low to high that repeat after `size` of them: a sum of so many waves each."""
    sums = [sum(math.sin(math.tau * n * (k / size) + n) for n in counts) / len(counts) for k in range(size)]
    return bytes(round(low + (high - low) * (0.5 + 0.5 * v)) for v in sums)


def pictures(size):
    """Three textures as PNG: base colour, normal, and occlusion with roughness and metallic."""

    def weave(channels):
        """Rows of three channels: `(across, down)`, of which the one is shifted by the other, or down alone."""
        for y in range(size):
            row = bytearray(3 * size)
            for n, (across, down) in enumerate(channels):
                shift = down[y] * 4 % size
                row[n::3] = across[shift:] + across[:shift] if across else bytes((down[y],)) * size
            yield bytes(row)

    slow, quick = waves(size, 0, 255, (2, 5)), waves(size, 0, 255, (3, 17, 41))
    still = bytes(size)
    base_color = ((waves(size, 90, 240, (3, 11, 53)), slow), (waves(size, 20, 130, (7, 29)), quick), (slow, quick))
    normal = ((waves(size, 108, 148, (40, 97)), still), (None, waves(size, 108, 148, (32, 89))), (None, b"\xfd" * size))
    occlusion, roughness = waves(size, 200, 255, (5, 13)), waves(size, 40, 200, (4, 23))
    packed = ((occlusion, slow), (roughness, quick), (waves(size, 0, 90, (6, 19)), slow))
    return [png(size, size, 3, weave(channels)) for channels in (base_color, normal, packed)]


def write_textured_knot(path, along, around):
    center, radius = fit(knot_rows(*KNOT, 200, 24))
    rows = [row + row[:1] for row in knot_rows(*KNOT, along, around)]
    rows.append(rows[0])
    coordinates = array("f")
    for j in range(along + 1):
        for i in range(around + 1):
            coordinates.extend((TEXTURE_REPEATS[0] * j / along, TEXTURE_REPEATS[1] * i / around))
    parts = mesh(rows, along + 1, around + 1, center, radius, closed=False)
    write_glb(path, parts, PAINT, coordinates, pictures(TEXTURE_SIZE))


def write_knot(path, along, around):
    # From a coarse knot, so that all sizes lie alike.
    center, radius = fit(knot_rows(*KNOT, 200, 24))
    write_glb(path, mesh(knot_rows(*KNOT, along, around), along, around, center, radius), PAINT)


def write_model(path, number):
    """One of the small models: knots, fluted tori and waving rings in turn, each with its own paint."""
    triangles = FEWEST * (MOST / FEWEST) ** (number / (MODELS - 1))
    around = max(12, round(math.sqrt(triangles / 2.0 / 6.0)))
    along = round(triangles / 2.0 / around)
    kind, turn = number % 3, number // 3
    if kind == 0:
        turns, windings = ((2, 3), (3, 2), (2, 5), (3, 4), (2, 7), (3, 5), (4, 3), (2, 9))[turn]
        rows = lambda a, b: knot_rows(turns, windings, 1.0, 0.4, 0.1 + 0.01 * turn, a, b)
    elif kind == 1:
        rows = lambda a, b: surface_rows(fluted_torus(3 + turn, 0.3, 0.35 + 0.02 * turn), a, b)
    else:
        rows = lambda a, b: surface_rows(folded_ring(2 + turn, 0.25, 0.2 + 0.02 * turn), a, b)
    paint = {
        "color": tuple(round(0.4 + 0.35 * math.sin(number + 2.1 * k), 3) for k in range(3)),
        "metallic": round(0.1 * (number % 6), 3),
        "roughness": round(0.3 + 0.05 * (number % 5), 3),
        "coat": 1.0,
        "coat_roughness": round(0.03 + 0.02 * (number % 4), 3),
    }
    center, radius = fit(rows(60, 24))
    write_glb(path, mesh(rows(along, around), along, around, center, radius), paint)


def sky(u, v):
    """Radiance at fractions of the picture: a sky over a dark ground, and two bright boxes."""
    up = math.cos(math.pi * v)
    if 0.58 < u < 0.70 and 0.15 < v < 0.31 or 0.17 < u < 0.23 and 0.20 < v < 0.50:
        return (9.0, 9.0, 9.0)
    if up < 0.0:
        return (0.16 + 0.06 * up, 0.15 + 0.06 * up, 0.14 + 0.06 * up)
    return (0.45 - 0.20 * up, 0.55 - 0.18 * up, 0.68 - 0.10 * up)


def write_environment(path):
    """Equirectangular Radiance picture. Scanlines are not packed: every reader takes them so."""
    width, height = ENVIRONMENT_SIZE
    with open(path, "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + f"-Y {height} +X {width}\n".encode())
        for y in range(height):
            line = bytearray()
            for x in range(width):
                color = sky((x + 0.5) / width, (y + 0.5) / height)
                exponent = math.frexp(max(color))[1]
                line += bytes(int(math.ldexp(c, 8 - exponent)) for c in color) + bytes((exponent + 128,))
            file.write(line)


def make(folder, knots, models, textured=False, say=print):
    """Writes what is missing; returns the paths of everything asked for."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths = {"environment": folder / "environment.hdr"}
    jobs = [(paths["environment"], write_environment, ())]
    for name in knots:
        paths[name] = folder / f"knot_{name}.glb"
        jobs.append((paths[name], write_knot, KNOTS[name]))
    if textured:
        paths["textured"] = folder / "knot_textured.glb"
        jobs.append((paths["textured"], write_textured_knot, KNOTS["5k"]))
    if models:
        paths["models"] = [folder / f"model_{k:02}.glb" for k in range(MODELS)]
        jobs += [(path, write_model, (k,)) for k, path in enumerate(paths["models"])]
    for path, write, arguments in jobs:
        if not path.exists():
            say(f"making {path}")
            # Renamed when whole, so that a broken-off run leaves no half file that the next one takes.
            unfinished = path.with_suffix(".part")
            write(unfinished, *arguments)
            unfinished.replace(path)
    return paths


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="where the files are written; those that exist are kept")
    make(parser.parse_args().folder, KNOTS, models=True, textured=True)

"""Shared parts of the runners: scenes of a conformance pack in, pictures with variance out.

Needs numpy, which Blender's and Mitsuba's packages bring along.
"""

import argparse
import json
import os
import struct
import sys

import numpy as np

# Radius of the square over which the variance of a few passes is averaged, in pixels.
SMOOTHING = 2


def arguments(description, samples, passes):
    """The command line that all runners have, and the pack's scenes that it asks for."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("pack", metavar="PACK", help="folder that `overcoat conformance PACK` has made")
    parser.add_argument("pictures", metavar="PICTURES", help="folder for NAME.exr of each scene; made if there is none")
    parser.add_argument("--scenes", metavar="LIST", default="", help="only these, comma-separated [default: all]")
    parser.add_argument("--samples", metavar="N", type=int, default=samples, help=f"per pixel and pass [default: {samples}]")
    parser.add_argument("--passes", metavar="N", type=int, default=passes, help=f"of different seeds [default: {passes}]")
    return parser


def scenes(args):
    """Size of the pack's pictures, and the descriptions of the scenes."""
    folder = os.path.join(args.pack, "scenes")
    try:
        with open(os.path.join(args.pack, "VERSION"), encoding="utf-8") as file:
            size = next(int(line.split()[1]) for line in file if line.startswith("size "))
        with open(os.path.join(args.pack, "scenes.tsv"), encoding="utf-8") as file:
            names = [line.split("\t")[0] for line in file.read().splitlines()[1:]]
    except (OSError, StopIteration):
        sys.exit(f"{args.pack}: no conformance pack; expected VERSION and scenes.tsv in it")
    if args.samples < 1 or args.passes < 2:
        sys.exit("--samples is 1 or more, --passes 2 or more: one has no variance")
    asked = [name for name in args.scenes.split(",") if name]
    for name in asked:
        if name not in names:
            sys.exit(f"no scene {name}; there are {', '.join(names)}")
    found = []
    for name in asked or names:
        with open(os.path.join(folder, f"{name}.json"), encoding="utf-8") as file:
            found.append(json.load(file))
    os.makedirs(args.pictures, exist_ok=True)
    return size, found


def environment(args, light):
    """Path of the map of a scene's light."""
    return os.path.abspath(os.path.join(args.pack, "scenes", light["file"]))


def combined(passes):
    """Mean of independent pictures, and its variance per pixel: that of the passes, smoothed, since there are few of them."""
    stack = np.asarray(passes, dtype=np.float64)
    variance = stack.var(axis=0, ddof=1) / len(stack)
    height, width, _ = variance.shape
    padded = np.pad(variance, ((SMOOTHING, SMOOTHING), (SMOOTHING, SMOOTHING), (0, 0)), mode="edge")
    steps = range(2 * SMOOTHING + 1)
    smooth = sum(padded[y : y + height, x : x + width] for y in steps for x in steps) / len(steps) ** 2
    return stack.mean(axis=0), smooth


def write(args, name, mean, variance):
    """PICTURES/NAME.exr with R, G, B and variance.R, .G, .B."""
    planes = {c: mean[..., k] for k, c in enumerate("RGB")}
    planes.update({f"variance.{c}": variance[..., k] for k, c in enumerate("RGB")})
    path = os.path.join(args.pictures, f"{name}.exr")
    with open(path, "wb") as file:
        file.write(exr(planes))
    middle = mean[mean.shape[0] // 2, mean.shape[1] // 2]
    print(f"{path}: middle {middle[0]:.4f} {middle[1]:.4f} {middle[2]:.4f}", flush=True)


def exr(planes):
    """An OpenEXR file of 32-bit floats, scan lines without compression (OpenEXR File Layout, openexr.com)."""
    names = sorted(planes)
    height, width = planes[names[0]].shape

    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<I", len(value)) + value

    channels = b"".join(name.encode() + b"\0" + struct.pack("<IIII", 2, 0, 1, 1) for name in names) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<II", 20000630, 2)
    header += attribute("channels", "chlist", channels) + attribute("compression", "compression", b"\0")
    header += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    header += attribute("lineOrder", "lineOrder", b"\0") + attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    row = 4 * width * len(names)
    start = len(header) + 8 * height
    table = b"".join(struct.pack("<Q", start + y * (row + 8)) for y in range(height))
    lines = []
    for y in range(height):
        values = b"".join(np.ascontiguousarray(planes[name][y], dtype="<f4").tobytes() for name in names)
        lines.append(struct.pack("<iI", y, row) + values)
    return header + table + b"".join(lines)

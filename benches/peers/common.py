"""What the peers share: arguments, camera, measuring, the report, and a PNG writer.

A peer is a script `peer_NAME.py` that draws with one renderer and prints one JSON object. The modes:

  probe    version, or a reason on standard error and exit code 1 if the renderer is not installed
  picture  one picture to --picture, then exit (what the whole process takes is the cold figure)
  file     the same of any file, as the renderer shows it by itself (F3D)
  warm     --frames pictures of an orbit after --warm-up ones, each read back; processor time a frame
  models   every --model loaded, drawn and read back, twice; processor time a model of the second time
"""

import argparse
import json
import math
import resource
import struct
import sys
import time
import zlib

# The camera of every renderer: looks at the origin from DIRECTION, metres and degrees.
DIRECTION = (0.5, 0.4, 1.0)
DISTANCE = 3.86
FIELD_OF_VIEW = 30.0
NEAR, FAR = DISTANCE - 1.2, DISTANCE + 1.2
BACKGROUND = (0.8, 0.8, 0.8)
# As in inputs.py: towards the light, not normalized.
LIGHT = (0.4, 0.8, 0.45)


def arguments(description, argv=None):
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mode", choices=("probe", "picture", "file", "warm", "models"))
    parser.add_argument("--model", nargs="+", default=[], metavar="GLB")
    parser.add_argument("--environment", metavar="HDR", help="equirectangular picture that lights the scene")
    parser.add_argument("--size", default="512x512", metavar="WxH")
    parser.add_argument("--samples", type=int, default=1, metavar="N", help="multisampling; 1 is none")
    parser.add_argument("--frames", type=int, default=12, metavar="N")
    parser.add_argument("--warm-up", type=int, default=2, metavar="N")
    parser.add_argument("--picture", metavar="PNG")
    args = parser.parse_args(argv)
    args.width, args.height = (int(side) for side in args.size.split("x"))
    if args.mode != "probe" and not args.model:
        parser.error(f"{args.mode} needs --model")
    return args


def eye(frame=0, frames=1):
    """Where the camera is in a frame of the orbit about the vertical axis; the same turn as `overcoat bench`."""
    angle = math.tau * frame / frames
    cos, sin = math.cos(angle), math.sin(angle)
    scale = DISTANCE / math.sqrt(sum(d * d for d in DIRECTION))
    x, y, z = (d * scale for d in DIRECTION)
    return (cos * x + sin * z, y, cos * z - sin * x)


def paint(path):
    """The first material of a GLB, from its JSON alone."""
    with open(path, "rb") as file:
        length = struct.unpack("<12xI4x", file.read(20))[0]
        document = json.loads(file.read(length))
    return document["materials"][0]


def peak_memory():
    """Peak resident set of this process, MiB. (ru_maxrss would count the parent before exec.)"""
    try:
        with open("/proc/self/status") as file:
            for line in file:
                if line.startswith("VmHWM:"):
                    return int(line.split()[1]) / 1024.0
    except OSError:
        pass
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def run(args, peer, version, startup, picture, frame, model):
    """Does what the mode asks and prints the report.

    `startup` is the processor time at which the renderer itself began; `picture(path)` draws the first model into a
    PNG; `frame(k, n)` draws and reads back one frame of the orbit of the first model; `model(path)` loads, draws and
    reads back any model.
    """
    report = {"peer": peer, "version": version, "startup_cpu_s": startup}
    if args.mode == "picture":
        picture(args.picture)
    elif args.mode == "warm":
        for k in range(args.warm_up):
            frame(k, args.frames)
        report.update(timed([lambda k=k: frame(k, args.frames) for k in range(args.frames)]))
    else:
        for _ in range(2):
            # The second time counts.
            report.update(timed([lambda path=path: model(path) for path in args.model]))
    finish(report)


def finish(report):
    usage = resource.getrusage(resource.RUSAGE_SELF)
    report.setdefault("cpu_s", usage.ru_utime + usage.ru_stime)
    report.setdefault("peak_mib", round(peak_memory(), 1))
    print(json.dumps(report))


def timed(steps):
    """Runs every step; processor time (all threads of this process) and wall time of one, in milliseconds."""
    cpu, wall = time.process_time(), time.perf_counter()
    for step in steps:
        step()
    return {
        "frames": len(steps),
        "frame_cpu_ms": 1e3 * (time.process_time() - cpu) / len(steps),
        "frame_wall_ms": 1e3 * (time.perf_counter() - wall) / len(steps),
    }


def missing(reason):
    """Ends a probe: the renderer cannot run here."""
    print(reason, file=sys.stderr)
    sys.exit(1)


def png(width, height, channels, rows):
    """A PNG file of rows of 8-bit RGB (3 channels) or RGBA (4), packed quickly (zlib level 1, no filters)."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    data = zlib.compress(b"".join(b"\0" + row for row in rows), 1)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def write_png(path, width, height, rgba_bottom_up):
    """8-bit RGBA from the rows of OpenGL."""
    stride = 4 * width
    rows = (rgba_bottom_up[y * stride : (y + 1) * stride] for y in reversed(range(height)))
    with open(path, "wb") as file:
        file.write(png(width, height, 4, rows))

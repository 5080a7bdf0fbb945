#!/usr/bin/env python3
"""Cold pictures of real files: processor time and peak memory of whole processes, beside F3D's and an earlier overcoat's.

Every program starts, loads one file and writes one PNG, as a thumbnailer does. Each round runs all of them on every file, one
after the other; ratios are medians of the ratios within a round, and means over files are geometric.

  python3 benches/peers/files.py models/*.glb --sizes 256,1024 --rounds 5
  python3 benches/peers/files.py models/*.glb --before ../earlier/overcoat --only overcoat,before
  python3 benches/peers/files.py --texture-sizes 256,512,1024,2048,4096,8192 --rounds 3

The last draws one square with a texture of each size and writes a plot. F3D is taken from the Python of --python; the time in
which that starts, before F3D's own libraries are loaded, is not counted. F3D draws no coat, and none of its environment.
"""

import argparse
import json
import math
import shutil
import struct
import sys
from pathlib import Path
from statistics import median

import common
import pictures
from compare import HERE, ROOT, RunFailed, last_json, machine, run

PROGRAMS = ("overcoat", "before", "f3d")


def command_line():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, prog="files.py"
    )
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE", help="models")
    parser.add_argument("--sizes", default="256", metavar="N,...", help="sides of the pictures [default: 256]")
    parser.add_argument("--rounds", type=int, default=5, metavar="N", help="rounds that count [default: 5]")
    parser.add_argument("--only", metavar="NAME,...", help=f"of {', '.join(PROGRAMS)} [default: all that are there]")
    parser.add_argument("--overcoat", metavar="PATH", help="the program [default: target/release/overcoat, or on PATH]")
    parser.add_argument("--before", metavar="PATH", help="an earlier one")
    parser.add_argument("--options", default="", metavar="TEXT", help="of both, separated by spaces")
    parser.add_argument("--python", default=sys.executable, metavar="PATH", help="Python that has f3d")
    parser.add_argument("--texture-sizes", metavar="N,...", help="draw a square with textures of these sizes instead")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="[default: target/peers/files]")
    args = parser.parse_args()
    args.out = args.out or ROOT / "target" / "peers" / "files"
    args.sizes = [int(size) for size in args.sizes.split(",")]
    args.texture_sizes = [int(size) for size in (args.texture_sizes or "").split(",") if size]
    built = ROOT / "target" / "release" / "overcoat"
    args.overcoat = args.overcoat or (str(built) if built.exists() else shutil.which("overcoat"))
    if not args.overcoat:
        parser.error("no overcoat found: cargo build --release, or give --overcoat PATH")
    if not args.files and not args.texture_sizes:
        parser.error("name some files, or --texture-sizes")
    return args


def programs(args):
    """Name of each that is there, and what makes its command for a file, a size and a picture."""
    ours = lambda path: lambda file, size, out: (
        [path, "render", str(file), "-o", str(out), "--size", str(size), "--quiet", *args.options.split()]
    )
    peer = [args.python, str(HERE / "peer_f3d.py")]
    found = {"overcoat": ours(args.overcoat)}
    if args.before:
        found["before"] = ours(args.before)
    try:
        last_json(run([*peer, "probe"])[2])
        found["f3d"] = lambda file, size, out: (
            [*peer, "file", "--model", str(file), "--size", f"{size}x{size}", "--picture", str(out)]
        )
    except RunFailed as failure:
        print(f"f3d: left out: {failure}")
    wanted = args.only.split(",") if args.only else PROGRAMS
    return {name: command for name, command in found.items() if name in wanted}


def one(name, command, out):
    """Processor seconds and MiB of a run; None if it draws nothing."""
    out.unlink(missing_ok=True)
    try:
        cpu, _, output = run(command)
        if pictures.covered(out) == 0.0:
            return None
        if name == "f3d":
            report = last_json(output)
            return cpu - report["startup_cpu_s"], report["peak_mib"]
        # Its report costs time (a hash), so memory is asked for in a run that is not timed.
        return cpu, last_json(run([*command, "--json"])[2])["peak_rss_bytes"] / 2**20
    except (RunFailed, OSError, ValueError):
        return None


def measure(args, files, sizes):
    """For each size, file and program a list of runs."""
    found = programs(args)
    runs = {}
    for number in range(args.rounds):
        for size in sizes:
            for file in files:
                for name, command in found.items():
                    key = (size, str(file), name)
                    if runs.get(key, [0])[-1] is None:
                        continue
                    out = args.out / f"{name}.png"
                    runs.setdefault(key, []).append(one(name, command(file, size, out), out))
                print(f"round {number + 1}/{args.rounds}  {size}  {file.name}", flush=True)
    return list(found), runs


def ratio(runs, other, k):
    return median(b[k] / a[k] for a, b in zip(runs, other))


def mean(values):
    return math.exp(sum(map(math.log, values)) / len(values)) if values else float("nan")


def table(names, files, size, runs):
    others = [name for name in names if name != "overcoat"]
    lines = [f"\n{size} x {size}", ""]
    lines.append("| file | overcoat | " + " | ".join(f"{name} | × | memory ×" for name in others) + " |")
    lines.append("| --- | ---: |" + " ---: | ---: | ---: |" * len(others))
    means = {name: ([], []) for name in others}
    for file in files:
        ours = runs.get((size, str(file), "overcoat"), [None])
        if None in ours:
            lines.append(f"| {file.name} | draws nothing |" + " | | |" * len(others))
            continue
        line = f"| {file.name} | {told(ours)} |"
        for name in others:
            theirs = runs.get((size, str(file), name), [None])
            if None in theirs:
                line += " draws nothing | | |"
                continue
            cpu, memory = ratio(ours, theirs, 0), ratio(ours, theirs, 1)
            means[name][0].append(cpu)
            means[name][1].append(memory)
            line += f" {told(theirs)} | {cpu:.2f} | {memory:.2f} |"
        lines.append(line)
    lines.append(
        "| geometric mean | |"
        + "".join(f" of {len(a)} files | {mean(a):.2f} | {mean(b):.2f} |" for a, b in means.values())
    )
    return "\n".join(lines)


def told(runs):
    return f"{median(r[0] for r in runs):.3f} s, {median(r[1] for r in runs):.0f} MiB"


# Textures of growing size


def square(path, side):
    """A GLB with a square that shows a noisy texture of that size, as PNG."""
    rows, state = [], 1
    tile = bytearray()
    for _ in range(3 * 251):
        state = (state * 1103515245 + 12345) & 0x7FFFFFFF
        tile.append(96 + (state >> 16) % 64)
    for y in range(side):
        shift = 3 * (y * 7 % 251)
        row = bytes(tile[shift:] + tile[:shift])
        rows.append((row * (side // 251 + 1))[: 3 * side])
    image = common.png(side, side, 3, rows)
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    positions = b"".join(struct.pack("<3f", x, y, 0) for x, y in corners)
    coordinates = b"".join(struct.pack("<2f", (x + 1) / 2, (1 - y) / 2) for x, y in corners)
    parts = [positions, coordinates, struct.pack("<6H", 0, 1, 2, 0, 2, 3), image]
    views, binary = [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(part)})
        binary += part + bytes(-len(part) % 4)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 3, "mimeType": "image/png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": views,
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def plot(path, title, unit, sizes, lines):
    """An SVG of some lines over the texture's side, both axes logarithmic."""
    width, height, left, top, right, bottom = 640, 400, 70, 40, 150, 50
    values = [v for line in lines.values() for v in line if v]
    low = 10 ** math.floor(math.log10(min(values)))
    high = 10 ** math.ceil(math.log10(max(values)))
    x = lambda size: left + (width - left - right) * math.log(size / sizes[0]) / math.log(sizes[-1] / sizes[0])
    y = lambda v: top + (height - top - bottom) * (1 - math.log(v / low) / math.log(high / low))
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="13">',
        f'<rect width="{width}" height="{height}" fill="#fff"/><text x="{left}" y="22" font-size="15">{title}</text>',
    ]
    tick = low
    while tick <= high * 1.001:
        for step in (1, 2, 5):
            v = tick * step
            if low <= v <= high * 1.001:
                out.append(f'<path d="M{left} {y(v):.1f}H{width - right}" stroke="#ddd"/>')
                out.append(f'<text x="{left - 8}" y="{y(v) + 4:.1f}" text-anchor="end">{v:g} {unit}</text>')
        tick *= 10
    for size in sizes:
        out.append(f'<path d="M{x(size):.1f} {top}V{height - bottom}" stroke="#ddd"/>')
        out.append(f'<text x="{x(size):.1f}" y="{height - bottom + 20}" text-anchor="middle">{size}</text>')
    out.append(f'<text x="{(left + width - right) / 2}" y="{height - 10}" text-anchor="middle">texels along a side</text>')
    colors = ("#0060c0", "#c04000", "#408000")
    for (name, line), color in zip(lines.items(), colors):
        points = [(x(size), y(v)) for size, v in zip(sizes, line) if v]
        path_of = "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in points)
        out.append(f'<path d="{path_of}" fill="none" stroke="{color}" stroke-width="2"/>')
        out += [f'<circle cx="{a:.1f}" cy="{b:.1f}" r="3" fill="{color}"/>' for a, b in points]
        out.append(f'<text x="{points[-1][0] + 8:.1f}" y="{points[-1][1] + 4:.1f}" fill="{color}">{name}</text>')
    path.write_text("\n".join(out) + "\n</svg>\n")


def texture_sizes(args):
    files = []
    for side in args.texture_sizes:
        files.append(args.out / f"square-{side}.glb")
        square(files[-1], side)
    names, runs = measure(args, files, args.sizes[:1])
    middle = lambda name, k: [
        None if None in r else median(entry[k] for entry in r)
        for r in (runs[(args.sizes[0], str(file), name)] for file in files)
    ]
    title = f"{args.sizes[0]} x {args.sizes[0]} pixels of a square"
    plot(args.out / "time.svg", f"{title}: processor time", "s", args.texture_sizes, {n: middle(n, 0) for n in names})
    plot(args.out / "memory.svg", f"{title}: memory", "MiB", args.texture_sizes, {n: middle(n, 1) for n in names})
    return table(names, files, args.sizes[0], runs)


def main():
    args = command_line()
    args.out.mkdir(parents=True, exist_ok=True)
    before = machine([0])
    if args.texture_sizes:
        text = texture_sizes(args)
    else:
        names, runs = measure(args, args.files, args.sizes)
        text = "\n".join(table(names, args.files, size, runs) for size in args.sizes)
    text = f"{before['cpu']}, {before['cores']} cores; {args.rounds} rounds\n{text}\n"
    (args.out / "table.md").write_text(text)
    print(f"\n{text}\nwritten: {args.out}")


if __name__ == "__main__":
    main()

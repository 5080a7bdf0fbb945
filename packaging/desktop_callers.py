#!/usr/bin/env python3
"""Asks the thumbnailers of desktops for pictures of models. Called by packaging/desktop_test.sh, in a session of its own.

Usage: packaging/desktop_callers.py ROOT PICTURES
"""

import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

import gi

gi.require_version("GnomeDesktop", "4.0")
from gi.repository import Gio, GLib, GnomeDesktop  # noqa: E402

CORNERS = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)]
SIDES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (2, 3, 7, 6), (1, 2, 6, 5), (0, 4, 7, 3)]


def triangles():
    return [t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))]


def write_models(folder, root):
    """One model of each kind, and some that lack a part or are none."""
    shutil.copy(root / "assets/models/sports-car.glb", folder / "car.glb")
    facets = [struct.pack("<12fH", 0, 0, 0, *(v for k in t for v in CORNERS[k]), 0) for t in triangles()]
    (folder / "box.stl").write_bytes(bytes(80) + struct.pack("<I", len(facets)) + b"".join(facets))
    ply = ["ply", "format ascii 1.0", "element vertex 8", "property float x", "property float y", "property float z",
           f"element face {len(triangles())}", "property list uchar int vertex_indices", "end_header"]
    ply += ["%d %d %d" % v for v in CORNERS] + ["3 %d %d %d" % t for t in triangles()]
    (folder / "box.ply").write_text("\n".join(ply) + "\n")
    obj = ["mtllib box.mtl"] + ["v %d %d %d" % v for v in CORNERS] + ["usemtl red"]
    obj += ["f %d %d %d" % tuple(k + 1 for k in t) for t in triangles()]
    # The library is there; GNOME shows its thumbnailers the model alone.
    (folder / "box.obj").write_text("\n".join(obj) + "\n")
    (folder / "box.mtl").write_text("newmtl red\nKd 0.8 0.02 0.02\n")
    (folder / "lonely.obj").write_text("\n".join(obj).replace("box.mtl", "gone.mtl") + "\n")
    points = b"".join(struct.pack("<3f", *v) for v in CORNERS)
    indices = b"".join(struct.pack("<3H", *t) for t in triangles())
    gltf = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3",
                       "min": [-1, -1, -1], "max": [1, 1, 1]},
                      {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(points)},
                        {"buffer": 0, "byteOffset": len(points), "byteLength": len(indices)}],
    }
    data = points + indices
    for name, uri in [("box.gltf", "box.bin"), ("lonely.gltf", "gone.bin")]:
        (folder / name).write_text(json.dumps({**gltf, "buffers": [{"byteLength": len(data), "uri": uri}]}))
    (folder / "box.bin").write_bytes(data)
    (folder / "broken.stl").write_bytes(b"solid nothing\n")
    # A name that has to be quoted.
    shutil.copy(folder / "box.stl", folder / "50% größer #1.stl")


def size_of_png(data):
    assert data[:8] == b"\x89PNG\r\n\x1a\n", "no PNG"
    return struct.unpack(">II", data[16:24])


def mime_type(path):
    return Gio.File.new_for_path(str(path)).query_info("standard::content-type", 0, None).get_content_type()


def colour_of(path):
    """Mean red and green of the covered pixels, 0 to 255."""
    gi.require_version("GdkPixbuf", "2.0")
    from gi.repository import GdkPixbuf

    pixels = GdkPixbuf.Pixbuf.new_from_file(str(path))
    data, channels = pixels.get_pixels(), pixels.get_n_channels()
    stride, width = pixels.get_rowstride(), pixels.get_width()
    covered = []
    for row in range(pixels.get_height()):
        for column in range(width):
            at = row * stride + column * channels
            if channels == 3 or data[at + 3] == 255:
                covered.append((data[at], data[at + 1]))
    assert covered, f"{path} shows nothing"
    assert channels == 3 or data[3] == 0, f"the corner of {path} is not transparent"
    return [sum(c[k] for c in covered) / len(covered) for k in (0, 1)]


class Gnome:
    """GnomeDesktop's factory: one file alone is shown to the thumbnailer, in bubblewrap."""

    name = "gnome"
    folder_is_seen = False

    def __init__(self):
        size = GnomeDesktop.DesktopThumbnailSize.LARGE
        self.factory = GnomeDesktop.DesktopThumbnailFactory.new(size)

    def make(self, path, out):
        uri, kind = path.as_uri(), mime_type(path)
        if not self.factory.can_thumbnail(uri, kind, int(path.stat().st_mtime)):
            return f"no thumbnailer for {kind}"
        try:
            picture = self.factory.generate_thumbnail(uri, kind, None)
        except GLib.Error as error:
            return error.message
        picture.savev(str(out), "png", [], [])
        return None


class Tumbler:
    """tumblerd over D-Bus, as Thunar asks it."""

    name = "tumbler"
    folder_is_seen = True

    def __init__(self):
        self.bus = Gio.bus_get_sync(Gio.BusType.SESSION, None)
        self.service = "org.freedesktop.thumbnails.Thumbnailer1"
        self.path = "/org/freedesktop/thumbnails/Thumbnailer1"

    def make(self, path, out):
        uri, loop, told = path.as_uri(), GLib.MainLoop(), []

        def heard(_bus, _sender, _path, _interface, signal, values):
            if signal == "Error":
                told.append(values.unpack()[3])
            if signal == "Finished":
                loop.quit()

        watch = self.bus.signal_subscribe(None, self.service, None, self.path, None, 0, heard)
        arguments = GLib.Variant("(asasssu)", ([uri], [mime_type(path)], "large", "default", 0))
        self.bus.call_sync(self.service, self.path, self.service, "Queue", arguments, None, 0, 30000, None)
        GLib.timeout_add_seconds(60, lambda: (told.append("no answer in a minute"), loop.quit()))
        loop.run()
        self.bus.signal_unsubscribe(watch)
        name = GLib.compute_checksum_for_string(GLib.ChecksumType.MD5, uri, -1)
        made = pathlib.Path(os.environ["XDG_CACHE_HOME"]) / "thumbnails/large" / f"{name}.png"
        if not made.exists():
            return told[0] if told else "nothing was made"
        shutil.copy(made, out)
        return None


def check_mime_types(folder):
    """What the system's database and the package's file say of names and contents."""
    kinds = {"car.glb": "gltf-binary", "box.gltf": "gltf+json", "box.obj": "obj", "box.stl": "stl", "box.ply": "ply"}
    for name, kind in kinds.items():
        assert mime_type(folder / name) == f"model/{kind}", f"{name} is {mime_type(folder / name)}"
    # By content alone.
    nameless = folder / "nameless"
    shutil.copy(folder / "box.ply", nameless)
    assert mime_type(nameless) == "model/ply", mime_type(nameless)
    other = "application/vnd.ms-package.3dmanufacturing-3dmodel+xml"
    assert Gio.content_type_equals(other, "model/3mf") or Gio.content_type_is_a(other, "model/3mf")


def check(caller, folder, pictures):
    """Models that every caller has a picture of, and what becomes of those that lack a part."""
    whole = ["car.glb", "box.stl", "box.ply", "box.obj", "lonely.obj", "50% größer #1.stl"]
    refused = ["lonely.gltf", "broken.stl"]
    (whole if caller.folder_is_seen else refused).append("box.gltf")
    for name in whole + refused:
        out = pictures / f"{caller.name}-{name}.png"
        error = caller.make(folder / name, out)
        print(f"{caller.name}: {name} ({mime_type(folder / name)}): {error or 'a picture'}")
        assert (error is None) == (name in whole), f"{caller.name}: {name}: {error}"
        assert out.exists() == (name in whole)
        if name in whole:
            assert size_of_png(out.read_bytes()) == (256, 256), name
    red, green = colour_of(pictures / f"{caller.name}-box.obj.png")
    # Red by its library; else of clay, and not black, white or missing.
    is_red = red > 2 * green
    assert is_red == caller.folder_is_seen, f"{caller.name}: box.obj is {red:.0f}, {green:.0f}"
    red, green = colour_of(pictures / f"{caller.name}-lonely.obj.png")
    assert green < red < 1.5 * green, f"{caller.name}: lonely.obj is {red:.0f}, {green:.0f}"


def check_without_walls(folder):
    """Where an outer filter forbids both walls the picture is made all the same, with a warning for each; --sandbox fails."""
    load, equal, give = 0x20, 0x15, 0x06
    eperm, allow = 0x00050001, 0x7FFF0000
    calls = {"x86_64": (444, 317, 157), "aarch64": (444, 277, 167)}[os.uname().machine]
    landlock, seccomp, prctl = calls
    code = [
        (load, 0, 0, 0),
        (equal, 4, 0, landlock),
        (equal, 3, 0, seccomp),
        (equal, 0, 3, prctl),
        (load, 0, 0, 16),
        # PR_SET_SECCOMP
        (equal, 0, 1, 22),
        (give, 0, 0, eperm),
        (give, 0, 0, allow),
    ]
    with tempfile.TemporaryFile() as program:
        program.write(b"".join(struct.pack("<HBBI", *line) for line in code))
        for option, expected in [([], 0), (["--no-sandbox"], 0), (["--sandbox"], 1)]:
            program.seek(0)
            out = folder / "without.png"
            command = ["bwrap", "--bind", "/", "/", "--dev", "/dev", "--proc", "/proc", "--seccomp", str(program.fileno()),
                       "overcoat", "thumbnail", *option, "box.stl", str(out)]
            done = subprocess.run(command, cwd=folder, pass_fds=[program.fileno()], stderr=subprocess.PIPE, text=True)
            print(f"both walls forbidden, {option}: {done.returncode} {done.stderr.strip()}")
            assert done.returncode == expected, done.stderr
            assert out.exists() == (expected == 0)
            assert done.stderr.count("warning: ") == (0 if option else 2), done.stderr
            out.unlink(missing_ok=True)


def main():
    root, pictures = map(pathlib.Path, sys.argv[1:])
    folder = pathlib.Path(os.environ["HOME"]) / "models"
    folder.mkdir()
    write_models(folder, root)
    check_mime_types(folder)
    for caller in [Gnome(), Tumbler()]:
        check(caller, folder, pictures)
    check_without_walls(folder)
    print("desktop: all is well")


main()

#!/usr/bin/env python3
"""Frames of F3D on Mesa's llvmpipe, with the camera around one model: what `cargo bench -p overcoat-benches --bench viewport` measures of overcoat.

    LP_NUM_THREADS=2 python3 benches/peers/turn_f3d.py assets/models/sports-car.glb [FRAMES]

Frames of 1280 x 720 without anti-aliasing, by F3D's own lights, each read back, after ten that are not counted.
"""

import os
import sys
import time

os.environ.setdefault("LIBGL_ALWAYS_SOFTWARE", "1")

import common
import peer_f3d


def at(values, part):
    return sorted(values)[min(len(values) * part // 100, len(values) - 1)]


def main():
    model, frames = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 120
    peer_f3d.f3d.Log.set_verbose_level(peer_f3d.f3d.Log.VerboseLevel.QUIET)
    program = peer_f3d.engine()
    program.options.update({
        "render.background.color": list(common.BACKGROUND),
        "render.grid.enable": False,
        "ui.axis": False,
        "ui.loader_progress": False,
        "scene.animation.autoplay": False,
    })
    program.window.size = (1280, 720)
    program.scene.add(model)
    program.window.render()
    walls, times = [], []
    for frame in range(10 + frames):
        program.window.camera.azimuth(360.0 / frames)
        wall, cpu = time.perf_counter(), time.process_time()
        image = program.window.render_to_image()
        if frame >= 10:
            walls.append(1e3 * (time.perf_counter() - wall))
            times.append(1e3 * (time.process_time() - cpu))
    if len(sys.argv) > 3:
        image.save(sys.argv[3])
    print(
        f"F3D {peer_f3d.f3d.Engine.get_lib_info().version}: wall {at(walls, 50):.1f} ms (95 %: {at(walls, 95):.1f} ms),"
        f" processor {at(times, 50):.1f} ms (95 %: {at(times, 95):.1f} ms)"
    )


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""F3D through its Python wheel, on Mesa's llvmpipe.

F3D does not draw the coat of a glTF file: the base layer alone is lit, by the environment or else by the file's light.
Anti-aliasing is left off, as F3D has it by default (--samples above 1 turns its supersampling on).
"""

import os
import sys
import time

os.environ.setdefault("LIBGL_ALWAYS_SOFTWARE", "1")

import common

STARTUP = time.process_time()

try:
    import f3d
except ImportError as error:
    common.missing(f"{error} (pip install f3d)")


def engine():
    """With EGL, or with OSMesa where that is all there is."""
    f3d.Engine.autoload_plugins()
    reasons = []
    for create in (f3d.Engine.create_egl, f3d.Engine.create_osmesa):
        try:
            return create()
        except Exception as error:
            reasons.append(str(error))
    common.missing(f"F3D has no OpenGL: {'; '.join(reasons)} (apt install libegl1 libgl1-mesa-dri)")


def main():
    args = common.arguments(__doc__)
    # F3D tells what it does on standard output, where the report belongs.
    f3d.Log.set_verbose_level(f3d.Log.VerboseLevel.QUIET)
    program = engine()
    version = f"F3D {f3d.Engine.get_lib_info().version}"
    if args.mode == "probe":
        common.finish({"peer": "f3d", "version": version})
        return
    options = program.options
    options.update(
        {
            "render.background.color": list(common.BACKGROUND),
            "render.grid.enable": False,
            "ui.axis": False,
            "ui.loader_progress": False,
            "scene.animation.autoplay": False,
        }
    )
    if args.environment:
        options["render.hdri.file"] = os.path.abspath(args.environment)
        options["render.hdri.ambient"] = True
    if args.samples > 1:
        options["render.effect.antialiasing.enable"] = True
        options["render.effect.antialiasing.mode"] = "ssaa"
    program.window.size = (args.width, args.height)
    camera = program.window.camera
    if args.mode == "file":
        program.scene.add(args.model[0])
        program.window.render_to_image().save(args.picture)
        common.finish({"peer": "f3d", "version": version, "startup_cpu_s": STARTUP})
        return

    def shot(k, n):
        camera.position = common.eye(k, n)
        camera.focal_point = (0.0, 0.0, 0.0)
        camera.view_up = (0.0, 1.0, 0.0)
        camera.view_angle = common.FIELD_OF_VIEW
        return program.window.render_to_image()

    def model(path):
        program.scene.clear()
        program.scene.add(path)
        return shot(0, 1)

    if args.mode != "models":
        program.scene.add(args.model[0])
    common.run(args, "f3d", version, STARTUP, lambda path: shot(0, 1).save(path), shot, model)


if __name__ == "__main__":
    sys.exit(main())

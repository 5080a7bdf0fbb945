"""`trimesh.Scene.save_image` without a window, a display or a driver.

    from overcoat.compat.trimesh import save_image
    png = save_image(scene, resolution=(640, 480))

or, for programs that call the method, one import instead of `import trimesh`:

    from overcoat.compat import trimesh
    png = scene.save_image(resolution=(640, 480))

Everything else of this module is trimesh's own. As soon as something of it is used, `trimesh.Scene.save_image` draws by overcoat.

The camera is trimesh's: `scene.camera` and `scene.camera_transform`, which trimesh makes up where nobody has set them. The light is
overcoat's studio, which no driver changes, and not OpenGL's; `lights`, `env` and every other option of `overcoat.render` may be
given as keywords.
"""

from __future__ import annotations

import importlib
import warnings
from typing import Any, Optional, Sequence

from .._errors import MissingFeatureWarning
from .._options import descriptions
from .._render import Renderer, shared_renderer
from .._trimesh import CREASE_DEGREES, camera_of, model_of_trimesh

#: What a window has and a picture does not.
_OF_WINDOWS = {"visible", "fullscreen", "resizable", "start_loop", "caption", "window_conf", "profile", "record", "callback_period"}


def save_image(
    scene: Any,
    resolution: Optional[Sequence[int]] = None,
    *,
    smooth: bool = True,
    background: Any = None,
    line_settings: Any = None,
    flags: Any = None,
    renderer: Optional[Renderer] = None,
    **kwargs: Any,
) -> bytes:
    """A PNG of a scene, as `trimesh.Scene.save_image`.

    Args:
        scene: A `trimesh.Scene`, or a geometry.
        resolution: `(width, height)` in pixels; that of `scene.camera` if `None`.
        smooth: Smooth normals for meshes that have none, with edges where faces meet at 40 degrees; flat faces otherwise.
        background: Colour as trimesh takes it: three or four numbers, whole ones up to 255 or fractions; white if `None`. With an
            alpha of 0 the picture is transparent.
        line_settings: `point_size` and `line_width` in pixels.
        flags: Of trimesh's viewer; what is set beside `cull` is named in a warning, and not drawn.
        renderer: Whose threads are used.
        kwargs: Options of `overcoat.render`. What only windows have is read over.
    """
    import numpy as np

    if not hasattr(scene, "camera_transform"):
        scene = scene.scene()
    # Makes up a camera where there is none, and keeps it, as trimesh does.
    camera = scene.camera
    if resolution is None:
        resolution = camera.resolution
    else:
        camera.resolution = resolution
    width, height = (int(side) for side in np.asarray(resolution).tolist())
    options = {name: value for name, value in kwargs.items() if name in descriptions()}
    _warn_of({name for name in kwargs if name not in options and name not in _OF_WINDOWS})
    _warn_of({f"flags['{name}']" for name, value in (flags or {}).items() if value and name != "cull"})
    settings = {"point_size": max(width, height) / 200, "line_width": max(width, height) / 400, **(line_settings or {})}
    for name, value in settings.items():
        options.setdefault(name, min(max(float(value), 0.1), 64.0))
    color = np.ones(4) if background is None else np.asarray(background)
    if color.dtype.kind in "iu":
        color = color / 255
    color = np.concatenate([color.reshape(-1).astype(float), [1.0]])[:4]
    if color[3] > 0:
        options.setdefault("background", "#" + "".join(f"{round(255 * min(max(part, 0), 1)):02x}" for part in color[:3]))
    options.setdefault("ground", "none")
    options.setdefault("camera", camera_of(scene))
    options["size"] = [width, height]
    model, _ = model_of_trimesh(scene, None, CREASE_DEGREES if smooth else 0.0)
    return (renderer or shared_renderer())._render(model, options, 3).png()


def install() -> None:
    """Makes `trimesh.Scene.save_image` draw by overcoat, in this process."""
    real = importlib.import_module("trimesh")
    real.Scene.save_image = save_image


def _warn_of(names: set[str]) -> None:
    for name in sorted(names):
        warnings.warn(f"save_image: '{name}' is not drawn by overcoat", MissingFeatureWarning, stacklevel=3)


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    install()
    return getattr(importlib.import_module("trimesh"), name)

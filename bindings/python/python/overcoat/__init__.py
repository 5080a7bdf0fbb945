"""overcoat renders 3D models to pictures on machines that have only a processor: no GPU, no display, no driver; and gives the same
bytes on every machine.

    import overcoat
    image = overcoat.render("car.glb", size=(640, 480))
    image.save("car.png")        # or .jpg, .webp, .exr, .hdr
    image.array                  # (480, 640, 4) uint8

`help(overcoat.render)` has the arguments, `help(overcoat.Options)` all options.
"""

from __future__ import annotations

from . import golden
from ._arrays import Mesh, Splats
from ._camera import CameraMatrices
from ._errors import (
    Cancelled,
    Error,
    GoldenError,
    HandleError,
    LimitError,
    LoadError,
    MeshError,
    MissingFeatureWarning,
    Mismatch,
    OptionError,
    OutputError,
    OvercoatWarning,
    RenderError,
    UnknownOptionError,
)
from ._option_types import Camera, PictureOptions, ViewOptions
from ._options import Options
from ._overcoat import Environment, Image, Model, Orbit, __version__
from ._render import Movie, Renderer, load, render, turntable
from ._scene import InstanceHandle, LightHandle, MaterialHandle, MeshHandle, ModelHandle, Scene
from ._viewport import Drawn, Hit, Viewport

__all__ = [
    "Camera",
    "CameraMatrices",
    "Cancelled",
    "Drawn",
    "Environment",
    "Error",
    "GoldenError",
    "HandleError",
    "Hit",
    "Image",
    "InstanceHandle",
    "LightHandle",
    "LimitError",
    "LoadError",
    "MaterialHandle",
    "Mesh",
    "MeshError",
    "MeshHandle",
    "Mismatch",
    "MissingFeatureWarning",
    "Model",
    "ModelHandle",
    "Movie",
    "OptionError",
    "Options",
    "Orbit",
    "OutputError",
    "OvercoatWarning",
    "PictureOptions",
    "RenderError",
    "Renderer",
    "Scene",
    "Splats",
    "UnknownOptionError",
    "ViewOptions",
    "Viewport",
    "__version__",
    "golden",
    "load",
    "render",
    "turntable",
]

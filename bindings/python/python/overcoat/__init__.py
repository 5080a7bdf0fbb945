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
from ._arrays import Mesh
from ._errors import (
    Error,
    GoldenError,
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
from ._options import Camera, Options, PictureOptions
from ._overcoat import Environment, Image, Model, __version__
from ._render import Movie, Renderer, load, render, turntable

__all__ = [
    "Camera",
    "Environment",
    "Error",
    "GoldenError",
    "Image",
    "LimitError",
    "LoadError",
    "Mesh",
    "MeshError",
    "Mismatch",
    "MissingFeatureWarning",
    "Model",
    "Movie",
    "OptionError",
    "Options",
    "OutputError",
    "OvercoatWarning",
    "PictureOptions",
    "RenderError",
    "Renderer",
    "UnknownOptionError",
    "__version__",
    "golden",
    "load",
    "render",
    "turntable",
]

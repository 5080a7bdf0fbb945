"""What is measured: every renderer in each of its settings, and the workloads."""

from dataclasses import dataclass

# Pixels and model of each column of warm frames, and how many frames of the orbit are counted.
WARM = {
    "5k": ("512x512", "5k", 10),
    "100k": ("512x512", "100k", 10),
    "1m": ("512x512", "1m", 4),
    "1080p": ("1920x1080", "5k", 4),
}
WARM_TITLES = {
    "5k": "5k triangles",
    "100k": "100k triangles",
    "1m": "1M triangles",
    "1080p": "5k triangles, 1920x1080",
}
# The same knot without and with textures, and how many frames of the orbit are counted.
TEXTURED_MODELS = {"textured-plain": "5k", "textured": "textured"}
TEXTURED_FRAMES = 12
LARGE = ("512x512", "5m", 3)
LARGE_TRIANGLES = 5_000_000
SIZE = "512x512"


@dataclass(frozen=True)
class Setting:
    """One renderer with one set of options: a row of the tables."""

    key: str
    peer: str
    title: str
    # What it draws, for the reader to judge how far two rows can be compared.
    draws: str
    samples: int = 1
    # True: the environment that all share; False: the light of the file alone.
    environment: bool = True
    # Built-in environment of overcoat instead.
    built_in: bool = False
    # Key of the setting of overcoat to which the ratio is told; None for overcoat itself.
    against: str = None
    variables: tuple = ()
    # Most probes of anisotropic filtering, in place of overcoat's default; 1 is trilinear filtering.
    anisotropy: int = None


def overcoat(key, samples, draws, **more):
    title = f"overcoat, {samples} sample{'s' if samples > 1 else ''}"
    return Setting(key, "overcoat", title, draws, samples=samples, **more)


ALL = "light, environment, coat"
SETTINGS = {
    setting.key: setting
    for setting in (
        overcoat("overcoat-8", 8, f"{ALL}; coverage by 8 samples"),
        overcoat("overcoat-8-studio", 8, "light, built-in studio, coat; coverage by 8 samples", built_in=True),
        overcoat("overcoat-4", 4, f"{ALL}; coverage by 4 samples"),
        overcoat("overcoat-1", 1, f"{ALL}; no anti-aliasing"),
        overcoat("overcoat-8-trilinear", 8, f"{ALL}; coverage by 8 samples, trilinear", anisotropy=1),
        overcoat("overcoat-4-trilinear", 4, f"{ALL}; coverage by 4 samples, trilinear", anisotropy=1),
        overcoat("overcoat-1-trilinear", 1, f"{ALL}; no anti-aliasing, trilinear", anisotropy=1),
        overcoat("overcoat-1-light", 1, "light, coat; no anti-aliasing", environment=False),
        Setting("llvmpipe", "llvmpipe", "llvmpipe, own shader", f"{ALL}; no anti-aliasing", against="overcoat-1"),
        Setting(
            "llvmpipe-new",
            "llvmpipe",
            "llvmpipe, own shader, shader cache off",
            f"{ALL}; no anti-aliasing",
            against="overcoat-1",
            variables=(("MESA_SHADER_CACHE_DISABLE", "true"), ("MESA_GLSL_CACHE_DISABLE", "true")),
        ),
        Setting("llvmpipe-4", "llvmpipe", "llvmpipe, own shader", f"{ALL}; MSAA 4", samples=4, against="overcoat-4"),
        Setting(
            "llvmpipe-light",
            "llvmpipe",
            "llvmpipe, own shader",
            "light, coat; no anti-aliasing",
            environment=False,
            against="overcoat-1-light",
        ),
        Setting(
            "f3d-light",
            "f3d",
            "F3D",
            "light, no coat; no anti-aliasing",
            environment=False,
            against="overcoat-1-light",
        ),
        Setting("f3d", "f3d", "F3D", "light, environment, no coat; no anti-aliasing", against="overcoat-1"),
        Setting(
            "vtk-light", "vtk", "VTK", "light, coat; MSAA 4", samples=4, environment=False, against="overcoat-1-light"
        ),
        Setting("vtk", "vtk", "VTK", f"{ALL}; MSAA 4", samples=4, against="overcoat-4"),
        Setting(
            "three", "three", "three.js in Chromium (SwiftShader)", f"{ALL}; MSAA 4", samples=4, against="overcoat-4"
        ),
    )
}

# Each is told against overcoat at 8 samples, as a user starts it.
COLD = (
    "overcoat-8",
    "overcoat-8-studio",
    "llvmpipe",
    "llvmpipe-new",
    "llvmpipe-4",
    "f3d-light",
    "f3d",
    "vtk-light",
    "vtk",
    "three",
)


def cold_against(setting):
    """Who reads no picture of the environment is told against overcoat with its built-in one."""
    return "overcoat-8" if setting.environment else "overcoat-8-studio"


FRAMES = (
    "overcoat-1-light",
    "overcoat-1",
    "overcoat-4",
    "overcoat-8",
    "llvmpipe-light",
    "llvmpipe",
    "llvmpipe-4",
    "f3d",
    "vtk",
    "three",
)
# They would tell nothing new, or take minutes.
LARGE_LEFT_OUT = ("llvmpipe-light", "three", "overcoat-1-light")

TEXTURED = (
    "overcoat-1-trilinear",
    "overcoat-4-trilinear",
    "overcoat-8-trilinear",
    "overcoat-8",
    "llvmpipe",
    "llvmpipe-4",
    "f3d",
    "vtk",
    "three",
)


def textured_against(setting):
    """Peers filter trilinearly, or by a few probes."""
    return f"{setting.against}-trilinear"

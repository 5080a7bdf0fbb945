"""The native half of overcoat. Only `Environment`, `Image` and `Model` are for users, as `overcoat.Image` and so on."""

import os
from typing import Any, Mapping, Optional, Sequence, final

import numpy as np
import numpy.typing as npt

__version__: str

@final
class Environment:
    """Light from afar: (H, W, 3) float32, linear radiance of an equirectangular picture, row 0 at the zenith, contiguous.

    Kept and given to several pictures it is filtered once, where an array is each time.
    """

    def __new__(cls, radiance: npt.NDArray[np.float32]) -> Environment: ...
    @property
    def shape(self) -> tuple[int, int]:
        """(height, width) in pixels."""

@final
class Model:
    """A loaded model, which never changes: drawn many times, read once."""

    @property
    def bounds(self) -> Optional[tuple[list[float], list[float]]]:
        """Corners of the box around it, `((x, y, z), (x, y, z))` in metres in its file's coordinates; `None` if it is empty."""
    @property
    def triangles(self) -> int:
        """Triangles, every instance counted."""
    @property
    def materials(self) -> list[str]:
        """Names of its materials, sorted, for the option `materials`."""
    @property
    def cameras(self) -> list[str]:
        """Names of its cameras, for the option `camera={"camera": name}`."""
    @property
    def warnings(self) -> list[str]:
        """What its file asks for and it does not have."""

@final
class Image:
    """A picture of linear light, and what is made of it when it is asked for. It never changes.

    `numpy.asarray(image)` is `image.array`. A notebook shows it.
    """

    @property
    def width(self) -> int:
        """In pixels."""
    @property
    def height(self) -> int:
        """In pixels."""
    @property
    def array(self) -> npt.NDArray[np.uint8]:
        """(H, W, 4), sRGB with straight, linear alpha, row 0 on top; a view without a copy, not to be written to."""
    @property
    def linear(self) -> npt.NDArray[np.float32]:
        """(H, W, 4), linear light multiplied by alpha, before exposure and tone curve; a view, likewise."""
    @property
    def aov(self) -> dict[str, npt.NDArray[np.float32]]:
        """Planes of the G-buffer that were asked for by `aov=`: (H, W) or (H, W, C) views, likewise."""
    @property
    def hash(self) -> str:
        """XXH3-128 of the linear picture, 32 hexadecimal digits: as `overcoat render --json` prints it."""
    @property
    def exposure(self) -> float:
        """Stops of the 8-bit picture; what was metered for `exposure="auto"`."""
    @property
    def warnings(self) -> list[str]:
        """What the file asks for and the picture does not show, in one sentence each."""
    def png(self) -> bytes:
        """The bytes of a PNG file, 8 bits."""
    def encode(self, format: str, *, quality: int = 90, half: bool = True) -> bytes:
        """The bytes of a file.

        Args:
            format: `png`, `webp`, `jpg`, `exr` or `hdr`; the last two hold linear light, and `exr` the planes of `aov` too.
            quality: Of JPEG, 1 to 100. JPEG has no transparency: white is behind the picture unless it has a background.
            half: Whether `exr` has 16 bits a number, or 32.
        """
    def save(self, path: str | os.PathLike[str], *, quality: int = 90, half: bool = True) -> None:
        """Writes a file whose extension tells the format; whole or not at all. Arguments as of `encode`."""
    def _repr_png_(self) -> bytes: ...
    def __array__(
        self, dtype: Optional[npt.DTypeLike] = None, copy: Optional[bool] = None
    ) -> npt.NDArray[Any]: ...

@final
class Plane:
    @property
    def __array_interface__(self) -> dict[str, Any]: ...

@final
class Renderer:
    def __new__(cls, threads: int, simd: Optional[str], tile_size: Optional[int]) -> Renderer: ...
    def load_path(self, path: str | os.PathLike[str], description: str, given_limits: Mapping[str, int]) -> Model: ...
    def load_bytes(
        self, bytes: bytes, format: Optional[str], description: str, given_limits: Mapping[str, int]
    ) -> Model: ...
    def render(self, model: Model, request: Mapping[str, Any], once: bool) -> Image: ...
    def turntable(self, model: Model, request: Mapping[str, Any], frames: int, turn_model: bool) -> list[Image]: ...
    @property
    def threads(self) -> int: ...

@final
class SceneBuilder:
    def __new__(cls) -> SceneBuilder: ...
    def add_image(self, texels: npt.NDArray[np.uint8]) -> int: ...
    def add_material(self, json: str) -> int: ...
    def add_mesh(
        self,
        positions: npt.NDArray[np.float32],
        indices: npt.NDArray[np.uint32],
        normals: Optional[npt.NDArray[np.float32]] = None,
        uv: Optional[npt.NDArray[np.float32]] = None,
        colors: Optional[npt.NDArray[np.float32]] = None,
        kind: str = "triangles",
        crease_degrees: Optional[float] = None,
        tangents_of: Optional[int] = None,
    ) -> int: ...
    def add_instance(self, mesh: int, material: int, matrix: npt.NDArray[np.float64], object: int) -> None: ...
    def add_light(self, json: str) -> None: ...
    def warn(self, message: str) -> None: ...
    def finish(self, up: Optional[str] = None) -> Model: ...

def aov_names() -> list[tuple[str, int]]: ...
def arithmetic_is_default() -> bool: ...
def check_request(request: Mapping[str, Any]) -> None: ...
def encode_movie(images: Sequence[Image], format: str, per_second: float) -> bytes: ...
def golden_check(
    folder: str | os.PathLike[str],
    name: str,
    actual: Image | npt.NDArray[np.uint8] | bytes,
    failures: str | os.PathLike[str] | None,
    update: bool,
    thresholds_text: str,
) -> None: ...
def golden_compare(
    expected: Image | npt.NDArray[np.uint8] | bytes,
    actual: Image | npt.NDArray[np.uint8] | bytes,
    thresholds_text: str,
) -> dict[str, Any]: ...
def read_description(path: str | os.PathLike[str]) -> str: ...
def run_command(arguments: Sequence[str]) -> int: ...
def scene_schema() -> str: ...
def srgb_table() -> list[float]: ...
def write_file(path: str | os.PathLike[str], bytes: bytes) -> None: ...

"""The native half of overcoat. Only `Environment`, `Image`, `Model` and `Orbit` are for users, as `overcoat.Image` and so on."""

import os
from typing import Any, Mapping, Optional, Sequence, final

import numpy as np
import numpy.typing as npt

from ._camera import CameraMatrices

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
    def aov(self) -> dict[str, npt.NDArray[Any]]:
        """Planes of the G-buffer that were asked for by `aov=`: (H, W) or (H, W, C) views, likewise; float32, of identities uint32."""
    @property
    def ids(self) -> dict[str, dict[int, str]]:
        """Names of what planes of identities show, `{plane: {number: name}}`: empty where the file has none. 0 is nothing."""
    def annotations(self, plane: str = "object-id") -> list[dict[str, Any]]:
        """Boxes and pixels of each instance, object or material, whether it is visible or not: a list of dicts by the numbers of a plane
        of identities that was asked for.

        `id` and `name`; and, by the names of BOP, `bbox_obj` and `bbox_visib` (left, top, width, height in pixels: of the whole
        geometry, also hidden and beyond the picture, and of the pixels that show it; `None` without any), `px_count_all` (pixels of
        the picture that would show it alone, or `None` where too many overlap), `px_count_visib` and `visib_fract`. Everything that overlaps something else is drawn alone for
        it, without light.
        """
    def flow_to(self, other: Image) -> npt.NDArray[np.float32]:
        """Optical flow to another picture of the same size, (H, W, 2) float32: pixels to the right and down from each pixel's centre to where
        the point that it shows is in the other, whether it is seen there or not. The picture has to have the planes `position` and
        `instance-id`, the other any plane; it is of the same model, in the same pose or another one.

        NaN where nothing is, behind the other camera, and where meshes are deformed: by skins and morph targets.
        """
    @property
    def hash(self) -> str:
        """XXH3-128 of the linear picture, 32 hexadecimal digits: as `overcoat render --json` prints it."""
    @property
    def exposure(self) -> float:
        """Stops of the 8-bit picture; what was metered for `exposure="auto"`."""
    @property
    def camera(self) -> CameraMatrices:
        """Matrices of the camera that it was taken with, in the coordinates of the file."""
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
class Orbit:
    """A camera for a mouse: it goes around a point, and +Y stays up. `camera=` of `Viewport.draw`, `Viewport.pick` and
    `render` takes it.

    `Orbit.around(scene, aspect)` makes one; the cameras of a model in a scene, `ModelHandle.cameras`, are such ones too.
    """

    @staticmethod
    def around(scene: Any, aspect: float = 1.0) -> Orbit:
        """Around a `Scene` or a `Model`, which fills a picture of that aspect (width over height), from where it shows most."""
    def turn(self, right_deg: float, up_deg: float = 0.0) -> None:
        """Goes around by angles in degrees: to the right, so that the scene turns to the left, and up. Up and down it stops a
        little before the poles."""
    def pan(self, right: float, up: float) -> None:
        """Moves camera and point along the picture, by parts of its height: to the right and up."""
    def zoom(self, factor: float) -> None:
        """Comes closer by a factor, above 0: 2 is half the distance."""
    @property
    def target(self) -> tuple[float, float, float]:
        """The point that it goes around, `(x, y, z)` in metres. Assigned to, the view moves with it."""
    @target.setter
    def target(self, target: Sequence[float]) -> None: ...
    @property
    def eye(self) -> tuple[float, float, float]:
        """Where it is seen from, `(x, y, z)` in metres."""
    def copy(self) -> Orbit:
        """Another one like it."""

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
class Geometry:
    def __new__(
        cls,
        positions: npt.NDArray[np.float32],
        indices: npt.NDArray[np.uint32],
        normals: Optional[npt.NDArray[np.float32]] = None,
        uv: Optional[npt.NDArray[np.float32]] = None,
        colors: Optional[npt.NDArray[np.float32]] = None,
        kind: str = "triangles",
        crease_degrees: Optional[float] = None,
        tangents_of: Optional[int] = None,
    ) -> Geometry: ...

@final
class Texels:
    def __new__(cls, texels: npt.NDArray[np.uint8]) -> Texels: ...

@final
class SceneBuilder:
    def __new__(cls) -> SceneBuilder: ...
    def add_image(self, texels: Texels) -> int: ...
    def add_material(self, json: str) -> int: ...
    def add_mesh(self, geometry: Geometry) -> int: ...
    def add_splats(
        self,
        positions: npt.NDArray[np.float32],
        scales: npt.NDArray[np.float32],
        rotations: npt.NDArray[np.float32],
        opacities: npt.NDArray[np.float32],
        colors: npt.NDArray[np.float32],
        harmonics: npt.NDArray[np.float32],
        matrix: npt.NDArray[np.float64],
        object: int,
    ) -> None: ...
    def add_instance(self, mesh: int, material: int, matrix: npt.NDArray[np.float64], object: int) -> None: ...
    def name_object(self, object: int, name: str) -> None: ...
    def add_light(self, json: str) -> None: ...
    def warn(self, message: str) -> None: ...
    def finish(self, up: Optional[str] = None) -> Model: ...

@final
class Viewport:
    def __new__(
        cls, renderer: Renderer, request: Mapping[str, Any], work: Optional[int], seconds: Optional[float]
    ) -> Viewport: ...
    def configure(self, request: Mapping[str, Any], work: Optional[int], seconds: Optional[float]) -> None: ...
    def draw(
        self,
        model: Model,
        orbit: Optional[Orbit],
        camera: str,
        out: npt.NDArray[Any],
        format: Optional[str],
        region: Optional[Sequence[int]],
        refine: bool,
    ) -> Optional[tuple[str, int, int, bool, float, int]]: ...
    def pick(
        self, world: World, orbit: Optional[Orbit], camera: str, x: int, y: int
    ) -> Optional[tuple[int, int, list[int], list[float], float, list[float], bool]]: ...
    def cancel(self) -> None: ...

@final
class World:
    def __new__(cls) -> World: ...
    def model(self) -> Model: ...
    def add_model(
        self, renderer: Renderer, model: Model, request: Mapping[str, Any], matrix: npt.NDArray[np.float64]
    ) -> tuple[int, list[str]]: ...
    def add_animated_model(
        self,
        renderer: Renderer,
        path: str | os.PathLike[str] | None,
        bytes: Optional[bytes],
        format: Optional[str],
        description: str,
        given_limits: Mapping[str, int],
        matrix: npt.NDArray[np.float64],
    ) -> tuple[int, list[str]]: ...
    def set_pose(self, model: int, seconds: float) -> list[str]: ...
    def animation_length(self, model: int) -> Optional[float]: ...
    def remove_model(self, model: int) -> None: ...
    def model_transform(self, model: int) -> list[list[float]]: ...
    def set_model_transform(self, model: int, matrix: npt.NDArray[np.float64]) -> None: ...
    def model_visible(self, model: int) -> bool: ...
    def set_model_visible(self, model: int, visible: bool) -> None: ...
    def model_instances(self, model: int) -> list[int]: ...
    def model_materials(self, model: int) -> list[int]: ...
    def model_lights(self, model: int) -> list[int]: ...
    def model_cameras(self, model: int) -> list[tuple[str, Orbit]]: ...
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
    def set_mesh(
        self,
        mesh: int,
        positions: npt.NDArray[np.float32],
        indices: npt.NDArray[np.uint32],
        normals: Optional[npt.NDArray[np.float32]] = None,
        uv: Optional[npt.NDArray[np.float32]] = None,
        colors: Optional[npt.NDArray[np.float32]] = None,
        kind: str = "triangles",
        crease_degrees: Optional[float] = None,
        tangents_of: Optional[int] = None,
    ) -> None: ...
    def remove_mesh(self, mesh: int) -> None: ...
    def add_material(self, renderer: Renderer, request: Mapping[str, Any]) -> tuple[int, list[str]]: ...
    def set_material(self, renderer: Renderer, material: int, request: Mapping[str, Any]) -> list[str]: ...
    def material_name(self, material: int) -> str: ...
    def remove_material(self, material: int) -> None: ...
    def add_instance(self, mesh: int, material: int, matrix: npt.NDArray[np.float64]) -> int: ...
    def remove_instance(self, instance: int) -> None: ...
    def transform(self, instance: int) -> list[list[float]]: ...
    def set_transform(self, instance: int, matrix: npt.NDArray[np.float64]) -> None: ...
    def visible(self, instance: int) -> bool: ...
    def set_visible(self, instance: int, visible: bool) -> None: ...
    def instance_mesh(self, instance: int) -> int: ...
    def set_instance_mesh(self, instance: int, mesh: int) -> None: ...
    def instance_material(self, instance: int) -> int: ...
    def set_instance_material(self, instance: int, material: int) -> None: ...
    def model_of(self, instance: int) -> Optional[int]: ...
    def add_light(self, json: str) -> int: ...
    def set_light(self, light: int, json: str) -> None: ...
    def light(self, light: int) -> tuple[list[float], float]: ...
    def set_light_color(self, light: int, color: Sequence[float]) -> None: ...
    def set_light_intensity(self, light: int, intensity: float) -> None: ...
    def remove_light(self, light: int) -> None: ...
    def set_environment(self, renderer: Renderer, request: Mapping[str, Any]) -> list[str]: ...
    def environment(self) -> tuple[float, float]: ...
    def turn_environment(self, rotation_degrees: float, intensity: float) -> None: ...
    def models(self) -> list[int]: ...
    def instances(self) -> list[int]: ...
    def materials(self) -> list[int]: ...
    def lights(self) -> list[int]: ...

def aov_names() -> list[tuple[str, int]]: ...
def model_extensions() -> list[str]: ...
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

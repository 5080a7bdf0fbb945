"""Pictures that follow each other, drawn into arrays."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import timedelta
from typing import TYPE_CHECKING, Any, Dict, Mapping, Optional, Sequence, Tuple, Union

from . import _overcoat
from ._errors import OptionError
from ._option_types import ViewOptions
from ._options import camera as given_camera, check_names, request
from ._scene import InstanceHandle, Scene

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    from typing_extensions import Unpack

    from ._camera import CameraMatrices
    from ._option_types import Camera, Quality
    from ._render import Renderer

    #: Where a picture is seen from.
    View = Union[_overcoat.Orbit, Camera, CameraMatrices, str, None]
    Out = Union[npt.NDArray[np.uint8], npt.NDArray[np.float32], npt.NDArray[np.uint32]]


@dataclass(frozen=True)
class Drawn:
    """A picture that has been drawn.

    Attributes:
        array: What it was drawn into.
        quality: The tier that it has.
        samples: Coverage samples a pixel that it has.
        scale: Pixels of the array, in each direction, for one that was drawn: 1, or 2 to 4 where a budget was too small for all.
        is_final: Whether `Viewport.refine` would draw no better one.
        exposure: Stops, with what was metered.
        triangles: Triangles of the scene.
    """

    array: Any
    quality: str
    samples: int
    scale: int
    is_final: bool
    exposure: float
    triangles: int


@dataclass(frozen=True)
class Hit:
    """What is seen in a pixel.

    Attributes:
        instance: Whose it is.
        triangle: Its number in the mesh; of meshes of points, that of the point.
        vertices: Numbers of its three vertices in the mesh.
        barycentric: Weights of the vertices where it is seen, 0 to 1, of sum 1.
        depth: Metres along the view direction, as `aov="depth"`.
        position: Where that is, `(x, y, z)` in metres.
        back_facing: Seen from behind.
    """

    instance: InstanceHandle
    triangle: int
    vertices: Tuple[int, int, int]
    barycentric: Tuple[float, float, float]
    depth: float
    position: Tuple[float, float, float]
    back_facing: bool


class Viewport:
    """Draws pictures of a scene that follow each other, into arrays of the caller: as well as there is work for, and better when
    nothing moves.

    It keeps threads and what it needs from one picture to the next. The interpreter is free while it draws; of several threads one
    draws, and the others wait. It survives a fork.

    Args:
        renderer: Whose number of threads and instruction set it has; those of `Renderer()` if `None`. It has threads of its own.
        budget: How much a picture of `draw` may take. A whole number: units of work, counted and not timed, so that the pictures
            are the same everywhere; about a nanosecond of one thread on a machine of 2022, so that 16_000_000 is a sixtieth of a
            second there. A `datetime.timedelta`: time by the clock. `None`: whatever the tier takes.
        options: Keys of scene files that say how pictures are drawn (`ViewOptions`), as of `overcoat.render`; among them
            size: `(width, height)` in pixels, or one number for both. 512 if not given.
            quality: Tier that pictures reach: `draft`, `fast`, `good` or `best`; `fast` if not given.
    """

    def __init__(
        self,
        renderer: Optional[Renderer] = None,
        *,
        budget: Union[int, timedelta, None] = None,
        **options: Unpack[ViewOptions],
    ) -> None:
        if renderer is None:
            from ._render import Renderer

            renderer = Renderer()
        self._options: Dict[str, Any] = {}
        self._budget = budget
        asked = _asked(options)
        self._native = _overcoat.Viewport(renderer._native, request(asked, "Viewport()"), *_budget(budget))
        self._options = asked

    def configure(self, *, budget: Union[int, timedelta, None] = None, **options: Unpack[ViewOptions]) -> None:
        """Draws the following pictures with other options; those that are not given stay, and `budget` too."""
        budget = self._budget if budget is None else budget
        asked = {**self._options, **_asked(options)}
        self._native.configure(request(asked, "Viewport()"), *_budget(budget))
        self._options, self._budget = asked, budget

    @property
    def size(self) -> Tuple[int, int]:
        """(width, height) in pixels. May be assigned to, as `quality` and `budget` may."""
        size = self._options.get("size", 512)
        width, height = (size, size) if isinstance(size, int) else size
        return int(width), int(height)

    @size.setter
    def size(self, value: Union[int, Sequence[int]]) -> None:
        self.configure(size=value)

    @property
    def quality(self) -> Quality:
        """The tier that pictures reach."""
        tier: Quality = self._options.get("quality", "fast")
        return tier

    @quality.setter
    def quality(self, value: Quality) -> None:
        self.configure(quality=value)

    @property
    def budget(self) -> Union[int, timedelta, None]:
        """How much a picture of `draw` may take."""
        return self._budget

    @budget.setter
    def budget(self, value: Union[int, timedelta, None]) -> None:
        self._native.configure(request(self._options, "Viewport()"), *_budget(value))
        self._budget = value

    def draw(
        self,
        scene: Scene,
        camera: View = None,
        out: Optional[Out] = None,
        *,
        format: Optional[str] = None,
        region: Optional[Sequence[int]] = None,
    ) -> Drawn:
        """Draws the next picture: at the tier that was set, or, with a budget, as well as the pictures before say that there is
        work for.

        Args:
            camera: An `Orbit`, a `Camera` dict or the name of a view; `None`: the scene is framed automatically.
            out: Memory that is drawn into, without a copy: (H, W, 4) uint8 or float32, or (H, W) uint32, row 0 on top; a new array
                of uint8 if `None`. Pixels of a row must follow each other; rows may lie apart, so that a part of a larger array
                can be drawn into. It must not be read or written to before the call is done, and cannot be resized meanwhile.
            format: How a pixel lies in memory. Of uint8 `rgba8` (the default; sRGB with straight alpha, as `Image.array`), `bgra8`,
                `rgba8-premultiplied`, `bgra8-premultiplied`; of float32 `rgba-f32-premultiplied` (the default; linear light, as
                `Image.linear`) and `rgba-f32`; of uint32 `xrgb8`, 0x00RRGGBB.
            region: `(x, y, width, height)`: `out` holds this part of the picture alone, from the upper left corner.

        Raises:
            OptionError: (a `ValueError`) The array is read-only, or of another type, shape or layout; the message says which.
            Cancelled: Another thread has called `cancel`.
        """
        drawn = self._draw(scene, camera, out, format, region, False)
        assert drawn is not None
        return drawn

    def refine(
        self,
        scene: Scene,
        camera: View = None,
        out: Optional[Out] = None,
        *,
        format: Optional[str] = None,
        region: Optional[Sequence[int]] = None,
    ) -> Optional[Drawn]:
        """Draws the next better picture of the same scene from the same camera, as long as nothing changes; the first one, a draft,
        if something has. `None` if there is no better one: then nothing is drawn.

        The best is the picture that `overcoat.render` draws with these options. A budget does not count. Arguments as of `draw`.
        """
        return self._draw(scene, camera, out, format, region, True)

    def _draw(
        self, scene: Scene, camera: View, out: Any, format: Optional[str], region: Optional[Sequence[int]], refine: bool
    ) -> Optional[Drawn]:
        part = _region(region)
        if out is None:
            out = self._memory(format, part)
        orbit, described = given_camera(camera)
        drawn = self._native.draw(_scene(scene).snapshot(), orbit, described, out, format, part, refine)
        return None if drawn is None else Drawn(out, *drawn)

    def _memory(self, format: Optional[str], part: Optional[Tuple[int, int, int, int]]) -> Any:
        import numpy as np

        width, height = self.size if part is None else part[2:]
        if format is not None and "f32" in format:
            return np.zeros((height, width, 4), dtype=np.float32)
        if format == "xrgb8":
            return np.zeros((height, width), dtype=np.uint32)
        return np.zeros((height, width, 4), dtype=np.uint8)

    def pick(self, scene: Scene, x: int, y: int, camera: View = None) -> Optional[Hit]:
        """What is seen in a pixel, counted from the upper left corner: the nearest triangle, line or point that is not all
        transparent. `None` where nothing is. Microseconds, if the last picture was of this scene and camera."""
        orbit, described = given_camera(camera)
        width, height = self.size
        if not (0 <= x < width and 0 <= y < height):
            raise OptionError(f"pixel: {x}, {y} of {width} x {height} is not in the picture")
        hit = self._native.pick(_scene(scene)._world, orbit, described, int(x), int(y))
        if hit is None:
            return None
        instance, triangle, vertices, weights, depth, position, back_facing = hit
        return Hit(
            InstanceHandle(scene, instance), triangle, _three(vertices), _three(weights), depth, _three(position), back_facing
        )

    def cancel(self) -> None:
        """Stops what other threads are drawing with it, or wait to draw: there `Cancelled` is raised, within about a millisecond
        in most pictures. What is begun afterwards is not stopped."""
        self._native.cancel()

    def __repr__(self) -> str:
        width, height = self.size
        return f"<overcoat.Viewport of {width} x {height} pixels>"


def _asked(options: Mapping[str, Any]) -> Dict[str, Any]:
    check_names(options, ViewOptions.__annotations__, "Viewport()")
    return {name: value for name, value in options.items() if value is not None}


def _budget(budget: Any) -> Tuple[Optional[int], Optional[float]]:
    if budget is None:
        return None, None
    if isinstance(budget, timedelta):
        return None, budget.total_seconds()
    if isinstance(budget, bool) or not isinstance(budget, int) or not 0 <= budget < 2**64:
        raise OptionError(f"budget: expected units of work as a whole number, or a timedelta, found {budget!r}")
    return budget, None


def _region(region: Optional[Sequence[int]]) -> Optional[Tuple[int, int, int, int]]:
    if region is None:
        return None
    found = [int(number) for number in region]
    if len(found) != 4 or not all(0 <= number < 2**32 for number in found) or 0 in found[2:]:
        raise OptionError(f"region: expected (x, y, width, height) in pixels of the picture, found {region!r}")
    x, y, width, height = found
    return x, y, width, height


def _scene(scene: Any) -> Scene:
    if not isinstance(scene, Scene):
        raise OptionError(f"scene: expected an overcoat.Scene, found {type(scene).__name__}")
    return scene


def _three(of: Any) -> Tuple[Any, Any, Any]:
    first, second, third = of
    return first, second, third

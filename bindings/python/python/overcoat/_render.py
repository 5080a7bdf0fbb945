"""Pictures of models."""

from __future__ import annotations

import warnings as python_warnings
from typing import TYPE_CHECKING, Any, Iterator, List, Mapping, Optional, Sequence, overload

from . import _overcoat
from ._arrays import Mesh
from ._errors import OptionError, OvercoatWarning
from ._options import request, split
from ._scene import Scene
from ._sources import check_loading, load as load_source

if TYPE_CHECKING:
    import os

    from typing_extensions import Unpack

    from ._option_types import PictureOptions


class Renderer:
    """Renders models, keeping threads, memory, environments and prepared scenes from one picture to the next.

    It may be used by several threads at once: each gets worker threads of its own. It survives a fork: the child starts new
    threads when it draws. Files of environments and materials are read again when they have changed.

    Args:
        threads: Worker threads, 0 to 256; 0 stands for one per processor. Changes no picture.
        simd: Instruction set (`sse2`, `avx2`, `avx512`, `neon`, `scalar`); the best there is if `None`. Changes no picture.
        tile_size: Side of a tile in pixels, 16, 32 or 64. Changes no picture.
    """

    def __init__(self, threads: int = 0, *, simd: Optional[str] = None, tile_size: Optional[int] = None) -> None:
        self._native = _overcoat.Renderer(threads, simd, tile_size)

    @property
    def threads(self) -> int:
        """Worker threads of each picture."""
        return self._native.threads

    def load(self, source: Any, /, **options: Any) -> _overcoat.Model:
        """As `overcoat.load`, with the threads of this renderer."""
        return self._load(source, options)

    def _load(self, source: Any, options: dict[str, Any], level: int = 4) -> _overcoat.Model:
        check_loading(options)
        limits = options.pop("limits", None)
        model, _ = load_source(self._native, source, options, limits)
        _warn(model.warnings, level)
        return model

    if TYPE_CHECKING:

        def render(self, source: Any = None, /, **options: Unpack[PictureOptions]) -> _overcoat.Image:
            """As `overcoat.render`."""
            ...

        def turntable(
            self,
            source: Any,
            /,
            *,
            frames: int = 36,
            turn: str = "model",
            **options: Unpack[PictureOptions],
        ) -> Movie:
            """As `overcoat.turntable`."""
            ...

    else:

        def render(self, source=None, /, **options):
            """As `overcoat.render`."""
            return self._render(source, options)

        def turntable(self, source, /, *, frames=36, turn="model", **options):
            """As `overcoat.turntable`."""
            return self._turntable(source, frames, turn, options)

    def _render(self, source: Any, options: Mapping[str, Any], level: int = 4) -> _overcoat.Image:
        source, options = _source(source, options)
        if isinstance(source, Scene):
            source = source.snapshot()
        is_model = isinstance(source, _overcoat.Model)
        if is_model:
            model, drawing = source, options
            if any(name in options for name in ("up", "animation", "time", "loop", "format")):
                load_source(self._native, source, split(options)[0], None)
                drawing = split(options)[1]
        else:
            model, drawing = self._loaded(source, options)
        image = self._native.render(model, request(drawing), not is_model)
        # Who keeps a model was told of its own when it was loaded.
        _warn(image.warnings[len(model.warnings) if is_model else 0 :], level)
        return image

    def _loaded(self, source: Any, options: Mapping[str, Any]) -> tuple[_overcoat.Model, dict[str, Any]]:
        loading, drawing = split(options)
        # What is wrong with the options is found before a file is read.
        _overcoat.check_request(request(drawing))
        model, implied = load_source(self._native, source, loading, options.get("limits"))
        for name, value in implied.items():
            if name == "materials":
                drawing["materials"] = {**value, **drawing.get("materials", {})}
            else:
                drawing.setdefault(name, value)
        return model, drawing

    def _turntable(self, source: Any, frames: Any, turn: str, options: Mapping[str, Any], level: int = 4) -> Movie:
        if isinstance(frames, bool) or not isinstance(frames, int) or not 1 <= frames < 2**32:
            raise OptionError(f"frames {frames!r}: expected a whole number, at least 1")
        if turn not in ("camera", "model"):
            raise OptionError(f"turn '{turn}': expected camera or model")
        source, options = _source(source, options)
        if isinstance(source, Scene):
            source = source.snapshot()
        if isinstance(options.get("camera"), _overcoat.Orbit):
            raise OptionError("camera: a turntable has a camera of its own, and no Orbit")
        model, drawing = self._loaded(source, options)
        images = self._native.turntable(model, request(drawing), frames, turn == "model")
        _warn(images[0].warnings[len(model.warnings) if isinstance(source, _overcoat.Model) else 0 :], level)
        return Movie(images)

    def __repr__(self) -> str:
        return "<overcoat.Renderer>"


class Movie(Sequence[_overcoat.Image]):
    """Pictures of one size, in their order."""

    def __init__(self, images: Sequence[_overcoat.Image]) -> None:
        self._images: List[_overcoat.Image] = list(images)

    def __len__(self) -> int:
        return len(self._images)

    @overload
    def __getitem__(self, index: int) -> _overcoat.Image: ...
    @overload
    def __getitem__(self, index: slice) -> Movie: ...
    def __getitem__(self, index: Any) -> Any:
        return Movie(self._images[index]) if isinstance(index, slice) else self._images[index]

    def __iter__(self) -> Iterator[_overcoat.Image]:
        return iter(self._images)

    def encode(self, format: str = "png", *, fps: float = 12.0) -> bytes:
        """The bytes of an animated PNG (`png`), WebP (`webp`) or GIF (`gif`: 256 colours a frame), which repeats for ever.

        Args:
            fps: Pictures a second, 0.01 to 1000.
        """
        return _overcoat.encode_movie(self._images, format, fps)

    def save(self, path: str | os.PathLike[str], *, fps: float = 12.0) -> None:
        """Writes an animated `.png`, `.webp` or `.gif`; whole or not at all."""
        import os as system

        name = system.fspath(path)
        content = self.encode(system.path.splitext(name)[1].lstrip("."), fps=fps)
        _overcoat.write_file(name, content)

    def _repr_png_(self) -> bytes:
        return self.encode("png")

    def __repr__(self) -> str:
        return f"<overcoat.Movie of {len(self)} pictures>"


_shared: Optional[Renderer] = None


def shared_renderer() -> Renderer:
    """The renderer of the functions of this module, made when it is first used."""
    global _shared
    if _shared is None:
        _shared = Renderer()
    return _shared


def load(source: Any, /, **options: Any) -> _overcoat.Model:
    """Loads a model once, to be drawn many times.

    Args:
        source: What `render` takes.
        up: Axis that is up in the file, such as `+z`; what its format has, or the model's shape says, if `None`.
        animation: Name or number of an animation; with `time` in seconds and `loop`.
        format: Of bytes whose content does not tell: `glb`, `gltf`, `obj`, `stl` and others (`overcoat formats`).
        limits: Bounds on what the file may ask for, by name.

    Raises:
        LoadError, LimitError, OptionError, MeshError, OSError
    """
    return shared_renderer()._load(source, options)


if TYPE_CHECKING:

    def render(
        source: Any = None,
        /,
        *,
        vertices: Any = None,
        faces: Any = None,
        lines: Any = None,
        normals: Any = None,
        uv: Any = None,
        colors: Any = None,
        texture: Any = None,
        renderer: Optional[Renderer] = None,
        **options: Unpack[PictureOptions],
    ) -> _overcoat.Image: ...

    def turntable(
        source: Any,
        /,
        *,
        frames: int = 36,
        turn: str = "model",
        renderer: Optional[Renderer] = None,
        **options: Unpack[PictureOptions],
    ) -> Movie: ...

else:

    def render(
        source=None,
        /,
        *,
        vertices=None,
        faces=None,
        lines=None,
        normals=None,
        uv=None,
        colors=None,
        texture=None,
        renderer=None,
        **options,
    ):
        """Draws one picture. The same input has the same bytes on every machine.

        The interpreter is free meanwhile, for other threads. Ctrl-C in the main thread stops the picture: `KeyboardInterrupt`.

        Args:
            source: Path of a model file (glTF, OBJ, STL, PLY, 3MF, FBX, COLLADA and others), its bytes, a file object, a `Model`, a `Mesh` or `Splats` or a
                list of them, a `Scene`, a scene or geometry of trimesh, PyVista or Open3D, or a scene of pyrender. In its place, arrays:
            vertices, faces, lines, normals, uv, colors, texture: As of `Mesh`.
            renderer: Whose threads are used; one that all calls share if `None`.
            options: Keys of scene files, see `help(overcoat.Options)`; among them
                size: `(width, height)` in pixels, or one number for both. 512 if not given.
                samples: Coverage samples a pixel, 1, 4, 8 or 16.
                quality: `draft`, `fast`, `good` or `best`.
                shading: Name of a shading model.
                camera: Dict of `eye`, `target`, `up` (metres), `fov_y_deg` (degrees), `view` and others, or the name of a view.
                env: `studio`, `car-studio`, `sky`, `none`, the path of an equirectangular picture, or an array (H, W, 3) of linear radiance.
                material: Name of a built-in material, path of a material file, or a dict of its keys.
                aov: Names of planes of the G-buffer, for `Image.aov`.

        Returns:
            An `Image`: `.array` is (H, W, 4) bytes, sRGB with straight alpha; `.linear` is float32.

        Raises:
            UnknownOptionError: (a `TypeError`) There is no such option; the message names the nearest.
            OptionError: (a `ValueError`) A value is out of its range, or the model does not have what is chosen.
            LoadError: A file is damaged or of no known format. A file that is not there is a `FileNotFoundError`.
            LimitError: It would cost more than a limit allows.
            MeshError: (a `ValueError`) Arrays are no mesh.

        Warns:
            OvercoatWarning: What the file asks for and the picture does not show; also in `Image.warnings`.
        """
        if vertices is not None:
            if source is not None:
                raise OptionError("vertices: there is a model already")
            source = Mesh(vertices, faces, normals, uv, colors, texture=texture, lines=lines)
            # Where there are texture coordinates, a material may have a normal map, which asks for tangents.
            if uv is not None:
                source.material = options.pop("material", None)
        else:
            arrays = {"faces": faces, "lines": lines, "normals": normals, "uv": uv, "colors": colors, "texture": texture}
            given = [name for name, value in arrays.items() if value is not None]
            if given:
                raise OptionError(f"{given[0]}: there are no vertices")
        return (renderer or shared_renderer())._render(source, options)

    def turntable(source, /, *, frames=36, turn="model", renderer=None, **options):
        """Draws a model once around: the pictures of the command `overcoat turntable`.

        Args:
            source, options: As of `render`.
            frames: How many pictures, at least 1.
            turn: `model` turns under a light that stays; `camera` goes around the model, and the light stays with it.

        Returns:
            A `Movie`, a sequence of `Image`: `.save("car.webp", fps=12)`.
        """
        return (renderer or shared_renderer())._turntable(source, frames, turn, options)


def _source(source: Any, options: Mapping[str, Any]) -> tuple[Any, dict[str, Any]]:
    """The model may be among the options, of a scene file."""
    rest = dict(options)
    named = rest.pop("model", None)
    if source is None:
        source = named
    if source is None:
        raise OptionError("no model is given")
    return source, rest


def _warn(messages: Sequence[str], level: int) -> None:
    for message in messages:
        python_warnings.warn(message, OvercoatWarning, stacklevel=level)

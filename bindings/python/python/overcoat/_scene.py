"""A scene that changes: what is in it has handles, which stay while other things come and go."""

from __future__ import annotations

import warnings as python_warnings
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Union

from . import _overcoat
from ._arrays import Mesh, array, identity, matrix
from ._errors import HandleError, MeshError, OptionError, OvercoatWarning
from ._options import LOADING, _environment, _json, _limits, check_names, plain, request

if TYPE_CHECKING:
    import os

    import numpy as np
    import numpy.typing as npt

    from ._render import Renderer

    Array = npt.NDArray[Any]
    #: Name of a built-in material, path of a material file, a dict of its keys, or `None` for clay.
    MaterialSource = Union[str, os.PathLike[str], Mapping[str, Any], None]


class _Handle:
    """What handles have in common: two of the same thing are equal, and may be keys of dicts."""

    def __init__(self, scene: Scene, bits: int) -> None:
        self._scene = scene
        self._bits = bits

    @property
    def scene(self) -> Scene:
        """The scene that it is in."""
        return self._scene

    @property
    def _world(self) -> _overcoat.World:
        return self._scene._world

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Handle) and (type(self), self._scene, self._bits) == (type(other), other._scene, other._bits)

    def __hash__(self) -> int:
        return hash((type(self), id(self._scene), self._bits))

    def __repr__(self) -> str:
        return f"<overcoat.{type(self).__name__} {self._bits:#x}>"


class MeshHandle(_Handle):
    """A mesh of a scene, for `Scene.add_instance`."""

    def replace(self, vertices: Any, faces: Any = None, **arrays: Any) -> None:
        """Puts another mesh in its place, in every instance of it. Arguments as of `Scene.add_mesh`."""
        self._world.set_mesh(self._bits, *_mesh(vertices, faces, arrays).arrays())

    def remove(self) -> None:
        """Removes it and gives its memory back.

        Raises:
            HandleError: There is an instance of it.
        """
        self._world.remove_mesh(self._bits)


class MaterialHandle(_Handle):
    """A material of a scene: of `Scene.add_material`, or one of a model."""

    @property
    def name(self) -> str:
        """Its name in its file; empty if it has none."""
        return self._world.material_name(self._bits)

    def assign(self, source: MaterialSource) -> None:
        """Makes it another one, in every instance that is made of it.

        Args:
            source: As of `Scene.add_material`. Keys that are not there have their defaults, unless there is `"over": True`: then
                they stay as they are.
        """
        scene = self._scene
        _warn(self._world.set_material(scene._renderer._native, self._bits, request({"material": source})), 3)

    def remove(self) -> None:
        """Removes it, with the textures that came with it.

        Raises:
            HandleError: An instance is made of it.
        """
        self._world.remove_material(self._bits)


class InstanceHandle(_Handle):
    """A mesh of some material at a place: of `Scene.add_instance`, or a part of a model."""

    @property
    def transform(self) -> npt.NDArray[np.float64]:
        """(4, 4), object to world; of a model's instance, object to model. Columns are multiplied. A copy: assign to move it."""
        return _array(self._world.transform(self._bits))

    @transform.setter
    def transform(self, value: Any) -> None:
        self._world.set_transform(self._bits, matrix("transform", value))

    @property
    def visible(self) -> bool:
        """Whether it is drawn, unless its model is hidden."""
        return self._world.visible(self._bits)

    @visible.setter
    def visible(self, value: bool) -> None:
        self._world.set_visible(self._bits, bool(value))

    @property
    def mesh(self) -> MeshHandle:
        """What is drawn."""
        return MeshHandle(self._scene, self._world.instance_mesh(self._bits))

    @mesh.setter
    def mesh(self, value: MeshHandle) -> None:
        self._world.set_instance_mesh(self._bits, _bits("mesh", value, MeshHandle))

    @property
    def material(self) -> MaterialHandle:
        """What it is made of."""
        return MaterialHandle(self._scene, self._world.instance_material(self._bits))

    @material.setter
    def material(self, value: MaterialHandle) -> None:
        self._world.set_instance_material(self._bits, _bits("material", value, MaterialHandle))

    @property
    def model(self) -> Optional[ModelHandle]:
        """The model that it is a part of."""
        bits = self._world.model_of(self._bits)
        return None if bits is None else ModelHandle(self._scene, bits)

    def remove(self) -> None:
        """Removes it. Its mesh and material stay. Poses of a model do not bring it back."""
        self._world.remove_instance(self._bits)


class LightHandle(_Handle):
    """A light of a scene: of `Scene.add_light`, or one of a model."""

    @property
    def color(self) -> tuple[float, float, float]:
        """Linear red, green and blue."""
        red, green, blue = self._world.light(self._bits)[0]
        return red, green, blue

    @color.setter
    def color(self, value: Any) -> None:
        self._world.set_light_color(self._bits, _numbers("color", value, 3))

    @property
    def intensity(self) -> float:
        """Lux of directional lights, candela of points and spots, candela per square metre of rectangles and tubes."""
        return self._world.light(self._bits)[1]

    @intensity.setter
    def intensity(self, value: float) -> None:
        self._world.set_light_intensity(self._bits, _number("intensity", value))

    def assign(self, description: Optional[Mapping[str, Any]] = None, /, **keys: Any) -> None:
        """Makes it another light. Arguments as of `Scene.add_light`."""
        self._world.set_light(self._bits, _light(description, keys))

    def remove(self) -> None:
        """Removes it."""
        self._world.remove_light(self._bits)


class ModelHandle(_Handle):
    """A model in a scene: one place and one pose, and the parts of its file."""

    @property
    def transform(self) -> npt.NDArray[np.float64]:
        """(4, 4), model to world; columns are multiplied. A copy: assign to move the model with all of its parts."""
        return _array(self._world.model_transform(self._bits))

    @transform.setter
    def transform(self, value: Any) -> None:
        self._world.set_model_transform(self._bits, matrix("transform", value))

    @property
    def visible(self) -> bool:
        """Whether it is drawn. The lights of a hidden model go on shining."""
        return self._world.model_visible(self._bits)

    @visible.setter
    def visible(self, value: bool) -> None:
        self._world.set_model_visible(self._bits, bool(value))

    @property
    def instances(self) -> List[InstanceHandle]:
        """Its parts, in the order of the file."""
        return [InstanceHandle(self._scene, bits) for bits in self._world.model_instances(self._bits)]

    @property
    def materials(self) -> List[MaterialHandle]:
        """Its materials, in the order of the file."""
        return [MaterialHandle(self._scene, bits) for bits in self._world.model_materials(self._bits)]

    @property
    def lights(self) -> List[LightHandle]:
        """Its lights, in the order of the file."""
        return [LightHandle(self._scene, bits) for bits in self._world.model_lights(self._bits)]

    @property
    def cameras(self) -> Dict[str, _overcoat.Orbit]:
        """Its cameras where they are now, by their names: `viewport.draw(scene, model.cameras["left"])`."""
        return dict(self._world.model_cameras(self._bits))

    @property
    def duration(self) -> Optional[float]:
        """Seconds to the last key frame of its animation; `None` if it was added without one."""
        return self._world.animation_length(self._bits)

    def pose(self, seconds: float) -> None:
        """Brings it to a time of its animation, in seconds from 0 on. Its parts keep their handles; what was changed of them stays
        changed, unless the file moves it.

        Raises:
            OptionError: It was added without an animation.
        """
        _warn(self._world.set_pose(self._bits, _number("pose", seconds)), 3)

    def remove(self) -> None:
        """Removes it with all of its parts. Meshes and materials that other instances use by now stay."""
        self._world.remove_model(self._bits)


class Scene:
    """A scene that changes: models, meshes, materials, instances and lights come and go, and what is in it has handles.

    A handle stays what it is while other things change; used after its thing was removed, or with another scene, it is a
    `HandleError`. What is refused changes nothing. `overcoat.render(scene)` draws a picture, `Viewport.draw` pictures that follow
    each other. A picture is of the scene as it is when it is begun: other threads may go on and change it meanwhile. Lengths are
    metres, +Y is up; matrices are (4, 4), columns are multiplied.

    Args:
        renderer: Whose threads load models and materials; one that all share if `None`.
    """

    def __init__(self, renderer: Optional[Renderer] = None) -> None:
        if renderer is None:
            from ._render import shared_renderer

            renderer = shared_renderer()
        self._renderer = renderer
        self._world = _overcoat.World()
        self._environment: Any = "studio"

    def add_model(self, source: Any, transform: Any = None, **options: Any) -> ModelHandle:
        """Adds a model with its lights. Its environment, and cameras of trimesh and pyrender, are not taken over.

        Args:
            source: What `overcoat.render` takes: a path, bytes, a `Model`, a `Mesh` or several, a scene of trimesh or pyrender.
            transform: (4, 4), model to world.
            animation: Name or number of an animation of a model file, so that `ModelHandle.pose` can move it; with `time` in
                seconds and `loop`.
            up, format, limits: As of `overcoat.load`.
            material, materials: Laid over those of the model, as of `overcoat.render`. Not together with `animation`.
        """
        check_names(options, (*LOADING, "format", "limits", "material", "materials"), "add_model()")
        options = {name: value for name, value in options.items() if value is not None}
        placed = identity() if transform is None else matrix("transform", transform)
        native = self._renderer._native
        laid: Dict[str, Any] = {name: options.pop(name) for name in ("material", "materials") if name in options}
        limits = options.pop("limits", None)
        if "animation" in options:
            if laid:
                raise OptionError(f"{next(iter(laid))}: not of a model with an animation; assign to the handles of its materials")
            return self._add_animated(source, options, limits, placed)
        from ._sources import load

        model, implied = load(native, source, options, limits)
        if "materials" in implied:
            laid["materials"] = {**implied["materials"], **laid.get("materials", {})}
        bits, warnings = self._world.add_model(native, model, request({**laid, "limits": limits}), placed)
        _warn([*([] if model is source else model.warnings), *warnings], 3)
        return ModelHandle(self, bits)

    def _add_animated(self, source: Any, options: Dict[str, Any], limits: Any, placed: Array) -> ModelHandle:
        from ._sources import file_of

        path, content, form = file_of(source, options.get("format"))
        if path is None and content is None:
            raise OptionError(f"animation: only model files have it, not a {type(source).__name__}")
        description = _json({name: plain(name, value) for name, value in options.items() if name in LOADING})
        form = None if path is not None else form
        native = self._renderer._native
        bits, warnings = self._world.add_animated_model(native, path, content, form, description, _limits(limits), placed)
        _warn(warnings, 4)
        return ModelHandle(self, bits)

    def add_mesh(self, vertices: Any, faces: Any = None, **arrays: Any) -> MeshHandle:
        """Adds a mesh, to be placed by `add_instance`.

        Args:
            vertices: (N, 3), positions in metres; or a `Mesh`, which has no material, texture or transform then.
            faces: (M, 3) whole numbers; `None`: the vertices are points.
            arrays: `lines`, `normals`, `uv`, `colors` and `crease_deg` of `Mesh`. Colours multiply that of the material.
        """
        return MeshHandle(self, self._world.add_mesh(*_mesh(vertices, faces, arrays).arrays()))

    def add_material(self, source: MaterialSource = None, *, limits: Optional[Mapping[str, int]] = None) -> MaterialHandle:
        """Adds a material.

        Args:
            source: Name of a built-in material, path of a material file, or a dict of its keys, such as
                `{"base_color": "#a01020", "roughness": 0.3, "coat": 1}`, with textures that may be arrays, as of `Mesh`; `None`: clay.
            limits: Bounds on what its textures may be, by name.
        """
        asked = request({"material": source, "limits": limits})
        bits, warnings = self._world.add_material(self._renderer._native, asked)
        _warn(warnings, 3)
        return MaterialHandle(self, bits)

    def add_instance(self, mesh: MeshHandle, material: MaterialHandle, transform: Any = None) -> InstanceHandle:
        """Places a mesh.

        Args:
            transform: (4, 4), object to world.
        """
        placed = identity() if transform is None else matrix("transform", transform)
        of, made = _bits("mesh", mesh, MeshHandle), _bits("material", material, MaterialHandle)
        return InstanceHandle(self, self._world.add_instance(of, made, placed))

    def add_light(self, description: Optional[Mapping[str, Any]] = None, /, **keys: Any) -> LightHandle:
        """Adds a light, with the keys of scene files, as a dict or by name: `add_light(type="directional", direction=[0, -1, 0],
        intensity=2)`.

        Args:
            type: `directional`, `point`, `spot`, `rect` or `tube`.
            color: Linear red, green and blue, or an sRGB colour `#rrggbb`; white if absent.
            intensity: Lux of directional lights, candela of points and spots, candela per square metre of rectangles and tubes.
            direction: In which a directional light travels.
            position, target: Of points, spots and rectangles, in metres; `target` is what they point at.
            range: Of points and spots, metres to where they have faded out.
            inner_cone_deg, outer_cone_deg: Of spots, half angles in degrees.
            size, up, two_sided: Of rectangles, width and height in metres.
            to, radius: Of tubes, the other end of the axis in metres; the first is `from`, which only a dict can have.
        """
        return LightHandle(self, self._world.add_light(_light(description, keys)))

    @property
    def environment(self) -> Any:
        """Light from afar: `studio` (the default), `car-studio`, `sky`, `none`, the path of an equirectangular picture, an array (H, W, 3) of linear
        radiance, row 0 at the zenith, or an `Environment`. What was assigned last."""
        return self._environment

    @environment.setter
    def environment(self, value: Any) -> None:
        if value is None:
            raise OptionError("environment: expected a name, a path, an array or an Environment")
        _warn(self._world.set_environment(self._renderer._native, request({"env": value})), 3)
        made = _environment(value)
        self._environment = value if made is None or made is value else made

    @property
    def environment_rotation_deg(self) -> float:
        """Turns the environment about +Y, in degrees, counter-clockwise seen from above. 0 by default."""
        return self._world.environment()[0]

    @environment_rotation_deg.setter
    def environment_rotation_deg(self, value: float) -> None:
        self._world.turn_environment(_number("environment_rotation_deg", value), self.environment_intensity)

    @property
    def environment_intensity(self) -> float:
        """Multiplies the environment's radiance. 1 by default."""
        return self._world.environment()[1]

    @environment_intensity.setter
    def environment_intensity(self, value: float) -> None:
        self._world.turn_environment(self.environment_rotation_deg, _number("environment_intensity", value))

    @property
    def models(self) -> List[ModelHandle]:
        """All models."""
        return [ModelHandle(self, bits) for bits in self._world.models()]

    @property
    def instances(self) -> List[InstanceHandle]:
        """All instances, those of models and hidden ones too, in the order of drawing."""
        return [InstanceHandle(self, bits) for bits in self._world.instances()]

    @property
    def materials(self) -> List[MaterialHandle]:
        """All materials, those of models too."""
        return [MaterialHandle(self, bits) for bits in self._world.materials()]

    @property
    def lights(self) -> List[LightHandle]:
        """All lights, those of models too."""
        return [LightHandle(self, bits) for bits in self._world.lights()]

    def snapshot(self) -> _overcoat.Model:
        """The scene as it is now, as a `Model`, which does not change with it. Meshes and textures are shared."""
        return self._world.model()

    def __repr__(self) -> str:
        return f"<overcoat.Scene of {len(self._world.instances())} instances>"


def _bits(what: str, handle: Any, kind: type[_Handle]) -> int:
    if not isinstance(handle, kind):
        raise HandleError(f"{what}: expected a {kind.__name__}, found {type(handle).__name__}")
    return handle._bits


def _array(rows: Any) -> npt.NDArray[np.float64]:
    import numpy as np

    return np.asarray(rows, dtype=np.float64)


def _mesh(vertices: Any, faces: Any, arrays: Mapping[str, Any]) -> Mesh:
    if isinstance(vertices, Mesh):
        if faces is not None or arrays:
            raise MeshError(f"{next(iter(arrays), 'faces')}: the Mesh has its own")
        for name in ("material", "texture", "transform"):
            if getattr(vertices, name) is not None:
                raise MeshError(f"{name}: a mesh of a scene has none; add_instance() takes materials and transforms, add_model() all")
        return vertices
    check_names(arrays, ("lines", "normals", "uv", "colors", "crease_deg"), "add_mesh()")
    return Mesh(vertices, faces, **arrays)


def _light(description: Optional[Mapping[str, Any]], keys: Mapping[str, Any]) -> str:
    light = {**(description or {}), **keys}
    return _json({"light": [plain("light", light)]})


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        raise OptionError(f"{name}: expected a number, found {type(value).__name__}")
    return float(value)


def _numbers(name: str, value: Any, count: int) -> Sequence[float]:
    found = array(name, value)
    if found.shape != (count,):
        raise MeshError(f"{name}: expected {count} numbers, found shape {found.shape}")
    return [float(number) for number in found]


def _warn(messages: Sequence[str], level: int) -> None:
    for message in messages:
        python_warnings.warn(message, OvercoatWarning, stacklevel=level)

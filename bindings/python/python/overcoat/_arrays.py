"""Meshes of arrays."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Mapping, Optional, Sequence, Union

from . import _overcoat
from ._errors import MeshError
from ._kept import texels_of

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Array = npt.NDArray[Any]
    Floats = npt.NDArray[np.float32]
    #: Vertices, faces, normals, uv, colours, kind, crease, set of texture coordinates for tangents.
    MeshArrays = tuple[
        Floats,
        npt.NDArray[np.uint32],
        Optional[Floats],
        Optional[Floats],
        Optional[Floats],
        str,
        Optional[float],
        Optional[int],
    ]

#: What is made of nothing known: a satin, warm light grey, as for files without materials. Linear.
CLAY: dict[str, Any] = {"base_color": [0.479, 0.434, 0.392, 1.0], "metallic": 0.0, "roughness": 0.6, "double_sided": True}
#: The same where vertices have colours, which multiply it.
WHITE_CLAY: dict[str, Any] = {**CLAY, "base_color": [1.0, 1.0, 1.0, 1.0]}


@dataclass
class Mesh:
    """A mesh of arrays: of any floating point or whole number type, contiguous or not, numpy's or what it can convert. They are
    copied once.

    Attributes:
        vertices: (N, 3), positions in metres, +Y up.
        faces: (M, 3) whole numbers, three vertices each, counter-clockwise seen from the front; `None`: the vertices are points, or
            joined by `lines`.
        normals: (N, 3), of any length. `None`: smooth ones are found, with edges where faces meet at more than `crease_deg`.
        uv: (N, 2), texture coordinates; (0, 0) is the upper left corner of the first texel of the first row, as in glTF.
        colors: (N, 3) or (N, 4), one colour a vertex. Whole numbers are sRGB, 0 to 255; floating point numbers are linear, 0 to 1.
        material: Name of a built-in material, path of a material file, or a dict of a material file's keys, such as
            `{"coat": 1, "coat_color": [1, 0.3, 0.1], "normal_texture": array}`; `None`: clay. Textures may be arrays (H, W), (H, W, 3) or
            (H, W, 4), row 0 on top, or images of Pillow, alone or as `file` of a dict with `wrap`, `scale` and others: bytes, or
            floating point numbers from 0 to 1, that mean what they do in files: sRGB in textures of colours, linear in others.
        texture: Such an array: the base colour by `uv`.
        transform: (4, 4), object to world; columns are multiplied.
        name: Of its material, for `materials=`.
        crease_deg: 0 to 180; 0 makes every face flat.
    """

    vertices: Any
    faces: Any = None
    normals: Any = None
    uv: Any = None
    colors: Any = None
    material: Any = None
    texture: Any = None
    transform: Any = None
    name: str = "mesh"
    crease_deg: float = 40.0
    #: (M, 2) whole numbers, two vertices each, in place of faces; as wide as the option `line_width` says, in pixels.
    lines: Any = None

    def add_to(self, builder: _overcoat.SceneBuilder, object_number: int, name: str) -> None:
        """Puts it into a scene that is being built."""
        vertices, indexed, normals, uv, colors, kind, crease, tangents = self.arrays()
        material = dict(WHITE_CLAY if colors is not None or self.texture is not None else CLAY)
        material["name"] = name
        if self.texture is not None:
            material["base_color_texture"] = {"image": builder.add_image(texels_of("texture", self.texture))}
        if colors is not None and (colors[:, 3] < 1).any():
            material["alpha_mode"] = "blend"
        if self.material is None:
            # The material of a file may have a normal map or a grain.
            tangents = None
        mesh = builder.add_mesh(_overcoat.Geometry(vertices, indexed, normals, uv, colors, kind, crease, tangents))
        placed = identity() if self.transform is None else matrix("transform", self.transform)
        builder.add_instance(mesh, builder.add_material(json.dumps(material)), placed, object_number)
        builder.name_object(object_number, name)

    def arrays(self) -> MeshArrays:
        """Its arrays as the native half takes them: of the right types, each in one piece, with tangents if there is `uv`."""
        vertices = floats("vertices", self.vertices, (3,))
        if self.faces is not None and self.lines is not None:
            raise MeshError("lines: the mesh has faces; make it two meshes")
        if self.faces is not None:
            kind, indexed = "triangles", indices("faces", self.faces, 3)
        elif self.lines is not None:
            kind, indexed = "lines", segments(indices("lines", self.lines, 2))
        else:
            kind, indexed = "points", points(len(vertices))
        colors = None if self.colors is None else linear_colors("colors", self.colors)
        normals = None if self.normals is None else floats("normals", self.normals, (3,))
        uv = None if self.uv is None else floats("uv", self.uv, (2,))
        return (
            vertices,
            indexed,
            normals,
            uv,
            colors,
            kind,
            self.crease_deg if kind == "triangles" else None,
            0 if uv is not None and kind == "triangles" else None,
        )


@dataclass
class Splats:
    """Gaussian splats of arrays (3D Gaussian Splatting, Kerbl et al. 2023), as trainers have them after their activations.

    Attributes:
        means: (N, 3), centres in metres, +Y up.
        scales: (N, 3), standard deviations along the axes of each in metres, at least 0.
        rotations: (N, 4), quaternions x, y, z, w of any length above 0, from the axes of each to the object.
        opacities: (N,), 0 to 1.
        colors: (N, 3), as a screen shows them: sRGB from 0 to 1, without the part that depends on the view: 0.5 + 0.28209479 times the
            coefficient of degree 0.
        harmonics: (N, K, 3) with K = 3, 8 or 15: coefficients of degree 1, 2 and 3 of each colour; `None`: the same from all sides.
        transform: (4, 4), object to world; columns are multiplied.
        name: For `Image.ids`.
    """

    means: Any
    scales: Any
    rotations: Any
    opacities: Any
    colors: Any
    harmonics: Any = None
    transform: Any = None
    name: str = "splats"

    def add_to(self, builder: _overcoat.SceneBuilder, object_number: int, name: str) -> None:
        """Puts them into a scene that is being built."""
        import numpy as np

        means = floats("means", self.means, (3,))
        opacities = array("opacities", self.opacities)
        if opacities.shape not in ((len(means),), (len(means), 1)):
            raise MeshError(f"opacities: expected shape ({len(means)},), found {opacities.shape}")
        harmonics = np.zeros((len(means), 0), dtype=np.float32)
        if self.harmonics is not None:
            given = array("harmonics", self.harmonics)
            if given.ndim != 3 or given.shape[2] != 3:
                raise MeshError(f"harmonics: expected shape (N, K, 3), found {given.shape}")
            harmonics = floats("harmonics", given.reshape(len(given), -1), (3 * given.shape[1],))
        builder.add_splats(
            means,
            floats("scales", self.scales, (3,)),
            floats("rotations", self.rotations, (4,)),
            floats("opacities", opacities.reshape(-1, 1), (1,)),
            floats("colors", self.colors, (3,)),
            harmonics,
            identity() if self.transform is None else matrix("transform", self.transform),
            object_number,
        )
        builder.name_object(object_number, name)


def model_of(
    meshes: Sequence[Union[Mesh, Splats]], up: Optional[str], warnings: Sequence[str] = ()
) -> _overcoat.Model:
    """A model of meshes and splats."""
    builder = _overcoat.SceneBuilder()
    for warning in warnings:
        builder.warn(warning)
    for number, (mesh, name) in enumerate(zip(meshes, _names(meshes))):
        mesh.add_to(builder, number, name)
    return builder.finish(up)


def materials_of(meshes: Sequence[Union[Mesh, Splats]]) -> dict[str, Any]:
    """The option `materials` for what meshes name as their material."""
    named = ((name, mesh) for name, mesh in zip(_names(meshes), meshes) if isinstance(mesh, Mesh))
    return {name: mesh.material for name, mesh in named if mesh.material is not None}


def _names(meshes: Sequence[Union[Mesh, Splats]]) -> list[str]:
    """Names of their materials: the second of a name is `name-2`."""
    names: list[str] = []
    for mesh in meshes:
        name, number = mesh.name, 2
        while name in names:
            name, number = f"{mesh.name}-{number}", number + 1
        names.append(name)
    return names


def array(what: str, value: Any) -> Array:
    """An array of real numbers."""
    import numpy as np

    try:
        found = np.asarray(value)
    except ValueError as error:
        raise MeshError(f"{what}: rows of different lengths are no array ({error})") from None
    if found.dtype.kind not in "fiu":
        raise MeshError(f"{what}: expected an array of numbers, found {found.dtype}")
    return found


def floats(what: str, value: Any, widths: Sequence[int]) -> npt.NDArray[np.float32]:
    """(N, width) as float32, in one piece."""
    import numpy as np

    found = array(what, value)
    if found.ndim != 2 or found.shape[1] not in widths:
        expected = " or ".join(f"(N, {width})" for width in widths)
        raise MeshError(f"{what}: expected shape {expected}, found {found.shape}")
    # What does not fit becomes infinite, which the library names.
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(found, dtype=np.float32)


def indices(what: str, value: Any, width: int) -> npt.NDArray[np.uint32]:
    """(M, width) of whole numbers as uint32."""
    import numpy as np

    found = array(what, value)
    if found.dtype.kind not in "iu" and found.size > 0:
        raise MeshError(f"{what}: expected whole numbers, found {found.dtype}")
    if found.ndim != 2 or found.shape[1] != width:
        if found.size > 0 or found.ndim != 1:
            raise MeshError(f"{what}: expected shape (M, {width}), found {found.shape}")
        found = found.reshape(0, width)
    if found.size > 0 and (found.min() < 0 or found.max() >= 2**32):
        bad = found.min() if found.min() < 0 else found.max()
        raise MeshError(f"{what}: {bad} is no vertex: expected numbers from 0 on, below that of vertices")
    return np.ascontiguousarray(found, dtype=np.uint32)


def points(count: int) -> npt.NDArray[np.uint32]:
    """Indices of as many points."""
    import numpy as np

    return np.repeat(np.arange(count, dtype=np.uint32)[:, None], 3, axis=1)


def segments(pairs: Array) -> npt.NDArray[np.uint32]:
    """Indices of lines between pairs of vertices, (M, 2)."""
    import numpy as np

    return np.ascontiguousarray(np.column_stack([pairs, pairs[:, 1]]).astype(np.uint32))


def linear_colors(what: str, value: Any) -> npt.NDArray[np.float32]:
    """(N, 4) linear colours."""
    import numpy as np

    found = array(what, value)
    if found.ndim != 2 or found.shape[1] not in (3, 4):
        raise MeshError(f"{what}: expected shape (N, 3) or (N, 4), found {found.shape}")
    result = np.ones((len(found), 4), dtype=np.float32)
    if found.dtype.kind == "f":
        result[:, : found.shape[1]] = found
        return result
    if found.size > 0 and (found.min() < 0 or found.max() > 255):
        raise MeshError(f"{what}: whole numbers are sRGB, 0 to 255; found {found.min()} to {found.max()}")
    result[:, : found.shape[1]] = found / np.float32(255)
    result[:, :3] = srgb_to_linear(result[:, :3])
    return result


def srgb_to_linear(encoded: Any) -> npt.NDArray[np.float32]:
    """IEC 61966-2-1, of values from 0 to 1, by a table of its 256 codes: the same bits on every machine."""
    import numpy as np

    codes = np.rint(np.clip(encoded, 0, 1) * 255).astype(np.uint8)
    return np.asarray(_table()[codes])


def _table() -> npt.NDArray[np.float32]:
    import numpy as np

    return np.asarray(_overcoat.srgb_table(), dtype=np.float32)


def texels(what: str, value: Any) -> npt.NDArray[np.uint8]:
    """(H, W, 4) bytes of a picture: an array, or an object of Pillow."""
    import numpy as np

    if hasattr(value, "convert") and hasattr(value, "size"):
        value = value.convert("RGBA")
    found = np.asarray(value)
    if found.dtype == np.bool_ or found.dtype.kind not in "fiu":
        raise MeshError(f"{what}: expected an array of numbers, found {found.dtype}")
    if found.dtype.kind == "f":
        found = np.rint(np.clip(np.nan_to_num(found), 0, 1) * 255)
    if found.ndim == 2:
        found = np.repeat(found[:, :, None], 3, axis=2)
    if found.ndim != 3 or found.shape[2] not in (3, 4) or found.shape[0] == 0 or found.shape[1] == 0:
        raise MeshError(f"{what}: expected shape (H, W, 3) or (H, W, 4), found {found.shape}")
    result = np.full((found.shape[0], found.shape[1], 4), 255, dtype=np.uint8)
    result[:, :, : found.shape[2]] = found
    return result


def picture(what: str, value: Any) -> npt.NDArray[np.uint8]:
    """(H, W, 4) bytes of a drawn picture."""
    import numpy as np

    found = np.asarray(value)
    if found.dtype != np.uint8:
        raise MeshError(f"{what}: expected bytes (uint8), found {found.dtype}")
    return texels(what, found)


def matrix(what: str, value: Any) -> npt.NDArray[np.float64]:
    """(4, 4) as float64."""
    import numpy as np

    found = array(what, value)
    if found.shape != (4, 4):
        raise MeshError(f"{what}: expected shape (4, 4), found {found.shape}")
    return np.ascontiguousarray(found, dtype=np.float64)


def identity() -> npt.NDArray[np.float64]:
    """Nothing is moved."""
    import numpy as np

    return np.eye(4)


def environment(radiance: Any) -> _overcoat.Environment:
    """(H, W, 3) linear radiance, equirectangular, row 0 at the zenith, as an environment."""
    import numpy as np

    found = array("env", radiance)
    if found.ndim != 3 or found.shape[2] != 3:
        raise MeshError(f"env: expected shape (H, W, 3), found {found.shape}")
    if found.dtype.kind != "f":
        raise MeshError(f"env: expected linear radiance as floating point numbers, found {found.dtype}")
    return _overcoat.Environment(np.ascontiguousarray(found, dtype=np.float32))


def object_json(value: Mapping[str, Any]) -> str:
    """JSON of numbers, also of numpy's."""
    from ._options import plain

    return json.dumps(plain("", value))

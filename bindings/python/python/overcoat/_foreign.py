"""Meshes of PyVista and Open3D as `Mesh`, by their attributes: neither has to be there.

PyVista: `PolyData`, whatever has a surface (`extract_surface`: grids and volumes), and `MultiBlock`. Polygons are cut into triangles from
their first corner. Colours are those of active scalars of three or four bytes; other scalars have no colours without a colour map, which
a warning says: `mesh.active_scalars = rgb` maps them. Texture coordinates count rows from below, as VTK's do.

Open3D: `TriangleMesh`, `PointCloud` and `LineSet` of `open3d.geometry`. Its colours are what its window shows: sRGB, 0 to 1. Its textures have
the row of v = 0 first in memory.
"""

from __future__ import annotations

from typing import Any, List, Optional, Tuple

from ._arrays import Mesh, array
from ._errors import MeshError


def meshes_of(source: Any) -> Optional[Tuple[List[Mesh], List[str]]]:
    """Meshes of what PyVista or Open3D made, and what they do not show; `None` of anything else."""
    warnings: List[str] = []
    if hasattr(source, "triangle_uvs") and hasattr(source, "triangles") and hasattr(source, "vertices"):
        return [_open3d_triangles(source)], warnings
    if hasattr(source, "points") and hasattr(source, "colors") and not hasattr(source, "point_data"):
        return [_open3d_points(source)], warnings
    if hasattr(source, "n_blocks") and hasattr(source, "keys"):
        meshes: List[Mesh] = []
        for number in range(source.n_blocks):
            block = source[number]
            if block is None:
                continue
            found = meshes_of(block)
            if found is None:
                raise MeshError(f"block {number}: a {type(block).__name__} is not drawn")
            name = source.get_block_name(number) if hasattr(source, "get_block_name") else None
            for mesh in found[0]:
                mesh.name = str(name or mesh.name)
            meshes.extend(found[0])
            warnings.extend(found[1])
        if not meshes:
            raise MeshError("the blocks are all empty")
        return meshes, warnings
    if hasattr(source, "point_data") and hasattr(source, "points"):
        surface = source if hasattr(source, "faces") else source.extract_surface() if hasattr(source, "extract_surface") else None
        return None if surface is None else (_pyvista(surface, warnings), warnings)
    return None


def _pyvista(mesh: Any, warnings: List[str]) -> List[Mesh]:
    import numpy as np

    vertices = array("points", mesh.points)
    faces = _polygons(array("faces", mesh.faces))
    if len(faces) == 0 and len(getattr(mesh, "strips", ())) > 0:
        faces = _polygons(array("faces", mesh.triangulate().faces))
    shared = {"colors": _scalars(mesh, len(vertices), warnings)}
    normals = mesh.point_data["Normals"] if "Normals" in mesh.point_data else None
    uv = getattr(mesh, "active_texture_coordinates", None)
    if uv is not None:
        uv = np.array(uv, dtype=np.float64)[:, :2]
        uv[:, 1] = 1 - uv[:, 1]
    found: List[Mesh] = []
    if len(faces) > 0:
        found.append(Mesh(vertices, faces, normals, uv, **shared))
    lines = _segments(array("lines", getattr(mesh, "lines", np.zeros(0, dtype=int))))
    if len(lines) > 0:
        found.append(Mesh(vertices, lines=lines, name="lines", **shared))
    return found or [Mesh(vertices, **shared)]


def _scalars(mesh: Any, count: int, warnings: List[str]) -> Any:
    """Colours of vertices."""
    import numpy as np

    scalars = getattr(mesh, "active_scalars", None)
    if scalars is None or getattr(mesh, "active_scalars_name", None) == "Normals":
        return None
    scalars = np.asarray(scalars)
    if scalars.dtype == np.uint8 and scalars.ndim == 2 and scalars.shape[1] in (3, 4) and len(scalars) == count:
        return scalars
    name = getattr(mesh, "active_scalars_name", None)
    warnings.append(f"scalars '{name}' are no colours of points, three or four bytes each: they are not drawn")
    return None


def _polygons(padded: Any) -> Any:
    """Triangles of VTK's list of polygons: the number of corners before each."""
    import numpy as np

    flat = padded.reshape(-1).astype(np.int64)
    if len(flat) % 4 == 0 and (flat[::4] == 3).all():
        return flat.reshape(-1, 4)[:, 1:]
    triangles: List[Any] = []
    for corners in _runs(flat, "faces"):
        if len(corners) >= 3:
            fan = np.column_stack([np.full(len(corners) - 2, corners[0]), corners[1:-1], corners[2:]])
            triangles.append(fan)
    return np.concatenate(triangles) if triangles else np.zeros((0, 3), dtype=np.int64)


def _segments(padded: Any) -> Any:
    """Pairs of VTK's list of polylines."""
    import numpy as np

    pairs = [np.column_stack([run[:-1], run[1:]]) for run in _runs(padded.reshape(-1).astype(np.int64), "lines")]
    return np.concatenate(pairs) if pairs else np.zeros((0, 2), dtype=np.int64)


def _runs(flat: Any, what: str) -> Any:
    at = 0
    while at < len(flat):
        count = int(flat[at])
        if count < 0 or at + 1 + count > len(flat):
            raise MeshError(f"{what}: {count} corners are said to follow where {len(flat) - at - 1} numbers are left")
        yield flat[at + 1 : at + 1 + count]
        at += 1 + count


def _codes(colors: Any, count: int) -> Any:
    """Bytes of colours from 0 to 1, of which there may be none."""
    import numpy as np

    found = np.asarray(colors)
    if len(found) != count or count == 0:
        return None
    return np.rint(np.clip(found, 0, 1) * 255).astype(np.uint8)


def _normals(normals: Any, count: int) -> Any:
    """Normals of vertices, of which there may be none."""
    import numpy as np

    found = np.asarray(normals)
    return found if len(found) == count and count > 0 else None


def _open3d_triangles(mesh: Any) -> Mesh:
    import numpy as np

    vertices, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    colors = _codes(mesh.vertex_colors, len(vertices))
    normals = _normals(mesh.vertex_normals, len(vertices))
    uvs, textures = np.asarray(mesh.triangle_uvs), list(getattr(mesh, "textures", ()))
    textures = [texture for texture in textures if np.asarray(texture).size > 0]
    if len(uvs) != 3 * len(triangles) or len(triangles) == 0 or not textures:
        return Mesh(vertices, triangles.reshape(-1, 3), normals, colors=colors)
    # Corners have texture coordinates of their own.
    corners = triangles.reshape(-1)
    return Mesh(
        vertices[corners],
        np.arange(len(corners)).reshape(-1, 3),
        None if normals is None else normals[corners],
        uvs,
        None if colors is None else colors[corners],
        texture=np.asarray(textures[0]),
    )


def _open3d_points(cloud: Any) -> Mesh:
    import numpy as np

    points = np.asarray(cloud.points)
    lines = np.asarray(cloud.lines) if hasattr(cloud, "lines") else None
    if lines is None:
        normals = _normals(getattr(cloud, "normals", ()), len(points))
        return Mesh(points, None, normals, colors=_codes(cloud.colors, len(points)))
    # Colours are those of lines.
    colors = _codes(cloud.colors, len(lines))
    if colors is None:
        return Mesh(points, lines=lines.reshape(-1, 2))
    ends = lines.reshape(-1)
    return Mesh(points[ends], lines=np.arange(len(ends)).reshape(-1, 2), colors=np.repeat(colors, 2, axis=0))

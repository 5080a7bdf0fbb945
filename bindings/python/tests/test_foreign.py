"""Meshes of PyVista and Open3D, by stand-ins with their attributes, and by the real ones where they are installed."""

from __future__ import annotations

import numpy as np
import pytest

import overcoat

CORNERS = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
VIEW = {"size": 40, "quality": "draft", "ground": "none", "camera": {"eye": [0, 0, 5], "target": [0, 0, 0], "ortho_height": 2.5}}


class PolyData:
    """As `pyvista.PolyData`."""

    def __init__(self, points, faces=(), lines=(), **point_data):
        self.points, self.faces, self.lines = np.asarray(points, float), np.asarray(faces, int), np.asarray(lines, int)
        self.point_data, self.active_scalars, self.active_scalars_name = point_data, None, None
        self.active_texture_coordinates, self.strips = None, np.zeros(0, int)


class Grid:
    def __init__(self, surface):
        self.points, self.point_data, self.surface = surface.points, {}, surface

    def extract_surface(self):
        return self.surface


class MultiBlock:
    def __init__(self, **blocks):
        self.blocks, self.n_blocks = blocks, len(blocks)

    def keys(self):
        return list(self.blocks)

    def __getitem__(self, number):
        return list(self.blocks.values())[number]

    def get_block_name(self, number):
        return list(self.blocks)[number]


class Open3D:
    """As what `open3d.geometry` has."""

    def __init__(self, **lists):
        for name, values in lists.items():
            setattr(self, name, values)


def triangle_mesh(**lists):
    empty = {name: [] for name in ("vertex_normals", "vertex_colors", "triangle_uvs", "textures")}
    return Open3D(**{**empty, "vertices": CORNERS, "triangles": [[0, 1, 2], [0, 2, 3]], **lists})


def draw(source, **options):
    return overcoat.render(source, **{**VIEW, **options})


def same(**arrays):
    return overcoat.render(vertices=CORNERS, **arrays, **VIEW).hash


def test_polygons_of_pyvista_are_triangles():
    expected = same(faces=[[0, 1, 2], [0, 2, 3]])
    assert draw(PolyData(CORNERS, [3, 0, 1, 2, 3, 0, 2, 3])).hash == expected
    quad = PolyData(CORNERS, [4, 0, 1, 2, 3])
    assert draw(quad).hash == expected and draw(Grid(quad)).hash == expected
    scene = overcoat.Scene()
    scene.add_model(quad)
    assert overcoat.render(scene, **VIEW).hash == expected
    quad.active_scalars, quad.active_scalars_name = np.arange(4.0), "heat"
    with pytest.warns(overcoat.OvercoatWarning, match="scalars 'heat' are no colours"):
        assert draw(quad).hash == expected
    rgb = np.array([[200, 0, 0], [0, 200, 0], [0, 0, 200], [9, 9, 9]], np.uint8)
    quad.active_scalars, quad.active_scalars_name = rgb, "rgb"
    assert draw(quad).hash == same(faces=[[0, 1, 2], [0, 2, 3]], colors=rgb)
    quad.active_texture_coordinates = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    texture = np.zeros((4, 4, 3), np.uint8)
    texture[:2] = [255, 0, 0]
    quad.active_scalars = None
    # The upper half is red.
    array = draw(quad, material={"base_color_texture": texture}).array
    assert array[12, 20, 0] > array[12, 20, 2] + 50 and abs(int(array[28, 20, 0]) - array[28, 20, 2]) < 20


def test_lines_points_and_blocks_of_pyvista():
    around = PolyData(CORNERS, lines=[5, 0, 1, 2, 3, 0])
    assert draw(around).hash == same(lines=[[0, 1], [1, 2], [2, 3], [3, 0]])
    assert draw(PolyData(CORNERS)).hash == same()
    blocks = MultiBlock(frame=around, plate=PolyData(CORNERS, [4, 0, 1, 2, 3]), nothing=None)
    assert draw(blocks, aov="object-id").ids["object-id"] == {1: "frame", 2: "plate"}
    with pytest.raises(overcoat.MeshError, match="9 corners are said to follow where 3"):
        draw(PolyData(CORNERS, [9, 0, 1, 2]))
    with pytest.raises(overcoat.MeshError, match="empty"):
        draw(MultiBlock(nothing=None))


def test_geometries_of_open3d():
    faces = [[0, 1, 2], [0, 2, 3]]
    assert draw(triangle_mesh()).hash == same(faces=faces)
    colors = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [0.2, 0.2, 0.2]])
    codes = np.rint(colors * 255).astype(np.uint8)
    assert draw(triangle_mesh(vertex_colors=colors)).hash == same(faces=faces, colors=codes)
    cloud = Open3D(points=CORNERS, colors=colors, normals=[])
    assert draw(cloud, point_size=5).hash == overcoat.render(vertices=CORNERS, colors=codes, point_size=5, **VIEW).hash
    lines = Open3D(points=CORNERS, lines=np.array([[0, 1], [2, 3]]), colors=[[1.0, 0, 0], [0, 0, 1.0]])
    array = draw(lines, line_width=3, shading="gltf").array
    assert array[36, 20, 0] > array[36, 20, 2] + 50 and array[4, 20, 2] > array[4, 20, 0] + 50
    texture = np.zeros((4, 4, 3), np.uint8)
    texture[:2] = [255, 0, 0]
    uvs = np.array([[0.0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]])
    array = draw(triangle_mesh(triangle_uvs=uvs, textures=[texture])).array
    # v = 0 is below here, and is the first row.
    assert array[28, 20, 0] > array[28, 20, 2] + 50 > array[12, 20, 0]


def test_the_real_ones():
    pyvista = pytest.importorskip("pyvista")
    assert (draw(pyvista.Sphere()).array[20, 20, 3] == 255).all()
    assert (draw(pyvista.ImageData(dimensions=(3, 3, 3))).array[..., 3] > 0).any()

"""Meshes of arrays."""

from __future__ import annotations

import numpy as np
import pytest

import overcoat

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
COLORS = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0]])


def draw(**arrays):
    return overcoat.render(size=32, **{"vertices": VERTICES, "faces": FACES, **arrays})


def test_types_and_layouts_change_nothing():
    expected = draw(vertices=VERTICES.astype(np.float32), faces=FACES.astype(np.uint32)).hash
    wide = np.zeros((4, 6))
    wide[:, ::2] = VERTICES
    for vertices in (VERTICES, VERTICES.tolist(), VERTICES.astype(np.float64), VERTICES.astype(np.float16), wide[:, ::2],
                     np.asfortranarray(VERTICES.astype(np.float32)), VERTICES.astype(">f4"), VERTICES.astype(np.int8)):
        assert draw(vertices=vertices).hash == expected
    for faces in (FACES.tolist(), FACES.astype(np.int8), FACES.astype(np.uint64), np.asfortranarray(FACES), FACES.astype(">i4")):
        assert draw(faces=faces).hash == expected


def test_arrays_are_copied_and_not_changed():
    vertices = VERTICES.astype(np.float32)
    model = overcoat.load(overcoat.Mesh(vertices, FACES))
    before = overcoat.render(model, size=32).hash
    vertices[:] = 0
    assert overcoat.render(model, size=32).hash == before


@pytest.mark.parametrize(
    "arrays, words",
    [
        ({"vertices": VERTICES[:, :2]}, "vertices: expected shape (N, 3), found (4, 2)"),
        ({"vertices": VERTICES.ravel()}, "vertices: expected shape (N, 3)"),
        ({"vertices": VERTICES * np.nan}, "position"),
        ({"vertices": VERTICES * 1e300}, "position"),
        ({"vertices": VERTICES * 1e20}, "position"),
        ({"vertices": VERTICES.astype(complex)}, "vertices: expected an array of numbers, found complex128"),
        ({"vertices": VERTICES.astype(object)}, "found object"),
        ({"vertices": [[0, 0, 0], [1]]}, "vertices"),
        ({"vertices": VERTICES.astype(bool)}, "found bool"),
        ({"faces": FACES + 1}, "vertex 4"),
        ({"faces": FACES - 1}, "-1 is no vertex"),
        ({"faces": FACES.astype(np.int64) + 2**40}, "is no vertex"),
        ({"faces": FACES.astype(float)}, "faces: expected whole numbers, found float64"),
        ({"faces": FACES[:, :2]}, "faces: expected shape (M, 3)"),
        ({"normals": VERTICES[:2]}, "normals"),
        ({"normals": np.full((4, 3), np.inf)}, "normal"),
        ({"uv": VERTICES}, "uv: expected shape (N, 2)"),
        ({"uv": VERTICES[:3, :2]}, "texture coordinates"),
        ({"colors": COLORS[:, :1]}, "colors: expected shape (N, 3) or (N, 4)"),
        ({"colors": COLORS * 2}, "sRGB, 0 to 255"),
        ({"colors": COLORS[:2]}, "colours has 2 elements for 4 vertices"),
        ({"texture": np.zeros((2, 2))}, None),
        ({"texture": np.zeros((2, 2, 5))}, "texture: expected shape"),
        ({"texture": np.zeros((0, 2, 3))}, "texture: expected shape"),
        ({"texture": "x"}, "texture"),
    ],
)
def test_what_is_no_mesh_is_said(arrays, words):
    if words is None:
        draw(**arrays)
        return
    with pytest.raises(overcoat.MeshError) as caught:
        draw(**arrays)
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_arrays_belong_together():
    with pytest.raises(overcoat.OptionError, match="faces: there are no vertices"):
        overcoat.render(faces=FACES)
    with pytest.raises(overcoat.OptionError, match="there is a model already"):
        overcoat.render(b"x", vertices=VERTICES)


def test_whole_colours_are_srgb_and_fractions_linear():
    white = np.ones((4, 3))
    assert draw(colors=white).hash == draw(colors=(white * 255).astype(np.uint8)).hash
    half = draw(colors=np.full((4, 3), 128, dtype=np.uint8)).linear[..., :3].max()
    assert half < draw(colors=white * 0.5).linear[..., :3].max()
    clear = draw(colors=np.array([[1.0, 1, 1, 0.5]] * 4), ground="none")
    assert 0.2 < clear.linear[..., 3].max() < 0.95


def test_a_texture_lies_as_in_gltf():
    texture = np.zeros((2, 2, 3), dtype=np.uint8)
    texture[0, 0] = [255, 0, 0]  # Upper left.
    texture[1, 1] = [0, 0, 255]  # Lower right.
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    uv = np.array([[0, 1], [1, 1], [1, 0], [0, 0]])
    image = overcoat.render(vertices=corners, faces=[[0, 1, 2], [0, 2, 3]], uv=uv, texture=texture, size=64, ground="none",
                            material=None, camera={"eye": [0.5, 0.5, 3], "target": [0.5, 0.5, 0], "fov_y_deg": 22})
    upper_left, lower_right = image.linear[14, 14], image.linear[50, 50]
    assert upper_left[0] > 5 * upper_left[2] and lower_right[2] > 5 * lower_right[0]


def test_meshes_have_places_materials_and_names():
    moved = np.eye(4)
    moved[0, 3] = 2
    red = overcoat.Mesh(VERTICES, FACES, material="candy-red")
    blue = overcoat.Mesh(VERTICES, FACES, material={"base_color": "#0000ff"}, transform=moved)
    model = overcoat.load([red, blue])
    assert model.materials == ["mesh", "mesh-2"] and model.triangles == 8
    assert model.bounds[1][0] == 3
    image = overcoat.render([red, blue], size=64, aov="object-id", ground="none")
    ids = image.aov["object-id"]
    assert set(np.unique(ids)) == {0, 1, 2}
    left, right = image.linear[ids == 1], image.linear[ids == 2]
    assert left[:, 0].mean() > left[:, 2].mean() and right[:, 2].mean() > right[:, 0].mean()
    again = overcoat.render([red, blue], size=64, materials={"mesh": {"base_color": "#00ff00"}})
    assert again.hash != image.hash
    for bad in (np.eye(3), np.eye(4) * np.nan):
        with pytest.raises(overcoat.MeshError):
            overcoat.render([overcoat.Mesh(VERTICES, FACES, transform=bad)])


def test_normals_are_smooth_but_for_creases():
    angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = np.column_stack([np.cos(angles), np.zeros(24), np.sin(angles)])
    vertices = np.concatenate([ring, ring + [0, 1, 0]])
    faces = [[i, 24 + i, (i + 1) % 24] for i in range(24)] + [[(i + 1) % 24, 24 + i, 24 + (i + 1) % 24] for i in range(24)]

    def normals(crease):
        mesh = overcoat.Mesh(vertices, faces, crease_deg=crease)
        image = overcoat.render(mesh, size=96, aov="normal", camera="front", samples=1, ground="none")
        found = image.aov["normal"][image.linear[..., 3] == 1]
        return len(np.unique(np.round(found, 3), axis=0))

    assert normals(40) > 3 * normals(0)


def test_points_need_no_faces():
    image = overcoat.render(vertices=np.random.RandomState(3).rand(200, 3), size=64, point_size=4, aov="depth")
    assert (image.aov["depth"] > 0).sum() > 500


def test_an_axis_may_be_up():
    tall = VERTICES * [1, 1, 5]
    assert draw(vertices=tall, up="+z").hash != draw(vertices=tall).hash
    with pytest.raises(overcoat.OptionError, match="up 'z'|up"):
        draw(up="sideways")
    with pytest.raises(overcoat.OptionError, match="only model files"):
        draw(animation="walk")


def test_nothing_is_a_model_too():
    with pytest.warns(overcoat.OvercoatWarning, match="nothing to see"):
        image = overcoat.render(vertices=np.zeros((0, 3)), faces=np.zeros((0, 3), dtype=int), size=16)
    assert image.array.max() == 0

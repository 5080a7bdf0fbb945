"""Materials of arrays: every parameter of the table, and textures that are arrays."""

from __future__ import annotations

import gc
import json
import subprocess
import sys

import numpy as np
import pytest

import overcoat
from overcoat import _kept

QUAD = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
FACES = np.array([[0, 1, 2], [0, 2, 3]])
UV = np.array([[0, 1], [1, 1], [1, 0], [0, 0]])


def draw(material, **options):
    arrays = {"vertices": QUAD, "faces": FACES, "uv": UV}
    return overcoat.render(**arrays, material=material, **{"size": 24, "quality": "draft", **options})


def noise(*shape):
    return np.random.default_rng(7).integers(0, 256, shape, dtype=np.uint8)


def test_every_parameter_of_the_table_is_one_of_arrays():
    done = subprocess.run([sys.executable, "-m", "overcoat", "materials", "--keys", "--json"], capture_output=True, text=True, check=True)
    keys = json.loads(done.stdout)["keys"]
    assert len(keys) > 100
    texture = noise(4, 4, 4)
    for key in keys:
        name, default = key["key"], key["default"]
        if key["takes"] == "texture":
            material = {name: texture}
        elif default is None:
            continue
        else:
            material = {name: json.loads(default)}
        if name.startswith("options."):
            material = {"options": {name.removeprefix("options."): json.loads(default)}}
        if name == "alpha_cutoff":
            material["alpha_mode"] = "mask"
        if name.endswith("normal_scale"):
            material[name.replace("scale", "texture")] = texture
        draw(material, size=8, samples=1)


def test_textures_are_arrays_as_they_are_files(tmp_path, monkeypatch):
    Image = pytest.importorskip("PIL.Image")
    monkeypatch.chdir(tmp_path)
    color, normal, grey = noise(8, 4, 3), noise(4, 4, 3) // 4 + 120, noise(5, 3)
    normal[..., 2] = 230
    for name, texels in (("color.png", color), ("normal.png", normal), ("grey.png", grey)):
        Image.fromarray(texels).save(tmp_path / name)

    def material(of):
        return {
            "base_color_texture": of("color.png", color),
            "normal_texture": {"file": of("normal.png", normal), "wrap": "clamp", "scale": [3, 2], "filter": "nearest"},
            "coat": 1,
            "coat_roughness_texture": of("grey.png", grey),
            "coat_roughness": 0.5,
        }

    files = draw(material(lambda name, texels: name)).hash
    assert draw(material(lambda name, texels: texels)).hash == files
    assert draw(material(lambda name, texels: texels.astype(np.float32) / 255)).hash == files
    assert draw(material(lambda name, texels: texels.tolist())).hash == files
    assert draw(material(lambda name, texels: Image.fromarray(texels))).hash == files
    scene = overcoat.Scene()
    scene.add_instance(scene.add_mesh(QUAD, FACES, uv=UV), scene.add_material({"base_color_texture": color}))
    before = overcoat.render(scene, size=24).hash
    scene.materials[0].assign({"over": True, "normal_texture": normal})
    assert overcoat.render(scene, size=24).hash != before


def test_a_texture_is_converted_once_and_again_when_it_changes():
    texture = noise(64, 64, 3)
    kept = len(_kept._texels)
    first = draw({"base_color_texture": texture}).hash
    made = _kept.texels_of("", texture)
    assert draw({"base_color_texture": texture}).hash == first
    assert _kept.texels_of("", texture) is made and len(_kept._texels) == kept + 1
    # A single number counts.
    texture[40, 10, 1] ^= 128
    assert draw({"base_color_texture": texture}).hash != first
    assert _kept.texels_of("", texture) is not made
    del texture
    gc.collect()
    assert len(_kept._texels) == kept


@pytest.mark.parametrize(
    "material, words",
    [
        ({"base_color_texture": np.zeros((2, 2, 2))}, "material.base_color_texture: expected shape (H, W, 3)"),
        ({"base_color_texture": np.zeros((0, 2, 3))}, "expected shape"),
        ({"normal_texture": {"file": np.zeros(3)}}, "material.normal_texture: expected shape"),
        ({"base_color_texture": np.zeros((2, 2, 3), dtype=complex)}, "expected an array of numbers"),
        ({"base_color_texture": "array/0"}, "array/0"),
        ({"base_color_texture": np.zeros((2, 2, 3)), "rougness": 1}, "roughness"),
        ({"coat_texture": {"file": np.zeros((2, 2, 3)), "channel": "x"}}, "'x' is not known"),
    ],
)
def test_what_is_no_texture_is_refused(material, words):
    with pytest.raises((overcoat.MeshError, overcoat.OptionError, overcoat.LoadError, OSError)) as error:
        draw(material)
    assert words in str(error.value)


def test_lines_are_as_wide_as_the_option():
    corners, around = QUAD * 0.9, [[0, 1], [1, 2], [2, 3], [3, 0]]
    options = {"size": 40, "ground": "none", "camera": {"eye": [0, 0, 5], "target": [0, 0, 0], "ortho_height": 2}}
    area = lambda *source, **arrays: overcoat.render(*source, **arrays, **options).linear[..., 3].sum()
    covered = [area(vertices=corners, lines=around, line_width=width) for width in (1, 4)]
    # Four sides of 36 pixels.
    assert 135 < covered[0] < 155 and 550 < covered[1] < 610
    assert area(overcoat.Mesh(corners, lines=around), line_width=4) == covered[1]
    scene = overcoat.Scene()
    scene.add_instance(scene.add_mesh(corners, lines=around), scene.add_material())
    assert abs(area(scene, line_width=4) - covered[1]) < 1
    with pytest.raises(overcoat.MeshError, match="lines: the mesh has faces"):
        overcoat.render(vertices=corners, lines=around, faces=FACES)
    with pytest.raises(overcoat.MeshError, match=r"lines: expected shape \(M, 2\)"):
        overcoat.render(vertices=corners, lines=FACES)


def splats(count=3, **changed):
    arrays = {
        "means": [[0.0, 0, 0]] * count,
        "scales": [[0.2, 0.2, 0.2]] * count,
        "rotations": [[0.0, 0, 0, 1]] * count,
        "opacities": [0.9] * count,
        "colors": [[1.0, 0, 0]] * count,
    }
    return overcoat.Splats(**{**arrays, **changed})


def test_splats_are_seen_and_beside_meshes():
    options = {"size": 40, "ground": "none", "camera": {"eye": [0, 0, 5], "target": [0, 0, 0], "ortho_height": 4}}
    array = overcoat.render(splats(), **options).array
    red, _, blue, alpha = array[20, 20]
    assert red > 240 and blue < 20 and alpha > 240 and array[2, 2, 3] == 0
    both = overcoat.render([overcoat.Mesh(QUAD + [0, 0, -1], FACES), splats()], aov="object-id", **options)
    assert both.array[20, 20, 0] > 200 and both.array[12, 12, 3] == 255
    assert both.ids["object-id"] == {1: "mesh", 2: "splats"}
    # Of degree 1: another colour from the other side.
    harmonics = np.zeros((3, 3, 3))
    harmonics[:, 1, 2] = 1.5
    sided = splats(colors=[[0.5, 0.5, 0.5]] * 3, harmonics=harmonics)
    front = overcoat.render(sided, **options).array[20, 20, 2]
    back = overcoat.render(sided, **{**options, "camera": {**options["camera"], "eye": [0, 0, -5]}}).array[20, 20, 2]
    assert abs(int(front) - int(back)) > 60


@pytest.mark.parametrize(
    "changed, words",
    [
        ({"opacities": [0.5, 0.5]}, "opacities: expected shape (3,)"),
        ({"opacities": [2.0] * 3}, "splat opacity"),
        ({"scales": [[1.0, 1, 1]]}, "3 means, but another array has 1 rows"),
        ({"rotations": [[0.0, 0, 1]] * 3}, "rotations: expected shape (N, 4)"),
        ({"rotations": [[0.0, 0, 0, 0]] * 3}, "rotation"),
        ({"means": [[np.nan, 0, 0]] * 3}, "splat position"),
        ({"harmonics": np.zeros((3, 4, 3))}, "harmonics: expected shape (N, K, 3) with K = 3, 8 or 15, found (3, 4, 3)"),
        ({"harmonics": np.zeros((3, 9))}, "harmonics: expected shape (N, K, 3)"),
    ],
)
def test_what_are_no_splats_is_refused(changed, words):
    with pytest.raises(overcoat.MeshError) as error:
        overcoat.render(splats(**changed), size=8)
    assert words in str(error.value)

"""`Scene` and its handles: whatever was changed, the picture is the one of a model that has always been so."""

from __future__ import annotations

import base64
import json
import struct
import warnings

import numpy as np
import pytest

import overcoat

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def moved(x, y=0.0, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def draw(source, **options):
    return overcoat.render(source, **{"size": 48, **options}).hash


def animated():
    """A glTF file whose only node goes from 0 to 2 metres to the right in a second, with a camera and a light."""
    arrays = [
        struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0),
        struct.pack("<2f", 0, 1),
        struct.pack("<6f", 0, 0, 0, 2, 0, 0),
    ]
    content, views = b"".join(arrays), []
    for array in arrays:
        views.append({"buffer": 0, "byteOffset": sum(view["byteLength"] for view in views), "byteLength": len(array)})
    return json.dumps(
        {
            "asset": {"version": "2.0"},
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 5}]}},
            "buffers": [
                {"byteLength": len(content), "uri": "data:application/octet-stream;base64," + base64.b64encode(content).decode()}
            ],
            "bufferViews": views,
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
                {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
                {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"},
            ],
            "materials": [{"name": "paint", "doubleSided": True}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
            "cameras": [{"type": "perspective", "name": "front", "perspective": {"yfov": 0.8, "znear": 0.1}}],
            "nodes": [
                {"mesh": 0},
                {"camera": 0, "name": "front", "translation": [0, 0, 5]},
                {"translation": [0, 1, 2], "extensions": {"KHR_lights_punctual": {"light": 0}}},
            ],
            "scenes": [{"nodes": [0, 1, 2]}],
            "scene": 0,
            "animations": [
                {
                    "name": "slide",
                    "samplers": [{"input": 1, "output": 2}],
                    "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                }
            ],
        }
    ).encode()


@pytest.mark.parametrize("name", ["sports-car.glb", "vase.ply", "torus-knot.obj", "rounded-cube.stl"])
def test_a_model_in_a_scene_is_the_model(model, name):
    path = model(name)
    for options in ({}, {"quality": "good", "camera": "front"}, {"env_rotation_deg": 40, "material": "candy-red"}):
        scene = overcoat.Scene()
        scene.add_model(path)
        assert draw(scene, **options) == draw(path, **options)
        loaded = overcoat.Scene()
        loaded.add_model(overcoat.load(path))
        assert draw(loaded, **options) == draw(path, **options)
    assert len(scene.models) == 1 and scene.models[0].instances == scene.instances


def test_meshes_of_arrays_and_of_trimesh_are_models_too():
    trimesh = pytest.importorskip("trimesh")
    mesh = overcoat.Mesh(VERTICES, FACES, material={"base_color": "#d02010", "coat": 1}, transform=moved(1))
    ball = trimesh.creation.icosphere()
    for source in (mesh, [mesh, overcoat.Mesh(VERTICES, FACES)], ball):
        scene = overcoat.Scene()
        scene.add_model(source)
        assert draw(scene) == draw(source)


def test_parts_that_are_put_together_are_the_mesh_that_has_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    overcoat.render(vertices=VERTICES, faces=FACES, size=16).save(tmp_path / "skin.png")
    uv = VERTICES[:, :2]
    for arrays, material in (
        ({}, None),
        ({"crease_deg": 0}, "candy-red"),
        ({"colors": np.linspace(0, 1, 12).reshape(4, 3)}, {"over": True, "base_color": [1, 1, 1], "coat": 1}),
        ({"uv": uv}, {"base_color_texture": "skin.png", "metallic": 1, "double_sided": True}),
    ):
        scene = overcoat.Scene()
        shape = scene.add_mesh(VERTICES, FACES, **arrays)
        made = scene.add_material(material)
        placed = scene.add_instance(shape, made, moved(0, 0, 2))
        assert draw(scene) == draw(overcoat.Mesh(VERTICES, FACES, material=material, transform=moved(0, 0, 2), **arrays)), material
        assert (placed.mesh, placed.material, placed.model) == (shape, made, None)
        assert (placed.transform == moved(0, 0, 2)).all() and placed.transform.dtype == np.float64


def test_what_is_changed_is_as_if_it_had_always_been_so():
    scene = overcoat.Scene()
    shape, red = scene.add_mesh(VERTICES, FACES), scene.add_material("candy-red")
    first, second = (scene.add_instance(shape, red, moved(x)) for x in (0.0, 3.0))
    sun = scene.add_light(type="directional", direction=[0, -1, -1], intensity=2)
    draw(scene)
    gold = {"base_color": "#ffd060", "metallic": 1}
    first.material = scene.add_material(gold)
    first.transform = moved(0, 1)
    second.mesh = scene.add_mesh(overcoat.Mesh(VERTICES * 2, FACES))
    sun.intensity, sun.color = 3, (1, 0.5, 0.25)
    assert sun.intensity == 3 and sun.color == (1, 0.5, 0.25)
    new = overcoat.Scene()
    new.add_instance(new.add_mesh(VERTICES, FACES), new.add_material(gold), moved(0, 1))
    new.add_instance(new.add_mesh(VERTICES * 2, FACES), new.add_material("candy-red"), moved(3))
    new.add_light({"type": "directional", "direction": [0, -1, -1], "intensity": 3, "color": [1, 0.5, 0.25]})
    assert draw(scene) == draw(new)
    # Hidden, replaced, and shown again.
    second.visible = False
    assert not second.visible and first.visible and draw(scene) != draw(new)
    first.mesh.replace(VERTICES * 3, FACES)
    first.material.assign("velvet")
    sun.assign(type="point", position=[0, 4, 0], intensity=9)
    third = overcoat.Scene()
    third.add_instance(third.add_mesh(VERTICES * 3, FACES), third.add_material("velvet"), moved(0, 1))
    third.add_light(type="point", position=[0, 4, 0], intensity=9)
    assert draw(scene) == draw(third)
    sun.remove()
    third.lights[0].remove()
    assert scene.lights == [] and draw(scene) == draw(third)
    second.visible = True
    first.remove()
    assert scene.instances == [second] and draw(scene) != draw(third)


def test_a_material_keeps_what_it_is_not_told(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    skin = "skin.png"
    overcoat.render(vertices=VERTICES, faces=FACES, size=16).save(skin)
    scene, new = overcoat.Scene(), overcoat.Scene()
    for each in (scene, new):
        each.add_mesh(VERTICES, FACES, uv=VERTICES[:, :2])
    made = scene.add_material({"base_color_texture": skin, "double_sided": True})
    shape = scene.add_mesh(VERTICES, FACES, uv=VERTICES[:, :2])
    scene.add_instance(shape, made)
    made.assign({"over": True, "coat": 1})
    both = {"base_color_texture": skin, "double_sided": True, "coat": 1}
    new.add_instance(new.add_mesh(VERTICES, FACES, uv=VERTICES[:, :2]), new.add_material(both))
    assert draw(scene) == draw(new)
    # Textures go with what reads them: their places are taken again.
    for _ in range(3):
        made.assign({"base_color": [1, 0, 0]})
        made.assign(both)
    assert draw(scene) == draw(new)
    with pytest.raises(ValueError, match="roughness"):
        made.assign({"roughness": 3})
    assert draw(scene) == draw(new)


def test_a_pose_is_the_model_at_that_time():
    content = animated()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = overcoat.Scene()
        handle = scene.add_model(content, moved(0, 0.5), animation="slide", format="gltf")
    assert handle.duration == 1 and len(handle.instances) == 1 and len(handle.lights) == 1
    part = handle.instances[0]
    camera = {"eye": [1, 1, 6], "target": [1, 0.5, 0]}
    for time in (0.0, 0.25, 1.0, 0.5):
        handle.pose(time)
        still = overcoat.Scene()
        still.add_model(overcoat.load(content, animation=0, time=time, format="gltf"), moved(0, 0.5))
        assert draw(scene, camera=camera) == draw(still, camera=camera)
        assert abs(part.transform[0, 3] - 2 * time) < 1e-6
    begun = overcoat.Scene().add_model(content, animation=0, time=0.5, format="gltf")
    assert (begun.instances[0].transform == part.transform).all()
    handle.transform = moved(0, 1.5)
    assert (handle.transform == moved(0, 1.5)).all()
    orbit = handle.cameras["front"]
    assert orbit.eye == pytest.approx((0, 1.5, 5))
    assert draw(scene, camera=orbit) != draw(scene, camera=camera)
    handle.visible = False
    assert not handle.visible and part.visible
    handle.visible = True
    handle.remove()
    assert scene.models == [] and scene.instances == [] and scene.lights == [] and scene.materials == []


def test_the_environment_is_as_of_a_picture(model, tmp_path):
    path = model("rounded-cube.glb")
    radiance = np.random.RandomState(0).rand(16, 32, 3).astype(np.float32)
    scene = overcoat.Scene()
    assert scene.environment == "studio"
    scene.add_model(path)
    for value in ("none", radiance, overcoat.Environment(radiance), "studio"):
        scene.environment = value
        assert draw(scene) == draw(path, env=value)
    scene.environment_rotation_deg, scene.environment_intensity = 70, 0.5
    assert (scene.environment_rotation_deg, scene.environment_intensity) == (70, 0.5)
    assert draw(scene) == draw(path, env_rotation_deg=70, env_intensity=0.5)
    scene.environment = radiance
    assert isinstance(scene.environment, overcoat.Environment)
    assert draw(scene) == draw(path, env=radiance, env_rotation_deg=70, env_intensity=0.5)
    # What a picture asks for is laid over what the scene has.
    assert draw(scene, env_intensity=2) == draw(path, env=radiance, env_rotation_deg=70, env_intensity=2)
    assert draw(scene, material="candy-red") == draw(path, env=radiance, env_rotation_deg=70, env_intensity=0.5, material="candy-red")
    assert draw(scene, env="none") != draw(scene)
    with pytest.raises(FileNotFoundError):
        scene.environment = tmp_path / "none.hdr"
    assert isinstance(scene.environment, overcoat.Environment)


def test_a_snapshot_stays(model):
    scene = overcoat.Scene()
    car = scene.add_model(model("rounded-cube.glb"))
    before, expected = scene.snapshot(), draw(scene)
    assert scene.snapshot() is before
    car.remove()
    assert draw(before) == expected and before.triangles > 0 and scene.snapshot().triangles == 0
    scene.add_model(before)
    assert draw(scene) == expected
    assert len(overcoat.turntable(scene, frames=2, size=16)) == 2


def test_handles_of_what_is_gone_or_elsewhere():
    scene, other = overcoat.Scene(), overcoat.Scene()
    shape, made = scene.add_mesh(VERTICES, FACES), scene.add_material()
    placed, sun = scene.add_instance(shape, made), scene.add_light(type="directional", direction=[0, -1, 0], intensity=1)
    car = scene.add_model(overcoat.Mesh(VERTICES, FACES))
    assert placed == scene.instances[0] and hash(placed) == hash(scene.instances[0]) and placed != shape
    with pytest.raises(overcoat.HandleError, match="in use, by instance 0"):
        shape.remove()
    with pytest.raises(LookupError, match="in use"):
        made.remove()
    with pytest.raises(overcoat.HandleError, match="the mesh is one of another world"):
        other.add_instance(shape, made)
    with pytest.raises(overcoat.HandleError, match="material: expected a MaterialHandle, found MeshHandle"):
        placed.material = shape
    [thing.remove() for thing in (placed, sun, car, shape, made)]
    for use in (
        lambda: placed.transform,
        lambda: setattr(placed, "transform", np.eye(4)),
        lambda: setattr(placed, "visible", True),
        lambda: placed.material,
        lambda: placed.remove(),
        lambda: sun.intensity,
        lambda: sun.remove(),
        lambda: car.instances,
        lambda: car.pose(0),
        lambda: made.name,
        lambda: made.assign("velvet"),
        lambda: shape.replace(VERTICES, FACES),
        lambda: scene.add_instance(shape, made),
    ):
        with pytest.raises(overcoat.HandleError, match="it has been removed"):
            use()
    # Places are used again, names are not.
    again = scene.add_mesh(VERTICES, FACES)
    assert again != shape
    with pytest.raises(overcoat.HandleError):
        shape.remove()


@pytest.mark.parametrize(
    "use, kind, words",
    [
        (lambda scene: scene.add_model("x.glb", np.eye(3)), ValueError, "transform: expected shape (4, 4), found (3, 3)"),
        (lambda scene: scene.add_model(VERTICES), overcoat.MeshError, "a model is a path"),
        (lambda scene: scene.add_model("x.glb", size=3), TypeError, "add_model() has no option 'size'"),
        (lambda scene: scene.add_model("none.glb"), FileNotFoundError, "none.glb"),
        (lambda scene: scene.add_model("none.glb", animation=0), FileNotFoundError, "none.glb"),
        (lambda scene: scene.add_model(overcoat.Mesh(VERTICES, FACES), animation=0), ValueError, "only model files"),
        (lambda scene: scene.add_model(animated(), animation="walk", format="gltf"), ValueError, "walk"),
        (lambda scene: scene.add_model(animated(), animation=0, material="velvet", format="gltf"), ValueError, "material"),
        (lambda scene: scene.add_model(animated(), format="gltf").pose(1), ValueError, "added without an animation"),
        (lambda scene: scene.add_model(animated(), animation=0, format="gltf").pose(-1), ValueError, "seconds"),
        (lambda scene: scene.add_mesh(VERTICES[:, :2], FACES), overcoat.MeshError, "vertices: expected shape (N, 3)"),
        (lambda scene: scene.add_mesh(VERTICES, FACES, texture=3), TypeError, "add_mesh() has no option 'texture'"),
        (lambda scene: scene.add_mesh(overcoat.Mesh(VERTICES, FACES, material="velvet")), ValueError, "material: a mesh of a scene"),
        (lambda scene: scene.add_material("candy-rad"), ValueError, "did you mean 'candy-red'"),
        (lambda scene: scene.add_material({"rough": 1}), ValueError, "rough"),
        (lambda scene: scene.add_light(type="area", intensity=1), ValueError, "'area' is no type of light"),
        (lambda scene: scene.add_light(type="point", intensity=1), ValueError, "needs the key position"),
        (lambda scene: scene.add_light(type="directional", direction=[0, 0, 0], intensity=1), ValueError, "light: its direction has no"),
        (lambda scene: setattr(scene, "environment", None), ValueError, "environment: expected a name"),
        (lambda scene: setattr(scene, "environment_intensity", "much"), ValueError, "environment_intensity: expected a number"),
        (lambda scene: setattr(scene, "environment_intensity", float("nan")), ValueError, "intensity"),
        (lambda scene: setattr(scene.add_model(overcoat.Mesh(VERTICES, FACES)), "transform", moved(1e15)), ValueError, ""),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(use, kind, words):
    scene = overcoat.Scene()
    with pytest.raises(kind) as caught:
        use(scene)
    assert words in str(caught.value) and "\n" not in str(caught.value)
    assert isinstance(caught.value, (overcoat.Error, OSError))
    assert scene.environment == "studio"

"""Scenes of the real trimesh, and its `save_image`."""

from __future__ import annotations

import io
import warnings

import numpy as np
import pytest

trimesh = pytest.importorskip("trimesh")
Image = pytest.importorskip("PIL.Image")

import overcoat  # noqa: E402
from overcoat.compat.trimesh import save_image  # noqa: E402


def pixels(png):
    return np.array(Image.open(io.BytesIO(png)).convert("RGBA"))


def test_a_model_of_trimesh_looks_as_through_its_exporter(model):
    """What trimesh has read of a file (it leaves out clear coats) has the same picture by arrays and by a GLB in memory."""
    scene = trimesh.load(model("sports-car.glb"))
    options = {"size": (160, 120), "quality": "draft", "ground": "none", "camera": {"view": [1, 0.5, 1]}}
    direct, exported = overcoat.render(scene, **options), overcoat.render(scene.export(file_type="glb"), **options)
    assert np.abs(direct.array.astype(int) - exported.array).mean() < 0.2
    original = overcoat.render(model("sports-car.glb"), **options)
    assert (direct.array[..., 3] == original.array[..., 3]).mean() > 0.99


def test_through_a_glb_it_looks_the_same():
    scene = trimesh.Scene([trimesh.creation.icosphere(subdivisions=3), trimesh.creation.box(extents=[1, 1, 1]).apply_translation([3, 0, 0])])
    scene.geometry["geometry_0"].visual.vertex_colors = [200, 40, 30, 255]
    direct = overcoat.render(scene, size=96, ground="none", aov="depth")
    exported = overcoat.render(scene.export(file_type="glb"), size=96, ground="none", aov="depth")
    assert np.abs(direct.aov["depth"] - exported.aov["depth"]).max() < 1e-3


def test_colours_of_faces_and_vertices():
    box = trimesh.creation.box()
    box.visual.face_colors = [[255, 0, 0, 255] if normal[2] > 0.5 else [0, 0, 255, 255] for normal in box.face_normals]
    view = {"camera": {"eye": [0, 0, 5], "target": [0, 0, 0]}, "size": 32, "ground": "none"}
    front = overcoat.render(box, **view).linear[16, 16]
    assert front[0] > 3 * front[2]
    back = overcoat.render(box, **{**view, "camera": {"eye": [0, 0, -5], "target": [0, 0, 0]}}).linear[16, 16]
    assert back[2] > 3 * back[0]
    ball = trimesh.creation.icosphere()
    ball.visual.vertex_colors = np.where(ball.vertices[:, :1] > 0, [255, 0, 0, 255], [0, 255, 0, 255]).astype(np.uint8)
    image = overcoat.render(ball, **view).linear
    assert image[16, 22, 0] > 3 * image[16, 22, 1] and image[16, 10, 1] > 3 * image[16, 10, 0]


def test_textures_lie_the_right_way_up():
    plane = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], process=False)
    texture = np.zeros((2, 2, 3), dtype=np.uint8)
    texture[0] = [255, 0, 0]  # Above.
    texture[1] = [0, 0, 255]
    uv = [[0, 0], [1, 0], [1, 1], [0, 1]]
    view = {"camera": {"eye": [0.5, 0.5, 3], "target": [0.5, 0.5, 0]}, "size": 48, "ground": "none"}
    for material in (
        trimesh.visual.material.SimpleMaterial(image=Image.fromarray(texture)),
        trimesh.visual.material.PBRMaterial(baseColorTexture=Image.fromarray(texture), metallicFactor=0.0),
    ):
        plane.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
        image = overcoat.render(plane, **view).linear
        assert image[14, 24, 0] > 3 * image[14, 24, 2] and image[34, 24, 2] > 3 * image[34, 24, 0]
        again = overcoat.render(trimesh.Scene(plane).export(file_type="glb"), **view).linear
        assert again[14, 24, 0] > 3 * again[14, 24, 2]


def test_places_cameras_points_and_paths():
    scene = trimesh.Scene()
    ball = trimesh.creation.icosphere()
    for x in (-3, 0, 3):
        scene.add_geometry(ball, transform=trimesh.transformations.translation_matrix([x, 0, 0]))
    found = overcoat.load(scene)
    assert found.triangles == 3 * len(ball.faces) and abs(found.bounds[1][0] - 4) < 1e-5
    scene.camera_transform = trimesh.transformations.translation_matrix([3, 0, 10])
    image = overcoat.render(scene, size=65, aov=["object-id", "depth"])
    assert abs(image.aov["depth"][32, 32] - 9) < 0.02  # The camera that was set.
    assert overcoat.render(scene, size=65, camera="front").hash != image.hash
    cloud = trimesh.PointCloud(np.random.RandomState(5).rand(100, 3), colors=np.full((100, 4), 255, dtype=np.uint8))
    assert overcoat.render(cloud, size=32, point_size=3).linear[..., 3].sum() > 50
    path = trimesh.load_path(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0.0]]))
    assert overcoat.render(path, size=32, line_width=2).linear[..., 3].sum() > 20


def test_save_image_takes_trimeshs_camera():
    scene = trimesh.Scene(trimesh.creation.box())
    png = pixels(save_image(scene, resolution=(92, 66)))
    assert png.shape == (66, 92, 4) and (png[..., 3] == 255).all() and (png[0, 0] == 255).all()
    assert (scene.camera.resolution == [92, 66]).all()
    # Rays of trimesh's camera meet the box where it is drawn. (The size is that of its fields of view, 60 and 45 degrees.)
    origins, rays, places = scene.camera_rays()
    hits = trimesh.creation.box().ray.intersects_any(origins, rays)
    drawn = (png[..., :3] != 255).any(axis=2)
    wanted = np.zeros((66, 92), dtype=bool)
    wanted[65 - places[:, 1], places[:, 0]] = hits
    assert (drawn != wanted).sum() < 60, (drawn != wanted).sum()
    assert pixels(save_image(scene)).shape[:2] == (66, 92)
    assert (pixels(save_image(scene, background=[255, 0, 0, 255]))[0, 0] == [255, 0, 0, 255]).all()
    assert pixels(save_image(scene, background=[0, 0, 0, 0]))[0, 0, 3] == 0
    assert save_image(scene, visible=True, material="candy-red") != save_image(scene)
    ball = trimesh.Scene(trimesh.creation.icosphere(subdivisions=1))
    assert save_image(ball, (32, 24), smooth=False) != save_image(ball, (32, 24))
    with pytest.warns(overcoat.MissingFeatureWarning, match="wireframe"):
        save_image(scene, flags={"wireframe": True})
    with pytest.warns(overcoat.MissingFeatureWarning, match="fixed"):
        save_image(scene, fixed=["a"])


def test_the_published_example_runs_with_another_import(tmp_path):
    """examples/offscreen_render.py of trimesh, but for the import, the model and the size."""
    from overcoat.compat import trimesh

    mesh = trimesh.creation.annulus(r_min=0.5, r_max=1.0, height=0.5)
    scene = mesh.scene()
    rotate = trimesh.transformations.rotation_matrix(angle=np.radians(10.0), direction=[0, 1, 0], point=scene.centroid)
    pictures = []
    for _ in range(4):
        camera_old, _geometry = scene.graph[scene.camera.name]
        camera_new = np.dot(rotate, camera_old)
        scene.graph[scene.camera.name] = camera_new
        pictures.append(scene.save_image(resolution=[96, 54], visible=True))
    assert len(set(pictures)) == 4 and all(pixels(png).shape == (54, 96, 4) for png in pictures)


def test_hostile_meshes_are_refused():
    mesh = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], process=False)
    mesh.vertices[0] = np.nan
    with pytest.raises(overcoat.MeshError):
        overcoat.render(mesh, size=16)
    mesh = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 7]], process=False, validate=False)
    with pytest.raises(overcoat.MeshError, match="vertex 7"):
        overcoat.render(mesh, size=16)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert overcoat.render(trimesh.Scene(), size=16).array.max() == 0


def test_geometries_are_converted_when_they_change(monkeypatch):
    from overcoat import _trimesh

    counts = [0]
    convert = _trimesh._Converter._convert

    def counted(*arguments):
        counts[0] += 1
        return convert(*arguments)

    monkeypatch.setattr(_trimesh._Converter, "_convert", counted)
    ball, box = trimesh.creation.icosphere(), trimesh.creation.box()
    ball.visual.vertex_colors = [200, 30, 30, 255]
    box.visual.face_colors = [30, 200, 30, 255]
    scene = trimesh.Scene([ball, box])
    draw = lambda: overcoat.render(scene, size=32, quality="draft").hash
    first = draw()
    assert counts == [2] and draw() == first and counts == [2]
    scene.graph.update(scene.graph.nodes_geometry[1], matrix=trimesh.transformations.translation_matrix([1, 0, 0]))
    moved = draw()
    assert moved != first and counts == [2]
    ball.vertices[3] *= 2
    spiked = draw()
    assert spiked != moved and counts == [3]
    box.visual.face_colors[:, 2] = 255
    assert draw() != spiked and counts == [4]
    kept = len(_trimesh._parts)
    del ball, box, scene, draw
    import gc

    gc.collect()
    assert len(_trimesh._parts) <= kept - 2

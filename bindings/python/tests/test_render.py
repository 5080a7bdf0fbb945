"""`render`, `Image`, `Renderer`, `turntable`."""

from __future__ import annotations

import io
import json
import pickle
import re
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import overcoat
from overcoat import _overcoat
from overcoat._option_types import PictureOptions
from overcoat._options import OWN, descriptions


#: Six metres before the model, half a metre high.
CLOSE = np.array([[1, 0, 0, 0], [0, 1, 0, 0.5], [0, 0, 1, 6], [0, 0, 0, 1]])


@pytest.mark.parametrize(
    "options, arguments",
    [
        ({}, []),
        ({"samples": 16, "quality": "good"}, ["--samples", "16", "--quality", "good"]),
        ({"shading": "openpbr", "env_rotation_deg": 30}, ["--shading", "openpbr", "--env-rotation", "30"]),
        ({"camera": "front", "background": "#204060"}, ["--view", "front", "--background", "#204060"]),
        ({"camera": {"eye": (3, 2, 4), "target": [0, 0.4, 0]}}, ["--eye", "3,2,4", "--target", "0,0.4,0"]),
        (
            {"camera": {"K": [[90, 0, 70.5], [0, 80, 30], [0, 0, 1]], "pose": CLOSE, "convention": "opengl"}},
            ["--intrinsics", "90,80,70.5,30", "--pose", "1,0,0,0,0,1,0,0.5,0,0,1,6,0,0,0,1", "--pose-convention", "opengl"],
        ),
        ({"material": "candy-red"}, ["--material", "candy-red"]),
        ({"exposure": "auto", "tone_mapping": "aces"}, ["--exposure", "auto", "--tone-map", "aces"]),
    ],
)
def test_the_command_draws_the_same_bits(model, command, tmp_path, options, arguments):
    image = overcoat.render(model("sports-car.glb"), size=(120, 80), **options)
    target = tmp_path / "car.png"
    done = command("render", model("sports-car.glb"), "--size", "120x80", "-o", str(target), "--json", *arguments)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["frame_hash"] == image.hash
    assert target.read_bytes() == image.png()


def test_a_picture_tells_its_camera_which_draws_it_again(model):
    path = model("sports-car.glb")
    for given, kind in (({}, "perspective"), ({"ortho_height": 0}, "orthographic"), ({"K": [90, 70, 10.5, 88], "far": 50}, "perspective")):
        image = overcoat.render(path, size=(90, 64), samples=1, camera=given, aov=["depth", "position"])
        told = image.camera
        assert (told.kind, told.width, told.height) == (kind, 90, 64) and told.near > 0
        assert told.far == given.get("far", np.inf)
        flip = np.diag([1.0, -1, -1, 1])
        assert np.allclose(told.world_to_camera @ told.camera_to_world @ flip, np.eye(4), atol=1e-12)
        seen = image.aov["depth"] > 0
        assert seen.sum() > 300
        apart = np.abs(told.unproject(image.aov["depth"]) - image.aov["position"])[seen]
        assert apart.max() < 1e-6 * image.aov["depth"].max()
        again = overcoat.render(path, size=(90, 64), samples=1, camera=told)
        assert np.abs(again.linear - image.linear).mean() < 1e-4
        if kind == "perspective":
            assert again.hash == image.hash
            # As a part of twice the pixels: the same picture, but larger.
            assert overcoat.render(path, size=(180, 128), camera=told).camera.K[0, 2] == 2 * told.K[0, 2]
    with pytest.raises(ValueError, match="expected shape"):
        image.camera.unproject(np.zeros((3, 3)))


@pytest.mark.parametrize(
    "camera, message",
    [
        ({"K": np.zeros((3, 3))}, "K[2][2] is 0, expected 1"),
        ({"K": [[-1, 0, 2], [0, 5, 2], [0, 0, 1]]}, "fx is -1"),
        ({"K": [[50, 0, 2], [0, 50, 2]]}, "expected 3 rows of 3 numbers"),
        ({"K": np.full((3, 3), np.nan)}, "expected a finite number"),
        ({"pose": np.eye(3), "convention": "opencv"}, "expected 4 rows of 4 numbers"),
        ({"pose": 2 * np.eye(4) - np.diag([0, 0, 0, 1]), "convention": "opencv"}, "it scales"),
        ({"pose": np.eye(4)}, "pose needs convention"),
        ({"pose": np.eye(4), "convention": "opencv", "eye": [0, 0, 1]}, "pose and eye contradict"),
        ({"K": [50, 50, 2, 2], "fov_y_deg": 20}, "K and fov_y_deg contradict"),
    ],
)
def test_cameras_that_are_none_say_why(model, camera, message):
    with pytest.raises(overcoat.OptionError, match=re.escape(message)):
        overcoat.render(model("rounded-cube.glb"), size=32, camera=camera)


@pytest.mark.parametrize("name", ["rounded-cube.stl", "torus-knot.obj", "vase.ply", "draped-cloth.glb"])
def test_a_path_bytes_and_a_file_are_the_same_model(model, name):
    path = model(name)
    expected = overcoat.render(path, size=48).hash
    assert overcoat.render(Path(path), size=48).hash == expected
    if not name.endswith(".obj"):  # Its materials are beside it.
        content = Path(path).read_bytes()
        assert overcoat.render(content, size=48).hash == expected
        assert overcoat.render(memoryview(content), size=48).hash == expected
        assert overcoat.render(io.BytesIO(content), size=48).hash == expected
    if not name.endswith(".obj"):
        with open(path, "rb") as file:
            assert overcoat.render(file, size=48).hash == expected
    assert overcoat.render(overcoat.load(path), size=48).hash == expected


def test_arrays_are_views_that_cannot_be_written_to(model):
    image = overcoat.render(model("rounded-cube.glb"), size=(64, 32), aov=["depth", "normal", "object-id"])
    assert (image.width, image.height) == (64, 32)
    assert image.array.shape == (32, 64, 4) and image.array.dtype == np.uint8
    assert image.linear.shape == (32, 64, 4) and image.linear.dtype == np.float32
    for array in (image.array, image.linear, image.aov["depth"]):
        assert not array.flags.writeable and not array.flags.owndata
        with pytest.raises(ValueError):
            array.flags.writeable = True
    assert image.array.ctypes.data == image.array.ctypes.data
    assert np.shares_memory(image.linear, image.linear)
    assert image.aov["depth"].shape == (32, 64) and image.aov["normal"].shape == (32, 64, 3)
    with pytest.raises(KeyError, match="was not drawn"):
        image.aov["uv"]
    covered = image.linear[:, :, 3] == 1
    lengths = np.linalg.norm(image.aov["normal"][covered & (image.aov["depth"] > 0)], axis=1)
    assert abs(np.median(lengths) - 1) < 1e-3
    assert np.asarray(image).dtype == np.uint8 and np.asarray(image, dtype=np.float32).dtype == np.float32
    assert np.array(image).flags.writeable


def test_arrays_outlive_their_picture(model):
    array = overcoat.render(model("rounded-cube.glb"), size=32).linear
    kept = array.copy()
    for _ in range(20):  # Whose memory the next pictures would take.
        overcoat.render(model("rounded-cube.glb"), size=32, camera="front", background="#ff0000")
    assert (array == kept).all()


def test_files_are_written_by_their_extension(model, tmp_path):
    image = overcoat.render(model("rounded-cube.glb"), size=32, aov="depth")
    starts = {"png": b"\x89PNG", "jpg": b"\xff\xd8", "webp": b"RIFF", "exr": b"\x76\x2f\x31\x01", "hdr": b"#?RADIANCE"}
    for extension, start in starts.items():
        path = tmp_path / f"x.{extension}"
        image.save(path)
        assert path.read_bytes().startswith(start)
        assert path.read_bytes() == image.encode(extension)
    assert image._repr_png_() == image.png()
    with pytest.raises(overcoat.OptionError, match="x.tga"):
        image.save(tmp_path / "x.tga")
    with pytest.raises(FileNotFoundError):
        image.save(tmp_path / "nowhere" / "x.png")


def test_the_default_picture_is_that_of_every_door(model):
    expected = (Path(__file__).parents[3] / "tests/default-picture.txt").read_text().split()
    assert overcoat.render(model("rounded-cube.glb"), size=(96, 64)).hash == expected[2]


def test_every_option_has_a_type():
    assert set(PictureOptions.__annotations__) == set(descriptions())
    schema = set(json.loads(_overcoat.scene_schema())["properties"])
    assert set(descriptions()) - schema == set(OWN)
    assert "depth" in descriptions()["aov"]
    for name in descriptions():
        assert f"    {name}: " in overcoat.Options.__doc__


@pytest.mark.parametrize(
    "options, kind, words",
    [
        ({"sample": 4}, TypeError, "did you mean 'samples'?"),
        ({"xyzzy": 4}, TypeError, "known are"),
        ({"samples": 3}, ValueError, "1, 4, 8 or 16"),
        ({"size": 0}, ValueError, "size"),
        ({"size": float("nan")}, ValueError, "size: expected a finite number"),
        ({"size": (10, -1)}, ValueError, "size"),
        ({"size": object()}, ValueError, "size: a value of type 'object'"),
        ({"size": 10**9}, overcoat.LimitError, "output_side"),
        ({"shading": "opengl"}, ValueError, "shading"),
        ({"camera": {"eye": [0, 0]}}, ValueError, "camera.eye: expected"),
        ({"camera": {"view": [0, 0]}}, ValueError, "view"),
        ({"camera": {"eye": [0, 0, 0], "target": [0, 0, 0]}}, ValueError, "camera"),
        ({"camera": {"camera": "left eye"}}, ValueError, "there is no camera"),
        ({"material": "candy-rad"}, ValueError, "did you mean 'candy-red'"),
        ({"material": {"base_colour": 1}}, ValueError, "base_col"),
        ({"materials": {"nothing": {"coat": 1}}}, ValueError, "nothing"),
        ({"aov": ["dept"]}, ValueError, "known are depth"),
        ({"limits": {"triangle": 1}}, ValueError, "triangles"),
        ({"limits": {"triangles": -1}}, ValueError, "whole number"),
        ({"limits": {"triangles": 1}}, overcoat.LimitError, "triangles"),
        ({"env": "no such.hdr"}, FileNotFoundError, "no such.hdr"),
        ({"time": 1.0}, ValueError, "animation"),
        ({"animation": "walk"}, ValueError, "animation"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(model, options, kind, words):
    with pytest.raises(kind, match=None) as caught:
        overcoat.render(model("rounded-cube.glb"), **options)
    assert words in str(caught.value) and "\n" not in str(caught.value)
    assert isinstance(caught.value, (overcoat.Error, OSError)) and "line 1" not in str(caught.value)


def test_sources_that_are_none(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        overcoat.render(tmp_path / "none.glb")
    assert caught.value.filename == str(tmp_path / "none.glb")
    with pytest.raises(OSError, match="it is a folder"):
        overcoat.render(tmp_path)
    for content in (b"", b"hello", b"glTF\x02\0\0\0", bytes(1000)):
        with pytest.raises(overcoat.LoadError):
            overcoat.render(content)
    with pytest.raises(overcoat.MeshError, match="not a int"):
        overcoat.render(7)
    with pytest.raises(overcoat.OptionError, match="no model"):
        overcoat.render()
    with pytest.raises(overcoat.OptionError, match="no such format"):
        overcoat.render(b"x", format="blend")


def test_a_limit_has_its_name(model):
    with pytest.raises(overcoat.LimitError) as caught:
        overcoat.render(model("sports-car.glb"), limits={"triangles": 100})
    error = pickle.loads(pickle.dumps(caught.value))
    assert (error.field, error.limit) == ("triangles", 100) and error.asked > 100


def test_options_are_checked_and_pickled(tmp_path, model):
    options = overcoat.Options(size=(40, 30), samples=1, camera={"view": "front"}, material={"coat": 1.0})
    again = pickle.loads(pickle.dumps(options))
    assert again == options and isinstance(again, overcoat.Options)
    assert overcoat.render(model("vase.glb"), **again).hash == overcoat.render(model("vase.glb"), **options).hash
    with pytest.raises(overcoat.OptionError):
        overcoat.Options(samples=5)
    with pytest.raises(overcoat.UnknownOptionError):
        overcoat.Options(simples=4)
    file = tmp_path / "picture.toml"
    file.write_text(f"model = '{model('vase.glb')}'\nsize = [40, 30]\nsamples = 1\n[camera]\nview = 'front'\n")
    opened = overcoat.Options.open(file)
    assert opened["size"] == [40, 30]
    plain = overcoat.render(model("vase.glb"), size=(40, 30), samples=1, camera="front")
    assert overcoat.render(**opened).hash == plain.hash


def test_warnings_are_of_python_and_of_the_picture(model):
    with pytest.warns(overcoat.OvercoatWarning, match="nothing to see") as caught:
        image = overcoat.render(model("vase.glb"), size=16, camera={"eye": [0, 0, 50], "target": [0, 0, 100]})
    assert any("nothing to see" in message for message in image.warnings)
    assert caught[0].filename == __file__
    with pytest.warns(overcoat.OvercoatWarning, match="velvet has no") as caught:
        overcoat.Renderer(1).render(model("material-ball.glb"), size=16, shading="velvet")
    assert caught[0].filename == __file__


def test_an_environment_is_an_array_or_is_kept(model):
    sky = np.zeros((16, 32, 3), dtype=np.float64)
    sky[:8] = [0.2, 0.5, 1.0]
    kept = overcoat.Environment(sky.astype(np.float32))
    assert kept.shape == (16, 32)
    by_array = overcoat.render(model("vase.glb"), size=32, env=sky)
    assert overcoat.render(model("vase.glb"), size=32, env=kept).hash == by_array.hash
    assert overcoat.render(model("vase.glb"), size=32).hash != by_array.hash
    brighter = overcoat.render(model("vase.glb"), size=32, env=kept, env_intensity=2)
    assert brighter.linear[..., :3].max() > 1.9 * by_array.linear[..., :3].max()
    for bad in (sky[..., :2], sky * np.nan, (sky * 255).astype(np.uint8), sky[:0]):
        with pytest.raises(overcoat.MeshError):
            overcoat.render(model("vase.glb"), size=32, env=bad)


def test_a_renderer_reads_changed_files_again(model, tmp_path):
    material = tmp_path / "paint.toml"
    renderer, shape = overcoat.Renderer(1), overcoat.load(model("vase.glb"))
    material.write_text("base_color = '#ff0000'\n")
    first = renderer.render(shape, size=24, material=material)
    assert renderer.render(shape, size=24, material=str(material)).hash == first.hash
    material.write_text("base_color = '#0000ff' # changed\n")
    second = renderer.render(shape, size=24, material=material)
    assert second.hash != first.hash
    assert second.hash == overcoat.render(model("vase.glb"), size=24, material={"base_color": "#0000ff"}).hash
    for threads, size in ((1, 16), (3, 32)):
        other = overcoat.Renderer(threads, tile_size=size, simd="scalar" if size == 16 and _has_scalar() else None)
        assert other.threads == threads
        assert other.render(shape, size=24, material=material).hash == second.hash


def _has_scalar() -> bool:
    try:
        return bool(overcoat.Renderer(1, simd="scalar"))
    except overcoat.OptionError:
        return False


def test_help_has_units_and_shapes():
    stub = Path(overcoat.__file__).with_name("_overcoat.pyi").read_text()
    for kind in (overcoat.Image, overcoat.Model, overcoat.Environment):
        assert len(kind.__doc__) > 40
        for name in vars(kind):
            if not name.startswith("_"):
                text = vars(kind)[name].__doc__
                assert text, (kind, name)
                assert text.split("\n")[0][:60] in stub or name in ("array", "linear", "aov"), (kind, name)
    for function in (overcoat.render, overcoat.turntable, overcoat.load, overcoat.golden.check):
        assert "Args:" in function.__doc__


def test_memory_that_is_not_there_is_a_limit(model):
    """Where the process may have no more, an allocation that fails would end it."""
    code = f"""
import resource, overcoat
model = overcoat.load({model("rounded-cube.glb")!r})
overcoat.render(model, size=16)
resource.setrlimit(resource.RLIMIT_AS, (3 << 29, 3 << 29))
try:
    overcoat.render(model, size=8192, limits={{"output_pixels": 1 << 30}})
except overcoat.LimitError as error:
    print(error.field)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.strip() == "memory", done.stdout + done.stderr


def test_settings_of_a_renderer_are_checked():
    for settings in ({"threads": 257}, {"tile_size": 33}, {"simd": "mmx"}):
        with pytest.raises(overcoat.OptionError, match=next(iter(settings)).replace("_", " ")):
            overcoat.Renderer(**settings)


def test_a_model_is_loaded_once(model):
    shape = overcoat.load(model("sports-car.glb"))
    assert shape.triangles > 1000 and len(shape.materials) > 1
    low, high = shape.bounds
    assert all(a < b for a, b in zip(low, high))
    with pytest.raises(overcoat.OptionError, match="loaded already"):
        overcoat.render(shape, up="+z")
    with pytest.raises(TypeError, match="did you mean 'animation'"):
        overcoat.load(model("vase.glb"), animations="x")
    turned = overcoat.load(model("rounded-cube.stl"), up="+x")
    assert overcoat.render(turned, size=16).hash != overcoat.render(model("rounded-cube.stl"), size=16).hash
    assert "triangles" in repr(shape)


def test_a_turntable_is_that_of_the_command(model, command, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        movie = overcoat.turntable(model("vase.glb"), frames=4, size=48)
    assert len(movie) == 4 and len(movie[1:]) == 3 and len({image.hash for image in movie}) == 4
    for extension in ("png", "webp", "gif"):
        ours, theirs = tmp_path / f"a.{extension}", tmp_path / f"b.{extension}"
        movie.save(ours, fps=8)
        done = command("turntable", model("vase.glb"), "--frames", "4", "--fps", "8", "--size", "48", "-o", str(theirs))
        assert done.returncode == 0, done.stderr
        assert ours.read_bytes() == theirs.read_bytes()
    under = overcoat.turntable(model("vase.glb"), frames=4, size=48, turn="camera")
    assert under[0].hash == movie[0].hash and under[1].hash != movie[1].hash
    for bad in ({"frames": 0}, {"frames": 10**6}, {"turn": "light"}):
        with pytest.raises(overcoat.Error):
            overcoat.turntable(model("vase.glb"), **{"frames": 2, **bad})
    with pytest.raises(overcoat.OptionError, match="png, apng, webp and gif"):
        movie.save(tmp_path / "a.bmp")
    with pytest.raises(overcoat.OptionError, match="fps"):
        movie.encode("png", fps=0)

"""`Viewport` and `Orbit`: pictures in the caller's own memory, which are those of `render`."""

from __future__ import annotations

import datetime
import multiprocessing
import threading
import time
import weakref

import numpy as np
import pytest

import overcoat

SIZE = (72, 56)


@pytest.fixture
def scene(model):
    scene = overcoat.Scene()
    scene.add_model(model("material-ball.glb"))
    return scene


def blank(dtype=np.uint8, size=SIZE):
    return np.full((size[1], size[0], 4), 7, dtype)


@pytest.mark.parametrize("options", [
    {}, {"quality": "draft"}, {"quality": "good", "samples": 4}, {"background": "#304050", "exposure": 1.5},
    {"exposure": "auto", "quality": "draft"}, {"ground": "none", "tone_mapping": "aces"}, {"background": "env"},
])
def test_the_picture_is_that_of_render(scene, options):
    expected = overcoat.render(scene, size=SIZE, camera="front", **options)
    viewport = overcoat.Viewport(size=SIZE, **options)
    shown, linear = blank(), blank(np.float32)
    drawn = viewport.draw(scene, "front", shown)
    assert drawn.array is shown and (shown == expected.array).all()
    assert (drawn.quality, drawn.is_final) == (viewport.quality, True) and drawn.exposure == expected.exposure
    viewport.draw(scene, "front", linear)
    assert (linear == expected.linear).all()
    assert (viewport.draw(scene, "front").array == expected.array).all()


def test_formats_are_the_same_picture(scene):
    viewport = overcoat.Viewport(size=SIZE, quality="draft")
    expected = viewport.draw(scene).array
    alpha = expected[..., 3:].astype(int)
    over = np.concatenate([(expected[..., :3] * alpha + 127) // 255, alpha], axis=2)
    found = {name: viewport.draw(scene, format=name).array for name in ("bgra8", "rgba8-premultiplied", "bgra8-premultiplied")}
    assert (found["bgra8"] == expected[..., [2, 1, 0, 3]]).all()
    assert (found["rgba8-premultiplied"] == over).all()
    assert (found["bgra8-premultiplied"] == over[..., [2, 1, 0, 3]]).all()
    straight, product = (viewport.draw(scene, format=name).array for name in ("rgba-f32", "rgba-f32-premultiplied"))
    assert np.allclose(straight[..., :3] * straight[..., 3:], product[..., :3], atol=1e-5) and (straight != product).any()
    viewport.configure(background="#000000")
    opaque = viewport.draw(scene).array.astype(np.uint32)
    words = viewport.draw(scene, format="xrgb8").array
    assert words.shape == (SIZE[1], SIZE[0]) and words.dtype == np.uint32
    assert (words == opaque[..., 0] << 16 | opaque[..., 1] << 8 | opaque[..., 2]).all()


def test_memory_is_written_in_place_and_nothing_else_of_it(scene):
    viewport = overcoat.Viewport(size=SIZE, quality="draft")
    expected = viewport.draw(scene).array
    width, height = SIZE
    # The memory is not numpy's own.
    memory = bytearray(4 * width * height)
    viewport.draw(scene, out=np.frombuffer(memory, np.uint8).reshape(height, width, 4))
    assert bytes(memory) == expected.tobytes()
    # Rows of a part of a larger array.
    large = np.full((height + 9, width + 11, 4), 7, np.uint8)
    viewport.draw(scene, out=large[4 : 4 + height, 5 : 5 + width])
    assert (large[4 : 4 + height, 5 : 5 + width] == expected).all()
    large[4 : 4 + height, 5 : 5 + width] = 7
    assert (large == 7).all()
    every_other = np.full((2 * height, width, 4), 7, np.float32)
    viewport.draw(scene, out=every_other[::2])
    assert (every_other[1::2] == 7).all() and (every_other[::2] == viewport.draw(scene, format="rgba-f32-premultiplied").array).all()
    # Memory that is not aligned.
    odd = np.zeros(16 * width * height + 1, np.uint8)[1:].view(np.float32).reshape(height, width, 4)
    viewport.draw(scene, out=odd)
    assert (odd == every_other[::2]).all()
    # A part of the picture.
    part = blank(size=(20, 10))
    viewport.draw(scene, out=part, region=(30, 25, 20, 10))
    assert (part == expected[25:35, 30:50]).all()
    tiny = blank(size=(1, 1))
    viewport.draw(scene, out=tiny, region=(36, 28, 1, 1))
    assert (tiny[0, 0] == expected[28, 36]).all()


@pytest.mark.parametrize(
    "out, options, words",
    [
        ([1, 2], {}, "out: expected a numpy array, found list"),
        (blank(np.float64), {}, "out: expected (H, W, 4) uint8 or float32, or (H, W) uint32, found (56, 72, 4) float64"),
        (blank(">f4"), {}, "found (56, 72, 4) >f4"),
        (blank()[..., :3], {}, "out: expected shape (56, 72, 4), found (56, 72, 3)"),
        (blank().swapaxes(0, 1), {}, "out: expected shape (56, 72, 4), found (72, 56, 4)"),
        (blank()[..., 0], {}, "found (56, 72) uint8"),
        (blank()[::-1], {}, "rows from the top on; found strides of (-288, 4, 1) bytes"),
        (blank()[:, ::-1], {}, "found strides of (288, -4, 1)"),
        (blank()[..., ::-1], {}, "found strides of (288, 4, -1)"),
        (np.asfortranarray(blank()), {}, "its pixels must follow each other"),
        (blank(size=(144, 56))[:, ::2], {}, "found strides of (576, 8, 1)"),
        (np.lib.stride_tricks.as_strided(blank(), (56, 72, 4), (8, 4, 1)), {}, "found strides of (8, 4, 1)"),
        (np.broadcast_to(blank(), (56, 72, 4)), {}, "out: the array cannot be written to"),
        (np.frombuffer(bytes(4 * 72 * 56), np.uint8).reshape(56, 72, 4), {}, "out: the array cannot be written to"),
        (blank(), {"format": "rgba-f32"}, "format 'rgba-f32': expected, of uint8, one of rgba8, "),
        (blank(), {"region": (0, 0, 10, 10)}, "out: expected shape (10, 10, 4), found (56, 72, 4)"),
        (blank(size=(10, 10)), {"region": (66, 0, 10, 10)}, "region: 10 x 10 at 66, 0 of 72 x 56"),
        (blank(size=(10, 10)), {"region": (-1, 0, 10, 10)}, "region: expected (x, y, width, height)"),
        (blank(size=(10, 10)), {"region": (0, 0, 0, 10)}, "region: expected (x, y, width, height)"),
        (blank(), {"camera": {"eye": [0, 0]}}, "camera.eye"),
        (blank(), {"camera": 3}, "camera"),
    ],
)
def test_what_does_not_fit_is_said_and_nothing_is_drawn(scene, out, options, words):
    before = np.copy(out)
    viewport = overcoat.Viewport(size=SIZE, quality="draft")
    with pytest.raises(ValueError) as caught:
        viewport.draw(scene, out=out, **options)
    assert words in str(caught.value) and isinstance(caught.value, overcoat.Error)
    assert (np.asarray(out) == before).all()
    viewport.draw(scene)


@pytest.mark.parametrize("options, kind, words", [
    ({"maps": 3}, TypeError, "Viewport() has no option 'maps'"),
    ({"env": "none"}, TypeError, "Viewport() has no option 'env'"),
    ({"sise": 3}, TypeError, "did you mean 'size'?"),
    ({"quality": "superb"}, ValueError, "quality"),
    ({"budget": 1.5}, ValueError, "budget: expected units of work"),
    ({"budget": datetime.timedelta(-1)}, ValueError, "budget: expected a time"),
    ({"size": 10**9}, overcoat.LimitError, "output_side"),
])
def test_options_that_are_none(scene, options, kind, words):
    with pytest.raises(kind) as caught:
        overcoat.Viewport(**options)
    assert words in str(caught.value)
    viewport = overcoat.Viewport(size=SIZE, quality="draft")
    with pytest.raises(kind):
        viewport.configure(**options)
    assert viewport.size == SIZE and viewport.quality == "draft" and viewport.budget is None


def test_it_is_refined_tier_by_tier_until_something_changes(scene):
    viewport, out = overcoat.Viewport(size=SIZE, quality="good"), blank()
    orbit = overcoat.Orbit.around(scene, SIZE[0] / SIZE[1])
    for _ in range(2):
        tiers = []
        while True:
            better = viewport.refine(scene, orbit, out)
            if better is None:
                break
            tiers.append((better.quality, better.is_final))
        assert tiers == [("draft", False), ("fast", False), ("good", True)]
        assert (out == overcoat.render(scene, size=SIZE, quality="good", camera=orbit).array).all()
        before = out.copy()
        assert viewport.refine(scene, orbit, out) is None and (out == before).all()
        orbit.turn(20, 10)
    scene.instances[0].visible = False
    assert viewport.refine(scene, orbit, out).quality == "draft"


def test_a_budget_of_work_decides_how_well_it_is_drawn(scene):
    viewport = overcoat.Viewport(size=SIZE, quality="good", budget=1)
    drawn = [viewport.draw(scene) for _ in range(4)][-1]
    assert (drawn.quality, drawn.samples, drawn.scale) == ("draft", 4, 4)
    viewport.budget = 10**12
    viewport.draw(scene)
    assert viewport.draw(scene).quality == "good"
    viewport.budget = datetime.timedelta(microseconds=1)
    viewport.draw(scene)
    assert viewport.draw(scene).quality == "draft"
    viewport.budget = None
    assert viewport.draw(scene).is_final
    viewport.size, viewport.quality = (8, 4), "fast"
    drawn = viewport.draw(scene)
    assert drawn.array.shape == (4, 8, 4) and drawn.quality == "fast"


def test_what_is_seen_in_a_pixel(scene):
    viewport = overcoat.Viewport(size=SIZE, quality="draft")
    camera = {"eye": [0, 1, 6], "target": [0, 0.5, 0]}
    viewport.draw(scene, camera)
    image = overcoat.render(scene, size=SIZE, quality="draft", camera=camera, aov=["depth", "object-id"])
    hits = 0
    for x, y in ((36, 28), (40, 20), (30, 40), (0, 0)):
        hit = viewport.pick(scene, x, y, camera)
        assert (hit is None) == (image.aov["object-id"][y, x] == 0)
        if hit is None:
            continue
        hits += 1
        assert hit.instance in scene.instances and abs(sum(hit.barycentric) - 1) < 1e-5 and not hit.back_facing
        assert hit.depth == pytest.approx(image.aov["depth"][y, x], abs=0.05)
        assert np.linalg.norm(np.subtract(hit.position, camera["eye"])) >= hit.depth - 1e-4
    assert hits >= 2
    hit = viewport.pick(scene, 36, 28, camera)
    hit.instance.visible = False
    other = viewport.pick(scene, 36, 28, camera)
    assert other is None or other.instance != hit.instance
    for pixel in ((-1, 0), (72, 0), (0, 56)):
        with pytest.raises(ValueError, match="is not in the picture"):
            viewport.pick(scene, *pixel, camera)


def test_an_orbit_goes_around(scene):
    orbit = overcoat.Orbit.around(scene, 1.5)
    assert overcoat.render(scene, size=(60, 40)).hash == overcoat.render(
        scene, size=(60, 40), camera=orbit
    ).hash
    first = orbit.copy()
    distance = np.linalg.norm(np.subtract(orbit.eye, orbit.target))
    orbit.turn(90)
    offset, before = (np.subtract(each.eye, each.target) for each in (orbit, first))
    assert offset == pytest.approx([before[2], before[1], -before[0]], abs=1e-4)
    orbit.zoom(2)
    assert np.linalg.norm(np.subtract(orbit.eye, orbit.target)) == pytest.approx(distance / 2, rel=1e-5)
    orbit.pan(0, 0.1)
    assert orbit.target[1] > first.target[1]
    orbit.target = (1, 2, 3)
    assert orbit.target == (1, 2, 3) and "around (1.0000, 2.0000, 3.0000)" in repr(orbit)
    model = scene.snapshot()
    assert overcoat.Orbit.around(model, 1.5).eye == first.eye
    for wrong in (lambda: orbit.turn(float("nan")), lambda: orbit.zoom(0), lambda: overcoat.Orbit.around(scene, 0),
                  lambda: overcoat.Orbit.around(3), lambda: overcoat.turntable(scene, frames=2, camera=orbit)):
        with pytest.raises(ValueError):
            wrong()


def begun(viewport, *arguments, **options):
    """Draws in another thread. Returns the thread and what came of it."""
    found = []

    def work():
        try:
            found.append(viewport.draw(*arguments, **options))
        except Exception as error:
            found.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    return thread, found


def test_a_picture_is_stopped_from_another_thread(scene):
    renderer = overcoat.Renderer(1)
    viewport = overcoat.Viewport(renderer, size=900, quality="best", samples=16)
    viewport.cancel()  # Nobody draws.
    threads = [begun(viewport, scene) for _ in range(2)]
    start = time.monotonic()
    while any(thread.is_alive() for thread, _ in threads) and time.monotonic() < start + 60:
        viewport.cancel()
        time.sleep(0.01)
    assert [type(found[0]) for _, found in threads] == [overcoat.Cancelled] * 2
    viewport.configure(size=SIZE, quality="draft")
    assert (viewport.draw(scene).array == overcoat.render(scene, size=SIZE, quality="draft", samples=16).array).all()


def test_an_array_stays_where_it_is_while_it_is_drawn_into(scene):
    viewport = overcoat.Viewport(overcoat.Renderer(1), size=500, quality="good")
    out = np.zeros((500, 500, 4), np.uint8)
    shown, other = scene.snapshot(), overcoat.Viewport(size=(500, 20), quality="draft")
    thread, found = begun(viewport, scene, out=out[:])
    while weakref.getweakrefcount(out) == 0 and thread.is_alive():
        time.sleep(0)
    # Larger, so that it would move.
    with pytest.raises(ValueError, match="cannot resize"):
        out.resize((1000, 500, 4), refcheck=False)
    # Another picture cannot be drawn there.
    with pytest.raises(ValueError, match="another picture is being drawn into its memory"):
        other.draw(scene, out=out[30:50])
    # What changes meanwhile is not in the picture.
    scene.instances[0].visible = False
    assert thread.is_alive()
    thread.join()
    assert isinstance(found[0], overcoat.Drawn)
    assert (out == overcoat.render(shown, size=500, quality="good").array).all()
    out.resize((10, 500, 4), refcheck=False)


def test_the_interpreter_is_free_and_threads_take_turns(scene):
    viewport, expected = overcoat.Viewport(size=160, quality="good"), overcoat.render(scene, size=160, quality="good").array
    pictures = [begun(viewport, scene) for _ in range(3)]
    count = 0
    while any(thread.is_alive() for thread, _ in pictures):
        count += 1
        time.sleep(0)
    assert count > 20
    assert all((found[0].array == expected).all() for _, found in pictures)


_KEPT = {}


def _draw_kept(name):
    return _KEPT[name].draw(_KEPT["scene"]).array.tobytes()


def test_children_of_a_fork_draw(scene):
    if "fork" not in multiprocessing.get_all_start_methods():
        pytest.skip("not of this system")
    idle, busy = (overcoat.Viewport(overcoat.Renderer(1), size=SIZE) for _ in range(2))
    expected = [viewport.draw(scene).array.tobytes() for viewport in (idle, busy)]
    _KEPT.update(idle=idle, busy=busy, scene=scene)
    out = np.zeros((1000, 1000, 4), np.uint8)
    busy.configure(size=1000, quality="best")
    thread, found = begun(busy, scene, out=out)
    while weakref.getweakrefcount(out) == 0 and thread.is_alive():
        time.sleep(0)
    busy.configure(size=SIZE, quality="fast")
    with multiprocessing.get_context("fork").Pool(1) as pool:
        is_drawing = thread.is_alive()
        # Whoever draws in the parent is not waited for.
        assert pool.map_async(_draw_kept, ["idle", "busy"]).get(timeout=60) == expected
    busy.cancel()
    thread.join()
    assert is_drawing and isinstance(found[0], overcoat.Cancelled)
    assert [viewport.draw(scene).array.tobytes() for viewport in (idle, busy)] == expected

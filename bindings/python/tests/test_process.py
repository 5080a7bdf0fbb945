"""Threads, forks, and arithmetic that others have changed."""

from __future__ import annotations

import ctypes
import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import threading
import time

import pytest

import overcoat
from overcoat import _overcoat


def test_other_threads_go_on_while_it_draws(model):
    shape = overcoat.load(model("material-ball.glb"))
    count, stop = [0], threading.Event()

    def work():
        while not stop.is_set():
            count[0] += 1
            time.sleep(0)

    thread = threading.Thread(target=work)
    thread.start()
    renderer = overcoat.Renderer(1)
    before, start = count[0], time.monotonic()
    renderer.render(shape, size=384, quality="best")
    drawing, progress = time.monotonic() - start, count[0] - before
    stop.set()
    thread.join()
    # With the interpreter held it would be one or two.
    assert progress > 20, (progress, drawing)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_stops_a_picture(model):
    """Pictures that would take many seconds, by each way to draw one; afterwards all goes on as before."""
    # What a shell starts in the background ignores it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    renderer, shape = overcoat.Renderer(1), overcoat.load(model("sports-car.glb"))
    expected = renderer.render(shape, size=48).hash
    scene = overcoat.Scene()
    scene.add_model(shape)
    viewport = overcoat.Viewport(renderer, size=5000, quality="fast", samples=16)
    for draw in (
        lambda: renderer.render(shape, size=5000, quality="fast", samples=16),
        lambda: renderer.turntable(shape, frames=999, size=1000, quality="draft"),
        lambda: viewport.draw(scene),
    ):
        timer = threading.Timer(0.1, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            draw()
        timer.join()
        assert renderer.render(shape, size=48).hash == expected
    # Exceptions of other handlers as well.
    before = signal.signal(signal.SIGALRM, _give_up)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        with pytest.raises(TimeoutError, match="enough"):
            renderer.render(shape, size=5000, quality="fast", samples=16)
    finally:
        signal.signal(signal.SIGALRM, before)


def _give_up(*_):
    raise TimeoutError("enough")


def test_threads_draw_at_once_and_the_same(model):
    renderer, shape = overcoat.Renderer(1), overcoat.load(model("sports-car.glb"))
    expected = renderer.render(shape, size=96).hash
    inside, most, lock, found = [0], [0], threading.Lock(), []
    barrier = threading.Barrier(3)

    def work():
        barrier.wait()
        for _ in range(3):
            with lock:
                inside[0] += 1
                most[0] = max(most[0], inside[0])
            found.append(renderer.render(shape, size=96, quality="good").hash)
            with lock:
                inside[0] -= 1

    threads = [threading.Thread(target=work) for _ in range(3)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(found) == 9 and len(set(found)) == 1 and most[0] > 1
    assert renderer.render(shape, size=96).hash == expected


def _draw(path):
    return overcoat.render(path, size=48).hash


_KEPT = {}


def _draw_kept(_):
    return _KEPT["renderer"].render(_KEPT["model"], size=48).hash


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_children_draw(model, method):
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip("not of this system")
    path = model("rounded-cube.glb")
    expected = _draw(path)  # The parent's threads are there.
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map_async(_draw, [path] * 4).get(timeout=60) == [expected] * 4


def test_a_renderer_survives_a_fork(model):
    if "fork" not in multiprocessing.get_all_start_methods():
        pytest.skip("not of this system")
    _KEPT["renderer"] = overcoat.Renderer(2)
    _KEPT["model"] = overcoat.load(model("rounded-cube.glb"))
    expected = _draw_kept(0)
    stop = threading.Event()

    def busy():  # A fork may come at any time of another thread's picture.
        while not stop.is_set():
            _draw_kept(0)

    thread = threading.Thread(target=busy)
    thread.start()
    try:
        with multiprocessing.get_context("fork").Pool(3) as pool:
            assert pool.map_async(_draw_kept, range(6)).get(timeout=60) == [expected] * 6
    finally:
        stop.set()
        thread.join()
    assert _draw_kept(0) == expected


FLUSH = r"""
#if defined(__x86_64__) || defined(__i386__)
#include <xmmintrin.h>
unsigned get_mode(void) { return _mm_getcsr(); }
void set_mode(unsigned mode) { _mm_setcsr(mode); }
unsigned flushing(void) { return _mm_getcsr() | 0x8040; }
#else
unsigned get_mode(void) { unsigned long v; __asm__ volatile("mrs %0, fpcr" : "=r"(v)); return (unsigned)v; }
void set_mode(unsigned mode) { unsigned long v = mode; __asm__ volatile("msr fpcr, %0" :: "r"(v)); }
unsigned flushing(void) { return get_mode() | (1u << 24); }
#endif
"""


def test_flushed_subnormals_of_others_change_nothing(model, tmp_path):
    if shutil.which("gcc") is None:
        pytest.skip("no compiler")
    source, library = tmp_path / "flush.c", tmp_path / "flush.so"
    source.write_text(FLUSH)
    subprocess.run(["gcc", "-O1", "-shared", "-fPIC", "-o", library, source], check=True)
    flush = ctypes.CDLL(str(library))
    flush.get_mode.restype = flush.flushing.restype = ctypes.c_uint
    expected = overcoat.render(model("sports-car.glb"), size=64).hash
    before = flush.get_mode()
    flush.set_mode(flush.flushing())
    try:
        assert not _overcoat.arithmetic_is_default()
        # With threads that were there before, and with new ones, which inherit the mode of the thread that makes them.
        assert overcoat.render(model("sports-car.glb"), size=64).hash == expected
        for threads in (1, 3):
            assert overcoat.Renderer(threads).render(model("sports-car.glb"), size=64).hash == expected
        inside = []
        thread = threading.Thread(target=lambda: inside.append(overcoat.Renderer(2).render(model("sports-car.glb"), size=64).hash))
        thread.start()
        thread.join()
        assert inside == [expected]
        assert overcoat.turntable(model("vase.glb"), frames=2, size=16)[0].hash
        # What it was is what it is again.
        assert not _overcoat.arithmetic_is_default()
        assert flush.get_mode() & 0xFFC0 == flush.flushing() & 0xFFC0
    finally:
        flush.set_mode(before)
    assert _overcoat.arithmetic_is_default()


def test_the_module_does_without_numpy_until_there_are_arrays(model):
    code = f"import sys, overcoat\nimage = overcoat.render({model('vase.glb')!r}, size=8)\nimage.png()\nprint('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    # Only so can the command give up its rights: a process with threads of a linear algebra library could not.
    assert done.stdout.split() == ["False"]


def test_the_wheel_has_the_command(model, tmp_path):
    run = [sys.executable, "-m", "overcoat"]
    target = tmp_path / "x.png"
    done = subprocess.run([*run, "render", model("vase.glb"), "--size", "16", "-o", target, "--json"], capture_output=True, text=True)
    assert done.returncode == 0 and json.loads(done.stdout)["frame_hash"] == overcoat.render(model("vase.glb"), size=16).hash
    done = subprocess.run([*run, "rendr"], capture_output=True, text=True)
    assert done.returncode == 2 and "render" in done.stderr and done.stderr.count("\n") == 1
    help_text = subprocess.run([*run, "--help"], capture_output=True, text=True)
    assert help_text.returncode == 0 and "golden" in help_text.stdout
    done = subprocess.run([*run, "thumbnail", model("vase.glb"), str(tmp_path / "t.png"), "32"], capture_output=True, text=True)
    assert "not everything is given up: " not in done.stderr or sys.platform != "linux", done.stderr

"""Pictures that tests expect: the function, the command and the fixture."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import overcoat
from overcoat import golden


@pytest.fixture
def cube(model):
    return overcoat.render(model("rounded-cube.glb"), size=32)


def test_a_golden_is_recorded_then_holds_then_differs(cube, tmp_path, monkeypatch):
    monkeypatch.delenv("UPDATE_GOLDENS", raising=False)
    path = tmp_path / "golden" / "cube.png"
    with pytest.raises(AssertionError, match="no expected picture"):
        golden.check(cube, path)
    with pytest.raises(golden.Mismatch, match="recorded"):
        golden.check(cube, path, update=True)
    golden.check(cube, path)
    golden.check(cube.array, path)
    golden.check(cube.png(), path)
    other = cube.array.copy()
    other[16, 16, 0] ^= 1
    with pytest.raises(golden.Mismatch, match="cube.new.png"):
        golden.check(other, path)
    assert (tmp_path / "golden" / "cube.new.png").is_file()
    golden.check(other, path, max_abs=1)
    assert not (tmp_path / "golden" / "cube.new.png").exists()
    with pytest.raises(golden.Mismatch):
        golden.check(other, path, failures=tmp_path / "out")
    assert (tmp_path / "out" / "cube.new.png").is_file()
    monkeypatch.setenv("UPDATE_GOLDENS", "1")
    with pytest.raises(golden.Mismatch, match="recorded"):
        golden.check(other, path)
    monkeypatch.delenv("UPDATE_GOLDENS")
    golden.check(other, path)


def test_what_is_no_picture_is_said(cube, tmp_path):
    for bad in (np.zeros((4, 4)), np.zeros((4, 4, 2), dtype=np.uint8), np.zeros((0, 4, 4), dtype=np.uint8), 7):
        with pytest.raises(overcoat.MeshError):
            golden.check(bad, tmp_path / "x.png")
    with pytest.raises(overcoat.OptionError, match="png"):
        golden.check(cube, tmp_path / "x.exr")
    with pytest.raises(overcoat.OptionError, match="thresholds"):
        golden.check(cube, tmp_path / "x.png", ssim=float("nan"))
    (tmp_path / "x.png").write_bytes(b"no picture")
    with pytest.raises(overcoat.Error):
        golden.check(cube, tmp_path / "x.png")
    with pytest.raises(overcoat.GoldenError):
        golden.compare(cube, b"no picture")


def test_pictures_are_measured(cube):
    equal = golden.compare(cube, cube.array)
    assert equal.ok and equal.verdict == "equal" and equal.pixels == 0
    other = cube.array.copy()
    other[10:20, 10:20, :3] //= 2
    found = golden.compare(cube, other)
    assert not found.ok and found.pixels == 100 and found.psnr < 40 and found.ssim < 1 and found.flip_max > 0
    assert golden.compare(cube, other, flip_mean=1.0, max_abs=255).ok
    small = golden.compare(cube, cube.array[:8])
    assert not small.ok and small.reasons


def test_the_command_checks_reports_and_accepts(cube, tmp_path):
    expected, actual = tmp_path / "expected", tmp_path / "actual"
    expected.mkdir(), actual.mkdir()
    cube.save(expected / "cube.png")
    other = overcoat.render(vertices=[[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces=[[0, 1, 2]], size=32)
    other.save(actual / "cube.png")
    run = [sys.executable, "-m", "overcoat", "golden"]
    assert subprocess.run([*run, "check", expected, actual], capture_output=True).returncode == 4
    page = tmp_path / "report.html"
    assert subprocess.run([*run, "report", expected, actual, "-o", page], capture_output=True).returncode == 4
    assert b"cube" in page.read_bytes()
    assert subprocess.run([*run, "accept", expected, actual, "cube.png"], capture_output=True).returncode == 0
    assert subprocess.run([*run, "check", expected, actual], capture_output=True).returncode == 0


TEST = """
import numpy as np
import pytest

@pytest.mark.parametrize("value", [10, 20])
def test_square(overcoat_golden, value):
    picture = np.full((8, 8, 4), 255, dtype=np.uint8)
    picture[2:6, 2:6, :3] = value + {}
    overcoat_golden(picture)
    overcoat_golden(picture, "named-%d" % value)
"""


def test_the_fixture(pytester, monkeypatch):
    monkeypatch.delenv("UPDATE_GOLDENS", raising=False)
    pytester.makepyfile(test_it=TEST.format(0))
    arguments = ["-p", "no:cacheprovider"]
    first = pytester.runpytest_subprocess(*arguments)
    first.assert_outcomes(failed=2)
    first.stdout.fnmatch_lines(["*no expected picture*"])
    # The second picture of a test is recorded in the run after that of the first.
    pytester.runpytest_subprocess(*arguments, "--overcoat-update").assert_outcomes(failed=2)
    pytester.runpytest_subprocess(*arguments, "--overcoat-update", "-k", "10 or 20")
    folder = pytester.path / "golden"
    names = {path.name for path in folder.iterdir() if not path.name.endswith(".new.png")}
    assert "test_square-10.png" in names, names


def test_the_fixture_shows_what_differs(pytester, monkeypatch):
    monkeypatch.delenv("UPDATE_GOLDENS", raising=False)
    body = TEST.split("    overcoat_golden(picture, ")[0]
    pytester.makepyfile(test_it=body.format(0))
    pytester.runpytest_subprocess("--overcoat-update").assert_outcomes(failed=2)
    pytester.runpytest_subprocess().assert_outcomes(passed=2)
    pytester.makepyfile(test_it=body.format(1))
    changed = pytester.runpytest_subprocess()
    changed.assert_outcomes(failed=2)
    changed.stdout.fnmatch_lines(["*overcoat: golden pictures that differ are shown in *report.html"])
    assert b"test_square-10" in (pytester.path / "golden" / "report.html").read_bytes()
    elsewhere = pytester.runpytest_subprocess("--overcoat-failures", "out")
    elsewhere.assert_outcomes(failed=2)
    assert (pytester.path / "out" / "golden" / "test_square-20.new.png").is_file()
    accepted = [sys.executable, "-m", "overcoat", "golden", "accept", "golden", "golden", "--all"]
    assert subprocess.run(accepted, cwd=pytester.path).returncode == 0
    pytester.runpytest_subprocess().assert_outcomes(passed=2)

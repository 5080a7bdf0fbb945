"""The annotations hold: mypy (strict) and pyright (strict) over the package, the stub against the native module, and a file of uses
and misuses."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
PACKAGE = HERE.parent


def wrong_lines(text: str) -> list[int]:
    """Lines of typing_check.py that a checker complains of, which must be those that are marked."""
    return sorted({int(line) for line in re.findall(r"typing_check\.py:(\d+):?\d*:? (?:- )?error", text)})


def marked_lines() -> list[int]:
    lines = (HERE / "typing_check.py").read_text().splitlines()
    return [number for number, line in enumerate(lines, 1) if line.endswith("# expect-error")]


def test_types_are_those_of_the_schema():
    script = PACKAGE / "scripts" / "option_types.py"
    done = subprocess.run([sys.executable, script, "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_mypy():
    pytest.importorskip("mypy")
    run = [sys.executable, "-m", "mypy", "--no-incremental", "--config-file", "pyproject.toml"]
    done = subprocess.run([*run, "python/overcoat"], cwd=PACKAGE, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    done = subprocess.run([*run, "tests/typing_check.py"], cwd=PACKAGE, capture_output=True, text=True, env=_with_path())
    assert wrong_lines(done.stdout) == marked_lines(), done.stdout + done.stderr


def test_the_stub_is_that_of_the_module():
    pytest.importorskip("mypy")
    run = [sys.executable, "-m", "mypy.stubtest", "overcoat._overcoat", "--ignore-missing-stub", "--ignore-disjoint-bases"]
    done = subprocess.run(run, cwd=PACKAGE, capture_output=True, text=True, env=_with_path())
    assert done.returncode == 0, done.stdout + done.stderr


def test_pyright():
    program = shutil.which("pyright") or str(Path(sys.executable).with_name("pyright"))
    if not Path(program).exists():
        pytest.skip("no pyright")
    done = subprocess.run([program, "-p", "pyproject.toml", "--pythonpath", sys.executable], cwd=PACKAGE, capture_output=True, text=True)
    errors = [line for line in done.stdout.splitlines() if " - error: " in line and "typing_check.py" not in line]
    assert not errors, "\n".join(errors)
    assert wrong_lines(done.stdout) == marked_lines(), done.stdout + done.stderr


def _with_path() -> dict[str, str]:
    import os

    return {**os.environ, "MYPYPATH": str(PACKAGE / "python")}

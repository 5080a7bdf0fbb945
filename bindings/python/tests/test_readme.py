"""Every listing of README.md runs, in its order."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from conftest import MODELS

README = Path(__file__).parents[1] / "README.md"


def listings(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README.read_text(), re.S)


def test_every_listing_runs(tmp_path, monkeypatch):
    pytest.importorskip("trimesh")
    if not hasattr(np, "infty"):
        np.infty = np.inf
    pytest.importorskip("pyrender")
    for file in MODELS.iterdir():
        if file.is_file():
            shutil.copy(file, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("UPDATE_GOLDENS", raising=False)
    names: dict[str, object] = {}
    found = listings("python")
    assert len(found) >= 12
    for number, listing in enumerate(found, 1):
        exec(compile(listing, f"README.md, listing {number}", "exec"), names)
    assert (tmp_path / "car.png").is_file() and (tmp_path / "turn.webp").is_file()
    # The listing of a test is one, and does what the text says.
    test = next(listing for listing in found if "overcoat_golden" in listing)
    (tmp_path / "test_listing.py").write_text("import overcoat\n\n\n" + test)
    run = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_listing.py"]
    assert subprocess.run(run, cwd=tmp_path).returncode == 1
    assert subprocess.run([*run, "--overcoat-update"], cwd=tmp_path).returncode == 1
    assert (tmp_path / "golden" / "test_cube.png").is_file()
    assert subprocess.run(run, cwd=tmp_path).returncode == 0


def test_the_notebook_runs(tmp_path, monkeypatch):
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    monkeypatch.setenv("OVERCOAT_MODELS", str(MODELS))
    notebook = nbformat.read(README.parent / "notebook.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=60, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", []) if "image/png" in output.get("data", {})]
    assert len(shown) == 2


def test_the_commands_of_the_readme_exist():
    text = README.read_text()
    helped = subprocess.run([sys.executable, "-m", "overcoat", "golden", "--help"], capture_output=True, text=True).stdout
    for name in ("check", "report", "accept"):
        assert f"overcoat golden {name}" in text and name in helped

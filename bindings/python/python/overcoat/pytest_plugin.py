"""Plugin of pytest: the fixture `overcoat_golden`.

    def test_knot(overcoat_golden):
        overcoat_golden(overcoat.render("knot.glb", size=128))

holds the picture against `golden/test_knot.png` beside the test. A picture that differs fails the test; it is written to
`golden/test_knot.new.png`, and at the end a page `golden/report.html` shows all of them beside the expected ones. Then either the
code is wrong, or `overcoat golden accept golden golden test_knot.png` takes the new picture, or `pytest --overcoat-update` records
all that the tests draw (and they fail, once).
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Set, Tuple

import pytest

if TYPE_CHECKING:
    from .golden import Picture

#: Folders of expected pictures and of failures, of this run.
_FOLDERS = pytest.StashKey[Set[Tuple[Path, Path]]]()
_REPORTS = pytest.StashKey[List[Path]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("overcoat", "golden pictures")
    group.addoption(
        "--overcoat-update",
        action="store_true",
        help="record golden pictures instead of comparing them; tests that record fail once",
    )
    group.addoption(
        "--overcoat-failures",
        metavar="DIR",
        help="folder for pictures that differ and the report (default: beside the expected ones)",
    )
    parser.addini("overcoat_golden_folder", "folder of expected pictures, relative to that of the test", default="golden")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_FOLDERS] = set()
    config.stash[_REPORTS] = []


class GoldenCheck:
    """What the fixture `overcoat_golden` is."""

    def __init__(self, request: pytest.FixtureRequest) -> None:
        self._config = request.config
        self._folder = Path(request.path).parent / str(request.config.getini("overcoat_golden_folder"))
        # Parameters become part of a file's name.
        self._test = re.sub(r"[^\w.-]+", "-", request.node.name).strip("-.")
        self._used: Dict[str, int] = {}

    def __call__(
        self, actual: Picture, name: Optional[str] = None, *, folder: Optional[os.PathLike[str]] = None, **thresholds: Any
    ) -> None:
        """Holds a picture against the expected one.

        Args:
            actual: As of `overcoat.golden.check`.
            name: Of the file, without `.png` (with its extension for bytes of other formats); that of the test if `None`.
            folder: Of the expected pictures.
            thresholds: As of `overcoat.golden.check`.
        """
        from . import golden

        name = self._test if name is None else name
        count = self._used[name] = self._used.get(name, 0) + 1
        if count > 1:
            raise ValueError(f"overcoat_golden: '{name}' is checked twice in one test; give the second a name")
        base = self._folder if folder is None else Path(folder)
        file = base / (name if isinstance(actual, bytes) and Path(name).suffix else f"{name}.png")
        wanted = self._config.getoption("--overcoat-failures")
        failures = base if wanted is None else Path(wanted) / _place(base, Path(self._config.rootpath))
        update = True if self._config.getoption("--overcoat-update") else None
        try:
            golden.check(actual, file, failures=failures, update=update, **thresholds)
        except golden.Mismatch:
            self._config.stash[_FOLDERS].add((base, failures))
            raise


def _place(folder: Path, root: Path) -> str:
    """A folder of failures for each of expected pictures."""
    try:
        relative = folder.resolve().relative_to(root.resolve())
    except ValueError:
        relative = Path(folder.name)
    return "-".join(relative.parts) or "golden"


@pytest.fixture
def overcoat_golden(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Holds pictures against expected ones: `overcoat_golden(image)`."""
    return GoldenCheck(request)


def pytest_sessionfinish(session: pytest.Session) -> None:
    folders: Set[Tuple[Path, Path]] = session.config.stash[_FOLDERS]
    for base, failures in sorted(list(folders)):
        if not base.is_dir() or not failures.is_dir():
            continue
        page = failures / "report.html"
        command = [sys.executable, "-m", "overcoat", "golden", "report", str(base), str(failures), "-o", str(page)]
        # 4: something differs, which is known.
        if subprocess.run([*command, "--quiet"], check=False, stdout=subprocess.DEVNULL).returncode in (0, 4):
            session.config.stash[_REPORTS].append(page)


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    for page in config.stash.get(_REPORTS, []):
        terminalreporter.write_line(f"overcoat: golden pictures that differ are shown in {page}")

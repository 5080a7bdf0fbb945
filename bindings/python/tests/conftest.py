"""What the tests have in common. Models are those of the repository."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Callable

import pytest

pytest_plugins = ["pytester"]

ROOT = Path(__file__).resolve().parents[3]
MODELS = ROOT / "assets" / "models"


@pytest.fixture
def model() -> Callable[[str], str]:
    """The path of a model by its name."""
    return lambda name: str(MODELS / name)


@pytest.fixture
def command() -> Callable[..., subprocess.CompletedProcess[str]]:
    """Runs the command line of the repository (`OVERCOAT_COMMAND`) or, without one, of the wheel."""
    program = os.environ.get("OVERCOAT_COMMAND")
    start = [program] if program else [sys.executable, "-m", "overcoat"]

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([*start, *arguments], capture_output=True, text=True, timeout=120)

    return run

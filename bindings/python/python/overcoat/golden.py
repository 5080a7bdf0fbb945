"""Pictures that a test expects, and those that it drew: exact, unless thresholds say otherwise.

    import overcoat
    from overcoat import golden

    def test_knot():
        golden.check(overcoat.render("knot.glb", size=128), "tests/golden/knot.png")

A picture that differs is written beside the expected one, `knot.new.png`, and `Mismatch` is raised, which is an
`AssertionError`. `overcoat golden report tests/golden tests/golden -o report.html` shows both, `overcoat golden accept
tests/golden tests/golden knot.png` takes the new one. With `UPDATE_GOLDENS=1` in the environment it is recorded at once, and the
test fails all the same: whoever records a picture has looked at it, and runs the tests again.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional, Sequence, Union

from . import _overcoat
from ._errors import Mismatch, OptionError

if TYPE_CHECKING:
    import numpy.typing as npt

    Path = Union[str, "os.PathLike[str]"]
    #: A picture, (H, W, 3) or (H, W, 4) bytes of sRGB with straight alpha, or the bytes of a picture file.
    Picture = Union[_overcoat.Image, bytes, npt.NDArray[Any]]


__all__ = ["Comparison", "Mismatch", "check", "compare"]


@dataclass(frozen=True)
class Comparison:
    """How much two pictures differ.

    Attributes:
        ok: Equal, or within the thresholds.
        verdict: `equal`, `within`, `differs` or `failed`.
        reasons: What is beyond a threshold, in one sentence each.
        pixels: How many differ at all.
        max_abs: Largest difference of a sample: codes of 255, or linear light.
        psnr: Peak signal-to-noise ratio in dB; infinite if they are equal.
        ssim: Structural similarity, 1 if they are equal.
        flip_mean, flip_max: FLIP, 0 if they are equal.
    """

    ok: bool
    verdict: str
    reasons: Sequence[str]
    pixels: Optional[int] = None
    max_abs: Optional[float] = None
    psnr: Optional[float] = None
    ssim: Optional[float] = None
    flip_mean: Optional[float] = None
    flip_max: Optional[float] = None


def check(
    actual: Picture,
    expected: Path,
    *,
    failures: Optional[Path] = None,
    update: Optional[bool] = None,
    max_abs: Optional[float] = None,
    pixels: Optional[int] = None,
    flip_mean: Optional[float] = None,
    flip_max: Optional[float] = None,
    psnr: Optional[float] = None,
    ssim: Optional[float] = None,
) -> None:
    """Holds a picture against an expected one.

    Args:
        actual: An `Image`, an array (H, W, 3 or 4) of bytes, or the bytes of a picture file of the format of `expected`.
        expected: Path of the expected picture, `.png` but for bytes.
        failures: Folder for what differs; beside the expected picture if `None`.
        update: Record instead of compare; by `UPDATE_GOLDENS=1` in the environment if `None`.
        max_abs, pixels, flip_mean, flip_max, psnr, ssim: Thresholds, where no `thresholds.toml` beside the expected picture says
            otherwise: at most (`psnr` in dB and `ssim`: at least).

    Raises:
        Mismatch: The pictures differ, there is no expected one, or it was recorded.
        GoldenError, OSError: They cannot be compared.
    """
    folder, name = os.path.split(os.fspath(expected))
    if update is None:
        update = os.environ.get("UPDATE_GOLDENS") == "1"
    given = _picture(actual)
    if not isinstance(given, bytes):
        stem, extension = os.path.splitext(name)
        if extension.lower() != ".png":
            raise OptionError(f"{name}: pictures of this process are kept as .png; give bytes for other formats")
        name = stem
    text = _thresholds(max_abs, pixels, flip_mean, flip_max, psnr, ssim)
    target = None if failures is None else os.fspath(failures)
    _overcoat.golden_check(folder or ".", name, given, target, update, text)


def compare(
    expected: Picture,
    actual: Picture,
    *,
    max_abs: Optional[float] = None,
    pixels: Optional[int] = None,
    flip_mean: Optional[float] = None,
    flip_max: Optional[float] = None,
    psnr: Optional[float] = None,
    ssim: Optional[float] = None,
) -> Comparison:
    """Measures how much two pictures differ; arguments as of `check`.

    Raises:
        GoldenError: One of them is no picture.
    """
    text = _thresholds(max_abs, pixels, flip_mean, flip_max, psnr, ssim)
    return Comparison(**_overcoat.golden_compare(_picture(expected), _picture(actual), text))


def _picture(value: Any) -> Any:
    if isinstance(value, (_overcoat.Image, bytes)):
        return value
    if isinstance(value, (bytearray, memoryview)):
        return bytes(value)
    from ._arrays import picture

    return picture("picture", value)


def _thresholds(
    max_abs: Optional[float],
    pixels: Optional[int],
    flip_mean: Optional[float],
    flip_max: Optional[float],
    psnr: Optional[float],
    ssim: Optional[float],
) -> str:
    given = {
        "max_abs": max_abs,
        "pixels": pixels,
        "flip_mean": flip_mean,
        "flip_max": flip_max,
        "psnr": psnr,
        "ssim": ssim,
    }
    return "".join(f"{name} = {value!r}\n" for name, value in given.items() if value is not None)

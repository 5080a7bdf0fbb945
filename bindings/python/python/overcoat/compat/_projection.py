"""Projections of pyrender's cameras by overcoat's, which look at the middle of the picture and have square pixels.

A camera with its optical centre elsewhere sees a part of a larger picture that has it in the middle; one with other pixels sees that
picture with its columns wider or narrower.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, Tuple

from .._errors import MissingFeatureWarning

if TYPE_CHECKING:
    import numpy.typing as npt


@dataclass(frozen=True)
class Projection:
    """What is drawn, and which part of it is the picture.

    Attributes:
        camera: Keys of the option `camera`.
        drawn: `(width, height)` of what is drawn, in pixels.
        columns: Width of what is drawn once its columns have the right width.
        left, top: Where the picture begins in it.
        size: `(width, height)` of the picture.
    """

    camera: Dict[str, float]
    drawn: Tuple[int, int]
    columns: int
    left: int
    top: int
    size: Tuple[int, int]

    def picture(self, array: npt.NDArray[Any], smooth: bool) -> npt.NDArray[Any]:
        """The picture of what was drawn, (H, W) or (H, W, C); `smooth` if values may be mixed."""
        import numpy as np

        if self.columns != self.drawn[0]:
            at = (np.arange(self.columns) + 0.5) * self.drawn[0] / self.columns - 0.5
            low = np.clip(np.floor(at).astype(int), 0, self.drawn[0] - 1)
            high = np.minimum(low + 1, self.drawn[0] - 1)
            part = np.clip(at - low, 0, 1)
            if smooth:
                part = part.reshape(1, -1, *[1] * (array.ndim - 2))
                mixed = array[:, low] * (1 - part) + array[:, high] * part
                array = (np.rint(mixed) if array.dtype == np.uint8 else mixed).astype(array.dtype)
            else:
                array = array[:, np.where(part < 0.5, low, high)]
        width, height = self.size
        # A copy: who has it may write to it, as in pyrender.
        return np.array(array[self.top : self.top + height, self.left : self.left + width], order="C")


def of_camera(camera: Any, width: int, height: int) -> Projection:
    """The projection of a camera of pyrender for a picture of this size in pixels."""
    if hasattr(camera, "fx"):
        return _intrinsics(camera, width, height)
    near = float(camera.znear)
    if hasattr(camera, "ymag"):
        # pyrender takes the width from the picture's shape, whatever `xmag` says.
        view = {"ortho_height": 2 * float(camera.ymag), "near": near}
        return Projection(view, (width, height), width, 0, 0, (width, height))
    if not hasattr(camera, "yfov"):
        raise TypeError(f"overcoat does not know the camera {type(camera).__name__}: pyrender has perspective, orthographic and "
                        "intrinsics cameras")
    drawn = width
    if camera.aspectRatio is not None:
        drawn = max(1, round(height * float(camera.aspectRatio)))
    view = {"fov_y_deg": math.degrees(float(camera.yfov)), "near": near}
    return Projection(view, (drawn, height), width, 0, 0, (width, height))


def _intrinsics(camera: Any, width: int, height: int) -> Projection:
    fx, fy, cx, cy = (float(getattr(camera, name)) for name in ("fx", "fy", "cx", "cy"))
    if not (fx > 0 and fy > 0):
        raise ValueError(f"focal lengths fx = {fx}, fy = {fy}: expected more than 0 pixels")
    # The border of the larger picture is a border of pixels, so that its middle is one or the centre of one.
    half_x, half_y = round(2 * cx), round(2 * cy)
    if abs(half_x - 2 * cx) > 1e-3 or abs(half_y - 2 * cy) > 1e-3:
        warnings.warn(
            f"the optical centre ({cx}, {cy}) is taken to be at ({half_x / 2}, {half_y / 2}): overcoat places it to half a pixel",
            MissingFeatureWarning,
            stacklevel=4,
        )
    columns, rows = max(half_x, 2 * width - half_x), max(half_y, 2 * height - half_y)
    left, top = (columns - half_x) // 2, (rows - half_y) // 2
    drawn = max(1, round(columns * fy / fx))
    view = {"fov_y_deg": math.degrees(2 * math.atan(rows / 2 / fy)), "near": float(camera.znear)}
    return Projection(view, (drawn, rows), columns, left, top, (width, height))

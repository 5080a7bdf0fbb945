"""Matrices of the camera that a picture was taken with."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt


@dataclass(frozen=True, eq=False)
class CameraMatrices:
    """Matrices of the camera that a picture was taken with: `Image.camera`. `camera=` takes it, and draws the same picture again.

    Attributes:
        kind: `perspective` or `orthographic`.
        width, height: Of the picture, in pixels.
        K: (3, 3) float64: fx, 0, cx; 0, fy, cy; 0, 0, 1, in pixels. The centre of the first pixel is at (0.5, 0.5). Of an orthographic
            camera fx and fy are pixels per metre, whatever the distance.
        world_to_camera: (4, 4) float64, the extrinsics of OpenCV: +x right, +y down, +z forward.
        camera_to_world: (4, 4) float64, the pose of OpenGL, pyrender and Blender: +x right, +y up, -z forward.
        near: Distance in metres before which nothing is drawn.
        far: Distance in metres beyond which no surface is drawn; `inf` without one.
    """

    kind: str
    width: int
    height: int
    K: npt.NDArray[np.float64]
    world_to_camera: npt.NDArray[np.float64]
    camera_to_world: npt.NDArray[np.float64]
    near: float
    far: float

    def unproject(self, depth: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
        """Positions in the world, (H, W, 3), of a (H, W) plane of depth of the picture. Where depth is 0 nothing is."""
        import numpy as np

        z = np.asarray(depth, dtype=np.float64)
        if z.shape != (self.height, self.width):
            raise ValueError(f"depth: expected shape {(self.height, self.width)}, found {z.shape}")
        v, u = np.mgrid[: self.height, : self.width] + 0.5
        scale = z if self.kind == "perspective" else np.ones_like(z)
        x, y = (u - self.K[0, 2]) / self.K[0, 0] * scale, (v - self.K[1, 2]) / self.K[1, 1] * scale
        pose = self.camera_to_world
        return np.asarray(np.stack([x, -y, -z], axis=2) @ pose[:3, :3].T + pose[:3, 3])

    def options(self) -> Dict[str, Any]:
        """The same camera as the option `camera`."""
        found: Dict[str, Any] = {"pose": self.world_to_camera, "convention": "opencv", "near": self.near}
        if math.isfinite(self.far):
            found["far"] = self.far
        if self.kind == "perspective":
            return {**found, "K": self.K, "intrinsics_size": [self.width, self.height]}
        return {**found, "ortho_height": self.height / float(self.K[1, 1])}

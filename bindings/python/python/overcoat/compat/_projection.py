"""Projections of pyrender's cameras, and of all others that have a matrix of a pinhole, as keys of the option `camera`."""

from __future__ import annotations

from typing import Any, Dict


def of_camera(camera: Any, width: int, height: int) -> Dict[str, Any]:
    """The projection of a camera of pyrender for a picture of this size in pixels.

    Raises:
        TypeError: It has no projection matrix.
        ValueError: The matrix is not one of a pinhole without skew.
    """
    import numpy as np

    view: Dict[str, Any] = {"near": float(getattr(camera, "znear", 0.05))}
    far = getattr(camera, "zfar", None)
    if far is not None and np.isfinite(far):
        view["far"] = float(far)
    if hasattr(camera, "ymag"):
        # pyrender takes the width from the picture's shape, whatever `xmag` says.
        return {**view, "ortho_height": 2 * float(camera.ymag)}
    name = type(camera).__name__
    if not hasattr(camera, "get_projection_matrix"):
        raise TypeError(f"overcoat does not know the camera {name}: it has no get_projection_matrix")
    for focal in ("fx", "fy"):
        if hasattr(camera, focal) and not float(getattr(camera, focal)) > 0:
            raise ValueError(f"focal length {focal} = {getattr(camera, focal)}: expected more than 0 pixels")
    matrix = np.asarray(camera.get_projection_matrix(width, height), dtype=np.float64)
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        raise ValueError(f"projection matrix of {name}: expected 4 rows of 4 finite numbers")
    # Rows of x, y and w: what they are besides focal lengths, principal point and the distance -z is no pinhole.
    others = matrix[[0, 0, 1, 1, 3, 3, 3], [1, 3, 0, 3, 0, 1, 3]]
    if np.abs(others).max() > 1e-9 or matrix[3, 2] != -1:
        raise ValueError(f"projection matrix of {name} is not one of a pinhole without skew")
    # From -1 to 1 across the picture, +y up, to pixels.
    focal_lengths = [matrix[0, 0] * width / 2, matrix[1, 1] * height / 2]
    principal = [(1 - matrix[0, 2]) * width / 2, (1 + matrix[1, 2]) * height / 2]
    return {**view, "K": [float(number) for number in (*focal_lengths, *principal)]}

"""Compares the measures of `overcoat golden` with other programs' (development only; not run by the tests).

    python3 compare_with_flip_evaluator.py OVERCOAT [EXPECTED ACTUAL]

OVERCOAT is the built program. Without more arguments it makes the pictures of `crates/golden/src/metrics/tests.rs`, compares
them, and prints the values that are recorded there; with two picture files it compares those.

Needs flip-evaluator 1.7, numpy, pillow and OpenEXR (PyPI); scikit-image 0.26 for SSIM and PSNR, if it is there.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import flip_evaluator
import numpy as np
import OpenEXR
from PIL import Image

try:
    from skimage.metrics import structural_similarity
except ImportError:
    structural_similarity = None


def noise(count, seed):
    """Numbers 0 to 255 of D. Knuth's MMIX generator, as in the Rust tests."""
    values, state = [], seed
    for _ in range(count):
        state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
        values.append(state >> 56)
    return np.array(values, dtype=np.uint8)


def pictures():
    """Pairs of 8-bit pictures, 64 x 48, that the Rust tests make too."""
    height, width = 48, 64
    y, x = np.mgrid[0:height, 0:width]
    gradient = np.stack([x * 4, y * 5, (x + y) * 2], axis=2).astype(np.uint8)
    checker = np.where(((x // 8 + y // 8) % 2 == 0)[..., None], [220, 40, 60], [30, 90, 200]).astype(np.uint8)
    shifted = np.roll(checker, 1, axis=1)
    static = noise(height * width * 3, 1).reshape(height, width, 3)
    faint = (gradient.astype(int) + (static.astype(int) % 9) - 4).clip(0, 255).astype(np.uint8)
    return {
        "gradient-brighter": (gradient, (gradient.astype(int) + 10).clip(0, 255).astype(np.uint8)),
        "gradient-faint-noise": (gradient, faint),
        "checker-shifted": (checker, shifted),
        "noise-other-noise": (static, noise(height * width * 3, 2).reshape(height, width, 3)),
    }


def linear_pictures():
    """The same as light without an upper end: (code / 64)^2."""
    return {f"linear-{name}": tuple((p.astype(np.float32) / 64) ** 2 for p in pair) for name, pair in pictures().items()}


def overcoat(program, expected, actual):
    command = [program, "golden", "check", expected, actual, "--json", "-", "--background", "#808080"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return json.loads(done.stdout)["files"][0]["metrics"]


def read_exr(path):
    with OpenEXR.File(str(path)) as file:
        channels = file.channels()
        if "RGBA" in channels:
            pixels = channels["RGBA"].pixels
        elif "RGB" in channels:
            pixels = channels["RGB"].pixels
        else:
            pixels = np.stack([channels[c].pixels for c in "RGB"], axis=2)
    return pixels.astype(np.float32)


def over_grey(pixels, linear):
    """Translucent pictures over the grey of overcoat's default, as overcoat does it."""
    if pixels.shape[2] == 3:
        return pixels
    alpha = pixels[..., 3:]
    if linear:
        return pixels[..., :3] + (1 - alpha) * np.float32(0.21586050)
    return pixels[..., :3] * alpha + (1 - alpha) * np.float32(128 / 255)


def compare(program, name, expected, actual):
    linear = str(expected).endswith(".exr")
    if linear:
        e, a = (over_grey(read_exr(p), True) for p in (expected, actual))
    else:
        e, a = (over_grey(np.asarray(Image.open(p)).astype(np.float32) / 255, False) for p in (expected, actual))
    e, a = np.ascontiguousarray(e, np.float32), np.ascontiguousarray(a, np.float32)
    flip, mean, _ = flip_evaluator.evaluate(e, a, "HDR" if linear else "LDR", applyMagma=False)
    ours = overcoat(program, expected, actual)
    print(f"{name:32} flip mean {mean:.6f} {ours['flip_mean']:.6f} ({ours['flip_mean'] - mean:+.1e})"
          f"  max {flip.max():.6f} {ours['flip_max']:.6f} ({ours['flip_max'] - flip.max():+.1e})", end="")
    if structural_similarity and not linear:
        ssim = structural_similarity(e.astype(np.float64), a.astype(np.float64), channel_axis=2, gaussian_weights=True,
                                     sigma=1.5, use_sample_covariance=False, data_range=1.0)
        psnr = 10 * np.log10(1 / np.mean((e.astype(np.float64) - a.astype(np.float64)) ** 2))
        print(f"  ssim {ssim:.6f} {ours['ssim']:.6f} ({ours['ssim'] - ssim:+.1e})"
              f"  psnr {psnr:.4f} {ours['psnr']:.4f} ({ours['psnr'] - psnr:+.1e})", end="")
    print()


def main():
    program, *files = sys.argv[1:]
    if files:
        compare(program, Path(files[0]).name, *files)
        return
    with tempfile.TemporaryDirectory() as folder:
        for name, pair in pictures().items():
            paths = [f"{folder}/{name}-{k}.png" for k in "ea"]
            for path, pixels in zip(paths, pair):
                Image.fromarray(pixels).save(path)
            compare(program, name, *paths)
        for name, pair in linear_pictures().items():
            paths = [f"{folder}/{name}-{k}.exr" for k in "ea"]
            for path, pixels in zip(paths, pair):
                header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
                OpenEXR.File(header, {"RGB": pixels}).write(path)
            compare(program, name, *paths)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""What Python adds to a picture, and what ways to it cost. Decides nothing; medians, in milliseconds.

Run:  measure.py [MODEL]
"""

from __future__ import annotations

import pathlib
import statistics
import sys
import time

import numpy as np

import overcoat

ROOT = pathlib.Path(__file__).resolve().parents[2]


def median(run, count=200, warm=10):
    for _ in range(warm):
        run()
    times = []
    for _ in range(count):
        start = time.perf_counter()
        run()
        times.append(1e3 * (time.perf_counter() - start))
    return statistics.median(times)


def main():
    path = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "assets/models/rounded-cube.glb")
    renderer = overcoat.Renderer()
    model = renderer.load(path)
    options = {"size": 256, "quality": "draft", "camera": "front"}
    print(f"{path}: {model.triangles} triangles, {renderer.threads} threads")
    empty = overcoat.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    tiny = renderer.load(empty)
    print(f"  one triangle, 1 pixel: {median(lambda: renderer.render(tiny, size=1, quality='draft', camera='front'), 500):.3f}")
    print(f"  kept model, 256 x 256: {median(lambda: renderer.render(model, **options)):.3f}")
    print(f"  the same, .array:      {median(lambda: renderer.render(model, **options).array):.3f}")
    print(f"  the same, .hash:       {median(lambda: renderer.render(model, **options).hash):.3f}")
    print(f"  the same, .png():      {median(lambda: renderer.render(model, **options).png(), 50):.3f}")
    print(f"  from the path:         {median(lambda: renderer.render(path, **options), 50):.3f}")
    scene = overcoat.Scene(renderer)
    handle = scene.add_model(path)
    viewport = overcoat.Viewport(renderer, size=(640, 480), quality="draft")
    orbit, out = overcoat.Orbit.around(scene, 640 / 480), np.empty((480, 640, 4), np.uint8)
    places = [np.eye(4), np.eye(4)]
    places[1][0, 3] = 0.01

    def move():
        places.reverse()
        handle.transform = places[0]
        viewport.draw(scene, orbit, out)

    print("a kept scene into an array, 640 x 480, draft")
    print(f"  nothing moves:         {median(lambda: viewport.draw(scene, orbit, out)):.3f}")
    print(f"  the model moves:       {median(move):.3f}")
    print(f"  render().array:        {median(lambda: renderer.render(scene, size=(640, 480), quality='draft', camera=orbit).array):.3f}")
    print(f"  pick:                  {median(lambda: viewport.pick(scene, 320, 240, orbit)):.4f}")
    try:
        import trimesh
    except ImportError:
        return
    ball = trimesh.creation.icosphere(subdivisions=6)
    ball.visual.vertex_colors = (np.abs(ball.vertices) * 255).astype(np.uint8)
    ball.vertex_normals  # Found once, and kept by trimesh.
    textured = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], process=False)
    from PIL import Image

    picture = Image.fromarray(np.random.RandomState(0).randint(0, 255, (1024, 1024, 3), dtype=np.uint8))
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=picture, metallicFactor=0.0)
    textured.visual = trimesh.visual.TextureVisuals(uv=[[0, 0], [1, 0], [1, 1], [0, 1]], material=material)
    for what, mesh in ((f"{len(ball.faces)} triangles", ball), ("a texture of 1024 x 1024", textured)):
        scene = trimesh.Scene(mesh)
        print(f"trimesh, {what}, to a model")
        print(f"  by arrays: {median(lambda: renderer.load(scene), 20, 2):.2f}")
        print(f"  by a GLB:  {median(lambda: renderer.load(scene.export(file_type='glb')), 20, 2):.2f}")


if __name__ == "__main__":
    main()

"""How the package is used, for the type checkers: what they must accept, and (`expect-error`) what they must not."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import overcoat
from overcoat import golden
from overcoat.compat.pyrender import OffscreenRenderer
from overcoat.compat.trimesh import save_image

if TYPE_CHECKING:
    import numpy.typing as npt


def uses() -> None:
    image: overcoat.Image = overcoat.render("x.glb", size=(1, 2), samples=4, camera={"eye": [0, 0, 1], "fov_y_deg": 30})
    pixels: npt.NDArray[np.uint8] = image.array
    linear: npt.NDArray[np.float32] = image.linear
    depth: npt.NDArray[np.float32] = image.aov["depth"]
    png: bytes = image.png()
    text: str = image.hash
    overcoat.render(Path("x.glb"), env=np.zeros((2, 4, 3)), material={"coat": 1}, aov="depth", limits={"triangles": 5})
    overcoat.render(vertices=np.zeros((3, 3)), faces=[[0, 1, 2]])
    overcoat.render(vertices=np.zeros((3, 3)), lines=[[0, 1]], aov=["depth", "instance-id"])
    overcoat.render([overcoat.Mesh(np.zeros((3, 3))), overcoat.Splats([], [], [], [], [])])
    model: overcoat.Model = overcoat.load(b"")
    renderer = overcoat.Renderer(2, simd="avx2")
    renderer.render(model, background="env")
    movie: overcoat.Movie = renderer.turntable(model, frames=3)
    last: overcoat.Image = movie[-1]
    first: overcoat.Movie = movie[:1]
    options = overcoat.Options(size=3)
    overcoat.render(model, **options)
    golden.check(image, "x.png", max_abs=1)
    same: bool = golden.compare(pixels, png).ok
    color, found = OffscreenRenderer(3, 4).render(None)
    data: bytes = save_image(None, (3, 4), background=[0, 0, 0])
    scene = overcoat.Scene()
    car: overcoat.ModelHandle = scene.add_model("x.glb", np.eye(4), animation="walk")
    ball = scene.add_mesh(np.zeros((3, 3)), [[0, 1, 2]])
    placed: overcoat.InstanceHandle = scene.add_instance(ball, scene.add_material({"coat": 1}))
    placed.transform = np.eye(4)
    placed.visible = car.visible
    scene.add_light(type="point", position=[0, 1, 0], intensity=3).intensity = 4
    viewport = overcoat.Viewport(renderer, size=(3, 4), quality="draft", budget=10**7)
    orbit = overcoat.Orbit.around(scene, 0.75)
    drawn: overcoat.Drawn = viewport.draw(scene, orbit, np.zeros((4, 3, 4), np.uint8), region=(0, 0, 1, 1))
    hit = viewport.pick(scene, 1, 2, "front")
    if hit is not None:
        hit.instance.remove()
    overcoat.render(scene, camera=orbit)
    print(drawn, viewport.refine(scene))
    print(linear, depth, text, last, first, same, color, found, data)


def misuses() -> None:
    overcoat.render("x.glb", sample=4)  # expect-error
    overcoat.render("x.glb", samples="4")  # expect-error
    overcoat.render("x.glb", quality="ultra")  # expect-error
    overcoat.render("x.glb", aov="deep")  # expect-error
    overcoat.render("x.glb", shading="cel")  # expect-error
    overcoat.render("x.glb", camera={"eyes": [0, 0, 1]})  # expect-error
    overcoat.Renderer("2")  # expect-error
    overcoat.render("x.glb").save(3)  # expect-error
    overcoat.Viewport(maps=3)  # expect-error
    overcoat.Viewport().draw("x.glb")  # expect-error
    overcoat.Scene().add_instance(overcoat.Scene().add_material(), 3)  # expect-error

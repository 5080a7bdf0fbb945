"""A data set for detection, segmentation and pose: pictures of a model from all around, with COCO's annotations.

    python data_set.py model.glb out --count 1000

Writes `images/NNNNNN.png`, `depth/NNNNNN.npy` (float32, metres along the view, 0 where nothing is) and `annotations.json`: COCO's
`images`, `categories` and `annotations` (<https://cocodataset.org/#format-data>) with uncompressed RLE, `bbox` around the visible
pixels and `area`. Beyond COCO, images have `camera` (`K` and `world_to_camera`, as OpenCV has them) and annotations
`visible_fraction` and `bbox_full`, which hidden parts and those beyond the picture are in.

Each thread draws pictures of its own, with one worker thread: so all processors are busy whatever a picture takes one for. Picture
`k` depends on nothing but `k` and the options: with Ray, `ray.remote(draw)` makes the same pictures on many machines.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Dict, List

import numpy as np
import overcoat

_own = threading.local()


def _drawer(path: str) -> Any:
    """The renderer and the model of this thread."""
    if getattr(_own, "path", None) != path:
        _own.renderer = overcoat.Renderer(threads=1)
        _own.path, _own.model = path, _own.renderer.load(path)
    return _own


def rle(mask: Any) -> Dict[str, Any]:
    """A mask as COCO's uncompressed RLE: lengths of runs by columns, the first of them of zeros."""
    flat = np.asarray(mask, dtype=bool).ravel(order="F")
    ends = np.flatnonzero(flat[1:] != flat[:-1]) + 1
    runs = np.diff(np.concatenate([[0], ends, [flat.size]])).tolist()
    return {"size": list(mask.shape), "counts": [0, *runs] if flat[0] else runs}


def direction(rng: random.Random) -> str:
    """A direction from which the model is seen: all over the upper half of the sphere, by area."""
    height, turn = rng.uniform(0.05, 0.95), rng.uniform(0, 2 * math.pi)
    radius = math.sqrt(1 - height * height)
    return f"{radius * math.cos(turn)},{height},{radius * math.sin(turn)}"


def draw(k: int, path: str, folder: Path, size: int, quality: str, seed: int = 0) -> Dict[str, Any]:
    """Draws picture `k`, writes its files, and returns what the list says of it."""
    own, rng = _drawer(path), random.Random(f"{seed} {k}")
    image = own.renderer.render(
        own.model,
        size=size,
        quality=quality,
        camera={"view": direction(rng)},
        background="#" + "".join(f"{rng.randrange(256):02x}" for _ in range(3)),
        aov=["depth", "object-id"],
    )
    name = f"{k:06}"
    image.save(folder / "images" / f"{name}.png")
    np.save(folder / "depth" / f"{name}.npy", image.aov["depth"])
    ids = image.aov["object-id"]
    annotations: List[Dict[str, Any]] = []
    for of in image.annotations("object-id"):
        if of["px_count_visib"] == 0:
            continue
        annotations.append(
            {
                "image_id": k,
                "category_id": of["id"],
                "segmentation": rle(ids == of["id"]),
                "area": of["px_count_visib"],
                "bbox": of["bbox_visib"],
                "iscrowd": 0,
                "visible_fraction": of["visib_fract"],
                "bbox_full": of["bbox_obj"],
            }
        )
    camera = {"K": image.camera.K.tolist(), "world_to_camera": image.camera.world_to_camera.tolist()}
    told = {"id": k, "file_name": f"images/{name}.png", "width": image.width, "height": image.height, "camera": camera}
    return {"image": told, "annotations": annotations, "names": image.ids["object-id"]}


def make(path: str, folder: Path, count: int, size: int = 512, quality: str = "fast", threads: int = 0) -> Path:
    """Draws and writes the whole set. Returns the path of its list."""
    for part in ("images", "depth"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(threads or overcoat.Renderer().threads) as pool:
        drawn = list(pool.map(lambda k: draw(k, path, folder, size, quality), range(count)))
    annotations = [of for one in drawn for of in one["annotations"]]
    for number, of in enumerate(annotations, 1):
        of["id"] = number
    names = drawn[0]["names"] if drawn else {}
    told = {
        "info": {"description": f"Pictures of {Path(path).name}"},
        "images": [one["image"] for one in drawn],
        "categories": [{"id": id, "name": name or f"object {id}"} for id, name in sorted(names.items())],
        "annotations": annotations,
    }
    target = folder / "annotations.json"
    target.write_text(json.dumps(told))
    return target


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="A data set of pictures of a model, with COCO's annotations")
    parser.add_argument("model")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--quality", default="fast", choices=["draft", "fast", "good", "best"])
    parser.add_argument("--threads", type=int, default=0, help="pictures that are drawn at a time [default: one a processor]")
    given = parser.parse_args()
    print(make(given.model, given.folder, given.count, given.size, given.quality, given.threads))

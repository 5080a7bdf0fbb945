"""Masks, boxes, depth and flow of data sets belong to each other; the example writes a set that another reader understands."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import numpy as np
import overcoat
import pytest

EXAMPLE = Path(__file__).parents[1] / "examples" / "data_set.py"

#: Boxes by their names: lower and upper corners.
BOXES = {"left": ((-1.0, 0.0, -0.5), (-0.2, 1.0, 0.5)), "right": ((0.2, 0.0, -0.5), (1.0, 1.5, 0.5))}


def obj() -> str:
    """The boxes as a model."""
    lines, first = [], 1
    for name, corners in BOXES.items():
        lines.append(f"o {name}")
        for k in range(8):
            lines.append("v " + " ".join(str(corners[k >> axis & 1][axis]) for axis in range(3)))
        for a, b, c, d in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)):
            lines.append("f " + " ".join(str(first + corner) for corner in (a, b, c, d)))
        first += 8
    return "\n".join(lines)


@pytest.fixture
def boxes(tmp_path):
    path = tmp_path / "boxes.obj"
    path.write_text(obj())
    return str(path)


def off_box(points, name):
    """Distances of points from the surface of a box."""
    low, high = (np.array(corner) for corner in BOXES[name])
    outside = np.maximum(np.maximum(low - points, points - high), 0)
    inside = np.minimum(points - low, high - points).min(axis=1)
    return np.hypot(np.linalg.norm(outside, axis=1), np.maximum(inside, 0))


def decoded(segmentation):
    """The mask of an uncompressed RLE, by the words of COCO's format."""
    height, width = segmentation["size"]
    assert sum(segmentation["counts"]) == height * width
    value, flat = 0, []
    for run in segmentation["counts"]:
        flat.extend([value] * run)
        value = 1 - value
    return np.array(flat, dtype=bool).reshape((width, height)).T


def test_the_example_writes_a_set_that_agrees_with_itself(boxes, tmp_path):
    spec = importlib.util.spec_from_file_location("data_set", EXAMPLE)
    data_set = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(data_set)
    told = json.loads(data_set.make(boxes, tmp_path / "set", 4, size=96, threads=2).read_text())
    assert [image["id"] for image in told["images"]] == [0, 1, 2, 3]
    names = {category["id"]: category["name"] for category in told["categories"]}
    assert set(names.values()) == {"left", "right"}
    assert len({of["id"] for of in told["annotations"]}) == len(told["annotations"]) >= 6
    for image in told["images"]:
        assert (tmp_path / "set" / image["file_name"]).read_bytes()[:4] == b"\x89PNG"
        depth = np.load(tmp_path / "set" / "depth" / f"{image['id']:06}.npy")
        K, outward = np.array(image["camera"]["K"]), np.array(image["camera"]["world_to_camera"])
        rows, columns = np.mgrid[: image["height"], : image["width"]] + 0.5
        own = np.stack([(columns - K[0, 2]) / K[0, 0] * depth, (rows - K[1, 2]) / K[1, 1] * depth, depth], axis=2)
        points = (own - outward[:3, 3]) @ outward[:3, :3]
        seen = np.zeros(depth.shape, dtype=int)
        for of in (of for of in told["annotations"] if of["image_id"] == image["id"]):
            mask = decoded(of["segmentation"])
            seen += mask
            assert of["area"] == mask.sum() > 0
            ys, xs = np.nonzero(mask)
            box = [xs.min(), ys.min(), xs.max() + 1 - xs.min(), ys.max() + 1 - ys.min()]
            assert of["bbox"] == box
            left, top, width, height = of["bbox_full"]
            assert left <= box[0] + 0.5 and top <= box[1] + 0.5
            assert left + width >= box[0] + box[2] - 0.5 and top + height >= box[1] + box[3] - 0.5
            assert 0 < of["visible_fraction"] <= 1
            # On the surface, within single precision at the distance of the camera; beside its borders by 1/256 pixel, more
            # where it is seen at an angle.
            off = off_box(points[mask], names[of["category_id"]])
            assert (off < 1e-6 * depth[mask]).mean() > 0.99
            assert off.max() < depth.max() / K[0, 0] / 32
        assert ((seen == 1) == (depth > 0)).all() and seen.max() == 1


def test_what_hides_what_is_told_in_numbers(boxes):
    # From the left, the left box hides most of the right one.
    image = overcoat.render(boxes, size=64, camera={"view": "-1,0,0", "ortho_height": 0}, aov=["object-id", "instance-id"])
    assert image.aov["object-id"].dtype == np.uint32
    assert sorted(image.ids["object-id"].values()) == ["left", "right"]
    found = {of["name"]: of for of in image.annotations()}
    assert found["left"]["visib_fract"] == 1
    right = found["right"]
    assert 0.3 < right["visib_fract"] < 0.37
    assert right["px_count_visib"] == (image.aov["object-id"] == right["id"]).sum()
    assert len(image.annotations("instance-id")) == 2
    with pytest.raises(overcoat.OptionError, match="object-id"):
        image.annotations("material-id")
    with pytest.raises(overcoat.OptionError):
        image.annotations("depth")


def test_flow_leads_to_the_place_in_the_other_picture(boxes):
    options = {"size": 64, "aov": ["position", "instance-id", "depth"], "quality": "draft"}
    first = overcoat.render(boxes, camera={"view": "0.3,0.4,1"}, **options)
    second = overcoat.render(boxes, camera={"view": "0.5,0.4,1"}, **options)
    flow = first.flow_to(second)
    assert flow.shape == (64, 64, 2) and flow.dtype == np.float32
    seen = first.aov["depth"] > 0
    assert (np.isnan(flow).all(axis=2) == ~seen).all()
    points = np.concatenate([first.aov["position"][seen], np.ones((seen.sum(), 1))], axis=1)
    own = (points @ second.camera.world_to_camera.T)[:, :3]
    place = (own @ second.camera.K.T)[:, :2] / own[:, 2:]
    rows, columns = np.mgrid[:64, :64] + 0.5
    expected = place - np.stack([columns[seen], rows[seen]], axis=1)
    assert np.abs(flow[seen] - expected).max() < 1e-3
    assert np.nanmax(np.abs(first.flow_to(first))) < 1e-3
    with pytest.raises(overcoat.OptionError, match="sizes"):
        first.flow_to(overcoat.render(boxes, size=32, aov="depth"))
    with pytest.raises(overcoat.OptionError, match="position"):
        overcoat.render(boxes, size=64, aov="depth").flow_to(second)
    with pytest.raises(overcoat.OptionError, match="aov"):
        overcoat.render(boxes, size=64).flow_to(second)

#!/usr/bin/env python3
"""Runs overcoat-step on the test model, whole, cut and damaged, and compares what comes with what must."""
import json
import os
import random
import struct
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
PROGRAM = os.path.join(HERE, "overcoat-step")


def run(path, *options):
    done = subprocess.run([PROGRAM, *options, path], capture_output=True, timeout=60)
    return done.returncode, done.stdout, done.stderr.decode(errors="replace")


def parsed(glb):
    magic, version, length, json_length = struct.unpack("<4sIII", glb[:16])
    assert (magic, version, length) == (b"glTF", 2, len(glb)), glb[:16]
    return json.loads(glb[20 : 20 + json_length])


def check_whole(path):
    code, glb, told = run(path)
    assert (code, told) == (0, ""), (code, told)
    scene = parsed(glb)
    names = [node["name"] for node in scene["nodes"]]
    assert names == ["", "Pair ä", "Left", "Right"], names
    assert len(scene["meshes"]) == 1, "instances share their mesh"
    assert [node.get("mesh") for node in scene["nodes"]] == [None, None, 0, 0]
    assert scene["nodes"][3]["matrix"][12:15] == [50, 0, 0]
    colours = [material["pbrMetallicRoughness"]["baseColorFactor"] for material in scene["materials"]]
    assert sorted(colours) == [[0, 0, 1, 1], [1, 0, 0, 1]], colours
    counts = {}
    for primitive in scene["meshes"][0]["primitives"]:
        counts[tuple(colours[primitive["material"]])] = scene["accessors"][primitive["indices"]]["count"]
    assert counts == {(0, 0, 1, 1): 30, (1, 0, 0, 1): 6}, counts
    assert run(path)[1] == glb, "the same bytes twice"
    assert scene["nodes"][0]["matrix"] == [0.001, 0, 0, 0, 0, 0, -0.001, 0, 0, 0.001, 0, 0, 0, 0, 0, 1]


def check_damaged(path, scratch):
    with open(path, "rb") as file:
        whole = file.read()
    dice = random.Random(1)
    damaged = [(f"cut at {n}", whole[:n]) for n in range(0, len(whole), max(1, len(whole) // 40))]
    for k in range(int(os.environ.get("FLIPS", "100"))):
        bytes_ = bytearray(whole)
        for _ in range(dice.randint(1, 8)):
            bytes_[dice.randrange(len(bytes_))] = dice.randrange(256)
        damaged.append((f"flip {k}", bytes(bytes_)))
    drawn = 0
    for what, content in damaged:
        with open(scratch, "wb") as file:
            file.write(content)
        code, glb, told = run(scratch)
        assert code in (0, 1), (what, code, told)
        if code == 0:
            parsed(glb)
            drawn += 1
            assert not what.startswith("cut") or "warning: the file is cut short" in told, (what, told)
        else:
            assert glb == b"" and told.strip().splitlines()[-1].startswith("overcoat-step: "), (what, told)
    print(f"{len(damaged)} damaged files: {drawn} drawn, {len(damaged) - drawn} refused, none has ended the program")


def main(folder):
    model = os.path.join(folder, "pair.step")
    with open(model, "w", encoding="ascii") as file:
        subprocess.run([sys.executable, os.path.join(HERE, "make_test_model.py")], stdout=file, check=True)
    check_whole(model)
    check_damaged(model, os.path.join(folder, "damaged.step"))
    for arguments in (["--pixels", "0", model], ["--colour", model], ["/no/such/file"], []):
        done = subprocess.run([PROGRAM, *arguments], capture_output=True)
        assert done.returncode == 1 and done.stdout == b"" and done.stderr.startswith(b"overcoat-step: "), arguments
    print("overcoat-step: passed")


main(sys.argv[1])

#!/usr/bin/env python3
"""How a translated paint looks, beside what `overcoat translate` reports.

Usage:  benches/translations.py [OVERCOAT] [MODEL.glb] [MATERIAL-IN-IT] [--models gltf,three,...]

Every built-in material is translated for each shading model and put into a material of a glTF file (the sports car's `paint`).
Source and copy are then drawn apart from the report, and FLIP between the two pictures is "seen". Prints a line a pair and, at
the end, Spearman's rank correlation of each reported number with what is seen.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SIZE = ["--size", "256x256"]


def run(program, *args):
    done = subprocess.run([program, *map(str, args)], capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr.strip()


def ranks(values):
    order = sorted(range(len(values)), key=values.__getitem__)
    out = [0.0] * len(values)
    first = 0
    while first < len(order):
        last = first
        while last + 1 < len(order) and values[order[last + 1]] == values[order[first]]:
            last += 1
        for place in order[first : last + 1]:
            out[place] = (first + last) / 2
        first = last + 1
    return out


def correlation(a, b):
    a, b = ranks(a), ranks(b)
    mean_a, mean_b = sum(a) / len(a), sum(b) / len(b)
    both = sum((x - mean_a) * (y - mean_b) for x, y in zip(a, b))
    own = sum((x - mean_a) ** 2 for x in a) * sum((y - mean_b) ** 2 for y in b)
    return both / own**0.5 if own > 0 else float("nan")


def pair(program, options, material, model, folder):
    """Reported numbers and the pictures of one translation, or the reason that there is none."""
    copy = folder / "copy.glb"
    into = ["--into", options.file, "--material", options.material, "-o", copy, "--json", "--force"]
    code, out, error = run(program, "translate", material, "--to", model, *into)
    if code:
        return None, error
    name = f"{material}--{model}.png"
    wanted = ["render", options.file, "--material", f"{options.material}={material}", *SIZE]
    for command in ([*wanted, "-o", folder / "source" / name], ["render", copy, "--shading", model, *SIZE, "-o", folder / "copy" / name]):
        code, _, error = run(program, *command)
        if code:
            return None, error
    report = json.loads(out)
    reported = {"fit": report["after"]["all"], "sphere": report["flip"]["sphere"], "file": report["flip"].get("file")}
    return (name, material, model, reported), None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", default=str(ROOT / "target/release/overcoat"))
    parser.add_argument("file", nargs="?", default=str(ROOT / "assets/models/sports-car.glb"))
    parser.add_argument("material", nargs="?", default="paint")
    parser.add_argument("--models", default="gltf,three,openpbr,stacklit-d", help="shading models, with commas between")
    options = parser.parse_args()
    code, out, error = run(options.program, "materials", "--json")
    if code:
        sys.exit(error)
    materials = [material["name"] for material in json.loads(out)["materials"]]
    models = options.models.split(",")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "source").mkdir()
        (folder / "copy").mkdir()
        rows = []
        for model in models:
            for material in materials:
                row, error = pair(options.program, options, material, model, folder)
                if row is None:
                    print(f"{material:28} {model:14} {error}")
                else:
                    rows.append(row)
        _, out, _ = run(options.program, "golden", "check", folder / "source", folder / "copy", "--json")
        files = json.loads(out)["files"]
        seen = {file["name"]: file["metrics"]["flip_mean"] for file in files if file.get("metrics")}
    rows = [(*row[1:], seen[row[0]]) for row in rows if row[0] in seen]
    for material, model, reported, value in rows:
        told = "".join(f" {name} {number:.4f}" for name, number in reported.items() if number is not None)
        print(f"{material:28} {model:14}{told} seen {value:.4f}")
    for name in ["fit", "sphere", "file"]:
        pairs = [(row[2][name], row[3]) for row in rows if row[2][name] is not None]
        if len(pairs) > 1:
            print(f"rank correlation of {name}: {correlation(*map(list, zip(*pairs))):.3f} over {len(pairs)} pairs")


if __name__ == "__main__":
    main()

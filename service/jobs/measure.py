#!/usr/bin/env python3
"""What one model costs: processor time and bytes over a folder of models, as quantiles for simulate.py.

Draws the folder by one worker of `overcoat-service batch`, several times for each size, and keeps the least time of each model: on a
machine that others use, what is above it is theirs (a busy one still adds half: let it be quiet). The table holds no names.

Run:  measure.py overcoat-service MODELS > measured.tsv
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

QUANTILES = [0, 1, 2, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80, 85, 90, 92, 94, 96, 98, 99, 100]
# What text models say of the files beside them.
REFERENCES = re.compile(r'"uri"\s*:\s*"([^":]+)"|^(?:mtllib|map_\w+|norm|bump)\s.*?(\S+)\s*$', re.M)


def input_bytes(path, depth=2):
    """The bytes of a file and of those that it names."""
    total = path.stat().st_size
    if depth and path.suffix.lower() in (".gltf", ".obj", ".mtl"):
        for found in set(REFERENCES.findall(path.read_text(errors="replace"))):
            beside = path.parent / "".join(found)
            if beside.is_file():
                total += input_bytes(beside, depth - 1)
    return total


def run(program, models, size):
    """Seconds and bytes of each picture, and what was refused."""
    with tempfile.TemporaryDirectory() as to:
        subprocess.run([program, "batch", models, "-o", to, "--size", str(size), "--quality", "fast", "--workers", "1",
                        "--threads", "1", "--quiet"], check=False)
        rows = [json.loads(line) for line in (pathlib.Path(to) / "report.jsonl").read_text().splitlines()]
    return {row["model"]: (sum(row["stages_ms"].values()) / 1000, sum(file["bytes"] for file in row["files"]))
            for row in rows if row["status"] == "drawn"}


def quantile(values, percent):
    at = (len(values) - 1) * percent / 100
    low = int(at)
    high = min(low + 1, len(values) - 1)
    return values[low] + (values[high] - values[low]) * (at - low)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program")
    arguments.add_argument("models")
    arguments.add_argument("--rounds", type=int, default=5)
    args = arguments.parse_args()
    columns = {}
    for size in (256, 512):
        rounds = [run(args.program, args.models, size) for _ in range(args.rounds)]
        names = set.intersection(*(set(round) for round in rounds))
        columns[f"seconds_{size}"] = sorted(min(round[name][0] for round in rounds) for name in names)
        columns[f"picture_bytes_{size}"] = sorted(rounds[0][name][1] for name in names)
        columns["model_bytes"] = sorted(input_bytes(pathlib.Path(args.models) / name) for name in names)
    print(f"# {len(names)} models, one thread of one worker, quality fast, 8 samples, PNG; least of {args.rounds} runs")
    print("\t".join(["percent", *columns]))
    for percent in QUANTILES:
        row = [quantile(values, percent) for values in columns.values()]
        print("\t".join([str(percent), *(f"{v:.4f}" if v < 100 else f"{v:.0f}" for v in row)]))
    for name, values in columns.items():
        print(f"{name}: mean {sum(values) / len(values):.4f}", file=sys.stderr)


if __name__ == "__main__":
    main()

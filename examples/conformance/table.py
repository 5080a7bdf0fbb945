"""Writes the table of the book from tables of `score.py --tsv` and the pack's own, in Markdown.

    python table.py PACK cycles.tsv three.tsv ...

A column for each file, named as it is, and for each model of the pack: error in percent, bold where the scene passes, with a 1
where it passes by the truth of one bounce alone.
"""

import csv
import os
import sys


def rows(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def cell(row):
    if row is None:
        return "-"
    error = f"{100 * float(row['error']):.1f}"
    if row["verdict"] == "pass":
        return f"**{error}**"
    return error + ("<sup>1</sup>" if row["one_verdict"] == "pass" else "")


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    pack, *tables = sys.argv[1:]
    columns, noise = {}, {}
    for path in tables:
        columns[os.path.splitext(os.path.basename(path))[0]] = {row["scene"]: row for row in rows(path)}
    for row in rows(os.path.join(pack, "engines", "scores.tsv")):
        columns.setdefault(f"`{row['model']}`", {})[row["scene"]] = row
        noise[row["scene"]] = row["noise"]
    with open(os.path.join(pack, "scenes.tsv"), encoding="utf-8") as file:
        scenes = [line.split("\t")[0] for line in file.read().splitlines()[1:]]
    print("| scene | noise |", " | ".join(columns), "|")
    print("|---|---:|" + "---:|" * len(columns))
    for scene in scenes:
        cells = [cell(column.get(scene)) for column in columns.values()]
        print(f"| `{scene}` | {100 * float(noise[scene]):.1f} |", " | ".join(cells), "|")
    passed = lambda column, key: sum(row[key] == "pass" for row in column.values())
    print(f"| passed of {len(scenes)} | |", " | ".join(str(passed(c, "verdict")) for c in columns.values()), "|")
    either = lambda column: sum("pass" in (row["verdict"], row["one_verdict"]) for row in column.values())
    print("| the same by one bounce | |", " | ".join(str(either(c)) for c in columns.values()), "|")


if __name__ == "__main__":
    main()

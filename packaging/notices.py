#!/usr/bin/env python3
"""Prints the licences of all packages that are compiled into a program: most of them ask for it.

Usage: packaging/notices.py TARGET PROGRAM   (as x86_64-unknown-linux-gnu overcoat; needs cargo)
"""

import json
import pathlib
import subprocess
import sys

NAMES = ("licen", "copying", "notice", "unlicense")


def compiled(target, program):
    """The packages that the program is made of, by name and version: not those that only build or test it."""
    command = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", target]
    metadata = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    root = next(id for id, package in packages.items() if package["name"] == program)
    found, waiting = set(), [root]
    while waiting:
        id = waiting.pop()
        if id in found:
            continue
        found.add(id)
        for dependency in nodes[id]["deps"]:
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                waiting.append(dependency["pkg"])
    # Its own packages come from no registry.
    others = (packages[id] for id in found if packages[id]["source"])
    return sorted(others, key=lambda package: (package["name"], package["version"]))


def texts(package):
    """The licence files of a package."""
    folder = pathlib.Path(package["manifest_path"]).parent
    files = [path for path in folder.iterdir() if path.is_file() and path.name.lower().startswith(NAMES)]
    return [path.read_text(errors="replace").strip() for path in sorted(files)]


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__.strip())
    seen = {}
    for package in compiled(sys.argv[1], sys.argv[2]):
        name = f"{package['name']} {package['version']}"
        print("=" * 100)
        print(f"{name}, {package['license'] or 'see below'}, {package['repository'] or 'https://crates.io'}")
        for author in package["authors"]:
            print(f"  {author}")
        found = texts(package)
        if not found:
            print("  (the package has no file with its licence)")
        for text in found:
            # Many have the same words.
            if text in seen:
                print(f"\nA text as that of {seen[text]}.")
            else:
                seen[text] = name
                print(f"\n{text}")


main()

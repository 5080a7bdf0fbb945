#!/usr/bin/env python3
"""The examples of this folder, run for real on this machine: a thousand small models, drawn by one process and then by Dask (and by
Ray, if it is installed) while its workers are killed. Nothing may be lost or doubled, and every picture must have the same bytes.

Install:  pip install dask distributed   (and "ray[data]")
Run:      test_jobs.py PROGRAM [--models 1000] [--kills 6]
"""
import argparse
import hashlib
import json
import os
import pathlib
import random
import signal
import struct
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).parent


def box(path, size):
    """An STL file of a box."""
    x, y, z = size
    corners = [(a * x, b * y, c * z) for a in (0, 1) for b in (0, 1) for c in (0, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [(a, b, c) for a, b, c, d in faces] + [(a, c, d) for a, b, c, d in faces]
    rows = [struct.pack("<12fH", 0, 0, 0, *corners[a], *corners[b], *corners[c], 0) for a, b, c in triangles]
    path.write_bytes(bytes(80) + struct.pack("<I", len(rows)) + b"".join(rows))


def make_models(folder, count):
    """Boxes of all shapes, and among them files that are none."""
    dice = random.Random(7)
    for number in range(count):
        path = folder / f"{number % 10}" / f"{number}.stl"
        path.parent.mkdir(exist_ok=True)
        if number % 20 == 0:
            path.write_bytes(dice.randbytes(300))
        else:
            box(path, [dice.uniform(0.2, 3) for _ in range(3)])


def pictures(folder):
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in folder.rglob("*.png")}


def check(name, wanted, to, count):
    found = pictures(to)
    assert found == wanted, f"{name}: {len(found)} pictures for {len(wanted)}, or other bytes"
    rows = [json.loads(line) for report in to.glob("report*.jsonl") for line in report.read_text().splitlines()]
    made = [row["out"] for row in rows if row["status"] in ("drawn", "copied")]
    assert len(made) == len(set(made)) == len(wanted), f"{name}: {len(made)} made, {len(set(made))} of them once"
    assert len({row["out"] for row in rows}) == count, f"{name}: not every model is in a report"
    print(f"{name}: {len(wanted)} pictures, each made once, all as by one process")


def with_dask(program, models, to, shards, kills):
    from dask.distributed import Client, LocalCluster
    sys.path.insert(0, str(HERE))
    import dask_batch

    dice = random.Random(11)
    with LocalCluster(n_workers=4, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        client.upload_file(str(HERE / "dask_batch.py"))
        tasks = [client.submit(dask_batch.draw_shard, program, str(models), str(to), index, shards,
                               ["--size", "128", "--samples", "16"], retries=20, pure=False) for index in range(shards)]
        killed = 0
        while killed < kills and not all(task.done() for task in tasks):
            time.sleep(0.25)
            running = list(client.run(os.getpid).values())
            if running:
                os.kill(dice.choice(running), signal.SIGKILL)
                killed += 1
        client.gather(tasks)
        print(f"dask: {killed} workers killed")
        assert killed >= min(kills, 2), "the work was done before anything could be killed"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--models", type=int, default=1000)
    parser.add_argument("--kills", type=int, default=6)
    arguments = parser.parse_args()
    program = str(pathlib.Path(arguments.program).resolve())
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        models, once = folder / "models", folder / "once"
        models.mkdir()
        make_models(models, arguments.models)
        command = [program, "batch", str(models), "-o", str(once), "--size", "128", "--samples", "16", "--quiet"]
        code = subprocess.run(command).returncode
        assert code == 1, f"exit code {code}: some models are damaged"
        wanted = pictures(once)
        # Of the files that are no models some happen to be ones.
        assert len(wanted) >= arguments.models - arguments.models // 20
        check("one process", wanted, once, arguments.models)
        with_dask(program, models, folder / "dask", 24, arguments.kills)
        check("dask", wanted, folder / "dask", arguments.models)
        try:
            import ray  # noqa: F401
        except ImportError:
            print("ray: not installed, left out")
            return
        command = [sys.executable, str(HERE / "ray_batch.py"), str(models), str(folder / "ray"), "--program", program,
                   "--size", "128"]
        subprocess.run([program, "batch", str(models), "-o", str(folder / "plain"), "--size", "128", "--quiet"])
        subprocess.run(command, check=True)
        check("ray", pictures(folder / "plain"), folder / "ray", arguments.models)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Thumbnails by Dask: one task for a shard, on a cluster of processes that may die.

Install:  pip install dask distributed
Run:      dask_batch.py MODELS PICTURES [--program overcoat-service] [--shards 16] [--workers 4] [--size 256]

Each task runs `overcoat-service batch --shard I/N --resume`. Dask runs the tasks of a worker that dies again elsewhere; what
such a worker had finished is kept, since the report of its shard says so. At the end all reports are one.
"""
import argparse
import json
import pathlib
import subprocess


def draw_shard(program, models, pictures, index, count, options):
    """Does one shard; returns its records. Raises if the program could not do its work."""
    report = pathlib.Path(pictures) / f"report-{index}-of-{count}.jsonl"
    command = [program, "batch", models, "-o", pictures, "--shard", f"{index}/{count}", "--resume", "--quiet",
               "--report", str(report), "--workers", "1", *options]
    done = subprocess.run(command, capture_output=True, text=True)
    # 1: some models have no picture, and the report says why.
    if done.returncode not in (0, 1) or not report.exists():
        raise RuntimeError(f"shard {index}: exit code {done.returncode}: {done.stderr.strip()}")
    return latest(report)


def latest(report):
    """The last record of each picture."""
    rows = (json.loads(line) for line in pathlib.Path(report).read_text().splitlines())
    return list({row["out"]: row for row in rows}.values())


def read_arguments(about):
    """The command line of this example, and of Ray's."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models")
    parser.add_argument("pictures")
    parser.add_argument("--program", default="overcoat-service")
    parser.add_argument("--shards", type=int, default=16)
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--size", default="256")
    return parser.parse_args()


def main():
    arguments = read_arguments(__doc__)
    from dask.distributed import Client, LocalCluster

    with LocalCluster(n_workers=arguments.workers, threads_per_worker=1, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            tasks = [client.submit(draw_shard, arguments.program, arguments.models, arguments.pictures, index,
                                   arguments.shards, ["--size", arguments.size], retries=5, pure=False)
                     for index in range(arguments.shards)]
            records = [record for shard in client.gather(tasks) for record in shard]
    made = sum(record["status"] != "failed" for record in records)
    print(json.dumps({"pictures": made, "failed": len(records) - made}))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Thumbnails by Ray Data: a data set of shards, mapped by actors that may die.

Install:  pip install "ray[data]"
Run:      ray_batch.py MODELS PICTURES [--program overcoat-service] [--shards 16] [--workers 4] [--size 256]

Ray runs the tasks of a process that dies again. What it had finished is kept, as with dask_batch.py, whose function this uses.
"""
import argparse
import json

from dask_batch import draw_shard


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models")
    parser.add_argument("pictures")
    parser.add_argument("--program", default="overcoat-service")
    parser.add_argument("--shards", type=int, default=16)
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--size", default="256")
    arguments = parser.parse_args()
    import ray

    ray.init(num_cpus=arguments.workers, include_dashboard=False, log_to_driver=False)

    def draw(row):
        records = draw_shard(arguments.program, arguments.models, arguments.pictures, int(row["id"]), arguments.shards,
                             ["--size", arguments.size])
        made = sum(record["status"] != "failed" for record in records)
        return {"shard": row["id"], "pictures": made, "failed": len(records) - made}

    shards = ray.data.range(arguments.shards, override_num_blocks=arguments.shards)
    rows = shards.map(draw, num_cpus=1).take_all()
    print(json.dumps({key: sum(row[key] for row in rows) for key in ("pictures", "failed")}))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Thumbnails by Ray Data: a data set of shards, mapped by actors that may die.

Install:  pip install "ray[data]"
Run:      ray_batch.py MODELS PICTURES [--program overcoat-service] [--shards 16] [--workers 4] [--size 256]

Ray runs the tasks of a process that dies again. What it had finished is kept, as with dask_batch.py, whose function this uses.
"""
import json

from dask_batch import draw_shard, read_arguments


def main():
    arguments = read_arguments(__doc__)
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

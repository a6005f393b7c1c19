#!/usr/bin/python3
"""Bakes the files of a list on the workers of a Dask cluster, a part of the list at a time.

    bake_with_dask.py assets.txt baked/ tcp://scheduler:8786

List and folder must be at the same place for all workers, and `recede` on their PATH. Without an address two workers
are started here. A part that a lost worker had begun is given to another one, which bakes what is left of it.
"""

import json
import subprocess
import sys

import distributed


def bake_part(assets: str, folder: str, part: int, parts: int) -> dict:
    run = subprocess.run(["recede", "batch", assets, "-o", folder, "--part", f"{part}/{parts}", "--json"],
                         stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if not run.stdout:
        raise RuntimeError(run.stderr.strip())
    return json.loads(run.stdout)


def main(assets: str, folder: str, address: str | None = None) -> int:
    with open(assets) as lines:
        n_assets = sum(1 for line in lines if line.strip() and not line.startswith("#"))
    parts = min(n_assets, 100)
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1) if address is None else None
    with distributed.Client(address or cluster) as client:
        tasks = [client.submit(bake_part, assets, folder, part, parts, pure=False) for part in range(1, parts + 1)]
        results = client.gather(tasks)
    if cluster is not None:
        cluster.close()
    for result in results:
        for asset in result["assets"]:
            print(f"{asset['state']:12} {asset['input']} {asset.get('reason', '')}".rstrip())
    return 1 if any(result["failed"] for result in results) else 0


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))

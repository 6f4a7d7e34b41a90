#!/usr/bin/env python3
"""many_solves_dask.py FOLDER: a study of 3 x 3 furnaces, each solved by one thread. Needs the package zonal and dask.distributed, or ray.

    many_solves_dask.py FOLDER --workers 2                    processes of this machine
    many_solves_dask.py FOLDER --scheduler tcp://HOST:8786    workers of a running `dask scheduler`
    many_solves_dask.py FOLDER --ray [--scheduler auto]       Ray in place of Dask

All workers see FOLDER under the same path. A case whose solution exists there is read, not solved. FOLDER/study.csv gets one row for each case.
"""

import argparse
import csv
import itertools
import os
from pathlib import Path

import zonal as zn

EXTINCTIONS, HEIGHTS = [0.25, 0.5, 1.0], [3.0, 4.0, 5.0]  # 1/m, m
COLUMNS = ["extinction", "height", "status", "power_W", "power_error_W", "gas_K", "source"]


def furnace(extinction, height, cells):
    scene = zn.Scene("furnace", mode="thermal")
    faces = {"z0": {"temperature": 1200, "emissivity": 0.85}, "z1": {"temperature": 400}}
    scene.surface(room=([0, 0, 0], [2, 2, height]), name="wall", temperature=900, emissivity=0.7, faces=faces)
    scene.medium([0, 0, 0], [2, 2, height], cells=[cells, cells, 2 * cells], extinction=extinction, heat_source=5000)
    scene.settings(patch_rule="voxels")
    return scene


def solve_case(folder, cells, extinction, height):
    """Solves one case, or reads its solution. Returns a small row, not the solution."""
    os.environ.setdefault("RAYON_NUM_THREADS", "1")  # for reading and writing; `threads` is that of the solve
    path = Path(folder) / f"extinction-{extinction}-height-{height}.npz"
    source = "read" if path.exists() else "solved"
    try:
        if source == "read":
            solution = zn.load_solution(path)
        else:
            solution = furnace(extinction, height, cells).solve(threads=1, max_memory=4)
            solution.save(path)  # writes a file beside it and renames that: the name stands for a whole file
    except zn.Error as error:
        return dict(zip(COLUMNS, [extinction, height, f"refused: {error}"]))
    table, status = solution.table, solution.report["status"]
    floor, gas = table["name"].index("wall.z0"), table["name"].index("medium")
    status = "converged" if all(s == "converged" for s in status) else "not converged"
    numbers = [table["net_power"][floor], table["net_power_error"][floor], table["temperature"][gas]]
    return dict(zip(COLUMNS, [extinction, height, status, *map(float, numbers), source]))


def rows_by_dask(cases, workers, scheduler):
    from distributed import Client, LocalCluster, as_completed

    cluster = scheduler or LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None)
    with Client(cluster) as client:
        futures = [client.submit(solve_case, *case, pure=False) for case in cases]
        for future in as_completed(futures):
            yield future.result()


def rows_by_ray(cases, workers, scheduler):
    import ray

    ray.init(address=scheduler, num_cpus=None if scheduler else workers, include_dashboard=None if scheduler else False)
    task = ray.remote(num_cpus=1)(solve_case)
    waiting = [task.remote(*case) for case in cases]
    while waiting:
        done, waiting = ray.wait(waiting)
        yield ray.get(done[0])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--cells", type=int, default=4, help="voxels along x and y; twice as many along z")
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--scheduler", help="address of running workers")
    parser.add_argument("--ray", action="store_true")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    folder = str(given.folder.resolve())
    cases = [(folder, given.cells, *case) for case in itertools.product(EXTINCTIONS, HEIGHTS)]
    rows = []
    for row in (rows_by_ray if given.ray else rows_by_dask)(cases, given.workers, given.scheduler):
        rows.append(row)
        print(*row.values(), flush=True)
    rows.sort(key=lambda row: (row["extinction"], row["height"]))
    partial = given.folder / ".study.csv.partial"
    with open(partial, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    os.replace(partial, given.folder / "study.csv")


if __name__ == "__main__":
    main()

"""Compares the speed of a sweep of 20,000 designs with and without a Ray cluster of two single-processor nodes.

    PHALANX=target/release/phalanx python python/bench/ray_scaling.py [--runs 20000] [--rounds 3]     (from the root)

Prints the rates of `phalanx sweep` and of `phalanx.ray.sweep` in alternation, by wall time and by processor time (which
depends little on other processes), and the wall time of a sweep during which a worker and then a node are killed. All
results must have the same bytes. With --evaluate, it also compares the rate of 1,000 designs through `phalanx.evaluate`
with that of `phalanx sweep`.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import json

import numpy as np
import phalanx
import phalanx.ray
from cluster import Node, cluster, kill, wait_for_nodes

STUDY = """
name = "scaling"

[scene]
sizing = "rigid"
contact.friction.mu_static = 0.8

[[axes]]
field = "design.base"
from = "12 mm"
to = "22 mm"

[[axes]]
field = "design.l21_fraction"
from = 0.0
to = 1.0

[[axes]]
field = "design.phi22"
from = "90 deg"
to = "120 deg"

[[axes]]
field = "design.arm_ratio"
from = 0.3334
to = 0.6666

[sample]
count = {runs}
"""


def cpu_s(nodes: list[Node]) -> float:
    """Returns the processor time of all processes of a cluster so far, including Ray's own, s."""
    ticks = 0
    for pid in {pid for node in nodes for pid in node.processes()}:
        try:
            fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        # utime, stime, cutime and cstime: the process and its reaped children.
        ticks += sum(int(field) for field in fields[11:15])
    return ticks / os.sysconf("SC_CLK_TCK")


def sweep_without_ray(study: Path, out: Path) -> tuple[float, float]:
    """Returns wall time and processor time of `phalanx sweep`, s.

    It runs in a separate session, like the nodes, because a kernel may share processor time by session.
    """
    for old in out.parent.glob(out.name + "*"):
        old.unlink()
    start, before = time.monotonic(), os.times()
    call = [os.environ["PHALANX"], "sweep", study, "--out", out, "--threads", "2", "--quiet"]
    subprocess.run(call, check=True, capture_output=True, start_new_session=True)
    after = os.times()
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return time.monotonic() - start, used


def sweep_with_ray(study: Path, out: Path) -> phalanx.ray.Swept:
    shutil.rmtree(f"{out}.parts", ignore_errors=True)
    return phalanx.ray.sweep(study, out)


def kill_worker_then_node(parts: Path, head: Node, second: Node, shards: int, sweep_ended: threading.Event) -> None:
    """Kills a worker after a third of the parts and a node after half of them."""
    finished = lambda: len(list(parts.glob("part-*.parquet")))  # noqa: E731
    while not sweep_ended.is_set() and finished() < shards // 3:
        time.sleep(0.02)
    while not sweep_ended.is_set():
        if worker := head.busy_worker():
            print(f"  killed a worker after {finished()} of {shards} parts")
            kill(worker)
            break
        time.sleep(0.01)
    while not sweep_ended.is_set() and finished() < shards // 2:
        time.sleep(0.02)
    if not sweep_ended.is_set():
        print(f"  killed the second node after {finished()} of {shards} parts")
        second.kill()


def compare_evaluate(rounds: int, directory: Path) -> None:
    """Compares 1,000 designs through `evaluate` with the same designs as a study, in alternation.

    The wall time of the study is the one that the program reports for its runs; its processor time includes the start
    of the process, which is about 0.1 %.
    """
    study, out = directory / "thousand.toml", directory / "thousand.parquet"
    study.write_text(STUDY.format(runs=1000))
    table = phalanx.sweep(study)
    fields = {
        "design.base": table["design.base_m"],
        "design.l21_fraction": table["design.l21_fraction"],
        "design.phi22": table["design.phi22_rad"],
        "design.arm_ratio": table["design.arm_ratio"],
    }
    scene = {"sizing": "rigid", "contact": {"friction": {"mu_static": 0.8}}}
    scene["design"] = {"base": "15.5 mm", "l21_fraction": 1.0, "phi22": "120 deg", "arm_ratio": 0.5}
    base = phalanx.Scene.from_dict(scene)
    evaluate_times: list[tuple[float, float]] = []
    sweep_times: list[tuple[float, float]] = []
    for _ in range(rounds):
        start, cpu_start = time.perf_counter(), time.process_time()
        results = phalanx.evaluate(base, fields, threads=2)
        evaluate_times.append((time.perf_counter() - start, time.process_time() - cpu_start))
        for old in directory.glob("thousand.parquet*"):
            old.unlink()
        call = [os.environ["PHALANX"], "sweep", study, "--out", out, "--threads", "2", "--json"]
        before = os.times()
        completed = subprocess.run(call, check=True, capture_output=True, text=True)
        after = os.times()
        used = after.children_user + after.children_system - before.children_user - before.children_system
        sweep_times.append((json.loads(completed.stdout)["now"]["wall_s"], used))
    np.testing.assert_allclose(results["tts_s"], table["tts_s"], rtol=1e-9)
    for index, clock in enumerate(("wall time", "processor time")):
        rates = [1000 / statistics.median(round_[index] for round_ in times) for times in (sweep_times, evaluate_times)]
        print(f"1,000 designs, designs per second of {clock}: sweep {rates[0]:.0f}, evaluate {rates[1]:.0f}: {rates[1] / rates[0]:.1%}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=20_000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--evaluate", action="store_true")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="phalanx-bench-") as name:
        directory = Path(name)
        if args.evaluate:
            compare_evaluate(max(5, args.rounds), directory)
        study = directory / "scaling.toml"
        study.write_text(STUDY.format(runs=args.runs))
        with cluster() as (address, head, second):
            # Only here, because Ray reads the token of the cluster once, at import.
            import ray

            ray.init(address=address, _node_ip_address="127.0.0.1", log_to_driver=False, logging_level="ERROR")
            try:
                wait_for_nodes(ray, 2)
                ray_wall: list[float] = []
                plain_wall: list[float] = []
                ray_cpu: list[float] = []
                plain_cpu: list[float] = []
                shards = 0
                for round_ in range(args.rounds):
                    wall_s, used_s = sweep_without_ray(study, directory / "plain.parquet")
                    plain_wall.append(wall_s)
                    plain_cpu.append(used_s)
                    before_s = cpu_s([head, second]) + sum(os.times()[:2])
                    swept = sweep_with_ray(study, directory / "ray.parquet")
                    ray_wall.append(swept.wall_s)
                    ray_cpu.append(cpu_s([head, second]) + sum(os.times()[:2]) - before_s)
                    shards = swept.shards
                    same = (directory / "plain.parquet").read_bytes() == swept.out.read_bytes()
                    plain_text = f"without Ray {plain_wall[-1]:.2f} s (processors {plain_cpu[-1]:.2f} s)"
                    ray_text = f"with Ray {ray_wall[-1]:.2f} s (processors {ray_cpu[-1]:.2f} s)"
                    print(f"round {round_ + 1}: {plain_text}, {ray_text} in {shards} parts, same bytes: {same}")
                    if not same:
                        raise SystemExit("the results with and without Ray differ")
                for clock, plain_times, ray_times in (("wall time", plain_wall, ray_wall), ("processor time", plain_cpu, ray_cpu)):
                    rates = [args.runs / statistics.median(times) for times in (plain_times, ray_times)]
                    ratio = f"{rates[1] / rates[0]:.1%}"
                    print(f"{args.runs} designs, designs per second of {clock}: without Ray {rates[0]:.0f}, with Ray {rates[1]:.0f}: {ratio}")
                sweep_ended = threading.Event()
                out = directory / "killed.parquet"
                arguments = (Path(f"{out}.parts"), head, second, shards, sweep_ended)
                thread = threading.Thread(target=kill_worker_then_node, args=arguments)
                thread.start()
                try:
                    swept = phalanx.ray.sweep(study, out, shards=shards)
                finally:
                    sweep_ended.set()
                    thread.join()
                same = (directory / "plain.parquet").read_bytes() == swept.out.read_bytes()
                print(f"with a killed worker and a killed node: {swept.wall_s:.2f} s, same bytes: {same}")
                if not same:
                    raise SystemExit("the results with and without Ray differ")
            finally:
                ray.shutdown()


if __name__ == "__main__":
    main()

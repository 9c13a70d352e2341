"""How fast a sweep is through Ray, beside the plain one: 20,000 designs on a cluster of two nodes on this machine, a processor each.

    PHALANX=target/release/phalanx python python/bench/ray_scaling.py [--runs 20000] [--rounds 3]     (from the root)

Prints the rate of `phalanx sweep` and of `phalanx.ray.sweep` in turn, by the clock and by the time of processors (which others on the
machine change little), and of one more during which a worker and then a node are killed; every result has to have the same bytes. With --evaluate also the rate of 1,000 designs through `phalanx.evaluate` beside
that of `phalanx sweep`.
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
    """Processor time of a cluster so far, all its processes together, those that serve it among them."""
    ticks = 0
    for pid in {pid for node in nodes for pid in node.processes()}:
        try:
            fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        # Its own, and those of children that it has waited for.
        ticks += sum(int(field) for field in fields[11:15])
    return ticks / os.sysconf("SC_CLK_TCK")


def plain(study: Path, out: Path) -> tuple[float, float]:
    """Seconds of the program, by the clock and of processors. In a session of its own, as the nodes are: a kernel that shares
    processors out by sessions gives it no less than each of them."""
    for old in out.parent.glob(out.name + "*"):
        old.unlink()
    start, before = time.monotonic(), os.times()
    call = [os.environ["PHALANX"], "sweep", study, "--out", out, "--threads", "2", "--quiet"]
    subprocess.run(call, check=True, capture_output=True, start_new_session=True)
    after = os.times()
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return time.monotonic() - start, used


def through_ray(study: Path, out: Path) -> phalanx.ray.Swept:
    shutil.rmtree(f"{out}.parts", ignore_errors=True)
    return phalanx.ray.sweep(study, out)


def disturb(parts: Path, head: Node, second: Node, shards: int, over: threading.Event) -> None:
    """Kills a worker at a third of the parts and a node at half of them."""
    done = lambda: len(list(parts.glob("part-*.parquet")))  # noqa: E731
    while not over.is_set() and done() < shards // 3:
        time.sleep(0.02)
    while not over.is_set():
        if worker := head.busy_worker():
            print(f"  killed a worker after {done()} of {shards} parts")
            kill(worker)
            break
        time.sleep(0.01)
    while not over.is_set() and done() < shards // 2:
        time.sleep(0.02)
    if not over.is_set():
        print(f"  killed the second node after {done()} of {shards} parts")
        second.kill()


def evaluated(rounds: int, directory: Path) -> None:
    """1,000 designs as arrays, beside the same as a study, in turn. The clock of the second is its own, of the runs alone; its processor
    time is that of the whole process, a tenth of a percent of which is its start."""
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
    ours: list[tuple[float, float]] = []
    theirs: list[tuple[float, float]] = []
    for _ in range(rounds):
        start, used = time.perf_counter(), time.process_time()
        found = phalanx.evaluate(base, fields, threads=2)
        ours.append((time.perf_counter() - start, time.process_time() - used))
        for old in directory.glob("thousand.parquet*"):
            old.unlink()
        call = [os.environ["PHALANX"], "sweep", study, "--out", out, "--threads", "2", "--json"]
        before = os.times()
        shown = subprocess.run(call, check=True, capture_output=True, text=True)
        after = os.times()
        used = after.children_user + after.children_system - before.children_user - before.children_system
        theirs.append((json.loads(shown.stdout)["now"]["wall_s"], used))
    np.testing.assert_allclose(found["tts_s"], table["tts_s"], rtol=1e-9)
    for at, what in enumerate(("by the clock", "of processors")):
        rates = [1000 / statistics.median(times[at] for times in of) for of in (theirs, ours)]
        print(f"1,000 designs a second {what}: sweep {rates[0]:.0f}, evaluate {rates[1]:.0f}: {rates[1] / rates[0]:.1%}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=20_000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--evaluate", action="store_true")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="phalanx-bench-") as name:
        directory = Path(name)
        if args.evaluate:
            evaluated(max(5, args.rounds), directory)
        study = directory / "scaling.toml"
        study.write_text(STUDY.format(runs=args.runs))
        with cluster() as (address, head, second):
            # Not before: its library looks for the cluster's token once.
            import ray

            ray.init(address=address, _node_ip_address="127.0.0.1", log_to_driver=False, logging_level="ERROR")
            try:
                wait_for_nodes(ray, 2)
                ours: list[float] = []
                theirs: list[float] = []
                our_cpu: list[float] = []
                their_cpu: list[float] = []
                shards = 0
                for round_ in range(args.rounds):
                    wall_s, used_s = plain(study, directory / "plain.parquet")
                    theirs.append(wall_s)
                    their_cpu.append(used_s)
                    before_s = cpu_s([head, second]) + sum(os.times()[:2])
                    swept = through_ray(study, directory / "ray.parquet")
                    ours.append(swept.wall_s)
                    our_cpu.append(cpu_s([head, second]) + sum(os.times()[:2]) - before_s)
                    shards = swept.shards
                    same = (directory / "plain.parquet").read_bytes() == swept.out.read_bytes()
                    words = f"plain {theirs[-1]:.2f} s ({their_cpu[-1]:.2f} of processors), Ray {ours[-1]:.2f} s ({our_cpu[-1]:.2f})"
                    print(f"round {round_ + 1}: {words} in {shards} parts, same bytes: {same}")
                    if not same:
                        raise SystemExit("the bytes differ")
                for what, of, by in (("by the clock", theirs, ours), ("of processors", their_cpu, our_cpu)):
                    rates = [args.runs / statistics.median(times) for times in (of, by)]
                    print(f"{args.runs} designs a second {what}: plain {rates[0]:.0f}, Ray {rates[1]:.0f}: {rates[1] / rates[0]:.1%}")
                over = threading.Event()
                out = directory / "killed.parquet"
                thread = threading.Thread(target=disturb, args=(Path(f"{out}.parts"), head, second, shards, over))
                thread.start()
                try:
                    swept = phalanx.ray.sweep(study, out, shards=shards)
                finally:
                    over.set()
                    thread.join()
                same = (directory / "plain.parquet").read_bytes() == swept.out.read_bytes()
                print(f"with a worker and a node killed: {swept.wall_s:.2f} s, same bytes: {same}")
                if not same:
                    raise SystemExit("the bytes differ")
            finally:
                ray.shutdown()


if __name__ == "__main__":
    main()

"""A sweep on a Ray cluster with a killed worker and a killed node gives the same bytes as an undisturbed sweep."""

import tempfile
import threading
import time
import unittest
from pathlib import Path
from unittest import mock

import phalanx
import phalanx.ray
from cluster import cluster, kill, wait_for_nodes
from common import ANCHOR

STUDY = """
name = "cluster"
scene = "own.toml"

[[axes]]
field = "design.base"
from = "12 mm"
to = "22 mm"

[[axes]]
field = "contact.friction.mu_static"
from = 0.0
to = 0.9

[sample]
count = 1200
"""


class Cluster(unittest.TestCase):
    def test_sweep_survives_a_killed_worker_and_a_killed_node(self):
        with tempfile.TemporaryDirectory() as directory, cluster() as (address, head, second):
            import ray

            root = Path(directory)
            # The scene extends another one, so both files must be sent to the workers.
            (root / "base.toml").write_text(ANCHOR.read_text())
            (root / "own.toml").write_text('extends = "base.toml"\n')
            study = root / "study.toml"
            study.write_text(STUDY)
            phalanx.sweep(study, out=root / "whole.parquet")
            whole = (root / "whole.parquet").read_bytes()
            ray.init(address=address, _node_ip_address="127.0.0.1", log_to_driver=False, logging_level="ERROR")
            try:
                wait_for_nodes(ray, 2)
                killed: list[str] = []
                sweep_ended = threading.Event()

                def kill_worker_then_node() -> None:
                    parts = root / "out.parquet.parts"
                    for victim in ("worker", "node"):
                        initial_count = len(list(parts.glob("part-*.parquet")))
                        while not sweep_ended.is_set() and len(list(parts.glob("part-*.parquet"))) < initial_count + 2:
                            time.sleep(0.01)
                        while not sweep_ended.is_set():
                            worker = head.busy_worker()
                            if victim == "node":
                                second.kill()
                            elif worker is None:
                                time.sleep(0.005)
                                continue
                            else:
                                kill(worker)
                            killed.append(victim)
                            break

                thread = threading.Thread(target=kill_worker_then_node)
                thread.start()
                try:
                    swept = phalanx.ray.sweep(study, root / "out.parquet", shards=40)
                finally:
                    sweep_ended.set()
                    thread.join()
                self.assertEqual(killed, ["worker", "node"])
                self.assertEqual((swept.runs, swept.shards, swept.made), (1200, 40, 40))
                self.assertEqual(swept.out.read_bytes(), whole)
                wait_for_nodes(ray, 1)

                # A repeated call reuses the number of parts and simulates only the missing ones.
                for k in (3, 17):
                    (root / "out.parquet.parts" / f"part-{k}-of-40.parquet").unlink()
                swept = phalanx.ray.sweep(study, root / "out.parquet")
                self.assertEqual((swept.shards, swept.made), (40, 2))
                self.assertEqual(swept.out.read_bytes(), whole)

                # Ray transfers the parts, whose number is chosen from timed runs.
                swept = phalanx.ray.sweep(study, root / "sent.csv", shared=False, shard_s=0.5)
                self.assertGreater(swept.shards, 1)
                phalanx.sweep(study, out=root / "whole.csv")
                self.assertEqual(swept.out.read_bytes(), (root / "whole.csv").read_bytes())

                # Errors of phalanx are reported without retries.
                with self.assertRaisesRegex(phalanx.StudyError, "no shard|numbered from 1"):
                    phalanx.sweep_shard(study, 5, 4, root / "x.parquet")
                part = root / "wrong.parquet.parts" / "part-1-of-2.parquet"
                part.parent.mkdir()
                part.write_text("years of work")
                with self.assertRaisesRegex(phalanx.StudyError, "part-1-of-2.parquet"):
                    phalanx.ray.sweep(study, root / "wrong.parquet", shards=2)
                self.assertEqual(part.read_text(), "years of work")
            finally:
                ray.shutdown()


class WithoutRay(unittest.TestCase):
    def test_error_without_ray_names_the_package_to_install(self):
        with mock.patch.dict("sys.modules", {"ray": None}), self.assertRaisesRegex(phalanx.PhalanxError, r"pip install phalanx\[ray\]"):
            phalanx.ray.sweep("study.toml", "out.parquet")


if __name__ == "__main__":
    unittest.main()

"""A sweep on a Ray cluster of two nodes, of which a worker and then a node are killed: the bytes are those of the undisturbed sweep."""

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
    def test_a_worker_and_a_node_are_killed(self):
        with tempfile.TemporaryDirectory() as directory, cluster() as (address, head, second):
            import ray

            place = Path(directory)
            # A scene that extends another one beside it: all of them go along.
            (place / "base.toml").write_text(ANCHOR.read_text())
            (place / "own.toml").write_text('extends = "base.toml"\n')
            study = place / "study.toml"
            study.write_text(STUDY)
            phalanx.sweep(study, out=place / "whole.parquet")
            whole = (place / "whole.parquet").read_bytes()
            ray.init(address=address, _node_ip_address="127.0.0.1", log_to_driver=False, logging_level="ERROR")
            try:
                wait_for_nodes(ray, 2)
                killed: list[str] = []
                over = threading.Event()

                def disturb() -> None:
                    parts = place / "out.parquet.parts"
                    for victim in ("worker", "node"):
                        seen = len(list(parts.glob("part-*.parquet")))
                        while not over.is_set() and len(list(parts.glob("part-*.parquet"))) < seen + 2:
                            time.sleep(0.01)
                        while not over.is_set():
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

                thread = threading.Thread(target=disturb)
                thread.start()
                try:
                    swept = phalanx.ray.sweep(study, place / "out.parquet", shards=40)
                finally:
                    over.set()
                    thread.join()
                self.assertEqual(killed, ["worker", "node"])
                self.assertEqual((swept.runs, swept.shards, swept.made), (1200, 40, 40))
                self.assertEqual(swept.out.read_bytes(), whole)
                wait_for_nodes(ray, 1)

                # Started again it makes only what is missing: as many parts as before, though nobody says how many.
                for k in (3, 17):
                    (place / "out.parquet.parts" / f"part-{k}-of-40.parquet").unlink()
                swept = phalanx.ray.sweep(study, place / "out.parquet")
                self.assertEqual((swept.shards, swept.made), (40, 2))
                self.assertEqual(swept.out.read_bytes(), whole)

                # Parts that come through Ray, of a number that is measured.
                swept = phalanx.ray.sweep(study, place / "sent.csv", shared=False, shard_s=0.5)
                self.assertGreater(swept.shards, 1)
                phalanx.sweep(study, out=place / "whole.csv")
                self.assertEqual(swept.out.read_bytes(), (place / "whole.csv").read_bytes())

                # What is wrong is said, and not tried twenty times.
                with self.assertRaisesRegex(phalanx.StudyError, "no shard|numbered from 1"):
                    phalanx.sweep_shard(study, 5, 4, place / "x.parquet")
                part = place / "wrong.parquet.parts" / "part-1-of-2.parquet"
                part.parent.mkdir()
                part.write_text("years of work")
                with self.assertRaisesRegex(phalanx.StudyError, "part-1-of-2.parquet"):
                    phalanx.ray.sweep(study, place / "wrong.parquet", shards=2)
                self.assertEqual(part.read_text(), "years of work")
            finally:
                ray.shutdown()


class Alone(unittest.TestCase):
    def test_without_ray_it_is_said_what_to_install(self):
        with mock.patch.dict("sys.modules", {"ray": None}), self.assertRaisesRegex(phalanx.PhalanxError, r"pip install phalanx\[ray\]"):
            phalanx.ray.sweep("study.toml", "out.parquet")


if __name__ == "__main__":
    unittest.main()

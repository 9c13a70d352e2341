"""Files of the user, states of other scenes, endless dictionaries and wrong arguments are refused; a fork works."""

import copy
import math
import os
import pickle
import signal
import tempfile
import time
import unittest
from pathlib import Path

import numpy as np
import phalanx
from common import ANCHOR, DISCS, GRIPPER, ROOT

FOREIGN = "name,age\nAda,36\n"


class Files(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.directory = Path(directory.name)

    def assert_kept(self, path: Path, contents: str, write) -> None:
        path.write_text(contents, encoding="utf-8")
        with self.assertRaises(phalanx.PhalanxError) as raised:
            write(path)
        self.assertNotIn("--", str(raised.exception))
        self.assertEqual(path.read_text(encoding="utf-8"), contents)

    def test_a_table_does_not_replace_a_file_of_the_user(self):
        table = phalanx.evaluate(ANCHOR, {"design.base": [0.018, 0.02]}, columns=["class", "status"])
        for name in ("mine.csv", "mine.parquet"):
            self.assert_kept(self.directory / name, FOREIGN, table.write)
            own = self.directory / f"own-{name}"
            table.write(own)
            first = own.read_bytes()
            # A table replaces one of phalanx, also with these columns only.
            table.write(own)
            self.assertEqual(own.read_bytes(), first)
        (self.directory / "empty.csv").touch()
        table.write(self.directory / "empty.csv")

    def test_a_log_does_not_replace_a_file_of_the_user(self):
        result = phalanx.run(ANCHOR, duration="1 ms", log=self.directory / "run.mcap")
        self.assert_kept(self.directory / "notes.mcap", FOREIGN, result.save)
        log = phalanx.read_log(self.directory / "run.mcap")
        bytes_of_log = (self.directory / "run.mcap").read_bytes()
        self.assert_kept(self.directory / "notes.mcap", FOREIGN, log.save)
        log.save(self.directory / "copy.mcap")
        self.assertEqual((self.directory / "copy.mcap").read_bytes(), bytes_of_log)
        # The copy of a log to itself is the log.
        log.save(self.directory / "run.mcap")
        self.assertEqual((self.directory / "run.mcap").read_bytes(), bytes_of_log)

    def test_results_of_a_sweep_do_not_replace_a_file_of_the_user(self):
        study = ROOT / "scenes" / "studies" / "capture.toml"
        self.assert_kept(self.directory / "mine.csv", FOREIGN, lambda path: phalanx.sweep(study, out=path, limit=1))
        write = lambda path: phalanx.sweep_shard(study, 1, 1000, path)
        self.assert_kept(self.directory / "mine.parquet", FOREIGN, write)

    def test_a_log_without_its_scene_keeps_its_columns(self):
        path = self.directory / "run.mcap"
        result = phalanx.run(GRIPPER, duration="2 ms", log=path)
        contents = bytearray(path.read_bytes())
        scene = contents.index(b"application/toml") + 40
        contents[scene] ^= 1
        path.write_bytes(contents)
        log = phalanx.read_log(path)
        self.assertEqual([name for name in result.columns if "_force_" not in name], log.columns)
        self.assertFalse(log.summary["whole"])
        self.assertIn("scene", log.summary["losses"][0]["what"])


class States(unittest.TestCase):
    def test_a_state_of_another_scene_or_model_is_refused(self):
        anchor = phalanx.Scene.load(ANCHOR)
        simulation = phalanx.Simulation(anchor)
        simulation.advance(1e-3)
        values = [simulation[name] for name in simulation.columns]
        for other, model in (
            (GRIPPER, "analytic"),
            (DISCS, "analytic"),
            (ANCHOR, "engine"),
            (anchor.with_({"design.base": "21 mm"}), "analytic"),
            (anchor.with_({"integrator.rtol": 1e-4}), "analytic"),
        ):
            state = phalanx.Simulation(other, model=model).state
            with self.assertRaisesRegex(ValueError, "the state is of"):
                simulation.state = state
            self.assertEqual([simulation[name] for name in simulation.columns], values)
        # Name, duration and log do not matter.
        named = phalanx.Simulation(anchor.with_({"name": "other", "duration": "5 ms"}))
        named.state = simulation.state
        self.assertEqual(named.time, simulation.time)
        # A pickle is a state of the same scene.
        with self.assertRaisesRegex(ValueError, "the state is of"):
            simulation.state = pickle.loads(pickle.dumps(phalanx.Simulation(anchor.with_({"design.base": "14 mm"})).state))

    def test_a_batch_restores_all_states_or_none(self):
        batch = phalanx.SimulationBatch([ANCHOR, ANCHOR])
        other = phalanx.SimulationBatch([GRIPPER])
        start = batch.states
        batch.advance(1e-3)
        with self.assertRaises(ValueError):
            batch.restore([0, 1], [start[0], other.states[0]])
        np.testing.assert_array_equal(batch.time, [1e-3, 1e-3])
        for indices in ([-1], [2], [2**70]):
            with self.assertRaises((IndexError, OverflowError)):
                batch.restore(indices, start[:1])
        batch.restore([1], start[1:])
        np.testing.assert_array_equal(batch.time, [1e-3, 0.0])


class Arguments(unittest.TestCase):
    def test_dictionaries_end(self):
        cycle: dict = {"duration": "20 ms"}
        cycle["design"] = {"base": cycle}
        crossed: list = []
        crossed.extend([crossed, crossed])
        deep: dict = {}
        for _ in range(100_000):
            deep = {"design": deep}
        wide: list = ["20 mm"]
        for _ in range(30):
            wide = [wide, wide]
        for value in (cycle, {"design": crossed}, deep, {"design": wide}, {"duration": 2**70}):
            start = time.monotonic()
            with self.assertRaises(ValueError):
                phalanx.Scene.from_dict(value)
            # Unfolding the shared lists would take years; a busy machine takes seconds.
            self.assertLess(time.monotonic() - start, 60.0)
        anchor = phalanx.Scene.load(ANCHOR)
        with self.assertRaises(ValueError):
            anchor.with_({"object.centre": crossed})
        with self.assertRaisesRegex(TypeError, "keys are strings"):
            phalanx.Scene.from_dict({1: "20 mm"})
        self.assertEqual(phalanx.Scene.from_dict(anchor.to_dict()).to_dict(), anchor.to_dict())
        # The destructor of a deep dictionary is recursive in some versions of Python.
        while deep:
            deep = deep["design"]

    def test_wrong_values_are_value_errors(self):
        anchor = phalanx.Scene.load(ANCHOR)
        simulation = phalanx.Simulation(anchor)
        study = ROOT / "scenes" / "studies" / "capture.toml"
        for call in (
            lambda: phalanx.run(anchor, model="wooden"),
            lambda: phalanx.run(anchor, duration="soon"),
            lambda: phalanx.evaluate(anchor, {"design.base": [0.02]}, threads=-1),
            lambda: phalanx.evaluate(anchor, {"design.base": [0.02]}, threads=10**6),
            lambda: phalanx.evaluate(anchor, {"design.nothing": [0.02]}),
            lambda: phalanx.sweep(study, limit=-1),
            lambda: phalanx.sweep_shard(study, -1, 4, "part.parquet"),
            lambda: phalanx.hold(GRIPPER, directions=-1),
            lambda: phalanx.capture(GRIPPER, places=-3),
            lambda: simulation.advance(-1.0),
            lambda: simulation.advance(math.nan),
            lambda: simulation.set_torque("motor", math.inf),
            lambda: simulation.set_torque("nothing", 1.0),
            lambda: anchor.with_({"design.base": "20 mn"}),
        ):
            with self.assertRaises(ValueError) as raised:
                call()
            self.assertIsInstance(raised.exception, phalanx.PhalanxError)
            self.assertEqual(str(pickle.loads(pickle.dumps(raised.exception))), str(raised.exception))

    def test_a_number_that_is_not_finite_ends_the_run_with_its_time(self):
        scene = phalanx.Scene.from_toml(
            """
            kind = "mechanism"
            duration = "10 ms"
            [bodies.a]
            mass = "10 g"
            inertia = "1e-300 kg*m^2"
            [joints.j]
            bodies = ["ground", "a"]
            points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
            start = "0 rad"
            [actuators.m]
            joint = "j"
            torque = "1e12 N*m"
            """
        )
        with self.assertRaisesRegex(phalanx.RunError, "stopped at 0 ms of 10 ms: `j_force_x_n` is not a finite number"):
            phalanx.run(scene, model="engine")
        with self.assertRaisesRegex(phalanx.RunError, "not a finite number"):
            phalanx.Simulation(scene, model="engine")


@unittest.skipUnless(hasattr(os, "fork"), "the system has no fork")
class Forks(unittest.TestCase):
    def test_a_batch_advances_after_a_fork(self):
        batch = phalanx.SimulationBatch([ANCHOR] * 4)
        batch.advance(1e-3)
        batch["q11_rad"]
        expected = copy.copy(phalanx.Simulation(ANCHOR))
        expected.advance(1e-3)
        expected.advance(1e-3)
        child = os.fork()
        if child == 0:
            status = 1
            try:
                batch.advance(1e-3)
                phalanx.evaluate(ANCHOR, {"design.base": [0.018, 0.02]}, columns=["status"])
                status = 0 if (batch["q11_rad"] == expected["q11_rad"]).all() else 2
            finally:
                os._exit(status)
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline:
            pid, status = os.waitpid(child, os.WNOHANG)
            if pid:
                self.assertEqual(os.waitstatus_to_exitcode(status), 0)
                break
            time.sleep(0.02)
        else:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            self.fail("the child process hangs")
        batch.advance(1e-3)
        np.testing.assert_array_equal(batch["q11_rad"], [expected["q11_rad"]] * 4)


if __name__ == "__main__":
    unittest.main()

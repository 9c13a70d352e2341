"""Scenes, results, tables, simulations and states survive pickling, and other processes."""

import copy
import multiprocessing
import pickle
import tempfile
import unittest
from pathlib import Path

import numpy as np
import phalanx
from common import ANCHOR, DISCS, GRIPPER, SCENES

FAILS = SCENES / "hard" / "through-the-fold.toml"
LIFT = SCENES / "real" / "2f85-lift.toml"


def pickled(value):
    return pickle.loads(pickle.dumps(value))


def end_of_run(scene: phalanx.Scene) -> phalanx.Result:
    return phalanx.run(scene, duration=5e-3)


def end_of_state(state: phalanx.SimulationState) -> tuple[list[float], list[phalanx.Event]]:
    simulation = phalanx.Simulation(ANCHOR)
    simulation.state = state
    return closed(simulation)


def closed(simulation: phalanx.Simulation) -> tuple[list[float], list[phalanx.Event]]:
    simulation.set_torque("motor", 0.4)
    simulation.advance_to(9e-3)
    return [simulation[column] for column in simulation.columns], simulation.events


class Pickles(unittest.TestCase):
    def assert_same_result(self, restored: phalanx.Result, result: phalanx.Result) -> None:
        self.assertEqual(restored.columns, result.columns)
        for name, column in result.items():
            np.testing.assert_array_equal(restored[name], column, err_msg=name)
        for attribute in ("events", "summary", "criteria", "gradient", "check"):
            self.assertEqual(getattr(restored, attribute), getattr(result, attribute), attribute)

    def test_a_pickled_scene_gives_the_same_run_bit_for_bit(self):
        for path, fields in ((ANCHOR, {"contact.friction.mu_static": 0.6, "design.base": 0.0155}), (GRIPPER, {}), (DISCS, {})):
            scene = phalanx.Scene.load(path).with_(fields)
            expected = end_of_run(scene)
            for restored in (pickled(scene), copy.copy(scene), copy.deepcopy(scene)):
                result = end_of_run(restored)
                for name, column in expected.items():
                    np.testing.assert_array_equal(result[name], column, err_msg=name)
                self.assertEqual(result.events, expected.events)

    def test_results_have_the_same_numbers_and_can_be_saved(self):
        scene = phalanx.Scene.load(ANCHOR)
        result = phalanx.run(scene, check=True, gradient=["design.base"], duration="8 ms", numeric_rate=5e3)
        for restored in (pickled(result), copy.copy(result), copy.deepcopy(result)):
            self.assert_same_result(restored, result)
            self.assertEqual(repr(restored), repr(result))
        self.assertIn("<html", pickled(result).html())
        with tempfile.TemporaryDirectory() as directory:
            paths = [Path(directory) / name for name in ("first.mcap", "second.mcap")]
            for path, each in zip(paths, (result, pickled(result)), strict=True):
                each.save(path)
            self.assertEqual(paths[0].read_bytes(), paths[1].read_bytes())
            read = phalanx.read_log(paths[0])
            self.assert_same_result(pickled(read), read)
            self.assertEqual(pickled(read).html(), read.html())

    def test_the_error_of_an_incomplete_run_keeps_its_result(self):
        with self.assertRaises(phalanx.RunError) as caught:
            phalanx.run(phalanx.Scene.load(ANCHOR).with_({"integrator.max_steps": 100}))
        restored = pickled(caught.exception)
        self.assertEqual(str(restored), str(caught.exception))
        self.assert_same_result(restored.result, caught.exception.result)

    def test_tables_keep_numbers_missing_values_and_counts(self):
        fields = {"design.base": [0.0155, 0.018, -1.0], "contact.friction.mu_static": 0.6}
        table = phalanx.evaluate(ANCHOR, fields)
        restored = pickled(table)
        self.assertEqual((restored.columns, restored.summary, str(restored)), (table.columns, table.summary, str(table)))
        self.assertTrue(any(np.isnan(table["tts_s"])))
        for column in table.columns:
            np.testing.assert_array_equal(restored[column], table[column], err_msg=column)

    def test_pickled_simulations_and_states_continue_with_the_same_bits(self):
        for model in ("analytic", "engine"):
            simulation = phalanx.Simulation(ANCHOR, model)
            for torque in (0.48, 0.3, 0.45):
                simulation.set_torque("motor", torque)
                simulation.advance(1.37e-3)
            state, restored = pickled(simulation.state), pickled(simulation)
            again = phalanx.Simulation(ANCHOR, model)
            again.state = state
            expected = closed(simulation)
            self.assertEqual(closed(restored), expected, model)
            self.assertEqual(closed(again), expected, model)
            restored.reset()
            self.assertEqual(restored.time, 0.0)

    def test_pickled_servos_continue_with_the_same_bits(self):
        simulation = phalanx.Simulation(LIFT)
        simulation.set_target("motor", "40 deg")
        simulation.advance("7 ms")
        simulation.set_target("lift", 0.0, "50 mm/s")
        simulation.advance(4e-3)
        restored = pickled(simulation)
        for each in (simulation, restored):
            each.advance(9e-3)
        np.testing.assert_array_equal(restored.observe(restored.columns), simulation.observe(simulation.columns))

    def test_a_failed_simulation_stays_failed(self):
        simulation = phalanx.Simulation(FAILS)
        with self.assertRaises(phalanx.RunError):
            simulation.advance(1.0)
        restored = pickled(simulation)
        self.assertEqual(restored.time, simulation.time)
        with self.assertRaises(phalanx.RunError):
            restored.advance(1e-3)

    def test_a_state_with_other_values_is_refused(self):
        simulation = phalanx.Simulation(ANCHOR)
        simulation.advance(3e-3)
        function, (saved,) = simulation.__reduce__()
        values = np.frombuffer(saved["values"], "<f8").copy()
        values[1] = np.nextafter(values[1], 10)
        with self.assertRaisesRegex(phalanx.RunError, "has other values when phalanx .* repeats it"):
            function({**saved, "values": values.tobytes()})

    def test_batches(self):
        batch = phalanx.SimulationBatch([phalanx.Scene.load(ANCHOR)] * 3 + [phalanx.Scene.load(FAILS)])
        batch.set_torque("motor", [0.3, 0.4, 0.5, 0.48])
        batch.advance(8e-3)
        restored = pickled(batch)
        self.assertEqual(restored.failures, batch.failures)
        self.assertIsNotNone(batch.failures[3])
        for each in (batch, restored):
            each.advance(2e-3)
        columns = ["time_s", "q11_rad", "distal_normal_n"]
        np.testing.assert_array_equal(restored.observe(columns), batch.observe(columns))

    def test_other_processes_give_the_same_bits(self):
        scenes = [phalanx.Scene.load(ANCHOR).with_({"contact.friction.mu_static": mu}) for mu in (0.2, 0.4, 0.6)]
        simulation = phalanx.Simulation(ANCHOR)
        simulation.advance(4.321e-3)
        with multiprocessing.get_context("spawn").Pool(2) as pool:
            results = pool.map(end_of_run, scenes)
            ends = pool.map(end_of_state, [simulation.state])
        for result, scene in zip(results, scenes, strict=True):
            expected = end_of_run(scene)
            for name, column in expected.items():
                np.testing.assert_array_equal(result[name], column, err_msg=name)
        self.assertEqual(ends, [closed(simulation)])


if __name__ == "__main__":
    unittest.main()

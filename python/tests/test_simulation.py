"""Simulations that Python advances: inputs, observations, copies and batches."""

import copy
import pickle
import unittest

import numpy as np
import phalanx
from common import ANCHOR, SCENES

FINGER = SCENES / "mechanisms" / "f85-finger.toml"
FAILS = SCENES / "hard" / "through-the-fold.toml"
KP, KD, TARGET, LIMIT = 2.0, 0.02, 0.5, 0.25


class Simulations(unittest.TestCase):
    def test_a_simulation_ends_as_a_run_does(self):
        result = phalanx.run(ANCHOR)
        simulation = phalanx.Simulation(ANCHOR)
        for piece in range(1, 51):
            simulation.advance_to(20e-3 * piece / 50)
        self.assertEqual(simulation.time, 20e-3)
        self.assertEqual(simulation.columns, result.columns)
        for column in ("q11_rad", "distal_normal_n", "kinetic_j"):
            self.assertEqual(simulation[column], result[column][-1], column)
        self.assertEqual(simulation.events, result.events)
        contact = simulation.contacts["distal"]
        self.assertEqual(contact["normal_n"], simulation["distal_normal_n"])
        self.assertIn("gap_rad", simulation.contacts["limit"])

    def test_a_controller_equals_the_sampled_servo(self):
        scene = phalanx.Scene.load(FINGER).to_dict()
        motor = scene["actuators"]["motor"]
        scene["actuators"]["motor"] = {key: value for key, value in motor.items() if not key.startswith("torque")}
        gains = {"target": f"{TARGET} rad", "kp": f"{KP} N*m/rad", "kd": f"{KD} N*m*s/rad", "limit": f"{LIMIT} N*m"}
        scene["actuators"]["motor"] |= gains | {"rate": "1 kHz"}
        result = phalanx.run(phalanx.Scene.from_dict(scene))
        simulation = phalanx.Simulation(FINGER)
        for sample in range(60):
            torque = KP * (TARGET - simulation["driver_rad"]) - KD * simulation["driver_rate_rad_s"]
            simulation.set_torque("motor", min(max(torque, -LIMIT), LIMIT))
            simulation.advance_to((sample + 1) * 1e-3)
        for column in ("driver_rad", "coupler_rad", "follower_rad", "driver_rate_rad_s"):
            self.assertAlmostEqual(simulation[column], result[column][-1], delta=1e-9, msg=column)
        for event, expected in zip(simulation.events, result.events, strict=True):
            self.assertEqual((event.contact, event.kind), (expected.contact, expected.kind))
            self.assertAlmostEqual(event.time_s, expected.time_s, delta=1e-9)

    def test_states_and_copies_continue_with_the_same_bits(self):
        def closed(simulation):
            simulation.set_torque("motor", 0.4)
            simulation.advance_to(9e-3)
            return [simulation[column] for column in simulation.columns], simulation.events

        simulation = phalanx.Simulation(ANCHOR)
        simulation.advance(4.321e-3)
        state, copied, deep = simulation.state, copy.copy(simulation), copy.deepcopy(simulation)
        expected = closed(simulation)
        for other in (copied, deep):
            self.assertEqual(closed(other), expected)
        simulation.state = state
        self.assertEqual(simulation.time, 4.321e-3)
        self.assertEqual(closed(simulation), expected)

    def test_observations_are_arrays_in_the_order_of_the_columns(self):
        columns = ["distal_normal_n", "q11_rad", "time_s", "q11_rad"]
        simulation = phalanx.Simulation(ANCHOR)
        simulation.advance(9e-3)
        observation = simulation.observe(columns)
        self.assertEqual((observation.dtype, observation.shape), (np.float64, (4,)))
        self.assertEqual(list(observation), [simulation[column] for column in columns])
        observation[0] = 0.0
        self.assertNotEqual(simulation.observe(columns)[0], 0.0)
        self.assertEqual(simulation.observe([]).shape, (0,))
        batch = phalanx.SimulationBatch([ANCHOR] * 3)
        batch.set_torque("motor", [0.3, 0.4, 0.5])
        batch.advance(9e-3)
        rows = batch.observe(columns)
        self.assertEqual((rows.dtype, rows.shape), (np.float64, (3, 4)))
        for index, column in enumerate(columns):
            np.testing.assert_array_equal(rows[:, index], batch[column])
        for owner in (simulation, batch):
            with self.assertRaisesRegex(KeyError, "`q11_rd` is no column; did you mean `q11_rad`"):
                owner.observe(["time_s", "q11_rd"])
            with self.assertRaises(TypeError):
                owner.observe("q11_rad")

    def test_a_preset_replaces_the_settings_of_the_integrator(self):
        scene = phalanx.Scene.load(ANCHOR).with_({"integrator.rtol": 1e-9})
        result = phalanx.run(scene, preset="draft")
        simulation, batch = phalanx.Simulation(scene, preset="draft"), phalanx.SimulationBatch([scene, ANCHOR], preset="draft")
        for owner in (simulation, batch, pickle.loads(pickle.dumps(simulation))):
            owner.advance(20e-3)
            self.assertEqual(set(owner.observe(["q11_rad"]).flatten()), {result["q11_rad"][-1]})
        self.assertNotEqual(phalanx.run(scene)["q11_rad"][-1], result["q11_rad"][-1])
        with self.assertRaisesRegex(phalanx.SceneError, "`preset` is a setting of the analytic model"):
            phalanx.Simulation(scene, "engine", preset="draft")

    def test_reset_returns_to_the_start(self):
        simulation, new = phalanx.Simulation(ANCHOR), phalanx.Simulation(ANCHOR)
        start = new.observe(new.columns)
        simulation.set_torque("motor", 0.1)
        simulation.advance(9e-3)
        self.assertFalse(np.array_equal(simulation.observe(new.columns), start))
        simulation.reset()
        np.testing.assert_array_equal(simulation.observe(new.columns), start)
        # The torque is that of the scene again, and a seed changes nothing.
        for each in (simulation, new):
            each.advance(9e-3)
        np.testing.assert_array_equal(simulation.observe(new.columns), new.observe(new.columns))
        simulation.reset(seed=7)
        simulation.advance(9e-3)
        np.testing.assert_array_equal(simulation.observe(new.columns), new.observe(new.columns))
        failed = phalanx.Simulation(FAILS)
        with self.assertRaises(phalanx.RunError):
            failed.advance(1.0)
        failed.reset()
        failed.advance(1e-3)
        self.assertEqual(failed.time, 1e-3)

    def test_simulations_of_a_batch_are_reset_by_index(self):
        batch = phalanx.SimulationBatch([ANCHOR] * 3)
        batch.advance(2e-3)
        batch.reset(indices=[1])
        self.assertEqual(list(batch.time), [2e-3, 0.0, 2e-3])
        with self.assertRaisesRegex(IndexError, "no simulation 3"):
            batch.reset(indices=[0, 3])
        self.assertEqual(list(batch.time), [2e-3, 0.0, 2e-3])
        batch.reset(seed=1)
        self.assertEqual(list(batch.time), [0.0] * 3)

    def test_errors_name_what_is_allowed_and_when(self):
        simulation = phalanx.Simulation(FAILS)
        with self.assertRaises(phalanx.RunError) as caught:
            simulation.advance(1.0)
        self.assertAlmostEqual(caught.exception.time_s, 6.401e-3, delta=1e-5)
        self.assertEqual(simulation.time, caught.exception.time_s)
        self.assertIn("at t = 0.0064", str(caught.exception))
        with self.assertRaisesRegex(phalanx.SceneError, "actuators with a torque: `motor`"):
            phalanx.Simulation(ANCHOR).set_torque("moter", 1.0)
        with self.assertRaisesRegex(KeyError, "q11_rad"):
            simulation["q12"]
        self.assertEqual((simulation.torque_inputs, simulation.target_inputs), (["motor"], []))

    def test_a_batch_equals_its_simulations(self):
        scene = phalanx.Scene.load(ANCHOR)
        batch = phalanx.SimulationBatch([scene] * 5 + [phalanx.Scene.load(FAILS)])
        # The last scene reaches its singularity with its own torque.
        torques = np.append(np.linspace(0.3, 0.6, 5), 0.48)
        starts = batch.states
        for _ in range(2):
            batch.set_torque("motor", torques)
            batch.advance(5e-3)
            batch.advance(5e-3)
            for index, torque in enumerate(torques[:5]):
                simulation = phalanx.Simulation(scene)
                simulation.set_torque("motor", float(torque))
                simulation.advance_to(5e-3)
                simulation.advance(5e-3)
                self.assertEqual(batch["q11_rad"][index], simulation["q11_rad"])
                self.assertEqual(batch.events[index], simulation.events)
            self.assertEqual(batch.failures[:5], [None] * 5)
            self.assertIn("at t = ", batch.failures[5])
            self.assertLess(batch.time[5], 10e-3)
            batch.restore(range(6), starts)
            self.assertEqual(list(batch.time), [0.0] * 6)
        with self.assertRaisesRegex(phalanx.SceneError, "6 simulations, but 2"):
            batch.set_torque("motor", [0.1, 0.2])


if __name__ == "__main__":
    unittest.main()

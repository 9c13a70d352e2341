"""The environments of the examples follow Gymnasium's interface, and their tasks can be solved."""

import importlib.util
import os
import subprocess
import sys
import tempfile
import unittest
import warnings
from pathlib import Path

import numpy as np
from common import ROOT
from gymnasium.utils.env_checker import check_env

EXAMPLES = ROOT / "python" / "examples"


def check(environment) -> None:
    """Checks the interface. Observations have no bounds, and there is nothing to render."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*A Box observation space (minimum|maximum) value is", UserWarning)
        check_env(environment, skip_render_check=True)


def example(name: str):
    """Imports an example."""
    specification = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


class Grasp(unittest.TestCase):
    def episode(self, environment, torque: float) -> tuple[list[float], dict]:
        observation, _ = environment.reset(seed=1)
        rewards, done = [], False
        while not done:
            observation, reward, terminated, truncated, information = environment.step(np.full(2, torque / 0.3 - 1.0))
            self.assertTrue(environment.observation_space.contains(observation))
            rewards.append(reward)
            done = terminated or truncated
        return rewards, information

    def test_it_passes_the_checks_of_gymnasium(self):
        check(example("grasp_environment").GraspEnvironment())

    def test_a_torque_grasps_and_none_does_not(self):
        environment = example("grasp_environment").GraspEnvironment()
        rewards, information = self.episode(environment, 0.48)
        self.assertTrue(information["grasped"], information)
        self.assertGreater(sum(rewards), 5.0)
        self.assertEqual(self.episode(environment, 0.48)[0], rewards)
        self.assertLess(sum(self.episode(environment, 0.0)[0]), 0.0)


class TableGripper(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.example = example("table_gripper_environment")

    def test_it_passes_the_checks_of_gymnasium(self):
        check(self.example.TableGripperEnvironment())

    def test_the_vector_equals_its_environments(self):
        vector, single = self.example.TableGripperVectorEnvironment(3), self.example.TableGripperEnvironment()
        observations, information = vector.reset(seed=5)
        self.assertTrue(vector.observation_space.contains(observations))
        self.assertEqual(len(set(information["offset_m"])), 3)
        actions = np.array([self.example.scripted_action(12)] * 3) * [[1.0], [0.5], [-0.2]]
        steps = [vector.step(actions) for _ in range(3)]
        for index, offset_m in enumerate(information["offset_m"]):
            observation, _ = single.reset(options={"offset_m": offset_m})
            np.testing.assert_array_equal(observation, observations[index])
            for rows, rewards, terminated, truncated, _ in steps:
                observation, reward, *ends, _ = single.step(actions[index])
                np.testing.assert_array_equal(observation, rows[index])
                self.assertEqual((reward, *ends), (rewards[index], terminated[index], truncated[index]))

    def test_the_scripted_policy_lifts_the_cube_and_idleness_does_not(self):
        environment = self.example.TableGripperEnvironment()
        for action, is_held in ((self.example.scripted_action, True), (lambda step: np.array([-1.0, 1.0]), False)):
            environment.reset(seed=3)
            total = 0.0
            for step in range(self.example.STEPS):
                _, reward, terminated, truncated, information = environment.step(action(step))
                self.assertFalse(terminated)
                total += reward
            self.assertTrue(truncated)
            self.assertEqual(information["held"], is_held)
            self.assertEqual(total > 5.0, is_held, total)

    def test_the_comparison_with_mujoco_is_printed(self):
        with tempfile.TemporaryDirectory() as directory:
            call = [sys.executable, EXAMPLES / "table_gripper_environment.py", "--quick", "--out", Path(directory) / "out.png"]
            result = subprocess.run(call, capture_output=True, text=True, check=False, env={**os.environ, "MPLCONFIGDIR": directory})
        self.assertEqual(result.returncode, 0, result.stderr)
        for name in ("phalanx", "MuJoCo, 0.5 ms", "MuJoCo, 2 ms"):
            self.assertRegex(result.stdout, rf"{name}: \d+ steps/s of 4 environments; \d of 4 held and lifted")


if __name__ == "__main__":
    unittest.main()

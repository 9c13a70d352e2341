"""A Gymnasium environment: a gripper like the Robotiq 2F-85 picks up a cube from a table. Also as a vector on all cores.

    pip install gymnasium
    python table_gripper_environment.py [--out table_gripper_environment.png] [--environments 64]

The agent sets the set points of the fingers and of the lift every 10 ms. `pip install mujoco` adds a comparison: the same
scripted policy in MuJoCo's model of the same scene, with steps of 0.5 and 2 ms.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import gymnasium
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import phalanx
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

try:
    import mujoco
    from mujoco.rollout import Rollout
except ImportError:
    mujoco = None

Array: TypeAlias = NDArray[np.float64]

SCENE = Path(__file__).resolve().parents[2] / "scenes" / "real" / "2f85-lift.toml"
PERIOD_S, STEPS = 0.01, 40
MAX_OFFSET_M = 3e-3
# Set points of the fingers, rad, and of the lift, m, for the actions -1 and 1, and the rates at which they move.
LOW: Array = np.array([np.radians(20), 0.0])
HIGH: Array = np.array([0.8, 0.05])
RATES: Array = np.array([6.0, 0.2])
START_Y_M, HELD_HEIGHT_M, HELD_FORCE_N = 0.140062, 0.04, 1.0
STATE = ["right_driver_rad", "left_driver_rad", "right_driver_rate_rad_s", "lift_position_m", "lift_rate_m_s"]
STATE += ["object_x_m", "object_y_m", "object_angle_rad", "object_vx_m_s", "object_vy_m_s"]
OFFSETS: Array = np.array([0.5, 0.5, 0.0, 0.025, 0.0, 0.0, START_Y_M, 0.0, 0.0, 0.0])
SCALES: Array = np.array([0.5, 0.5, 5.0, 0.025, 0.2, 0.005, 0.05, 0.1, 0.2, 0.2])


def scene_with_offset(scene: phalanx.Scene, offset_m: float) -> phalanx.Scene:
    """The scene without its own motion, with the cube at an offset from the middle."""
    return scene.with_(
        {
            "actuators.motor.targets": [LOW[0]] * 2,
            "actuators.motor.target_rate": RATES[0],
            "actuators.lift.targets": [LOW[1]] * 5,
            "actuators.lift.target_rate": RATES[1],
            "bodies.object.start.at[0]": offset_m,
        }
    )


class Task:
    """Observations and rewards, of one simulation or of rows of a batch."""

    def __init__(self, columns: list[str]) -> None:
        pads = [[name for name in columns if f"{side}_follower.pad" in name and name.endswith("_normal_n")] for side in ("left", "right")]
        self.columns, self.splits = STATE + pads[0] + pads[1], np.cumsum([len(STATE), len(pads[0])])
        self.size = len(STATE) + 2

    def observation(self, values: Array) -> Array:
        """Angles, rates and positions of the order of 1, and the force of each pad in 50 N."""
        state, left, right = np.split(values, self.splits, axis=-1)
        forces = np.stack([left.sum(axis=-1), right.sum(axis=-1)], axis=-1)
        observation: Array = np.concatenate([(state - OFFSETS) / SCALES, forces / 50.0], axis=-1)
        return observation

    def reward(self, observation: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Height of a gripped cube as a fraction of the largest one, and whether it is held and lifted."""
        height_m = START_Y_M - (observation[..., 6] * SCALES[6] + OFFSETS[6])
        gripped = 50.0 * observation[..., -2:].min(axis=-1) > HELD_FORCE_N
        return gripped * np.clip(height_m / HIGH[1], -1.0, 1.0), gripped & (height_m > HELD_HEIGHT_M)


def set_points(action: Array) -> Array:
    """Set points of the fingers, rad, and of the lift, m."""
    return LOW + 0.5 * (HIGH - LOW) * (1.0 + np.clip(action, -1.0, 1.0))


class TableGripperEnvironment(gymnasium.Env[Array, Array]):
    """Picks up a cube that lies at a random offset. An episode takes 0.4 s."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self) -> None:
        self.scene = phalanx.Scene.load(SCENE)
        self.task = Task(phalanx.Simulation(self.scene).columns)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (self.task.size,), np.float64)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float64)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Starts an episode. The seed determines the offset of the cube, and nothing else is random."""
        super().reset(seed=seed)
        offset_m = (options or {}).get("offset_m", self.np_random.uniform(-MAX_OFFSET_M, MAX_OFFSET_M))
        self.simulation = phalanx.Simulation(scene_with_offset(self.scene, offset_m), preset="draft")
        self.steps = 0
        return self.observe(), {"offset_m": offset_m}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Moves the set points for one period."""
        fingers, lift = set_points(action)
        self.simulation.set_target("motor", fingers)
        self.simulation.set_target("lift", lift)
        self.steps += 1
        try:
            self.simulation.advance(PERIOD_S)
        except phalanx.RunError as error:
            return self.observe(), -1.0, True, False, {"failure": str(error), "held": False}
        observation = self.observe()
        reward, held = self.task.reward(observation)
        return observation, float(reward), False, self.steps == STEPS, {"held": bool(held)}

    def observe(self) -> Array:
        return self.task.observation(self.simulation.observe(self.task.columns))


class TableGripperVectorEnvironment(VectorEnv[Array, Array, NDArray[Any]]):
    """The same environment many times, which `SimulationBatch` advances on all cores. Episodes end together."""

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.DISABLED}

    def __init__(self, num_envs: int) -> None:
        single = TableGripperEnvironment()
        self.scene, self.task, self.num_envs = single.scene, single.task, num_envs
        self.single_observation_space, self.single_action_space = single.observation_space, single.action_space
        self.observation_space = batch_space(single.observation_space, num_envs)
        self.action_space = batch_space(single.action_space, num_envs)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Starts an episode of all environments, with a random offset for each."""
        super().reset(seed=seed)
        offsets_m = self.np_random.uniform(-MAX_OFFSET_M, MAX_OFFSET_M, self.num_envs)
        scenes = [scene_with_offset(self.scene, offset_m) for offset_m in offsets_m]
        self.batch = phalanx.SimulationBatch(scenes, preset="draft")
        self.steps = 0
        return self.observe(), {"offset_m": offsets_m}

    def step(self, actions: Array) -> tuple[Array, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Moves the set points for one period."""
        for name, targets in zip(("motor", "lift"), set_points(actions).T, strict=True):
            self.batch.set_target(name, targets)
        self.steps += 1
        self.batch.advance(PERIOD_S)
        observation = self.observe()
        rewards, held = self.task.reward(observation)
        failed = np.array([failure is not None for failure in self.batch.failures])
        truncated = np.full(self.num_envs, self.steps == STEPS)
        return observation, np.where(failed, -1.0, rewards), failed, truncated, {"held": held & ~failed}

    def observe(self) -> Array:
        return self.task.observation(self.batch.observe(self.task.columns))


def scripted_action(step: int) -> Array:
    """Closes for 0.1 s, then lifts."""
    return np.array([1.0, 1.0 if step >= 10 else -1.0])


def phalanx_episode(environment: TableGripperVectorEnvironment) -> tuple[Array, NDArray[np.bool_], float]:
    """Returns the heights of the cubes after each step, m, which are held at the end, and the time of the steps, s."""
    environment.reset(seed=0)
    heights, start = [], time.perf_counter()
    for step in range(STEPS):
        observation, _, _, _, information = environment.step(np.tile(scripted_action(step), (environment.num_envs, 1)))
        heights.append(START_Y_M - (observation[:, 6] * SCALES[6] + OFFSETS[6]))
    return np.array(heights), information["held"], time.perf_counter() - start


class MujocoGripper:
    """The same scene in MuJoCo: its own contacts, as stiff as the time step allows, on all cores."""

    def __init__(self, scene: phalanx.Scene, offsets_m: Array, step_s: float) -> None:
        self.model = mujoco.MjModel.from_xml_string(scene_with_offset(scene, 0.0).to_mjcf())
        self.model.opt.timestep, self.model.opt.tolerance = step_s, 1e-8
        self.substeps = round(PERIOD_S / step_s)
        data = mujoco.MjData(self.model)
        mujoco.mj_resetDataKeyframe(self.model, data, 0)
        state = np.empty(mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
        mujoco.mj_getState(self.model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        # A state begins with the time. The joints of the cube come last.
        self.states = np.tile(state, (len(offsets_m), 1))
        self.y_index = self.model.nq - 1
        self.states[:, self.y_index - 1] = offsets_m
        self.actuators = [self.model.actuator(name).id for name in ("motor", "lift")]
        # Damping acts on the rate of the set point as well, as in the scene.
        bias = self.model.actuator_biasprm[self.actuators]
        self.seconds_of_rate = bias[:, 2] / bias[:, 1]
        self.set_points = np.tile(LOW, (len(offsets_m), 1))
        threads = os.cpu_count() or 1
        self.data, self.rollout = [mujoco.MjData(self.model) for _ in range(threads)], Rollout(nthread=threads)

    def controls(self, actions: Array) -> Array:
        """Set points that move to those of the actions, at their rates, for each step of MuJoCo."""
        times = np.arange(1, self.substeps + 1)[:, None] * self.model.opt.timestep
        way = (set_points(actions) - self.set_points)[:, None]
        moved = np.clip(way, -RATES * times, RATES * times)
        rates = np.where(np.abs(way) > RATES * times, np.sign(way) * RATES, 0.0)
        path = self.set_points[:, None] + moved
        self.set_points = path[:, -1]
        controls = np.zeros((len(actions), self.substeps, self.model.nu))
        controls[:, :, self.actuators] = path + self.seconds_of_rate * rates
        return controls

    def step(self, actions: Array) -> Array:
        """Returns the heights of the cubes, m."""
        states, _ = self.rollout.rollout(self.model, self.data, self.states, self.controls(actions))
        self.states = states[:, -1]
        height_m: Array = START_Y_M - self.states[:, self.y_index]
        return height_m


def mujoco_episode(scene: phalanx.Scene, offsets_m: Array, step_s: float) -> tuple[Array, NDArray[np.bool_], float]:
    """As `phalanx_episode`, without the forces of the pads."""
    gripper = MujocoGripper(scene, offsets_m, step_s)
    start = time.perf_counter()
    heights = np.array([gripper.step(np.tile(scripted_action(step), (len(offsets_m), 1))) for step in range(STEPS)])
    return heights, heights[-1] > HELD_HEIGHT_M, time.perf_counter() - start


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("table_gripper_environment.png"))
    parser.add_argument("--environments", type=int, default=64)
    parser.add_argument("--quick", action="store_true", help="four environments")
    args = parser.parse_args(arguments)

    environment = TableGripperVectorEnvironment(4 if args.quick else args.environments)
    _, information = environment.reset(seed=0)
    episodes: dict[str, Callable[[], tuple[Array, NDArray[np.bool_], float]]] = {"phalanx": lambda: phalanx_episode(environment)}
    if mujoco is not None:
        for step_s in (0.5e-3, 2e-3):
            episodes[f"MuJoCo, {1e3 * step_s:g} ms"] = lambda step_s=step_s: mujoco_episode(  # type: ignore[misc]
                environment.scene, information["offset_m"], step_s
            )
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for name, episode in episodes.items():
        heights_m, held, wall_s = episode()
        count = environment.num_envs
        print(f"{name}: {count * STEPS / wall_s:.0f} steps/s of {count} environments; {held.sum()} of {count} held and lifted")
        axes.plot(1e3 * PERIOD_S * np.arange(1, STEPS + 1), 1e3 * heights_m[:, 0], label=name)
    axes.set_xlabel("time, ms")
    axes.set_ylabel("height of the first cube, mm")
    axes.legend(frameon=False)
    figure.savefig(args.out, dpi=120)
    print(args.out)


if __name__ == "__main__":
    main()

"""A Gymnasium environment: a gripper learns to grasp a disc that lies off the middle. Gymnasium is not needed.

    python grasp_environment.py [--out grasp_environment.png]

The agent sets the torques of both motors every 0.5 ms and sees the angles and rates of the driven links and where the
disc is. `GraspEnvironment` has `reset`, `step`, `observation_space` and `action_space`; with gymnasium installed it is
a `gymnasium.Env` with its spaces.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import phalanx

try:
    from gymnasium import Env
    from gymnasium.spaces import Box
except ImportError:
    Env = object

    class Box:
        """The part of `gymnasium.spaces.Box` that this environment uses."""

        def __init__(self, low: np.ndarray, high: np.ndarray, dtype: type = np.float64) -> None:
            self.low, self.high, self.dtype, self.shape = low.astype(dtype), high.astype(dtype), dtype, low.shape
            self.random = np.random.default_rng()

        def seed(self, seed: int) -> None:
            self.random = np.random.default_rng(seed)

        def sample(self) -> np.ndarray:
            return self.random.uniform(self.low, self.high).astype(self.dtype)

        def contains(self, x: np.ndarray) -> bool:
            return x.shape == self.shape and bool(np.all(x >= self.low) and np.all(x <= self.high))


SCENE = Path(__file__).resolve().parents[2] / "scenes" / "gripper" / "offset.toml"
PERIOD_S = 0.5e-3
MAX_TORQUE = 0.6
OBSERVED = ["right_q11_rad", "left_q11_rad", "right_qd11_rad_s", "left_qd11_rad_s", "object_x_m", "object_y_m"]
SCALES = np.array([1.0, 1.0, 100.0, 100.0, 0.01, 0.01])
MAX_OFFSET_MM = 4.0
HOLD_STEPS = 10


class GraspEnvironment(Env):
    """Grasp of a disc by both fingers; an episode ends when it is held for 5 ms, when it is lost, or after 40 ms."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, model: str = "analytic") -> None:
        self.scene, self.model = phalanx.Scene.load(SCENE), model
        limit = np.full(len(OBSERVED), np.inf)
        self.observation_space = Box(-limit, limit, dtype=np.float64)
        self.action_space = Box(np.zeros(2), np.full(2, MAX_TORQUE), dtype=np.float64)
        self.random = np.random.default_rng()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        """Places the disc at an offset, by default a random one; returns the observation."""
        if seed is not None:
            self.random = np.random.default_rng(seed)
        offset = (options or {}).get("offset_mm", self.random.uniform(-MAX_OFFSET_MM, MAX_OFFSET_MM))
        self.simulation = phalanx.Simulation(self.scene.with_({"object.offset": f"{offset} mm"}), self.model)
        self.steps = self.held = 0
        return self.observe(), {"offset_mm": offset}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Applies both torques for one period; returns observation, reward, terminated, truncated and information."""
        right, left = np.clip(action, self.action_space.low, self.action_space.high)
        self.simulation.set_torque("right_motor", float(right))
        self.simulation.set_torque("left_motor", float(left))
        self.steps += 1
        try:
            self.simulation.advance_to(self.steps * PERIOD_S)
        except phalanx.RunError as error:
            return self.observe(), -1.0, True, False, {"failure": str(error)}
        x, y = self.simulation["object_x_m"], self.simulation["object_y_m"]
        speed = np.hypot(self.simulation["object_vx_m_s"], self.simulation["object_vy_m_s"])
        forces = self.finger_forces()
        lost = not (abs(x) < 0.03 and 0 < y < 0.06)
        self.held = self.held + 1 if min(forces) > 0.5 and speed < 0.02 else 0
        grasped = self.held >= HOLD_STEPS
        # A gentle, quick and centred grasp is best.
        reward = 10.0 * grasped - 10.0 * lost - 0.01 - 0.05 * abs(x) / 1e-3 * grasped - 1e-4 * max(forces)
        information = {"forces_n": forces, "grasped": grasped, "lost": lost}
        return self.observe(), float(reward), grasped or lost, self.steps * PERIOD_S >= 0.04, information

    def finger_forces(self) -> tuple[float, float]:
        """Normal forces of the right and of the left finger on the disc, N."""
        contacts = self.simulation.contacts
        right, left = (
            sum(contacts[f"{side}_{phalanx_name}"]["normal_n"] for phalanx_name in ("proximal", "distal"))
            for side in ("right", "left")
        )
        return right, left

    def observe(self) -> np.ndarray:
        return np.array([self.simulation[name] for name in OBSERVED]) / SCALES


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("grasp_environment.png"))
    parser.add_argument("--quick", action="store_true", help="fewer policies")
    args = parser.parse_args(arguments)

    environment = GraspEnvironment()
    torques = np.linspace(0.2, MAX_TORQUE, 3 if args.quick else 9)
    offsets = (0.0, 3.5)
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for offset in offsets:
        returns = []
        for torque in torques:
            environment.reset(seed=0, options={"offset_mm": offset})
            total, done = 0.0, False
            while not done:
                _, reward, terminated, truncated, _ = environment.step(np.array([torque, torque]))
                total, done = total + reward, terminated or truncated
            returns.append(total)
        axes.plot(torques, returns, "o-", label=f"disc {offset} mm off the middle")
        print(f"offset {offset} mm: returns " + ", ".join(f"{value:.2f}" for value in returns))
    axes.set_xlabel("torque of both motors, N·m")
    axes.set_ylabel("return of an episode")
    axes.legend(frameon=False)
    figure.savefig(args.out, dpi=120)
    print(args.out)


if __name__ == "__main__":
    main()

"""A Gymnasium environment: a gripper learns to grasp a disc that lies off the middle.

    pip install gymnasium
    python grasp_environment.py [--out grasp_environment.png]

The agent sets the torques of both motors every 0.5 ms and sees the angles and rates of the driven links and where the
disc is.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any, Literal

import gymnasium
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import phalanx
from numpy.typing import NDArray

SCENE = Path(__file__).resolve().parents[2] / "scenes" / "gripper" / "offset.toml"
PERIOD_S = 0.5e-3
MAX_TORQUE = 0.6
OBSERVED = ["right_q11_rad", "left_q11_rad", "right_qd11_rad_s", "left_qd11_rad_s", "object_x_m", "object_y_m"]
SCALES: NDArray[np.float64] = np.array([1.0, 1.0, 100.0, 100.0, 0.01, 0.01])
FORCES = [f"{side}_{name}_normal_n" for side in ("right", "left") for name in ("proximal", "distal")]
MAX_OFFSET_M = 4e-3
HOLD_STEPS = 10


class GraspEnvironment(gymnasium.Env[NDArray[np.float64], NDArray[np.float64]]):
    """Grasp of a disc by both fingers; an episode ends when it is held for 5 ms, when it is lost, or after 40 ms."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, model: Literal["analytic", "engine"] = "analytic") -> None:
        self.scene, self.model = phalanx.Scene.load(SCENE), model
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (len(OBSERVED),), np.float64)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float64)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float64], dict[str, Any]]:
        """Places the disc at an offset, by default a random one; returns the observation."""
        super().reset(seed=seed)
        offset_m = (options or {}).get("offset_m", self.np_random.uniform(-MAX_OFFSET_M, MAX_OFFSET_M))
        self.simulation = phalanx.Simulation(self.scene.with_({"object.offset": offset_m}), self.model)
        self.steps = self.held = 0
        return self.observe(), {"offset_m": offset_m}

    def step(self, action: NDArray[np.float64]) -> tuple[NDArray[np.float64], float, bool, bool, dict[str, Any]]:
        """Applies both torques, from 0 (-1) to the largest (1), for one period."""
        right, left = 0.5 * MAX_TORQUE * (1.0 + np.clip(action, -1.0, 1.0))
        self.simulation.set_torque("right_motor", right)
        self.simulation.set_torque("left_motor", left)
        self.steps += 1
        try:
            self.simulation.advance_to(self.steps * PERIOD_S)
        except phalanx.RunError as error:
            return self.observe(), -1.0, True, False, {"failure": str(error)}
        x, y, vx, vy = self.simulation.observe(["object_x_m", "object_y_m", "object_vx_m_s", "object_vy_m_s"])
        forces = self.simulation.observe(FORCES).reshape(2, 2).sum(axis=1)
        lost = not (abs(x) < 0.03 and 0 < y < 0.06)
        self.held = self.held + 1 if forces.min() > 0.5 and np.hypot(vx, vy) < 0.02 else 0
        grasped = self.held >= HOLD_STEPS
        # A gentle, quick and centred grasp is best.
        reward = 10.0 * grasped - 10.0 * lost - 0.01 - 0.05 * abs(x) / 1e-3 * grasped - 1e-4 * forces.max()
        information = {"forces_n": forces, "grasped": grasped, "lost": lost}
        return self.observe(), float(reward), grasped or lost, self.steps * PERIOD_S >= 0.04, information

    def observe(self) -> NDArray[np.float64]:
        """Angles, rates and position of the disc, all of the order of 1."""
        return self.simulation.observe(OBSERVED) / SCALES


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("grasp_environment.png"))
    parser.add_argument("--quick", action="store_true", help="fewer policies")
    args = parser.parse_args(arguments)

    environment = GraspEnvironment()
    torques = np.linspace(0.2, MAX_TORQUE, 3 if args.quick else 9)
    offsets_m = (0.0, 3.5e-3)
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for offset_m in offsets_m:
        returns = []
        for torque in torques:
            environment.reset(seed=0, options={"offset_m": offset_m})
            total, done = 0.0, False
            while not done:
                _, reward, terminated, truncated, _ = environment.step(np.full(2, 2.0 * torque / MAX_TORQUE - 1.0))
                total, done = total + reward, terminated or truncated
            returns.append(total)
        label = f"{1e3 * offset_m} mm"
        axes.plot(torques, returns, "o-", label=f"disc {label} off the middle")
        print(f"offset {label}: returns " + ", ".join(f"{value:.2f}" for value in returns))
    axes.set_xlabel("torque of both motors, N·m")
    axes.set_ylabel("return of an episode")
    axes.legend(frameon=False)
    figure.savefig(args.out, dpi=120)
    print(args.out)


if __name__ == "__main__":
    main()

"""A controller in the loop: position control of a finger with a sampled, quantised and delayed angle sensor.

    python controller.py [--out controller.png]

Sampling, quantisation and delay are the lines of `Sensor` and of the loop; the simulation itself takes the steps that
its contacts need and locates every touch-down.
"""

from __future__ import annotations

import argparse
import math
from collections import deque
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import phalanx

SCENE = Path(__file__).resolve().parents[2] / "scenes" / "mechanisms" / "f85-finger.toml"
PERIOD_S = 1e-3
KP, KD, LIMIT = 2.0, 0.02, 0.25
TARGET_RAD = 0.5


class Sensor:
    """An encoder with `counts` per turn whose readings arrive `delay` samples late."""

    def __init__(self, counts: int | None, delay: int) -> None:
        self.resolution = 2 * math.pi / counts if counts else 0.0
        self.readings: deque[float] = deque([0.0] * delay, maxlen=delay + 1)

    def read(self, angle: float) -> float:
        self.readings.append(round(angle / self.resolution) * self.resolution if self.resolution else angle)
        return self.readings[0]


def control(sensor: Sensor, duration: float) -> tuple[list[float], list[float], list[float], list[phalanx.Event]]:
    """Returns times, angles and torques of a controlled closing, and its events."""
    simulation = phalanx.Simulation(SCENE)
    times, angles, torques = [], [], []
    last = sensor.read(simulation["driver_rad"])
    for sample in range(1, round(duration / PERIOD_S) + 1):
        angle = sensor.read(simulation["driver_rad"])
        torque = KP * (TARGET_RAD - angle) - KD * (angle - last) / PERIOD_S
        last = angle
        simulation.set_torque("motor", max(-LIMIT, min(torque, LIMIT)))
        times.append(simulation.time)
        angles.append(simulation["driver_rad"])
        torques.append(simulation["motor_torque_n_m"])
        simulation.advance_to(sample * PERIOD_S)
    return times, angles, torques, simulation.events


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("controller.png"))
    parser.add_argument("--quick", action="store_true", help="simulate half the duration")
    args = parser.parse_args(arguments)

    figure, (angle_axes, torque_axes) = plt.subplots(2, 1, figsize=(8, 6), sharex=True, layout="constrained")
    for label, counts, delay in (("ideal", None, 0), ("1024 counts", 1024, 0), ("1024 counts, 3 ms late", 1024, 3)):
        times, angles, torques, events = control(Sensor(counts, delay), 0.03 if args.quick else 0.06)
        angle_axes.plot([1e3 * time for time in times], [math.degrees(angle) for angle in angles], label=label)
        torque_axes.step([1e3 * time for time in times], torques, where="post", label=label)
        first = ", ".join(f"{event.contact} at {1e3 * event.time_s:.3f} ms" for event in events[:2])
        print(f"{label}: {len(events)} events, {first}")
    angle_axes.set_ylabel("angle of the driver, deg")
    torque_axes.set_ylabel("torque of the motor, N·m")
    torque_axes.set_xlabel("time, ms")
    angle_axes.legend(frameon=False)
    figure.savefig(args.out, dpi=120)
    print(args.out)


if __name__ == "__main__":
    main()

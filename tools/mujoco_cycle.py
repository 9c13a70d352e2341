"""The grasp cycle of scenes/gripper/cycle.toml in MuJoCo, for tools/work_precision.py.

`phalanx scene export` leaves out the motion of the palm and the brakes. Both are added here. MuJoCo computes in the frame of the palm, as
phalanx does: gravity is reduced by the acceleration of the palm, and the table is a body that moves in the opposite direction. A brake
is dry friction of the driven joint (`frictionloss`), as stiff as the other constraints. Torques, brakes, gravity and table are set before
each step.
"""

import re
import tempfile
import tomllib
from pathlib import Path

import mujoco_beside
from mujoco_beside import SAMPLE_S, phalanx

TABLE = """
    <body name="table" gravcomp="1">
      <joint name="table.x" type="slide" axis="1 0 0"/>
      <joint name="table.y" type="slide" axis="0 1 0"/>
      <inertial pos="0 0 0" mass="1e6" diaginertia="1e6 1e6 1e6"/>
      <geom name="ground.table" type="box" pos="0 {y} 0" size="1 0.01 1"/>
    </body>
  </worldbody>"""
SIDES = ("right", "left")
# Default of `brake_rise`.
BRAKE_RISE_S = 1e-3


def seconds(text):
    """A time such as "20 ms" in s."""
    return float(text.removesuffix(" ms")) * 1e-3


def smoothstep(s):
    return s * s * (3 - 2 * s)


class Cycle:
    """The model of a cycle with its motions."""

    def __init__(self, scene, step_s, integrator):
        import mujoco

        text = Path(scene).read_text()
        settings = tomllib.loads(text)
        # Name, direction (m), start and duration of each move.
        self.moves = [
            ([float(move.get(axis, "0 mm").removesuffix(" mm")) * 1e-3 for axis in "xy"], seconds(move["start"]), seconds(move["time"]))
            for move in settings["moves"].values()
        ]
        motor = settings["motor"]
        self.torques = list(zip(map(seconds, motor["times"]), [float(torque.removesuffix(" N*mm")) * 1e-3 for torque in motor["torques"]]))
        self.brake = seconds(motor["brake_at"]), seconds(motor["brake_release"]), float(motor["brake_torque"].removesuffix(" N*m"))
        with tempfile.TemporaryDirectory() as directory:
            fixed, path = Path(directory) / "fixed.toml", Path(directory) / "model.xml"
            # Without moves the palm is the world.
            fixed.write_text(re.sub(r"^\[moves\.[^\[]*", "", text, flags=re.MULTILINE))
            phalanx("scene", "export", fixed, "--mjcf", path)
            xml = path.read_text()
            y = float(re.search(r'<geom name="ground.table"[^>]*pos="\S+ (\S+) ', xml)[1]) + 0.01
            xml = re.sub(r'\n *<geom name="ground.table"[^>]*/>', "", xml).replace("\n  </worldbody>", TABLE.format(y=y))
            xml = re.sub(r'(<key [^>]*qpos="[^"]*)(" qvel="[^"]*)"', r'\1 0 0\2 0 0"', xml)
            path.write_text(xml)
            self.model, self.data = mujoco_beside.load(path, step_s, integrator, False)
        self.step = mujoco.mj_step
        self.motors = [self.model.actuator(f"{side}_motor").id for side in SIDES]
        self.driven = [self.model.joint(f"{side}_q11").dofadr[0] for side in SIDES]
        for rate in self.driven:
            self.model.dof_solref[rate] = (2 * step_s, 1)
        self.table = [(self.model.joint(f"table.{axis}").qposadr[0], self.model.joint(f"table.{axis}").dofadr[0]) for axis in "xy"]
        self.gravity = list(self.model.opt.gravity[:2])

    def palm(self, t):
        """Position, velocity and acceleration of the palm: polynomials of order 7 from rest to rest."""
        result = [[0.0, 0.0] for _ in range(3)]
        for direction, start, time in self.moves:
            u = min(max((t - start) / time, 0.0), 1.0)
            v = u * (1 - u)
            values = (u**4 * (35 - u * (84 - u * (70 - 20 * u))), 140 * v**3 / time, 420 * v**2 * (1 - 2 * u) / time**2)
            for derivative, value in zip(result, values):
                for axis in range(2):
                    derivative[axis] += direction[axis] * value
        return result

    def brake_torque(self, t):
        """Largest torque of a brake, N·m."""
        engaged, released = (min(max((t - start) / BRAKE_RISE_S, 0.0), 1.0) for start in self.brake[:2])
        return self.brake[2] * (smoothstep(engaged) - smoothstep(released))

    def simulate(self, duration_s, record=lambda: None):
        """Runs from the start to the end, and calls `record` every 0.1 ms."""
        model, data, step_s = self.model, self.data, self.model.opt.timestep
        motor = 0
        stride = max(1, round(SAMPLE_S / step_s))
        for step in range(round(duration_s / step_s)):
            # The middle of the step decides on discontinuities, whose times are multiples of the step.
            middle = (step + 0.5) * step_s
            while motor + 1 < len(self.torques) and middle > self.torques[motor + 1][0]:
                motor += 1
            for actuator in self.motors:
                data.ctrl[actuator] = self.torques[motor][1]
            for rate in self.driven:
                model.dof_frictionloss[rate] = self.brake_torque(middle)
            at_start, in_middle = self.palm(step * step_s), self.palm(middle)
            for axis, (position, rate) in enumerate(self.table):
                model.opt.gravity[axis] = self.gravity[axis] - in_middle[2][axis]
                data.qpos[position] = -at_start[0][axis]
                data.qvel[rate] = -at_start[1][axis]
            self.step(model, data)
            if (step + 1) % stride == 0:
                record()

"""MuJoCo models become scenes with the same motion, and everything that is lost is named."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
import phalanx
from common import SCENES, command
from convert_models import LINK, MODELS, mjcf
from gripper_models import GRIPPERS

try:
    import mujoco
except ImportError:
    mujoco = None

if mujoco is not None:
    from phalanx.convert.rigid import free_motion

# Largest difference of a coordinate from that of the hand-written scene, rad or m.
HAND_WRITTEN = 1e-6
# Tolerance of the motion beside MuJoCo over 50 ms, rad or m; it is larger where the force of a servo reaches its limit within a step.
RIGID = 1e-8
CLIPPED = {"gear": 2e-8, "coef": 4e-8}


def convert(text: str, **options: object) -> phalanx.Conversion:
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "model.xml"
        path.write_text(text)
        return phalanx.from_mjcf(path, **options)


def notes(conversion: phalanx.Conversion, kind: str) -> str:
    return "\n".join(str(note) for note in conversion.report.of(kind))


def difference(first: phalanx.Result, a: str, second: phalanx.Result, b: str) -> float:
    """Largest difference of two columns at the times that both runs have."""
    _, i, j = np.intersect1d(first.time, second.time, return_indices=True)
    assert len(i) > 200
    return float(np.abs(first[a][i] - second[b][j]).max())


def column(conversion: phalanx.Conversion, name: str) -> str:
    joint = next(joint for joint in conversion.mechanism.joints if joint.name == name)
    return f"{name}_position_m" if joint.is_slide else f"{name}_rad"


@unittest.skipIf(mujoco is None, "needs mujoco")
class Motions(unittest.TestCase):
    def test_equal_those_of_hand_written_scenes(self):
        for name, model in {**MODELS, **GRIPPERS}.items():
            with self.subTest(model=name):
                conversion = convert(model.mjcf, duration=0.05)
                own = phalanx.run(conversion.scene, preset="reference")
                hand_written = phalanx.run(phalanx.Scene.from_toml(model.scene), preset="reference")
                for joint, other in model.joints.items():
                    self.assertLess(difference(own, column(conversion, joint), hand_written, other), HAND_WRITTEN, joint)
                    self.assertGreater(np.ptp(hand_written[other]), 1e-3)

    def test_equal_those_of_mujoco_with_rigid_constraints(self):
        for name, model in {**MODELS, **GRIPPERS}.items():
            with self.subTest(model=name):
                conversion = convert(model.mjcf)
                found = free_motion(conversion.source, conversion.plane, conversion.mechanism, 0.05)
                self.assertEqual(found.keys(), model.joints.keys())
                self.assertLess(max(found.values()), CLIPPED.get(name, RIGID))

    def test_export_and_back_gives_the_same_motion(self):
        for name in ("four-bar", "slider-crank", "andrews"):
            with self.subTest(scene=name):
                scene = phalanx.Scene.load(SCENES / "mechanisms" / f"{name}.toml")
                conversion = convert(scene.to_mjcf(), duration=scene.duration_s)
                tight = {"duration": min(scene.duration_s, 0.05), "rtol": 1e-12}
                first, second = phalanx.run(scene, **tight), phalanx.run(conversion.scene, **tight)
                model = conversion.source.model
                for joint in (model.joint(k).name for k in range(model.njnt)):
                    # Andrews' mechanism turns ten times in 30 ms, and multiplies rounding errors.
                    bound = 1e-6 if name == "andrews" else 1e-9
                    self.assertLess(difference(first, column(conversion, joint), second, column(conversion, joint)), bound)


@unittest.skipIf(mujoco is None, "needs mujoco")
class Refusals(unittest.TestCase):
    def assert_refused(self, text: str, *parts: str, **options: object) -> None:
        with self.assertRaises(phalanx.ConversionError) as raised:
            convert(text, **options)
        for part in parts:
            self.assertIn(part, str(raised.exception))

    def test_name_the_axis_that_contradicts(self):
        hand = f'<body name="wrist"><joint name="roll" axis="0 0 1"/>{LINK}<body name="palm" pos="0 0 0.1"><geom size="0.01"/>'
        hand += "".join(
            f'<body name="{name}" pos="{x} 0 0"><joint name="{name}" axis="0 -1 0"/>{LINK}</body>' for name, x in (("left", -0.02), ("right", 0.02))
        )
        hand = mjcf(hand + "</body></body>")
        self.assert_refused(hand, "joint roll", "(0, 0, 1)", "90 deg", 'root="wrist"')
        conversion = convert(hand, root="palm")
        self.assertEqual([joint.name for joint in conversion.mechanism.joints], ["left", "right"])
        self.assertIn("roll", notes(conversion, "lost"))
        self.assert_refused(hand, "no body wrists", "wrist, palm, left, right", root="wrists")

    def test_name_what_a_scene_does_not_have(self):
        link = f'<body name="a"><joint name="a" axis="0 -1 0"/>{LINK}</body><body name="b"><joint name="b" axis="0 -1 0"/>{LINK}</body>'
        polynomial = '<equality><joint name="cam" joint1="a" joint2="b" polycoef="0 1 0.2 0 0"/></equality>'
        self.assert_refused(mjcf(link, polynomial), "equality cam", "order 2")
        ball = f'<body name="a"><joint name="a" axis="0 -1 0"/>{LINK}<body name="b"><joint name="b" type="ball"/>{LINK}</body></body>'
        self.assert_refused(mjcf(ball), "b is a ball joint")
        double = f'<body name="a"><joint name="a" axis="0 -1 0"/>{LINK}<body name="b"><joint name="x" type="slide" axis="1 0 0"/><joint name="y" axis="0 -1 0"/>{LINK}</body></body>'
        self.assert_refused(mjcf(double), "body b has 2 joints (x, y)")
        self.assert_refused(mjcf('<body name="a"><joint name="a" axis="0 -1 0"/></body>'), "MuJoCo does not read")
        self.assert_refused(mjcf(""), "no hinge or slide")
        self.assert_refused("<mujoco", "no XML file")
        self.assert_refused(mjcf(link), "no key frame open", key="open")
        self.assert_refused(mjcf(link), "no actuator motor", ctrl={"motor": 1.0})
        self.assert_refused(mjcf(link), "no plane 'xw'", plane="xw")

    def test_without_mujoco_name_the_command(self):
        with mock.patch.dict(sys.modules, {"mujoco": None}), self.assertRaises(ImportError) as raised:
            convert(mjcf(""))
        self.assertIn('pip install "phalanx[mujoco]"', str(raised.exception))


if __name__ == "__main__":
    unittest.main()

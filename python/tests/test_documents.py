"""Functions return the JSON documents of the commands, with the same defaults."""

import unittest

import phalanx
from common import ANCHOR, DISCS, GRIPPER, SCENES, document

HOLD = SCENES / "gripper" / "hold.toml"


def without_times(value: object) -> object:
    """Removes the times of a document, which differ between runs."""
    time_keys = ("wall_s", "timed_runs", "real_time_factor", "analytic_factor")
    if isinstance(value, dict):
        return {key: without_times(item) for key, item in value.items() if key not in time_keys}
    return [without_times(item) for item in value] if isinstance(value, list) else value


class Documents(unittest.TestCase):
    maxDiff = 2000

    def assert_same(self, package: dict, program: dict) -> None:
        self.assertEqual(package.keys(), program.keys())
        for key in package.keys():
            self.assertEqual(package[key], program[key], key)

    def test_statics(self):
        self.assert_same(phalanx.statics(ANCHOR), document("statics", ANCHOR))
        flags = ["--mu-static", "0,0.4", "--motor", "500 N*mm"]
        self.assert_same(phalanx.statics(ANCHOR, [0, 0.4], "500 N*mm"), document("statics", ANCHOR, *flags))
        self.assert_same(phalanx.statics(ANCHOR, [0, 0.4], 0.5), document("statics", ANCHOR, *flags))
        design = SCENES / "gripper" / "design-95.toml"
        flags = ["--posture", "geometric", "--every", "30 deg"]
        self.assert_same(phalanx.statics(design, posture="geometric", every="30 deg"), document("statics", design, *flags))
        self.assert_same(phalanx.statics(design), document("statics", design))
        for scene, options, message in (
            (ANCHOR, {"posture": "run"}, "for a gripper"),
            (DISCS, {}, "name the held body"),
            (DISCS, {"posture": "run"}, "for fingers and grippers"),
            (design, {"posture": "closed"}, "no `=`"),
            (design, {"posture": "geometric", "at": 0.1}, "remove one of them"),
            (ANCHOR, {"mu_static": [-1]}, "0 or more"),
            (ANCHOR, {"motor": "5 mm"}, "torque"),
        ):
            with self.subTest(options=options), self.assertRaisesRegex(phalanx.PhalanxError, message):
                phalanx.statics(scene, **options)

    def test_size(self):
        self.assert_same(phalanx.size(ANCHOR), document("size", ANCHOR))
        flags = ["--rule", "whole", "--closing-time", "8 ms", "--preload", "60 deg"]
        self.assert_same(phalanx.size(ANCHOR, "whole", "8 ms", "60 deg"), document("size", ANCHOR, *flags))
        for scene, options, message in (
            (GRIPPER, {}, "one finger"),
            (ANCHOR, {"rule": "x"}, "rigid"),
            (ANCHOR, {"closing_time": -1}, "greater than 0"),
        ):
            with self.assertRaisesRegex(phalanx.SceneError, message):
                phalanx.size(scene, **options)

    def test_hold(self):
        quick = {"scan": 2, "tol": 0.5, "directions": 1, "to": "100 m/s^2", "slip": 0.5e-3}
        flags = ["--scan", "2", "--tol", "0.5", "--directions", "1", "--to", "100 m/s^2"]
        self.assert_same(phalanx.hold(HOLD, **quick), document("hold", HOLD, *flags))
        vibration = {"vibration": [50, "200 Hz"], "along": ["x"], "scan": 2, "tol": 0.5, "to": 30.0}
        flags = ["--vibration", "50 Hz, 200 Hz", "--along", "x", "--scan", "2", "--tol", "0.5", "--to", "30 m/s^2"]
        self.assert_same(phalanx.hold(HOLD, **vibration), document("hold", HOLD, *flags))
        for options, message in (
            ({"scan": 1}, "from 2"),
            ({"from_": 5.0, "to": 1.0}, "`from_` must be smaller"),
            ({"move": True, "pulse": "1 ms"}, "exclude each other"),
            ({"vibration": [50, 50]}, "twice"),
            ({"vibration": [50], "along": ["z"]}, "along contains"),
            ({"directions": 0}, "1 to 360"),
        ):
            with self.subTest(options=options), self.assertRaisesRegex(phalanx.SceneError, message):
                phalanx.hold(HOLD, **options)
        with self.assertRaisesRegex(phalanx.SceneError, "is not a gripper"):
            phalanx.hold(ANCHOR)

    def test_hold_has_the_defaults_of_the_program(self):
        quick = ["--directions", "1", "--scan", "2", "--tol", "0.9"]
        self.assert_same(phalanx.hold(HOLD, directions=1, scan=2, tol=0.9), document("hold", HOLD, *quick))

    def test_capture(self):
        flags = ["--places", "3", "--to", "1 mm"]
        self.assert_same(phalanx.capture(GRIPPER, places=3, to="1 mm"), document("capture", GRIPPER, *flags))
        self.assert_same(phalanx.capture(phalanx.Scene.load(GRIPPER), places=3), document("capture", GRIPPER, "--places", "3"))
        for scene, options, message in (
            (ANCHOR, {}, "is not a gripper"),
            (GRIPPER, {"places": 4}, "odd"),
            (GRIPPER, {"to": "1 s"}, "length"),
        ):
            with self.assertRaisesRegex(phalanx.SceneError, message):
                phalanx.capture(scene, **options)

    def test_validate(self):
        package = phalanx.validate(ANCHOR, quick=True)
        program = document("validate", ANCHOR, "--quick")
        self.assert_same(without_times(package), without_times(program))
        self.assertTrue(package["passed"])
        with self.assertRaisesRegex(phalanx.SceneError, "stores several runs in memory"):
            phalanx.validate(phalanx.Scene.load(ANCHOR).with_({"log.numeric_rate": "40 MHz", "log.picture_rate": "0 Hz", "duration": "100 ms"}))


if __name__ == "__main__":
    unittest.main()

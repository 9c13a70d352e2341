"""What commands print as JSON is what functions return, with the defaults of either."""

import unittest

import phalanx
from common import ANCHOR, DISCS, GRIPPER, SCENES, document

HOLD = SCENES / "gripper" / "hold.toml"


def timeless(of: object) -> object:
    """Without how long anything took, which is measured anew each time."""
    measured = ("wall_s", "timed_runs", "real_time_factor", "analytic_factor")
    if isinstance(of, dict):
        return {key: timeless(value) for key, value in of.items() if key not in measured}
    return [timeless(part) for part in of] if isinstance(of, list) else of


class Documents(unittest.TestCase):
    maxDiff = 2000

    def same(self, ours: dict, theirs: dict, but: tuple[str, ...] = ()) -> None:
        self.assertEqual(ours.keys(), theirs.keys())
        for key in ours.keys() - set(but):
            self.assertEqual(ours[key], theirs[key], key)

    def test_statics(self):
        self.same(phalanx.statics(ANCHOR), document("statics", ANCHOR))
        flags = ["--mu-static", "0,0.4", "--motor", "500 N*mm"]
        self.same(phalanx.statics(ANCHOR, [0, 0.4], "500 N*mm"), document("statics", ANCHOR, *flags))
        self.same(phalanx.statics(ANCHOR, [0, 0.4], 0.5), document("statics", ANCHOR, *flags))
        design = SCENES / "gripper" / "design-95.toml"
        flags = ["--posture", "geometric", "--every", "30 deg"]
        self.same(phalanx.statics(design, posture="geometric", every="30 deg"), document("statics", design, *flags))
        self.same(phalanx.statics(design), document("statics", design))
        for scene, flags, words in (
            (ANCHOR, {"posture": "run"}, "for a gripper"),
            (DISCS, {}, "scene of discs"),
            (design, {"posture": "closed"}, "no `=`"),
            (design, {"posture": "geometric", "at": 0.1}, "take one of them out"),
            (ANCHOR, {"mu_static": [-1]}, "0 or more"),
            (ANCHOR, {"motor": "5 mm"}, "torque"),
        ):
            with self.subTest(flags=flags), self.assertRaisesRegex(phalanx.PhalanxError, words):
                phalanx.statics(scene, **flags)

    def test_size(self):
        self.same(phalanx.size(ANCHOR), document("size", ANCHOR))
        flags = ["--rule", "whole", "--closing-time", "8 ms", "--preload", "60 deg"]
        self.same(phalanx.size(ANCHOR, "whole", "8 ms", "60 deg"), document("size", ANCHOR, *flags))
        for scene, flags, words in ((GRIPPER, {}, "one finger"), (ANCHOR, {"rule": "x"}, "rigid"), (ANCHOR, {"closing_time": -1}, "more than 0")):
            with self.assertRaisesRegex(phalanx.SceneError, words):
                phalanx.size(scene, **flags)

    def test_hold(self):
        quick = {"scan": 2, "tol": 0.5, "directions": 1, "to": "100 m/s^2", "slip": 0.5e-3}
        flags = ["--scan", "2", "--tol", "0.5", "--directions", "1", "--to", "100 m/s^2"]
        self.same(phalanx.hold(HOLD, **quick), document("hold", HOLD, *flags))
        vibration = {"vibration": [50, "200 Hz"], "along": ["x"], "scan": 2, "tol": 0.5, "to": 30.0}
        flags = ["--vibration", "50 Hz, 200 Hz", "--along", "x", "--scan", "2", "--tol", "0.5", "--to", "30 m/s^2"]
        self.same(phalanx.hold(HOLD, **vibration), document("hold", HOLD, *flags))
        for flags, words in (
            ({"scan": 1}, "from 2"),
            ({"from_": 5.0, "to": 1.0}, "first must be smaller"),
            ({"move": True, "pulse": "1 ms"}, "exclude each other"),
            ({"vibration": [50, 50]}, "twice"),
            ({"vibration": [50], "along": ["z"]}, "along has"),
            ({"directions": 0}, "1 to 360"),
        ):
            with self.subTest(flags=flags), self.assertRaisesRegex(phalanx.SceneError, words):
                phalanx.hold(HOLD, **flags)
        with self.assertRaisesRegex(phalanx.SceneError, "is no gripper"):
            phalanx.hold(ANCHOR)

    def test_defaults_of_hold_are_those_of_the_program(self):
        quick = ["--directions", "1", "--scan", "2", "--tol", "0.9"]
        self.same(phalanx.hold(HOLD, directions=1, scan=2, tol=0.9), document("hold", HOLD, *quick))

    def test_capture(self):
        flags = ["--places", "3", "--to", "1 mm"]
        self.same(phalanx.capture(GRIPPER, places=3, to="1 mm"), document("capture", GRIPPER, *flags))
        self.same(phalanx.capture(phalanx.Scene.load(GRIPPER), places=3), document("capture", GRIPPER, "--places", "3"))
        for scene, flags, words in ((ANCHOR, {}, "is no gripper"), (GRIPPER, {"places": 4}, "odd"), (GRIPPER, {"to": "1 s"}, "length")):
            with self.assertRaisesRegex(phalanx.SceneError, words):
                phalanx.capture(scene, **flags)

    def test_validate(self):
        ours = phalanx.validate(ANCHOR, quick=True)
        theirs = document("validate", ANCHOR, "--quick")
        self.same(timeless(ours), timeless(theirs))
        self.assertTrue(ours["passed"])
        with self.assertRaisesRegex(phalanx.SceneError, "holds several runs in memory"):
            phalanx.validate(phalanx.Scene.load(ANCHOR).with_({"log.numeric_rate": "40 MHz", "log.picture_rate": "0 Hz", "duration": "100 ms"}))


if __name__ == "__main__":
    unittest.main()

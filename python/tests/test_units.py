"""Every duration, length, angle, force and rate is a string with a unit or a number in SI."""

import unittest

import numpy as np
import phalanx
from common import ANCHOR, DISCS, GRIPPER, SCENES

LIFT = SCENES / "real" / "2f85-lift.toml"


class Units(unittest.TestCase):
    def assert_same_numbers(self, first: phalanx.Result, second: phalanx.Result) -> None:
        self.assertEqual(first.columns, second.columns)
        for name in first:
            np.testing.assert_array_equal(first[name], second[name], err_msg=name)

    def test_settings_of_a_run(self):
        for options, si in (
            ({"duration": "5 ms"}, {"duration": 5e-3}),
            ({"duration": "4 ms", "numeric_rate": "2 kHz"}, {"duration": 4e-3, "numeric_rate": 2e3}),
            ({"duration": "4 ms", "picture_rate": "1 kHz"}, {"duration": 4e-3, "picture_rate": 1000}),
            ({"duration": "2 ms", "model": "engine", "step": "2 us"}, {"duration": 2e-3, "model": "engine", "step": 2e-6}),
            ({"duration": "2 ms", "model": "engine", "tolerance": "0.1 um"}, {"duration": 2e-3, "model": "engine", "tolerance": 1e-7}),
        ):
            with self.subTest(si=si):
                self.assert_same_numbers(phalanx.run(ANCHOR, **options), phalanx.run(ANCHOR, **si))
        self.assertEqual(phalanx.run(ANCHOR, duration=np.float64(3e-3)).time[-1], 3e-3)
        for options, message in (
            ({"duration": 0.0}, "longer than 0"),
            ({"duration": float("nan")}, "NaN"),
            ({"step": -1e-6, "model": "engine"}, "step: .*longer than 0"),
            ({"duration": "5 mm"}, "time"),
        ):
            with self.subTest(options=options), self.assertRaisesRegex(phalanx.SceneError, message):
                phalanx.run(ANCHOR, **options)
        with self.assertRaises(TypeError):
            phalanx.run(ANCHOR, duration=[1])

    def test_fields_of_a_scene(self):
        for path, texts, numbers in (
            (ANCHOR, {"design.base": "14 mm"}, {"design.base": 0.014}),
            (ANCHOR, {"gravity": ["0 m/s^2", "-1 m/s^2"]}, {"gravity": [0, -1.0]}),
            (ANCHOR, {"gravity[1]": "-2 m/s^2", "duration": "15 ms"}, {"gravity[1]": -2, "duration": np.float64(0.015)}),
            (GRIPPER, {"object.offset": "1.5 mm"}, {"object.offset": 1.5e-3}),
            (DISCS, {"duration": "2 ms"}, {"duration": 2e-3}),
            (LIFT, {"parameters.table": "161 mm"}, {"parameters.table": 0.161}),
            (LIFT, {"bodies.object.start.at": ["1 mm", "140 mm"]}, {"bodies.object.start.at": (0.001, 0.14)}),
            # Units depend on the joint.
            (LIFT, {"actuators.lift.kp": "2e5 N/m"}, {"actuators.lift.kp": 2e5}),
            (LIFT, {"actuators.motor.kp": "90 N*m/rad"}, {"actuators.motor.kp": 90}),
            (LIFT, {"actuators.lift.targets": ["0 m"] * 4 + ["0.04 m"]}, {"actuators.lift.targets": [0.0] * 4 + [0.04]}),
            (LIFT, {"joints.lift.damping": "3 N*s/m"}, {"joints.lift.damping": 3}),
            (LIFT, {"joints.right_tip.damping": "0.01 N*m*s/rad"}, {"joints.right_tip.damping": 0.01}),
        ):
            scene = phalanx.Scene.load(path)
            with self.subTest(numbers=numbers):
                self.assertEqual(scene.with_(numbers).resolved, scene.with_(texts).resolved)
        # A plain number stays one.
        self.assertEqual(phalanx.Scene.load(ANCHOR).with_({"contact.friction.mu_static": 1})["contact.friction.mu_static"], 1)
        for fields in ({"design.base": float("nan")}, {"design.base": -0.01}, {"palm": 0.5}, {"laws.pad.damping": 3.0}):
            scene = phalanx.Scene.load(LIFT if "laws.pad.damping" in fields else ANCHOR)
            with self.subTest(fields=fields), self.assertRaises(phalanx.SceneError):
                scene.with_(fields)

    def test_dictionaries(self):
        scene = phalanx.Scene.load(LIFT)
        expected = scene.to_dict()
        numbers = scene.to_dict()
        numbers["duration"] = 0.25
        numbers["joints"]["lift"]["start"] = 0.0
        numbers["actuators"]["lift"]["targets"] = [0.0, 0, 0.008, "42 mm", 0.05]
        numbers["actuators"]["motor"]["limit"] = 5.0
        numbers["bodies"]["object"]["mass"] = 0.1
        self.assertEqual(phalanx.Scene.from_dict(numbers).resolved, phalanx.Scene.from_dict(expected).resolved)
        extending = {"extends": "2f85-lift.toml", "duration": 0.1, "actuators": {"lift": {"kp": 2e5}}}
        name = str(LIFT.parent / "own.toml")
        texts = {"extends": "2f85-lift.toml", "duration": "100 ms", "actuators": {"lift": {"kp": "2e5 N/m"}}}
        self.assertEqual(phalanx.Scene.from_dict(extending, name).resolved, phalanx.Scene.from_dict(texts, name).resolved)
        finger = phalanx.Scene.load(ANCHOR).to_dict()
        finger["design"]["base"], finger["motor"]["torque"] = 0.014, 0.5
        changed = phalanx.Scene.load(ANCHOR).with_({"design.base": "14 mm", "motor.torque": "500 N*mm"})
        self.assertEqual(phalanx.Scene.from_dict(finger).resolved, changed.resolved)

    def test_arrays_of_designs(self):
        fields = {"actuators.motor.limit": [4.0, 5.0], "duration": 0.02}
        texts = {"actuators.motor.limit": ["4 N*m", "5 N*m"], "duration": "20 ms"}
        tables = [phalanx.evaluate(SCENES / "real" / "2f85-pinch.toml", each, threads=1) for each in (fields, texts)]
        self.assertEqual(list(tables[0]["status"]), ["completed", "completed"], tables[0]["reason"])
        self.assertEqual(tables[0].columns, tables[1].columns)
        for column in tables[0].columns:
            np.testing.assert_array_equal(tables[0][column], tables[1][column], err_msg=column)

    def test_simulations(self):
        by_texts, by_numbers = phalanx.Simulation(ANCHOR), phalanx.Simulation(ANCHOR)
        by_texts.set_torque("motor", "400 N*mm")
        by_numbers.set_torque("motor", 0.4)
        by_texts.advance("3 ms"), by_numbers.advance(3e-3)
        by_texts.advance_to("5 ms"), by_numbers.advance_to(5e-3)
        columns = by_texts.columns
        np.testing.assert_array_equal(by_texts.observe(columns), by_numbers.observe(columns))
        for call in (
            lambda: by_texts.advance("5 mm"),
            lambda: by_texts.set_torque("motor", "5 N"),
            lambda: by_texts.advance(float("nan")),
            lambda: by_texts.set_torque("motor", float("inf")),
        ):
            with self.assertRaises(phalanx.SceneError):
                call()
        with self.assertRaises(TypeError):
            by_texts.advance(None)

    def test_targets_of_simulations(self):
        by_texts, by_numbers = phalanx.Simulation(LIFT), phalanx.Simulation(LIFT)
        by_texts.set_target("lift", "5 mm", "10 mm/s"), by_numbers.set_target("lift", 5e-3, 0.01)
        by_texts.set_target("motor", "30 deg", "20 deg/s"), by_numbers.set_target("motor", np.radians(30), np.radians(20))
        for each in (by_texts, by_numbers):
            each.advance(4e-3)
        columns = by_texts.columns
        np.testing.assert_allclose(by_texts.observe(columns), by_numbers.observe(columns), rtol=1e-9, atol=1e-12)
        with self.assertRaisesRegex(phalanx.SceneError, "length"):
            by_texts.set_target("lift", "5 deg")

    def test_batches(self):
        first, second = (phalanx.SimulationBatch([ANCHOR] * 2) for _ in range(2))
        first.set_torque("motor", ["300 N*mm", 0.4]), second.set_torque("motor", [0.3, 0.4])
        first.advance("2 ms"), second.advance(2e-3)
        first.set_torque("motor", "0.5 N*m"), second.set_torque("motor", 0.5)
        first.advance("2 ms"), second.advance(2e-3)
        np.testing.assert_array_equal(first.observe(["q11_rad"]), second.observe(["q11_rad"]))

    def test_documents(self):
        texts, numbers = (phalanx.statics(LIFT, at="250 ms", every="30 deg"), phalanx.statics(LIFT, at=0.25, every=np.pi / 6))
        self.assertEqual(texts, numbers)
        for function, arguments, texts, numbers in (
            (phalanx.statics, (ANCHOR,), {"motor": "500 N*mm"}, {"motor": 0.5}),
            (phalanx.statics, (GRIPPER,), {"at": "20 ms", "within": "0.1 mm"}, {"at": 0.02, "within": 1e-4}),
            (phalanx.size, (ANCHOR,), {"closing_time": "8 ms", "preload": "1 rad"}, {"closing_time": 8e-3, "preload": 1.0}),
            (phalanx.capture, (GRIPPER,), {"to": "1 mm", "finely": "0.5 mm", "places": 3}, {"to": 1e-3, "finely": 5e-4, "places": 3}),
        ):
            with self.subTest(numbers=numbers):
                self.assertEqual(function(*arguments, **texts), function(*arguments, **numbers))
        quick = {"scan": 2, "tol": 0.9}
        texts = {"vibration": ["50 Hz"], "from_": "5 m/s^2", "to": "30 m/s^2", "slip": "0.5 mm", "along": ["x"]}
        numbers = {"vibration": [50.0], "from_": 5.0, "to": 30.0, "slip": 5e-4, "along": ["x"]}
        hold = SCENES / "gripper" / "hold.toml"
        self.assertEqual(phalanx.hold(hold, **texts, **quick), phalanx.hold(hold, **numbers, **quick))


if __name__ == "__main__":
    unittest.main()

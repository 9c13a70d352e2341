"""Runs give the same results as the program, as columns without copies."""

import csv
import html
import re
import tempfile
import unittest
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import phalanx
import polars
import pyarrow
import pyarrow.interchange
from common import ANCHOR, DISCS, GRIPPER, command, document


def address(array: np.ndarray) -> int:
    return array.__array_interface__["data"][0]


class Runs(unittest.TestCase):
    def assert_same_results(self, package: dict, program: dict) -> None:
        for key in ("wall_s", "log"):
            package.pop(key), program.pop(key)
        self.assertEqual(package, program)

    def test_run_equals_the_run_of_the_program(self):
        cases = [
            (ANCHOR, {}, []),
            (ANCHOR, {"preset": "reference", "duration": "8 ms"}, ["--preset", "reference", "--duration", "8 ms"]),
            (ANCHOR, {"preset": "draft"}, ["--preset", "draft"]),
            (ANCHOR, {"rtol": 1e-8}, ["--rtol", "1e-8"]),
            (ANCHOR, {"model": "engine", "step": "2 us", "duration": "5 ms"}, ["--model", "engine", "--step", "2 us", "--duration", "5 ms"]),
            (GRIPPER, {"duration": "12 ms"}, ["--duration", "12 ms"]),
            (DISCS, {}, []),
        ]
        for scene, options, flags in cases:
            with self.subTest(scene=scene.name, flags=flags):
                result = phalanx.run(scene, check=None, **options)
                self.assert_same_results(result.summary, document("run", scene, *flags))
                self.assertEqual(result.outcome["steps"], result.summary["steps"])

    def test_run_is_checked_only_on_request(self):
        self.assertIsNone(phalanx.run(ANCHOR).check)
        self.assertEqual(phalanx.run(ANCHOR, check=True).check["verdict"], "sure")

    def test_columns_equal_the_csv_table_of_replay(self):
        with tempfile.TemporaryDirectory() as directory:
            log, table = Path(directory) / "run.mcap", Path(directory) / "run.csv"
            command("run", ANCHOR, "--log", log, "--set", "log.joint_forces=true")
            command("replay", log, "--csv", table)
            with table.open(newline="") as file:
                header, *rows = list(csv.reader(file))
            result = phalanx.run(ANCHOR)
            self.assertEqual(result.columns, header)
            self.assertEqual(len(result.time), len(rows))
            for index, name in enumerate(header):
                expected = np.array([float(row[index] or "nan") for row in rows])
                np.testing.assert_array_equal(result[name], expected, err_msg=name)

    def test_columns_are_not_copied(self):
        result = phalanx.run(ANCHOR)
        q11 = result["q11_rad"]
        self.assertEqual((q11.dtype, q11.flags.writeable, q11.flags.owndata), (np.float64, False, False))
        self.assertEqual(address(q11), address(result["q11_rad"]))
        self.assertEqual(result.time[-1], 0.02)
        table = pyarrow.table(result)
        self.assertEqual(table.column("q11_rad").chunk(0).buffers()[1].address, address(q11))
        self.assertEqual(address(result.to_polars()["q11_rad"].to_numpy(allow_copy=False)), address(q11))
        self.assertTrue(np.shares_memory(result.to_pandas()["q11_rad"].to_numpy(), q11))
        self.assertEqual(polars.DataFrame(result).columns, result.columns)
        # The array remains valid after its result has been deleted.
        last = q11[-1]
        del result, table
        self.assertEqual(q11[-1], last)
        with self.assertRaises(ValueError):
            q11[0] = 1.0
        with self.assertRaisesRegex(KeyError, "did you mean \"q11_rad\""):
            phalanx.run(ANCHOR)["q11_rd"]

    def test_a_result_is_a_mapping(self):
        result = phalanx.run(ANCHOR, duration="5 ms")
        self.assertIsInstance(result, Mapping)
        self.assertEqual(list(result), result.columns)
        self.assertEqual((list(result.keys()), len(result)), (result.columns, len(result.columns)))
        self.assertIn("q11_rad", result)
        for missing in ("q11", 3, None):
            self.assertNotIn(missing, result)
            self.assertIsNone(result.get(missing))
            self.assertEqual(result.get(missing, 7), 7)
        self.assertEqual(address(result.get("q11_rad")), address(result["q11_rad"]))
        self.assertEqual([address(column) for column in result.values()], [address(result[name]) for name in result])
        self.assertEqual([name for name, _ in result.items()], result.columns)
        self.assertEqual({**result}.keys(), result.keys())
        match result:
            case {"time_s": time, "q11_rad": _}:
                np.testing.assert_array_equal(time, result.time)
            case _:
                self.fail("a result matches no mapping pattern")
        for key in ("scene", "contacts", "energy", "criteria"):
            self.assertIn(key, result.summary)

    def test_columns_through_the_interchange_protocol(self):
        result = phalanx.run(ANCHOR, duration="5 ms")
        frame = pyarrow.interchange.from_dataframe(result)
        self.assertEqual(frame.column_names, result.columns)
        np.testing.assert_array_equal(frame["q11_rad"].to_numpy(), result["q11_rad"])

    def test_events_and_criteria(self):
        result = phalanx.run(ANCHOR)
        touch_downs = [event for event in result.events if event.kind == "touch-down" and event.time_s > 0]
        self.assertEqual([event.contact for event in touch_downs], ["proximal", "distal"])
        self.assertAlmostEqual(touch_downs[1].time_s, 6.883746e-3, places=8)
        self.assertGreater(touch_downs[0].approach_speed, 2)
        self.assertEqual(result.criteria["class"], "stable")
        self.assertIn("from 6.88 ms on, in less than 15 ms", result.criteria["class_reason"])
        damped = phalanx.run(phalanx.Scene.load(ANCHOR).with_({"contact.damping": "1e4 N*s/m"})).criteria
        self.assertEqual(damped["class"], "unstable")
        self.assertEqual(damped["class_reason"], "q21 ends 0.249° from the grasp; at most 0.2° count as in position")
        self.assertAlmostEqual(result.contacts["proximal"]["first_s"], touch_downs[0].time_s, places=12)
        self.assertAlmostEqual(result.energies["balance_j"], result["balance_j"][-1])
        gripper = phalanx.run(GRIPPER)
        self.assertEqual(gripper.criteria["fate"], "held")
        self.assertEqual(gripper.criteria["grasp"], gripper.summary["grasp"])
        self.assertIsNone(phalanx.run(DISCS).criteria)

    def test_log_equals_the_log_of_the_program(self):
        with tempfile.TemporaryDirectory() as directory:
            program, saved, logged = (Path(directory) / f"{name}.mcap" for name in ("program", "saved", "logged"))
            for scene, flags, options in ((ANCHOR, [], {}), (GRIPPER, ["--duration", "10 ms"], {"duration": "10 ms"})):
                command("run", scene, "--log", program, *flags)
                result = phalanx.run(scene, check=None, log=logged, **options)
                result.save(saved)
                self.assertEqual(saved.read_bytes(), program.read_bytes())
                self.assertEqual(logged.read_bytes(), program.read_bytes())
                read = phalanx.read_log(program)
                self.assertEqual(read.events, result.events)
                # Logs have the forces of joints on request only.
                columns = [name for name in result.columns if "_force_" not in name]
                self.assertEqual(read.columns, columns)
                for name in columns:
                    np.testing.assert_array_equal(read[name], result[name], err_msg=name)
                self.assertEqual(read.criteria, result.criteria)
                self.assertEqual(read.summary, document("replay", program))

    def test_read_log_rejects_other_files(self):
        for path, message in ((ANCHOR, "MCAP"), (ANCHOR.parent / "no.mcap", "there is no log")):
            with self.assertRaisesRegex(phalanx.RunError, message):
                phalanx.read_log(path)

    def test_page_equals_the_page_of_the_program(self):
        with tempfile.TemporaryDirectory() as directory:
            page = Path(directory) / "run.html"
            command("run", ANCHOR, "--plot", page)
            # Only the wall times differ between two runs.
            without_times = lambda text: [line for line in text.splitlines() if " wall " not in line and "steps" not in line]  # noqa: E731
            result = phalanx.run(ANCHOR, check=None)
            self.assertEqual(without_times(result.html()), without_times(page.read_text()))
            frame = result._repr_html_()
            content = re.match(r'<iframe srcdoc="([^"]*)" sandbox="allow-scripts', frame)[1]
            self.assertEqual(html.unescape(content), result.html())

    def test_invalid_arguments_raise_the_errors_of_the_program(self):
        for options, message in (
            ({"model": "magic"}, "\"analytic\" or \"engine\""),
            ({"preset": "fine"}, "\"draft\" or \"engineering\" or \"reference\""),
            ({"step": "1 us"}, 'leave `step` out or use model="engine"'),
            ({"model": "engine", "rtol": 1e-6}, "leave `rtol` out"),
            ({"rtol": 2.0}, "between 0 and 1"),
            ({"duration": "0 ms"}, "longer than 0"),
            ({"model": "engine", "step": "1 us", "tolerance": "1 um"}, "leave one of them out"),
            ({"numeric_rate": "9000 MHz"}, "use numeric_rate="),
        ):
            with self.subTest(options=options), self.assertRaisesRegex(phalanx.SceneError, message):
                phalanx.run(ANCHOR, **options)

    def test_error_of_an_incomplete_run_contains_its_result(self):
        scene = phalanx.Scene.load(ANCHOR).with_({"integrator.max_steps": 100})
        with self.assertRaisesRegex(phalanx.RunError, "the simulation stopped at") as caught:
            phalanx.run(scene)
        result = caught.exception.result
        self.assertFalse(result.completed)
        self.assertGreater(len(result.time), 20)
        self.assertLess(result.time[-1], 0.02)
        self.assertIn("not completed", repr(result))

    def test_gradients_agree_with_differences_of_runs(self):
        fields = ["motor.torque", "design.base"]
        result = phalanx.run(ANCHOR, gradient=fields)
        self.assertEqual(sorted(result.gradient), sorted(fields))
        scene = phalanx.Scene.load(ANCHOR)
        for field, value, unit in [("motor.torque", 0.48, "N*m"), ("design.base", 15.5e-3, "m")]:
            gradient, change = result.gradient[field], 1e-4 * value
            self.assertEqual((gradient["value"], gradient["unit"]), (value, unit))
            ends = [phalanx.run(scene.with_({field: f"{value + side * change!r} {unit}"}), rtol=1e-11) for side in (-1, 1)]
            for column in ("q11_rad", "distal_normal_n"):
                expected = (ends[1][column][-1] - ends[0][column][-1]) / (2 * change)
                self.assertAlmostEqual(gradient["end"]["values"][column] / expected, 1, delta=1e-5, msg=(field, column))
            expected = (ends[1].criteria["tts_s"] - ends[0].criteria["tts_s"]) / (2 * change)
            self.assertAlmostEqual(gradient["tts_s"]["value"] / expected, 1, delta=1e-5, msg=field)
            kinds = [(event["contact"], event["kind"]) for event in gradient["events"]]
            self.assertEqual(kinds, [(event.contact, event.kind) for event in result.events if event.time_s > 0])
        self.assertIsNone(phalanx.run(ANCHOR).gradient)

    def test_refused_gradients_name_field_and_remedy(self):
        for arguments, message in [
            ({"gradient": ["design.bas"]}, "`design.bas` is not a number or a quantity of the scene"),
            ({"gradient": ["name"]}, "`name` is not a number"),
            ({"gradient": ["design.base"], "model": "engine"}, "in the analytic model; remove"),
        ]:
            with self.assertRaisesRegex(phalanx.SceneError, message):
                phalanx.run(ANCHOR, **arguments)


if __name__ == "__main__":
    unittest.main()

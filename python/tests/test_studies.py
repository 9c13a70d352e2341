"""Sweeps of study files, of arrays and in parts."""

import itertools
import tempfile
import unittest
from pathlib import Path

import duckdb
import numpy as np
import pandas
import phalanx
import pyarrow
import pyarrow.interchange
from common import ANCHOR, GRIPPER, SCENES, THESIS, command


class Evaluate(unittest.TestCase):
    def test_rows_equal_those_of_a_sweep(self):
        base = [12e-3, 15.5e-3, 19e-3]
        with tempfile.TemporaryDirectory() as directory:
            study, out = Path(directory) / "s.toml", Path(directory) / "s.parquet"
            study.write_text(f'scene = "{ANCHOR}"\n[[axes]]\nfield = "design.base"\nvalues = ["12 mm", "15.5 mm", "19 mm"]\n')
            command("sweep", study, "--out", out)
            expected = pandas.read_parquet(out)
        table = phalanx.evaluate(ANCHOR, {"design.base": np.array(base)}, threads=2)
        self.assertEqual(table.columns, list(expected.columns))
        actual = table.to_pandas()
        for name in table.columns:
            if expected[name].dtype.kind in "fi":
                np.testing.assert_array_equal(actual[name].to_numpy(), expected[name].to_numpy(), err_msg=name)
            else:
                equal = [a == b or (a is None and pandas.isna(b)) for a, b in zip(actual[name], expected[name], strict=True)]
                self.assertTrue(all(equal), name)

    def test_accepts_numbers_texts_and_single_values(self):
        scene = phalanx.Scene.load(ANCHOR)
        table = phalanx.evaluate(
            scene,
            {
                "design.base": ["14 mm", 0.014, np.float64(0.014)],
                "contact.friction.mu_static": 0.6,
                "spring.type": "constant",
                "palm": [True, True, False],
            },
        )
        self.assertEqual(list(table["status"]), ["completed"] * 3)
        self.assertEqual(table["tts_s"][0], table["tts_s"][1])
        np.testing.assert_array_equal(table["design.base_m"], [0.014] * 3)
        run = phalanx.run(scene.with_({"design.base": "14 mm", "contact.friction.mu_static": 0.6}))
        self.assertEqual(table["tts_s"][0], run.criteria["tts_s"])
        series = phalanx.evaluate(scene, {"design.base": pandas.Series([0.014, 0.015])}, columns=["tts_s", "run"])
        self.assertEqual((series.columns, len(series)), (["run", "tts_s"], 2))
        self.assertEqual(len(phalanx.evaluate(scene, {"design.base": []})), 0)

    def test_a_preset_replaces_the_settings_of_the_integrator(self):
        fields = {"contact.friction.mu_static": [0.4, 0.8], "integrator.rtol": 1e-8}
        fine, draft = (phalanx.evaluate(ANCHOR, fields, preset=preset)["steps"] for preset in (None, "draft"))
        expected = [phalanx.run(phalanx.Scene.load(ANCHOR).with_({"contact.friction.mu_static": mu}), preset="draft") for mu in (0.4, 0.8)]
        self.assertEqual(list(draft), [result.outcome["steps"] for result in expected])
        self.assertTrue(all(2 * few < many for few, many in zip(draft, fine, strict=True)))
        with self.assertRaisesRegex(phalanx.SceneError, "`preset` is a setting of the analytic model"):
            phalanx.evaluate(ANCHOR, fields, model="engine", preset="draft")

    def test_varies_parameters(self):
        text = ANCHOR.read_text().replace('base = "15.5 mm"', 'base = "= reach - margin"')
        scene = phalanx.Scene.from_toml('parameters = { reach = "16.5 mm", margin = "1 mm", ratio = 2 }\n' + text)
        table = phalanx.evaluate(scene, {"parameters.reach": [16e-3, "17 mm", "= 16 * margin"], "parameters.ratio": 3})
        self.assertEqual(list(table["status"]), ["completed"] * 3)
        self.assertEqual(table.columns[2:4], ["parameters.reach_m", "parameters.ratio"])
        # The value of an expression is not that of the study, which knows numbers only.
        self.assertEqual(list(table.to_pandas()["parameters.reach_m"].isna()), [False, False, True])
        for row, reach in enumerate(("16 mm", "17 mm", "16 mm")):
            run = phalanx.run(scene.with_({"parameters.reach": reach}))
            self.assertEqual(table["tts_s"][row], run.criteria["tts_s"])
        with self.assertRaisesRegex(phalanx.PhalanxError, "unknown parameter `rich`(.|\n)*did you mean `reach`"):
            phalanx.evaluate(scene, {"parameters.rich": [1e-3]})

    def test_refused_and_failed_designs_are_rows(self):
        base = ["15.5 mm", float("nan"), 5.0, "3 furlongs", 0.0155, None]
        scene = phalanx.Scene.load(ANCHOR)
        table = phalanx.evaluate(scene, {"design.base": base[:5]})
        self.assertEqual(list(table["status"]), ["completed", "refused", "refused", "refused", "completed"])
        for row, message in ((1, "not a finite number"), (2, "must be below"), (3, "unknown unit")):
            self.assertIn(message, table["reason"][row])
        self.assertTrue(np.isnan(table["tts_s"][1]))
        self.assertEqual(table.summary["by_status"]["refused"], 3)
        steps = phalanx.evaluate(scene, {"integrator.max_steps": [100, 100_000, 1.5]})
        self.assertEqual(list(steps["status"]), ["failed", "completed", "refused"])
        with self.assertRaises(TypeError):
            phalanx.evaluate(scene, {"design.base": base})

    def test_filtered_designs_are_not_simulated(self):
        base = [12e-3, 20e-3]
        form_closed = phalanx.evaluate(ANCHOR, {"design.base": base})["form_closed"]
        table = phalanx.evaluate(ANCHOR, {"design.base": base}, filter={"form_closed": True})
        self.assertEqual(list(table["status"] == "completed"), list(form_closed))
        self.assertEqual(table.summary["by_status"]["filtered"], 2 - sum(form_closed))
        for scene, criterion, message in [
            (ANCHOR, "form_close", "`form_close` is not a criterion of a filter(.|\n)*palm_force_positive"),
            (GRIPPER, "form_closed", "statics of one finger"),
        ]:
            with self.assertRaisesRegex(phalanx.StudyError, message):
                phalanx.evaluate(scene, {"duration": []}, filter={criterion: True})

    def test_design_that_cannot_grasp_has_a_reason_and_no_class(self):
        scene = SCENES / "long-fingers.toml"
        table = phalanx.evaluate(scene, {"lengths.t22": [0.010, 0.016]})
        self.assertEqual(list(table["status"]), ["completed"] * 2)
        self.assertEqual(list(table["class"]), [None, "stable"])
        self.assertRegex(table["reason"][0], "the distal phalanx does not reach its contact: it is 10.0000 mm long")
        self.assertIsNone(table["reason"][1])
        self.assertRegex(table["class_reason"][1], "in position with both contacts active from 8.05 ms on, in less than 15 ms")
        self.assertEqual(table.summary["no_class"], 1)
        self.assertIn(table["reason"][0], [reason["reason"] for reason in table.summary["reasons"]])
        run = phalanx.run(phalanx.Scene.load(scene).with_({"lengths.t22": "10 mm"}))
        self.assertIsNone(run.criteria)
        self.assertIn(table["reason"][0], run.summary["no_criteria"])

    def test_rejects_unknown_fields_and_columns(self):
        for fields, message in (
            ({"design.bas": 1}, r"unknown key `bas` in \[design\]\s.*did you mean `base`"),
            ({"design": 1}, "is a table"),
            ({"design.base": [1, 2], "palm": [True]}, "arrays of equal length"),
        ):
            with self.assertRaisesRegex(phalanx.StudyError, message):
                phalanx.evaluate(ANCHOR, fields)
        with self.assertRaisesRegex(phalanx.StudyError, "is not a column"):
            phalanx.evaluate(ANCHOR, {"design.base": 0.0155}, columns=["tts"])

    def test_rows_do_not_depend_on_threads(self):
        fields = {"design.base": np.linspace(12e-3, 22e-3, 40), "contact.friction.mu_static": np.linspace(0, 1, 40)}
        [one, two] = [pyarrow.table(phalanx.evaluate(ANCHOR, fields, threads=threads)) for threads in (1, 2)]
        self.assertTrue(one.equals(two))

    def test_engine_model_is_supported(self):
        scene = phalanx.Scene.load(ANCHOR).with_({"duration": "2 ms"})
        table = phalanx.evaluate(scene, {"design.base": [0.014, 0.0155]}, model="engine")
        self.assertEqual(list(table["status"]), ["completed"] * 2)


class Sweep(unittest.TestCase):
    def test_results_equal_those_of_the_program(self):
        with tempfile.TemporaryDirectory() as directory:
            for suffix in ("parquet", "csv"):
                program, package = Path(directory) / f"program.{suffix}", Path(directory) / f"package.{suffix}"
                command("sweep", THESIS, "--out", program)
                table = phalanx.sweep(THESIS, out=package)
                self.assertEqual(package.read_bytes(), program.read_bytes())
                self.assertEqual(Path(f"{package}.study.json").read_bytes(), Path(f"{program}.study.json").read_bytes())
                # A second call reads the existing results.
                self.assertEqual(len(phalanx.sweep(THESIS, out=package)), len(table))
            written = Path(directory) / "written.parquet"
            phalanx.sweep(THESIS).write(written)
            self.assertEqual(pyarrow.parquet.read_table(written).num_rows, 384)
            self.assertTrue(pyarrow.parquet.read_table(written).equals(pyarrow.parquet.read_table(Path(directory) / "package.parquet")))

    def test_table_converts_to_other_libraries_and_text(self):
        table = phalanx.sweep(THESIS, limit=30)
        self.assertEqual(len(table), 30)
        memory = duckdb.connect()
        memory.register("runs", table)
        self.assertEqual(memory.sql("select count(*) from runs").fetchall(), [(30,)])
        self.assertEqual(table.to_polars().height, 30)
        frame = pyarrow.interchange.from_dataframe(table)
        self.assertEqual((frame.num_rows, frame.column_names), (30, table.columns))
        self.assertEqual(frame["class"].to_pylist(), pyarrow.table(table)["class"].to_pylist())
        self.assertEqual(table["run"].dtype, np.int64)
        self.assertEqual(table["force_positive"].dtype, bool)
        self.assertIn("completed", repr(table))
        for text in ["design.base_m", "0.012", "and 25 more rows", repr(table)]:
            self.assertIn(text, str(table))
        with self.assertRaisesRegex(phalanx.StudyError, "more than 1000000 designs"):
            phalanx.evaluate(ANCHOR, {"design.base": itertools.repeat(0.0155)})

    def test_study_error_has_a_position(self):
        with tempfile.TemporaryDirectory() as directory:
            study = Path(directory) / "s.toml"
            study.write_text(f'scene = "{ANCHOR}"\n[[axes]]\nfield = "design.bas"\nvalues = [1]\n')
            with self.assertRaises(phalanx.StudyError) as caught:
                phalanx.sweep(study)
            self.assertEqual(caught.exception.line, 3)
            self.assertEqual(str(caught.exception).strip(), command("sweep", study, "--list", status=2).strip())
            other_file = Path(directory) / "other_file.csv"
            other_file.write_text("years of work")
            with self.assertRaisesRegex(phalanx.StudyError, "not replaced"):
                phalanx.sweep(THESIS, out=other_file)
            self.assertEqual(other_file.read_text(), "years of work")
            with self.assertRaisesRegex(phalanx.StudyError, "no such file"):
                phalanx.sweep(Path(directory) / "no.toml")

    def test_merged_parts_equal_the_whole_sweep(self):
        with tempfile.TemporaryDirectory() as directory:
            root = Path(directory)
            info = phalanx.study_info(THESIS)
            self.assertEqual((info["runs"], info["designs"], info["model"]), (384, 192, "analytic"))
            parts = [root / f"{k}.parquet" for k in (1, 2, 3)]
            for k, part in enumerate(parts, start=1):
                info = phalanx.sweep_shard(THESIS, k, 3, part)
                self.assertEqual((info["made_now"], info["shard"], info["of"]), (128, k, 3))
            self.assertEqual(phalanx.sweep_shard(THESIS, 1, 3, parts[0])["made_now"], 0)
            with self.assertRaisesRegex(phalanx.StudyError, "part 2/3"):
                phalanx.sweep_merge(THESIS, [parts[0], parts[2]], root / "out.parquet")
            merged = phalanx.sweep_merge(THESIS, parts[::-1], root / "out.parquet")
            self.assertEqual((merged["parts"], merged["runs"]), (3, 384))
            phalanx.sweep(THESIS, out=root / "whole.parquet")
            self.assertEqual((root / "out.parquet").read_bytes(), (root / "whole.parquet").read_bytes())
            with self.assertRaisesRegex(phalanx.StudyError, "no shard 4/3"):
                phalanx.sweep_shard(THESIS, 4, 3, root / "4.parquet")


if __name__ == "__main__":
    unittest.main()

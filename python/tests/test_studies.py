"""Sweeps, arrays of designs, parts."""


import itertools
import tempfile
import unittest
from pathlib import Path

import duckdb
import numpy as np
import pandas
import phalanx
import pyarrow
from common import ANCHOR, SCENES, THESIS, command



class Evaluate(unittest.TestCase):
    def test_rows_are_those_of_a_sweep(self):
        base = [12e-3, 15.5e-3, 19e-3]
        with tempfile.TemporaryDirectory() as directory:
            study, out = Path(directory) / "s.toml", Path(directory) / "s.parquet"
            study.write_text(f'scene = "{ANCHOR}"\n[[axes]]\nfield = "design.base"\nvalues = ["12 mm", "15.5 mm", "19 mm"]\n')
            command("sweep", study, "--out", out)
            theirs = pandas.read_parquet(out)
        found = phalanx.evaluate(ANCHOR, {"design.base": np.array(base)}, threads=2)
        self.assertEqual(found.columns, list(theirs.columns))
        ours = found.to_pandas()
        for name in found.columns:
            if theirs[name].dtype.kind in "fi":
                np.testing.assert_array_equal(ours[name].to_numpy(), theirs[name].to_numpy(), err_msg=name)
            else:
                same = [a == b or (a is None and pandas.isna(b)) for a, b in zip(ours[name], theirs[name], strict=True)]
                self.assertTrue(all(same), name)

    def test_numbers_texts_and_single_values(self):
        scene = phalanx.Scene.load(ANCHOR)
        found = phalanx.evaluate(
            scene,
            {
                "design.base": ["14 mm", 0.014, np.float64(0.014)],
                "contact.friction.mu_static": 0.6,
                "spring.type": "constant",
                "palm": [True, True, False],
            },
        )
        self.assertEqual(list(found["status"]), ["completed"] * 3)
        self.assertEqual(found["tts_s"][0], found["tts_s"][1])
        np.testing.assert_array_equal(found["design.base_m"], [0.014] * 3)
        one = phalanx.run(scene.with_({"design.base": "14 mm", "contact.friction.mu_static": 0.6}))
        self.assertEqual(found["tts_s"][0], one.criteria["tts_s"])
        series = phalanx.evaluate(scene, {"design.base": pandas.Series([0.014, 0.015])}, columns=["tts_s", "run"])
        self.assertEqual((series.columns, len(series)), (["run", "tts_s"], 2))
        self.assertEqual(len(phalanx.evaluate(scene, {"design.base": []})), 0)

    def test_what_is_refused_or_fails_is_a_row(self):
        base = ["15.5 mm", float("nan"), 5.0, "3 furlongs", 0.0155, None]
        scene = phalanx.Scene.load(ANCHOR)
        found = phalanx.evaluate(scene, {"design.base": base[:5]})
        self.assertEqual(list(found["status"]), ["completed", "refused", "refused", "refused", "completed"])
        for row, words in ((1, "not a finite number"), (2, "must be below"), (3, "unknown unit")):
            self.assertIn(words, found["reason"][row])
        self.assertTrue(np.isnan(found["tts_s"][1]))
        self.assertEqual(found.summary["by_status"]["refused"], 3)
        steps = phalanx.evaluate(scene, {"integrator.max_steps": [100, 100_000, 1.5]})
        self.assertEqual(list(steps["status"]), ["failed", "completed", "refused"])
        with self.assertRaises(TypeError):
            phalanx.evaluate(scene, {"design.base": base})

    def test_a_design_that_cannot_grasp_has_a_reason_and_no_class(self):
        scene = SCENES / "long-fingers.toml"
        found = phalanx.evaluate(scene, {"lengths.t22": [0.010, 0.016]})
        self.assertEqual(list(found["status"]), ["completed"] * 2)
        self.assertEqual(list(found["class"]), [None, "stable"])
        self.assertRegex(found["reason"][0], "the distal phalanx does not reach its contact: it is 10.0000 mm long")
        self.assertIsNone(found["reason"][1])
        self.assertRegex(found["class_reason"][1], "both phalanges press in position from 8.05 ms on, in less than 15 ms")
        self.assertEqual(found.summary["no_class"], 1)
        self.assertIn(found["reason"][0], [reason["reason"] for reason in found.summary["reasons"]])
        run = phalanx.run(phalanx.Scene.load(scene).with_({"lengths.t22": "10 mm"}))
        self.assertIsNone(run.criteria)
        self.assertIn(found["reason"][0], run.summary["no_criteria"])

    def test_what_is_no_field_is_refused(self):
        for fields, words in (
            ({"design.bas": 1}, r"unknown key `bas` in \[design\]\s.*did you mean `base`"),
            ({"design": 1}, "is a table"),
            ({"design.base": [1, 2], "palm": [True]}, "arrays of one length"),
        ):
            with self.assertRaisesRegex(phalanx.StudyError, words):
                phalanx.evaluate(ANCHOR, fields)
        with self.assertRaisesRegex(phalanx.StudyError, "is no column"):
            phalanx.evaluate(ANCHOR, {"design.base": 0.0155}, columns=["tts"])

    def test_rows_do_not_depend_on_threads(self):
        fields = {"design.base": np.linspace(12e-3, 22e-3, 40), "contact.friction.mu_static": np.linspace(0, 1, 40)}
        [one, two] = [pyarrow.table(phalanx.evaluate(ANCHOR, fields, threads=threads)) for threads in (1, 2)]
        self.assertTrue(one.equals(two))

    def test_the_engine_too(self):
        scene = phalanx.Scene.load(ANCHOR).with_({"duration": "2 ms"})
        found = phalanx.evaluate(scene, {"design.base": [0.014, 0.0155]}, model="engine")
        self.assertEqual(list(found["status"]), ["completed"] * 2)


class Sweep(unittest.TestCase):
    def test_results_are_those_of_the_program(self):
        with tempfile.TemporaryDirectory() as directory:
            for form in ("parquet", "csv"):
                theirs, ours = Path(directory) / f"theirs.{form}", Path(directory) / f"ours.{form}"
                command("sweep", THESIS, "--out", theirs)
                table = phalanx.sweep(THESIS, out=ours)
                self.assertEqual(ours.read_bytes(), theirs.read_bytes())
                self.assertEqual(Path(f"{ours}.study.json").read_bytes(), Path(f"{theirs}.study.json").read_bytes())
                # It is there already.
                self.assertEqual(len(phalanx.sweep(THESIS, out=ours)), len(table))
            written = Path(directory) / "written.parquet"
            phalanx.sweep(THESIS).write(written)
            self.assertEqual(pyarrow.parquet.read_table(written).num_rows, 384)
            self.assertTrue(pyarrow.parquet.read_table(written).equals(pyarrow.parquet.read_table(Path(directory) / "ours.parquet")))

    def test_a_table_is_read_by_others(self):
        table = phalanx.sweep(THESIS, limit=30)
        self.assertEqual(len(table), 30)
        memory = duckdb.connect()
        memory.register("runs", table)
        self.assertEqual(memory.sql("select count(*) from runs").fetchall(), [(30,)])
        self.assertEqual(table.to_polars().height, 30)
        self.assertEqual(table["run"].dtype, np.int64)
        self.assertEqual(table["force_positive"].dtype, bool)
        self.assertIn("completed", repr(table))
        for part in ["design.base_m", "0.012", "and 25 more rows", repr(table)]:
            self.assertIn(part, str(table))
        with self.assertRaisesRegex(phalanx.StudyError, "more than 1000000 designs"):
            phalanx.evaluate(ANCHOR, {"design.base": itertools.repeat(0.0155)})

    def test_what_is_wrong_with_a_study_has_its_place(self):
        with tempfile.TemporaryDirectory() as directory:
            study = Path(directory) / "s.toml"
            study.write_text(f'scene = "{ANCHOR}"\n[[axes]]\nfield = "design.bas"\nvalues = [1]\n')
            with self.assertRaises(phalanx.StudyError) as caught:
                phalanx.sweep(study)
            self.assertEqual(caught.exception.line, 3)
            self.assertEqual(str(caught.exception).strip(), command("sweep", study, "--list", status=2).strip())
            taken = Path(directory) / "taken.csv"
            taken.write_text("years of work")
            with self.assertRaisesRegex(phalanx.StudyError, "left alone"):
                phalanx.sweep(THESIS, out=taken)
            self.assertEqual(taken.read_text(), "years of work")
            with self.assertRaisesRegex(phalanx.StudyError, "no such file"):
                phalanx.sweep(Path(directory) / "no.toml")

    def test_parts_make_the_whole(self):
        with tempfile.TemporaryDirectory() as directory:
            place = Path(directory)
            info = phalanx.study_info(THESIS)
            self.assertEqual((info["runs"], info["designs"], info["model"]), (384, 192, "analytic"))
            parts = [place / f"{k}.parquet" for k in (1, 2, 3)]
            for k, part in enumerate(parts, start=1):
                made = phalanx.sweep_shard(THESIS, k, 3, part)
                self.assertEqual((made["made_now"], made["shard"], made["of"]), (128, k, 3))
            self.assertEqual(phalanx.sweep_shard(THESIS, 1, 3, parts[0])["made_now"], 0)
            with self.assertRaisesRegex(phalanx.StudyError, "--shard 2/3"):
                phalanx.sweep_merge(THESIS, [parts[0], parts[2]], place / "out.parquet")
            merged = phalanx.sweep_merge(THESIS, parts[::-1], place / "out.parquet")
            self.assertEqual((merged["parts"], merged["runs"]), (3, 384))
            phalanx.sweep(THESIS, out=place / "whole.parquet")
            self.assertEqual((place / "out.parquet").read_bytes(), (place / "whole.parquet").read_bytes())
            with self.assertRaisesRegex(phalanx.StudyError, "no shard 4/3"):
                phalanx.sweep_shard(THESIS, 4, 3, place / "4.parquet")


if __name__ == "__main__":
    unittest.main()

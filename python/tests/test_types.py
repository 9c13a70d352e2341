"""The types of results in annotations are those of the results, and the examples pass strict type checks."""

import tempfile
import types
import typing
import unittest
from pathlib import Path

import phalanx
from common import ANCHOR, DISCS, GRIPPER, ROOT, SCENES, THESIS
from phalanx import results
from test_stubs import CONFIGURATION, run_module

HOLD = SCENES / "gripper" / "hold.toml"
PINCH = SCENES / "real" / "2f85-pinch.toml"
EXAMPLES = ROOT / "python" / "examples"


def differences(value: object, expected: object, path: str = "") -> list[str]:
    """Where a value does not have a type."""
    if expected is typing.Any:
        return []
    if typing.is_typeddict(expected):
        return differences_of_keys(value, expected, path)
    origin, arguments = typing.get_origin(expected), typing.get_args(expected)
    if origin in (typing.Union, types.UnionType):
        found = [differences(value, each, path) for each in arguments]
        return min(found, key=len)
    if origin is typing.Literal:
        return [] if value in arguments else [f"{path}: {value!r} is none of {arguments}"]
    if origin in (dict, list) and not isinstance(value, origin):
        return [f"{path}: {value!r} is no {origin.__name__}"]
    if origin is dict:
        return [text for key, item in value.items() for text in differences(item, arguments[1], f"{path}.{key}")]
    if origin is list:
        return [text for item in value for text in differences(item, arguments[0], f"{path}[]")]
    if origin is tuple:
        # JSON has lists.
        return [text for item, each in zip(value, arguments, strict=True) for text in differences(item, each, f"{path}[]")]
    allowed = {float: (float, int), None: type(None)}.get(expected, expected)
    return [] if isinstance(value, allowed) else [f"{path}: {value!r} is not {expected}"]


def differences_of_keys(value: object, expected: type, path: str) -> list[str]:
    if not isinstance(value, dict):
        return [f"{path}: {value!r} is no dictionary"]
    hints = typing.get_type_hints(expected)
    wrong = [f"{path}.{key} is not in {expected.__name__}" for key in value.keys() - hints.keys()]
    wrong += [f"{path}.{key} is missing" for key in expected.__required_keys__ - value.keys()]
    for key in value.keys() & hints.keys():
        wrong += differences(value[key], hints[key], f"{path}.{key}")
    return wrong


class Types(unittest.TestCase):
    def assert_type(self, value: object, expected: object) -> None:
        self.assertEqual(differences(value, expected), [])

    def test_differences_are_found(self):
        energies = phalanx.run(ANCHOR, duration="2 ms").energies
        self.assertEqual(differences({**energies, "balance_j": "0"}, results.Energies), [".balance_j: '0' is not <class 'float'>"])
        self.assertEqual(differences({**energies, "other": 1.0}, results.Energies), [".other is not in Energies"])
        energies.pop("spring_j")
        self.assertEqual(differences(energies, results.Energies), [".spring_j is missing"])

    def test_runs(self):
        scenes = ["hard/gripper-no-friction", "gripper/cycle", "gripper/cycle-dropped", "gripper/table", "real/t42-grasp"]
        scenes += ["mechanisms/slider-crank", "mechanisms/f85-finger", "laws/spring", "real/2f85-lift"]
        for path in (ANCHOR, GRIPPER, DISCS, PINCH, *(SCENES / f"{name}.toml" for name in scenes)):
            with self.subTest(scene=path.name):
                result = phalanx.run(path, check=True if path in (ANCHOR, DISCS) else None)
                self.assert_type(result.summary, results.RunSummary)
                self.assert_type(result.criteria, results.Criteria | None)
                self.assertTrue(result.criteria is None or result.criteria.keys())
        engine = phalanx.run(GRIPPER, model="engine", duration="5 ms")
        self.assert_type(engine.summary, results.RunSummary)

    def test_gradients(self):
        result = phalanx.run(ANCHOR, gradient=["design.base"])
        self.assert_type(result.gradient, dict[str, results.Gradient])

    def test_documents(self):
        quick = {"scan": 2, "tol": 0.9, "to": 100.0}
        for value, expected in (
            (phalanx.statics(ANCHOR), results.FingerStatics),
            (phalanx.statics(SCENES / "gripper" / "design-95.toml"), results.GripperStatics),
            (phalanx.statics(PINCH), results.MechanismStatics),
            (phalanx.size(ANCHOR), results.SizingResult),
            (phalanx.hold(HOLD, directions=1, **quick), results.HoldResult),
            (phalanx.hold(HOLD, vibration=[50.0], along=["x"], **quick), results.HoldResult),
            (phalanx.capture(GRIPPER, places=3), results.CaptureResult),
            (phalanx.capture(PINCH, places=3, to="1 mm"), results.OffsetsResult),
            (phalanx.validate(ANCHOR), results.ValidationResult),
            (phalanx.study_info(THESIS), results.StudyInfo),
            (phalanx.evaluate(ANCHOR, {"design.base": [0.0155, -1.0]}).summary, results.TableSummary),
        ):
            with self.subTest(expected=expected.__name__):
                self.assert_type(value, expected)

    def test_parts(self):
        study = SCENES / "studies" / "sample.toml"
        with tempfile.TemporaryDirectory() as directory:
            parts = [Path(directory) / f"{k}.parquet" for k in (1, 2)]
            infos = [phalanx.sweep_shard(study, k, 2, part) for k, part in enumerate(parts, 1)]
            self.assert_type(infos, list[results.PartInfo])
            self.assert_type(phalanx.sweep_merge(study, parts, Path(directory) / "all.parquet"), results.MergeInfo)

    def test_examples_pass_strict_type_checks(self):
        scripts = sorted(map(str, EXAMPLES.glob("*.py")))
        self.assertGreater(len(scripts), 8)
        result = run_module("mypy", "--strict", "--config-file", CONFIGURATION, *scripts)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)


if __name__ == "__main__":
    unittest.main()

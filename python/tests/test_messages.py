"""Exceptions name the arguments of the functions, not the flags of the command line."""

import inspect
import re
import unittest
from collections.abc import Iterator

import phalanx
from common import ANCHOR, GRIPPER, ROOT
from phalanx.errors import _FLAG, _in_python

FLAG = re.compile(_FLAG + "[a-z]")
# Messages of these modules reach only the command line, or are parts of reports.
OTHERS = {"cli", "docs", "live", "page", "report", "show", "tests"}

# The message of this run names a flag.
FOLD = """
kind = "mechanism"
duration = "200 ms"
bodies.crank = { mass = "50 g", inertia = "2e-5 kg*m^2", guess = { angle = "1 rad" } }
bodies.rod = { mass = "40 g", inertia = "5e-5 kg*m^2", guess = { at = ["16.2 mm", "25.2 mm"] } }
bodies.rocker = { mass = "50 g", inertia = "2e-5 kg*m^2", guess = { at = ["50 mm", "0 mm"], angle = "1 rad" } }
joints.a = { bodies = ["ground", "crank"], points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]], start = "1 rad", start_rate = "-20 rad/s" }
joints.b = { bodies = ["crank", "rod"], points = [["30 mm", "0 mm"], ["0 mm", "0 mm"]] }
joints.c = { bodies = ["rod", "rocker"], points = [["50 mm", "0 mm"], ["30 mm", "0 mm"]] }
joints.d = { bodies = ["ground", "rocker"], points = [["50 mm", "0 mm"], ["0 mm", "0 mm"]] }
"""


def messages() -> Iterator[str]:
    """Texts of the library with flags."""
    text = re.compile(r'"((?:[^"\\]|\\.)*)"', re.DOTALL)
    files = [*(ROOT / "src").rglob("*.rs"), *(ROOT / "crates").rglob("*.rs"), *(ROOT / "python").rglob("*.rs")]
    for file in files:
        if OTHERS.isdisjoint(file.relative_to(ROOT).parts):
            source = file.read_text(encoding="utf-8").split("#[cfg(test)]")[0]
            for found in text.finditer(source):
                message = re.sub(r"\\\n\s*", "", found[1]).replace('\\"', '"')
                if FLAG.search(message) and "`mcap " not in message and "`scene show" not in message:
                    yield message


def arguments() -> set[str]:
    """Names of the arguments of all functions."""
    functions = [getattr(phalanx, name) for name in phalanx.__all__]
    names = {"with_"}
    for function in filter(inspect.isbuiltin, functions):
        names.update(inspect.signature(function).parameters)
    return names


class Messages(unittest.TestCase):
    def test_every_flag_becomes_an_argument(self):
        known, count = arguments(), 0
        for message in messages():
            with self.subTest(message=message):
                translated = _in_python(message)
                self.assertNotRegex(translated, FLAG)
                self.assertEqual(_in_python(translated), translated)
                flags = {flag.replace("-", "_") for flag in re.findall(_FLAG + "([a-z][a-z-]*)", message)}
                # `force` is an argument of the search only: a file is deleted instead.
                names = {"from_" if flag == "from" else flag for flag in flags} - {"force", "set", "shard"}
                self.assertLessEqual(names, known)
                count += 1
        self.assertGreater(count, 40)

    def test_values_follow_their_argument(self):
        for message, expected in (
            ("or simulate with `--model engine`", 'or simulate with `model="engine"`'),
            ('use --numeric-rate "5e8 Hz" or a shorter --duration', 'use numeric_rate="5e8 Hz" or a shorter `duration`'),
            ("such as --along x,y,angle", 'such as along=["x", "y", "angle"]'),
            ("give another --out, or replace it with --force", "give another `out`, or delete it first"),
            ("replace it with --force (force=True)", "replace it with force=True"),
            ('--set a.b="1 mm" --set c.d=false', 'with_({"a.b": "1 mm", "c.d": "false"})'),
            ("a file /tmp/--out/my--force.csv", "a file /tmp/--out/my--force.csv"),
        ):
            self.assertEqual(_in_python(message), expected)

    def test_exceptions_have_no_flags(self):
        anchor = phalanx.Scene.load(ANCHOR)
        for call in (
            lambda: phalanx.run(anchor, numeric_rate="1e12 Hz"),
            lambda: phalanx.run(anchor, step="1 us", tolerance="1 um", model="engine"),
            lambda: phalanx.run(anchor, step="1 us"),
            lambda: phalanx.run(anchor, preset="reference", model="engine"),
            lambda: phalanx.hold(GRIPPER, from_=5.0, to=1.0),
            lambda: phalanx.hold(GRIPPER, scan=1),
            lambda: phalanx.hold(GRIPPER, tol=2.0),
            lambda: phalanx.statics(GRIPPER, posture="geometric", at="1 ms"),
            lambda: phalanx.statics(GRIPPER, at="3000 s"),
        ):
            with self.assertRaises(phalanx.PhalanxError) as raised:
                call()
            self.assertNotRegex(str(raised.exception), FLAG)

    def test_results_have_no_flags(self):
        scene = phalanx.Scene.from_toml(FOLD)
        batch = phalanx.SimulationBatch([scene])
        batch.advance(1.0)
        with self.assertRaises(phalanx.RunError) as raised:
            phalanx.run(scene)
        table = phalanx.evaluate(scene, {"duration": [0.2]})
        for text in (batch.failures[0], str(raised.exception), str(raised.exception.result.summary["error"]), table["reason"][0]):
            self.assertIn('model="engine"', text)
            self.assertNotRegex(text, FLAG)


if __name__ == "__main__":
    unittest.main()

"""The stubs are those of the module: names, parameters, defaults; and everything says what it is."""

import inspect
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import phalanx
import phalanx.ray
from phalanx import _phalanx

CONFIGURATION = str(Path(__file__).resolve().parents[1] / "pyproject.toml")


def call(*arguments: str) -> subprocess.CompletedProcess:
    # Not where a directory is called phalanx too.
    with tempfile.TemporaryDirectory() as directory:
        return subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True, check=False, cwd=directory)


class Stubs(unittest.TestCase):
    def test_they_are_those_of_the_module(self):
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as allowed:
            # An entry that nothing needs is an error, and has to be the only one: so it is really looked.
            allowed.write("phalanx.run\n")
            allowed.flush()
            result = call("mypy.stubtest", "phalanx", "--allowlist", allowed.name, "--mypy-config-file", CONFIGURATION)
        said = result.stdout + result.stderr
        self.assertEqual(result.returncode, 1, said)
        self.assertIn("unused allowlist entry phalanx.run", said)
        self.assertIn("Found 1 error ", said)

    def test_the_package_is_typed(self):
        result = call("mypy", "--strict", "--config-file", CONFIGURATION, "-p", "phalanx")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def test_everything_says_what_it_is(self):
        for name in phalanx.__all__:
            if name != "__version__":
                self.assertTrue(inspect.getdoc(getattr(phalanx, name)), name)
        for owner in (_phalanx.Scene, _phalanx.Result, _phalanx.Table):
            for name, member in vars(owner).items():
                if not name.startswith("_"):
                    self.assertTrue(inspect.getdoc(member), f"{owner.__name__}.{name}")
        self.assertTrue(inspect.getdoc(phalanx.ray.sweep))
        self.assertRegex(phalanx.__version__, r"^\d+\.\d+\.\d+$")


if __name__ == "__main__":
    unittest.main()

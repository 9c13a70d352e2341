"""The stubs match the module (names, parameters, defaults), and all public items have docstrings."""

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


def run_module(*arguments: str) -> subprocess.CompletedProcess:
    # In an empty directory, so that no local directory shadows the package phalanx.
    with tempfile.TemporaryDirectory() as directory:
        return subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True, check=False, cwd=directory)


class Stubs(unittest.TestCase):
    def test_stubs_match_the_module(self):
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as allowlist:
            # The unused entry must be the only error, which proves that stubtest has compared the package.
            allowlist.write("phalanx.run\n")
            # The module is a command line; importing it gives the function of the same name.
            allowlist.write("phalanx.optimize\n")
            # stubtest expects a Union for an alias of several literals.
            allowlist.write("phalanx.results.Fate\n")
            allowlist.flush()
            result = run_module("mypy.stubtest", "phalanx", "--allowlist", allowlist.name, "--mypy-config-file", CONFIGURATION)
        output = result.stdout + result.stderr
        self.assertEqual(result.returncode, 1, output)
        self.assertIn("unused allowlist entry phalanx.run", output)
        self.assertIn("Found 1 error ", output)

    def test_package_passes_strict_type_checks(self):
        result = run_module("mypy", "--strict", "--config-file", CONFIGURATION, "-p", "phalanx")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def test_all_public_items_have_docstrings(self):
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

"""Every example runs with `--quick` and writes its output file."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
SHARED = {"grid.py"}


class Examples(unittest.TestCase):
    def test_every_example_runs_and_writes_its_figure_or_table(self):
        scripts = sorted(path for path in EXAMPLES.glob("*.py") if path.name not in SHARED)
        self.assertEqual(len(scripts), 9)
        for script in scripts:
            with self.subTest(script=script.name), tempfile.TemporaryDirectory() as directory:
                table = script.stem in ("sobol_salib", "duckdb_parts")
                out = Path(directory) / ("out.csv" if table else "out.png")
                result = subprocess.run(
                    [sys.executable, "-W", "error::DeprecationWarning:__main__", script, "--quick", "--out", out],
                    capture_output=True,
                    text=True,
                    check=False,
                    cwd=directory,
                    env={**os.environ, "MPLCONFIGDIR": directory},
                )
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertIn(str(out), result.stdout)
                written = out.read_bytes()
                self.assertGreater(len(written), 100 if table else 10_000)
                if not table:
                    self.assertTrue(written.startswith(b"\x89PNG"))


if __name__ == "__main__":
    unittest.main()

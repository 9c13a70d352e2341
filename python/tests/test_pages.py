"""All Python blocks of the documents run in order, and the first plot takes five lines."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from common import ROOT, SCENES

BOOK = ROOT / "book" / "pages"
PAGES = [ROOT / "README.md", ROOT / "python" / "README.md", ROOT / "src" / "docs" / "python.md", BOOK / "python.md", BOOK / "from-mujoco.md"]
BLOCK = re.compile(r"^```py\n(.*?)^```$", re.DOTALL | re.MULTILINE)


class Pages(unittest.TestCase):
    def test_all_code_blocks_run(self):
        for page in PAGES:
            blocks = BLOCK.findall(page.read_text())
            self.assertTrue(blocks, page)
            with self.subTest(page=page.name), tempfile.TemporaryDirectory() as directory:
                shutil.copytree(SCENES, Path(directory) / "scenes")
                script = Path(directory) / "page.py"
                script.write_text("import matplotlib\nmatplotlib.use('Agg')\n" + "\n".join(blocks))
                result = subprocess.run([sys.executable, script], cwd=directory, capture_output=True, text=True, check=False)
                self.assertEqual(result.returncode, 0, result.stderr)
                if "savefig" in blocks[0]:
                    self.assertTrue((Path(directory) / "q11.png").read_bytes().startswith(b"\x89PNG"))

    def test_the_map_of_a_linkage_prints_what_the_page_shows(self):
        page = (ROOT / "book" / "pages" / "your-linkage.md").read_text()
        (block,) = BLOCK.findall(page)
        with tempfile.TemporaryDirectory() as directory:
            shutil.copy(SCENES / "mechanisms" / "two-pivot.toml", Path(directory) / "my-gripper.toml")
            result = subprocess.run([sys.executable, "-c", block], cwd=directory, capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stdout, r"^24 mm, 0\.2: [a-z ]+, ")
        self.assertEqual(len(result.stdout.splitlines()), 6)

    def test_search_of_the_tutorial_prints_what_the_page_shows(self):
        page = (ROOT / "book" / "pages" / "choosing.md").read_text()
        command, shown = re.search(r"```sh\nphalanx optimize (.*)\n```\n\n```text\n((?:.*\n)*?)```", page).groups()
        with tempfile.TemporaryDirectory() as directory:
            for name, text in re.findall(r"^```toml file=(\S+)\n(.*?)^```$", page, re.DOTALL | re.MULTILINE):
                (Path(directory) / name).write_text(text)
            call = [sys.executable, "-m", "phalanx.optimize", *command.split()]
            result = subprocess.run(call, cwd=directory, capture_output=True, text=True, check=False)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn(shown, result.stdout)
            self.assertEqual(len(list((Path(directory) / "best").iterdir())), 2)

    def test_a_model_of_mujoco_becomes_a_scene_as_the_page_shows(self):
        page = (BOOK / "your-mujoco-model.md").read_text()
        shown = re.findall(r"^```sh\n([^`]*)\n```\n\n```text\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
        self.assertEqual(len(shown), 3)
        with tempfile.TemporaryDirectory() as directory:
            for name, text in re.findall(r"^```xml file=(\S+)\n(.*?)^```$", page, re.DOTALL | re.MULTILINE):
                (Path(directory) / name).write_text(text)
            for line, output in shown:
                program, *arguments = line.split()
                call = [sys.executable if program == "python" else os.environ["PHALANX"], *arguments]
                result = subprocess.run(call, cwd=directory, capture_output=True, text=True, check=False)
                self.assertEqual(result.returncode, 0, result.stderr)
                for part in output.splitlines():
                    self.assertIn(part.removesuffix("..."), result.stdout)
            script = "\n".join(BLOCK.findall(page))
            result = subprocess.run([sys.executable, "-c", script], cwd=directory, capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        # The figures of MuJoCo depend on the processor in their last digits.
        table = re.search(r"```text\n(my-hand.xml, .*?)```", page, re.DOTALL).group(1)
        words = [re.sub(r"[\d.e+-]+", "#", " ".join(text.split())) for text in (table, result.stdout)]
        self.assertTrue(words[1].startswith(words[0].strip()))

    def test_first_plot_takes_five_lines(self):
        first = BLOCK.findall((BOOK / "python.md").read_text())[0]
        self.assertEqual(len(first.strip().splitlines()), 5)

    def test_the_page_of_the_package_is_short(self):
        self.assertLessEqual(len((ROOT / "python" / "README.md").read_text().splitlines()), 40)


if __name__ == "__main__":
    unittest.main()

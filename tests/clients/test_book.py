"""The tutorial: its site can be built, its links are valid, its commands print what it shows."""

import base64
import contextlib
import importlib.util
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parents[2]
PAGES = ROOT / "book" / "pages"
BLOCK = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
# tools/clients.sh sets the module unless it cannot be built.
EXPLORER = "PHALANX_EXPLORER" in os.environ
NUMBER = re.compile(r"[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def build(*arguments: str) -> subprocess.CompletedProcess:
    command = [sys.executable, ROOT / "tools" / "book.py", *arguments]
    return subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)


def book():
    """Imports tools/book.py as a module."""
    spec = importlib.util.spec_from_file_location("book", ROOT / "tools" / "book.py")
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


def lines_match(shown: str, printed: str) -> bool:
    """Whether a printed line matches the shown one: equal words, numbers within 0.1%; `...` matches any text."""
    if "..." in shown:
        pattern = ".*".join(re.escape(piece) for piece in shown.rstrip().split("..."))
        return re.fullmatch(pattern, printed.rstrip()) is not None
    if NUMBER.sub("#", shown).split() != NUMBER.sub("#", printed).split():
        return False
    pairs = zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=True)
    number = lambda text: float(text.replace("−", "-"))  # noqa: E731
    return all(abs(number(a) - number(b)) <= 1e-3 * abs(number(a)) for a, b in pairs)


def first_missing_line(shown: list[str], printed: list[str]) -> str | None:
    """Returns the first shown line that is not printed, in order; a line `...` matches any lines."""
    at, gap = 0, False
    for line in shown:
        if line.strip() == "...":
            gap = True
            continue
        while at < len(printed) and not lines_match(line, printed[at]):
            if not gap:
                return line
            at += 1
        if at == len(printed):
            return line
        at, gap = at + 1, False
    return None if gap or at == len(printed) else f"(end of the shown output, but another line was printed: {printed[at]})"


class Commands(unittest.TestCase):
    """Executes the commands of every page in a fresh directory with the shipped scenes."""

    def execute_page(self, page: Path, directory: Path) -> int:
        binaries = directory / "bin"
        binaries.mkdir()
        (binaries / "phalanx").symlink_to(os.environ["PHALANX"])
        environment = {**os.environ, "PATH": f"{binaries}:{os.environ['PATH']}", "COLUMNS": "200"}
        shutil.copytree(ROOT / "scenes", directory / "scenes")
        done = 0
        for language, info, body in BLOCK.findall(page.read_text()):
            if named := re.search(r"file=(\S+)", info):
                (directory / named[1]).write_text(body)
            elif language == "python":
                result = subprocess.run([sys.executable, "-c", body], cwd=directory, capture_output=True, text=True, check=False)
                self.assertEqual(result.returncode, 0, f"{page.name}: {result.stderr}")
                self.assertNotEqual(result.stdout, "")
                done += 1
            elif language == "console":
                expected_status = int((re.search(r"status=(\d)", info) or [0, "0"])[1])
                for call in re.split(r"^\$ ", body, flags=re.MULTILINE)[1:]:
                    command, *shown = call.splitlines()
                    result = subprocess.run(shlex.split(command), cwd=directory, env=environment, capture_output=True, text=True, check=False)
                    self.assertEqual(result.returncode, expected_status, f"{page.name}: $ {command}\n{result.stderr}")
                    printed = (result.stdout + result.stderr).splitlines()
                    absent = first_missing_line(shown, printed)
                    self.assertIsNone(absent, f"{page.name}: $ {command} should print\n{absent}\nbut printed\n" + "\n".join(printed))
                    done += 1
        return done

    def test_commands_print_what_the_pages_show(self):
        done = {}
        for page in sorted(PAGES.glob("*.md")):
            with self.subTest(page=page.name), tempfile.TemporaryDirectory() as directory:
                done[page.stem] = self.execute_page(page, Path(directory))
        self.assertGreaterEqual(sum(done.values()), 18, done)

    def test_a_missing_line_is_detected(self):
        printed = ["angle 2.0888 deg", "", "force 23.6 N"]
        self.assertIsNone(first_missing_line(["angle 2.0889 deg", "...", "force 23.6 N"], printed))
        self.assertEqual(first_missing_line(["angle 2.1889 deg", "..."], printed), "angle 2.1889 deg")
        self.assertEqual(first_missing_line(["...", "torque 23.6 N"], printed), "torque 23.6 N")
        self.assertIsNotNone(first_missing_line(["angle 2.0888 deg"], printed))


class Site(unittest.TestCase):
    def test_site_is_built_without_dead_links(self):
        with tempfile.TemporaryDirectory() as out:
            result = build(out)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            site = Path(out)
            self.assertIn("<iframe", (site / "the-page.html").read_text())
            self.assertIn("experiment-95", (site / "live" / "closing.html").read_text())
            self.assertTrue((site / "reference" / "accuracy.html").exists())
            if EXPLORER:
                self.assertIn('<iframe class="explorer" src="explorer.html"', (site / "index.html").read_text())
                self.assertIn('id="explorer"', (site / "explorer.html").read_text())
            for page in (page for page in site.rglob("*.html") if page.parent.name != "live" and page.name != "explorer.html"):
                text = page.read_text()
                self.assertNotIn("<!-- explorer", text, page.name)
                self.assertNotIn("```", text, page.name)

    def test_site_without_webassembly_compiler_omits_the_explorer(self):
        program = book()
        with tempfile.TemporaryDirectory() as out, mock.patch.object(program, "find_module", return_value=None), io.StringIO() as errors:
            with contextlib.redirect_stderr(errors), contextlib.redirect_stdout(io.StringIO()):
                program.main(out)
            self.assertIn("without the explorer", errors.getvalue())
            site = Path(out)
            self.assertFalse((site / "explorer.html").exists())
            self.assertFalse([page.name for page in site.glob("**/*.html") if "explorer.html#" in page.read_text() or 'class="explore' in page.read_text()])

    def test_only_a_missing_compiler_is_tolerated(self):
        program = book()
        with mock.patch.dict(os.environ, {"PHALANX": "/nowhere/phalanx"}), mock.patch.object(program.subprocess, "run") as run:
            os.environ.pop("PHALANX_EXPLORER", None)
            run.return_value.returncode = 1
            self.assertIsNone(program.find_module())
            run.return_value.returncode = 0
            self.assertEqual(program.find_module().name, program.MODULE)
            # The compiler exists but fails.
            run.return_value.returncode = 101
            self.assertRaises(SystemExit, program.find_module)

    def test_comments_about_the_explorer_become_links(self):
        program = book()
        comment = '<!-- explorer scene=gripper/design-95.toml set="design.base=14 mm" set=gravity=0 t=0.0069 says="a=1 ms" says=b=2 -->'
        link = program.link_explorer(comment, "../", True)
        self.assertIn('href="../explorer.html#scene=gripper%2Fdesign-95.toml&amp;set=design.base%3D14+mm&amp;set=gravity%3D0&amp;t=0.0069"', link)
        self.assertIn('data-says="a=1 ms; b=2"', link)
        self.assertEqual(program.link_explorer(f"a{comment}b", "", False), "ab")
        own = program.link_explorer('```toml file=own.toml\n[design]\n```\n<!-- explorer scene=own.toml called="mine & yours" -->', "", True)
        text = re.search(r"#scene=own.toml&amp;text=([\w-]+)", own)[1]
        self.assertEqual(zlib.decompress(base64.urlsafe_b64decode(text + "=" * (-len(text) % 4)), -15), b"[design]\n")
        self.assertIn(">Open in the explorer: mine &amp; yours</a>", own)
        for wrong in ("scene=a.toml at=3", "scene=a.toml there"):
            self.assertRaises(SystemExit, program.link_explorer, f"<!-- explorer {wrong} -->", "", True)

    def test_dead_links_are_errors(self):
        scene = ["<!-- explorer scene=no-such.toml -->"] if EXPLORER else []
        for broken in ("[x](no-page.md)", "[x](index.md#no-such-place)", '<img src="figures/no.svg">', *scene):
            with self.subTest(link=broken), tempfile.TemporaryDirectory() as scratch:
                pages = Path(scratch) / "pages"
                shutil.copytree(PAGES, pages)
                (pages / "sizing.md").write_text((pages / "sizing.md").read_text() + f"\n\n{broken}\n")
                result = build(Path(scratch) / "site", pages)
                self.assertNotEqual(result.returncode, 0, broken)

    def test_a_foreign_directory_is_not_overwritten(self):
        with tempfile.TemporaryDirectory() as out:
            kept = Path(out) / "thesis.txt"
            kept.write_text("years of work")
            result = build(out)
            self.assertNotEqual(result.returncode, 0)
            self.assertEqual(kept.read_text(), "years of work")


class Repository(unittest.TestCase):
    def test_relative_links_of_all_documents_are_valid(self):
        documents = [ROOT / "README.md", ROOT / "tools" / "viewers" / "README.md", *PAGES.glob("*.md"), *(ROOT / "src" / "docs").glob("*.md")]
        link_count = 0
        for document in documents:
            text = re.sub(r"```.*?```", "", document.read_text(), flags=re.DOTALL)
            for link in re.findall(r"\]\(([^)\s]+)\)", text):
                if re.match(r"https?:|#|crate::|super::", link):
                    continue
                link_count += 1
                path = document.parent / link.split("#")[0]
                self.assertTrue(path.exists(), f"{document.relative_to(ROOT)}: {link}")
        self.assertGreater(link_count, 80)


if __name__ == "__main__":
    unittest.main()

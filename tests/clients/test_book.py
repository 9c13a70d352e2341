"""The tutorial: its site is built, its links lead somewhere, its commands do what it shows."""

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
# tools/clients.sh names the module wherever it can be built, and says where it cannot.
EXPLORER = "PHALANX_EXPLORER" in os.environ
NUMBER = re.compile(r"[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def build(*arguments: str) -> subprocess.CompletedProcess:
    command = [sys.executable, ROOT / "tools" / "book.py", *arguments]
    return subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)


def book():
    """tools/book.py as a module."""
    spec = importlib.util.spec_from_file_location("book", ROOT / "tools" / "book.py")
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


def same(shown: str, printed: str) -> bool:
    """Whether a line is the one shown: its words, and its numbers to a thousandth; `...` stands for anything."""
    if "..." in shown:
        pattern = ".*".join(re.escape(piece) for piece in shown.rstrip().split("..."))
        return re.fullmatch(pattern, printed.rstrip()) is not None
    if NUMBER.sub("#", shown).split() != NUMBER.sub("#", printed).split():
        return False
    pairs = zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=True)
    number = lambda text: float(text.replace("−", "-"))  # noqa: E731
    return all(abs(number(a) - number(b)) <= 1e-3 * abs(number(a)) for a, b in pairs)


def missing(shown: list[str], printed: list[str]) -> str | None:
    """The first line shown that is not printed, in order; between lines around a `...` anything may be."""
    at, gap = 0, False
    for line in shown:
        if line.strip() == "...":
            gap = True
            continue
        while at < len(printed) and not same(line, printed[at]):
            if not gap:
                return line
            at += 1
        if at == len(printed):
            return line
        at, gap = at + 1, False
    return None if gap or at == len(printed) else f"(then it ends, but printed is also: {printed[at]})"


class Commands(unittest.TestCase):
    """Every page by itself, in a directory with the shipped scenes, as a reader would go through it."""

    def follow(self, page: Path, directory: Path) -> int:
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
                wanted = int((re.search(r"status=(\d)", info) or [0, "0"])[1])
                for call in re.split(r"^\$ ", body, flags=re.MULTILINE)[1:]:
                    command, *shown = call.splitlines()
                    result = subprocess.run(shlex.split(command), cwd=directory, env=environment, capture_output=True, text=True, check=False)
                    self.assertEqual(result.returncode, wanted, f"{page.name}: $ {command}\n{result.stderr}")
                    printed = (result.stdout + result.stderr).splitlines()
                    absent = missing(shown, printed)
                    self.assertIsNone(absent, f"{page.name}: $ {command} should print\n{absent}\nbut printed\n" + "\n".join(printed))
                    done += 1
        return done

    def test_every_page_shows_what_its_commands_print(self):
        done = {}
        for page in sorted(PAGES.glob("*.md")):
            with self.subTest(page=page.name), tempfile.TemporaryDirectory() as directory:
                done[page.stem] = self.follow(page, Path(directory))
        self.assertGreaterEqual(sum(done.values()), 18, done)

    def test_a_line_that_is_not_printed_is_noticed(self):
        printed = ["angle 2.0888 deg", "", "force 23.6 N"]
        self.assertIsNone(missing(["angle 2.0889 deg", "...", "force 23.6 N"], printed))
        self.assertEqual(missing(["angle 2.1889 deg", "..."], printed), "angle 2.1889 deg")
        self.assertEqual(missing(["...", "torque 23.6 N"], printed), "torque 23.6 N")
        self.assertIsNotNone(missing(["angle 2.0888 deg"], printed))


class Site(unittest.TestCase):
    def test_it_is_built_and_no_link_is_dead(self):
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

    def test_without_a_compiler_for_the_browser_it_is_built_without_the_explorer(self):
        program = book()
        with tempfile.TemporaryDirectory() as out, mock.patch.object(program, "module", return_value=None), io.StringIO() as said:
            with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
                program.main(out)
            self.assertIn("without the explorer", said.getvalue())
            site = Path(out)
            self.assertFalse((site / "explorer.html").exists())
            self.assertFalse([page.name for page in site.glob("**/*.html") if "explorer.html#" in page.read_text() or 'class="explore' in page.read_text()])

    def test_only_a_missing_compiler_is_done_without(self):
        program = book()
        with mock.patch.dict(os.environ, {"PHALANX": "/nowhere/phalanx"}), mock.patch.object(program.subprocess, "run") as run:
            os.environ.pop("PHALANX_EXPLORER", None)
            run.return_value.returncode = 1
            self.assertIsNone(program.module())
            run.return_value.returncode = 0
            self.assertEqual(program.module().name, program.MODULE)
            # A compiler that fails.
            run.return_value.returncode = 101
            self.assertRaises(SystemExit, program.module)

    def test_comments_about_the_explorer_become_links(self):
        program = book()
        comment = '<!-- explorer scene=gripper/design-95.toml set="design.base=14 mm" set=gravity=0 t=0.0069 says="a=1 ms" says=b=2 -->'
        link = program.explored(comment, "../", True)
        self.assertIn('href="../explorer.html#scene=gripper%2Fdesign-95.toml&amp;set=design.base%3D14+mm&amp;set=gravity%3D0&amp;t=0.0069"', link)
        self.assertIn('data-says="a=1 ms; b=2"', link)
        self.assertEqual(program.explored(f"a{comment}b", "", False), "ab")
        own = program.explored('```toml file=own.toml\n[design]\n```\n<!-- explorer scene=own.toml called="mine & yours" -->', "", True)
        text = re.search(r"#scene=own.toml&amp;text=([\w-]+)", own)[1]
        self.assertEqual(zlib.decompress(base64.urlsafe_b64decode(text + "=" * (-len(text) % 4)), -15), b"[design]\n")
        self.assertIn(">Open in the explorer: mine &amp; yours</a>", own)
        for wrong in ("scene=a.toml at=3", "scene=a.toml there"):
            self.assertRaises(SystemExit, program.explored, f"<!-- explorer {wrong} -->", "", True)

    def test_dead_links_end_it(self):
        scene = ["<!-- explorer scene=no-such.toml -->"] if EXPLORER else []
        for broken in ("[x](no-page.md)", "[x](index.md#no-such-place)", '<img src="figures/no.svg">', *scene):
            with self.subTest(link=broken), tempfile.TemporaryDirectory() as scratch:
                pages = Path(scratch) / "pages"
                shutil.copytree(PAGES, pages)
                (pages / "sizing.md").write_text((pages / "sizing.md").read_text() + f"\n\n{broken}\n")
                result = build(Path(scratch) / "site", pages)
                self.assertNotEqual(result.returncode, 0, broken)

    def test_a_directory_of_something_else_is_left_alone(self):
        with tempfile.TemporaryDirectory() as out:
            kept = Path(out) / "thesis.txt"
            kept.write_text("years of work")
            result = build(out)
            self.assertNotEqual(result.returncode, 0)
            self.assertEqual(kept.read_text(), "years of work")


class Repository(unittest.TestCase):
    def test_links_of_all_documents_hold_where_they_are(self):
        documents = [ROOT / "README.md", ROOT / "tools" / "viewers" / "README.md", *PAGES.glob("*.md"), *(ROOT / "src" / "docs").glob("*.md")]
        followed = 0
        for document in documents:
            text = re.sub(r"```.*?```", "", document.read_text(), flags=re.DOTALL)
            for link in re.findall(r"\]\(([^)\s]+)\)", text):
                if re.match(r"https?:|#|crate::|super::", link):
                    continue
                followed += 1
                path = document.parent / link.split("#")[0]
                self.assertTrue(path.exists(), f"{document.relative_to(ROOT)}: {link}")
        self.assertGreater(followed, 80)


if __name__ == "__main__":
    unittest.main()

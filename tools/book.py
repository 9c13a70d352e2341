#!/usr/bin/env python3
"""Builds the tutorial into a site of static pages.

usage: book.py [OUT]      (default: target/book; needs Python 3.11, and fetches MkDocs into target/clients)

Its sources are put together first: the pages of book/pages, the documents of src/docs as its reference, the pictures, the scenes,
and a live page of a closing that the program writes. A link that leads nowhere ends it with status 1.
$PHALANX names the program to use instead of building it.
"""

import os
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "target" / "book-source"
MARK = ".phalanx-book"
LIVE = {"closing.html": "scenes/experiment-95.toml"}


def phalanx() -> list[str]:
    """The program: the given one, or built."""
    return [os.environ["PHALANX"]] if "PHALANX" in os.environ else ["cargo", "run", "--release", "--quiet", "--locked", "--"]


def mkdocs() -> list[str]:
    """MkDocs of this interpreter, or of the environment of the clients, which is set up on the way."""
    for python in (sys.executable, str(ROOT / "target" / "clients" / "venv" / "bin" / "python")):
        if Path(python).exists() and subprocess.run([python, "-c", "import mkdocs"], capture_output=True, check=False).returncode == 0:
            return [python, "-m", "mkdocs"]
    subprocess.run([ROOT / "tools" / "clients.sh", "setup"], check=True)
    return [str(ROOT / "target" / "clients" / "venv" / "bin" / "python"), "-m", "mkdocs"]


def tutorial(text: str) -> str:
    """A page of the tutorial, whose links hold in the repository, with those of the site."""
    return text.replace("](../../src/docs/", "](reference/").replace("](../../tools/figures/", "](figures/")


def reference(text: str) -> str:
    """A document of the library as a page: names of items are not links here, paths are those of the site."""
    text = re.sub(r"\[(`[^`\]]+`)\](?!\()", r"\1", text)
    text = re.sub(r"\[([^\]]+)\]\((?:crate|super)::([a-z_:]*)[^)]*\)", lambda m: documented(m[1], m[2]), text)
    return text.replace("](../../scenes/", "](../scenes/").replace("](../../tools/figures/", "](../figures/").replace("](../../tools/viewers/README.md", "](viewers.md")


def documented(words: str, item: str) -> str:
    """A link to an item: to its page if it is a document, else only its words."""
    return f"[{words}]({item}.md)" if (ROOT / "src" / "docs" / f"{item}.md").exists() else words


def gather(pages: Path) -> None:
    """All sources of the site."""
    shutil.rmtree(SOURCE, ignore_errors=True)
    shutil.copytree(pages, SOURCE)
    for path in SOURCE.glob("*.md"):
        path.write_text(tutorial(path.read_text()))
    (SOURCE / "reference").mkdir()
    for document in sorted((ROOT / "src" / "docs").glob("*.md")):
        (SOURCE / "reference" / document.name).write_text(reference(document.read_text()))
    shutil.copytree(ROOT / "tools" / "figures", SOURCE / "figures", dirs_exist_ok=True)
    shutil.copytree(ROOT / "scenes", SOURCE / "scenes")
    (SOURCE / "live").mkdir()
    for page, scene in LIVE.items():
        subprocess.run([*phalanx(), "run", scene, "--html", SOURCE / "live" / page], check=True, cwd=ROOT, stdout=subprocess.DEVNULL)


class Links(HTMLParser):
    """Where a page leads, and what can be led to in it."""

    def __init__(self) -> None:
        super().__init__()
        self.to: list[str] = []
        self.anchors: set[str] = set()

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.to += [attrs[key] for key in ("href", "src", "data") if attrs.get(key)]
        self.anchors |= {attrs[key] for key in ("id", "name") if attrs.get(key)}


def dead_links(site: Path) -> list[str]:
    """Links within the site that lead nowhere; MkDocs does not look into raw HTML."""
    pages = {}
    # A live page is a document of its own and holds all it needs.
    for path in site.rglob("*.html"):
        if path.parent.name != "live":
            pages[path.resolve()] = links = Links()
            links.feed(path.read_text())
    dead = []
    for path, links in pages.items():
        for link in links.to:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir():
                target = target / "index.html"
            known = pages.get(target)
            if not target.exists():
                dead.append(f"{path.relative_to(site.resolve())}: {link}: there is no such file")
            elif parts.fragment and known and unquote(parts.fragment) not in known.anchors:
                dead.append(f"{path.relative_to(site.resolve())}: {link}: there is no such place in it")
    return dead


def main(out: str = "", pages: str = "") -> None:
    site = Path(out or ROOT / "target" / "book").resolve()
    # MkDocs empties the directory it writes to.
    if site.exists() and any(site.iterdir()) and not (site / MARK).exists():
        sys.exit(f"{site} holds something else than a site of this script: give an empty or a new directory")
    gather(Path(pages or ROOT / "book" / "pages"))
    command = [*mkdocs(), "build", "--strict", "--quiet", "--config-file", ROOT / "book" / "mkdocs.yml", "--site-dir", site]
    built = subprocess.run(command, check=False)
    # Its page for what is not found is written for the root of a server.
    (site / "404.html").unlink(missing_ok=True)
    site.mkdir(parents=True, exist_ok=True)
    (site / MARK).write_text("written by tools/book.py\n")
    dead = dead_links(site) if built.returncode == 0 else []
    for link in dead:
        print(link, file=sys.stderr)
    if built.returncode != 0 or dead:
        sys.exit(1)
    print(f"wrote {site}: open {site / 'index.html'}")


if __name__ == "__main__":
    if len(sys.argv) > 3 or any(argument.startswith("-") for argument in sys.argv[1:]):
        sys.exit(__doc__)
    main(*sys.argv[1:])

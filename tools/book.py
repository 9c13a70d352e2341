#!/usr/bin/env python3
"""Builds the tutorial into a site of static pages.

usage: book.py [OUT]      (default: target/book; needs Python 3.11, and fetches MkDocs into target/clients)

Its sources are put together first: the pages of book/pages, the documents of src/docs as its reference, the pictures, the scenes,
a live page of a closing that the program writes, and the explorer. A link that leads nowhere ends it with status 1.
$PHALANX names the program to use instead of building it, $PHALANX_EXPLORER the explorer's module; without one tools/explorer.sh
builds it, and where that has no compiler for the browser, the site is built without the explorer, which is said.

What is shown in a page can be opened in the explorer by a comment beside it, which readers of the repository do not see:
    <!-- explorer scene=gripper/design-95.toml set="design.base=14 mm" t=0.0069 says="criteria.tts_s=6.88 ms" -->
`scene` is one that the explorer brings along, or one that stands in the page (a block ```toml file=NAME); `set` (any number of them)
are fields on top of it, `t` is the instant in seconds, `map` two fields and a criterion, `called` what the link says it opens. `says`
are figures that the page states, by their keys in `phalanx run --json`: tests/clients/book.test.mjs holds the page to the explorer by
them. The comment `<!-- explorer here -->` stands where the explorer itself is shown.
"""

import base64
import html
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import zlib
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import parse_qs, unquote, urlencode, urlsplit

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "target" / "book-source"
MARK = ".phalanx-book"
LIVE = {"closing.html": "scenes/experiment-95.toml"}
EXPLORER = "explorer.html"
MODULE = "phalanx-explorer.wasm.gz"
COMMENT = re.compile(r"<!-- explorer (.*?) -->")
# What a comment may say of the explorer, besides `here`.
WORDS = ("scene", "set", "t", "map", "called", "says")
OWN = re.compile(r"^```toml file=(\S+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


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


def module() -> Path | None:
    """The explorer's module: the given one, or the one beside the given program, or built; `None` where nothing here can build it."""
    if given := os.environ.get("PHALANX_EXPLORER"):
        return Path(given)
    if "PHALANX" in os.environ and (beside := Path(os.environ["PHALANX"]).with_name(MODULE)).exists():
        return beside
    # Its own failures have the compiler's status; 1 is that of a thing which is not there.
    status = subprocess.run([ROOT / "tools" / "explorer.sh"], check=False, stdout=subprocess.DEVNULL).returncode
    if status not in (0, 1):
        sys.exit(f"tools/explorer.sh: status {status}")
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / MODULE if status == 0 else None


def packed(text: str) -> str:
    """A scene as an address of the explorer takes it."""
    deflate = zlib.compressobj(9, zlib.DEFLATED, -15)
    return base64.urlsafe_b64encode(deflate.compress(text.encode()) + deflate.flush()).decode().rstrip("=")


def explored(text: str, up: str, there: bool) -> str:
    """A page with its comments about the explorer as links to it, `up` from there; without them where there is no explorer."""
    scenes = dict(OWN.findall(text))

    def link(found: re.Match) -> str:
        if not there:
            return ""
        if found[1].strip() == "here":
            return (
                f'<iframe class="explorer" src="{up}{EXPLORER}" title="The explorer: a closing, simulated anew while sliders move" loading="lazy"></iframe>\n\n'
                f'<a class="explore" href="{up}{EXPLORER}" target="_blank">Open the explorer by itself</a>'
            )
        pairs = [tuple(word.split("=", 1)) for word in shlex.split(found[1])]
        if any(len(pair) < 2 or pair[0] not in WORDS for pair in pairs):
            sys.exit(f"{found[0]}: say {', '.join(f'{word}=…' for word in WORDS)}")
        own = [("text", packed(scenes[value])) for word, value in pairs if word == "scene" and value in scenes]
        query = urlencode([pair for pair in pairs if pair[0] not in ("called", "says")] + own)
        says = "; ".join(value for word, value in pairs if word == "says")
        said = f' data-says="{html.escape(says)}"' if says else ""
        called = "".join(f": {html.escape(value)}" for word, value in pairs if word == "called")
        return f'<a class="explore" href="{up}{EXPLORER}#{html.escape(query)}" target="_blank"{said}>Open in the explorer{called}</a>'

    return COMMENT.sub(link, text)


def tutorial(text: str) -> str:
    """A page of the tutorial, whose links hold in the repository, with those of the site."""
    return text.replace("](../../src/docs/", "](reference/").replace("](../../tools/figures/", "](figures/")


def fenced(text: str) -> str:
    """A page whose blocks have their language alone: what the tests read behind it, MkDocs takes for no block."""
    return re.sub(r"^```(\w+) .*$", r"```\1", text, flags=re.MULTILINE)


def reference(text: str) -> str:
    """A document of the library as a page: names of items are not links here, paths are those of the site."""
    text = re.sub(r"\[(`[^`\]]+`)\](?!\()", r"\1", text)
    text = re.sub(r"\[([^\]]+)\]\((?:crate|super)::([a-z_:]*)[^)]*\)", lambda m: documented(m[1], m[2]), text)
    return text.replace("](../../scenes/", "](../scenes/").replace("](../../tools/figures/", "](../figures/").replace("](../../tools/viewers/README.md", "](viewers.md").replace("](../../book/pages/", "](../")


def documented(words: str, item: str) -> str:
    """A link to an item: to its page if it is a document, else only its words."""
    return f"[{words}]({item}.md)" if (ROOT / "src" / "docs" / f"{item}.md").exists() else words


def gather(pages: Path) -> None:
    """All sources of the site."""
    shutil.rmtree(SOURCE, ignore_errors=True)
    shutil.copytree(pages, SOURCE)
    module_file = module()
    if module_file is None:
        print("the site is built without the explorer, and without links to it: its module could not be built (see above)", file=sys.stderr)
    else:
        subprocess.run([*phalanx(), "explore", "--module", module_file, "--out", SOURCE / EXPLORER], check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
    for path in SOURCE.glob("*.md"):
        path.write_text(fenced(explored(tutorial(path.read_text()), "", module_file is not None)))
    (SOURCE / "reference").mkdir()
    for document in sorted((ROOT / "src" / "docs").glob("*.md")):
        text = explored(reference(document.read_text()), "../", module_file is not None)
        (SOURCE / "reference" / document.name).write_text(text)
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


def brought(page: Path) -> set[str]:
    """The scenes that the explorer brings along."""
    data = re.search(r'<script type="application/json" id="explorer">(.*?)</script>', page.read_text(), re.DOTALL)
    return {preset["file"] for preset in json.loads(data[1])["presets"]}


def dead_links(site: Path) -> list[str]:
    """Links within the site that lead nowhere; MkDocs does not look into raw HTML."""
    pages = {}
    # A live page is a document of its own and holds all it needs; the explorer is one, whose places are scenes.
    explorer = (site / EXPLORER).resolve()
    scenes = brought(explorer) if explorer.exists() else set()
    for path in site.rglob("*.html"):
        if path.parent.name != "live" and path.resolve() != explorer:
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
            elif target == explorer and parts.fragment:
                asked = parse_qs(parts.fragment)
                if "text" not in asked and not scenes.issuperset(asked.get("scene", [""])):
                    dead.append(f"{path.relative_to(site.resolve())}: {link}: the explorer has no such scene")
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

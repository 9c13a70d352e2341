#!/usr/bin/env python3
"""Builds the tutorial as a static site.

usage: book.py [OUT]      (default: target/book; needs Python 3.11, and installs MkDocs into target/clients)

The sources are the pages of book/pages, the documents of src/docs as reference, the figures, the scenes, an animated
page of a closing that the program writes, and the explorer. A dead link ends the script with status 1. $PHALANX names
the program, which is otherwise built; $PHALANX_EXPLORER names the explorer's module, which tools/explorer.sh otherwise
builds. Without a compiler for the browser, a message is printed and the site is built without the explorer.

A comment in a page becomes a link to the explorer; readers of the repository do not see it:
    <!-- explorer scene=gripper/design-95.toml set="design.base=14 mm" t=0.0069 says="criteria.tts_s=6.88 ms" -->
`scene` names a scene of the explorer, or of the page (a block ```toml file=NAME). Each `set` (any number) changes a
field, `t` is the instant in seconds, `map` gives two fields and a criterion, and `called` is the link text. `says`
lists results that the page states, by their keys in `phalanx run --json`; tests/clients/book.test.mjs compares them
with the explorer. The comment `<!-- explorer here -->` embeds the explorer itself.
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
# Marks a directory as output of this script.
MARKER = ".phalanx-book"
ANIMATED_PAGES = {"closing.html": "scenes/experiment-95.toml"}
EXPLORER = "explorer.html"
MODULE = "phalanx-explorer.wasm.gz"
EXPLORER_COMMENT = re.compile(r"<!-- explorer (.*?) -->")
# Keys of an explorer comment other than `here`.
COMMENT_KEYS = ("scene", "set", "t", "map", "called", "says")
SCENE_BLOCK = re.compile(r"^```toml file=(\S+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def phalanx() -> list[str]:
    """Returns the command that runs the program: $PHALANX, or `cargo run`."""
    return [os.environ["PHALANX"]] if "PHALANX" in os.environ else ["cargo", "run", "--release", "--quiet", "--locked", "--"]


def mkdocs() -> list[str]:
    """Returns the command that runs MkDocs: of this interpreter, or of the environment that tools/clients.sh sets up."""
    for python in (sys.executable, str(ROOT / "target" / "clients" / "venv" / "bin" / "python")):
        if Path(python).exists() and subprocess.run([python, "-c", "import mkdocs"], capture_output=True, check=False).returncode == 0:
            return [python, "-m", "mkdocs"]
    subprocess.run([ROOT / "tools" / "clients.sh", "setup"], check=True)
    return [str(ROOT / "target" / "clients" / "venv" / "bin" / "python"), "-m", "mkdocs"]


def find_module() -> Path | None:
    """Returns the explorer's module, or None without a compiler for it.

    It is $PHALANX_EXPLORER, the module in the directory of $PHALANX, or a new build.
    """
    if path := os.environ.get("PHALANX_EXPLORER"):
        return Path(path)
    if "PHALANX" in os.environ and (sibling := Path(os.environ["PHALANX"]).with_name(MODULE)).exists():
        return sibling
    # Status 1 means that the compiler for the browser is missing; a failed build has the status of the compiler.
    status = subprocess.run([ROOT / "tools" / "explorer.sh"], check=False, stdout=subprocess.DEVNULL).returncode
    if status not in (0, 1):
        sys.exit(f"tools/explorer.sh: status {status}")
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / MODULE if status == 0 else None


def encode_scene(text: str) -> str:
    """Encodes a scene for a URL of the explorer: raw deflate, then URL-safe base64 without padding."""
    deflate = zlib.compressobj(9, zlib.DEFLATED, -15)
    return base64.urlsafe_b64encode(deflate.compress(text.encode()) + deflate.flush()).decode().rstrip("=")


def link_explorer(text: str, root: str, has_explorer: bool) -> str:
    """Replaces the explorer comments of a page by links, or removes them if the site has no explorer.

    `root` is the relative path from the page to the root of the site.
    """
    scenes = dict(SCENE_BLOCK.findall(text))

    def link(match: re.Match) -> str:
        if not has_explorer:
            return ""
        if match[1].strip() == "here":
            return (
                f'<iframe class="explorer" src="{root}{EXPLORER}" title="The explorer: simulates a closing again whenever a slider moves" loading="lazy"></iframe>\n\n'
                f'<a class="explore" href="{root}{EXPLORER}" target="_blank">Open the explorer in a new tab</a>'
            )
        pairs = [tuple(pair.split("=", 1)) for pair in shlex.split(match[1])]
        if any(len(pair) < 2 or pair[0] not in COMMENT_KEYS for pair in pairs):
            sys.exit(f"{match[0]}: expected {', '.join(f'{key}=…' for key in COMMENT_KEYS)}, or `here`")
        scene_text = [("text", encode_scene(scenes[value])) for key, value in pairs if key == "scene" and value in scenes]
        query = urlencode([pair for pair in pairs if pair[0] not in ("called", "says")] + scene_text)
        results = "; ".join(value for key, value in pairs if key == "says")
        attribute = f' data-says="{html.escape(results)}"' if results else ""
        label = "".join(f": {html.escape(value)}" for key, value in pairs if key == "called")
        return f'<a class="explore" href="{root}{EXPLORER}#{html.escape(query)}" target="_blank"{attribute}>Open in the explorer{label}</a>'

    return EXPLORER_COMMENT.sub(link, text)


def convert_tutorial_links(text: str) -> str:
    """Replaces the repository links of a tutorial page by links of the site."""
    return text.replace("](../../src/docs/", "](reference/").replace("](../../tools/figures/", "](figures/")


def strip_block_info(text: str) -> str:
    """Removes the text after the language of code blocks. The tests need it, but MkDocs would not recognise the blocks."""
    return re.sub(r"^```(\w+) .*$", r"```\1", text, flags=re.MULTILINE)


def convert_reference(text: str) -> str:
    """Converts a document of the library into a page: removes links to items, and replaces paths by those of the site."""
    text = re.sub(r"\[(`[^`\]]+`)\](?!\()", r"\1", text)
    text = re.sub(r"\[([^\]]+)\]\((?:crate|super)::([a-z_:]*)[^)]*\)", lambda m: convert_item_link(m[1], m[2]), text)
    return text.replace("](../../scenes/", "](../scenes/").replace("](../../tools/figures/", "](../figures/").replace("](../../tools/viewers/README.md", "](viewers.md").replace("](../../book/pages/", "](../")


def convert_item_link(label: str, item: str) -> str:
    """Returns a link to the page of an item if it is a document, else only the label."""
    return f"[{label}]({item}.md)" if (ROOT / "src" / "docs" / f"{item}.md").exists() else label


def collect_sources(pages: Path) -> None:
    """Writes all sources of the site into SOURCE."""
    shutil.rmtree(SOURCE, ignore_errors=True)
    shutil.copytree(pages, SOURCE)
    module = find_module()
    if module is None:
        print("the site is built without the explorer and links to it, because its module could not be built (see above)", file=sys.stderr)
    else:
        subprocess.run([*phalanx(), "explore", "--module", module, "--out", SOURCE / EXPLORER], check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
    for path in SOURCE.glob("*.md"):
        path.write_text(strip_block_info(link_explorer(convert_tutorial_links(path.read_text()), "", module is not None)))
    (SOURCE / "reference").mkdir()
    for document in sorted((ROOT / "src" / "docs").glob("*.md")):
        text = link_explorer(convert_reference(document.read_text()), "../", module is not None)
        (SOURCE / "reference" / document.name).write_text(text)
    shutil.copytree(ROOT / "tools" / "figures", SOURCE / "figures", dirs_exist_ok=True)
    shutil.copytree(ROOT / "scenes", SOURCE / "scenes")
    (SOURCE / "live").mkdir()
    for page, scene in ANIMATED_PAGES.items():
        subprocess.run([*phalanx(), "run", scene, "--plot", SOURCE / "live" / page], check=True, cwd=ROOT, stdout=subprocess.DEVNULL)


class Links(HTMLParser):
    """The link targets and the anchors of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.targets: list[str] = []
        self.anchors: set[str] = set()

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.targets += [attrs[key] for key in ("href", "src", "data") if attrs.get(key)]
        self.anchors |= {attrs[key] for key in ("id", "name") if attrs.get(key)}


def explorer_scenes(page: Path) -> set[str]:
    """Returns the names of the scenes that the explorer contains."""
    data = re.search(r'<script type="application/json" id="explorer">(.*?)</script>', page.read_text(), re.DOTALL)
    return {preset["file"] for preset in json.loads(data[1])["presets"]}


def dead_links(site: Path) -> list[str]:
    """Returns the dead links within the site; MkDocs does not check raw HTML."""
    pages = {}
    # Animated pages and the explorer are self-contained, so their own links are not checked. Fragments of the explorer
    # name scenes.
    explorer = (site / EXPLORER).resolve()
    scenes = explorer_scenes(explorer) if explorer.exists() else set()
    for path in site.rglob("*.html"):
        if path.parent.name != "live" and path.resolve() != explorer:
            pages[path.resolve()] = links = Links()
            links.feed(path.read_text())
    dead = []
    for path, links in pages.items():
        for link in links.targets:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir():
                target = target / "index.html"
            target_page = pages.get(target)
            if not target.exists():
                dead.append(f"{path.relative_to(site.resolve())}: {link}: the file does not exist")
            elif target == explorer and parts.fragment:
                query = parse_qs(parts.fragment)
                if "text" not in query and not scenes.issuperset(query.get("scene", [""])):
                    dead.append(f"{path.relative_to(site.resolve())}: {link}: the explorer does not contain this scene")
            elif parts.fragment and target_page and unquote(parts.fragment) not in target_page.anchors:
                dead.append(f"{path.relative_to(site.resolve())}: {link}: the page has no such anchor")
    return dead


def main(out: str = "", pages: str = "") -> None:
    site = Path(out or ROOT / "target" / "book").resolve()
    # MkDocs empties its output directory.
    if site.exists() and any(site.iterdir()) and not (site / MARKER).exists():
        sys.exit(f"{site} is not empty and was not written by this script: give an empty or a new directory")
    collect_sources(Path(pages or ROOT / "book" / "pages"))
    command = [*mkdocs(), "build", "--strict", "--config-file", ROOT / "book" / "mkdocs.yml", "--site-dir", site]
    built = subprocess.run(command, check=False)
    # The 404 page of MkDocs works only at the root of a server.
    (site / "404.html").unlink(missing_ok=True)
    site.mkdir(parents=True, exist_ok=True)
    (site / MARKER).write_text("written by tools/book.py\n")
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

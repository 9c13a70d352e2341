"""Dark colour scheme for SVG figures of Matplotlib."""

from pathlib import Path


def add_dark_scheme(picture: Path, colours: dict[str, str]):
    """Adds a dark colour scheme to an SVG file; `colours` maps each light colour to its dark one."""
    text = picture.read_text()
    rules = []
    for light, dark in colours.items():
        for attribute in ("fill", "stroke"):
            if f"{attribute}: {light}" in text:
                rules.append(f'svg:root [style*="{attribute}: {light}"] {{ {attribute}: {dark} !important; }}')
    # Matplotlib omits the fill of black text and markers.
    if "#000000" in colours:
        rules.append(f'svg:root :is(text, use):not([style*="fill:"]) {{ fill: {colours["#000000"]}; }}')
    style = "<style>@media (prefers-color-scheme: dark) {\n" + "\n".join(rules) + "\n}</style>\n"
    picture.write_text(text.replace(" <defs>", f" {style} <defs>", 1))

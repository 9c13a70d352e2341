"""Pictures of Matplotlib that read on a dark ground too."""

from pathlib import Path


def both_schemes(picture: Path, colours: dict[str, str]):
    """Puts the colours for a dark ground into a picture, for readers whose scheme that is; `colours`: what stands for each there."""
    text = picture.read_text()
    rules = []
    for light, dark in colours.items():
        for name in ("fill", "stroke"):
            if f"{name}: {light}" in text:
                rules.append(f'svg:root [style*="{name}: {light}"] {{ {name}: {dark} !important; }}')
    # Matplotlib leaves black unsaid, of letters and of marks.
    if "#000000" in colours:
        rules.append(f'svg:root :is(text, use):not([style*="fill:"]) {{ fill: {colours["#000000"]}; }}')
    style = "<style>@media (prefers-color-scheme: dark) {\n" + "\n".join(rules) + "\n}</style>\n"
    picture.write_text(text.replace(" <defs>", f" {style} <defs>", 1))

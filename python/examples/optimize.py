"""The front of time to stability and largest peak force over the thesis' four variables, worst case over the friction.

    python optimize.py [--out front.png] [--population 64] [--generations 40]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import phalanx
from grid import SCENE, VARIABLES

STUDY = """
name = "closing"

[scene]
{scene}
{variables}
[[conditions]]
field = "contact.friction.mu_static"
values = [0.4, 0.8]

[[objectives]]
column = "tts_s"

[[objectives]]
columns = ["peak_f21_n", "peak_f22_n"]
name = "peak_n"

[[constraints]]
column = "class"
at_least = "semi-stable"

[filter]
force_positive = true
form_closed = true

[method]
population = {population}
generations = {generations}
"""


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("front.png"))
    parser.add_argument("--population", type=int, default=64)
    parser.add_argument("--generations", type=int, default=40)
    parser.add_argument("--quick", action="store_true", help="a few generations")
    args = parser.parse_args(arguments)
    if args.quick:
        args.population, args.generations = 16, 3

    scene = SCENE.replace('name = "design"\n', "").replace("[design]", "[scene.design]")
    units = {"design.base": "m", "design.phi22": "rad"}

    def bound(field: str, value: float) -> str:
        return f'"{value} {units[field]}"' if field in units else str(value)

    variables = "".join(
        f'[[variables]]\nfield = "{field}"\nfrom = {bound(field, float(low))}\nto = {bound(field, float(high))}\n\n'
        for field, (low, high) in VARIABLES.items()
    )
    study = Path("closing.toml")
    method = {"population": args.population, "generations": args.generations}
    study.write_text(STUDY.format(scene=scene, variables=variables, **method))
    result = phalanx.optimize(study, plot=args.out)
    print(result)
    print(f"{args.out}: hypervolume {result.hypervolume:.4f}, fastest design {result.front.to_pylist()[0]}")


if __name__ == "__main__":
    main()

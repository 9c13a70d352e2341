"""Command line of the conversion: `python -m phalanx.convert MODEL --out my-gripper.toml`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .. import __version__
from ..errors import PhalanxError
from .conversion import CUBE_KG, DURATION_S, from_mjcf
from .plane import PLANES

_DESCRIPTION = """\
Convert a MuJoCo model (MJCF) or a URDF into a scene of a mechanism, and report what it lacks.

All hinges of the mechanism must be parallel, and all slides perpendicular to them. --root takes a part of a model: the
hand of an arm, a finger whose first joint does not matter. --branch takes a part with the joint of its first body: a
finger, or several fingers, of a hand."""

_EPILOG = """\
examples:
  python -m phalanx.convert 2f85.xml --out my-gripper.toml
  python -m phalanx.convert panda.xml --root hand --plane yz --ctrl fingers=255 --out my-gripper.toml
  python -m phalanx.convert hand.xml --branch index_proximal --out index.toml
  python -m phalanx.convert robot.urdf --root gripper_base --out my-gripper.toml

exit status: 0 done; 2 bad input; the report is on the standard output."""


def _control(text: str) -> tuple[str, float]:
    name, _, value = text.rpartition("=")
    try:
        if name:
            return name, float(value)
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE, such as fingers=255")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m phalanx.convert", description=_DESCRIPTION, epilog=_EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("model", type=Path, metavar="MODEL", help="MJCF or URDF file")
    add("--out", type=Path, metavar="FILE.toml", help="write the scene to this file (default: print it)")
    add(
        "--plane",
        default="auto",
        metavar="|".join(PLANES),
        help="axes of the root's frame that are x and y of the scene (default: found from the joints)",
    )
    add("--root", metavar="BODY", help="convert only what is below this body, which becomes the ground")
    add(
        "--branch",
        action="append",
        default=[],
        metavar="BODY",
        help="convert only this body, with its own joint, and what is below it, such as a finger; can be repeated",
    )
    add("--key", metavar="NAME", help='key frame of the start (default: the first one; "" for the zero position)')
    add("--ctrl", type=_control, action="append", default=[], metavar="NAME=VALUE", help="control signal of an actuator; can be repeated")
    add("--cube", type=float, metavar="MM", help="add a cube with this edge, mm, between the ends of the fingers")
    add("--cube-mass", type=float, default=1e3 * CUBE_KG, metavar="G", help=f"its mass, g (default: {1e3 * CUBE_KG:g})")
    add("--cube-at", type=float, nargs=2, metavar=("X", "Y"), help="its place in the plane, mm")
    add("--duration", type=float, default=DURATION_S, metavar="S", help=f"duration of the scene, s (default: {DURATION_S:g})")
    add("--force", action="store_true", help="replace an existing file")
    add("-q", "--quiet", action="store_true", help="do not print the report")
    add("-V", "--version", action="version", version=f"phalanx {__version__}")
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line and returns its exit status."""
    args = _parser().parse_args(arguments)
    try:
        if args.out is not None and args.out.exists() and not args.force:
            print(f"error: {args.out} exists; choose another name, or replace it with --force", file=sys.stderr)
            return 2
        found = from_mjcf(
            args.model,
            plane=args.plane,
            root=args.root,
            branch=args.branch,
            key=args.key,
            ctrl=dict(args.ctrl),
            cube=None if args.cube is None else 1e-3 * args.cube,
            cube_mass=1e-3 * args.cube_mass,
            cube_at=None if args.cube_at is None else (1e-3 * args.cube_at[0], 1e-3 * args.cube_at[1]),
            duration=args.duration,
        )
        if args.out is None:
            print(found.toml, end="")
        else:
            args.out.write_text(found.toml, encoding="utf-8")
        _ = found.scene
    except PhalanxError as error:
        print("error: " + error._command_message.removeprefix("error: "), file=sys.stderr)
        return 2
    except (ImportError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if args.out is not None and not args.quiet:
        print(found)
        mechanism = found.mechanism
        freedoms = sum(joint.start is not None for joint in mechanism.joints) + 3 * sum(body.is_free for body in mechanism.bodies)
        parts = f"{len(mechanism.bodies)} bodies, {len(mechanism.joints)} joints, {freedoms} degrees of freedom"
        print(f"\nwrote {args.out}: {parts}, {len(mechanism.contacts)} pairs of outlines")
    return 0


if __name__ == "__main__":
    sys.exit(main())

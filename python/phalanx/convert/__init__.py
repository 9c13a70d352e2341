"""Scenes from MuJoCo and URDF models: `phalanx.from_mjcf`, `phalanx.compare_mujoco`, and `python -m phalanx.convert`."""

from ..errors import ConversionError
from .compare import Comparison, Side, compare_mujoco
from .conversion import Conversion, from_mjcf
from .report import Note, Report

__all__ = ["Comparison", "Conversion", "ConversionError", "Note", "Report", "Side", "compare_mujoco", "from_mjcf"]

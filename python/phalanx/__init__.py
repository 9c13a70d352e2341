"""A planar simulator of high-speed underactuated grippers: stiff contact with exact events.

    import matplotlib.pyplot as plt
    import phalanx

    result = phalanx.run("scenes/experiment-95.toml")
    plt.plot(result.time, result["q11_rad"])
    plt.show()

All values are in SI; column names contain the units. The JSON output of a command of the program is a dictionary here,
and its error messages are exceptions.
"""

from collections.abc import Mapping

from ._phalanx import (
    Result,
    Scene,
    Simulation,
    SimulationBatch,
    SimulationState,
    Table,
    __version__,
    capture,
    evaluate,
    hold,
    read_log,
    run,
    size,
    statics,
    study_info,
    sweep,
    sweep_merge,
    sweep_shard,
    validate,
)
from .convert import Comparison, Conversion, compare_mujoco, from_mjcf
from .errors import ConversionError, PhalanxError, RunError, SceneError, StudyError
from .events import Event
from .optimization import optimize

Mapping.register(Result)

__all__ = [
    "Comparison",
    "Conversion",
    "ConversionError",
    "Event",
    "PhalanxError",
    "Result",
    "RunError",
    "Scene",
    "SceneError",
    "Simulation",
    "SimulationBatch",
    "SimulationState",
    "StudyError",
    "Table",
    "__version__",
    "capture",
    "compare_mujoco",
    "evaluate",
    "from_mjcf",
    "hold",
    "optimize",
    "read_log",
    "run",
    "size",
    "statics",
    "study_info",
    "sweep",
    "sweep_merge",
    "sweep_shard",
    "validate",
]

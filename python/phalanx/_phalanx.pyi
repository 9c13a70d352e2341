"""Compiled module of phalanx. `phalanx` exports all public names."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Literal, TypeAlias, TypeVar, final, overload

import numpy
import numpy.typing
import pandas
import polars

from .events import Event
from .results import (
    CaptureResult,
    Check,
    ContactResult,
    Criteria,
    Energies,
    Gradient,
    HoldResult,
    MergeInfo,
    OffsetsResult,
    PartInfo,
    RunSummary,
    SizingResult,
    Statics,
    StudyInfo,
    TableSummary,
    ValidationResult,
)

__all__ = [
    "Column",
    "Result",
    "Scene",
    "Simulation",
    "SimulationBatch",
    "SimulationState",
    "Table",
    "Variable",
    "__version__",
    "_read_optimisation",
    "_study_files",
    "capture",
    "evaluate",
    "hold",
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

__version__: str

_T = TypeVar("_T")
_Path: TypeAlias = str | PathLike[str]
_SceneLike: TypeAlias = Scene | _Path
_Model: TypeAlias = Literal["analytic", "engine"]
_Preset: TypeAlias = Literal["draft", "engineering", "reference"]
# A string with a unit, such as "20 mm", or a number in SI.
_Quantity: TypeAlias = str | float
_Value: TypeAlias = str | float | bool | Sequence[str | float | bool] | numpy.generic
_Values: TypeAlias = _Value | Iterable[_Value] | numpy.typing.NDArray[Any]
_Numbers: TypeAlias = numpy.typing.NDArray[numpy.float64]

@final
class Column:
    """Numbers in memory of phalanx: `numpy.asarray(column)` returns a read-only view."""

    @property
    def __array_interface__(self) -> dict[str, Any]:
        """Address, type and number of the values, for numpy."""

@final
class Scene:
    """A validated scene of a finger, a gripper, a mechanism or discs. It is immutable: `with_` returns a changed
    copy.
    """

    @staticmethod
    def load(path: _Path) -> Scene:
        """Reads a scene file (TOML) and the files that it extends.

        Raises SceneError with file, line, column and field of the error.
        """

    @staticmethod
    def from_toml(text: str, name: str = "scene.toml") -> Scene:
        """Reads a scene from a TOML string.

        `name` is its file name in messages and logs. Paths of extended scenes are relative to the directory of this
        name.
        """

    @staticmethod
    def from_dict(scene: dict[str, Any], name: str = "scene.toml") -> Scene:
        """Reads a scene from a dictionary with the keys of a scene file, such as `{"design": {"base": "20 mm", …}, …}`.

        Quantities are strings with units, or numbers in SI.
        """

    def with_(self, fields: Mapping[str, _Value]) -> Scene:
        """Returns a copy with other values of some fields, as with `phalanx run --set`.

        `scene.with_({"contact.friction.mu_static": 0.6, "design.base": "20 mm"})`

        A value is a string with a unit, a number (in SI if the field has a unit), True, False, or a list.
        `object.centre[0]` is an entry of a list. A string that begins with "=" is an expression.
        """

    @property
    def toml(self) -> str:
        """The scene as written, with all defaults, as the text of a scene file. It is the output of `phalanx scene
        show`.
        """

    @property
    def resolved(self) -> str:
        """The simulated scene as text in full precision. It is the output of `phalanx scene show --resolved`."""

    def to_dict(self) -> dict[str, Any]:
        """Returns the contents of `toml` as a dictionary of strings with units, numbers, flags and lists."""

    def to_mjcf(self) -> str:
        """Returns the MuJoCo model of the scene (`phalanx scene export`).

        Contacts, limits and friction are MuJoCo's own. Raises SceneError for a scene that has no model in MuJoCo.
        """

    @property
    def kind(self) -> Literal["finger", "gripper", "bodies", "mechanism"]:
        """ "finger", "gripper", "bodies" (discs) or "mechanism"."""

    @property
    def name(self) -> str:
        """The field `name` of the scene."""

    @property
    def duration_s(self) -> float:
        """Duration of a run, s."""

    def __getitem__(self, path: str, /) -> Any:
        """Returns a field of `toml` by its path, such as `scene["design.base"]`, or a section as a dictionary."""

    def __reduce__(self) -> tuple[Any, Any]:
        """Supports pickling, such as for other processes."""

    @staticmethod
    def _from_texts(layers: list[tuple[str, str]], settings: list[tuple[str, str]]) -> Scene: ...

@final
class Result(Mapping[str, _Numbers]):
    """The results of a run, or of the run in a log: a mapping from column names to arrays.

    All values are in SI; column names contain the units. A pickled result contains its numbers; unpickling does not
    simulate it again.
    """

    def __getitem__(self, column: str, /) -> _Numbers:
        """Returns a column as a read-only numpy array that shares memory with the run, such as `result["q11_rad"]`.

        `columns` lists the names. Units: angles rad, rates rad/s, forces N, torques N·m, lengths m, energies J.
        """

    def __contains__(self, column: object, /) -> bool: ...
    def __iter__(self) -> Iterator[str]:
        """Iterates over the names of the columns."""

    @overload
    def get(self, key: str, default: None = None, /) -> _Numbers | None: ...
    @overload
    def get(self, key: str, default: _T, /) -> _Numbers | _T:
        """Returns a column, or `default` if there is no column of this name."""

    @property
    def columns(self) -> list[str]:
        """Names of all columns with their units, as in `phalanx replay --csv`: `time_s` is first, the energies are
        last.
        """

    @property
    def time(self) -> _Numbers:
        """Times of the samples, s. Two samples may have the same time: one before and one after an event."""

    @property
    def events(self) -> list[Event]:
        """Contact events in order of time."""

    @property
    def summary(self) -> RunSummary:
        """The document of `phalanx run --json` (for a log: `phalanx replay --json`) as a dictionary."""

    @property
    def outcome(self) -> RunSummary:
        """Same as `summary`."""

    @property
    def contacts(self) -> dict[str, ContactResult]:
        """Results by contact: first touch-down (s), touch-downs, largest force (N), penetration (m), impulse (N·s)."""

    @property
    def criteria(self) -> Criteria | None:
        """Criteria of a finger, or the fate of the object of a hand.

        For a finger, a dictionary with `class`, `class_reason`, `tts_s`, … For a hand, a dictionary whose `grasp`
        contains fate, reason, times, pairs and margin; for a gripper, it also contains the entries of its `grasp`
        itself.

        None for discs (`contacts` contains their restitution), and for a run without criteria; the reason is then given
        by `summary["no_criteria"]` or `summary["no_grasp"]`.
        """

    @property
    def energies(self) -> Energies | None:
        """Energies and work at the end, J."""

    @property
    def gradient(self) -> dict[str, Gradient] | None:
        """Derivatives of the run with respect to the fields in `run(…, gradient=[…])`, in SI units; None without such
        fields.

        `gradient["design.base"]` contains `end` (derivatives of the last sample, by column), `events`, and `tts_s`
        (derivative of the time to stability). Each event has `time` (derivative of its time) and `state` (derivatives
        of the sample at the event). `end` and `state` have `values`, `errors` (estimates) and `reason`; the others have
        `value`, `error` and `reason`. If there is no derivative, `reason` is a sentence.
        """

    @property
    def check(self) -> Check | None:
        """Error estimate from a second, independent resolution; None if the run was not checked."""

    @property
    def warnings(self) -> list[str] | None:
        """Reasons to doubt the results, such as an unbalanced energy; empty for a valid run, None for a log."""

    @property
    def completed(self) -> bool | None:
        """Whether the run reached its full duration; None for a log that ends too early to tell."""

    def to_pandas(self) -> pandas.DataFrame:
        """Returns all columns as a pandas DataFrame that shares memory with the run."""

    def to_polars(self) -> polars.DataFrame:
        """Returns all columns as a Polars DataFrame that shares memory with the run."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """Returns all columns as an Arrow stream, for pyarrow, Polars, DuckDB and others, without a copy."""

    def __dataframe__(self, nan_as_null: bool = False, allow_copy: bool = True) -> object:
        """Supports the dataframe interchange protocol through pyarrow.

        Raises ImportError without pyarrow.
        """

    def save(self, path: _Path) -> None:
        """Writes the same log as `phalanx run --log`, byte for byte (MCAP, for Foxglove, Rerun and PlotJuggler).

        The run is repeated for this; the same scene gives the same run. The log of a result from a log is copied.
        """

    def html(self) -> str | None:
        """Returns the animated page of `phalanx run --plot`. None for a log without a readable scene."""

    def _repr_html_(self) -> str | None:
        """Returns the page of `html` in a frame, for notebooks."""

    def __len__(self) -> int:
        """Number of columns. The number of samples is `len(result.time)`."""

    def __reduce__(self) -> tuple[Any, Any]:
        """Supports pickling, such as for other processes."""

    @classmethod
    def _restore(cls, saved: dict[str, Any]) -> Result: ...

@final
class Simulation:
    """A scene that the caller advances: a controller in the loop.

    `simulation = phalanx.Simulation("scene.toml")`, `simulation.advance(1e-4)`, `simulation["q11_rad"]`,
    `simulation.set_torque("motor", 0.48)`. Between two calls the model takes its own steps and locates its events.
    Results of the analytic model do not depend on how the time is divided; those of the engine model differ by up to
    4e-6 rad for 1,000 pieces. A simulation can continue beyond the duration of the scene. preset: replaces the settings
    of the scene's integrator; "draft" is the fastest.

    A copy (`copy.copy(simulation)`) or a `state` continues bit for bit, also after pickling: a pickle contains the
    scene and the inputs, and the run is repeated when it is read. Durations, torques and targets are numbers in SI, or
    strings with units. Raises SceneError for an invalid scene, and RunError if the model does not simulate it.
    """

    def __new__(cls, scene: _SceneLike, model: _Model = "analytic", *, preset: _Preset | None = None) -> Simulation: ...
    def advance(self, duration: _Quantity) -> None:
        """Advances by a duration, s.

        Raises RunError with the time `time_s` of the failure if the model cannot advance further; the simulation is
        then at that time. Other Python threads continue. Ctrl-C interrupts the call; then only a `state` that was
        stored before can be continued.
        """

    def advance_to(self, time: _Quantity) -> None:
        """Advances to a time, s; see `advance`."""

    def reset(self, seed: int | None = None) -> None:
        """Returns to the start of the scene, with the inputs of the scene.

        seed: has no effect, because nothing in a simulation is random; it is accepted because environments have a
        `reset` with a seed. Vary the scene instead (`scene.with_`).
        """

    @property
    def time(self) -> float:
        """Present time, s."""

    def __getitem__(self, column: str, /) -> float:
        """Returns the present value of a column, such as `simulation["q11_rad"]`.

        `columns` lists the names. Units: angles rad, rates rad/s, forces N, torques N·m, lengths m, energies J.
        """

    def observe(self, columns: Sequence[str]) -> _Numbers:
        """Returns the present values of `columns` as a new array with shape (len(columns),), in their order and units.

        Raises KeyError for an unknown column, with a similar one.
        """

    @property
    def columns(self) -> list[str]:
        """Names of all columns with their units: `time_s` is first, the energies are last."""

    @property
    def contacts(self) -> dict[str, dict[str, float]]:
        """Present values by contact, with the keys of its columns, such as
        `simulation.contacts["distal"]["normal_n"]`.
        """

    @property
    def events(self) -> list[Event]:
        """Contact events so far, in order of time."""

    @property
    def torque_inputs(self) -> list[str]:
        """Names of the actuators whose input is a torque or a force."""

    @property
    def target_inputs(self) -> list[str]:
        """Names of the actuators whose input is a target."""

    def set_torque(self, actuator: str, torque: _Quantity) -> None:
        """Sets the torque of an actuator, N·m (prismatic joint: force, N; electric motor: voltage, V), from now on.

        Raises SceneError that lists the actuators if the name is wrong.
        """

    def set_target(self, actuator: str, target: _Quantity, rate: _Quantity = 0.0) -> None:
        """Sets the target of a servo, rad or m, from now on; the target moves at `rate`, rad/s or m/s.

        For a servo with a `target_rate`, the set point starts from its present value and follows the target at no more
        than that rate.

        Raises SceneError that lists the actuators if the name is wrong.
        """

    @property
    def state(self) -> SimulationState:
        """The whole state.

        Assign it to this simulation, or to another one of the same scene and model, to continue from there bit for bit.
        A state of another scene or model raises SceneError.
        """

    @state.setter
    def state(self, state: SimulationState, /) -> None: ...
    def __copy__(self) -> Simulation:
        """Returns an independent copy."""

    def __deepcopy__(self, memo: object, /) -> Simulation:
        """Returns an independent copy."""

    def __reduce__(self) -> tuple[Any, Any]:
        """Supports pickling. The run is repeated when the pickle is read."""

    @classmethod
    def _restore(cls, saved: dict[str, Any]) -> Simulation: ...

@final
class SimulationState:
    """State of a `Simulation`, from which it can continue."""

    def __reduce__(self) -> tuple[Any, Any]:
        """Supports pickling. The run is repeated when the pickle is read."""

    @classmethod
    def _restore(cls, saved: dict[str, Any]) -> SimulationState: ...

@final
class SimulationBatch:
    """Many simulations that advance together on all cores, with arrays as inputs and outputs.

    scenes: one scene for each simulation; `[scene] * 100` gives 100 equal simulations. A simulation that fails keeps
    the time of its failure, and the others continue. preset: see `Simulation`. After `os.fork`, a batch can also
    advance in the child process.
    """

    def __new__(cls, scenes: Sequence[_SceneLike], model: _Model = "analytic", *, preset: _Preset | None = None) -> SimulationBatch: ...
    def advance(self, duration: _Quantity) -> None:
        """Advances all simulations by a duration, s. Ctrl-C interrupts; then only a stored state can be continued."""

    def reset(self, seed: int | None = None, indices: Sequence[int] | None = None) -> None:
        """Returns all simulations, or those with these indices, to the start of their scenes.

        seed: has no effect; see `Simulation.reset`. Raises IndexError for an index without a simulation; no simulation
        is changed then.
        """

    @property
    def time(self) -> _Numbers:
        """Present time of each simulation, s."""

    def observe(self, columns: Sequence[str]) -> _Numbers:
        """Returns the present values of `columns` as a new array with shape (len(batch), len(columns)).

        Raises KeyError for an unknown column, with a similar one.
        """

    def __getitem__(self, column: str, /) -> _Numbers:
        """Returns the present values of a column, one for each simulation, such as `batch["q11_rad"]`."""

    def set_torque(self, actuator: str, torque: _Quantity | Sequence[_Quantity] | _Numbers) -> None:
        """Sets the torque of an actuator in all simulations, N·m (prismatic joint: force, N; electric motor: voltage, V).

        torque: one number for all simulations, or one for each. Simulations that have failed ignore it.
        """

    def set_target(self, actuator: str, target: _Quantity | Sequence[_Quantity] | _Numbers) -> None:
        """Sets the target of a servo in all simulations, rad or m.

        target: one number for all simulations, or one for each. Simulations that have failed ignore it.
        """

    @property
    def events(self) -> list[list[Event]]:
        """Contact events of each simulation so far."""

    @property
    def failures(self) -> list[str | None]:
        """Reason of the failure of each simulation; None if it can advance."""

    @property
    def states(self) -> list[SimulationState]:
        """States of all simulations, for `restore`."""

    def restore(self, indices: Sequence[int], states: Sequence[SimulationState]) -> None:
        """Restores states of the simulations with these indices; `states` contains one state for each index.

        Raises IndexError for an index without a simulation, and SceneError for a state of another scene or model; no
        simulation is changed then.
        """

    def __len__(self) -> int:
        """Number of simulations."""

    def __reduce__(self) -> tuple[Any, Any]:
        """Supports pickling. The run is repeated when the pickle is read."""

    @classmethod
    def _restore(cls, saved: tuple[str, list[dict[str, Any]]]) -> SimulationBatch: ...

@final
class Table:
    """The results of a sweep: one row for each run. Columns are those of the tables of `phalanx sweep`; values are
    in SI.
    """

    def __getitem__(self, column: str, /) -> numpy.typing.NDArray[Any]:
        """Returns a column as a numpy array.

        Numbers are a read-only view; if values are missing, they are a copy with NaN. Flags are bools; if values are
        missing, they are objects. Strings are objects. Missing objects are None.
        """

    @property
    def columns(self) -> list[str]:
        """Names of all columns, with their units."""

    @property
    def summary(self) -> TableSummary:
        """Counts of runs: `runs`, `by_status`, `by_class`, and `reasons` of runs without completion or class.

        `no_class` is the number of completed runs without a class, because the finger cannot grasp its object.
        """

    def to_pandas(self) -> pandas.DataFrame:
        """Returns all columns as a pandas DataFrame."""

    def to_polars(self) -> polars.DataFrame:
        """Returns all columns as a Polars DataFrame."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """Returns all columns as an Arrow stream, for pyarrow, Polars, DuckDB and others."""

    def __dataframe__(self, nan_as_null: bool = False, allow_copy: bool = True) -> object:
        """Supports the dataframe interchange protocol through pyarrow.

        Raises ImportError without pyarrow.
        """

    def write(self, path: _Path) -> None:
        """Writes the table as CSV or Parquet, by the suffix of the path.

        An existing file is replaced only if it is a table of phalanx, or has the same columns; otherwise StudyError is
        raised.
        """

    def __len__(self) -> int:
        """Returns the number of runs."""

    def __reduce__(self) -> tuple[Any, Any]:
        """Supports pickling, such as for other processes."""

    @classmethod
    def _restore(cls, columns: list[tuple[str, str, Any]], summary: str) -> Table: ...

@final
class Variable:
    """A field that a search varies, with its range."""

    @property
    def path(self) -> str:
        """Path of the field."""

    @property
    def column(self) -> str:
        """Name of the column of the field in the results: the path with the unit of the SI value."""

    @property
    def ends_si(self) -> list[float]:
        """Both ends of the range in SI, in the order of the study."""

    @property
    def is_log(self) -> bool:
        """Whether the search measures distances by ratios of values, on a logarithmic scale."""

    @property
    def start_fraction(self) -> float:
        """Fraction of the range at which the start value lies."""

    def value_at(self, fraction: float) -> Any:
        """Returns the value at a fraction of the range, from 0 to 1, as written in a scene."""

    def si_at(self, fraction: float) -> float:
        """Returns the SI value at a fraction of the range."""

def run(
    scene: _SceneLike,
    model: _Model = "analytic",
    check: bool | None = False,
    *,
    preset: _Preset | None = None,
    rtol: float | str | None = None,
    step: _Quantity | None = None,
    tolerance: _Quantity | None = None,
    duration: _Quantity | None = None,
    numeric_rate: _Quantity | None = None,
    picture_rate: _Quantity | None = None,
    log: _Path | None = None,
    gradient: Sequence[str] | None = None,
) -> Result:
    """Simulates a scene.

    check: True estimates the error with a second, independent resolution and detects a chaotic outcome; None does so
    only if it is cheap (as `phalanx run` does); False never does. log: path of a log to write (MCAP).

    The other arguments replace settings of the scene: preset (analytic), rtol (analytic), step such as "1 us" (engine),
    tolerance such as "0.02 um" (engine), duration such as "30 ms", numeric_rate such as "20 kHz", picture_rate such as
    "1 kHz". Quantities are strings with units, or numbers in SI.

    gradient: numeric fields of the scene, such as `["design.base", "contact.friction.mu_static"]`. The run is
    differentiated with respect to them (analytic model); `gradient` of the result contains the derivatives.

    Raises SceneError for an invalid scene or argument, and RunError if the run is not completed. The `result` of a
    RunError contains the run up to its end. Other Python threads continue during the run; Ctrl-C interrupts it.
    """

def read_log(path: _Path) -> Result:
    """Reads a log of phalanx (MCAP) up to its end or to the first damage.

    `summary["losses"]` lists lost data; `summary["missing"]` lists missing topics.
    """

def evaluate(
    scene: _SceneLike,
    fields: Mapping[str, _Values],
    *,
    model: _Model = "analytic",
    preset: _Preset | None = None,
    threads: int = 0,
    columns: Sequence[str] | None = None,
    check: bool = False,
    filter: dict[str, bool] | None = None,
) -> Table:
    """Simulates many designs of a scene on native threads. Returns a table with one row per design, in order.

    fields: values by field path, such as `{"design.base": [0.018, 0.020, 0.022], "contact.friction.mu_static": 0.6}`.
    All arrays and lists must have the same length; a single value applies to every design. Values are numbers in SI, or
    strings with units. preset: replaces the integrator settings of all designs ("draft" for searches). threads: number
    of threads; 0 for one per core. columns: columns to return; by default all. check: check every run, with three more
    runs each. filter: static criteria of a finger, such as `{"form_closed": True}`; other designs are not simulated and
    have the status "filtered".

    A design with an invalid scene or an incomplete run gives a row with `status` and `reason`, never an exception. A
    design that cannot grasp its object has a `reason` and no `class`. `class_reason` explains the class. Raises
    StudyError for an unknown field or for arrays of different lengths, and SceneError for an invalid scene.
    """

def sweep(
    study: _Path,
    threads: int = 0,
    out: _Path | None = None,
    *,
    model: _Model | None = None,
    preset: _Preset | None = None,
    check: bool = False,
    limit: int | None = None,
    restart: bool = False,
) -> Table:
    """Simulates all runs of a study (`phalanx sweep`).

    study: path of a study file (TOML). threads: number of threads; 0 for one per core. out: path of the results, CSV or
    Parquet according to its suffix. With `out`, an interrupted sweep resumes when it is called again, and the file
    OUT.study.json identifies the study. model: overrides the model of the study. preset: replaces the integrator
    settings of all runs ("draft" for searches). check: check every run. limit: simulate only the first `limit` runs.
    restart: discard earlier results in `out`.

    An invalid scene or an incomplete run gives a row with status and reason. A design that cannot grasp its object has
    a reason and no class. Raises StudyError for an invalid study or unusable results.
    """

def sweep_shard(
    study: _Path,
    k: int,
    n: int,
    out: _Path,
    threads: int = 0,
    *,
    model: _Model | None = None,
    preset: _Preset | None = None,
    check: bool = False,
    restart: bool = False,
) -> PartInfo:
    """Simulates one part of a study and writes it atomically as a Parquet file (`phalanx sweep --shard k/n`).

    k: number of the part, from 1 to n. An existing part is not simulated again, so repeating the call resumes an
    interrupted sweep. Returns the description of the part: `shard`, `of`, `first_run`, `last_run`, `runs` (of the whole
    study), …, and `made_now`, the number of new runs.
    """

def sweep_merge(
    study: _Path,
    parts: Sequence[_Path],
    out: _Path,
    *,
    model: _Model | None = None,
    preset: _Preset | None = None,
    check: bool = False,
) -> MergeInfo:
    """Merges the parts of a study (`phalanx sweep merge`).

    The files `out` and OUT.study.json have the same bytes as those of an uninterrupted sweep. parts: files or
    directories, in any order. Raises StudyError that names missing, duplicate, damaged or foreign parts. Returns
    `parts`, `bytes` and `runs`.
    """

def _read_optimisation(
    file: _Path, text: str | None = None, model: str | None = None, preset: str | None = None
) -> dict[str, Any]:
    """Reads and checks a study file of an optimisation and its base scene.

    text: content of the file; by default, the file is read. model: overrides the model of the study. preset: replaces
    the integrator settings of the scene. Raises StudyError with file, line and field of the errors.
    """

def _study_files(study: _Path) -> list[Path]:
    """Returns the files of a study: the study file, then the files of its base scene."""

def study_info(
    study: _Path, *, model: _Model | None = None, preset: _Preset | None = None, check: bool = False
) -> StudyInfo:
    """Describes a study: `name`, `model`, `runs`, `designs`, and `fingerprint`.

    Studies with different results have different fingerprints.
    """

def statics(
    scene: _SceneLike,
    mu_static: Sequence[float] | None = None,
    motor: _Quantity | None = None,
    *,
    posture: str | None = None,
    at: _Quantity | None = None,
    within: _Quantity | None = None,
    object: str | None = None,
    base: str | None = None,
    every: _Quantity | None = None,
) -> Statics:
    """Computes the static grasp of a scene (`phalanx statics --json`): forces, closure, and allowable acceleration.

    mu_static: friction coefficients; default: 0 and the coefficient of the scene. motor: motor torque for fingers and
    grippers, a string such as "500 N*mm" or a number in N·m.

    For grippers and mechanisms: at: time in the run. within: largest gap at which a surface counts as in contact.
    every: angle between directions, such as "15 deg". For grippers: posture: "run", "geometric", or angles such as
    "q11=2 deg, q21=65 deg". For mechanisms: object: the held body, if several bodies have no joints. base: the body
    that is accelerated. Quantities are strings with units, or numbers in SI.
    """

def size(
    scene: _SceneLike,
    rule: Literal["rigid", "whole"] = "rigid",
    closing_time: _Quantity | None = None,
    preload: _Quantity | None = None,
) -> SizingResult:
    """Sizes the spring and the motor of a finger for a test trajectory (`phalanx size --json`).

    closing_time: duration of the trajectory; default: 10 ms. preload: preload angle of the torsional spring that is
    compared with the constant spring; default: the preload of the scene, or 90 deg if it has none. Quantities are
    strings with units, or numbers in s and rad.
    """

def hold(
    scene: _SceneLike,
    *,
    pulse: _Quantity | None = None,
    directions: int | None = None,
    vibration: Sequence[_Quantity] | None = None,
    along: Sequence[Literal["x", "y", "angle"]] | None = None,
    move: bool = False,
    slip: _Quantity | None = None,
    at: _Quantity | None = None,
    from_: _Quantity | None = None,
    to: _Quantity | None = None,
    scan: int | None = None,
    tol: float | None = None,
    model: _Model = "analytic",
    threads: int = 0,
) -> HoldResult:
    """Finds the accelerations up to which a gripper, or the hand of a mechanism, holds its object (`phalanx hold --json`).

    Loads are pulses of duration `pulse` in `directions` directions; or vibrations with the frequencies `vibration` (a
    list) along "x", "y" or "angle"; or, with `move`, the motion of the scene. slip: largest allowed slip of the object
    in the hand. at: time at which the loads begin. from_, to: range of the peak acceleration. scan: number of
    accelerations in this range. tol: relative tolerance of a limit. Quantities are strings with units, or numbers in
    SI.
    """

def capture(
    scene: _SceneLike,
    to: _Quantity | Sequence[_Quantity] | None = None,
    places: int = 15,
    finely: _Quantity | None = None,
    model: _Model = "analytic",
    *,
    along: Sequence[str] | None = None,
) -> CaptureResult | OffsetsResult:
    """Finds the positioning errors that a gripper, or the hand of a mechanism, captures (`phalanx capture --json`).

    along: directions of the offsets of the object of a mechanism: a list of one or two of "x", "y" and "angle";
    default: x. to: largest error, or a list with one value for each of `along`; default: 3.5 mm, 10 deg. places: number
    of object positions, odd and at least 3. finely: tolerance of the edges of the captured range; default: 0.01 mm,
    0.01 deg. Sizes are strings with units, or numbers in m or rad.
    """

def validate(
    scene: _SceneLike,
    quick: bool = False,
    ladder: bool = False,
    ladder_time: _Quantity | None = None,
) -> ValidationResult:
    """Compares the engine with the analytic model (`phalanx validate --json`). Returns `passed`, and each bound with
    its value.

    ladder: also compare and time other settings (speed against error), for at most `ladder_time`, by default 10 s.
    quick: omit the slow settings of the ladder.
    """

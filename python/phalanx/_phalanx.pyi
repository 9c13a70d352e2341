"""The compiled part of phalanx. Everything here is exported by `phalanx` itself."""

from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Literal, TypeAlias, final

import numpy
import numpy.typing
import pandas
import polars

from .events import Event

__all__ = [
    "Column",
    "Result",
    "Scene",
    "Table",
    "__version__",
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

_Path: TypeAlias = str | PathLike[str]
_SceneLike: TypeAlias = Scene | _Path
_Model: TypeAlias = Literal["analytic", "engine"]
# A text with its unit, such as "20 mm", or a number in SI.
_Quantity: TypeAlias = str | float
_Value: TypeAlias = str | float | bool | Sequence[str | float | bool] | numpy.generic
_Values: TypeAlias = _Value | Iterable[_Value] | numpy.typing.NDArray[Any]
_Numbers: TypeAlias = numpy.typing.NDArray[numpy.float64]

@final
class Column:
    """Numbers that phalanx holds, for numpy to look at: `numpy.asarray(column)` is a view that cannot be written to."""

    @property
    def __array_interface__(self) -> dict[str, Any]:
        """How numpy finds the numbers: their address, kind and count."""

@final
class Scene:
    """A scene of a finger, a gripper or discs, checked, with every default filled in. It never changes: `with_` makes another one."""

    @staticmethod
    def load(path: _Path) -> Scene:
        """Reads a scene file (TOML), and those it extends.

        Raises SceneError with file, line, column and field of what is wrong.
        """

    @staticmethod
    def from_toml(text: str, name: str = "scene.toml") -> Scene:
        """Reads a scene from a text (TOML). `name` is what messages and logs call its file; scenes it extends are looked for from there."""

    @staticmethod
    def from_dict(scene: dict[str, Any], name: str = "scene.toml") -> Scene:
        """Reads a scene from a dictionary with the keys of a scene file: `{"design": {"base": "20 mm", …}, …}`."""

    def with_(self, fields: dict[str, _Value]) -> Scene:
        """The same scene with other values in some fields, as `phalanx run --set` has them.

        `scene.with_({"contact.friction.mu_static": 0.6, "design.base": "20 mm"})`

        A value is a text with its unit, a number where the field is one without a unit, True or False, or a list; one element of a
        pair is `object.centre[0]`.
        """

    @property
    def toml(self) -> str:
        """The scene as it was written with every default filled in, as a scene file: what `phalanx scene show` prints."""

    @property
    def resolved(self) -> str:
        """What is simulated, as a scene file in full precision: what `phalanx scene show --resolved` prints."""

    def to_dict(self) -> dict[str, Any]:
        """The same as `toml`, as a dictionary of texts with units, numbers, flags and lists."""

    @property
    def kind(self) -> Literal["finger", "gripper", "bodies"]:
        """ "finger", "gripper" or "bodies" (discs)."""

    @property
    def name(self) -> str:
        """The name that the scene gives itself."""

    @property
    def duration_s(self) -> float:
        """Length of a run, in s."""

    def __getitem__(self, path: str, /) -> Any:
        """A field by its path, as `toml` has it: `scene["design.base"]`. Of a section, its dictionary."""

    def __reduce__(self) -> tuple[Any, Any]:
        """For copies in other processes."""

    @staticmethod
    def _of_texts(layers: list[tuple[str, str]], settings: list[tuple[str, str]]) -> Scene: ...

@final
class Result:
    """A run of a scene, or what a log has of one. Figures are in SI, their names say the unit."""

    def __getitem__(self, column: str, /) -> _Numbers:
        """A column as an array of numpy that cannot be written to, over the very numbers of the run: `result["q11_rad"]`.

        Names are those of `columns`; angles rad, rates rad/s, forces N, torques N·m, lengths m, energies J.
        """

    @property
    def columns(self) -> list[str]:
        """Names of all columns with their units, as `phalanx replay --csv` has them: `time_s` first, the energies last."""

    @property
    def time(self) -> _Numbers:
        """Times of the samples, in s; two may share one, before and after an event."""

    @property
    def events(self) -> list[Event]:
        """Changes of contact in order of time."""

    @property
    def summary(self) -> dict[str, Any]:
        """The document of `phalanx run --json` (of a log: `phalanx replay --json`) as a dictionary."""

    @property
    def outcome(self) -> dict[str, Any]:
        """The same as `summary`."""

    @property
    def contacts(self) -> Any:
        """By contact: first touch (s), touch-downs, largest force (N), deepest penetration (m), impulse (N·s)."""

    @property
    def criteria(self) -> dict[str, Any] | None:
        """Of a finger: class, what decides it (`class_reason`), `tts_s`, `rebound_percent`, …; of a gripper what became of its object.

        None of discs (`contacts` has their restitution), and where the run does not say: `summary["no_criteria"]` says why.
        """

    @property
    def energies(self) -> dict[str, float] | None:
        """Energies and works at the end, in J."""

    @property
    def check(self) -> dict[str, Any] | None:
        """What a second, independent resolution says of the error; None where the run was not checked."""

    @property
    def warnings(self) -> list[str] | None:
        """Sentences on what makes the results doubtful, such as an energy balance that is off; empty for a sound run, None of a log."""

    @property
    def completed(self) -> bool | None:
        """Whether the run got to its end; None of a log that does not get that far."""

    def to_pandas(self) -> pandas.DataFrame:
        """All columns as a pandas DataFrame over the same numbers."""

    def to_polars(self) -> polars.DataFrame:
        """All columns as a Polars DataFrame over the same numbers."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """All columns as a stream of Arrow, for pyarrow, Polars, DuckDB and others; the numbers are not copied."""

    def save(self, path: _Path) -> None:
        """Writes the log that `phalanx run --log` would (MCAP, for Foxglove, Rerun and PlotJuggler), byte for byte.

        The run is made again for it: the same scene gives the same run. Of a result that was read from a log, that file is copied.
        """

    def html(self) -> str | None:
        """The page of `phalanx run --html`, the bodies in motion. None of a log whose scene is lost."""

    def _repr_html_(self) -> str | None:
        """The same page in a frame of its own: what a notebook shows."""

    def __len__(self) -> int:
        """How many samples there are."""

@final
class Table:
    """What a sweep found: a row for each run, columns as in the tables of `phalanx sweep`, figures in SI."""

    def __getitem__(self, column: str, /) -> numpy.typing.NDArray[Any]:
        """A column as an array of numpy.

        Numbers are a view that cannot be written to, or where some are missing a copy with NaN there; flags are bools and texts
        objects, None where missing.
        """

    @property
    def columns(self) -> list[str]:
        """Names of all columns, with their units."""

    @property
    def summary(self) -> dict[str, Any]:
        """How many runs ended how: `runs`, `by_status`, `by_class`, and `reasons` of those that were not completed or have no class.

        `no_class` is how many of the completed runs have no class, because the finger cannot grasp its object.
        """

    def to_pandas(self) -> pandas.DataFrame:
        """All columns as a pandas DataFrame."""

    def to_polars(self) -> polars.DataFrame:
        """All columns as a Polars DataFrame."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """All columns as a stream of Arrow, for pyarrow, Polars, DuckDB and others."""

    def write(self, path: _Path) -> None:
        """Writes the table as CSV or Parquet, by the name."""

    def __len__(self) -> int:
        """How many runs there are."""

def run(
    scene: _SceneLike,
    model: _Model = "analytic",
    check: bool | None = False,
    *,
    preset: Literal["engineering", "reference"] | None = None,
    rtol: float | str | None = None,
    construction: Literal["maximal", "reduced"] | None = None,
    step: str | None = None,
    tolerance: str | None = None,
    duration: str | None = None,
    numeric_rate: str | None = None,
    picture_rate: str | None = None,
    log: _Path | None = None,
) -> Result:
    """Simulates a scene.

    check: True estimates the error by a second, independent resolution and says whether the outcome is chaotic, None does so where
    it is cheap (as `phalanx run`), False never. log: also write a log there (MCAP).

    The others are the flags of `phalanx run`: preset (analytic), rtol (analytic), construction (engine), step such as "1 us"
    (engine), tolerance such as "0.02 um" (engine), duration such as "30 ms", numeric_rate such as "20 kHz", picture_rate such as
    "1 kHz".

    Raises SceneError for what is wrong with the scene or an argument, RunError if the run does not get to its end; the error's
    `result` has the run up to there. Other threads go on meanwhile, and Ctrl-C ends the run.
    """

def read_log(path: _Path) -> Result:
    """Reads a log of phalanx (MCAP), as far as it goes: `summary["losses"]` says what is lost, `summary["missing"]` which topics are missing."""

def evaluate(
    scene: _SceneLike,
    fields: dict[str, _Values],
    *,
    model: _Model = "analytic",
    threads: int = 0,
    columns: Sequence[str] | None = None,
    check: bool = False,
) -> Table:
    """Simulates many designs of a scene, on Rust's threads, and makes of them the table of a sweep: a row each, in order.

    fields: values by the path of their field, such as
    `{"design.base": [0.018, 0.020, 0.022], "contact.friction.mu_static": 0.6}`. Arrays and lists are all of one length; a single
    value is that of every design. A number is in SI, a text has its unit. threads: 0 for one on each core. columns: only these of
    the table. check: check every run (three more runs for each).

    A design whose scene is not valid, or whose run does not end, is a row with `status` and `reason`, never an exception; one
    that cannot grasp its object has a `reason` and no `class`. `class_reason` says what decides the class. Raises
    StudyError for a path that is no field, or arrays of different lengths; SceneError for a scene that is none.
    """

def sweep(
    study: _Path,
    threads: int = 0,
    out: _Path | None = None,
    *,
    model: _Model | None = None,
    check: bool = False,
    limit: int | None = None,
    restart: bool = False,
) -> Table:
    """Makes every run of a study (`phalanx sweep`).

    study: path of a study file (TOML). threads: 0 for one on each core. out: CSV or Parquet by the name; then a sweep that was
    broken off goes on where it was when it is called again, and OUT.study.json beside it says of which study the results are.
    model: instead of the study's. check: check every run. limit: only the first so many runs. restart: begin anew.

    A scene that is not valid and a run that does not end are rows, with status and reason; so are designs that cannot grasp,
    which have a reason and no class. Raises StudyError for what is wrong
    with the study, or with the place of its results.
    """

def sweep_shard(
    study: _Path,
    k: int,
    n: int,
    out: _Path,
    threads: int = 0,
    *,
    model: _Model | None = None,
    check: bool = False,
    restart: bool = False,
) -> dict[str, Any]:
    """Makes one part of a study into a Parquet file that appears whole or not at all (`phalanx sweep --shard k/n`).

    k: from 1 to n. A part that is there already is left as it is, so the same call again takes a broken sweep up. Returns what
    the part is: `shard`, `of`, `first_run`, `last_run`, `runs` (of the whole study), …, and `made_now`, how many runs were made now.
    """

def sweep_merge(
    study: _Path,
    parts: Sequence[_Path],
    out: _Path,
    *,
    model: _Model | None = None,
    check: bool = False,
) -> dict[str, int]:
    """Joins the parts of a study to the results of the whole (`phalanx sweep merge`).

    out and OUT.study.json get the very bytes that the undisturbed sweep writes. parts: files, or directories of them, in any
    order. Raises StudyError with what is missing, there twice, damaged or foreign. Returns `parts`, `bytes` and `runs`.
    """

def _study_files(study: _Path) -> list[Path]:
    """The files of a study: its own, then those of its base scene."""

def study_info(study: _Path, *, model: _Model | None = None, check: bool = False) -> dict[str, Any]:
    """What a study is: `name`, `model`, `runs`, `designs`, and `fingerprint`, which tells studies apart whose results differ."""

def statics(
    scene: _SceneLike,
    mu_static: Sequence[float] | None = None,
    motor: _Quantity | None = None,
    *,
    posture: str | None = None,
    at: _Quantity | None = None,
    within: _Quantity | None = None,
    every: str | None = None,
) -> dict[str, Any]:
    """The grasp of a scene at rest (`phalanx statics --json`): forces, form and force closure, what acceleration it bears.

    mu_static: friction coefficients, instead of 0 and those of the scene. motor: torque such as "500 N*mm", or in N·m. Of a
    gripper: posture "run", "geometric" or angles ("q11=2 deg, q21=65 deg"), at (time of the run, s), within (m), every (angle
    between directions).
    """

def size(
    scene: _SceneLike,
    rule: Literal["rigid", "whole"] = "rigid",
    closing_time: _Quantity | None = None,
    preload: _Quantity | None = None,
) -> dict[str, Any]:
    """Spring and motor of a finger for a test trajectory (`phalanx size --json`).

    closing_time: length of the trajectory, 10 ms if it is not given. preload: of the torsional spring that the constant one is
    compared with, 90 deg if it is not given. Texts with units, or numbers in s and rad.
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
) -> dict[str, Any]:
    """How much acceleration a gripper holds its object against (`phalanx hold --json`).

    Pulses of length `pulse` in `directions` directions, or vibrations at these frequencies (a list) along "x", "y", "angle", or
    the scene's own move. slip: how far the object may slip in the hand. at: when loads begin. from_, to: peak accelerations that
    are tried, scan of them; tol: how finely limits are found. Texts with units, or numbers in SI.
    """

def capture(
    scene: _SceneLike,
    to: _Quantity | None = None,
    places: int = 15,
    finely: _Quantity | None = None,
    model: _Model = "analytic",
) -> dict[str, Any]:
    """Which positioning errors a gripper captures (`phalanx capture --json`).

    to: largest error, 3.5 mm if it is not given. places: how many of them, an odd number from 3. finely: how finely edges are
    found, 0.01 mm if it is not given. Texts with units, or numbers in m.
    """

def validate(
    scene: _SceneLike,
    quick: bool = False,
    ladder: bool = False,
    ladder_time: _Quantity | None = None,
) -> dict[str, Any]:
    """The engine compared with the analytic model (`phalanx validate --json`): `passed`, every bound with what was measured.

    ladder: compare and time other settings as well, speed against error, in at most ladder_time, 10 s if it is not given. quick:
    leave those that take long out of the ladder.
    """

//! The classes `Simulation` and `SimulationBatch`: simulations that Python advances.

use std::sync::{Mutex, MutexGuard};

use phalanx::study::batch;
use phalanx::trace::schema::{Subject, SubjectKind};
use phalanx::trace::{self, Action, Event, Model, Schema, SimulationError};
use phalanx::units::Dimension;
use pyo3::exceptions::{PyIndexError, PyKeyError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyString, PyType};

use super::conversion::Reduced;
use super::result::{NamedEvent, model};
use super::scene::{Scene, SceneLike};
use super::{columns, conversion, errors, interruptible};

/// Converts an error of a simulation.
fn exception(py: Python<'_>, error: &SimulationError) -> PyErr {
    match error {
        SimulationError::Input(message) => errors::argument(py, message),
        SimulationError::Rejected(message) => errors::run(py, message, None),
        SimulationError::Failed(failure) => errors::failure(py, error, failure.time_s),
    }
}

/// Returns events in which contacts are given by their names.
pub fn named_events(schema: &Schema, events: &[Event]) -> Vec<NamedEvent> {
    let named = |event: &Event| {
        let name = schema.contacts.get(event.contact).map_or(String::new(), |contact| contact.name.clone());
        (event.time_s, name, event.kind.name().to_string(), event.approach_speed, event.impulse)
    };
    events.iter().map(named).collect()
}

/// Returns events as a list of `phalanx.Event`.
pub fn event_list<'py>(py: Python<'py>, events: Vec<NamedEvent>) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let class = py.import("phalanx.events")?.getattr("Event")?;
    events.into_iter().map(|event| class.call1(event)).collect()
}

fn is_contact(subject: &Subject) -> bool {
    matches!(subject.kind, SubjectKind::Contact | SubjectKind::Limit)
}

/// Locks the contents of an object that only one thread may use at a time.
fn lock<T>(contents: &Mutex<T>) -> PyResult<MutexGuard<'_, T>> {
    let message = "the simulation is in use by another thread";
    contents.try_lock().map_err(|_| PyRuntimeError::new_err(message))
}

/// Advances a simulation to a time. The interpreter lock is released only for steps, because that takes longer than an
/// advance within a step.
fn advance(py: Python<'_>, simulation: &mut trace::Simulation, time_s: f64) -> PyResult<()> {
    let result = match simulation.is_within_step(time_s) {
        true => simulation.advance_to(time_s),
        false => interruptible::run_on_caller(py, |keep_running| simulation.advance_while(time_s, keep_running))?,
    };
    result.map_err(|error| exception(py, &error))
}

/// Reads an input of an actuator, in SI. The dimension is that of its joint, of the shaft of its motor, or of the distance that
/// it controls.
fn read_input(
    py: Python<'_>,
    simulation: &trace::Simulation,
    actuator: &str,
    (name, value): (&str, &Bound<'_, PyAny>),
    [angular, linear]: [Dimension; 2],
) -> PyResult<f64> {
    let schema = simulation.schema();
    let is_in = |names: &[String]| names.iter().any(|known| known == actuator);
    let is_linear = schema.actuators.iter().any(|known| known.name == actuator && known.is_linear);
    let dimension = match name == "torque" {
        true if is_in(&schema.motors) => Dimension::Voltage,
        true if is_in(&schema.shafts) => angular,
        false if is_in(&schema.distances) => linear,
        _ if is_linear => linear,
        _ => angular,
    };
    conversion::quantity(py, name, value, dimension)
}

const EFFORT: [Dimension; 2] = [Dimension::Torque, Dimension::Force];
const TARGET: [Dimension; 2] = [Dimension::Angle, Dimension::Length];
const TARGET_RATE: [Dimension; 2] = [Dimension::AngularRate, Dimension::Speed];

/// Reads a scene, and replaces the settings of its integrator by those of a preset, if there is one.
fn with_preset(py: Python<'_>, scene: SceneLike, model: Model, preset: Option<&str>) -> PyResult<Py<Scene>> {
    match preset {
        None => scene.into_python(py),
        name => Py::new(py, scene.get(py)?.with_preset(py, model, name)?),
    }
}

/// A simulation, its start and its scene.
struct Loaded {
    simulation: trace::Simulation,
    start: trace::Simulation,
    scene: Py<Scene>,
}

impl Loaded {
    fn new(py: Python<'_>, scene: Py<Scene>, model: Model) -> PyResult<Self> {
        let simulation = trace::Simulation::new(&scene.get().scene, model);
        let simulation = simulation.map_err(|error| exception(py, &error))?;
        Ok(Self { start: simulation.clone(), simulation, scene })
    }

    fn clone_ref(&self, py: Python<'_>) -> Self {
        let [simulation, start] = [&self.simulation, &self.start].map(Clone::clone);
        Self { simulation, start, scene: self.scene.clone_ref(py) }
    }
}

/// A simulation for pickling: its scene, and what has changed it since its start.
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
struct Saved<'py> {
    scene: Py<Scene>,
    model: String,
    version: String,
    /// Kind, index and two numbers of each action.
    actions: Bound<'py, PyBytes>,
    /// Numbers of all columns, to check the repetition.
    values: Bound<'py, PyBytes>,
}

/// A batch for pickling: its model, and its simulations.
type SavedBatch<'py> = (String, Vec<Saved<'py>>);

fn column_values(simulation: &trace::Simulation) -> Vec<u8> {
    let sample = simulation.sample();
    conversion::to_bytes(&simulation.channels().iter().map(|channel| channel.value(sample)).collect::<Vec<_>>())
}

fn save<'py>(py: Python<'py>, simulation: &trace::Simulation, scene: &Py<Scene>) -> PyResult<Saved<'py>> {
    let actions = simulation.actions().ok_or_else(|| {
        let message = "an interrupted simulation cannot be pickled; pickle a `state` from before";
        errors::run(py, message, None)
    })?;
    let numbers = actions.iter().flat_map(|action| match *action {
        Action::Advance(time_s) => [0.0, 0.0, time_s, 0.0],
        Action::Torque(index, torque) => [1.0, index as f64, torque, 0.0],
        Action::Target(index, target, rate) => [2.0, index as f64, target, rate],
    });
    Ok(Saved {
        scene: scene.clone_ref(py),
        model: simulation.model().name().to_string(),
        version: env!("CARGO_PKG_VERSION").to_string(),
        actions: PyBytes::new(py, &conversion::to_bytes(&numbers.collect::<Vec<_>>())),
        values: PyBytes::new(py, &column_values(simulation)),
    })
}

impl Saved<'_> {
    fn actions(&self) -> Vec<Action> {
        let numbers = conversion::from_bytes(self.actions.as_bytes());
        let action = |[kind, index, first, second]: [f64; 4]| match kind {
            0.0 => Action::Advance(first),
            1.0 => Action::Torque(index as usize, first),
            _ => Action::Target(index as usize, first, second),
        };
        numbers.as_chunks().0.iter().copied().map(action).collect()
    }

    /// Checks that a repetition has the same bits.
    fn check(&self, py: Python<'_>, simulation: &trace::Simulation) -> PyResult<()> {
        if column_values(simulation) == self.values.as_bytes() {
            return Ok(());
        }
        let (saved, own) = (&self.version, env!("CARGO_PKG_VERSION"));
        let message = format!(
            "a simulation that was pickled with phalanx {saved} has other values when phalanx {own} repeats it; use the \
             same version, or simulate it again"
        );
        Err(errors::run(py, message, None))
    }

    /// Repeats the simulation.
    fn restore(&self, py: Python<'_>) -> PyResult<Loaded> {
        let mut loaded = Loaded::new(py, self.scene.clone_ref(py), self::model(py, &self.model)?)?;
        let (simulation, actions) = (&mut loaded.simulation, self.actions());
        interruptible::run_on_caller(py, |keep_running| simulation.repeat(&actions, keep_running))?
            .map_err(|error| exception(py, &error))?;
        self.check(py, &loaded.simulation)?;
        Ok(loaded)
    }
}

/// A scene that the caller advances: a controller in the loop.
///
/// `simulation = phalanx.Simulation("scene.toml")`, `simulation.advance(1e-4)`, `simulation["q11_rad"]`,
/// `simulation.set_torque("motor", 0.48)`. model: "analytic" or "engine". preset: replaces the settings of the scene's
/// integrator; "draft" is the fastest. Between two calls the model takes its own steps and locates its events. Results
/// of the analytic model do not depend on how the time is divided; those of the engine model differ by up to 4e-6 rad
/// for 1,000 pieces. A simulation can continue beyond the duration of the scene.
///
/// A copy (`copy.copy(simulation)`) or a `state` continues bit for bit, also after pickling: a pickle contains the
/// scene and the inputs, and the run is repeated when it is read. Durations, torques and targets are numbers in SI, or
/// strings with units. Raises SceneError for an invalid scene, and RunError if the model does not simulate it.
#[pyclass(frozen, module = "phalanx")]
pub struct Simulation {
    loaded: Mutex<Loaded>,
}

/// State of a `Simulation`, from which it can continue.
#[pyclass(frozen, module = "phalanx")]
pub struct SimulationState {
    simulation: Mutex<trace::Simulation>,
    scene: Py<Scene>,
}

#[pymethods]
impl SimulationState {
    /// Supports pickling. The run is repeated when the state is read.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py, (Saved<'py>,)>> {
        let (py, state) = (slf.py(), slf.get());
        let saved = save(py, &*lock(&state.simulation)?, &state.scene)?;
        Ok((py.get_type::<Self>().getattr("_restore")?, (saved,)))
    }

    #[classmethod]
    fn _restore(class: &Bound<'_, PyType>, saved: Saved<'_>) -> PyResult<Self> {
        let Loaded { simulation, scene, .. } = saved.restore(class.py())?;
        Ok(Self { simulation: Mutex::new(simulation), scene })
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (scene, model = "analytic", *, preset = None))]
    fn new(py: Python<'_>, scene: SceneLike, model: &str, preset: Option<&str>) -> PyResult<Self> {
        let model = self::model(py, model)?;
        let loaded = Loaded::new(py, with_preset(py, scene, model, preset)?, model)?;
        Ok(Self { loaded: Mutex::new(loaded) })
    }

    /// Advances by a duration, s.
    ///
    /// Raises RunError with its `time_s` if the model cannot advance further; the simulation is then at that time.
    /// Other Python threads continue; Ctrl-C interrupts, after which only a `state` can be continued.
    fn advance(&self, py: Python<'_>, duration: &Bound<'_, PyAny>) -> PyResult<()> {
        let duration_s = conversion::quantity(py, "duration", duration, Dimension::Time)?;
        let simulation = &mut lock(&self.loaded)?.simulation;
        let time_s = simulation.time_s() + duration_s;
        advance(py, simulation, time_s)
    }

    /// Advances to a time, s; see `advance`.
    fn advance_to(&self, py: Python<'_>, time: &Bound<'_, PyAny>) -> PyResult<()> {
        let time_s = conversion::quantity(py, "time", time, Dimension::Time)?;
        advance(py, &mut lock(&self.loaded)?.simulation, time_s)
    }

    /// Returns to the start of the scene, with the inputs of the scene.
    ///
    /// seed: has no effect, because nothing in a simulation is random; it is accepted for the `reset` of environments.
    /// Vary the scene instead (`scene.with_`).
    #[pyo3(signature = (seed = None))]
    fn reset(&self, seed: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let _ = seed;
        let loaded = &mut *lock(&self.loaded)?;
        loaded.simulation.clone_from(&loaded.start);
        Ok(())
    }

    /// Present time, s.
    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(lock(&self.loaded)?.simulation.time_s())
    }

    /// Returns the present value of a column, such as `simulation["q11_rad"]`.
    ///
    /// `columns` lists the names. Units: angles rad, rates rad/s, forces N, torques N·m, lengths m, energies J.
    fn __getitem__(&self, column: &str) -> PyResult<f64> {
        let value = lock(&self.loaded)?.simulation.get(column);
        value.map_err(|error| PyKeyError::new_err(error.to_string()))
    }

    /// Returns the present values of some columns as a new array of float64 with shape (len(columns),), in their order and
    /// units.
    ///
    /// Raises KeyError for an unknown column, with a similar one.
    fn observe<'py>(&self, py: Python<'py>, columns: Vec<String>) -> PyResult<Bound<'py, PyAny>> {
        let values = lock(&self.loaded)?.simulation.observe(&columns);
        conversion::vector(py, &values.map_err(|error| PyKeyError::new_err(error.to_string()))?)
    }

    /// Names of all columns with their units: `time_s` first, the energies last.
    #[getter]
    fn columns(&self) -> PyResult<Vec<String>> {
        Ok(lock(&self.loaded)?.simulation.channels().iter().map(|channel| channel.name.clone()).collect())
    }

    /// Present values by contact, each with the keys of its columns: `simulation.contacts["distal"]["normal_n"]`.
    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (loaded, contacts) = (lock(&self.loaded)?, PyDict::new(py));
        let simulation = &loaded.simulation;
        let sample = simulation.sample();
        let subjects = simulation.schema().subjects();
        for subject in subjects.iter().filter(|subject| is_contact(subject)) {
            let values = PyDict::new(py);
            for (quantity, channel) in subject.channels() {
                values.set_item(quantity.key, channel.value(sample))?;
            }
            contacts.set_item(&subject.name, values)?;
        }
        Ok(contacts)
    }

    /// Contact events so far in order of time, as `phalanx.Event`.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let simulation = &lock(&self.loaded)?.simulation;
        event_list(py, named_events(simulation.schema(), simulation.events()))
    }

    /// Names of the actuators with a torque or a force as input.
    #[getter]
    fn torque_inputs(&self) -> PyResult<Vec<String>> {
        Ok(lock(&self.loaded)?.simulation.torque_inputs().map(str::to_string).collect())
    }

    /// Names of the actuators with a target as input.
    #[getter]
    fn target_inputs(&self) -> PyResult<Vec<String>> {
        Ok(lock(&self.loaded)?.simulation.target_inputs().map(str::to_string).collect())
    }

    /// Sets the torque of an actuator, N·m (of a prismatic joint: the force, N; of an electric motor: the voltage, V), from
    /// now on.
    ///
    /// Raises SceneError that lists the actuators if the name is wrong.
    fn set_torque(&self, py: Python<'_>, actuator: &str, torque: &Bound<'_, PyAny>) -> PyResult<()> {
        let simulation = &mut lock(&self.loaded)?.simulation;
        let torque = read_input(py, simulation, actuator, ("torque", torque), EFFORT)?;
        simulation.set_torque(actuator, torque).map_err(|error| exception(py, &error))
    }

    /// Sets the target of a servo, rad or m, from now on; it moves at a rate, rad/s or m/s. The set point of a servo with a
    /// `target_rate` follows it from its present value, at most at that rate.
    ///
    /// Raises SceneError that lists the actuators if the name is wrong.
    #[pyo3(signature = (actuator, target, rate = None), text_signature = "($self, actuator, target, rate=0.0)")]
    fn set_target(
        &self,
        py: Python<'_>,
        actuator: &str,
        target: &Bound<'_, PyAny>,
        rate: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let simulation = &mut lock(&self.loaded)?.simulation;
        let target = read_input(py, simulation, actuator, ("target", target), TARGET)?;
        let read_rate = |rate| read_input(py, simulation, actuator, ("rate", rate), TARGET_RATE);
        let rate = rate.map_or(Ok(0.0), read_rate)?;
        simulation.set_target(actuator, target, rate).map_err(|error| exception(py, &error))
    }

    /// The whole state. Assigning it, also to another simulation of the same scene and model, continues from there with the
    /// same bits; a state of another scene or model raises SceneError.
    #[getter]
    fn state(&self, py: Python<'_>) -> PyResult<SimulationState> {
        let loaded = lock(&self.loaded)?;
        Ok(SimulationState { simulation: Mutex::new(loaded.simulation.clone()), scene: loaded.scene.clone_ref(py) })
    }

    #[setter]
    fn set_state(&self, py: Python<'_>, state: &Bound<'_, SimulationState>) -> PyResult<()> {
        let state = state.get();
        let (saved, loaded) = (lock(&state.simulation)?, &mut *lock(&self.loaded)?);
        loaded.simulation.restore(&saved).map_err(|error| exception(py, &error))?;
        loaded.scene = state.scene.clone_ref(py);
        Ok(())
    }

    /// Returns an independent copy.
    fn __copy__(&self, py: Python<'_>) -> PyResult<Self> {
        Ok(Self { loaded: Mutex::new(lock(&self.loaded)?.clone_ref(py)) })
    }

    /// Supports pickling. The run is repeated when the simulation is read.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py, (Saved<'py>,)>> {
        let (py, loaded) = (slf.py(), lock(&slf.get().loaded)?);
        Ok((py.get_type::<Self>().getattr("_restore")?, (save(py, &loaded.simulation, &loaded.scene)?,)))
    }

    #[classmethod]
    fn _restore(class: &Bound<'_, PyType>, saved: Saved<'_>) -> PyResult<Self> {
        Ok(Self { loaded: Mutex::new(saved.restore(class.py())?) })
    }

    /// Returns an independent copy.
    fn __deepcopy__(&self, memo: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.__copy__(memo.py())
    }

    fn __repr__(&self) -> PyResult<String> {
        let simulation = &lock(&self.loaded)?.simulation;
        let (events, time_s) = (simulation.events().len(), simulation.time_s());
        Ok(format!("<phalanx.Simulation at {time_s:?} s, {events} events>"))
    }
}

/// One quantity for all simulations, or one for each.
#[derive(FromPyObject)]
enum Numbers<'py> {
    One(f64),
    Text(Bound<'py, PyString>),
    Each(Vec<f64>),
    EachText(Vec<Bound<'py, PyAny>>),
}

/// Many simulations that advance together on all cores, with arrays as inputs and outputs.
///
/// scenes: one scene for each simulation; `[scene] * 100` gives 100 equal simulations. A simulation that fails keeps
/// the time of its failure, and the others continue. preset: see `Simulation`. After `os.fork`, a batch can also
/// advance in the child process.
#[pyclass(frozen, module = "phalanx")]
pub struct SimulationBatch {
    loaded: Mutex<LoadedBatch>,
    model: Model,
}

/// Simulations, their starts and their scenes.
struct LoadedBatch {
    simulations: Vec<trace::Simulation>,
    starts: Vec<trace::Simulation>,
    scenes: Vec<Py<Scene>>,
}

impl LoadedBatch {
    fn new(py: Python<'_>, scenes: Vec<Py<Scene>>, model: Model) -> PyResult<Self> {
        let validated: Vec<_> = scenes.iter().map(|scene| scene.get().scene.clone()).collect();
        let simulations = py.detach(|| batch::create(&validated, model)).map_err(|(index, error)| {
            let message = format!("simulation {index}: {error}");
            errors::run(py, message, None)
        })?;
        Ok(Self { starts: simulations.clone(), simulations, scenes })
    }
}

#[pymethods]
impl SimulationBatch {
    #[new]
    #[pyo3(signature = (scenes, model = "analytic", *, preset = None))]
    fn new(py: Python<'_>, scenes: Vec<SceneLike>, model: &str, preset: Option<&str>) -> PyResult<Self> {
        let model = self::model(py, model)?;
        let scenes = scenes.into_iter().map(|scene| with_preset(py, scene, model, preset));
        let scenes = scenes.collect::<PyResult<Vec<_>>>()?;
        Ok(Self { loaded: Mutex::new(LoadedBatch::new(py, scenes, model)?), model })
    }

    /// Advances all simulations by a duration, s. Ctrl-C interrupts, after which only a `state` can be continued.
    fn advance(&self, py: Python<'_>, duration: &Bound<'_, PyAny>) -> PyResult<()> {
        let duration_s = conversion::quantity(py, "duration", duration, Dimension::Time)?;
        let simulations = &mut lock(&self.loaded)?.simulations[..];
        interruptible::run(py, |keep_running| batch::advance(simulations, duration_s, keep_running))?
            .map_err(|error| exception(py, &error))
    }

    /// Returns all simulations, or those with these indices, to the start of their scenes.
    ///
    /// seed: has no effect, because nothing in a simulation is random; see `Simulation.reset`. Raises IndexError for an
    /// index without a simulation; all simulations are then unchanged.
    #[pyo3(signature = (seed = None, indices = None))]
    fn reset(&self, seed: Option<&Bound<'_, PyAny>>, indices: Option<Vec<i128>>) -> PyResult<()> {
        let _ = seed;
        let LoadedBatch { simulations, starts, .. } = &mut *lock(&self.loaded)?;
        let count = simulations.len();
        let indices = indices.map_or_else(|| Ok((0..count).collect()), |indices| check_indices(&indices, count))?;
        indices.into_iter().for_each(|index| simulations[index].clone_from(&starts[index]));
        Ok(())
    }

    /// Returns the present values of some columns as a new array of float64 with shape (len(batch), len(columns)), in their
    /// order and units.
    ///
    /// Raises KeyError for an unknown column, with a similar one.
    fn observe<'py>(&self, py: Python<'py>, columns: Vec<String>) -> PyResult<Bound<'py, PyAny>> {
        let simulations = &mut lock(&self.loaded)?.simulations[..];
        let rows = py.detach(|| batch::observe(simulations, &columns));
        let rows = rows.map_err(|error| PyKeyError::new_err(error.to_string()))?;
        conversion::vector(py, &rows.concat())?.call_method1("reshape", ((rows.len(), columns.len()),))
    }

    /// Present time of each simulation, s.
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let times = lock(&self.loaded)?.simulations.iter().map(trace::Simulation::time_s).collect();
        columns::number_array(py, &columns::array_of_numbers(times))
    }

    /// Returns the present values of a column, one for each simulation, such as `batch["q11_rad"]`.
    fn __getitem__<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Bound<'py, PyAny>> {
        let simulations = &mut lock(&self.loaded)?.simulations[..];
        let values = py.detach(|| batch::read(simulations, column));
        let values = values.map_err(|error| PyKeyError::new_err(error.to_string()))?;
        columns::number_array(py, &columns::array_of_numbers(values))
    }

    /// Sets the torque of an actuator in all simulations, N·m (of a prismatic joint: the force, N; of an electric motor: the
    /// voltage, V): one number, or one for each. Simulations that have failed ignore it.
    fn set_torque(&self, py: Python<'_>, actuator: &str, torque: Numbers<'_>) -> PyResult<()> {
        self.set_each(py, actuator, ("torque", torque, EFFORT), |simulation, torque| {
            simulation.set_torque(actuator, torque)
        })
    }

    /// Sets the target of a servo in all simulations, rad or m: one number, or one for each. Simulations that have
    /// failed ignore it.
    fn set_target(&self, py: Python<'_>, actuator: &str, target: Numbers<'_>) -> PyResult<()> {
        self.set_each(py, actuator, ("target", target, TARGET), |simulation, target| {
            simulation.set_target(actuator, target, 0.0)
        })
    }

    /// Contact events of each simulation so far, as `phalanx.Event`.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Vec<Vec<Bound<'py, PyAny>>>> {
        let simulations = &lock(&self.loaded)?.simulations;
        let events =
            |simulation: &trace::Simulation| event_list(py, named_events(simulation.schema(), simulation.events()));
        simulations.iter().map(events).collect()
    }

    /// Reason of the failure of each simulation; None if it can advance.
    #[getter]
    fn failures(&self, py: Python<'_>) -> PyResult<Vec<Option<String>>> {
        let simulations = &lock(&self.loaded)?.simulations;
        let message = |simulation: &trace::Simulation| simulation.failure().map(ToString::to_string);
        let messages = simulations.iter().map(message);
        messages.map(|message| message.map(|message| errors::in_python(py, message)).transpose()).collect()
    }

    /// States of all simulations, for `restore`.
    #[getter]
    fn states(&self, py: Python<'_>) -> PyResult<Vec<SimulationState>> {
        let loaded = lock(&self.loaded)?;
        let state = |(saved, scene): (&trace::Simulation, &Py<Scene>)| SimulationState {
            simulation: Mutex::new(saved.clone()),
            scene: scene.clone_ref(py),
        };
        Ok(loaded.simulations.iter().zip(&loaded.scenes).map(state).collect())
    }

    /// Restores the states of the simulations with these indices; `states` has one for each.
    ///
    /// Raises IndexError for an index without a simulation, and SceneError for a state of another scene or model; all
    /// simulations are then unchanged.
    fn restore(&self, py: Python<'_>, indices: Vec<i128>, states: Vec<Bound<'_, SimulationState>>) -> PyResult<()> {
        let LoadedBatch { simulations, scenes, .. } = &mut *lock(&self.loaded)?;
        let indices = check_indices(&indices, simulations.len())?;
        if indices.len() != states.len() {
            let (indices, states) = (indices.len(), states.len());
            let message = format!("there are {indices} indices, but {states} states; give one state for each index");
            return Err(PyIndexError::new_err(message));
        }
        let copy = |(index, state): (&usize, &Bound<'_, SimulationState>)| {
            Ok((*index, lock(&state.get().simulation)?.clone()))
        };
        let saved = indices.iter().zip(&states).map(copy).collect::<PyResult<Vec<_>>>()?;
        batch::restore(simulations, &saved).map_err(|error| exception(py, &error))?;
        indices.iter().zip(&states).for_each(|(index, state)| scenes[*index] = state.get().scene.clone_ref(py));
        Ok(())
    }

    /// Supports pickling. The runs are repeated, on all cores, when the batch is read.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py, (SavedBatch<'py>,)>> {
        let (py, loaded) = (slf.py(), lock(&slf.get().loaded)?);
        let saved =
            loaded.simulations.iter().zip(&loaded.scenes).map(|(simulation, scene)| save(py, simulation, scene));
        let saved = saved.collect::<PyResult<Vec<_>>>()?;
        Ok((py.get_type::<Self>().getattr("_restore")?, ((slf.get().model.name().to_string(), saved),)))
    }

    #[classmethod]
    fn _restore(class: &Bound<'_, PyType>, saved: SavedBatch<'_>) -> PyResult<Self> {
        let (py, (model, saved)) = (class.py(), saved);
        let (model, scenes) = (self::model(py, &model)?, saved.iter().map(|saved| saved.scene.clone_ref(py)).collect());
        let mut loaded = LoadedBatch::new(py, scenes, model)?;
        let actions: Vec<_> = saved.iter().map(Saved::actions).collect();
        let simulations = &mut loaded.simulations[..];
        interruptible::run(py, |keep_running| batch::repeat(simulations, &actions, keep_running))?
            .map_err(|error| exception(py, &error))?;
        saved.iter().zip(&loaded.simulations).try_for_each(|(saved, simulation)| saved.check(py, simulation))?;
        Ok(Self { loaded: Mutex::new(loaded), model })
    }

    fn __len__(&self) -> PyResult<usize> {
        Ok(lock(&self.loaded)?.simulations.len())
    }
}

impl SimulationBatch {
    fn set_each(
        &self,
        py: Python<'_>,
        actuator: &str,
        (name, values, dimensions): (&str, Numbers<'_>, [Dimension; 2]),
        set: impl Fn(&mut trace::Simulation, f64) -> Result<(), SimulationError> + Send + Sync,
    ) -> PyResult<()> {
        let simulations = &mut lock(&self.loaded)?.simulations[..];
        let read = |(simulation, value): (&trace::Simulation, &Bound<'_, PyAny>)| {
            read_input(py, simulation, actuator, (name, value), dimensions)
        };
        let check_count = |given: usize| {
            let count = simulations.len();
            let message = format!("there are {count} simulations, but {given} values of {name}");
            if given == count { Ok(()) } else { Err(errors::argument(py, message)) }
        };
        let values = match values {
            Numbers::One(value) => vec![value; simulations.len()],
            Numbers::Text(text) => {
                simulations.iter().map(|simulation| read((simulation, text.as_any()))).collect::<PyResult<_>>()?
            }
            Numbers::Each(values) => check_count(values.len()).map(|()| values)?,
            Numbers::EachText(values) => {
                check_count(values.len())?;
                simulations.iter().zip(&values).map(read).collect::<PyResult<_>>()?
            }
        };
        py.detach(|| batch::set(simulations, &values, set)).map_err(|error| exception(py, &error))
    }
}

/// Checks indices of simulations.
fn check_indices(indices: &[i128], count: usize) -> PyResult<Vec<usize>> {
    let check = |index: &i128| {
        let valid = usize::try_from(*index).ok().filter(|index| *index < count);
        let message = || format!("there is no simulation {index}; indices are from 0 and below {count}");
        valid.ok_or_else(|| PyIndexError::new_err(message()))
    };
    indices.iter().map(check).collect()
}

//! The classes `Simulation` and `SimulationBatch`: simulations that Python advances.

use std::sync::{Mutex, MutexGuard};

use phalanx::study::batch;
use phalanx::trace::schema::{Subject, SubjectKind};
use phalanx::trace::{self, Event, Schema, SimulationError};
use pyo3::exceptions::{PyIndexError, PyKeyError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::result::model;
use super::scene::SceneLike;
use super::{columns, errors, interruptible};

/// Converts an error of a simulation.
fn exception(py: Python<'_>, error: &SimulationError) -> PyErr {
    match error {
        SimulationError::Input(message) => errors::argument(py, message),
        SimulationError::Rejected(message) => errors::run(py, message, None),
        SimulationError::Failed(failure) => errors::failure(py, error, failure.time_s),
    }
}

/// Returns events as `phalanx.Event`.
pub fn event_list<'py>(py: Python<'py>, schema: &Schema, events: &[Event]) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let class = py.import("phalanx.events")?.getattr("Event")?;
    let to_python = |event: &Event| {
        let contact = schema.contacts.get(event.contact);
        let name = contact.map_or("", |contact| contact.name.as_str());
        class.call1((event.time_s, name, event.kind.name(), event.approach_speed, event.impulse))
    };
    events.iter().map(to_python).collect()
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

/// A scene that the caller advances: a controller in the loop.
///
/// `simulation = phalanx.Simulation("scene.toml")`, `simulation.advance(1e-4)`, `simulation["q11_rad"]`,
/// `simulation.set_torque("motor", 0.48)`. model: "analytic" or "engine". Between two calls the model takes its own steps
/// and locates its events; results of the analytic model do not depend on how the time is divided (in the engine model, by
/// up to 4e-6 rad in 1,000 pieces). The duration of the scene is not its end.
///
/// `copy.copy(simulation)` and `state` continue with the same bits. Raises SceneError for an invalid scene, and RunError
/// if the model does not simulate it.
#[pyclass(frozen, module = "phalanx")]
pub struct Simulation {
    simulation: Mutex<trace::Simulation>,
}

impl Simulation {
    fn from_simulation(simulation: trace::Simulation) -> Self {
        Self { simulation: Mutex::new(simulation) }
    }
}

/// State of a `Simulation`, from which it can continue.
#[pyclass(frozen, module = "phalanx._phalanx")]
pub struct SimulationState {
    simulation: Mutex<trace::Simulation>,
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (scene, model = "analytic"))]
    fn new(py: Python<'_>, scene: SceneLike, model: &str) -> PyResult<Self> {
        let model = self::model(py, model)?;
        let simulation = trace::Simulation::new(&scene.get(py)?.scene, model);
        simulation.map(Self::from_simulation).map_err(|error| exception(py, &error))
    }

    /// Advances by a duration, s.
    ///
    /// Raises RunError with its `time_s` if the model cannot advance further; the simulation is then at that time.
    /// Other Python threads continue; Ctrl-C interrupts, after which only a `state` can be continued.
    fn advance(&self, py: Python<'_>, duration: f64) -> PyResult<()> {
        let mut simulation = lock(&self.simulation)?;
        let time_s = simulation.time_s() + duration;
        advance(py, &mut simulation, time_s)
    }

    /// Advances to a time, s; see `advance`.
    fn advance_to(&self, py: Python<'_>, time: f64) -> PyResult<()> {
        advance(py, &mut *lock(&self.simulation)?, time)
    }

    /// Present time, s.
    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(lock(&self.simulation)?.time_s())
    }

    /// Returns the present value of a column, such as `simulation["q11_rad"]`.
    ///
    /// `columns` lists the names. Units: angles rad, rates rad/s, forces N, torques N·m, lengths m, energies J.
    fn __getitem__(&self, column: &str) -> PyResult<f64> {
        let value = lock(&self.simulation)?.get(column);
        value.map_err(|error| PyKeyError::new_err(error.to_string()))
    }

    /// Names of all columns with their units: `time_s` first, the energies last.
    #[getter]
    fn columns(&self) -> PyResult<Vec<String>> {
        Ok(lock(&self.simulation)?.channels().iter().map(|channel| channel.name.clone()).collect())
    }

    /// Present values by contact, each with the keys of its columns: `simulation.contacts["distal"]["normal_n"]`.
    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (simulation, contacts) = (lock(&self.simulation)?, PyDict::new(py));
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
        let simulation = lock(&self.simulation)?;
        event_list(py, simulation.schema(), simulation.events())
    }

    /// Names of the actuators with a torque or a force as input.
    #[getter]
    fn torque_inputs(&self) -> PyResult<Vec<String>> {
        Ok(lock(&self.simulation)?.torque_inputs().map(str::to_string).collect())
    }

    /// Names of the actuators with a target as input.
    #[getter]
    fn target_inputs(&self) -> PyResult<Vec<String>> {
        Ok(lock(&self.simulation)?.target_inputs().map(str::to_string).collect())
    }

    /// Sets the torque of an actuator, N·m (of a prismatic joint: the force, N), from now on.
    ///
    /// Raises SceneError that lists the actuators if the name is wrong.
    fn set_torque(&self, py: Python<'_>, actuator: &str, torque: f64) -> PyResult<()> {
        lock(&self.simulation)?.set_torque(actuator, torque).map_err(|error| exception(py, &error))
    }

    /// Sets the target of a servo, rad or m, from now on; it moves at a rate, rad/s or m/s. The set point of a servo with a
    /// `target_rate` follows it from its present value, at most at that rate.
    ///
    /// Raises SceneError that lists the actuators if the name is wrong.
    #[pyo3(signature = (actuator, target, rate = 0.0))]
    fn set_target(&self, py: Python<'_>, actuator: &str, target: f64, rate: f64) -> PyResult<()> {
        lock(&self.simulation)?.set_target(actuator, target, rate).map_err(|error| exception(py, &error))
    }

    /// The whole state. Assigning it, also to another simulation of the same scene and model, continues from there with the
    /// same bits; a state of another scene or model raises SceneError. States belong to the process and cannot be pickled.
    #[getter]
    fn state(&self) -> PyResult<SimulationState> {
        Ok(SimulationState { simulation: Mutex::new(lock(&self.simulation)?.clone()) })
    }

    #[setter]
    fn set_state(&self, py: Python<'_>, state: &Bound<'_, SimulationState>) -> PyResult<()> {
        let saved = lock(&state.get().simulation)?;
        lock(&self.simulation)?.restore(&saved).map_err(|error| exception(py, &error))
    }

    /// Returns an independent copy.
    fn __copy__(&self) -> PyResult<Self> {
        Ok(Self::from_simulation(lock(&self.simulation)?.clone()))
    }

    /// Returns an independent copy.
    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.__copy__()
    }

    fn __repr__(&self) -> PyResult<String> {
        let simulation = lock(&self.simulation)?;
        let (events, time_s) = (simulation.events().len(), simulation.time_s());
        Ok(format!("<phalanx.Simulation at {time_s:?} s, {events} events>"))
    }
}

/// One number for all simulations, or one for each.
#[derive(FromPyObject)]
enum Numbers {
    One(f64),
    Each(Vec<f64>),
}

/// Many simulations that advance together on all cores, with arrays as inputs and outputs.
///
/// scenes: one scene for each simulation; `[scene] * 100` gives 100 equal ones. A simulation that fails stays at the time
/// of its failure, and the others continue. After `os.fork`, a batch also advances in the child process.
#[pyclass(frozen, module = "phalanx")]
pub struct SimulationBatch {
    simulations: Mutex<Vec<trace::Simulation>>,
}

#[pymethods]
impl SimulationBatch {
    #[new]
    #[pyo3(signature = (scenes, model = "analytic"))]
    fn new(py: Python<'_>, scenes: Vec<SceneLike>, model: &str) -> PyResult<Self> {
        let model = self::model(py, model)?;
        let scenes = scenes.iter().map(|scene| Ok(scene.get(py)?.scene)).collect::<PyResult<Vec<_>>>()?;
        let simulations = py.detach(|| batch::create(&scenes, model)).map_err(|(index, error)| {
            let message = format!("simulation {index}: {error}");
            errors::run(py, message, None)
        })?;
        Ok(Self { simulations: Mutex::new(simulations) })
    }

    /// Advances all simulations by a duration, s. Ctrl-C interrupts, after which only a `state` can be continued.
    fn advance(&self, py: Python<'_>, duration: f64) -> PyResult<()> {
        let mut simulations = lock(&self.simulations)?;
        let simulations = &mut simulations[..];
        interruptible::run(py, |keep_running| batch::advance(simulations, duration, keep_running))?
            .map_err(|error| exception(py, &error))
    }

    /// Present time of each simulation, s.
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let times = lock(&self.simulations)?.iter().map(trace::Simulation::time_s).collect();
        columns::number_array(py, &columns::array_of_numbers(times))
    }

    /// Returns the present values of a column, one for each simulation, such as `batch["q11_rad"]`.
    fn __getitem__<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Bound<'py, PyAny>> {
        let mut simulations = lock(&self.simulations)?;
        let simulations = &mut simulations[..];
        let values = py.detach(|| batch::read(simulations, column));
        let values = values.map_err(|error| PyKeyError::new_err(error.to_string()))?;
        columns::number_array(py, &columns::array_of_numbers(values))
    }

    /// Sets the torque of an actuator in all simulations, N·m (of a prismatic joint: the force, N): one number, or one
    /// for each. Simulations that have failed ignore it.
    fn set_torque(&self, py: Python<'_>, actuator: &str, torque: Numbers) -> PyResult<()> {
        self.set_each(py, "torque", torque, |simulation, torque| simulation.set_torque(actuator, torque))
    }

    /// Sets the target of a servo in all simulations, rad or m: one number, or one for each. Simulations that have
    /// failed ignore it.
    fn set_target(&self, py: Python<'_>, actuator: &str, target: Numbers) -> PyResult<()> {
        self.set_each(py, "target", target, |simulation, target| simulation.set_target(actuator, target, 0.0))
    }

    /// Contact events of each simulation so far, as `phalanx.Event`.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Vec<Vec<Bound<'py, PyAny>>>> {
        let simulations = lock(&self.simulations)?;
        simulations.iter().map(|simulation| event_list(py, simulation.schema(), simulation.events())).collect()
    }

    /// Reason of the failure of each simulation; None if it can advance.
    #[getter]
    fn failures(&self) -> PyResult<Vec<Option<String>>> {
        let simulations = lock(&self.simulations)?;
        Ok(simulations.iter().map(|simulation| simulation.failure().map(ToString::to_string)).collect())
    }

    /// States of all simulations, for `restore`.
    #[getter]
    fn states(&self) -> PyResult<Vec<SimulationState>> {
        let simulations = lock(&self.simulations)?;
        Ok(simulations.iter().map(|saved| SimulationState { simulation: Mutex::new(saved.clone()) }).collect())
    }

    /// Restores the states of the simulations with these indices; `states` has one for each.
    ///
    /// Raises IndexError for an index without a simulation, and SceneError for a state of another scene or model; all
    /// simulations are then unchanged.
    fn restore(&self, py: Python<'_>, indices: Vec<i128>, states: Vec<Bound<'_, SimulationState>>) -> PyResult<()> {
        let mut simulations = lock(&self.simulations)?;
        let count = simulations.len();
        let is_index = |index: &i128| usize::try_from(*index).is_ok_and(|index| index < count);
        if indices.len() != states.len() || !indices.iter().all(is_index) {
            let (indices, states) = (indices.len(), states.len());
            return Err(PyIndexError::new_err(format!(
                "{indices} indices and {states} states for {count} simulations; give one state for each index from 0 and below {count}"
            )));
        }
        let copy = |(index, state): (&i128, &Bound<'_, SimulationState>)| {
            Ok((*index as usize, lock(&state.get().simulation)?.clone()))
        };
        let states = indices.iter().zip(&states).map(copy).collect::<PyResult<Vec<_>>>()?;
        batch::restore(&mut simulations, &states).map_err(|error| exception(py, &error))
    }

    fn __len__(&self) -> PyResult<usize> {
        Ok(lock(&self.simulations)?.len())
    }
}

impl SimulationBatch {
    fn set_each(
        &self,
        py: Python<'_>,
        name: &str,
        values: Numbers,
        set: impl Fn(&mut trace::Simulation, f64) -> Result<(), SimulationError> + Send + Sync,
    ) -> PyResult<()> {
        let mut simulations = lock(&self.simulations)?;
        let values = match values {
            Numbers::One(value) => vec![value; simulations.len()],
            Numbers::Each(values) if values.len() == simulations.len() => values,
            Numbers::Each(values) => {
                let (given, count) = (values.len(), simulations.len());
                return Err(errors::argument(
                    py,
                    format!("there are {count} simulations, but {given} values of {name}"),
                ));
            }
        };
        let simulations = &mut simulations[..];
        py.detach(|| batch::set(simulations, &values, set)).map_err(|error| exception(py, &error))
    }
}

//! Simulations that advance together, on all cores.

use rayon::prelude::*;

use crate::scene::Scene;
use crate::trace::{Action, Model, Simulation, SimulationError};
use phalanx_parallel::on_all_cores;

/// Creates one simulation for each scene.
///
/// # Errors
/// Returns the index of a scene that the model cannot simulate, and the reason.
pub fn create(scenes: &[Scene], model: Model) -> Result<Vec<Simulation>, (usize, SimulationError)> {
    let create = |(index, scene)| Simulation::new(scene, model).map_err(|error| (index, error));
    on_all_cores(|| scenes.par_iter().enumerate().map(create).collect())
}

/// Advances all simulations by a duration, s, as long as `keep_running` returns true. A simulation that has failed
/// keeps its time.
///
/// # Errors
/// Returns an error if the duration is negative or not finite.
pub fn advance(
    simulations: &mut [Simulation],
    duration_s: f64,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<(), SimulationError> {
    each(simulations, |_, simulation| simulation.advance_while(simulation.time_s() + duration_s, &|| keep_running()))
}

/// Returns, for each simulation, the number of its sample in the column with this name.
///
/// # Errors
/// See [`Simulation::get`].
pub fn read(simulations: &mut [Simulation], column: &str) -> Result<Vec<f64>, SimulationError> {
    on_all_cores(|| simulations.par_iter_mut().map(|simulation| simulation.get(column)).collect())
}

/// Returns, for each simulation, numbers of its sample in the order of `columns`.
///
/// # Errors
/// See [`Simulation::get`].
pub fn observe(simulations: &mut [Simulation], columns: &[String]) -> Result<Vec<Vec<f64>>, SimulationError> {
    on_all_cores(|| simulations.par_iter_mut().map(|simulation| simulation.observe(columns)).collect())
}

/// Repeats the actions of other simulations on new simulations; see [`Simulation::repeat`]. `actions` contains one list
/// for each simulation.
///
/// # Errors
/// See [`Simulation::repeat`].
pub fn repeat(
    simulations: &mut [Simulation],
    actions: &[Vec<Action>],
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<(), SimulationError> {
    each(simulations, |index, simulation| simulation.repeat(&actions[index], &|| keep_running()))
}

/// Restores states of simulations, each given with the index of its simulation.
///
/// # Errors
/// Returns an error if a state belongs to another scene or model. No simulation is changed then.
///
/// # Panics
/// Panics if an index is out of range.
pub fn restore(simulations: &mut [Simulation], states: &[(usize, Simulation)]) -> Result<(), SimulationError> {
    states.iter().try_for_each(|(index, state)| simulations[*index].check_state(state))?;
    states.iter().try_for_each(|(index, state)| simulations[*index].restore(state))
}

/// Sets an input of each simulation with a function such as [`Simulation::set_torque`]. `values` contains one value for
/// each simulation.
///
/// # Errors
/// See [`Simulation::set_torque`]. A simulation that has failed does not cause an error.
pub fn set(
    simulations: &mut [Simulation],
    values: &[f64],
    set: impl Fn(&mut Simulation, f64) -> Result<(), SimulationError> + Sync,
) -> Result<(), SimulationError> {
    each(simulations, |index, simulation| set(simulation, values[index]))
}

/// Applies a function to all simulations; failures of the models are no errors.
fn each(
    simulations: &mut [Simulation],
    apply: impl Fn(usize, &mut Simulation) -> Result<(), SimulationError> + Sync,
) -> Result<(), SimulationError> {
    let apply = |(index, simulation)| match apply(index, simulation) {
        Err(SimulationError::Failed(_)) => Ok(()),
        result => result,
    };
    on_all_cores(|| simulations.par_iter_mut().enumerate().try_for_each(apply))
}

//! Grippers with stiction, against an independent program.

use phalanx::trace::{Event, Model, Outcome, Sample, Sink, SinkError, run};

use super::gripper::{GripperModel, assert_impulses, max_error, run_engineering, run_reference, sample_times};
use crate::support::reference_cases::{cases_with_stiction, reference_case};

/// Capacity of the model for coordinates, including the internal states of bristles.
const MAX_COORDINATES: usize = 16;

/// Contacts that may have bristles. The reference cases list the two brakes after them; the second brake has an entry
/// even if one motor drives both fingers.
const BRISTLE_CONTACTS: [usize; 6] = [0, 1, 3, 4, 6, 7];

/// Relaxation times of contacts and brakes in the reference cases, s. The deflection is σ times the relaxation time.
const RELAXATION_S: [f64; 8] = [1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 2e-4, 2e-4];

#[test]
fn reference_preset_agrees_with_an_independent_program() {
    for case in cases_with_stiction() {
        let (samples, end) = run_reference::<MAX_COORDINATES>(&case.scene, sample_times(&case));
        let max_error = max_error(&case, &samples.states);
        assert!(max_error < 2e-9, "{}: {max_error:.1e}", case.name);
        let (model, system) = (GripperModel::<MAX_COORDINATES>::new(&case.scene.system), &case.scene.system);
        let brakes = if system.differential.is_some() { [0, 2] } else { [0, 1] };
        let bristle_states = BRISTLE_CONTACTS.map(|contact| model.bristle_index(contact)).into_iter();
        let bristle_states = bristle_states.chain(brakes.map(|drive| model.brake_bristle_index(drive)));
        for (index, ((expected, relaxation), bristle_state)) in
            case.bristle_deflection.into_iter().zip(RELAXATION_S).zip(bristle_states).enumerate()
        {
            let bristle_deflection = relaxation * bristle_state.map_or(0.0, |bristle_state| end.state.v[bristle_state]);
            assert!(
                (bristle_deflection - expected).abs() < 1e-6 * expected.abs() + 1e-14,
                "{}: {index}: {bristle_deflection:e}",
                case.name
            );
        }
        assert_impulses(&case, &end);
    }
}

#[test]
fn engineering_preset_is_close_to_the_independent_program() {
    for case in cases_with_stiction() {
        let (samples, _) = run_engineering::<MAX_COORDINATES>(&case.scene, sample_times(&case));
        let max_error = max_error(&case, &samples.states);
        assert!(max_error < 5e-7, "{}: {max_error:.1e}", case.name);
    }
}

/// Counts the samples of a log.
#[derive(Default)]
struct SampleCounter(usize);

impl Sink for SampleCounter {
    fn sample(&mut self, _: &Sample) -> Result<(), SinkError> {
        self.0 += 1;
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Holding an object for a minute costs little more than the closing. With the regularised friction of the thesis the
/// object creeps by more than 0.5 mm; with bristles only the creep of the normal law remains, less than a fifth of
/// that.
#[test]
fn holding_for_a_minute_takes_few_steps_and_samples() {
    let run_one_minute = |letter: &str| -> (Outcome, usize) {
        let mut scene = reference_case(letter).scene;
        scene.duration_s = 60.0;
        let mut count = SampleCounter::default();
        (run(Model::Analytic, &scene, &mut count).unwrap_or_else(|error| panic!("{letter}: {error}")), count.0)
    };
    let displacement_m = |outcome: &Outcome| (outcome.last.body(0).centre_m[1] - 0.02).abs();
    let [(regularised, _), (bristle, samples)] = ["a", "g"].map(run_one_minute);
    assert!(displacement_m(&regularised) > 0.5e-3, "{:?}", regularised.last.bodies());
    assert!(displacement_m(&bristle) < 0.1e-3, "{:?}", bristle.last.bodies());
    assert!(bristle.last.body(0).velocity_m_s[1].abs() < 1e-6, "{:?}", bristle.last.bodies());
    assert!(bristle.work.steps < 1000 && samples < 2000, "{} steps, {samples} samples", bristle.work.steps);
}

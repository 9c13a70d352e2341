//! Grippers whose friction holds, against an independent program.

use phalanx::trace::{Event, Model, Outcome, Sample, Sink, SinkError, run};

use super::gripper::{GripperModel, assert_impulses, everyday, off, reference, times};
use crate::support::grippers::{anchor, held};

/// Coordinates that there is room for, with memories.
const HELD: usize = 16;

/// The contacts that may have bristles; behind them the anchors have both brakes, the second one also where one input drives both fingers.
const PLACES: [usize; 6] = [0, 1, 3, 4, 6, 7];

/// Relaxation times of contacts and brakes in the anchors: stretch is σ times that.
const RELAXATION_S: [f64; 8] = [1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 2e-4, 2e-4];

#[test]
fn the_reference_agrees_with_an_independent_program() {
    for anchor in held() {
        let (found, end) = reference::<HELD>(&anchor.scene, times(&anchor));
        let off = off(&anchor, &found.states);
        assert!(off < 2e-9, "{}: {off:.1e}", anchor.name);
        let (model, system) = (GripperModel::<HELD>::new(&anchor.scene.system), &anchor.scene.system);
        let brakes = if system.differential.is_some() { [0, 2] } else { [0, 1] };
        let memories = PLACES.map(|place| model.memory(place)).into_iter();
        let memories = memories.chain(brakes.map(|drive| model.memory_of_brake(drive)));
        for (slot, ((wanted, relaxation), memory)) in
            anchor.stretch.into_iter().zip(RELAXATION_S).zip(memories).enumerate()
        {
            let stretch = relaxation * memory.map_or(0.0, |memory| end.state.v[memory]);
            assert!((stretch - wanted).abs() < 1e-6 * wanted.abs() + 1e-14, "{}: {slot}: {stretch:e}", anchor.name);
        }
        assert_impulses(&anchor, &end);
    }
}

#[test]
fn the_everyday_preset_is_near_it() {
    for anchor in held() {
        let (found, _) = everyday::<HELD>(&anchor.scene, times(&anchor));
        let off = off(&anchor, &found.states);
        assert!(off < 5e-7, "{}: {off:.1e}", anchor.name);
    }
}

/// Counts what a log would get.
#[derive(Default)]
struct Count(usize);

impl Sink for Count {
    fn sample(&mut self, _: &Sample) -> Result<(), SinkError> {
        self.0 += 1;
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

/// A minute in the hand costs little more than the closing. The thesis' law lets the object go by a millimetre and on; what a bristle
/// leaves is the creep of the normal law, less than a tenth of that.
#[test]
fn a_minute_in_the_hand_is_some_hundred_steps_and_samples() {
    let minute = |letter: &str| -> (Outcome, usize) {
        let mut scene = anchor(letter).scene;
        scene.duration_s = 60.0;
        let mut count = Count::default();
        (run(Model::Analytic, &scene, &mut count).unwrap_or_else(|error| panic!("{letter}: {error}")), count.0)
    };
    let moved = |outcome: &Outcome| (outcome.last.bodies[0].centre_m[1] - 0.02).abs();
    let [(regularised, _), (bristle, samples)] = ["a", "g"].map(minute);
    assert!(moved(&regularised) > 0.5e-3, "{:?}", regularised.last.bodies);
    assert!(moved(&bristle) < 0.1e-3, "{:?}", bristle.last.bodies);
    assert!(bristle.last.bodies[0].velocity_m_s[1].abs() < 1e-6, "{:?}", bristle.last.bodies);
    assert!(bristle.work.steps < 1000 && samples < 2000, "{} steps, {samples} samples", bristle.work.steps);
}

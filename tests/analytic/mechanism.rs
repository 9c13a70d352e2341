//! The analytic model of mechanisms: reference solutions, Jacobians, the five-bar written out as a mechanism against its
//! closed-form kernel, and random mechanisms.

use phalanx::analytic::mechanism::{MechanismMode, MechanismModel, MechanismSize, event_function_count};
use phalanx::integrator::{
    Method, Observer, Options, Radau5, RadauOrRodas, State, Step, StepTools, Tolerances, integrate_by,
};
use std::f64::consts::TAU;

use super::jacobian::{Entry, Equations};
use crate::support::mechanism_cases::{MechanismCase, all_cases, mechanism_case};

const N: usize = 8;
const K: usize = 3;
const C: usize = 12;
const Z: usize = C + 2;
const G: usize = event_function_count(C);

type Model = MechanismModel<N, K, C>;

/// Largest differences from a reference solution along all its samples, and the touch-downs.
#[derive(Debug, Default)]
struct Difference {
    position_m: f64,
    angle_rad: f64,
    energy_j: f64,
    touches_s: Vec<f64>,
}

/// Compares every step of a run with a reference solution.
struct Comparison<'a> {
    model: &'a Model,
    case: &'a MechanismCase,
    next: usize,
    balance_j: Option<f64>,
    found: Difference,
}

impl Comparison<'_> {
    fn compare(&mut self, state: &State<N, Z>) {
        let sample = &self.case.samples[self.next];
        let (q, v) = (&state.q, &state.v);
        for (body, pose) in sample.poses.iter().enumerate() {
            let ([x, y, angle], _) = self.model.body((q, v), body);
            self.found.position_m = self.found.position_m.max((x - pose[0]).abs()).max((y - pose[1]).abs());
            // Whole turns of bodies in dyads do not follow from the coordinates.
            let turns = ((angle - pose[2]) / TAU).round();
            self.found.angle_rad = self.found.angle_rad.max((angle - pose[2] - TAU * turns).abs());
        }
        let energies = self.model.energies((q, v));
        let balance = energies.kinetic + energies.gravity + energies.spring - state.z[C] - state.z[C + 1];
        let start = *self.balance_j.get_or_insert(balance);
        self.found.energy_j = self.found.energy_j.max((balance - start).abs());
        self.next += 1;
    }
}

impl Observer<N, Z, MechanismMode<C>> for Comparison<'_> {
    fn step(&mut self, step: &Step<N, Z>, _: &MechanismMode<C>, tools: &mut dyn StepTools<N, Z>) -> bool {
        while let Some(sample) = self.case.samples.get(self.next) {
            let theta = (sample.time_s - step.t0) / step.h;
            if theta > 1.0 + 1e-9 {
                break;
            }
            let state = if theta < 1.0 { tools.resolve(theta) } else { *step.end };
            self.compare(&state);
        }
        true
    }

    fn event(&mut self, t: f64, _: &State<N, Z>, index: usize, mode: &MechanismMode<C>) {
        if mode[index].has_force() {
            self.found.touches_s.push(t);
        }
    }
}

fn compare(case: &MechanismCase, method: RadauOrRodas<N, Z>, tolerances: Tolerances) -> Difference {
    let model = Model::new(&case.mechanism, (&case.start.poses, &case.start.rates)).expect("dyads");
    let mut comparison = Comparison { model: &model, case, next: 0, balance_j: None, found: Difference::default() };
    let options = Options { tolerances, max_steps: 1_000_000 };
    let start = model.start::<Z>();
    let end = integrate_by::<N, Z, G, _, _, _>(method, &model, &options, 0.0, start, case.duration_s, &mut comparison);
    end.result.unwrap_or_else(|failure| panic!("{}: {failure}", case.name));
    assert_eq!(comparison.next, case.samples.len(), "{}", case.name);
    comparison.found
}

fn first_touches(case: &MechanismCase) -> impl Iterator<Item = f64> + '_ {
    case.events.iter().filter(|(_, name, rises)| name.ends_with("touch") && *rises).map(|(time, ..)| *time)
}

#[test]
fn reference_solutions_are_met_at_reference_tolerances() {
    let tolerances = Tolerances { atol_q: 1e-14, atol_v: 1e-9, rtol_v: 1e-11 };
    for case in all_cases() {
        let found = compare(&case, Method::new(), tolerances);
        let name = &case.name;
        assert!(found.position_m < 1e-8 && found.angle_rad < 1e-7, "{name}: {found:?}");
        for touch in first_touches(&case) {
            let nearest = found.touches_s.iter().map(|time| (time - touch).abs()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-9, "{name}: touch at {touch} s missed by {nearest:e} s");
        }
        assert!(found.energy_j < 1e-9, "{name}: {found:?}");
    }
}

#[test]
fn everyday_tolerances_are_accurate_to_1e_5() {
    let tolerances = Tolerances { atol_q: 3e-11, atol_v: 3e-7, rtol_v: 3e-7 };
    for case in all_cases() {
        let found = compare(&case, RadauOrRodas::rodas(), tolerances);
        assert!(found.position_m < 1e-6 && found.angle_rad < 1e-5, "{}: {found:?}", case.name);
    }
}

/// Published end values of Andrews' squeezer (IVP test set, 16 digits printed).
#[test]
fn andrews_squeezer_agrees_with_the_published_solution() {
    let case = mechanism_case("a_andrews");
    let model = Model::new(&case.mechanism, (&case.start.poses, &case.start.rates)).expect("dyads");
    let tolerances = Tolerances { atol_q: 1e-14, atol_v: 1e-9, rtol_v: 1e-12 };
    let options = Options { tolerances, max_steps: 1_000_000 };
    let method: Radau5<N, Z> = Method::new();
    let end = integrate_by::<N, Z, G, _, _, _>(method, &model, &options, 0.0, model.start::<Z>(), 0.03, &mut ());
    let published = [
        ("beta", 15.81077119629904),
        ("theta", -15.75637105984298),
        ("gamma", 0.04082224013073101),
        ("phi", -0.5347301163226948),
        ("delta", 0.5244099658805304),
        ("omega", 0.5347301163226948),
        ("epsilon", 1.048080741042263),
    ];
    for (name, value) in published {
        let joint = case.mechanism.joints.iter().position(|joint| joint.name == name).expect("a joint");
        let (found, _) = model.joint((&end.state.q, &end.state.v), joint);
        let turns = ((found - value) / TAU).round();
        assert!((found - value - TAU * turns).abs() < 1e-9 * value.abs().max(1.0), "{name}: {found}, {value}");
    }
}

/// States of a run, for tests of single states.
struct States<'a> {
    model: &'a Model,
    found: Vec<(f64, State<N, Z>, MechanismMode<C>)>,
}

impl Observer<N, Z, MechanismMode<C>> for States<'_> {
    fn step(&mut self, step: &Step<N, Z>, mode: &MechanismMode<C>, _: &mut dyn StepTools<N, Z>) -> bool {
        self.found.push((step.t1, *step.end, *mode));
        self.model.start::<Z>();
        true
    }

    fn event(&mut self, _: f64, _: &State<N, Z>, _: usize, _: &MechanismMode<C>) {}
}

#[test]
fn jacobians_match_differences_along_the_reference_cases() {
    for case in all_cases() {
        let model = Model::new(&case.mechanism, (&case.start.poses, &case.start.rates)).expect("dyads");
        let mut states = States { model: &model, found: Vec::new() };
        let options =
            Options { tolerances: Tolerances { atol_q: 1e-9, atol_v: 1e-5, rtol_v: 1e-5 }, max_steps: 1_000_000 };
        let (method, start) = (RadauOrRodas::rodas(), model.start::<Z>());
        let end = integrate_by::<N, Z, G, _, _, _>(method, &model, &options, 0.0, start, case.duration_s, &mut states);
        end.result.unwrap_or_else(|failure| panic!("{}: {failure}", case.name));
        let stride = states.found.len().div_ceil(40);
        for (t, state, mode) in states.found.into_iter().step_by(stride) {
            // Penetrations limit the differences of positions, slips those of rates.
            let depth = (0..model.contact_count())
                .map(|index| model.contact_reading((&state.q, &state.v), index, mode[index]))
                .filter(|reading| reading.normal > 0.0)
                .map(|reading| reading.delta)
                .fold(1e-2, f64::min);
            let next = <Model as Hybrid<N, Z, G>>::next_discontinuity(&model, t - 2e-5);
            let time_step = if next < t + 2e-5 { 0.0 } else { 1e-5 };
            let steps = [time_step, 0.02 * depth, 1e-3 * (1.0 + state.v.iter().fold(0.0f64, |a, b| a.max(b.abs())))];
            let equations = Equations::<_, N, Z> { system: &model, mode, t, q: state.q, v: state.v };
            let allowed = |entry: &Entry| {
                2e-5 * (entry.row_size + 1e-6 * entry.value.abs() / entry.h) + 1e-7 * entry.largest[1] * entry.h + 1e-7
            };
            equations.check(&case.name, 4, |variable| steps[variable.kind()], allowed);
        }
    }
}

#[test]
fn sizes_and_structure_of_the_reference_cases() {
    let sizes = [("a_andrews", 1, 1), ("b_swinging_slider", 3, 2), ("c_f85_link_pad", 2, 2), ("c_f85_two_disc", 7, 3)];
    for (name, coordinates, group) in sizes {
        let size = MechanismSize::new(&mechanism_case(name).mechanism).expect("dyads");
        assert_eq!((size.coordinates, size.group), (coordinates, group), "{name}");
    }
}

#[test]
fn loops_beyond_dyads_are_refused_by_name() {
    let mut case = mechanism_case("b_four_bar");
    // A brace from the ground to the coupler makes the four-bar rigid.
    let mut brace = case.mechanism.joints[0].clone();
    (brace.name, brace.bodies) = ("brace".to_string(), [None, Some(1)]);
    case.mechanism.joints.push(brace);
    let error = MechanismSize::new(&case.mechanism).unwrap_err().to_string();
    assert!(error.contains("no row of dyads") || error.contains("can move"), "{error}");
}

//! Runs of the engine that cannot continue: cancelled within a solution of many contacts, and numbers that are not finite.

use std::cell::Cell;
use std::fmt::Write;

use phalanx::scene::{Scene, parse_any};
use phalanx::trace::schema::State;
use phalanx::trace::{Event, Model, Outcome, RequiredData, RunError, Sample, Sink, SinkError, run};

/// A sink that is cancelled at one of its checks, and counts the samples and those that are not finite.
#[derive(Default)]
struct Watch {
    checks: Cell<u64>,
    cancelled_at: Option<u64>,
    samples: u64,
    invalid_samples: u64,
}

impl Sink for Watch {
    fn required_data(&self) -> RequiredData {
        RequiredData { joint_forces: false, ..RequiredData::ALL }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.samples += 1;
        let is_finite = sample.time_s.is_finite() && sample.values().iter().all(|value| value.is_finite());
        self.invalid_samples += u64::from(!is_finite);
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        assert!(event.time_s.is_finite() && event.approach_speed.is_finite() && event.impulse.is_finite());
        Ok(())
    }

    fn should_continue(&self) -> bool {
        self.checks.set(self.checks.get() + 1);
        self.cancelled_at.is_none_or(|last| self.checks.get() < last)
    }
}

/// A body with many discs that slides on the ground.
fn many_contacts(count: usize) -> Scene {
    let mut text = "kind = \"mechanism\"\nduration = \"1 ms\"\n[bodies.a]\nmass = \"100 g\"\ninertia = \"1e-2 kg*m^2\"\n\
                    [bodies.a.start]\nat = [\"0 mm\", \"0.9999 mm\"]\nvelocity = [\"0.1 m/s\", \"0 m/s\"]\n\
                    [ground.outlines.floor]\ntype = \"half_plane\"\nnormal = [0, 1]\n\
                    [laws.hard]\ntype = \"hunt_crossley\"\nstiffness = 1e6\nexponent = 1.5\ndamping = \"0.3 s/m\"\n\
                    friction = { mu_static = 0.5, mu_dynamic = 0.4, v_static = \"0.01 m/s\", v_dynamic = \"0.02 m/s\" }\n\
                    [[contacts]]\nbetween = [\"a\", \"ground\"]\nlaw = \"hard\"\n[engine]\nmax_steps = 4\n"
        .to_string();
    for disc in 0..count {
        let outline = format!("[bodies.a.outlines.o{disc}]\ntype = \"disc\"\nradius = \"1 mm\"");
        writeln!(text, "{outline}\ncenter = [\"{disc} mm\", \"0 mm\"]").expect("formatted");
    }
    parse_any(&text, "many.toml").expect("a scene")
}

fn failure(result: Result<Outcome, RunError>) -> (RunError, Outcome) {
    match result {
        Err(RunError::Simulation { failure, partial_outcome }) => {
            let outcome = (*partial_outcome).clone();
            (RunError::Simulation { failure, partial_outcome }, outcome)
        }
        other => panic!("{other:?}"),
    }
}

/// A sub-step with 240 rows solves dozens of linear systems with 5 million multiplications each.
#[test]
fn many_contacts_are_cancelled_within_a_sub_step() {
    let scene = many_contacts(120);
    let mut complete = Watch::default();
    let (_, outcome) = failure(run(Model::Engine, &scene, &mut complete));
    let (checks, substeps) = (complete.checks.get(), outcome.work.contact_substeps);
    assert!(outcome.work.steps == 4 && substeps >= 4, "{:?}", outcome.work);
    assert!(checks > 6 * substeps, "{checks} checks in {substeps} sub-steps");
    for cancelled_at in [1, 2, checks / 3, checks / 2, checks - 3] {
        let mut watch = Watch { cancelled_at: Some(cancelled_at), ..Watch::default() };
        let (error, outcome) = failure(run(Model::Engine, &scene, &mut watch));
        assert!(error.is_stop(), "{error}");
        assert!(outcome.work.steps < 4 && watch.samples <= complete.samples);
        // The solver ends within a few checks.
        let further = watch.checks.get() - cancelled_at;
        assert!(further < 12, "{further} checks after the cancellation at {cancelled_at}");
    }
}

/// A joint with a motor, a spring and a damper, and a ball that falls, with numbers from the whole range.
fn extreme(values: &[&str; 6]) -> String {
    let [mass, inertia, torque, damping, stiffness, gravity] = values;
    format!(
        "kind = \"mechanism\"\nduration = \"1 ms\"\ngravity = [\"0 m/s^2\", \"-{gravity} m/s^2\"]\n\
         [bodies.arm]\nmass = \"{mass} kg\"\ninertia = \"{inertia} kg*m^2\"\ncom = [\"10 mm\", \"0 mm\"]\n\
         [bodies.ball]\nmass = \"{mass} kg\"\ninertia = \"{inertia} kg*m^2\"\n\
         [bodies.ball.start]\nat = [\"100 mm\", \"1.01 mm\"]\nvelocity = [\"0.1 m/s\", \"-1 m/s\"]\n\
         [bodies.ball.outlines.skin]\ntype = \"disc\"\nradius = \"1 mm\"\n\
         [ground.outlines.floor]\ntype = \"half_plane\"\nnormal = [0, 1]\n\
         [joints.j]\nbodies = [\"ground\", \"arm\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"0 rad\"\n\
         damping = \"{damping} N*m*s/rad\"\n[springs.s]\njoint = \"j\"\nstiffness = \"{stiffness} N*m/rad\"\n\
         [actuators.m]\njoint = \"j\"\ntorque = \"{torque} N*m\"\n\
         [laws.hard]\ntype = \"spring_damper\"\nstiffness = {stiffness}\nexponent = 1.0\ndamping = \"1 N*s/m\"\n\
         friction = {{ mu_static = 0.5, mu_dynamic = 0.4, v_static = \"0.01 m/s\", v_dynamic = \"0.02 m/s\" }}\n\
         [[contacts]]\nbetween = [\"ball\", \"ground\"]\nlaw = \"hard\"\n\
         [engine]\nmax_steps = 60\n[integrator]\nmax_steps = 60\n"
    )
}

#[test]
fn numbers_that_are_not_finite_end_a_run_with_their_time() {
    let ranges: [&[&str]; 6] = [
        &["1e-300", "1e-3", "1e6"],
        &["1e-300", "1e-6", "1e12"],
        &["0", "1", "1e12"],
        &["0", "1e24"],
        &["1e3", "1e24"],
        &["9.81", "1e12"],
    ];
    let count: usize = ranges.iter().map(|range| range.len()).product();
    let (mut not_finite, mut others) = (0, 0);
    for case in 0..count {
        let mut rest = case;
        let values = ranges.map(|range| {
            let value = range[rest % range.len()];
            rest /= range.len();
            value
        });
        let scene = match parse_any(&extreme(&values), "extreme.toml") {
            Ok(scene) => scene,
            Err(error) => panic!("{values:?}: {error}"),
        };
        for model in [Model::Engine, Model::Analytic] {
            let mut watch = Watch::default();
            let (last, has_failed) = match run(model, &scene, &mut watch) {
                Err(RunError::Simulation { failure, partial_outcome }) => {
                    assert!(failure.time_s.is_finite() && !failure.reason.to_string().contains("NaN"), "{failure}");
                    let is_reported = failure.reason.to_string().contains("not a finite number");
                    *(if is_reported { &mut not_finite } else { &mut others }) += 1;
                    (partial_outcome.last, true)
                }
                Ok(outcome) => (outcome.last, false),
                Err(error) => panic!("{error}"),
            };
            // The forces of joints are unknown at the end of a run that failed; the analytic model also records that start.
            let is_finite = has_failed || last.values().iter().all(|value| value.is_finite());
            assert!(is_finite, "{values:?} {model:?}: {last:?}");
            assert!(watch.invalid_samples == 0 || model == Model::Analytic && has_failed, "{values:?} {model:?}");
            assert!(last.energy().values().iter().all(|energy| energy.is_finite()), "{values:?} {model:?}");
        }
    }
    println!("{count} scenes in both models: {not_finite} not finite, {others} ended for other reasons");
    assert!(not_finite > 10, "{not_finite}");
}

/// The kinetic energy of this joint is 0 times infinity.
#[test]
fn the_first_number_that_is_not_finite_is_named() {
    let text = "kind = \"mechanism\"\nduration = \"10 ms\"\n[bodies.a]\nmass = \"10 g\"\ninertia = \"1e-300 kg*m^2\"\n\
                [joints.j]\nbodies = [\"ground\", \"a\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\n\
                start = \"0 rad\"\n[actuators.m]\njoint = \"j\"\ntorque = \"1e12 N*m\"\n";
    let scene = parse_any(text, "scene.toml").expect("a scene");
    let (error, outcome) = failure(run(Model::Engine, &scene, &mut Watch::default()));
    let message = error.to_string();
    assert!(message.contains("at t = 0.000000000 s: `j_force_x_n` is not a finite number"), "{message}");
    assert!(outcome.last.values().iter().all(|value| value.is_finite()));
    // A motion that leaves the range of numbers later.
    let text =
        text.replace("1e-300 kg*m^2", "1e-30 kg*m^2").replace("\"10 g\"", "\"10 g\"\ncom = [\"1 mm\", \"0 mm\"]");
    let scene = parse_any(&text, "scene.toml").expect("a scene");
    let mut watch = Watch::default();
    let last = run(Model::Engine, &scene, &mut watch).unwrap_or_else(|error| failure(Err(error)).1).last;
    assert!(last.energy().values().iter().all(|energy| energy.is_finite()));
    assert_eq!(watch.invalid_samples, 0);
}

//! The runs that a check compares, each recorded at even intervals, and the differences of two runs.

use crate::criteria::{Rebound, Rebounds};
use crate::integrator::Reason;
use crate::invariants::EnergyAudit;
use crate::mechanism::{Body, Mechanism, OutlinePoint, OutlineShape, SpringKind};
use crate::numeric::elementary::hypot;
use crate::scene::{Hand, Integrator, Keyword, Method, Scene, Stepping};
use crate::shape::max_radius;
use crate::trace::schema::State;
use crate::trace::{
    self, BodyState, Cancellable, Energy, Event, EventKind, KeepRunning, Model, OffGrid, Outcome, RequiredData,
    RunError, Sample, Schema, Sink, SinkError,
};

/// Radius of the usual object. Comparisons of the two models use it to relate distances to angles.
pub const REFERENCE_LENGTH_M: f64 = 0.02;

/// Number of intervals between points. Errors can appear and vanish within a hundredth of a run.
const INTERVALS: f64 = 256.0;
/// Relative tolerance for equal end times of runs that end early.
const END_TIME_TOLERANCE: f64 = 1e-4;

/// Number of compared angles per finger.
const FINGER_ANGLES: usize = 3;

/// Quantities of a run that are compared with another run.
#[derive(Clone, Debug, Default)]
pub struct Path {
    /// Coordinates at the points of the path.
    pub points: Vec<Vec<f64>>,
    /// Energies at the points of the path; empty if not recorded.
    pub energies: Vec<Energy>,
    /// Coordinates at the end.
    pub last: Vec<f64>,
    /// Times of the first touch-down of each contact, s; `None` without one.
    pub first_s: Vec<Option<f64>>,
    /// Normal force of each contact at the end, N.
    pub normal_n: Vec<f64>,
    pub end_s: f64,
    pub failure: Option<Reason>,
    /// Whether the object left the gripper, which ended the run.
    pub ejected: bool,
    pub energy: Energy,
    /// Rebounds of the contacts of discs; empty in scenes with joints or other outlines.
    pub rebounds: Vec<Rebound>,
    /// Largest speed of a body, m/s.
    pub speed_m_s: f64,
    /// Largest opening of a joint.
    pub loop_gap_m: f64,
    pub audit: Option<EnergyAudit>,
    /// A contact that is deeper than the rounding radii of its outlines; `None` if there is none.
    pub deep_contact: Option<String>,
    /// First overlap of two surfaces whose touch-down was not found: index of the contact, time and depth. If there is
    /// none at the points of the path, an overlap in any step counts, with the time of the end.
    pub unseen_overlap: Option<(usize, f64, f64)>,
    /// Largest overlap of each contact, in m or rad.
    pub depths: Vec<f64>,
    /// Names of the contacts.
    pub contact_names: Vec<String>,
    /// Units of the coordinates. Differences are divided by them.
    pub units: Vec<f64>,
    pub steps: u64,
    pub events: u64,
}

/// Records the path of a run and passes samples and events on.
struct PathRecorder<'a> {
    interval_s: f64,
    points: Vec<Vec<f64>>,
    energies: Vec<Energy>,
    /// Does not depend on whether the run has samples on a grid.
    measured: OffGrid<Measured>,
    touches: Touches,
    sink: &'a mut dyn Sink,
    /// Whether the other sink receives all the data that it uses.
    is_complete: bool,
}

/// Overlap without a touch above which surfaces have passed through each other, m (limit: rad): 1 nm, a hundred times the
/// tolerance of event location in the analytic model. An engine run finds a touch at the end of a step at the latest.
const MAX_UNSEEN_OVERLAP: f64 = 1e-9;

/// Which contacts are in touch according to the events and forces of a run, compared with the overlaps at the points of its
/// path.
#[derive(Default)]
struct Touches {
    /// Whether the surfaces of each contact were apart at an earlier point, and have not touched since.
    apart: Vec<bool>,
    unseen_overlap: Option<(usize, f64, f64)>,
}

impl Touches {
    fn event(&mut self, event: &Event) {
        if let (Some(apart), EventKind::TouchDown) = (self.apart.get_mut(event.contact), event.kind) {
            *apart = false;
        }
    }

    fn point(&mut self, sample: &Sample) {
        self.apart.resize(sample.contacts().count(), false);
        for (index, (contact, apart)) in sample.contacts().zip(&mut self.apart).enumerate() {
            if contact.gap_m > MAX_UNSEEN_OVERLAP {
                *apart = true;
            } else if contact.normal_n > 0.0 {
                // A step with a clamped law has no events.
                *apart = false;
            } else if *apart && contact.gap_m < -MAX_UNSEEN_OVERLAP {
                self.unseen_overlap.get_or_insert((index, sample.time_s, -contact.gap_m));
            }
        }
    }
}

/// What a path contains of all samples and events of a run.
struct Measured {
    /// Audit if energies are recorded.
    audit: Option<EnergyAudit>,
    rebounds: Option<Rebounds>,
    speed_m_s: f64,
}

impl Sink for Measured {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let speeds = sample.bodies().map(|BodyState { velocity_m_s: [x, y], .. }| hypot(x, y));
        self.speed_m_s = speeds.fold(self.speed_m_s, f64::max);
        self.audit.iter_mut().for_each(|audit| audit.record(sample.time_s, &sample.energy()));
        self.rebounds.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.rebounds.event(event)
    }
}

impl PathRecorder<'_> {
    fn push(&mut self, sample: &Sample) {
        if self.points.len() <= INTERVALS as usize {
            self.points.push(coordinates(sample));
            self.energies.extend(self.measured.sink.audit.map(|_| sample.energy()));
        }
    }
}

/// Returns the compared coordinates: angles of fingers or joints of a mechanism, centres of bodies, and angles of the bodies
/// of a mechanism.
fn coordinates(sample: &Sample) -> Vec<f64> {
    let fingers = sample.fingers().flat_map(|finger| [finger.q11_rad, finger.q21_rad, finger.q22_rad]);
    let joints = if sample.counts().fingers == 0 { sample.counts().joints } else { 0 };
    let angles = fingers.chain((0..joints).map(|joint| sample.joint_state(joint).angle_rad));
    let centres = sample.bodies().flat_map(|body| body.centre_m);
    let turns = sample.bodies().map(|body| body.angle_rad);
    angles.chain(centres).chain(turns).collect()
}

impl Sink for PathRecorder<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if self.points.is_empty() {
            self.touches.point(sample);
            self.push(sample);
        }
        self.measured.sample(sample)?;
        self.sink.sample(sample)
    }

    fn point(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.touches.point(sample);
        self.push(sample);
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.measured.event(event)?;
        self.touches.event(event);
        self.sink.event(event)
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sink.extreme(sample)
    }

    fn crossing(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.measured.sample(sample)?;
        self.sink.crossing(sample)
    }

    /// Requires passive angles because points contain them.
    fn required_data(&self) -> RequiredData {
        RequiredData {
            energies: self.measured.sink.audit.is_some(),
            passive: true,
            point_interval_s: self.interval_s,
            ..RequiredData::NONE
        }
        .or(if self.is_complete { self.sink.required_data() } else { RequiredData::NONE })
    }

    fn should_continue(&self) -> bool {
        self.sink.should_continue()
    }
}

impl Path {
    /// Largest difference between the coordinates of two points, in their units.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let differences = a.iter().zip(b).zip(&self.units).map(|((x, y), unit)| (x - y).abs() / unit);
        let largest = differences.fold(0.0, |m: f64, d| if d.is_nan() { d } else { m.max(d) });
        if largest.is_nan() { f64::INFINITY } else { largest }
    }
}

/// Largest difference along the part that both paths have.
pub fn difference(a: &Path, b: &Path) -> f64 {
    a.points.iter().zip(&b.points).map(|(p, q)| a.distance(p, q)).fold(0.0, f64::max)
}

/// Whether both runs reach their end, or both end early at about the same time.
pub fn have_same_end(a: &Path, b: &Path) -> bool {
    (a.failure.is_some(), a.ejected) == (b.failure.is_some(), b.ejected)
        && (a.end_s - b.end_s).abs() <= END_TIME_TOLERANCE * a.end_s.max(b.end_s)
}

/// Errors of a run relative to a reference.
pub fn errors(run: &Path, reference: &Path) -> Errors {
    let differences = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).abs()).collect::<Vec<f64>>();
    let both_end = run.failure.is_none() && reference.failure.is_none();
    let last = if both_end { differences(&run.last, &reference.last) } else { Vec::new() };
    let at_end = if both_end { run.distance(&run.last, &reference.last) } else { 0.0 };
    let first = run.first_s.iter().zip(&reference.first_s).map(|(a, b)| a.zip(*b).map(|(a, b)| (a - b).abs()));
    let restitution = run.rebounds.iter().zip(&reference.rebounds);
    Errors {
        path: difference(run, reference).max(at_end),
        last,
        first_s: first.collect(),
        normal_n: if both_end { differences(&run.normal_n, &reference.normal_n) } else { Vec::new() },
        restitution: restitution.clone().map(|(a, b)| restitution_error(a, b)).collect(),
        rebound: restitution.map(|(a, b)| rebound_error(a, b, run.speed_m_s)).fold(0.0, f64::max),
        energy: energy_error(run, reference),
    }
}

/// Error of a restitution; infinite if only one of the runs has it.
fn restitution_error(a: &Rebound, b: &Rebound) -> Option<f64> {
    match (a.restitution(), b.restitution()) {
        (Some(a), Some(b)) => Some((a - b).abs()),
        (None, None) => None,
        _ => Some(f64::INFINITY),
    }
}

/// Error of a restitution, weighted with the approach speed relative to the largest speed in the run. It is 0 if the
/// run has no restitution; a missing restitution of the reference counts as 0.
fn rebound_error(a: &Rebound, b: &Rebound, speed_m_s: f64) -> f64 {
    let approach_m_s = a.approach_m_s.into_iter().chain(b.approach_m_s).fold(0.0, f64::max);
    let error = a.restitution().map_or(0.0, |a| (a - b.restitution().unwrap_or_default()).abs());
    if error == 0.0 { 0.0 } else { error * (approach_m_s / speed_m_s).min(1.0) }
}

/// Largest difference of an energy or a work, as a fraction of the energy exchanged: at the end, and along the path if
/// the difference persists from one point to the next. Impacts are shorter than an interval, and a small shift of an
/// impact in time makes a large difference of kinetic energy within it.
fn energy_error(run: &Path, reference: &Path) -> f64 {
    let scale_j =
        [run, reference].into_iter().filter_map(|path| path.audit).map(|audit| audit.scale_j()).fold(0.0, f64::max);
    let difference = |(a, b): (&Energy, &Energy)| {
        let pairs = a.values().into_iter().zip(b.values());
        pairs
            .map(|(x, y)| (x - y).abs())
            .fold(0.0, |largest: f64, value| if value.is_nan() { f64::INFINITY } else { largest.max(value) })
    };
    let along: Vec<f64> = run.energies.iter().zip(&reference.energies).map(difference).collect();
    let persistent = along.windows(2).map(|pair| pair[0].min(pair[1])).fold(0.0, f64::max);
    let both_end = run.failure.is_none() && reference.failure.is_none();
    let at_end = if both_end { difference((&run.energy, &reference.energy)) } else { 0.0 };
    let error_j = persistent.max(at_end);
    if error_j == 0.0 { 0.0 } else { error_j / scale_j }
}

/// Estimated errors of the main results of a run. An error is `None` if one or both runs do not have the quantity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// Largest error of a coordinate along the path, rad (object: in radii; scenes without joints: m); infinite without
    /// a comparison.
    pub path: f64,
    /// Errors of the coordinates at the end. They are q11, q21, q22 of every finger or the joints of a mechanism, then
    /// x and y of every body, then the angle of every body.
    pub last: Vec<f64>,
    /// Error of the first touch-down of each contact, s.
    pub first_s: Vec<Option<f64>>,
    /// Error of the normal force of each contact at the end, N.
    pub normal_n: Vec<f64>,
    /// Errors of the restitution of every pair of discs; infinite if only one of the runs has it.
    pub restitution: Vec<Option<f64>>,
    /// Largest error of a restitution, multiplied by the ratio (at most 1) of the approach speed to the largest speed
    /// of the run.
    pub rebound: f64,
    /// Largest error of any energy or work, as a fraction of the energy exchanged in the run.
    pub energy: f64,
}

/// Units of the compared coordinates. Joint angles have the unit 1. The unit of positions is the radius of the object
/// in scenes with fingers, and [`REFERENCE_LENGTH_M`] in a mechanism. Without joints it is 1 m, and the angle of a body
/// counts as the displacement of its outermost point.
pub fn units(scene: &Scene) -> Vec<f64> {
    if let Some(mechanism) = &scene.mechanism {
        let joints = mechanism.joints.iter().map(|joint| match joint.kind.is_angle() {
            true => 1.0,
            false => REFERENCE_LENGTH_M,
        });
        let (unit_m, has_joints) = if scene.has_joints() { (REFERENCE_LENGTH_M, true) } else { (1.0, false) };
        let turn = |body: &Body| if has_joints { 1.0 } else { body.reach_m().map_or(1.0, f64::recip) };
        let centres = mechanism.bodies.iter().flat_map(|_| [unit_m; 2]);
        return joints.chain(centres).chain(mechanism.bodies.iter().map(turn)).collect();
    }
    let hand = &scene.hand;
    let angles = std::iter::repeat_n(1.0, FINGER_ANGLES * hand.fingers.len());
    let object = hand.moving_object().into_iter();
    angles
        .chain(object.flat_map(|object| {
            let radius_m = max_radius(&object.shape);
            [radius_m, radius_m, 1.0]
        }))
        .collect()
}

/// Tolerance of the reference, as a fraction of the run's tolerance.
const TOLERANCE_FACTOR: f64 = 1e-2;
/// Smallest tolerance of the reference.
const MIN_TOLERANCE: f64 = 1e-9;
/// Duration of the reference relative to the end of a run that ended early.
const DURATION_FACTOR: f64 = 1.25;

#[derive(Clone, Copy)]
pub(crate) struct RunOptions<'a> {
    /// Whether to use the reference settings: another method, or smaller steps.
    pub finer: bool,
    /// Relative change of the actuation.
    pub perturbation: f64,
    /// Duration over which the path is sampled.
    pub span_s: f64,
    /// Whether energies are recorded along the path.
    pub energies: bool,
    /// Largest number of steps.
    pub max_steps: u64,
    pub keep_running: KeepRunning<'a>,
}

/// Increases the actuation of a scene by the relative amount `relative_change`. In a gripper, the increase of the left
/// motor torque is half as large, so that the fingers differ. With a differential, its input torque increases, and the
/// object moves to the right by this fraction of its radius. In a mechanism, the actuators and their limits, the
/// springs, gravity, and the rates at the start increase.
pub fn perturbed(scene: &Scene, relative_change: f64) -> Scene {
    let mut scene = scene.clone();
    if let Some(mechanism) = &mut scene.mechanism {
        perturb_mechanism(mechanism, 1.0 + relative_change);
        return scene;
    }
    let Hand { fingers, differential, object, .. } = &mut scene.hand;
    for (finger, part) in fingers.iter_mut().zip([relative_change, 0.5 * relative_change]) {
        finger.motor.actuation = finger.motor.actuation.scaled(1.0 + part);
    }
    if let Some(differential) = differential {
        differential.motor.actuation = differential.motor.actuation.scaled(1.0 + relative_change);
        if let Some(object) = object {
            object.centre_m[0] += relative_change * max_radius(&object.shape);
        }
    }
    scene
}

fn perturb_mechanism(mechanism: &mut Mechanism, factor: f64) {
    mechanism.gravity_m_s2 = mechanism.gravity_m_s2.map(|g| g * factor);
    for actuator in &mut mechanism.actuators {
        let profile = actuator.command.profile_mut();
        *profile = profile.scaled(factor);
        // The force of a servo at its limit does not follow its target.
        actuator.limit.iter_mut().for_each(|limit| *limit *= factor);
    }
    // Springs may be all that drives a mechanism.
    for spring in &mut mechanism.springs {
        spring.stiffness *= factor;
        if let SpringKind::Torsional { preload, .. } = &mut spring.kind {
            *preload *= factor;
        }
    }
    for actuator in mechanism.tendons.iter_mut().filter_map(|tendon| tendon.actuator.as_mut()) {
        actuator.tension = actuator.tension.scaled(factor);
    }
    mechanism.joints.iter_mut().for_each(|joint| joint.start_rate *= factor);
    mechanism.bodies.iter_mut().for_each(|body| body.rate = body.rate.map(|rate| rate * factor));
}

/// Returns the other family of methods at a smaller tolerance.
fn other_method(integrator: &Integrator) -> Integrator {
    let method = match integrator.method {
        Method::Rodas5p => Method::RadauIIa5,
        Method::RadauIIa5 => Method::Rodas5p,
    };
    Integrator { method, ..integrator.with_rtol((TOLERANCE_FACTOR * integrator.rtol).max(MIN_TOLERANCE)) }
}

pub(crate) fn reference_name(scene: &Scene, reference_model: Model) -> String {
    match reference_model {
        Model::Analytic => {
            let integrator = other_method(&scene.integrator);
            format!("the analytic model, {} (rtol {:.0e})", integrator.method.keyword(), integrator.rtol)
        }
        Model::Engine => "the engine with finer steps".to_string(),
    }
}

/// Whether both models use the same contact laws.
pub(crate) fn is_comparable(scene: &Scene) -> bool {
    scene.engine.uses_laws()
}

/// Returns the scene with the settings of a run of a check.
fn configured_scene(scene: &Scene, options: &RunOptions<'_>) -> Scene {
    let mut configured = perturbed(scene, options.perturbation);
    if options.finer {
        configured.integrator = other_method(&scene.integrator);
        configured.engine.stepping = finer_stepping(scene.engine.stepping, options.span_s);
    }
    for max_steps in [&mut configured.integrator.max_steps, &mut configured.engine.max_steps] {
        *max_steps = options.max_steps.min(*max_steps);
    }
    configured.duration_s = scene.duration_s.min(DURATION_FACTOR * options.span_s);
    configured
}

/// Simulates a scene as [`trace::run`] does, and records its path. A check compares this path with those of other runs.
pub fn run_and_record(model: Model, scene: &Scene, sink: &mut dyn Sink) -> (Result<Outcome, RunError>, Path) {
    let mut recorder = recorder(scene, model, (scene.duration_s, true), sink);
    recorder.is_complete = true;
    let result = trace::run(model, scene, &mut recorder);
    let path = path(scene, &result, recorder);
    (result, path)
}

/// Runs a scene with the settings of a check and returns its path. The samples and events are also passed to `sink`.
pub fn run(scene: &Scene, model: Model, options: &RunOptions<'_>, sink: &mut dyn Sink) -> Path {
    let mut recorder = recorder(scene, model, (options.span_s, options.energies), sink);
    let mut cancellable = Cancellable { sink: &mut recorder, keep_running: options.keep_running };
    let result = trace::run(model, &configured_scene(scene, options), &mut cancellable);
    path(scene, &result, recorder)
}

fn recorder<'a>(
    scene: &Scene,
    model: Model,
    (span_s, energies): (f64, bool),
    sink: &'a mut dyn Sink,
) -> PathRecorder<'a> {
    let measured = Measured {
        audit: energies.then(|| EnergyAudit::new(model, scene)),
        rebounds: scene.mechanism.as_ref().and_then(Rebounds::for_mechanism),
        speed_m_s: 0.0,
    };
    PathRecorder {
        interval_s: span_s / INTERVALS,
        points: Vec::new(),
        energies: Vec::new(),
        measured: OffGrid::new(scene.log.numeric_hz, measured),
        touches: Touches::default(),
        sink,
        is_complete: false,
    }
}

fn path(scene: &Scene, result: &Result<Outcome, RunError>, mut recorder: PathRecorder<'_>) -> Path {
    let (outcome, failure) = match result {
        Ok(outcome) => (outcome, None),
        Err(RunError::Simulation { failure, partial_outcome }) => (&**partial_outcome, Some(failure.reason.clone())),
        // The recorder never fails. If the other sink fails, its caller handles the error.
        Err(RunError::Sink(_)) => (&Outcome::default(), None),
    };
    // The recorder never fails.
    let _ = recorder.measured.end();
    let Measured { audit, rebounds, speed_m_s } = recorder.measured.sink;
    let schema = Schema::from_scene(scene);
    let surfaces: Vec<usize> = schema.surfaces().collect();
    let contacts = surfaces.iter().filter_map(|index| outcome.contacts.get(*index));
    let forces = surfaces.iter().filter_map(|index| outcome.last.contacts().nth(*index));
    Path {
        last: coordinates(&outcome.last),
        points: recorder.points,
        energies: recorder.energies,
        energy: outcome.last.energy(),
        rebounds: rebounds.iter().flat_map(Rebounds::pairs).copied().collect(),
        loop_gap_m: outcome.loop_gap_m,
        deep_contact: scene.mechanism.as_ref().and_then(|mechanism| deep_contact(mechanism, outcome)),
        unseen_overlap: recorder.touches.unseen_overlap.or_else(|| {
            let contacts = outcome.contacts.iter().enumerate();
            let mut unseen = contacts.filter(|(_, contact)| contact.passed_through());
            unseen.next().map(|(index, contact)| (index, outcome.last.time_s, contact.max_penetration_m))
        }),
        depths: outcome.contacts.iter().map(|contact| contact.max_penetration_m).collect(),
        contact_names: schema.contacts.iter().map(|contact| contact.name.clone()).collect(),
        ejected: outcome.ejected_s.is_some(),
        first_s: contacts.map(|contact| contact.first_s).collect(),
        normal_n: forces.map(|contact| contact.normal_n).collect(),
        end_s: outcome.last.time_s,
        failure,
        steps: outcome.work.steps,
        events: outcome.work.events,
        speed_m_s,
        audit,
        units: units(scene),
    }
}

/// Describes the first contact of a mechanism that is deeper than the roundings of its outlines together. There the point
/// is inside the core of the face, where the normal jumps between sides.
fn deep_contact(mechanism: &Mechanism, outcome: &Outcome) -> Option<String> {
    let points = mechanism.point_contacts();
    points.iter().zip(&outcome.contacts).find_map(|(point, summary)| {
        let radius_m = match point.point {
            OutlinePoint::Vertex { radius_m, .. } => radius_m,
            OutlinePoint::Ellipse { .. } => 0.0,
        };
        let face = &mechanism.outline(mechanism.contacts[point.pair].face).shape;
        let rounding_m = radius_m + face.radius_m();
        let depth_m = summary.max_penetration_m;
        let is_deep = !matches!(face, OutlineShape::HalfPlane { .. }) && depth_m > rounding_m;
        is_deep.then(|| {
            format!(
                "the contact {} is {:.4} mm deep, more than the roundings of its outlines, {:.4} mm, beyond which the \
                 direction of its force jumps; raise the stiffness or the rounding",
                point.name,
                depth_m * 1e3,
                rounding_m * 1e3
            )
        })
    })
}

/// Returns a quarter of a fixed step; or a tenth of the tolerance and at most a quarter of the step limit, because free
/// flight has no error that a tolerance would control.
fn finer_stepping(stepping: Stepping, span_s: f64) -> Stepping {
    match stepping {
        Stepping::Fixed { step_s } => Stepping::Fixed { step_s: 0.25 * step_s },
        Stepping::Adaptive { tolerance_m, max_step_s } => {
            Stepping::Adaptive { tolerance_m: 0.1 * tolerance_m, max_step_s: 0.25 * max_step_s.min(span_s) }
        }
    }
}

//! Preparation of a mechanism for loads on the base of its grasp, and its runs under them.

use super::base::{with_fixed_drives, with_prescribed_base};
use super::load::{Load, LoadCase, LoadSetup, moves_start, peak_acceleration, rescale};
use super::plan::{HoldError, LoadOutcome, Loads, Plan, SETTLING_S};
use super::prepare::{
    StartReason, completed_motion, first_move_end_s, fixed_actuation, rest_start, run_scene, smaller_limit,
    standard_cycle,
};
use crate::criteria::{ObjectCriteria, ObjectTracker, balanced_acceleration};
use crate::grasp::run_until_removal;
use crate::mechanism::{ContactPair, Mechanism, OutlineId, Pose, PrescribedMotion, pose_in_world};
use crate::numeric::elementary::{hypot, sin_cos};
use crate::numeric::plane::{add, rotate};
use crate::scene::{PalmMotion, Scene};
use crate::statics::{GraspRoles, MechanismLimit};
use crate::trace::{BodyState, ContactSample, Event, Model, Removal, RequiredData, Sample, Sink, SinkError};
use phalanx_parallel::{ComputeError, Monitor};

/// Number of instants of a load at which overlaps with the surroundings are sought.
const SWEEP_SAMPLES: usize = 1000;

/// A mechanism whose base follows loads.
#[derive(Clone, Debug)]
pub(super) struct PreparedMechanism {
    /// The scene with a prescribed base, and with drives that do not change from the start of the loads on.
    scene: Scene,
    roles: GraspRoles,
    /// Index of the base.
    base: usize,
    pub setup: LoadSetup,
    pub start_reason: StartReason,
    /// State at the start of the loads.
    at_start: Sample,
    /// The grasp there.
    grasp: ObjectCriteria,
    /// Indices of the contact points of surroundings that a load would hit.
    removed_points: Vec<usize>,
    /// Names of the outlines that are removed.
    pub removed: Vec<String>,
}

/// Finds the start of the loads and prepares the scene of a mechanism for them.
pub(super) fn prepare(
    scene: &Scene,
    plan: &Plan,
    cases: &[LoadCase],
    monitor: &Monitor<'_>,
) -> Result<PreparedMechanism, HoldError> {
    let roles = scene.grasp_roles().map_err(HoldError::NoGrasp)?;
    let (start_s, start_reason) = load_start(scene, &roles, plan, monitor)?;
    if let Some(release_s) = scene.grasp.as_ref().and_then(|keys| keys.release_s).filter(|end_s| *end_s <= start_s) {
        return Err(HoldError::ReleasedBeforeLoad { start_s, release_s });
    }
    let fixed = with_fixed_drives(scene, start_s, fixed_actuation);
    let (moving, base, motion) = with_prescribed_base(&fixed, &roles, start_s, |scene, recorder| {
        let until = Scene { duration_s: start_s, ..scene.clone() };
        run_scene(plan.model, &until, recorder, monitor).map(|_| ())
    })?;
    // A spline ends at the start of the loads.
    let prior = match (&plan.loads, scene.mechanism.as_ref().and_then(Mechanism::palm)) {
        (Loads::Move, Some(_)) => PalmMotion::default(),
        (_, Some(_)) => completed_motion(&motion, start_s),
        (_, None) => motion.clone(),
    };
    let prior_motion = PalmMotion { initial_pose: motion.initial_pose, ..prior };
    let scene = with_motion(&moving, base, prior_motion.clone(), start_s);
    let mechanism = scene.mechanism.as_ref().ok_or_else(HoldError::no_grasp)?;
    let mut tracker = ObjectTracker::for_scene(&scene).ok_or_else(HoldError::no_grasp)?;
    let at_start = run_scene(plan.model, &scene, &mut tracker, monitor)?.last;
    let grasp = tracker.criteria().ok_or_else(HoldError::no_grasp)?;
    let object = mechanism.reported_index(roles.object).ok_or_else(HoldError::no_grasp)?;
    let centre_m = centre_of(&at_start.body(object), mechanism.bodies[roles.object].com_m);
    let own = scene_motion(scene_moves(&motion, fixed.mechanism.as_ref()), mechanism.gravity_m_s2);
    let setup = LoadSetup {
        start_s,
        scene_peak_m_s2: peak_acceleration(&own, centre_m),
        scene_motion: own,
        prior_motion,
        lever_m: hypot(centre_m[0], centre_m[1]),
    };
    let roles = scene.grasp_roles().map_err(HoldError::NoGrasp)?;
    let mut prepared = PreparedMechanism {
        roles,
        base,
        setup,
        start_reason,
        at_start,
        grasp,
        removed_points: Vec::new(),
        removed: Vec::new(),
        scene: scene.clone(),
    };
    prepared.remove_surroundings(cases, plan.to_m_s2);
    Ok(prepared)
}

/// The moves of a scene from its start on; `None` if its base has none, or follows its joints.
fn scene_moves(motion: &PalmMotion, mechanism: Option<&Mechanism>) -> Option<PalmMotion> {
    let has_own = mechanism.is_some_and(|mechanism| mechanism.palm().is_some());
    let start_s = moves_start(motion).filter(|_| has_own)?;
    Some(PalmMotion { initial_pose: [0.0; 3], ..rescale(motion, 1.0, -start_s) })
}

/// The moves of the scene, or the standard cycle of robots, with its lift against gravity.
fn scene_motion(own: Option<PalmMotion>, [gx, gy]: [f64; 2]) -> PalmMotion {
    let size = hypot(gx, gy);
    let up = if size > 0.0 { [-gx / size, -gy / size] } else { [0.0, 1.0] };
    own.unwrap_or_else(|| standard_cycle(up))
}

fn with_motion(scene: &Scene, base: usize, motion: PalmMotion, duration_s: f64) -> Scene {
    let mut moved = Scene { duration_s, ..scene.clone() };
    if let Some(mechanism) = &mut moved.mechanism {
        mechanism.bodies[base].motion = Some(PrescribedMotion::Palm(motion));
    }
    moved
}

/// Start of the loads: as requested; with the moves of the scene, or after the first of them; or when object and base are at
/// rest.
fn load_start(
    scene: &Scene,
    roles: &GraspRoles,
    plan: &Plan,
    monitor: &Monitor<'_>,
) -> Result<(f64, StartReason), HoldError> {
    if let Some(start_s) = plan.start_s {
        return Ok((start_s, StartReason::Requested));
    }
    let mechanism = scene.mechanism.as_ref().ok_or_else(HoldError::no_grasp)?;
    if let Some((motion, start_s)) = mechanism.palm().and_then(|(_, motion)| Some((motion, moves_start(motion)?))) {
        return Ok(match plan.loads {
            Loads::Move => (start_s, StartReason::OwnMove),
            _ => (first_move_end_s(motion, start_s), StartReason::MoveCompleted),
        });
    }
    let release_s = scene.grasp.as_ref().and_then(|keys| keys.release_s);
    let end_s = release_s.map_or(scene.duration_s, |release_s| release_s.min(scene.duration_s));
    let closing = Scene { duration_s: end_s, ..scene.clone() };
    let bodies: Vec<usize> = [Some(roles.object), roles.base]
        .into_iter()
        .flatten()
        .filter_map(|body| mechanism.reported_index(body))
        .collect();
    let brakes = mechanism.actuators.iter().filter_map(|actuator| actuator.brake);
    let blocked_s = brakes.map(|brake| brake.start_s + brake.rise_s).fold(0.0, f64::max);
    rest_start(plan.model, &closing, &bodies, blocked_s, monitor)
}

impl PreparedMechanism {
    /// Name of the base.
    pub fn base_name(&self) -> &str {
        self.mechanism().map_or("", |mechanism| &mechanism.bodies[self.base].name)
    }

    /// Names of the outlines of the ground that count as part of the hand although no key says so.
    pub fn assumed_hand(&self) -> Vec<String> {
        let name = |id: &OutlineId| Some(self.mechanism()?.outline_name(*id));
        self.roles.assumed_hand.iter().filter_map(name).collect()
    }

    fn mechanism(&self) -> Option<&Mechanism> {
        self.scene.mechanism.as_ref()
    }

    /// Finds the surroundings that object and hand, fixed to the base, would hit under the largest of the loads.
    fn remove_surroundings(&mut self, cases: &[LoadCase], to_m_s2: f64) {
        let Some(mechanism) = self.mechanism() else { return };
        let is_reported = |body: &usize| mechanism.bodies[*body].is_reported;
        let mut carried: Vec<bool> = (0..mechanism.bodies.len()).map(|body| mechanism.has_joint(Some(body))).collect();
        (carried[self.roles.object], carried[self.base]) = (true, true);
        let is_carried =
            |id: OutlineId| id.body.is_some_and(|body| carried[body]) && !self.roles.surroundings.contains(&id);
        let between = |pair: &&ContactPair| is_carried(pair.points) != is_carried(pair.face);
        let pairs: Vec<ContactPair> = mechanism.contacts.iter().filter(between).cloned().collect();
        // Poses relative to the base.
        let mut states = vec![[0.0; 3]; mechanism.bodies.len()];
        for (index, body) in mechanism.reported_bodies().enumerate() {
            let BodyState { centre_m: [x, y], angle_rad, .. } = self.at_start.body(index);
            states[body] = [x, y, angle_rad];
        }
        let swept = Mechanism { contacts: pairs, ..mechanism.clone() };
        let mut is_hit = vec![false; swept.contacts.len()];
        let at_start = self.setup.prior_motion.pose(self.setup.start_s).position;
        for case in cases {
            let load = case.load(&self.setup, to_m_s2);
            for index in 0..=SWEEP_SAMPLES {
                let part = index as f64 / SWEEP_SAMPLES as f64;
                let time_s = self.setup.start_s + part * (load.end_s - self.setup.start_s);
                let base = load.motion.pose(time_s).position;
                let pose = |(body, state): (usize, &Pose)| {
                    let moves = carried[body] || body == self.base;
                    if is_reported(&body) || moves {
                        pose_in_world(if moves { base } else { at_start }, *state)
                    } else {
                        *state
                    }
                };
                let poses: Vec<Pose> = states.iter().enumerate().map(pose).collect();
                swept.deep_overlaps(&poses, 0.0).into_iter().for_each(|(pair, _)| is_hit[pair] = true);
            }
        }
        let hit: Vec<&ContactPair> =
            swept.contacts.iter().zip(&is_hit).filter(|(_, is_hit)| **is_hit).map(|(pair, _)| pair).collect();
        let is_removed = |pair: &ContactPair| {
            hit.iter().any(|other| mechanism.is_same_contact([pair.points, pair.face], [other.points, other.face]))
        };
        let points = mechanism.point_contacts();
        let removed_points: Vec<usize> =
            (0..points.len()).filter(|index| is_removed(&mechanism.contacts[points[*index].pair])).collect();
        let outside = hit.iter().map(|pair| if is_carried(pair.points) { pair.face } else { pair.points });
        let mut removed: Vec<String> = outside.map(|id| mechanism.outline_name(id)).collect();
        removed.sort();
        removed.dedup();
        (self.removed_points, self.removed) = (removed_points, removed);
    }

    /// Returns the largest acceleration that the contacts at the start of the loads can balance in both directions of a
    /// load. `None` for loads that rotate or change their direction, or if the statics have no solution.
    pub fn static_limit(&self, case: &LoadCase) -> Option<MechanismLimit> {
        let [cos, sin] = case.direction()?;
        let [forward, backward] =
            [[cos, sin], [-cos, -sin]].map(|direction| balanced_acceleration(&self.scene, &self.grasp, direction));
        Some(smaller_limit(forward?, backward?))
    }

    /// Simulates the mechanism under a motion of its base, and for [`SETTLING_S`] after it. Returns the outcome, or the
    /// reason why the run was not completed.
    pub fn simulate(
        &self,
        model: Model,
        load: Load,
        monitor: &Monitor<'_>,
    ) -> Result<Result<LoadOutcome, String>, ComputeError> {
        let start_s = self.setup.start_s;
        let scene = with_motion(&self.scene, self.base, load.motion, load.end_s + SETTLING_S);
        let Some(tracker) = ObjectTracker::for_scene(&scene) else { return Ok(Err(HoldError::no_grasp().to_string())) };
        let mut sink = LoadSink { tracker: tracker.with_motion_start(start_s), masked: &self.removed_points };
        let removal = Removal { at_s: start_s, contacts: &self.removed_points };
        let outcome = run_until_removal(model, &scene, removal, &mut sink, monitor.keep_running());
        let outcome = outcome.ok_or_else(|| monitor.stopped())?;
        Ok(outcome.and_then(|outcome| {
            let criteria = sink.tracker.criteria().ok_or("there is no sample")?;
            Ok(LoadOutcome::new(&criteria, &outcome))
        }))
    }
}

/// Evaluates a run under a load: the criteria of the grasp, without surroundings that are removed.
struct LoadSink<'a> {
    tracker: ObjectTracker,
    masked: &'a [usize],
}

impl Sink for LoadSink<'_> {
    fn required_data(&self) -> RequiredData {
        self.tracker.required_data()
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if self.masked.is_empty() {
            return self.tracker.sample(sample);
        }
        let mut masked = sample.clone();
        self.masked.iter().for_each(|contact| masked.set_contact(*contact, &ContactSample::NONE));
        self.tracker.sample(&masked)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        if self.masked.contains(&event.contact) { Ok(()) } else { self.tracker.event(event) }
    }
}

/// Centre of mass of a body in a state.
fn centre_of(state: &BodyState, com_m: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = sin_cos(state.angle_rad);
    add(state.centre_m, rotate(com_m, [cos, sin]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::hold::load_cases;

    /// The base follows the spline of its motion on the lift, so that the object is where it is in the scene.
    #[test]
    fn the_motion_of_a_lift_is_prescribed() {
        let scene = crate::scene::load_any("scenes/real/2f85-lift.toml").unwrap_or_else(|error| panic!("{error}"));
        let plan = Plan { start_s: Some(0.25), ..Plan::default() };
        let monitor = Monitor::silent(&|| true);
        let prepared =
            prepare(&scene, &plan, &load_cases(&plan.loads), &monitor).unwrap_or_else(|error| panic!("{error}"));
        let until = Scene { duration_s: 0.25, ..scene.clone() };
        let on_lift = run_scene(plan.model, &until, &mut (), &monitor).unwrap_or_else(|error| panic!("{error}")).last;
        let index = |scene: &Scene, name: &str| {
            let mechanism = scene.mechanism.as_ref().expect("a mechanism");
            mechanism.reported_bodies().position(|body| mechanism.bodies[body].name == name).expect("a body")
        };
        let [object, palm] = ["object", "palm"].map(|name| on_lift.body(index(&scene, name)));
        let found = prepared.at_start.body(index(&prepared.scene, "object"));
        for axis in 0..2 {
            let expected = object.centre_m[axis] - palm.centre_m[axis];
            assert!((found.centre_m[axis] - expected).abs() < 2e-6, "{found:?} {object:?} {palm:?}");
        }
        assert!((found.angle_rad - object.angle_rad).abs() < 1e-4, "{found:?} {object:?}");
        assert_eq!(prepared.removed, ["ground.table"]);
    }
}

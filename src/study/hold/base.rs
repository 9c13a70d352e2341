//! The base of a mechanism that follows a load: the ground, a body that moves by prescription, or a body on joints.
//!
//! A body on joints, such as a lift, follows its own motion up to the start of the loads: the joints that carry it are
//! removed, and a spline prescribes the motion that they gave it.

use super::plan::HoldError;
use crate::drive::Profile;
use crate::mechanism::{JointCombination, Mechanism, PrescribedMotion, SpringKind, assemble};
use crate::numeric::elementary::hypot;
use crate::scene::{PalmMotion, Path, Scene};
use crate::statics::{GraspRoles, carriers, move_ground};
use crate::trace::{BodyState, RequiredData, Sample, Sink, SinkError};

/// Largest number of parts of the spline that prescribes the motion of a base. Its poses are those at the ends of steps, which are
/// close to each other where the motion changes fast.
const MAX_SPLINE_PARTS: f64 = 1000.0;

/// Speed below which a body counts as at rest, m/s: in a pulse of 40 ms it would creep by 40 µm.
pub(super) const REST_SPEED_M_S: f64 = 1e-3;

/// Returns the scene with the commands of all actuators and brakes as they are at a time, from then on.
pub(super) fn with_fixed_drives(scene: &Scene, time_s: f64, fixed: impl Fn(&Profile, f64) -> Profile) -> Scene {
    let mut scene = scene.clone();
    let Some(mechanism) = &mut scene.mechanism else { return scene };
    for actuator in &mut mechanism.actuators {
        let profile = actuator.command.profile_mut();
        *profile = fixed(profile, time_s);
        actuator.brake.iter_mut().for_each(|brake| brake.release_s = brake.release_s.filter(|end_s| *end_s < time_s));
    }
    for actuator in mechanism.tendons.iter_mut().filter_map(|tendon| tendon.actuator.as_mut()) {
        actuator.tension = fixed(&actuator.tension, time_s);
    }
    // The grasp is judged at the end of the load.
    scene.grasp.iter_mut().for_each(|keys| keys.release_s = None);
    scene
}

/// Returns the scene with a base that a motion prescribes: the index of the base, and the motion that it has so far. The base
/// of a scene without such a motion follows its joints up to `start_s`; `record` runs a scene up to this time.
pub(super) fn with_prescribed_base(
    scene: &Scene,
    roles: &GraspRoles,
    start_s: f64,
    record: impl FnOnce(&Scene, &mut BaseRecorder) -> Result<(), HoldError>,
) -> Result<(Scene, usize, PalmMotion), HoldError> {
    let mut moving = scene.clone();
    let Some(mechanism) = &mut moving.mechanism else { return Err(HoldError::no_grasp()) };
    let name = |body: usize| scene.drawn_mechanism().bodies[body].name.clone();
    match (mechanism.palm().map(|(palm, motion)| (palm, motion.clone())), roles.base) {
        (Some((palm, motion)), base) if base == Some(palm) => Ok((moving, palm, motion)),
        (Some((palm, _)), base) => {
            let base = mechanism.body_name(base).to_string();
            Err(HoldError::OtherBodyMoves { base, moving: name(palm) })
        }
        (None, None) => {
            move_ground(mechanism, &mut moving.grasp, PalmMotion::default());
            let base = mechanism.bodies.len() - 1;
            Ok((moving, base, PalmMotion::default()))
        }
        (None, Some(base)) => {
            let start = assemble(mechanism).map_err(|error| HoldError::Scene { reason: error.to_string() })?;
            let index = mechanism.reported_index(base).ok_or_else(HoldError::no_grasp)?;
            let mut recorder = BaseRecorder { index, poses: Vec::new() };
            record(scene, &mut recorder)?;
            let (path, first) = recorder.path(start_s, &name(base))?;
            cut_free(mechanism, (roles.object, base))?;
            for (body, pose) in mechanism.bodies.iter_mut().zip(start.poses) {
                body.pose = pose;
            }
            let motion = PalmMotion { initial_pose: first, path: Some(path), ..PalmMotion::default() };
            mechanism.bodies[base].pose = first;
            mechanism.bodies[base].motion = Some(PrescribedMotion::Palm(motion.clone()));
            Ok((moving, base, motion))
        }
    }
}

/// Removes the joints that carry the base, with all that acts on them.
fn cut_free(mechanism: &mut Mechanism, (object, base): (usize, usize)) -> Result<(), HoldError> {
    let carriers = carriers(mechanism, (object, base));
    let is_carrier = |body: Option<usize>| body.is_none_or(|body| carriers[body]);
    let takes_part = |body: Option<usize>| body == Some(object) || mechanism.has_joint(body);
    let is_hand = |body: Option<usize>| body != Some(base) && !is_carrier(body) && takes_part(body);
    let carries = |[a, b]: [Option<usize>; 2]| (a == Some(base) && is_carrier(b)) || (b == Some(base) && is_carrier(a));
    let is_cut: Vec<bool> = mechanism.joints.iter().map(|joint| carries(joint.bodies)).collect();
    let of_hand: Vec<bool> = mechanism.joints.iter().map(|joint| joint.bodies.into_iter().any(is_hand)).collect();
    let refuse = |what: &str, name: &str| {
        let base = mechanism.bodies[base].name.clone();
        Err(HoldError::TiedBase { base, what: format!("the {what} `{name}`") })
    };
    // Whether a component goes with the joints; an error if it also acts on the hand.
    let goes = |what: &str, name: &str, terms: &[(usize, f64)], bodies: &[Option<usize>]| {
        let is_tied = terms.iter().any(|(joint, _)| is_cut[*joint]) || bodies.iter().any(|body| is_carrier(*body));
        let acts = terms.iter().any(|(joint, _)| of_hand[*joint]) || bodies.iter().any(|body| is_hand(*body));
        let on_base = bodies.contains(&Some(base)) || terms.iter().any(|(joint, _)| is_cut[*joint]);
        match (is_tied, acts) {
            (true, true) => refuse(what, name),
            (true, false) => Ok(on_base),
            (false, _) => Ok(false),
        }
    };
    let of_combination = |what: &str, name: &str, on: &JointCombination| goes(what, name, &on.terms, &[]);
    let Mechanism { couplings, springs, tendons, actuators, rotors, sum_limits, .. } = &*mechanism;
    let couplings: Vec<bool> =
        couplings.iter().map(|each| of_combination("coupling", &each.name, &each.on)).collect::<Result<_, _>>()?;
    let actuators: Vec<bool> = actuators
        .iter()
        .map(|each| {
            let points = each.powertrain.feedback.iter().flat_map(|feedback| feedback.points);
            let bodies: Vec<Option<usize>> = points.map(|id| id.body).collect();
            goes("actuator", &each.name, &each.on.terms, &bodies)
        })
        .collect::<Result<_, _>>()?;
    let rotors: Vec<bool> =
        rotors.iter().map(|each| of_combination("rotor", &each.name, &each.on)).collect::<Result<_, _>>()?;
    let springs: Vec<bool> = springs
        .iter()
        .map(|each| match &each.kind {
            SpringKind::Torsional { on, .. } => of_combination("spring", &each.name, on),
            SpringKind::Linear { bodies, .. } => goes("spring", &each.name, &[], bodies),
        })
        .collect::<Result<_, _>>()?;
    let tendons: Vec<bool> = tendons
        .iter()
        .map(|each| {
            let bodies: Vec<Option<usize>> = each.path.iter().map(|element| element.body).collect();
            goes("tendon", &each.name, &each.joints, &bodies)
        })
        .collect::<Result<_, _>>()?;
    let limits: Vec<bool> =
        sum_limits.iter().map(|each| of_combination("limit", &each.name, &each.on)).collect::<Result<_, _>>()?;
    retain(&mut mechanism.sum_limits, &limits);
    retain(&mut mechanism.couplings, &couplings);
    retain(&mut mechanism.actuators, &actuators);
    retain(&mut mechanism.rotors, &rotors);
    retain(&mut mechanism.springs, &springs);
    retain(&mut mechanism.tendons, &tendons);
    retain(&mut mechanism.joints, &is_cut);
    let place = |joint: usize| is_cut[..joint].iter().filter(|is_cut| !**is_cut).count();
    let springs = mechanism.springs.iter_mut().filter_map(|spring| match &mut spring.kind {
        SpringKind::Torsional { on, .. } => Some(on),
        SpringKind::Linear { .. } => None,
    });
    let couplings = mechanism.couplings.iter_mut().map(|coupling| &mut coupling.on);
    let actuators = mechanism.actuators.iter_mut().map(|actuator| &mut actuator.on);
    let rotors = mechanism.rotors.iter_mut().map(|rotor| &mut rotor.on);
    let limits = mechanism.sum_limits.iter_mut().map(|limit| &mut limit.on);
    let terms = springs.chain(couplings).chain(actuators).chain(rotors).chain(limits).flat_map(|on| &mut on.terms);
    let spools = mechanism.tendons.iter_mut().flat_map(|tendon| &mut tendon.joints);
    terms.chain(spools).for_each(|(joint, _)| *joint = place(*joint));
    Ok(())
}

/// Keeps the items that do not go.
fn retain<T>(items: &mut Vec<T>, goes: &[bool]) {
    let mut goes = goes.iter();
    items.retain(|_| !goes.next().copied().unwrap_or(false));
}

/// A sink that records the motion of a body in the world.
pub(super) struct BaseRecorder {
    /// Index among the bodies of samples.
    index: usize,
    poses: Vec<(f64, BodyState)>,
}

impl Sink for BaseRecorder {
    fn required_data(&self) -> RequiredData {
        RequiredData { grid: false, ..RequiredData::NONE }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.poses.push((sample.time_s, sample.body(self.index)));
        Ok(())
    }
}

impl BaseRecorder {
    /// The spline of the displacements from the first pose, and this pose. The base is at rest at both ends.
    fn path(&self, start_s: f64, base: &str) -> Result<(Path, [f64; 3]), HoldError> {
        let (Some(first), Some(last)) = (self.poses.first(), self.poses.last()) else {
            return Err(HoldError::no_grasp());
        };
        for (time_s, state) in [first, last] {
            let [vx, vy] = state.velocity_m_s;
            // A point at 1 m from the origin.
            let speed_m_s = hypot(vx, vy) + state.spin_rad_s.abs();
            if speed_m_s > REST_SPEED_M_S {
                return Err(HoldError::BaseMoves { base: base.to_string(), time_s: *time_s, speed_m_s });
            }
        }
        let pose = |state: &BodyState| [state.centre_m[0], state.centre_m[1], state.angle_rad];
        let initial = pose(&first.1);
        let relative = |(time_s, state): &(f64, BodyState)| {
            let pose = pose(state);
            (*time_s, std::array::from_fn(|axis| pose[axis] - initial[axis]))
        };
        let shortest_s = start_s / MAX_SPLINE_PARTS;
        let mut points = vec![relative(first)];
        for state in &self.poses {
            let is_next = |time_s: f64| state.0 - time_s >= shortest_s && start_s - state.0 >= shortest_s;
            if points.last().is_some_and(|(time_s, _)| is_next(*time_s)) {
                points.push(relative(state));
            }
        }
        points.push(relative(last));
        let path = Path::new(points).ok_or_else(HoldError::no_grasp)?;
        Ok((path, initial))
    }
}

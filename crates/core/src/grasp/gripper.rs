//! How a gripper holds its object at rest: what `phalanx statics` reports of a scene with two fingers.
//!
//! The posture is that of a run, the geometric one around the object where the scene has it, or whatever it is said to be. Of its
//! contacts are asked: force closure with friction, form closure, and the accelerations of the palm that they can balance.

use super::geometric::geometric;
use super::simulate::run;
use crate::criteria::{Driven, Fate, GraspTracker, Pressed, friction, hand_at_rest, pressed};
use crate::gripper::{GraspError, Site, close};
use crate::scene::words::SceneKind;
use crate::scene::{DiscMotion, Place, Scene, Side, WrongKind};
use crate::shape::reach;
use crate::statics::{
    Balance, Blocked, Drive, ForceClosure, FormClosure, GripperRow, HandAtRest, Holding, MetAt, PerContact, Stance,
    StaticsError, balance_polar, force_closure, gripper_closure,
};
use crate::trace::{self, BodyState, FingerState, Model, Sample};

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    pub posture: PostureOf,
    /// Friction coefficients of all contacts; none given: those of the scene.
    pub mu_static: Vec<f64>,
    /// Of each motor, or of the differential's input, instead of the scene's.
    pub motor_n_m: Option<f64>,
    /// Directions of acceleration, evenly around from x towards y.
    pub directions: usize,
}

/// Which posture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PostureOf {
    /// Of a run of the analytic model at a time; where none is given, at its end, or when its fingers let go. Contacts are those that
    /// press, and, if that is said, those nearer than `within_m`.
    Run {
        at_s: Option<f64>,
        within_m: Option<f64>,
    },
    /// All phalanges on the object where the scene has it.
    Geometric,
    Given(Given),
}

/// A posture as it is said to be. What is nearer to the object's surface than `within_m` touches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Given {
    /// (q11, q21) of right and left.
    pub angles_rad: [[f64; 2]; 2],
    /// Of the object's centre; where the scene has it otherwise.
    pub object_m: [Option<f64>; 2],
    pub within_m: f64,
}

/// The grasp.
#[derive(Clone, Debug, PartialEq)]
pub struct GripperGrasp {
    pub scene: String,
    pub source: Source,
    /// Where fingers and object are; of a run also forces.
    pub sample: Sample,
    pub mass_kg: f64,
    pub gravity_m_s2: [f64; 2],
    pub contacts: Vec<Touching>,
    /// Motors as they drive when blocked: both fingers', or the differential's input.
    pub drives: Vec<Drive>,
    /// With both driven links blocked and, with a differential, with its input blocked.
    pub closures: Vec<(Blocked, Result<FormClosure<GripperRow>, StaticsError>)>,
    /// One for each friction coefficient that was asked for.
    pub holds: Vec<Holds>,
}

/// Where a posture comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    Run { time_s: f64, fate: Fate },
    Geometric,
    Given,
}

/// A contact with the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touching {
    pub place: Place,
    pub at: MetAt,
    pub mu_static: f64,
    /// Normal force and friction of the run, N.
    pub forces_n: Option<[f64; 2]>,
}

/// What contacts hold with a friction coefficient, or with those of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Holds {
    pub mu_static: Option<f64>,
    pub force_closure: ForceClosure,
    /// With motors blocked and at their torque, as [`Driven::BOTH`].
    pub polar: [Vec<Balance>; 2],
}

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GripperGraspError {
    #[error(transparent)]
    Kind(#[from] WrongKind),
    #[error(
        "the object of \"{scene}\" is fixed, so nothing need hold it: take out [object] motion = \"fixed\", or give another scene"
    )]
    Fixed { scene: String },
    #[error(
        "the run of \"{scene}\" ends at {:.6} ms, before the {:.6} ms of --at: ask for an earlier time, or give the scene a longer \
         duration", .end_s * 1e3, .at_s * 1e3
    )]
    Late { scene: String, end_s: f64, at_s: f64 },
    #[error(
        "the {side} finger of \"{scene}\" does not reach around its object: {error}; take the posture of a run, or say which it is \
         (--posture)"
    )]
    NoReach { scene: String, side: &'static str, error: GraspError },
    #[error(
        "{place} is {:.4} mm deep in the object, more than the {:.4} mm within which surfaces touch: give other angles, or a \
         larger --within", .depth_m * 1e3, .within_m * 1e3
    )]
    Deep { place: String, depth_m: f64, within_m: f64 },
    #[error("nothing touches the object of \"{scene}\" {at}, so nothing holds it: {hint}")]
    Nothing { scene: String, at: String, hint: &'static str },
    #[error("the run of \"{scene}\" was not completed: {reason}")]
    Run { scene: String, reason: String },
    #[error("the grasp of \"{scene}\" has no statics: {error}")]
    Statics { scene: String, error: StaticsError },
    #[error("it was stopped")]
    Stopped,
}

/// The grasp of a gripper.
///
/// # Errors
/// See [`GripperGraspError`].
pub fn gripper_grasp(
    scene: &Scene,
    asked: &Asked,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<GripperGrasp, GripperGraspError> {
    let name = || scene.name.clone();
    let DiscMotion::Free { mass_kg, .. } = scene.only(SceneKind::Gripper)?.system.grasped().motion else {
        return Err(GripperGraspError::Fixed { scene: name() });
    };
    let refused = |error| GripperGraspError::Statics { scene: name(), error };
    let (source, sample) = match asked.posture {
        PostureOf::Run { at_s, .. } => ran(scene, at_s, go_on)?,
        PostureOf::Geometric => {
            let unreached = |(side, error): (Side, GraspError)| GripperGraspError::NoReach {
                scene: name(),
                side: side.word(),
                error,
            };
            let angles_rad = geometric(scene).map_err(unreached)?;
            (Source::Geometric, placed(scene, angles_rad, scene.system.grasped().centre_m)?)
        }
        PostureOf::Given(Given { angles_rad, object_m, .. }) => {
            let centre_m = [0, 1].map(|axis| object_m[axis].unwrap_or(scene.system.grasped().centre_m[axis]));
            (Source::Given, placed(scene, angles_rad, centre_m)?)
        }
    };
    let mut press = pressed(scene, &sample);
    let met = press.stance.met().map_err(refused)?;
    match asked.posture {
        PostureOf::Run { within_m, .. } => {
            let near = within_m.map(|within_m| near(scene, &met, within_m));
            press.touching = near.map_or(press.touching, |near| press.touching.with(near, |presses, is| presses || is));
        }
        PostureOf::Geometric => press.touching = near(scene, &met, GEOMETRIC_M),
        PostureOf::Given(Given { within_m, .. }) => {
            deepest(scene, &met, within_m)?;
            press.touching = near(scene, &met, within_m);
            press.limits = limits(scene, &sample);
        }
    }
    let contacts = contacts(scene, &sample, &press, &met, matches!(source, Source::Run { .. }));
    if contacts.is_empty() {
        return Err(nothing(scene, source));
    }
    let differential = scene.system.differential.as_ref().map(|_| Blocked::Input);
    let closures = [Blocked::Outputs].into_iter().chain(differential);
    let hand = |driven| hand_at_rest(scene, &press, driven).ok_or(GripperGraspError::Fixed { scene: name() });
    let hands = [hand(Driven::Blocked)?, hand(Driven::AtTorque)?].map(|hand| with_motor(hand, asked.motor_n_m));
    let asked_mu: Vec<Option<f64>> = match &asked.mu_static[..] {
        [] => vec![None],
        given => given.iter().copied().map(Some).collect(),
    };
    let holds = asked_mu.into_iter().map(|mu| holds(&hands, &contacts, mu, asked.directions));
    Ok(GripperGrasp {
        scene: name(),
        source,
        mass_kg,
        gravity_m_s2: hands[0].gravity_m_s2,
        drives: hands[0].drives.clone(),
        closures: closures.map(|blocked| (blocked, gripper_closure(&press.stance, &press.touching, blocked))).collect(),
        holds: holds.collect::<Result<_, _>>().map_err(refused)?,
        contacts,
        sample,
    })
}

/// What of a geometric posture counts as touching: rounding, and what a palm may be off by.
const GEOMETRIC_M: f64 = 1e-6;

/// A tip that is bent by no more is on its limit.
const STRAIGHT_RAD: f64 = 1e-6;

/// A run, and where it comes to.
fn ran(
    scene: &Scene,
    at_s: Option<f64>,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<(Source, Sample), GripperGraspError> {
    let (name, end_s) = (scene.name.clone(), scene.duration_s);
    if let Some(at_s) = at_s.filter(|at_s| *at_s > end_s) {
        return Err(GripperGraspError::Late { scene: name, end_s, at_s });
    }
    // Fingers that have let go hold nothing: just before.
    let duration_s = at_s.or(scene.cycle().releases_s.map(f64::next_down)).unwrap_or(end_s);
    let short = Scene { duration_s, ..scene.clone() };
    let mut tracker = GraspTracker::of(&short);
    match run(Model::Analytic, &short, &mut tracker, go_on) {
        Some(Ok(outcome)) => {
            let fate = tracker.criteria().map_or(Fate::NotGrasped, |criteria| criteria.fate);
            Ok((Source::Run { time_s: outcome.last.time_s, fate }, outcome.last))
        }
        Some(Err(reason)) => Err(GripperGraspError::Run { scene: name, reason }),
        None => Err(GripperGraspError::Stopped),
    }
}

/// Fingers and object at rest somewhere, at the end of the scene.
fn placed(scene: &Scene, angles_rad: [[f64; 2]; 2], centre_m: [f64; 2]) -> Result<Sample, GripperGraspError> {
    let mut fingers = Vec::with_capacity(2);
    for side in Side::BOTH {
        let (of, [q11, q21]) = (&scene.system.finger(side).linkage, angles_rad[side as usize]);
        let posture = close(&of.lengths, of.assembly, q11, q21)
            .map_err(|error| GripperGraspError::Statics { scene: scene.name.clone(), error: error.into() })?;
        fingers.push(FingerState {
            q11_rad: q11,
            q21_rad: q21,
            q12_rad: posture.q12_rad,
            q22_rad: posture.q22_rad,
            q13_rad: q21 + posture.q22_rad,
            ..FingerState::default()
        });
    }
    let bodies = vec![BodyState { centre_m, angle_rad: scene.system.grasped().angle_rad, ..BodyState::default() }];
    let contacts = vec![trace::ContactSample::NONE; Place::ALL.len()];
    Ok(Sample { time_s: scene.duration_s, fingers, bodies, contacts, ..Sample::default() })
}

/// What of the hand is at most so far from the object's surface.
fn near(scene: &Scene, met: &PerContact<MetAt>, within_m: f64) -> PerContact<bool> {
    let touching = met.map(|at| at.gap_m <= within_m);
    PerContact { palm: touching.palm && scene.system.palm.is_some(), ..touching }
}

/// Whether the tips of a posture are straight, where they have a limit there.
fn limits(scene: &Scene, sample: &Sample) -> [bool; 2] {
    Side::BOTH.map(|side| {
        let of = scene.system.finger(side);
        let past_straight_rad = sample.fingers[side as usize].q22_rad + of.linkage.lengths.phi22_rad;
        of.limit.is_some() && past_straight_rad <= STRAIGHT_RAD
    })
}

fn deepest(scene: &Scene, met: &PerContact<MetAt>, within_m: f64) -> Result<(), GripperGraspError> {
    for place in places(scene) {
        let depth_m = -of(met, place).gap_m;
        if depth_m > within_m {
            return Err(GripperGraspError::Deep { place: named(place), depth_m, within_m });
        }
    }
    Ok(())
}

fn named(place: Place) -> String {
    match place {
        Place::Finger(side, Site::Proximal) => format!("the {} proximal phalanx", side.word()),
        Place::Finger(side, _) => format!("the {} tip", side.word()),
        Place::Palm | Place::Table => "the palm".to_string(),
    }
}

/// Places of the hand that the scene has.
fn places(scene: &Scene) -> impl Iterator<Item = Place> {
    let has_palm = scene.system.palm.is_some();
    Place::ALL.into_iter().filter(move |place| match place {
        Place::Finger(_, site) => *site != Site::Limit,
        Place::Palm => has_palm,
        Place::Table => false,
    })
}

/// What a contact of the hand has of something; a limit has that of its tip, a table that of the palm.
fn of<T: Copy>(all: &PerContact<T>, place: Place) -> T {
    match place {
        Place::Finger(side, site) => all.phalanges[side as usize][usize::from(site != Site::Proximal)],
        Place::Palm | Place::Table => all.palm,
    }
}

fn contacts(scene: &Scene, sample: &Sample, press: &Pressed<'_>, met: &PerContact<MetAt>, ran: bool) -> Vec<Touching> {
    let mu = friction(scene);
    let touching = places(scene).filter(|place| of(&press.touching, *place));
    let touching = touching.map(|place| {
        let contact = &sample.contacts[place.index()];
        // Along t, which is mirrored on the left; samples have it the same way round everywhere.
        let along = if matches!(place, Place::Finger(Side::Left, _)) { -1.0 } else { 1.0 };
        let forces_n = ran.then_some([contact.normal_n, along * contact.tangential_n]);
        Touching { place, at: of(met, place), mu_static: of(&mu, place), forces_n }
    });
    touching.collect()
}

fn nothing(scene: &Scene, source: Source) -> GripperGraspError {
    let (at, hint) = match source {
        Source::Run { time_s, fate } => {
            let at = format!("at {:.6} ms of its run, where it is {}", time_s * 1e3, fate.name());
            (at, "ask for another time with --at, or for another posture with --posture")
        }
        Source::Geometric | Source::Given => ("in this posture".to_string(), "give other angles, or a larger --within"),
    };
    GripperGraspError::Nothing { scene: scene.name.clone(), at, hint }
}

fn with_motor(hand: HandAtRest<'_>, motor_n_m: Option<f64>) -> HandAtRest<'_> {
    let Some(torque_n_m) = motor_n_m else { return hand };
    let drives = hand.drives.iter().map(|drive| Drive { torque_n_m, ..*drive }).collect();
    HandAtRest { drives, ..hand }
}

fn holds(
    hands: &[HandAtRest<'_>; 2],
    contacts: &[Touching],
    mu_static: Option<f64>,
    directions: usize,
) -> Result<Holds, StaticsError> {
    let polar = |hand: &HandAtRest<'_>| {
        let friction = hand.friction.map(|mu| mu.map(|mu| mu_static.unwrap_or(mu)));
        balance_polar(&HandAtRest { friction, ..hand.clone() }, directions)
    };
    let holding = |touching: &Touching| Holding {
        point_m: touching.at.point_m,
        push: touching.at.normal,
        mu: mu_static.unwrap_or(touching.mu_static),
    };
    let holding: Vec<Holding> = contacts.iter().map(holding).collect();
    let Stance { object, .. } = hands[0].stance;
    Ok(Holds {
        mu_static,
        force_closure: force_closure(&holding, object.centre_m, reach(&object.shape)),
        polar: [polar(&hands[0])?, polar(&hands[1])?],
    })
}

//! Scene files: parsed, checked and resolved to SI with every default filled in.
//!
//! | file | contents |
//! |---|---|
//! | `sections` | the sections of a scene: every key with its type, default and description; resolved, physics checked |
//! | `quantity`, `keywords` | types of values: quantities with their dimension and range, keywords |
//! | `schema` | the schema of a scene, and what follows from it: allowed values, records, documentation |
//! | `section` | the sections of the schema with their keys, parsed for reading |
//! | `written` | single values as written |
//! | `value` | reading single values by their type |
//! | `section_input` | the file as written, section by section |
//! | `parameters` | the section `[parameters]`, and values given by expressions |
//! | `parse` | text → scene as written → [`Scene`] |
//! | `keys` | unknown keys, suggestions; keys of single entries of lists |
//! | `field` | paths of fields |
//! | `compose`, `precedence` | merging of a scene with those it extends and with single settings |
//! | `check`, `error` | collecting, showing and locating problems |
//! | `show` | a scene → a complete scene file |
//! | `template` | the common part of all designs of a study |
//! | `hand` | [`Hand`], a design of five-bar fingers with their object, and its possible contacts |
//! | `builder` | the mechanism of a hand |
//! | `discs` | discs that test contact laws, and their mechanism |

mod builder;
pub mod check;
mod compose;
mod discs;
pub mod error;
mod field;
mod hand;
pub mod keys;
pub mod keywords;
pub mod parameters;
pub mod parse;
pub mod precedence;
pub mod quantity;
pub mod schema;
pub mod section;
mod section_input;
pub mod sections;
mod show;
mod template;
pub mod value;
pub mod written;

pub use crate::drive::{Brake, Interpolation, Profile};
pub use crate::palm_motion::{Axis, Move, PalmMotion, Path, Pose, Ramp, Vibration};
use crate::statics::{GraspKeys, GraspRoles, NoGrasp, grasp_roles};
pub use builder::{FINGER_JOINTS, OpenLoop};
pub use compose::{
    EXTENDS, Layer, extended, extended_in, parse_layers, parse_layers_as, parse_layers_of_section, parse_setting,
    setting_from_parts,
};
pub use discs::{Disc, DiscMotion, Discs};
pub use error::{LocatedProblem, Problem, SceneError, locate_problems, one_line};
pub use field::{PARAMETERS, Part, no_such_entry, parse_field, split_entries};
pub use hand::{
    Differential, FingerContactLaws, HalfPlane, Hand, HandContact, HandFinger, Initial, Motor, Object, ObjectMotion,
    Side,
};
pub use keys::closest_match;
use keywords::SceneKind;
pub use parse::{parse, parse_any, parse_template};
pub use quantity::Keyword;
pub use schema::schema;
pub use sections::{
    Bounds, ENGINE_MAX_STEP_S, Engine, Integrator, LogExcess, LogSettings, Method, Preset, Response, Stepping,
    Thresholds,
};
pub use show::{show, show_written};
pub use template::Template;

pub use crate::gripper::{Placement, Spring, SpringKind};
use crate::mechanism::{self, Mechanism};
use std::borrow::Cow;

/// A resolved scene: everything a model needs, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub name: String,
    /// Kind of the scene, as in its file.
    pub kind: SceneKind,
    /// Description by the user; empty if there is none.
    pub description: String,
    /// The exact text of the file, for the attachment of the log.
    pub source: String,
    /// Fingers and their object; empty in scenes without five-bar fingers.
    pub hand: Hand,
    /// The mechanism; `None` in scenes with five-bar fingers.
    pub mechanism: Option<Mechanism>,
    pub duration_s: f64,
    pub integrator: Integrator,
    pub engine: Engine,
    pub bounds: Bounds,
    /// Thresholds of the criteria of a grasp; unused in scenes without a grasp.
    pub thresholds: Thresholds,
    /// Settings of the section `[grasp]` of a mechanism, or of the hand from which the mechanism was built; `None`
    /// without either.
    pub grasp: Option<GraspKeys>,
    pub log: LogSettings,
}

impl Scene {
    /// Name for texts, without line breaks.
    pub fn display_name(&self) -> String {
        one_line(&self.name)
    }

    /// Number of five-bar fingers.
    pub fn finger_count(&self) -> usize {
        self.hand.fingers.len()
    }

    /// Whether bodies are connected by joints.
    pub fn has_joints(&self) -> bool {
        self.mechanism.as_ref().map_or(self.finger_count() > 0, |mechanism| !mechanism.joints.is_empty())
    }

    /// Returns the mechanism in which a grasp is judged, with the contacts of [`Scene::drawn_mechanism`]. In it, a
    /// fixed object of a hand is the last body; in the simulated mechanism, it is an outline of the ground.
    pub fn judged_mechanism(&self) -> Cow<'_, Mechanism> {
        match &self.mechanism {
            Some(mechanism) => Cow::Borrowed(mechanism),
            None => Cow::Owned(self.hand.judged().drawn_mechanism()),
        }
    }

    /// Returns what the scene says about the grasp: its section `[grasp]`, or the palm, the table and the release of a
    /// hand. `None` without such a section.
    pub fn grasp_keys(&self) -> Option<GraspKeys> {
        match self.finger_count() {
            0 => self.grasp.clone(),
            _ => Some(self.hand.grasp_keys(&self.judged_mechanism(), self.duration_s)),
        }
    }

    /// Returns the roles in the grasp of [`Scene::judged_mechanism`]. A single finger has no grasp, because its class
    /// is judged instead.
    ///
    /// # Errors
    /// Returns the reason why there is no grasp.
    pub fn grasp_roles(&self) -> Result<GraspRoles, NoGrasp> {
        if self.finger_count() == 1 {
            return Err(NoGrasp::Nothing);
        }
        grasp_roles(&self.judged_mechanism(), &self.grasp_keys().unwrap_or_default())
    }

    /// Returns the mechanism that both models simulate.
    ///
    /// # Errors
    /// Returns an error if the initial angles of a finger do not close its loop.
    pub fn mechanism(&self) -> Result<Cow<'_, Mechanism>, OpenLoop> {
        match &self.mechanism {
            Some(mechanism) => Ok(Cow::Borrowed(mechanism)),
            None => self.hand.mechanism().map(Cow::Owned),
        }
    }

    /// Returns the scene of `kind = "mechanism"` with the same bodies, joints and laws. In this way a finger, a gripper
    /// or discs can be turned into a linkage of one's own; [`show`] writes the scene as a file.
    ///
    /// # Errors
    /// Returns an error if the initial angles of a finger do not close its loop, or for discs that are driven, do not
    /// rotate, or have a contact without stiffness.
    pub fn as_mechanism(&self) -> Result<Scene, NoMechanismFile> {
        let (mechanism, grasp) = match &self.mechanism {
            Some(mechanism) => {
                if let Some(reason) = self.no_file_of_discs(mechanism) {
                    return Err(NoMechanismFile::Discs { reason });
                }
                (mechanism.clone(), self.grasp.clone())
            }
            None => {
                let mechanism = self.hand.mechanism_of_file()?;
                let keys = self.hand.grasp_keys(&mechanism, self.duration_s);
                let grasp = Some(keys).filter(|keys| keys.object.is_some() && self.finger_count() > 1);
                (mechanism, grasp)
            }
        };
        Ok(Scene { kind: SceneKind::Mechanism, hand: Hand::EMPTY, mechanism: Some(mechanism), grasp, ..self.clone() })
    }

    /// Reason why no file of a mechanism describes discs.
    fn no_file_of_discs(&self, mechanism: &Mechanism) -> Option<String> {
        if self.kind != SceneKind::Bodies {
            return None;
        }
        let of_body = |body: &mechanism::Body| match (body.motion.is_some(), body.rotates()) {
            (true, _) => Some(format!("`{}` is driven; write motion = \"free\" or \"fixed\" first", body.name)),
            (false, false) => Some(format!("`{}` does not rotate; write rotates = true first", body.name)),
            (false, true) => None,
        };
        let without_spring = mechanism.contacts.iter().any(|contact| contact.law.normal.stiffness_n_per_m_e == 0.0);
        let of_law = || without_spring.then(|| "their contact has no stiffness; give it one first".to_string());
        mechanism.bodies.iter().find_map(of_body).or_else(of_law)
    }

    /// Returns the mechanism that samples, logs and drawings describe. In it, a finger whose loop does not close at its
    /// start is straight; such a scene fails before its first step.
    pub fn drawn_mechanism(&self) -> Cow<'_, Mechanism> {
        self.mechanism.as_ref().map_or_else(|| Cow::Owned(self.hand.drawn_mechanism()), Cow::Borrowed)
    }

    /// Length of the shortest link, m; infinite without links.
    pub fn shortest_link_m(&self) -> f64 {
        self.mechanism.as_ref().map_or_else(|| self.hand.shortest_link_m(), Mechanism::shortest_link_m)
    }

    /// Returns the single finger, or the right finger of a gripper.
    ///
    /// # Panics
    /// Panics if there are no fingers: check [`Scene::finger_count`] first.
    #[inline]
    pub fn finger(&self) -> &HandFinger {
        &self.hand.fingers[0]
    }

    /// Mutable access to [`Scene::finger`].
    ///
    /// # Panics
    /// Panics if there are no fingers.
    pub fn finger_mut(&mut self) -> &mut HandFinger {
        &mut self.hand.fingers[0]
    }

    /// Returns the object that fingers grasp.
    #[inline]
    pub fn object(&self) -> Option<&Object> {
        self.hand.object.as_ref()
    }

    /// Returns a copy with another palm motion and duration.
    pub fn with_palm_motion(&self, palm_motion: Option<PalmMotion>, duration_s: f64) -> Self {
        let mut moved = self.clone();
        (moved.hand.palm_motion, moved.duration_s) = (palm_motion, duration_s);
        moved
    }

    /// Applies a preset of the integrator to this scene and keeps the step budget. The reference preset resolves slip
    /// rates to 1e-5 of the narrowest slip range of a friction law. The reason is that two methods differed by 1.2e-7 m
    /// with a sticking range of 1 µm/s and a tolerance of 1e-9 m/s.
    pub fn apply_preset(&mut self, preset: Preset) {
        let max_steps = self.integrator.max_steps;
        self.integrator = match preset {
            Preset::Draft => Integrator { max_steps, ..Integrator::preset(preset) },
            Preset::Engineering => {
                Integrator { max_steps, ..Integrator::engineering_for(self.kind, self.grasp_roles().is_ok()) }
            }
            Preset::Reference => {
                let reference = Integrator::preset(preset);
                let range_m_s = match &self.mechanism {
                    Some(mechanism) => mechanism.narrowest_slip_range_m_s(),
                    None => self.hand.narrowest_slip_range_m_s(),
                };
                let resolved = 1e-5 * range_m_s;
                Integrator { atol_rate_rad_s: reference.atol_rate_rad_s.min(resolved), max_steps, ..reference }
            }
        };
    }

    /// Returns the scene if it has this number of five-bar fingers.
    ///
    /// # Errors
    /// Returns an error if the scene has another number of fingers.
    pub fn require_fingers(&self, count: usize) -> Result<&Self, WrongKind> {
        if self.finger_count() == count {
            return Ok(self);
        }
        let required = [SceneKind::Mechanism, SceneKind::Finger, SceneKind::Gripper][count];
        Err(WrongKind { scene: self.name.clone(), found: self.kind, required })
    }
}

/// Reason why a scene cannot be written as a file of a mechanism.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoMechanismFile {
    #[error(transparent)]
    OpenLoop(#[from] OpenLoop),
    #[error("the discs cannot be bodies of a mechanism: {reason}")]
    Discs { reason: String },
}

/// Error for a scene of one kind where another kind is required.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{scene}\" is a scene of kind \"{}\", but a scene of kind \"{}\" is required: give another scene",
    .found.keyword(), .required.keyword()
)]
pub struct WrongKind {
    pub scene: String,
    pub found: SceneKind,
    pub required: SceneKind,
}

/// Times of the phases of a grasp cycle of a gripper, s: the fingers are blocked, the palm moves, and the fingers open.
/// `None` for a phase that the scene does not have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cycle {
    /// Time at which the brake of each finger is fully engaged, s.
    pub blocked_s: [Option<f64>; 2],
    /// Time at which the palm begins to move, s.
    pub motion_start_s: Option<f64>,
    /// Time from which on no motor closes the fingers and no brake is engaged, s.
    pub release_s: Option<f64>,
}

impl Scene {
    /// Returns the grasp cycle of a gripper.
    pub fn cycle(&self) -> Cycle {
        self.hand.cycle(self.duration_s)
    }
}

impl Hand {
    /// Returns the grasp cycle in a run of this duration.
    pub fn cycle(&self, duration_s: f64) -> Cycle {
        let input = self.differential.as_ref().map(|differential| &differential.motor);
        let motors: Vec<&Motor> = input.into_iter().chain(self.fingers.iter().map(|finger| &finger.motor)).collect();
        let engaged_s = |motor: &Motor| motor.brake.map(|brake| brake.start_s + brake.rise_s);
        let motor = |side: usize| input.or_else(|| self.fingers.get(side).map(|finger| &finger.motor));
        let blocked_s = [0, 1].map(|side| motor(side).and_then(engaged_s));
        let motion = self.palm_motion.as_ref();
        let motion_start_s = motion.map(|motion| motion.start_s()).filter(|start| *start < duration_s);
        let closes = |t: f64| {
            motors.iter().any(|motor| {
                let is_braked =
                    motor.brake.is_some_and(|brake| t >= brake.start_s && brake.release_s.is_none_or(|end| t < end));
                is_braked || motor.actuation.at(t).0 > 0.0
            })
        };
        let candidates = motors.iter().flat_map(|motor| {
            let release = motor.brake.and_then(|brake| brake.release_s);
            closing_end_candidates(&motor.actuation).into_iter().chain(release)
        });
        let mut candidates: Vec<f64> = candidates.filter(|end| *end > 0.0 && *end < duration_s).collect();
        candidates.sort_by(f64::total_cmp);
        let first = candidates.iter().position(|end| closes(end.next_down()) && !closes(*end));
        let release_s = first.map(|index| candidates[index]);
        Cycle { blocked_s, motion_start_s, release_s }
    }
}

/// Times at which a motor torque may stop closing the finger.
fn closing_end_candidates(actuation: &Profile) -> Vec<f64> {
    match actuation {
        Profile::Constant { .. } | Profile::Ramp { .. } => Vec::new(),
        Profile::HalfSine { length_s, .. } => vec![*length_s],
        Profile::Reversal { at_s, .. } => vec![*at_s],
        Profile::Table { points, .. } => {
            // The zeros of linear interpolation, and all points.
            let crossings = points.windows(2).filter(|pair| pair[0].1 > 0.0 && pair[1].1 < 0.0).map(|pair| {
                let ((t0, a), (t1, b)) = (pair[0], pair[1]);
                t0 + (t1 - t0) * a / (a - b)
            });
            crossings.chain(points.iter().map(|point| point.0)).collect()
        }
    }
}

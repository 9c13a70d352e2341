//! Integrator, engine, tolerances of the validation, thresholds of grasps, and contents of the log.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{FINGERS, NO_FINGERS, NO_OR_TWO_FINGERS, WITH_HANDS};
use crate::law::ContactLaw;
use crate::limits::{MAX_PICTURES, MAX_SAMPLES};
use crate::numeric::elementary::{log10, powi};
use crate::scene::Hand;
use crate::scene::keywords::SceneKind;
use crate::scene::quantity::{
    Angle, AngularRate, Force, Frequency, Length, NotNegative, Plain, Positive, Quantity, Time, keyword_enum,
};
use crate::scene::section_input::SectionInput;
use crate::units::{self, Dimension, G_M_S2};

/// Integration of the equations of motion. Defaults depend on the preset.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Integrator {
    /// "engineering" for general use (rtol 1e-5; 3e-6 in grippers and in mechanisms with a grasp, 3e-7 in other mechanisms),
    /// "draft" for searches and learning (rtol 2e-4), "reference" for comparisons (rtol 1e-11).
    #[schemars(extend("default" = "engineering"))]
    pub preset: Preset,
    /// Integration method of order 5: Rodas5P, with steps of DOP853 where a mechanism is not stiff, or Radau IIA.
    pub method: Method,
    /// Relative tolerance of rates.
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
    pub rtol: f64,
    /// Absolute tolerance of angles; the same number in m is that of the positions of discs.
    #[schemars(with = "Positive<Angle>")]
    pub atol_angle_rad: f64,
    /// Absolute tolerance of rates; the same number in m/s is that of the velocities of discs.
    #[schemars(with = "Positive<AngularRate>")]
    pub atol_rate_rad_s: f64,
    /// Maximum number of steps of a run.
    #[schemars(extend("default" = MAX_STEPS, "minimum" = 1))]
    pub max_steps: u64,
}

keyword_enum! {
    /// Presets for the tolerances of the integrator.
    pub enum Preset { Draft = "draft", Engineering = "engineering", Reference = "reference" }
}

keyword_enum! {
    /// Integration method.
    pub enum Method { Rodas5p = "rodas5p", RadauIIa5 = "radau5" }
}

/// Default step budget of both models.
const MAX_STEPS: u64 = 10_000_000;

/// Default relative tolerance of grasps. Impacts between two fingers and a moving object amplify errors by a factor
/// of 1e4: at 1e-5, the default of one finger, the error exceeded 1e-5 rad in 5 of 314 random grippers. In 90 random grasps
/// of six linkages it is above 1e-5 (rad or 100 mm) in one, and below 5e-7 in 81.
const GRASP_RTOL: f64 = 3e-6;

/// Default relative tolerance of mechanisms without a grasp: cranks turn many times, and errors of their phase add up. Of 899
/// random mechanisms with and without a grasp whose check is `sure`, 99 % are within 1e-5 at these defaults, and 94 % at 1e-5
/// (tools/tolerances.py).
const MECHANISM_RTOL: f64 = 3e-7;

/// Smallest useful absolute tolerance of angles: the precision of an angle of 1 rad.
const FINEST_ATOL_RAD: f64 = 1e-14;
/// Smallest useful absolute tolerance of rates: the precision of a rate of 100 rad/s.
const FINEST_ATOL_RAD_S: f64 = 1e-9;

impl Integrator {
    /// Returns the settings of a preset.
    pub const fn preset(preset: Preset) -> Self {
        let (method, rtol, atol_angle_rad, atol_rate_rad_s) = match preset {
            Preset::Draft => (Method::Rodas5p, 2e-4, 2e-8, 2e-4),
            Preset::Engineering => (Method::Rodas5p, 1e-5, 1e-9, 1e-5),
            Preset::Reference => (Method::RadauIIa5, 1e-11, 1e-14, 1e-9),
        };
        Self { preset, method, rtol, atol_angle_rad, atol_rate_rad_s, max_steps: MAX_STEPS }
    }

    /// Returns the default settings of a scene: the engineering preset, with a tighter tolerance for grasps and mechanisms.
    pub(crate) fn engineering_for(kind: SceneKind, has_grasp: bool) -> Self {
        let defaults = Self::preset(Preset::Engineering);
        match kind {
            SceneKind::Gripper => defaults.with_rtol(GRASP_RTOL),
            SceneKind::Mechanism => defaults.with_rtol(if has_grasp { GRASP_RTOL } else { MECHANISM_RTOL }),
            SceneKind::Finger | SceneKind::Bodies => defaults,
        }
    }

    /// Sets `rtol` and multiplies the absolute tolerances by the same factor, but not below 1e-14 rad and 1e-9 rad/s,
    /// the limit of double precision.
    pub fn with_rtol(&self, rtol: f64) -> Self {
        let factor = rtol / self.rtol;
        let scaled = |atol: f64, finest: f64| (factor * atol).max(finest.min(atol));
        Self {
            rtol,
            atol_angle_rad: scaled(self.atol_angle_rad, FINEST_ATOL_RAD),
            atol_rate_rad_s: scaled(self.atol_rate_rad_s, FINEST_ATOL_RAD_S),
            ..*self
        }
    }
}

/// Contact law and stepping of the engine model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(with = "EngineSettings")]
pub struct Engine {
    #[serde(flatten)]
    pub response: Response,
    #[serde(flatten)]
    pub stepping: Stepping,
    /// Number of sweeps over the joints per step, in rapier's projected Gauss–Seidel solver.
    #[serde(default)]
    pub iterations: u32,
    /// Largest number of steps. A run that needs more steps ends with an error; its log is kept.
    pub max_steps: u64,
}

/// Origin of the contact forces of the engine model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "law", rename_all = "kebab-case")]
pub enum Response {
    /// The scene's contact laws, applied through the engine's contact-force hook.
    #[serde(rename = "scene")]
    Laws,
    /// rapier's own rigid contact, with its Coulomb friction and Newton restitution.
    Rapier {
        #[serde(default = "unset")]
        friction: f64,
        restitution: f64,
    },
}

/// A value that is not given.
fn unset() -> f64 {
    f64::NAN
}

/// Step sizes of the engine model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "stepping", rename_all = "kebab-case")]
pub enum Stepping {
    Fixed {
        #[serde(rename = "step", default = "unset")]
        step_s: f64,
    },
    /// Steps in which no joint deviates by more than `tolerance_m` from its circular path; shorter around impacts.
    Adaptive {
        #[serde(rename = "tolerance")]
        tolerance_m: f64,
        #[serde(rename = "max_step")]
        max_step_s: f64,
    },
}

pub const ENGINE_MAX_STEP_S: f64 = 6e-5;

impl Engine {
    pub const DEFAULT: Self = Self {
        response: Response::Laws,
        stepping: Stepping::Adaptive { tolerance_m: 1e-7, max_step_s: ENGINE_MAX_STEP_S },
        iterations: Self::default_iterations(Response::Laws),
        max_steps: MAX_STEPS,
    };

    /// Whether contacts follow the laws of the scene, as in the analytic model.
    pub fn uses_laws(&self) -> bool {
        self.response == Response::Laws
    }

    /// Default number of joint sweeps. With the contact laws of the scene, the engine passes the joint reactions to
    /// rapier, and the sweeps only confirm them. With rapier's contact, the sweeps have to propagate the impulses
    /// through the linkage.
    pub const fn default_iterations(response: Response) -> u32 {
        match response {
            Response::Laws => 2,
            Response::Rapier { .. } => 50,
        }
    }
}

/// Contact law and stepping of the engine model.
// The keys of an `Engine` in a file, for the schema.
#[derive(JsonSchema)]
pub struct EngineSettings {
    /// Contact law: "scene": the laws of [contact]; "rapier": rapier's own rigid contact.
    #[schemars(extend("default" = "scene", "enum" = ["scene", "rapier"]))]
    pub law: String,
    /// Coefficient of rapier's Coulomb friction (law = "rapier"). Default: mu_static of the contact (of the proximal
    /// contact of a finger).
    #[schemars(extend("x-with" = "law = rapier"))]
    pub friction: Option<NotNegative<Plain>>,
    /// Coefficient of rapier's Newton restitution, 0 to 1 (law = "rapier").
    #[schemars(extend("x-with" = "law = rapier", "default" = 0.0, "minimum" = 0.0, "maximum" = 1.0))]
    pub restitution: Option<Quantity<Plain>>,
    /// "adaptive": steps limited by `tolerance`, shorter around impacts; "fixed": all steps of size `step`.
    #[schemars(extend("default" = "adaptive", "enum" = ["adaptive", "fixed"]))]
    pub stepping: String,
    /// Step size. Required with stepping = "fixed", not allowed otherwise.
    #[schemars(extend("x-with" = "stepping = fixed",
        "x-required" = "add the step size: step = \"10 us\"; or use stepping = \"adaptive\""))]
    pub step: Option<Positive<Time>>,
    /// Largest deviation of a joint from its circular path in one step, in which bodies move along straight lines
    /// (stepping = "adaptive"). The default is proportionally smaller if the shortest link is shorter than 2.5 mm.
    // Runs of mechanisms are longer, and their error grows with time.
    #[schemars(extend("x-with" = "stepping = adaptive", "default" = "1e-4 mm", "x-mechanism" = { "default": "3e-5 mm" }))]
    pub tolerance: Option<Positive<Length>>,
    /// Longest step (stepping = "adaptive").
    #[schemars(extend("x-with" = "stepping = adaptive", "default" = "60 us"))]
    pub max_step: Option<Positive<Time>>,
    /// Sweeps of rapier's joint solver in every step. Default: 2, or 50 with law = "rapier".
    // Bounded, because the step budget cannot end a run if a single step takes too long.
    #[schemars(extend("minimum" = 1, "maximum" = 10_000))]
    pub iterations: Option<u32>,
    /// Maximum number of steps of a run.
    #[schemars(extend("default" = MAX_STEPS, "minimum" = 1))]
    pub max_steps: u64,
}

/// Tolerances of `phalanx validate` for differences between the engine model and the analytic model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Bounds {
    /// Difference of any joint angle (without joints: of the angle of any body) during the run up to `until`.
    #[schemars(with = "Positive<Angle>", extend("default" = "2e-5 rad", "x-gripper" = {
        "default": "1e-4 rad", "description": "Difference of any joint angle of either finger, over the run up to `until`."
    }))]
    pub angle_rad: f64,
    /// Distance between the positions of a body in both models, during the run up to `until`.
    #[schemars(with = "Positive<Length>", extend("x-kinds" = NO_OR_TWO_FINGERS, "default" = "1 um", "x-gripper" = {
        "description": "Distance between the object's centres in both models, over the run up to `until`."
    }))]
    pub position_m: f64,
    /// Difference of the times of the first contact of two surfaces.
    #[schemars(with = "Positive<Time>", extend("default" = "0.5 us", "x-finger" = {
        "description": "Difference of the times of the first contact of a phalanx with the object."
    }))]
    pub contact_time_s: f64,
    /// Relative difference of a normal force at the end.
    #[schemars(with = "Positive<Plain>", extend("x-kinds" = FINGERS, "default" = 1e-4, "x-gripper" = { "default": 5e-3 }))]
    pub final_force: f64,
    /// Relative difference of the normal impulse of an impact.
    #[schemars(with = "Positive<Plain>", extend("default" = 5e-3, "x-bodies" = {
        "description": "Relative difference of the normal impulse of a pair, over the run up to `until`."
    }))]
    pub impulse: f64,
    /// Relative difference of the largest normal force of a contact.
    #[schemars(with = "Positive<Plain>", extend("x-kinds" = NO_FINGERS, "default" = 1e-2))]
    pub peak_force: f64,
    /// Opening of a joint of the engine model.
    #[schemars(with = "Positive<Length>", extend("default" = "1e-4 mm"))]
    pub loop_gap_m: f64,
    /// Difference of the time to stability.
    #[schemars(with = "Positive<Time>", extend("x-kinds" = WITH_HANDS, "default" = "10 us", "x-gripper" = {
        "default": "0.1 ms", "description": "Difference of the time to stability of the whole grasp."
    }, "x-mechanism" = {
        "default": "0.1 ms",
        "description": "Difference of the time to stability of the whole grasp, and of the time at which the object is lost."
    }))]
    pub stability_time_s: f64,
    /// Difference of the coefficient of restitution of two discs without joints.
    #[schemars(with = "Positive<Plain>", extend("x-kinds" = NO_FINGERS, "default" = 1e-2))]
    pub restitution: f64,
    /// End of the comparison of trajectories, at most the duration; later rebounds may be chaotic. Default: the
    /// duration.
    #[schemars(with = "Positive<Time>")]
    pub until_s: f64,
}

impl Bounds {
    /// Default tolerances of a kind of scene.
    pub const fn defaults_for_run(kind: SceneKind, duration_s: f64) -> Self {
        let finger = Self {
            angle_rad: 2e-5,
            position_m: 1e-6,
            contact_time_s: 5e-7,
            final_force: 1e-4,
            impulse: 5e-3,
            peak_force: 1e-2,
            loop_gap_m: 1e-7,
            stability_time_s: 1e-5,
            restitution: 1e-2,
            until_s: duration_s,
        };
        match kind {
            SceneKind::Finger | SceneKind::Bodies => finger,
            SceneKind::Mechanism => Self { stability_time_s: 1e-4, ..finger },
            SceneKind::Gripper => Self { angle_rad: 1e-4, final_force: 5e-3, stability_time_s: 1e-4, ..finger },
        }
    }
}

/// Thresholds for a lost contact and a held object. A single finger follows the thesis instead, in which every loss of
/// contact counts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Thresholds {
    /// Shortest loss of contact: a contact is lost if its force is at or below `loss_force` for at least this time.
    /// Default: 0.1 ms, and at most 0.005 of the duration.
    #[schemars(with = "NotNegative<Time>")]
    pub loss_time_s: f64,
    /// Largest normal force of a lost contact. Default: 1e-4 of the largest motor torque over the length of the
    /// proximal phalanx.
    #[schemars(with = "NotNegative<Force>", extend("x-mechanism" = {
        "description": "Largest normal force of a lost contact. Default: 1e-3 of the weight of the object at 9.81 m/s²."
    }))]
    pub loss_force_n: f64,
    /// An object counts as held if it is held without interruption for at least this time. Default: 1 ms, and at most
    /// 0.05 of the duration.
    #[schemars(with = "NotNegative<Time>")]
    pub held_time_s: f64,
}

impl Thresholds {
    /// No thresholds, for scenes without a gripper: every loss of contact counts, and an object counts as held at once.
    pub const NONE: Self = Self { loss_time_s: 0.0, loss_force_n: 0.0, held_time_s: 0.0 };

    /// Defaults for a run of this duration.
    pub fn defaults_for_run(duration_s: f64, loss_force_n: f64) -> Self {
        let loss_time_s = 1e-4f64.min(0.005 * duration_s);
        Self { loss_time_s, loss_force_n, held_time_s: 10.0 * loss_time_s }
    }
}

/// Contents of the log.
// In addition, every integrator step during an impact is logged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LogSettings {
    /// Samples per second of simulated time; during impacts every step is logged in addition. In runs of grippers with
    /// more than 1000 samples, the analytic model logs 4 to 7 samples in each step that is longer than the sample
    /// interval.
    #[schemars(with = "Positive<Frequency>", extend("default" = "10 kHz", "x-key" = "numeric_rate"))]
    pub numeric_hz: f64,
    /// Pictures (frames, force arrows) per second of simulated time for 3-D views, at most one per sample; 0 for none.
    #[schemars(with = "NotNegative<Frequency>", extend("default" = "5 kHz", "x-key" = "picture_rate"))]
    pub picture_hz: f64,
    /// Whether the log contains the forces of joints, which make it 10 to 13 % larger.
    #[schemars(extend("default" = false))]
    pub joint_forces: bool,
}

/// Error for a log with too many samples or pictures.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{:.0} {} ({:e} Hz over {} s) are more than the limit of {:e} per log",
    .rate_hz * .duration_s, if *.pictures { "pictures" } else { "samples" }, .rate_hz, .duration_s, .max
)]
pub struct LogExcess {
    /// Whether there are too many pictures; otherwise there are too many samples.
    pub pictures: bool,
    pub rate_hz: f64,
    pub duration_s: f64,
    pub max: f64,
}

impl LogExcess {
    /// Returns the largest allowed rate for this run, rounded down to one digit.
    pub fn suggested_rate(&self) -> String {
        let rate_hz = self.max / self.duration_s;
        let digit = powi(10.0, log10(rate_hz).floor() as i32);
        format!("{:e} Hz", (rate_hz / digit).floor() * digit)
    }
}

impl LogSettings {
    /// Checks the limits of samples and pictures for a run of this duration.
    pub fn excess(&self, duration_s: f64) -> Option<LogExcess> {
        let excess = |pictures, rate_hz, max| LogExcess { pictures, rate_hz, duration_s, max };
        [excess(false, self.numeric_hz, MAX_SAMPLES), excess(true, self.picture_hz, MAX_PICTURES)]
            .into_iter()
            .find(|excess| excess.rate_hz * duration_s > excess.max)
    }
}

/// Resolves the settings of the integrator. Preset and relative tolerance determine the defaults of the other settings.
pub fn integrator(input: &SectionInput<'_>, has_grasp: bool) -> Integrator {
    let mut base = Integrator::engineering_for(input.kind, has_grasp);
    let Integrator { preset, rtol, .. } = input.read_over(&base);
    if preset != Preset::Engineering {
        base = Integrator::preset(preset);
    }
    if input.has("rtol") {
        base = base.with_rtol(rtol);
    }
    input.read_over(&base)
}

/// Default duration.
const DURATION_S: f64 = 0.020;

/// For links shorter than this, m, the default tolerance of steps is proportional to their length: the error of angles
/// is the tolerance divided by the length.
const SHORT_LINK_M: f64 = 2.5e-3;

/// Resolves the settings of the engine model. The default friction of rapier's contact is the static friction of the
/// contact law of the scene; for discs, this law is `law`.
pub fn engine(input: &SectionInput<'_>, hand: Option<&Hand>, law: Option<ContactLaw>) -> Engine {
    let mut engine: Engine = input.read();
    if !input.has("iterations") {
        engine.iterations = Engine::default_iterations(engine.response);
    }
    let proximal = hand.and_then(|hand| hand.fingers.first()).map(|finger| finger.contact.proximal);
    if let (Response::Rapier { friction, .. }, Some(law), false) =
        (&mut engine.response, proximal.or(law), input.has("friction"))
    {
        *friction = law.friction.map_or(0.0, |friction| friction.mu_static);
    }
    if let (Stepping::Adaptive { tolerance_m, .. }, Some(hand), false) =
        (&mut engine.stepping, hand, input.has("tolerance"))
    {
        *tolerance_m *= SHORT_LINK_M.min(hand.shortest_link_m()) / SHORT_LINK_M;
    }
    engine
}

/// Resolves the tolerances of the validation; only the end of the comparison depends on the duration.
pub fn bounds(input: &SectionInput<'_>, duration_s: Option<f64>) -> Bounds {
    let defaults = Bounds::defaults_for_run(input.kind, duration_s.unwrap_or(DURATION_S));
    let bounds: Bounds = input.read_over(&defaults);
    let help = "lower it, raise `duration`, or remove it (default: the duration)";
    check_within_duration(input, "until", bounds.until_s, duration_s, help);
    bounds
}

/// Force threshold of a mechanism as a part of the weight of its object: below the forces that carry it, and above those of
/// contacts that end.
const LOSS_WEIGHT: f64 = 1e-3;

/// Resolves the thresholds of the criteria of a grasp; `object_kg` is the mass of the object of a mechanism.
pub fn thresholds(
    input: &SectionInput<'_>,
    hand: Option<&Hand>,
    object_kg: Option<f64>,
    duration_s: Option<f64>,
) -> Thresholds {
    let duration = duration_s.unwrap_or(DURATION_S);
    let defaults = match (input.kind, object_kg) {
        (SceneKind::Gripper, _) => Thresholds::defaults_for_run(duration, 1e-4 * hand.map_or(0.0, Hand::motor_force_n)),
        (SceneKind::Mechanism, Some(mass_kg)) => Thresholds::defaults_for_run(duration, LOSS_WEIGHT * mass_kg * G_M_S2),
        (SceneKind::Finger | SceneKind::Bodies | SceneKind::Mechanism, _) => Thresholds::NONE,
    };
    let thresholds: Thresholds = input.read_over(&defaults);
    for (key, time_s) in [("loss_time", thresholds.loss_time_s), ("held_time", thresholds.held_time_s)] {
        check_within_duration(input, key, time_s, duration_s, "lower it, raise `duration`, or remove it");
    }
    thresholds
}

/// Reports a time that is longer than the run.
fn check_within_duration(input: &SectionInput<'_>, key: &str, time_s: f64, duration_s: Option<f64>, help: &str) {
    let Some(duration_s) = duration_s.filter(|duration_s| time_s > *duration_s) else { return };
    let [time, duration] = [time_s, duration_s].map(|time_s| units::format(time_s, Dimension::Time));
    let message = format!("`{}` is {time}, but must be at most the duration of {duration}", input.path(key));
    input.report(key, message, "after the end", help);
}

/// Resolves the settings of the log and checks the limits of its rates.
pub fn log(input: &SectionInput<'_>, duration_s: Option<f64>) -> LogSettings {
    let settings: LogSettings = input.read();
    if let Some(excess) = duration_s.and_then(|duration_s| settings.excess(duration_s)) {
        let key = if excess.pictures { "picture_rate" } else { "numeric_rate" };
        let help = format!("write `{key} = \"{}\"` in [log], or shorten the run", excess.suggested_rate());
        input.report(key, excess.to_string(), "too many", help);
    }
    settings
}

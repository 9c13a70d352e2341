//! Motor, spring and differential, given or sized.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use super::bodies::Target;
use super::finger::{FingerLengths, geometry};
use super::start::InitialSettings;
use super::{GRIPPER, check_point_count, extend};
use crate::gripper::{Finger, contact_angle_proximal};
use crate::law::Bristle;
use crate::scene::quantity::{
    Angle, AngularDamping, AngularRate, AngularStiffness, Inertia, Keyword, NotNegative, Positive, Quantity, Time,
    Torque, Word, keyword_enum, keywords,
};
use crate::scene::section_input::SectionInput;
use crate::scene::{Brake, Interpolation, Motor, Placement, Problem, Profile, Spring, SpringKind};
use crate::shape::PlacedShape;
use crate::sizing::{INTERVALS, Sizing, SizingError, Task, size_with};

keyword_enum! {
    /// Type of a torque as a function of time, in a file.
    pub enum ProfileType {
        Constant = "constant",
        Ramp = "ramp",
        HalfSine = "half-sine",
        Reversal = "reversal",
        Table = "table",
    }
}

keywords! { Interpolation { "linear" => Interpolation::Linear, "step" => Interpolation::Step } }

/// Motor torque on the driven link; counter-clockwise (closing) is positive.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct MotorSettings {
    /// Torque over time: "constant"; "ramp": rises smoothly during `rise`; "half-sine": one pulse; "reversal": changes
    /// sign at `reverse_at`; "table": `times` and `torques`.
    #[schemars(extend("default" = "constant"))]
    pub profile: ProfileType,
    /// Full torque. Required, except with profile = "table" or `sizing`.
    #[schemars(extend("x-with" = "profile = constant|ramp|half-sine|reversal"))]
    pub torque: Option<Quantity<Torque>>,
    /// Duration of the smooth rise from 0 (profile = "ramp").
    #[schemars(extend("x-with" = "profile = ramp", "x-required" = "add the duration of the rise: rise = \"2 ms\""))]
    pub rise: Option<Positive<Time>>,
    /// Duration of the pulse; the torque is 0 after it (profile = "half-sine").
    #[schemars(extend("x-with" = "profile = half-sine", "x-required" = "add the duration of the pulse: pulse = \"10 ms\""))]
    pub pulse: Option<Positive<Time>>,
    /// Time at which the torque changes sign (profile = "reversal").
    #[schemars(extend("x-with" = "profile = reversal",
        "x-required" = "add the time at which the torque changes sign: reverse_at = \"10 ms\""))]
    pub reverse_at: Option<NotNegative<Time>>,
    /// Times of the table, increasing; the torque is constant before the first and after the last (profile = "table").
    #[schemars(extend("x-with" = "profile = table"))]
    pub times: Option<Vec<Quantity<Time>>>,
    /// Torques of the table, one per time (profile = "table").
    #[schemars(extend("x-with" = "profile = table"))]
    pub torques: Option<Vec<Quantity<Torque>>>,
    /// Interpolation between the times of the table: "linear", or "step": each torque is constant until the next time.
    #[schemars(extend("x-with" = "profile = table", "default" = "linear"))]
    pub interpolation: Word<Interpolation>,
    /// Inertia of rotor and gear, reflected to the driven link.
    #[schemars(extend("x-kinds" = GRIPPER, "default" = "0 kg*m^2"))]
    pub inertia: Option<NotNegative<Inertia>>,
    /// Rate of the driven link at which the torque is 0; the torque decreases linearly with the rate. Default: constant
    /// torque.
    #[schemars(extend("x-kinds" = GRIPPER))]
    pub no_load_speed: Option<Positive<AngularRate>>,
    /// Brake: "two-way"; "one-way": blocks opening only; "none".
    #[schemars(extend("x-kinds" = GRIPPER, "default" = "none"))]
    pub brake: Option<BrakeKind>,
    /// Maximum torque of the brake; beyond it the brake slips.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake = two-way|one-way",
        "x-required" = "add the maximum torque: brake_torque = \"2 N*m\""))]
    pub brake_torque: Option<Positive<Torque>>,
    /// Time at which the brake begins to engage.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake = two-way|one-way",
        "x-required" = "add the time of engagement: brake_at = \"15 ms\""))]
    pub brake_at: Option<NotNegative<Time>>,
    /// Duration of engagement and of release.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake = two-way|one-way", "default" = "1 ms"))]
    pub brake_rise: Option<Positive<Time>>,
    /// Time at which the brake begins to release. Default: never.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake = two-way|one-way"))]
    pub brake_release: Option<Positive<Time>>,
    /// Half width of the sticking range: the rate at which the brake reaches its maximum torque.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake = two-way|one-way", "default" = "0.01 rad/s"))]
    pub brake_v_static: Option<Positive<AngularRate>>,
    /// "regularised": creeps within `brake_v_static`; "bristle": holds without creep, by a spring and a damper.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake = two-way|one-way", "default" = "regularised"))]
    pub brake_law: Option<BrakeLaw>,
    /// Damping of the bristle. With its default and that of `brake_relaxation`, the stiffness is 1e4 N·m/rad, more than
    /// that of a real shaft.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake_law = bristle", "default" = "2 N*m*s/rad"))]
    pub brake_damping: Option<Positive<AngularDamping>>,
    /// Relaxation time of the bristle: its damping over its stiffness.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake_law = bristle", "default" = "0.2 ms"))]
    pub brake_relaxation: Option<Positive<Time>>,
}

/// Settings that describe a given motor, but with the inertia `inertia_kg_m2`.
pub fn motor_settings(motor: &Motor, inertia_kg_m2: f64) -> Value {
    let brake = motor.brake;
    let bristle = brake.and_then(|brake| brake.bristle);
    let kind = match brake {
        None => BrakeKind::None,
        Some(brake) if brake.one_way => BrakeKind::OneWay,
        Some(_) => BrakeKind::TwoWay,
    };
    let mut settings = json!({
        "inertia": inertia_kg_m2,
        "no_load_speed": motor.no_load_speed_rad_s,
        "brake": kind,
        "brake_torque": brake.map(|brake| brake.torque_n_m),
        "brake_at": brake.map(|brake| brake.start_s),
        "brake_rise": brake.map(|brake| brake.rise_s),
        "brake_release": brake.and_then(|brake| brake.release_s),
        "brake_v_static": brake.map(|brake| brake.v_static_rad_s),
        "brake_law": if bristle.is_some() { BrakeLaw::Bristle } else { BrakeLaw::Regularised },
        "brake_damping": bristle.map(|bristle| bristle.damping_n_s_per_m),
        "brake_relaxation": bristle.map(|bristle| bristle.relaxation_s),
    });
    let profile = match &motor.actuation {
        Profile::Constant { value } => json!({ "profile": ProfileType::Constant, "torque": value }),
        Profile::Ramp { value, rise_s } => json!({ "profile": ProfileType::Ramp, "torque": value, "rise": rise_s }),
        Profile::HalfSine { value, length_s } => {
            json!({ "profile": ProfileType::HalfSine, "torque": value, "pulse": length_s })
        }
        Profile::Reversal { value, at_s } => {
            json!({ "profile": ProfileType::Reversal, "torque": value, "reverse_at": at_s })
        }
        Profile::Table { points, interpolation } => json!({
            "profile": ProfileType::Table,
            "times": points.iter().map(|point| point.0).collect::<Value>(),
            "torques": points.iter().map(|point| point.1).collect::<Value>(),
            "interpolation": interpolation.keyword(),
        }),
    };
    extend(&mut settings, profile);
    settings
}

keyword_enum! {
    /// Kind of a brake in a file.
    pub enum BrakeKind { None = "none", TwoWay = "two-way", OneWay = "one-way" }
}

keyword_enum! {
    /// Friction law of a brake in a file.
    pub enum BrakeLaw { Regularised = "regularised", Bristle = "bristle" }
}

keyword_enum! {
    /// Type of a spring in a file.
    pub enum SpringType { Constant = "constant", Torsional = "torsional", None = "none" }
}

keywords! { Placement {
    Placement::Phalanges.name() => Placement::Phalanges,
    Placement::DrivenCoupler.name() => Placement::DrivenCoupler,
    Placement::GroundLinks.name() => Placement::GroundLinks,
    Placement::CouplerDistal.name() => Placement::CouplerDistal,
} }

/// The spring that straightens the finger.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct SpringSettings {
    /// "constant": a constant torque; "torsional": stiffness × (preload + deflection); "none".
    #[schemars(extend("default" = "constant"))]
    pub r#type: SpringType,
    /// Torque of the constant spring. Required with type = "constant", except with `sizing`.
    #[schemars(extend("x-with" = "type = constant"))]
    pub torque: Option<NotNegative<Torque>>,
    /// Stiffness of the torsional spring. Required with type = "torsional", except with `sizing`.
    #[schemars(extend("x-with" = "type = torsional"))]
    pub stiffness: Option<Positive<AngularStiffness>>,
    /// Deflection of the torsional spring in the straight configuration.
    #[schemars(extend("x-with" = "type = torsional", "default" = "0 deg"))]
    pub preload: NotNegative<Angle>,
    /// Joint angle on which the spring acts.
    #[schemars(extend("x-with" = "type = constant|torsional", "default" = "q22"))]
    pub placement: Word<Placement>,
}

/// Settings that describe a given spring.
pub fn spring_settings(spring: Option<Spring>) -> Value {
    let Some(Spring { kind, placement }) = spring else { return json!({ "type": SpringType::None }) };
    let mut settings = match kind {
        SpringKind::Constant { torque_n_m } => json!({ "type": SpringType::Constant, "torque": torque_n_m }),
        SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
            json!({ "type": SpringType::Torsional, "stiffness": stiffness_n_m_per_rad, "preload": preload_rad })
        }
    };
    settings["placement"] = placement.keyword().into();
    settings
}

/// A differential (seesaw) with [motor] at its input; each finger gets half of the torque. An empty section
/// suffices to add it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct DifferentialSettings {
    /// Whether there is a differential.
    #[schemars(extend("default" = true))]
    pub present: bool,
    /// Inertia of the parts that rotate with the input, by the mean angle of both driven links; added to the inertia of
    /// [motor].
    #[schemars(extend("x-with" = "present = true", "default" = "0 kg*m^2"))]
    pub input_inertia: NotNegative<Inertia>,
    /// Inertia of the seesaw, which rotates by half the difference of the angles of both driven links.
    #[schemars(extend("x-with" = "present = true", "default" = "0 kg*m^2"))]
    pub seesaw_inertia: NotNegative<Inertia>,
}

/// Result of sizing motor and spring: `Some(None)` if the scene does not request sizing, `None` if it failed.
pub type SizingResult = Option<Option<Sizing>>;

/// Combines the sizings for two tasks. The spring has the larger torque; `motors` selects the torque of the motor.
pub fn combine(first: Sizing, second: Sizing, motors: fn(f64, f64) -> f64) -> Sizing {
    Sizing { motor_n_m: motors(first.motor_n_m, second.motor_n_m), spring_n_m: first.spring_n_m.max(second.spring_n_m) }
}

/// Resolves the motor, with the torque of the sizing if there is one.
pub fn motor(input: &SectionInput<'_>, sized: SizingResult) -> Option<Motor> {
    let settings: MotorSettings = input.read();
    // If the profile is invalid, the required keys are unknown.
    input.is_valid("profile").then_some(())?;
    let torque_n_m = sized.flatten().map_or(*settings.torque.unwrap_or_default(), |sizing| sizing.motor_n_m);
    let actuation = match settings.profile {
        ProfileType::Table => {
            Profile::Table { points: table_points(input, &settings)?, interpolation: settings.interpolation.0 }
        }
        _ if matches!(sized, Some(None)) && !input.has("torque") => {
            return input.refuse_missing("torque", "add the motor's torque on l11: [motor] torque = \"480 N*mm\"");
        }
        ProfileType::Constant => Profile::Constant { value: torque_n_m },
        ProfileType::Ramp => Profile::Ramp { value: torque_n_m, rise_s: *settings.rise? },
        ProfileType::HalfSine => Profile::HalfSine { value: torque_n_m, length_s: *settings.pulse? },
        ProfileType::Reversal => Profile::Reversal { value: torque_n_m, at_s: *settings.reverse_at? },
    };
    let brake = match settings.brake {
        None | Some(BrakeKind::None) => None,
        Some(kind) => Some(brake(input, &settings, kind == BrakeKind::OneWay)?),
    };
    Some(Motor {
        actuation,
        inertia_kg_m2: settings.inertia.map_or(0.0, |inertia| *inertia),
        no_load_speed_rad_s: settings.no_load_speed.map(|speed| *speed),
        brake,
    })
}

/// Resolves the brake of a motor; `None` if it is invalid.
fn brake(input: &SectionInput<'_>, settings: &MotorSettings, one_way: bool) -> Option<Brake> {
    let (start_s, rise_s) = (*settings.brake_at?, *settings.brake_rise?);
    let release_s = settings.brake_release.map(|release| *release);
    let bristle = match settings.brake_law? {
        BrakeLaw::Regularised => None,
        BrakeLaw::Bristle => {
            Some(Bristle { damping_n_s_per_m: *settings.brake_damping?, relaxation_s: *settings.brake_relaxation? })
        }
    };
    let (torque_n_m, v_static_rad_s) = (*settings.brake_torque?, *settings.brake_v_static?);
    if release_s.is_some_and(|release_s| release_s < start_s + rise_s) {
        let message = "`motor.brake_release` is before the brake is fully engaged, at brake_at + brake_rise";
        let help = "release the brake later, or remove this key: then the brake is never released";
        input.report("brake_release", message, "too early", help);
    }
    Some(Brake { torque_n_m, start_s, rise_s, release_s, one_way, v_static_rad_s, bristle })
}

/// Returns the points of a table.
fn table_points(input: &SectionInput<'_>, settings: &MotorSettings) -> Option<Vec<(f64, f64)>> {
    for key in ["times", "torques"].into_iter().filter(|key| !input.has(key)) {
        let help = "a table requires both: times = [\"0 ms\", \"5 ms\"] and torques = [\"0 N*mm\", \"480 N*mm\"]";
        input.report_missing(key, help);
    }
    let (times, torques) = (settings.times.as_ref()?, settings.torques.as_ref()?);
    check_point_count(input, times.len())?;
    if times.is_empty() {
        let help = "give at least one time and torque";
        return input.refuse("times", "the table of the motor is empty", "no times", help);
    }
    if times.len() != torques.len() {
        let message = format!("the table of the motor has {} times, but {} torques", times.len(), torques.len());
        return input.refuse("torques", message, "different number", "give one torque per time");
    }
    if let Some(i) = (1..times.len()).find(|&i| *times[i] <= *times[i - 1]) {
        let message = format!("the times of the motor's table do not increase: value {} is not after value {i}", i + 1);
        let help = "put the times in increasing order, without duplicates";
        let label = "not later than the preceding time";
        input.checker.push(Problem::new(input.item_span("times", i), message, label, help));
        return None;
    }
    Some(times.iter().zip(torques).map(|(time, torque)| (**time, **torque)).collect())
}

/// Resolves the spring. `Some(None)` without a spring; `None` if it is invalid.
pub fn spring(input: &SectionInput<'_>, sized: SizingResult) -> Option<Option<Spring>> {
    let settings: SpringSettings = input.read();
    input.is_valid("type").then_some(())?;
    let preload_rad = *settings.preload;
    let kind = match (settings.r#type, sized) {
        (SpringType::None, _) => return Some(None),
        (SpringType::Constant, Some(None)) => {
            if !input.has("torque") {
                let help = "add the spring's torque: [spring] torque = \"132.6 N*mm\"; or remove the spring: [spring] type = \"none\"";
                input.report_missing("torque", help);
            }
            SpringKind::Constant { torque_n_m: *settings.torque? }
        }
        (SpringType::Torsional, Some(None)) => {
            if !input.has("stiffness") {
                input.report_missing("stiffness", "add the spring's stiffness: stiffness = \"100 N*mm/rad\"");
            }
            SpringKind::Torsional { stiffness_n_m_per_rad: *settings.stiffness?, preload_rad }
        }
        (SpringType::Constant, _) => SpringKind::Constant { torque_n_m: sized.flatten()?.spring_n_m },
        // c_s q_p = k_s (2.30): the same torque in the straight configuration.
        (SpringType::Torsional, _) => {
            if !input.has("preload") {
                let help = "add the preload, by which the sizing determines the stiffness: preload = \"90 deg\"";
                input.report_missing("preload", help);
            } else if input.is_valid("preload") && preload_rad == 0.0 {
                input.report_out_of_range("preload", "above 0");
            }
            SpringKind::Torsional { stiffness_n_m_per_rad: sized.flatten()?.spring_n_m / preload_rad, preload_rad }
        }
    };
    Some(Some(Spring { kind, placement: settings.placement.0 }))
}

/// Sizes motor and spring for both ends of the positioning error (thesis §4.2.1.3), if the scene requests it. The
/// object at one end may be out of reach of the finger, which then touches it only after the other finger has moved it.
/// `finger_and_target` is `None` if the finger or its target is invalid.
pub fn size(
    input: &SectionInput<'_>,
    lengths: &FingerLengths,
    finger_and_target: Option<(&Finger, &Target)>,
    gravity_m_s2: [f64; 2],
) -> SizingResult {
    if !input.has("sizing") {
        input.report_unused(["closing_time"], "without sizing = \"rigid\" or \"whole\"");
        return Some(None);
    }
    reject_given(input);
    let (finger, target) = finger_and_target?;
    if target.object.is_none() {
        let message = "`sizing` needs the object that the finger closes on, and this scene has none";
        let help = "give [motor] torque and [spring] torque instead, or remove [object] present = false";
        return input.refuse("sizing", message, "requires an object", help);
    }
    let has_range = target.ends.windows(2).any(|pair| pair[0] != pair[1]);
    let mut sized = Vec::new();
    for object in &target.ends {
        let count = input.checker.count();
        let sizing = size_for(input, lengths, finger, *object, gravity_m_s2);
        let mut problems = input.checker.take_after(count);
        if has_range {
            let base = -object.centre_m[0] * 1e3;
            let details = format!(
                " with the object at the end of the positioning error, {base:.3} mm from the ground joint along the palm"
            );
            let failed = problems.iter_mut().filter(|problem| problem.label == SIZING_LABEL);
            failed.for_each(|problem| problem.message.push_str(&details));
        }
        sized.push((sizing, problems));
    }
    let reachable = sized.iter().filter_map(|(sizing, _)| *sizing);
    let combined = reachable.reduce(|first, second| combine(first, second, f64::max));
    for (sizing, problems) in sized {
        if sizing.is_some() || combined.is_none() {
            input.checker.extend(problems);
        }
    }
    combined.map(Some)
}

/// Sizes motor and spring for one position of the object.
fn size_for(
    input: &SectionInput<'_>,
    lengths: &FingerLengths,
    finger: &Finger,
    object: PlacedShape,
    gravity_m_s2: [f64; 2],
) -> Option<Sizing> {
    let (opening_rad, rule) = (opening(input, finger, object)?, lengths.rule?);
    let placement = input.subsection("spring").read::<SpringSettings>().placement.0;
    let task = Task { object, opening_rad, gravity_m_s2, closing_s: lengths.closing_s };
    geometry(input, "sizing", SIZING_LABEL, size_with(finger, &task, rule, placement, INTERVALS))
}

/// Reports values that are given in addition to the sizing.
fn reject_given(input: &SectionInput<'_>) {
    let (motor, spring) = (input.subsection("motor"), input.subsection("spring"));
    for (section, key) in [(&motor, "torque"), (&spring, "torque"), (&spring, "stiffness")] {
        if section.has(key) {
            let message = format!("`{}` is given, but `sizing` determines it", section.path(key));
            section.report(key, message, "conflicts with `sizing`", "remove this key, or remove `sizing`");
        }
    }
    if motor.is_valid("profile") && motor.read::<MotorSettings>().profile == ProfileType::Table {
        let message = "`sizing` determines the motor torque, but profile = \"table\" gives all torques";
        let help = "remove `sizing` and give [spring] torque, or choose another profile";
        motor.report("profile", message, "has its own torques", help);
    }
    if spring.read::<SpringSettings>().r#type == SpringType::None {
        let message = "`sizing` sizes motor and spring together, but this scene has no spring";
        spring.report("type", message, "no spring", "remove `sizing` and give [motor] torque, or add a spring");
    }
}

/// q_0, the initial angle before the proximal contact.
fn opening(input: &SectionInput<'_>, finger: &Finger, object: PlacedShape) -> Option<f64> {
    let start = input.subsection("initial");
    if start.has("q11") {
        let message =
            "`sizing` uses a test trajectory with a straight initial configuration, but `q11` may give another one";
        let help = "give only `q21` or `offset` for a straight start, or give [motor] torque and [spring] torque instead of `sizing`";
        return start.refuse("q11", message, "not allowed with sizing", help);
    }
    let settings: InitialSettings = start.read();
    if !start.has("q21") {
        // The sizing checks that it is above 0.
        return settings.offset.map(|offset| *offset);
    }
    let q21_rad = *settings.q21?;
    let contact = contact_angle_proximal(finger.lengths.half_width_m, object).map_err(SizingError::from);
    Some(geometry(input, "sizing", SIZING_LABEL, contact)? - q21_rad)
}

/// Label of an impossible sizing.
const SIZING_LABEL: &str = "this finger cannot be sized";

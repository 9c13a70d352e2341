//! Powertrains of actuators: gears, motors, and the distance that a controller measures.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use super::mirror::Entries;
use crate::law::Bristle;
use crate::mechanism::{
    Actuator, DistanceFeedback, GearLoss, MIN_DISTANCE_M, Mechanism, Motor, NamedPoint, PointId, Pose, Powertrain,
};
use crate::scene::Problem;
use crate::scene::keys::closest_match;
use crate::scene::quantity::{
    BackEmf, Current, Inductance, Length, NotNegative, Plain, Positive, Quantity, Resistance, TorqueConstant, Voltage,
};
use crate::scene::section_input::SectionInput;
use crate::units::Dimension;

/// Relaxation time of the bristle of a gear, s.
const BRISTLE_RELAXATION_S: f64 = 1e-3;

/// A DC motor, in place of `torque`, `limit` and `no_load_speed`. Its electrical energy is not part of the energy balance.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct MotorSettings {
    /// Torque per current. Required.
    #[schemars(extend("x-required" = "add the torque constant: torque_constant = \"9 mN*m/A\""))]
    pub torque_constant: Option<Positive<TorqueConstant>>,
    /// Resistance of the winding. Required.
    #[schemars(extend("x-required" = "add the resistance: resistance = \"3 ohm\""))]
    pub resistance: Option<Positive<Resistance>>,
    /// Voltage; with `target` or `targets`, the largest voltage of the controller. Required unless `voltages` is given.
    #[schemars(extend("x-alternative" = "voltages", "x-required" = "add the voltage: voltage = \"12 V\""))]
    pub voltage: Option<Quantity<Voltage>>,
    /// Voltages at the `times` of the actuator.
    pub voltages: Option<Vec<Quantity<Voltage>>>,
    /// Largest current in both directions. Default: none.
    pub current_limit: Option<Positive<Current>>,
    /// Voltage per rate of the motor. Default: `torque_constant`, which is the same in SI units.
    pub back_emf: Option<NotNegative<BackEmf>>,
    /// Inductance of the winding. Default: none; the current follows the voltage at once.
    pub inductance: Option<Positive<Inductance>>,
}

/// What a controller measures in place of the coordinate.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct FeedbackSettings {
    /// Two points of [bodies.NAME.points] or [ground.points] whose distance `target` is: ["left.tip", "right.tip"]. Required.
    #[schemars(extend("x-required" = "add the two points: distance = [\"left.tip\", \"right.tip\"]"))]
    pub distance: Option<[String; 2]>,
    /// 1 if a positive torque (force) of the actuator opens; −1 if it closes.
    #[schemars(extend("default" = 1.0))]
    pub sign: Quantity<Plain>,
}

/// A named point.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct PointSettings {
    /// Position in the frame of the body. Required.
    #[schemars(extend("x-required" = "add the position: at = [\"5 mm\", \"0 mm\"]"))]
    pub at: Option<[Quantity<Length>; 2]>,
}

/// Named points of a body or the ground.
pub(super) fn points(section: &SectionInput<'_>) -> Option<Vec<NamedPoint>> {
    let sections = section.subsections();
    sections.iter().for_each(|(name, each)| super::names::check_name(each, &section.path(""), name));
    let point = |(name, section): &(&str, SectionInput<'_>)| {
        let PointSettings { at } = section.read();
        Some(NamedPoint { name: (*name).to_owned(), at_m: super::outline::si(at?) })
    };
    sections.iter().map(point).collect::<Vec<_>>().into_iter().collect()
}

/// The units of an actuator: those of its coordinate, of the shaft of its motor, of its command, and of what its controller
/// measures.
#[derive(Clone, Copy, Debug)]
pub(super) struct Units {
    /// Whether the coordinate is a length, with words for messages.
    pub linear: bool,
    pub of: &'static str,
    /// Whether the shaft has a force.
    pub shaft_is_linear: bool,
    pub has_motor: bool,
    pub measures_length: bool,
}

impl Units {
    pub fn new(section: &SectionInput<'_>, linear: bool, of: &'static str) -> Self {
        let has_gear = section.has("gear") || section.has("lead");
        let has_motor = section.subsection("motor").is_present();
        let measures_length = linear || section.subsection("feedback").is_present();
        Self { linear, of, shaft_is_linear: linear && !has_gear && !has_motor, has_motor, measures_length }
    }

    /// Dimensions of the gains of a controller.
    pub fn gains(&self) -> [Dimension; 2] {
        use Dimension as D;
        match (self.has_motor, self.shaft_is_linear, self.measures_length) {
            (true, _, false) => [D::AngularVoltage, D::BackEmf],
            (true, _, true) => [D::LinearVoltage, D::LinearVoltageDamping],
            (false, true, _) => [D::LinearStiffness, D::LinearDamping],
            (false, false, false) => [D::AngularStiffness, D::AngularDamping],
            (false, false, true) => [D::Force, D::Impulse],
        }
    }

    /// Dimension of a key of the actuator, if it depends on these units.
    pub fn dimension(&self, key: &str) -> Option<Dimension> {
        use Dimension as D;
        let of = |is_linear: bool, [angular, linear]: [D; 2]| Some(if is_linear { linear } else { angular });
        match key {
            "limit" => of(self.shaft_is_linear, [D::Torque, D::Force]),
            "no_load_speed" => of(self.shaft_is_linear, [D::AngularRate, D::Speed]),
            "offset" => of(self.linear, [D::Angle, D::Length]),
            "loss_rate" => of(self.linear, [D::AngularRate, D::Speed]),
            "loss_stiffness" => of(self.linear, [D::AngularStiffness, D::LinearStiffness]),
            "target" | "targets" => of(self.measures_length, [D::Angle, D::Length]),
            "target_rate" => of(self.measures_length, [D::AngularRate, D::Speed]),
            "kp" => Some(self.gains()[0]),
            "kd" => Some(self.gains()[1]),
            _ => None,
        }
    }

    /// Checks that all values have the units of this actuator.
    pub fn check(&self, section: &SectionInput<'_>) -> bool {
        let mut is_valid = true;
        for key in section.keys() {
            let Some(right) = self.dimension(key) else { continue };
            let Some(wrong) = section.dimensions(key).into_iter().find(|found| *found != right) else { continue };
            let of = match (self.has_motor, section.has("gear") || section.has("lead"), self.measures_length) {
                _ if !["limit", "no_load_speed", "kp", "kd", "target", "targets", "target_rate"].contains(&key) => {
                    self.of
                }
                _ if key.starts_with("target") && self.measures_length != self.linear => "a distance",
                (true, ..) => "an actuator with a motor",
                (_, true, _) => "an actuator with a gear",
                (_, _, length) if length != self.linear => "a controller of a distance",
                _ => self.of,
            };
            let message = format!("`{}` is {}, but {of} needs {}", section.path(key), wrong.name(), right.name());
            section.report(key, message, right.name(), format!("write it as in \"{}\"", right.example()));
            is_valid = false;
        }
        is_valid
    }
}

/// Settings of a gear and its rotor, as in a scene, in SI.
#[derive(Clone, Copy, Debug)]
pub(super) struct GearSettings {
    pub gear: Option<f64>,
    pub lead: Option<f64>,
    pub rotor: Option<f64>,
    pub efficiency: Option<f64>,
    pub loss_rate: Option<f64>,
    pub loss_stiffness: Option<f64>,
}

/// Resolves gear, loss and motor of an actuator; `None` if any is invalid. The feedback follows when all points are known.
pub(super) fn powertrain(
    name: &str,
    section: &SectionInput<'_>,
    settings: &GearSettings,
    units: &Units,
) -> Option<Powertrain> {
    let gear = match (settings.gear, settings.lead) {
        (Some(_), Some(_)) => {
            let message = format!("actuator `{name}` has both a gear and a lead");
            return section.refuse("lead", message, "not with `gear`", "keep one of them: gear = 2 pi / lead");
        }
        (None, Some(_)) if !units.linear => {
            let message =
                format!("`{}` is for a prismatic joint, but `{name}` drives {}", section.path("lead"), units.of);
            return section.refuse("lead", message, "no screw", "write the ratio of the gear: gear = 30");
        }
        (None, Some(lead)) => std::f64::consts::TAU / lead,
        (Some(0.0), None) => {
            let message = format!("`{}` is 0, so the motor would not turn", section.path("gear"));
            let help = "write the rate of the motor per rate of the joint: gear = 30; negative if it turns backwards";
            return section.refuse("gear", message, "not 0", help);
        }
        (Some(gear), None) => gear,
        (None, None) => 1.0,
    };
    if units.linear && settings.gear.or(settings.lead).is_none() {
        let of_shaft = ["rotor"].into_iter().find(|key| section.has(key)).map(|key| (key, section.path(key)));
        let motor = section.subsection("motor");
        let of_motor = motor.is_present().then(|| ("motor", motor.path("")));
        if let Some((key, path)) = of_shaft.or(of_motor) {
            let message =
                format!("`{path}` is for a motor that turns, but `{name}` drives a prismatic joint without a gear");
            let help = "add the travel per turn: lead = \"5 mm\"; or gear, in rad/m";
            return section.refuse(key, message, "no gear", help);
        }
    }
    let loss = settings.efficiency.filter(|efficiency| *efficiency < 1.0);
    if loss.is_none() {
        let reason = if settings.efficiency.is_some() { "with an efficiency of 1" } else { "without `efficiency`" };
        section.report_unused(["loss_rate", "loss_stiffness"], reason);
    }
    let loss = loss.map(|efficiency| GearLoss {
        efficiency,
        rate: settings.loss_rate.unwrap_or(if units.linear { 1e-3 } else { 0.01 }),
        bristle: settings.loss_stiffness.map(|stiffness| Bristle {
            damping_n_s_per_m: stiffness * BRISTLE_RELAXATION_S,
            relaxation_s: BRISTLE_RELAXATION_S,
        }),
    });
    if settings.loss_stiffness.is_some() {
        section.report_unused(["loss_rate"], "with `loss_stiffness`");
    }
    let motor = motor(name, section)?;
    let rotor_kg_m2 = settings.rotor.unwrap_or(0.0);
    Some(Powertrain { gear, rotor_kg_m2, loss, motor, feedback: None })
}

/// Resolves a motor; the outer `None` if it is invalid.
fn motor(name: &str, section: &SectionInput<'_>) -> Option<Option<Motor>> {
    let motor = section.subsection("motor");
    if !motor.is_present() {
        return Some(None);
    }
    for key in ["torque", "torques", "force", "forces", "limit", "no_load_speed"] {
        if section.has(key) {
            let message = format!(
                "actuator `{name}` has both `{key}` and a motor, whose torque follows from voltage, resistance and torque constant"
            );
            let help = "keep one of them; the motor has a current_limit, and its no-load speed is voltage / back_emf";
            return section.refuse(key, message, "not with `motor`", help);
        }
    }
    let MotorSettings { torque_constant, resistance, current_limit, back_emf, inductance, .. } = motor.read();
    let torque_constant = *torque_constant?;
    Some(Some(Motor {
        torque_constant,
        resistance: *resistance?,
        current_limit: current_limit.map(|limit| *limit),
        back_emf: back_emf.map_or(torque_constant, |back_emf| *back_emf),
        inductance: inductance.map(|inductance| *inductance),
    }))
}

/// Resolves the feedback of all actuators, and checks the start.
pub(super) fn feedback(mechanism: &mut Mechanism, actuators: &Entries<'_>, partners: &[usize]) -> Option<()> {
    let find = |section: &SectionInput<'_>, index: usize, text: &str| -> Option<PointId> {
        let bodies = mechanism.bodies.iter().enumerate().map(|(index, body)| (Some(index), &body.points));
        let all = std::iter::once((None, &mechanism.ground_points)).chain(bodies);
        let ids = all.flat_map(|(body, points)| (0..points.len()).map(move |point| PointId { body, point }));
        let ids: Vec<PointId> = ids.collect();
        let names: Vec<String> = ids.iter().map(|id| mechanism.point_name(*id)).collect();
        if let Some(found) = names.iter().position(|name| name == text) {
            return Some(ids[found]);
        }
        let message =
            format!("`{}` names no point: there is no point `{}`", section.path("distance"), text.escape_debug());
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        let label =
            closest_match(text, &known).map_or("unknown point".into(), |near| format!("did you mean `{near}`?"));
        let help = match known[..] {
            [] => "name the points of the bodies: [bodies.left.points.tip] with at = [\"5 mm\", \"0 mm\"]".to_string(),
            _ => format!("the scene has: {}", known.join(", ")),
        };
        section.checker.push(Problem::new(section.item_span("distance", index), message, label, help));
        None
    };
    let mut found = Vec::new();
    for (_, name, section) in actuators.written() {
        let section = section.subsection("feedback");
        if !section.is_present() {
            continue;
        }
        let FeedbackSettings { distance, sign } = section.read();
        let distance = distance?;
        let points = [0, 1].map(|k: usize| find(&section, k, &distance[k]));
        let points = [points[0]?, points[1]?];
        if points[0].body == points[1].body {
            let message = format!(
                "`{}` names two points of `{}`, whose distance is constant",
                section.path("distance"),
                mechanism.body_name(points[0].body)
            );
            return section.refuse("distance", message, "the same body", "name points of two bodies that move apart");
        }
        if sign.abs() != 1.0 {
            let message = format!("`{}` is {}, but must be 1 or -1", section.path("sign"), *sign);
            let help = "write 1 if a positive effort opens, -1 if it closes";
            return section.refuse("sign", message, "1 or -1", help);
        }
        found.push((name.to_owned(), DistanceFeedback { points, sign: *sign }));
    }
    let image = |id: PointId| PointId { body: id.body.map(|body| partners[body]), ..id };
    let names: Vec<String> = actuators.names().into_iter().map(str::to_owned).collect();
    let pairs = actuators.partners();
    for (name, feedback) in found {
        let Some(index) = names.iter().position(|other| *other == name) else { continue };
        for (name, feedback) in [
            (&names[index], feedback),
            (&names[pairs[index]], DistanceFeedback { points: feedback.points.map(image), ..feedback }),
        ] {
            if pairs[index] == index && *name != names[index] {
                continue;
            }
            let actuator = mechanism.actuators.iter_mut().find(|actuator| actuator.name == *name);
            let is_first = actuator.as_ref().is_some_and(|actuator| actuator.powertrain.feedback.is_none());
            if let Some(actuator) = actuator.filter(|_| is_first) {
                actuator.powertrain.feedback = Some(feedback);
            }
        }
    }
    Some(())
}

/// Reports distances of 0 at the start, and controllers that would drive their distance away from its target.
pub(super) fn check_feedback(mechanism: &Mechanism, poses: &[Pose], actuators: &Entries<'_>) {
    for (index, actuator) in mechanism.actuators.iter().enumerate() {
        let Some(feedback) = &actuator.powertrain.feedback else { continue };
        let Some(entry) = actuators.names().iter().position(|name| *name == actuator.name) else { continue };
        let section = actuators.section(entry).subsection("feedback");
        let [a, b] = feedback.points.map(|id| mechanism.point_name(id));
        let distance = mechanism.distance(feedback, poses);
        if distance < MIN_DISTANCE_M {
            let message =
                format!("the points `{a}` and `{b}` start at the same place, where their distance has no direction");
            let help = "move the points, or change the start, so that they begin apart";
            section.report("distance", message, "no distance", help);
            continue;
        }
        let Some(opening) = mechanism.opening(index, poses) else { continue };
        if feedback.sign * opening < 0.0 {
            let does = if opening < 0.0 { "closes" } else { "opens" };
            let message = format!(
                "a positive effort of `{}` {does} the distance of `{a}` and `{b}` at the start, so the controller would drive it away from \
                 its target",
                actuator.name
            );
            let help = format!("write sign = {}", -feedback.sign);
            section.report("sign", message, "wrong sign", help);
        }
    }
}

/// Settings of the points of a body or the ground.
pub(super) fn point_settings(points: &[NamedPoint]) -> Value {
    points.iter().map(|point| (point.name.clone(), json!({ "at": point.at_m }))).collect()
}

/// Settings of the powertrain of an actuator, without its command.
pub(super) fn powertrain_settings(actuator: &Actuator, linear: bool, mechanism: &Mechanism) -> Value {
    let Powertrain { gear, rotor_kg_m2, loss, motor, feedback } = &actuator.powertrain;
    // A slider without a gear has a force.
    let has_gear = *gear != 1.0 || linear && (motor.is_some() || *rotor_kg_m2 != 0.0);
    let bristle = loss.and_then(|loss| loss.bristle);
    let mut settings = json!({
        "gear": has_gear.then_some(*gear),
        "rotor": Some(*rotor_kg_m2).filter(|inertia| *inertia != 0.0),
        "efficiency": loss.map(|loss| loss.efficiency),
        "loss_rate": loss.filter(|loss| loss.bristle.is_none()).map(|loss| loss.rate),
        "loss_stiffness": bristle.map(|bristle| bristle.damping_n_s_per_m / bristle.relaxation_s),
    });
    if let Some(motor) = motor {
        settings["motor"] = json!({
            "torque_constant": motor.torque_constant,
            "resistance": motor.resistance,
            "current_limit": motor.current_limit,
            "back_emf": motor.back_emf,
            "inductance": motor.inductance,
        });
    }
    if let Some(feedback) = feedback {
        let names = feedback.points.map(|id| mechanism.point_name(id));
        settings["feedback"] = json!({ "distance": names, "sign": feedback.sign });
    }
    settings
}

//! Reference solutions for mechanisms (tests/anchors/mechanism.json), for actuators with gears and motors
//! (tests/anchors/drives.json), and for cables that lift off and rub (tests/anchors/cable.json), computed by an independent
//! program: absolute coordinates, its own Radau IIA of order 9 that lands on events. Runs at tolerances 1e-10 and 1e-12 agree
//! to 11 digits
//! or more.

use std::collections::BTreeMap;

use phalanx::drive::{Interpolation, Profile};
use phalanx::law::{Bristle, ContactLaw, Damping, FrictionKind, FrictionLaw, NormalLaw};
use phalanx::mechanism::{
    Actuator, Body, Command, ContactPair, Coupling, DistanceFeedback, ForcePoint, GearLoss, Joint, JointCombination,
    JointKind, Mechanism, Motor, NamedPoint, Outline, OutlineId, OutlineShape, PathElement, PointId, Pose, Powertrain,
    Spring, SpringKind, Start, SumLimit, Tendon, TendonActuator,
};
use phalanx::scene::Scene;
use serde_json::Value;

use super::laws::mechanism_scene;

/// A mechanism and its reference solution. Lists follow the order of the mechanism.
pub struct MechanismCase {
    pub name: String,
    pub mechanism: Mechanism,
    pub duration_s: f64,
    pub start: Start,
    pub samples: Vec<MechanismSample>,
    /// Time, name (such as `ground.disc/link.face touch`) and whether the function rises.
    pub events: Vec<(f64, String, bool)>,
}

pub struct MechanismSample {
    pub time_s: f64,
    pub poses: Vec<Pose>,
    pub rates: Vec<Pose>,
    /// Coordinates and rates of the joints.
    pub joints: Vec<[f64; 2]>,
    /// Torques or forces of the actuators of joints.
    pub actuators: Vec<f64>,
    /// Their motor torque, current, voltage and measured distance; not a number where the case has none.
    pub drives: Vec<[f64; 4]>,
    /// Lengths and tensions of the tendons.
    pub tendons: Vec<[f64; 2]>,
    /// Path elements of the tendons, tendon by tendon, without the ends of their paths; empty without friction and lift-off.
    pub elements: Vec<ElementValues>,
    /// Contacts whose gap is below 2 mm.
    pub contacts: BTreeMap<String, ContactValues>,
    pub energies: BTreeMap<String, f64>,
}

/// A path element of a cable: whether the cable is on it, its wrap there (0 if it is off), its speed and the tension behind it.
#[derive(Clone, Copy, Debug, Default)]
pub struct ElementValues {
    pub is_on: bool,
    pub wrap_rad: f64,
    /// `None` without friction.
    pub slip_m_s: Option<f64>,
    pub tension_n: f64,
}

pub struct ContactValues {
    pub gap_m: f64,
    pub gap_rate_m_s: f64,
    pub slip_m_s: f64,
    pub normal_force_n: f64,
    pub friction_force_n: f64,
}

impl MechanismCase {
    /// Returns the scene of the case.
    pub fn scene(&self) -> Scene {
        mechanism_scene(self.mechanism.clone(), self.duration_s)
    }
}

/// All cases of mechanisms with direct actuators, ordered by name.
pub fn all_cases() -> Vec<MechanismCase> {
    cases_in("mechanism")
}

/// All cases of actuators with gears, motors and feedback, and of limits of sums, ordered by name.
pub fn drive_cases() -> Vec<MechanismCase> {
    cases_in("drives")
}

/// All cases of cables that lift off and rub, ordered by name.
pub fn cable_cases() -> Vec<MechanismCase> {
    cases_in("cable")
}

fn cases_in(file: &str) -> Vec<MechanismCase> {
    let text = std::fs::read_to_string(format!("tests/anchors/{file}.json")).expect("the reference solutions");
    let cases: BTreeMap<String, Value> = serde_json::from_str(&text).expect("JSON");
    cases.iter().map(|(name, case)| parse_case(name, case)).collect()
}

/// Returns the case with this name, such as `b_four_bar`.
pub fn mechanism_case(name: &str) -> MechanismCase {
    all_cases().into_iter().find(|case| case.name == name).expect("a case of that name")
}

fn parse_case(name: &str, case: &Value) -> MechanismCase {
    let mechanism = mechanism(&case["scene"]);
    let poses =
        |value: &Value| -> Vec<Pose> { mechanism.bodies.iter().map(|body| numbers(&value[&body.name])).collect() };
    let sample = |value: &Value| MechanismSample {
        time_s: number(&value["t"]),
        poses: poses(&value["poses"]),
        rates: poses(&value["rates"]),
        joints: mechanism.joints.iter().map(|joint| numbers(&value["joints"][&joint.name])).collect(),
        actuators: mechanism
            .actuators
            .iter()
            .map(|actuator| {
                let of = &value["actuators"][&actuator.name];
                number(if of.is_object() { &of["effort"] } else { of })
            })
            .collect(),
        drives: mechanism
            .actuators
            .iter()
            .map(|actuator| {
                let of = &value["actuators"][&actuator.name];
                ["motor_torque", "current", "voltage", "distance"].map(|key| or(&of[key], f64::NAN))
            })
            .collect(),
        tendons: mechanism
            .tendons
            .iter()
            .map(|tendon| ["length", "tension"].map(|key| number(&value["tendons"][&tendon.name][key])))
            .collect(),
        elements: mechanism
            .tendons
            .iter()
            .flat_map(|tendon| list(&value["tendons"][&tendon.name]["elements"]).filter_map(element_values))
            .collect(),
        contacts: object(&value["contacts"]).map(|(name, value)| (name.clone(), contact_values(value))).collect(),
        energies: object(&value["energies"]).map(|(name, value)| (name.clone(), number(value))).collect(),
    };
    let event = |event: &Value| (number(&event[0]), text(&event[1]), event[2] == "up");
    MechanismCase {
        name: name.to_owned(),
        duration_s: number(&case["duration"]),
        start: Start {
            poses: poses(&case["start"]["poses"]),
            rates: poses(&case["start"]["rates"]),
            implied: Vec::new(),
        },
        samples: list(&case["samples"]).map(sample).collect(),
        events: list(&case["events"]).map(event).collect(),
        mechanism,
    }
}

/// Values of a path element; `None` at the first one of a path.
fn element_values(value: &Value) -> Option<ElementValues> {
    let is_on = value["on"] == true;
    (!is_on || value["wrap"].is_number()).then(|| ElementValues {
        is_on,
        wrap_rad: or(&value["wrap"], 0.0),
        slip_m_s: value["slip"].as_f64(),
        tension_n: or(&value["tension_after"], 0.0),
    })
}

fn contact_values(value: &Value) -> ContactValues {
    ContactValues {
        gap_m: number(&value["gap"]),
        gap_rate_m_s: number(&value["gap_rate"]),
        slip_m_s: number(&value["slip"]),
        normal_force_n: number(&value["normal_force"]),
        friction_force_n: number(&value["friction_force"]),
    }
}

/// Converts a scene of the reference program.
fn mechanism(scene: &Value) -> Mechanism {
    let mut mechanism = Mechanism {
        gravity_m_s2: numbers(&scene["gravity"]),
        ground_outlines: list(&scene["ground"]["outline"]).map(outline).collect(),
        bodies: list(&scene["body"]).map(body).collect(),
        ..Mechanism::default()
    };
    mechanism.joints = list(&scene["joint"]).map(|value| joint(value, &mechanism)).collect();
    mechanism.couplings = list(&scene["coupling"]).map(|value| coupling(value, &mechanism)).collect();
    // The reference program also states the starts that follow from a coupling.
    for coupling in &mechanism.couplings {
        mechanism.joints[coupling.on.terms[0].0].start = None;
    }
    mechanism.springs = list(&scene["spring"]).map(|value| spring(value, &mechanism)).collect();
    mechanism.tendons = list(&scene["tendon"]).map(|value| tendon(value, &mechanism)).collect();
    let (pulls, motors): (Vec<&Value>, Vec<&Value>) =
        list(&scene["actuator"]).partition(|actuator| actuator["tendon"].is_string());
    for pull in pulls {
        let tendon =
            mechanism.tendons.iter_mut().find(|tendon| tendon.name == text(&pull["tendon"])).expect("a tendon");
        tendon.actuator = Some(TendonActuator { name: text(&pull["name"]), tension: profile(&pull["tension"]) });
    }
    mechanism.actuators = motors.into_iter().map(|value| actuator(value, &mechanism)).collect();
    mechanism.sum_limits = list(&scene["limit"]).map(|value| sum_limit(value, &mechanism)).collect();
    mechanism.contacts = list(&scene["contact"]).map(|value| contact(value, &mechanism)).collect();
    mechanism
}

fn body(value: &Value) -> Body {
    Body {
        com_m: numbers_or_zero(&value["com"]),
        pose: numbers(&value["start"]),
        rate: numbers_or_zero(&value["rate"]),
        outlines: list(&value["outline"]).map(outline).collect(),
        points: object(&value["points"])
            .map(|(name, at)| NamedPoint { name: name.clone(), at_m: numbers(at) })
            .collect(),
        ..Body::new(text(&value["name"]), number(&value["mass"]), number(&value["inertia"]))
    }
}

fn outline(value: &Value) -> Outline {
    let radius_m = or(&value["radius"], 0.0);
    let shape = match value["type"].as_str() {
        Some("disc") => OutlineShape::Disc { center_m: numbers(&value["center"]), radius_m },
        Some("capsule") => {
            OutlineShape::Capsule { from_m: numbers(&value["from"]), to_m: numbers(&value["to"]), radius_m }
        }
        Some("half_plane") => {
            OutlineShape::HalfPlane { point_m: numbers(&value["point"]), normal: numbers(&value["normal"]) }
        }
        Some("polygon") => {
            OutlineShape::Polygon { vertices_m: list(&value["vertices"]).map(numbers).collect(), radius_m }
        }
        Some("ellipse") => OutlineShape::Ellipse {
            center_m: numbers(&value["center"]),
            semi_axes_m: numbers(&value["semi_axes"]),
            angle_rad: number(&value["angle"]),
        },
        other => panic!("outline {other:?}"),
    };
    Outline { name: text(&value["name"]), shape }
}

fn joint(value: &Value, mechanism: &Mechanism) -> Joint {
    let kind = match value["type"].as_str() {
        Some("revolute") => JointKind::Revolute,
        Some("prismatic") => JointKind::Prismatic { axis_rad: number(&value["axis"]) },
        other => panic!("joint {other:?}"),
    };
    let points_m = [0, 1].map(|side| numbers(&value["points"][side]));
    Joint {
        offset_rad: or(&value["offset"], 0.0),
        start: value["start"].as_f64(),
        start_rate: or(&value["start_rate"], 0.0),
        damping: or(&value["damping"], 0.0),
        armature: or(&value["armature"], 0.0),
        lower: value["lower"].as_f64(),
        upper: value["upper"].as_f64(),
        limit: value["limit"].is_object().then(|| normal_law(&value["limit"])),
        ..Joint::new(text(&value["name"]), kind, bodies(&value["bodies"], mechanism), points_m)
    }
}

fn coupling(value: &Value, mechanism: &Mechanism) -> Coupling {
    let terms = object(&value["terms"]).map(|(joint, factor)| (joint_index(joint, mechanism), number(factor)));
    let on = JointCombination { terms: terms.collect(), offset: or(&value["value"], 0.0) };
    Coupling { name: value["name"].as_str().unwrap_or("coupling").to_owned(), on }
}

fn spring(value: &Value, mechanism: &Mechanism) -> Spring {
    let kind = match value["type"].as_str() {
        Some("torsional") => SpringKind::Torsional {
            on: JointCombination::of_joint(joint_index(&text(&value["joint"]), mechanism)),
            preload: or(&value["torque"], 0.0),
        },
        Some("linear") => SpringKind::Linear {
            bodies: bodies(&value["bodies"], mechanism),
            points_m: [0, 1].map(|side| numbers(&value["points"][side])),
        },
        other => panic!("spring {other:?}"),
    };
    Spring {
        name: text(&value["name"]),
        kind,
        stiffness: number(&value["stiffness"]),
        damping: or(&value["damping"], 0.0),
        rest: or(&value["rest"], 0.0),
    }
}

fn tendon(value: &Value, mechanism: &Mechanism) -> Tendon {
    let count = list(&value["path"]).count();
    let is_reversed = value["from"] == "last";
    let element = |(index, element): (usize, &Value)| {
        let is_inner = index > 0 && index + 1 < count && element["roller"] != true;
        let side = or(&element["side"], 1.0);
        let friction = [&element["friction"], &value["friction"]].into_iter().find(|friction| friction.is_object());
        PathElement {
            body: body_index(&text(&element["body"]), mechanism),
            point_m: numbers(&element["point"]),
            radius_m: or(&element["radius"], 0.0),
            side: if is_reversed { -side } else { side },
            friction: friction.filter(|_| is_inner).map(cable_friction),
        }
    };
    let mut path: Vec<PathElement> = list(&value["path"]).enumerate().map(element).collect();
    if is_reversed {
        path.reverse();
    }
    Tendon {
        name: text(&value["name"]),
        path,
        joints: object(&value["joints"]).map(|(name, c)| (joint_index(name, mechanism), number(c))).collect(),
        stiffness_n_per_m: or(&value["stiffness"], 0.0),
        damping_n_s_per_m: or(&value["damping"], 0.0),
        rest_m: or(&value["rest"], 0.0),
        actuator: None,
        far_joints: Vec::new(),
        is_reversed,
    }
}

fn cable_friction(value: &Value) -> FrictionLaw {
    let bristle = value["stiffness"].as_f64().map(|stiffness| {
        let relaxation_s = number(&value["relaxation"]);
        Bristle { damping_n_s_per_m: stiffness * relaxation_s, relaxation_s }
    });
    FrictionLaw {
        mu_static: number(&value["mu_static"]),
        mu_dynamic: number(&value["mu_dynamic"]),
        v_static_m_s: number(&value["v_static"]),
        v_dynamic_m_s: number(&value["v_dynamic"]),
        kind: bristle.into(),
    }
}

fn actuator(value: &Value, mechanism: &Mechanism) -> Actuator {
    let command = match value["kp"].as_f64() {
        Some(kp) => Command::Servo {
            kp,
            kd: or(&value["kd"], 0.0),
            target: profile(&value["target"]),
            target_rate: None,
            rate_hz: None,
        },
        None if value["motor"].is_object() => Command::Effort(profile(&value["motor"]["voltage"])),
        None => Command::Effort(profile(&value["torque"])),
    };
    let motor = &value["motor"];
    let loss_rate = or(&value["loss_rate"], 0.01);
    let bristle = value["loss_stiffness"]
        .as_f64()
        .map(|stiffness| Bristle { damping_n_s_per_m: stiffness * 1e-3, relaxation_s: 1e-3 });
    let powertrain = Powertrain {
        gear: or(&value["gear"], 1.0),
        rotor_kg_m2: or(&value["rotor"], 0.0),
        loss: value["efficiency"].as_f64().map(|efficiency| GearLoss { efficiency, rate: loss_rate, bristle }),
        motor: motor.is_object().then(|| Motor {
            torque_constant: number(&motor["torque_constant"]),
            resistance: number(&motor["resistance"]),
            current_limit: motor["current_limit"].as_f64(),
            back_emf: or(&motor["back_emf"], number(&motor["torque_constant"])),
            inductance: motor["inductance"].as_f64(),
        }),
        feedback: value["feedback"].is_object().then(|| DistanceFeedback {
            points: [0, 1].map(|k| point_id(&value["feedback"]["distance"][k], mechanism)),
            sign: or(&value["sign"], 1.0),
        }),
    };
    Actuator {
        name: text(&value["name"]),
        on: JointCombination::of_joint(joint_index(&text(&value["joint"]), mechanism)),
        command,
        // The reference program writes 1e300 for no limit.
        limit: value["limit"].as_f64().filter(|limit| *limit < 1e300),
        no_load_speed: value["no_load_speed"].as_f64(),
        brake: None,
        powertrain,
    }
}

fn point_id(value: &Value, mechanism: &Mechanism) -> PointId {
    let name = text(value);
    let (body, point) = name.split_once('.').expect("body.point");
    let body = body_index(body, mechanism);
    let points = body.map_or(&mechanism.ground_points, |body| &mechanism.bodies[body].points);
    PointId { body, point: points.iter().position(|other| other.name == point).expect("a point") }
}

fn sum_limit(value: &Value, mechanism: &Mechanism) -> SumLimit {
    let terms = object(&value["terms"]).map(|(joint, factor)| (joint_index(joint, mechanism), number(factor)));
    SumLimit {
        name: text(&value["name"]),
        on: JointCombination { terms: terms.collect(), offset: 0.0 },
        lower: value["lower"].as_f64(),
        upper: value["upper"].as_f64(),
        law: normal_law(&value["stop"]),
    }
}

fn contact(value: &Value, mechanism: &Mechanism) -> ContactPair {
    let friction = &value["friction"];
    let friction = friction.is_object().then(|| FrictionLaw {
        mu_static: number(&friction["mu_s"]),
        mu_dynamic: number(&friction["mu_d"]),
        v_static_m_s: number(&friction["v_s"]),
        v_dynamic_m_s: number(&friction["v_d"]),
        kind: FrictionKind::Regularised,
    });
    let force_point = match value["at"].as_str() {
        None | Some("face") => ForcePoint::Face,
        Some("points") => ForcePoint::Points,
        Some("middle") => ForcePoint::Middle,
        other => panic!("force point {other:?}"),
    };
    ContactPair {
        name: None,
        points: outline_id(&value["points"], mechanism),
        face: outline_id(&value["face"], mechanism),
        law: ContactLaw { normal: normal_law(value), friction },
        rolling: None,
        force_point,
        is_reported_on_face: false,
    }
}

fn normal_law(value: &Value) -> NormalLaw {
    let damping = match value["law"].as_str() {
        Some("hunt_crossley") => Damping::HuntCrossley { factor_s_per_m: number(&value["damping"]) },
        Some("step") => {
            Damping::Step { max_n_s_per_m: number(&value["damping"]), transition_m: number(&value["depth"]) }
        }
        other => panic!("law {other:?}"),
    };
    NormalLaw { stiffness_n_per_m_e: number(&value["stiffness"]), exponent: number(&value["exponent"]), damping }
}

fn profile(value: &Value) -> Profile {
    match value.as_f64() {
        Some(value) => Profile::Constant { value },
        None => Profile::Table {
            points: list(value).map(|point| (number(&point[0]), number(&point[1]))).collect(),
            interpolation: Interpolation::Linear,
        },
    }
}

fn body_index(name: &str, mechanism: &Mechanism) -> Option<usize> {
    (name != "ground").then(|| mechanism.bodies.iter().position(|body| body.name == name).expect("a body"))
}

fn bodies(value: &Value, mechanism: &Mechanism) -> [Option<usize>; 2] {
    [0, 1].map(|side| body_index(&text(&value[side]), mechanism))
}

fn joint_index(name: &str, mechanism: &Mechanism) -> usize {
    mechanism.joints.iter().position(|joint| joint.name == name).expect("a joint")
}

fn outline_id(value: &Value, mechanism: &Mechanism) -> OutlineId {
    let name = text(value);
    let (body, outline) = name.split_once('.').expect("body.outline");
    let body = body_index(body, mechanism);
    let outlines = body.map_or(&mechanism.ground_outlines, |body| &mechanism.bodies[body].outlines);
    OutlineId { body, outline: outlines.iter().position(|other| other.name == outline).expect("an outline") }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

fn or(value: &Value, default: f64) -> f64 {
    value.as_f64().unwrap_or(default)
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    std::array::from_fn(|i| number(&value[i]))
}

fn numbers_or_zero<const N: usize>(value: &Value) -> [f64; N] {
    if value.is_null() { [0.0; N] } else { numbers(value) }
}

fn text(value: &Value) -> String {
    value.as_str().expect("text").to_owned()
}

fn list(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn object(value: &Value) -> impl Iterator<Item = (&String, &Value)> {
    value.as_object().into_iter().flatten()
}

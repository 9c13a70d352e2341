//! Mechanisms: bodies with outlines, joints, springs, couplings, actuators, laws and contacts.
//!
//! Sections refer to each other by name. Lists of the [`Mechanism`] are in the order of the names.

use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::{Table, Value};

use super::law::FrictionSettings;
use super::names::{GROUND, find, find_at};
use super::outline::{OutlineSettings, outline, outline_settings, si};
use super::tendon::{self, Known, TendonSettings};
use super::{law, list, table};
use crate::law::{Bristle, ContactLaw, Damping, FrictionLaw, NormalLaw, damping_from_restitution};
use crate::limits::{MAX_BODIES, MAX_CONTACTS};
use crate::mechanism::{
    Actuator, Body, Command, Condition, ContactPair, Coupling, ForcePoint, Joint, JointCombination, JointKind,
    Mechanism, Outline, OutlineId, OutlineShape, PlaneArea, Pose, Spring, SpringKind, Tendon, TendonActuator, assemble,
    coordinate_in,
};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{rotate, sub};
use crate::scene::quantity::{
    Angle, AngularRate, Coordinate, CoordinateRate, Density, Effort, Force, Frequency, Inertia, JointDamping,
    JointInertia, JointStiffness, Keyword, LawDamping, Length, Mass, NotNegative, Plain, Positive, Quantity, Speed,
    Time, Torque, Word,
};
use crate::scene::section_input::{SceneInput, SectionInput};
use crate::scene::{Interpolation, Problem, Profile};
use crate::units::{Dimension, format};

/// Sections of a mechanism.
#[derive(JsonSchema)]
pub struct MechanismSettings {
    /// Bodies, one section per name, chosen freely: [bodies.driver]. `ground` is the fixed body.
    #[schemars(extend(
        "minProperties" = 1,
        "propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$", "not": { "const": "ground" } }
    ))]
    pub bodies: BTreeMap<String, LinkSettings>,
    pub ground: GroundSettings,
    /// Joints, one section per name. Joints may form loops; nothing marks the joint that closes one.
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub joints: BTreeMap<String, JointSettings>,
    /// Springs with a damper, one section per name.
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub springs: BTreeMap<String, LinkageSpringSettings>,
    /// Tendons, one section per name: cables over eyelets and pulleys.
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub tendons: BTreeMap<String, TendonSettings>,
    /// Linear relations of joint coordinates, one section per name: gears, synchronised jaws.
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub couplings: BTreeMap<String, CouplingSettings>,
    /// Actuators of joints and tendons, one section per name. Each has a torque (force) over time, or follows a target.
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub actuators: BTreeMap<String, ActuatorSettings>,
    /// Laws of contacts and joint limits, one section per name.
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub laws: BTreeMap<String, NamedLawSettings>,
    /// Pairs of outlines that may touch, each with the header [[contacts]].
    pub contacts: Vec<ContactEntry>,
}

/// A rigid body with its own frame.
#[derive(JsonSchema)]
pub struct LinkSettings {
    #[serde(flatten)]
    pub keys: LinkKeys,
    pub guess: GuessSettings,
    pub start: StartSettings,
    /// Outlines in the frame of the body, one section per name: [bodies.link.outlines.face].
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub outlines: BTreeMap<String, OutlineSettings>,
}

/// Keys of a body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct LinkKeys {
    /// Mass. Required, or `density`.
    #[schemars(extend("x-alternative" = "density",
        "x-required" = "add the mass: mass = \"9 g\"; or density and depth of the outlines"))]
    pub mass: Option<Positive<Mass>>,
    /// Moment of inertia about the centre of mass. Required, or `density`.
    #[schemars(extend("x-alternative" = "density",
        "x-required" = "add the moment of inertia about the centre of mass: inertia = \"200 g*mm^2\""))]
    pub inertia: Option<Positive<Inertia>>,
    /// Centre of mass in the frame of the body.
    #[schemars(extend("default" = ["0 mm", "0 mm"]))]
    pub com: [Quantity<Length>; 2],
    /// Density of the outlines of the body, in place of mass, inertia and centre of mass. The outlines must not overlap.
    pub density: Option<Positive<Density>>,
    /// Depth of the outlines. Required with `density`.
    pub depth: Option<Positive<Length>>,
}

/// Rough pose of a body with joints: it selects how the loops are assembled.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct GuessSettings {
    /// Position of the origin of the body's frame.
    #[schemars(extend("default" = ["0 mm", "0 mm"]))]
    pub at: [Quantity<Length>; 2],
    /// Angle of the body's frame.
    #[schemars(extend("default" = "0 deg"))]
    pub angle: Quantity<Angle>,
}

/// Pose and rate at the start of a body without joints.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct StartSettings {
    /// Position of the origin of the body's frame.
    #[schemars(extend("default" = ["0 mm", "0 mm"]))]
    pub at: [Quantity<Length>; 2],
    /// Angle of the body's frame.
    #[schemars(extend("default" = "0 deg"))]
    pub angle: Quantity<Angle>,
    /// Velocity of the origin.
    #[schemars(extend("default" = ["0 m/s", "0 m/s"]))]
    pub velocity: [Quantity<Speed>; 2],
    /// Angular rate.
    #[schemars(extend("default" = "0 rad/s"))]
    pub spin: Quantity<AngularRate>,
}

/// The fixed body, whose frame is that of the world.
#[derive(JsonSchema)]
pub struct GroundSettings {
    /// Outlines in the frame of the world, one section per name: [ground.outlines.floor].
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub outlines: BTreeMap<String, OutlineSettings>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointType {
    Revolute,
    Prismatic,
}

impl Keyword for JointType {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[("revolute", JointType::Revolute), ("prismatic", JointType::Prismatic)];
}

/// A joint of two bodies. Its coordinate is the angle of the second body against the first (revolute), or its position
/// along the axis (prismatic).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct JointSettings {
    /// "revolute": a pin; "prismatic": a slider without rotation.
    #[schemars(extend("default" = "revolute"))]
    pub r#type: Word<JointType>,
    /// The two bodies: ["ground", "driver"]. Required.
    #[schemars(extend("x-required" = "add the two bodies: bodies = [\"ground\", \"driver\"]"))]
    pub bodies: Option<[String; 2]>,
    /// Point of the joint in each body, in its own frame. Required, or `at`.
    #[schemars(extend("x-alternative" = "at",
        "x-required" = "add the point in the frame of each body: points = [[\"0 mm\", \"0 mm\"], [\"30 mm\", \"0 mm\"]]"))]
    pub points: Option<[[Quantity<Length>; 2]; 2]>,
    /// Point of the joint in the world, in place of `points`: the `guess` of both bodies must then be exact.
    pub at: Option<[Quantity<Length>; 2]>,
    /// Direction in which the second body slides, in the frame of the first.
    #[schemars(extend("x-with" = "type = prismatic", "default" = "0 deg"))]
    pub axis: Option<Quantity<Angle>>,
    /// Angle of the second body against the first at which a revolute joint has the coordinate 0, and at which a
    /// prismatic joint holds it.
    #[schemars(extend("default" = "0 deg"))]
    pub offset: Quantity<Angle>,
    /// Coordinate at the start. Default: it follows from other joints.
    pub start: Option<Quantity<Coordinate>>,
    /// Rate at the start, of a joint with `start`. Default: 0.
    pub start_rate: Option<Quantity<CoordinateRate>>,
    /// Damping. Default: none.
    pub damping: Option<NotNegative<JointDamping>>,
    /// Inertia of rotor and gear, reflected to the joint. Default: none.
    pub armature: Option<NotNegative<JointInertia>>,
    /// Torque (force) of Coulomb friction while the joint moves. Default: none.
    pub friction: Option<Positive<Effort>>,
    /// Largest torque (force) of friction, before the joint moves. Default: `friction`.
    pub static_friction: Option<Positive<Effort>>,
    /// Rates at which friction reaches `static_friction`, and from which it is `friction`. Default: 0.01 and 0.02 rad/s, of
    /// a prismatic joint 1 and 2 mm/s.
    pub friction_rates: Option<[Positive<CoordinateRate>; 2]>,
    /// Stiffness of a bristle, by which friction holds without creep. Default: none; below the first of `friction_rates`,
    /// the joint creeps.
    pub friction_stiffness: Option<Positive<JointStiffness>>,
    /// Lower limit of the coordinate. Default: none.
    pub lower: Option<Quantity<Coordinate>>,
    /// Upper limit of the coordinate. Default: none.
    pub upper: Option<Quantity<Coordinate>>,
    /// Name of the law of the limits. Required with a limit.
    #[schemars(extend("minLength" = 1))]
    pub stop: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpringType {
    Torsional,
    Linear,
}

impl Keyword for SpringType {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[("torsional", SpringType::Torsional), ("linear", SpringType::Linear)];
}

/// A spring with a damper.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct LinkageSpringSettings {
    /// "torsional": acts on the coordinate of a joint; "linear": between points of two bodies.
    #[schemars(extend("default" = "torsional"))]
    pub r#type: Word<SpringType>,
    /// Joint of a torsional spring.
    #[schemars(extend("minLength" = 1, "x-with" = "type = torsional", "x-required" = "add the joint: joint = \"driver\""))]
    pub joint: Option<String>,
    /// Bodies of a linear spring.
    #[schemars(extend("x-with" = "type = linear", "x-required" = "add the two bodies: bodies = [\"ground\", \"driver\"]"))]
    pub bodies: Option<[String; 2]>,
    /// Ends of a linear spring in the frames of its bodies.
    #[schemars(extend("x-with" = "type = linear",
        "x-required" = "add both ends: points = [[\"0 mm\", \"0 mm\"], [\"30 mm\", \"0 mm\"]]"))]
    pub points: Option<[[Quantity<Length>; 2]; 2]>,
    /// Stiffness. Required.
    #[schemars(extend("x-required" = "add the stiffness: stiffness = \"0.1 N*m/rad\", or \"400 N/m\" of a linear spring"))]
    pub stiffness: Option<NotNegative<JointStiffness>>,
    /// Damping. Default: none.
    pub damping: Option<NotNegative<JointDamping>>,
    /// Coordinate or length without elastic force. Default: 0.
    pub rest: Option<Quantity<Coordinate>>,
    /// Constant torque (force) of a torsional spring in addition, its preload. Default: 0.
    #[schemars(extend("x-with" = "type = torsional"))]
    pub torque: Option<Quantity<Effort>>,
}

/// The sum of joint coordinates times factors is constant.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct CouplingSettings {
    /// The coupled joints. Required.
    #[schemars(extend("x-required" = "add the joints: joints = [\"right\", \"left\"]"))]
    pub joints: Option<Vec<String>>,
    /// A factor for each joint. Required.
    #[schemars(extend("x-required" = "add a factor for each joint: factors = [1, -1] for equal coordinates"))]
    pub factors: Option<Vec<Quantity<Plain>>>,
    /// The sum. Default: 0.
    pub value: Option<Quantity<Coordinate>>,
}

/// An actuator of a joint: a torque (force) over time, or a controller that follows a target. The torque is limited, and
/// falls with the speed.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct ActuatorSettings {
    /// The driven joint. Required, or `tendon`.
    #[schemars(extend("minLength" = 1, "x-alternative" = "tendon", "x-required" = "add the driven joint: joint = \"driver\""))]
    pub joint: Option<String>,
    /// The pulled tendon, in place of `joint`.
    #[schemars(extend("minLength" = 1))]
    pub tendon: Option<String>,
    /// Constant tension of a tendon.
    pub tension: Option<NotNegative<Force>>,
    /// Tensions of a tendon at `times`.
    pub tensions: Option<Vec<NotNegative<Force>>>,
    /// Constant torque of a revolute joint.
    pub torque: Option<Quantity<Torque>>,
    /// Constant force of a prismatic joint.
    pub force: Option<Quantity<Force>>,
    /// Times of `torques`, `forces`, `tensions` or `targets`, increasing. Values are linear between the times, and constant before the
    /// first and after the last.
    pub times: Option<Vec<Quantity<Time>>>,
    /// Torques at `times`.
    pub torques: Option<Vec<Quantity<Torque>>>,
    /// Forces at `times`.
    pub forces: Option<Vec<Quantity<Force>>>,
    /// Coordinate that the controller follows.
    pub target: Option<Quantity<Coordinate>>,
    /// Coordinates at `times` that the controller follows.
    pub targets: Option<Vec<Quantity<Coordinate>>>,
    /// Largest rate of the set point, which begins at the coordinate at the start and follows `target` or `targets`.
    /// Default: none; the set point is the target.
    pub target_rate: Option<Positive<CoordinateRate>>,
    /// Gain on the error of the coordinate. Default: 0, for a target whose rate alone is followed.
    pub kp: Option<NotNegative<JointStiffness>>,
    /// Gain on the error of the rate. Default: 0.
    pub kd: Option<NotNegative<JointDamping>>,
    /// Rate at which the controller is computed; its torque (force) is constant in between. Default: it is continuous.
    pub rate: Option<Positive<Frequency>>,
    /// Largest torque (force). Default: none.
    pub limit: Option<Positive<Effort>>,
    /// Rate at which the torque (force) has fallen to 0. Default: it does not fall.
    pub no_load_speed: Option<Positive<CoordinateRate>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LawType {
    HuntCrossley,
    Restitution,
    SpringDamper,
    Step,
}

impl Keyword for LawType {
    const KEYWORDS: &'static [(&'static str, Self)] = &[
        ("hunt_crossley", LawType::HuntCrossley),
        ("restitution", LawType::Restitution),
        ("spring_damper", LawType::SpringDamper),
        ("step", LawType::Step),
    ];
}

/// A law of contacts or joint limits: a normal law, and friction of contacts.
#[derive(JsonSchema)]
pub struct NamedLawSettings {
    #[serde(flatten)]
    pub keys: NamedLawKeys,
    pub friction: FrictionSettings,
}

/// Keys of a law.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct NamedLawKeys {
    /// "hunt_crossley": k δ^e (1 + 1.5 a δ'), recommended; "restitution": the same with a from the rebound of a free mass;
    /// "spring_damper": k δ^e + c δ'; "step": k δ^e + c δ' with a damper that engages over `transition`.
    #[schemars(extend("default" = "hunt_crossley"))]
    pub r#type: Word<LawType>,
    /// Stiffness k in N/m^e (limit: N·m/rad^e), a plain number because its unit depends on the exponent e. Required.
    #[schemars(extend("x-required" = "add the stiffness in N/m^e (limit: N·m/rad^e): stiffness = 1e6"))]
    pub stiffness: Option<Positive<Plain>>,
    /// Exponent e, at least 1.
    #[schemars(extend("default" = 1.5, "minimum" = 1.0))]
    pub exponent: Quantity<Plain>,
    /// Factor a of "hunt_crossley", in s/m (limit: s/rad); damping c of the others, with "step" fully engaged beyond the
    /// transition. Default: none.
    #[schemars(extend("x-with" = "type = hunt_crossley|spring_damper|step"))]
    pub damping: Option<NotNegative<LawDamping>>,
    /// Speed of rebound over speed of impact of a free mass at `speed`, above 0 and at most 1.
    #[schemars(extend("x-with" = "type = restitution", "exclusiveMinimum" = 0.0, "maximum" = 1.0,
        "x-required" = "add the coefficient of restitution: restitution = 0.6"))]
    pub restitution: Option<Quantity<Plain>>,
    /// Impact speed at which the rebound has this coefficient; slower impacts rebound better.
    #[schemars(extend("x-with" = "type = restitution", "x-required" = "add the impact speed: speed = \"0.5 m/s\", or a rate \
        for a limit"))]
    pub speed: Option<Positive<CoordinateRate>>,
    /// Penetration over which the damper engages.
    #[schemars(extend("x-with" = "type = step", "x-required" = "add the penetration over which the damper engages: \
        transition = \"0.1 mm\", or an angle for a limit"))]
    pub transition: Option<Positive<Coordinate>>,
}

/// Outlines that may touch.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct ContactEntry {
    /// Two outlines, each as `body.outline`, as `body` (all its outlines), or as a pattern: "finger_*.pad" are the pads of
    /// all bodies whose names begin with finger_. All corners of either touch the other; a disc or an ellipse touches with
    /// its points only. Required, or `points`.
    #[schemars(extend("x-alternative" = "points",
        "x-required" = "add two outlines or bodies: between = [\"palm\", \"object\"]"))]
    pub between: Option<[String; 2]>,
    /// In place of `between`: the outline whose points touch, as `body.outline`. A disc and an ellipse have one point, a
    /// capsule two, a polygon its corners. Two outlines that both have corners need an entry in each direction.
    #[schemars(extend("minLength" = 1))]
    pub points: Option<String>,
    /// Outline that the points touch. Required with `points`, or `faces`.
    #[schemars(extend("minLength" = 1, "x-alternative" = "faces|between",
        "x-required" = "add the outline that they touch: face = \"link.pad\", or a list: faces = [\"link.pad\"]"))]
    pub face: Option<String>,
    /// Several outlines that they touch, in place of `face`.
    pub faces: Option<Vec<String>>,
    /// Name of the law. Required.
    #[schemars(extend("minLength" = 1, "x-required" = "add the name of a law: law = \"pad\", with a section [laws.pad]"))]
    pub law: Option<String>,
    /// Rolling resistance: the lever arm of a moment against the relative rotation, times the normal force. Default: none.
    pub rolling_arm: Option<Positive<Length>>,
    /// Relative rate from which the moment is full; below it, bodies creep.
    #[schemars(extend("default" = "0.1 rad/s"))]
    pub rolling_rate: Positive<AngularRate>,
    /// Where the force acts: on the surface of the face, on that of the points, in the middle of the overlap, or for
    /// each body on its own surface.
    #[schemars(extend("default" = "face"))]
    pub at: Word<ForcePoint>,
}

impl Keyword for ForcePoint {
    const KEYWORDS: &'static [(&'static str, Self)] = &[
        ("face", ForcePoint::Face),
        ("points", ForcePoint::Points),
        ("middle", ForcePoint::Middle),
        ("each", ForcePoint::Each),
    ];
}

/// Resolves a mechanism and assembles it; `None` if any part is invalid.
pub fn mechanism(input: &SceneInput, root: &SectionInput<'_>, gravity_m_s2: [f64; 2]) -> Option<Mechanism> {
    let sections = |key: &str| {
        let sections = root.subsection(key).subsections();
        sections.iter().for_each(|(name, section)| check_name(input, section, key, name));
        sections
    };
    let [bodies, joints, springs, tendons, couplings, actuators, laws] =
        ["bodies", "joints", "springs", "tendons", "couplings", "actuators", "laws"].map(sections);
    if bodies.is_empty() {
        let help = "add at least one body: [bodies.link] with mass, inertia and guess";
        root.checker.report_missing_at("[bodies.NAME]", root.subsection("bodies").span, help);
        return None;
    }
    if bodies.len() > MAX_BODIES {
        let message = format!("there are {} bodies, but at most {MAX_BODIES} are allowed", bodies.len());
        return root.subsection("bodies").refuse("", message, "", format!("remove {}", bodies.len() - MAX_BODIES));
    }
    let ground = root.subsection("ground").subsection("outlines");
    let ground_outlines = outlines(input, &ground);
    let body_names: Vec<&str> = bodies.iter().map(|(name, _)| *name).collect();
    let joint_names: Vec<&str> = joints.iter().map(|(name, _)| *name).collect();
    let joint_bodies: Vec<Option<[Option<usize>; 2]>> =
        joints.iter().map(|(_, section)| two_bodies(section, &body_names, "a joint")).collect();
    let is_jointed = |body: usize| joint_bodies.iter().flatten().flatten().any(|other| *other == Some(body));
    // A joint that names no body may concern any of them.
    let all_known = joint_bodies.iter().all(Option::is_some);
    let bodies: Vec<Option<Body>> = bodies
        .iter()
        .enumerate()
        .map(|(k, (name, section))| body(input, name, section, all_known.then(|| is_jointed(k))))
        .collect();
    let laws: Vec<(&str, Option<NamedLaw>)> = laws.iter().map(|(name, section)| (*name, named_law(section))).collect();
    let all_joints: Vec<Option<Joint>> = joints
        .iter()
        .zip(&joint_bodies)
        .map(|((name, section), between)| joint(name, section, *between, &bodies, &laws))
        .collect();
    let kinds: Vec<Option<JointKind>> = joints.iter().map(|(_, section)| joint_kind(section)).collect();
    let known_joints = Joints { names: &joint_names, kinds: &kinds };
    let springs: Vec<Option<Spring>> =
        springs.iter().map(|(name, section)| spring(name, section, &body_names, &known_joints)).collect();
    let known = Known { bodies: &body_names, joints: &joint_names, kinds: &kinds };
    let mut all_tendons: Vec<_> = tendons.iter().map(|(name, section)| tendon::tendon(name, section, &known)).collect();
    let (pulls, motors): (Vec<_>, Vec<_>) = actuators.into_iter().partition(|(_, section)| section.has("tendon"));
    let tendon_names: Vec<&str> = tendons.iter().map(|(name, _)| *name).collect();
    pulls.iter().for_each(|(name, section)| pull(name, section, &tendon_names, &mut all_tendons));
    let all_couplings: Vec<Option<Coupling>> =
        couplings.iter().map(|(name, section)| coupling(name, section, &known_joints)).collect();
    let actuators: Vec<Option<Actuator>> =
        motors.iter().map(|(name, section)| actuator(name, section, &known_joints)).collect();
    let mut mechanism = Mechanism {
        gravity_m_s2,
        // Contacts refer to all outlines.
        bodies: bodies.into_iter().collect::<Option<_>>()?,
        ground_outlines: ground_outlines?,
        joints: all_joints.into_iter().collect::<Option<_>>()?,
        couplings: all_couplings.into_iter().collect::<Option<_>>()?,
        springs: springs.into_iter().collect::<Option<_>>()?,
        tendons: all_tendons.into_iter().collect::<Option<_>>()?,
        actuators: actuators.into_iter().collect::<Option<_>>()?,
        rotors: Vec::new(),
        contacts: Vec::new(),
    };
    mechanism.contacts = contacts(root, &mechanism, &laws)?;
    // A start that does not fit is reported only if everything else is valid.
    if root.checker.is_clean() {
        match assemble(&mechanism) {
            Ok(start) => {
                tendon::tension(&mut mechanism, &tendons, &start.poses);
                limit_target_rates(&mut mechanism, &motors, &start.poses);
            }
            Err(error) => {
                let (section, key) = match error.condition() {
                    Condition::Joint(joint) => (&joints[joint].1, ""),
                    Condition::Coupling(coupling) => (&couplings[coupling].1, ""),
                    Condition::Start(joint) => (&joints[joint].1, "start"),
                };
                let message = error.to_string();
                let (message, help) = message.split_once(": ").unwrap_or((&message, ""));
                section.report(key, message, "cannot be assembled", help);
            }
        }
    }
    Some(mechanism)
}

/// Checks a name: names are used in topics, keys and columns.
fn check_name(input: &SceneInput, section: &SectionInput<'_>, key: &str, name: &str) {
    let is_valid = name.starts_with(|first: char| first.is_ascii_alphabetic())
        && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
    let message = match name {
        GROUND if key == "bodies" => {
            format!("`{GROUND}` cannot be the name of a body: it is the fixed body, with outlines in [ground.outlines]")
        }
        _ if is_valid => return,
        _ => format!("`{}` cannot be a name in [{key}]", name.escape_debug()),
    };
    let span = input.name_span(&section.path("")).or(section.span.clone());
    let help = format!("use a letter followed by letters, digits and _, as in [{key}.link_2]");
    section.checker.push(Problem::new(span, message, "invalid name", help));
}

/// Finds the two bodies of a joint or a spring.
fn two_bodies(input: &SectionInput<'_>, names: &[&str], what: &str) -> Option<[Option<usize>; 2]> {
    #[derive(Deserialize)]
    struct Names {
        bodies: Option<[String; 2]>,
    }
    let Names { bodies } = input.read_quietly();
    let bodies = bodies?;
    let known: Vec<&str> = [GROUND].into_iter().chain(names.iter().copied()).collect();
    let found: Vec<Option<usize>> = bodies
        .iter()
        .enumerate()
        .map(|(k, name)| find_at(input, input.item_span("bodies", k), "bodies", name, "body", &known))
        .collect();
    let [a, b] = [found[0]?, found[1]?];
    if a == b {
        let message = format!("`{}` names `{}` twice, but {what} connects two bodies", input.path("bodies"), bodies[0]);
        return input.refuse("bodies", message, "the same body", "name two bodies; `ground` is the fixed one");
    }
    Some([a, b].map(|body| body.checked_sub(1)))
}

/// Resolves a body; `is_jointed` is `None` if it is unknown.
fn body(input: &SceneInput, name: &str, section: &SectionInput<'_>, is_jointed: Option<bool>) -> Option<Body> {
    let keys: LinkKeys = section.read();
    let (guess, start) = (section.subsection("guess"), section.subsection("start"));
    let outlines = outlines(input, &section.subsection("outlines"));
    match is_jointed {
        Some(true) if start.is_present() => {
            let message = format!("`{}` is for bodies without joints, but `{name}` has joints", start.path(""));
            let help =
                "give its rough pose in `guess`, and the start of its joints: start = \"0 deg\" in [joints.NAME]";
            start.report("", message, "for bodies without joints", help);
        }
        Some(false) if guess.is_present() => {
            let message = format!("`{}` is for bodies with joints, but `{name}` has none", guess.path(""));
            guess.report(
                "",
                message,
                "for bodies with joints",
                "rename it to `start`, which may also have a velocity and a spin",
            );
        }
        _ => {}
    }
    let GuessSettings { at, angle } = guess.read();
    let mut pose = [*at[0], *at[1], *angle];
    let mut rate = [0.0; 3];
    if start.is_present() {
        let StartSettings { at, angle, velocity, spin } = start.read();
        (pose, rate) = ([*at[0], *at[1], *angle], [*velocity[0], *velocity[1], *spin]);
    }
    let outlines = outlines?;
    let (mass_kg, inertia_kg_m2, com_m) = inertia(section, &keys, &outlines)?;
    Some(Body { name: name.to_owned(), mass_kg, inertia_kg_m2, com_m, pose, rate, motion: None, outlines })
}

/// Mass, moment of inertia and centre of mass of a body.
fn inertia(section: &SectionInput<'_>, keys: &LinkKeys, outlines: &[Outline]) -> Option<(f64, f64, [f64; 2])> {
    let Some(density) = keys.density else {
        section.report_unused("depth", "without `density`");
        return Some((*keys.mass?, *keys.inertia?, si(keys.com)));
    };
    ["mass", "inertia", "com"].iter().for_each(|key| section.report_unused(key, "with `density`"));
    let areas: Option<Vec<PlaneArea>> = outlines.iter().map(|outline| outline.shape.area()).collect();
    let Some(areas) = areas.filter(|areas| !areas.is_empty()) else {
        let message = format!("`{}` needs outlines with an area", section.path("density"));
        let help = "add an outline that is not a half plane, or give mass and inertia";
        return section.refuse("density", message, "no area", help);
    };
    if keys.depth.is_none() {
        section.report_missing("depth", "add the depth of the outlines: depth = \"20 mm\"");
    }
    let (total, per_area) = (PlaneArea::sum(&areas), *density * *keys.depth?);
    Some((per_area * total.area_m2, per_area * total.polar_m4, total.centroid_m))
}

fn outlines(input: &SceneInput, section: &SectionInput<'_>) -> Option<Vec<Outline>> {
    let sections = section.subsections();
    sections.iter().for_each(|(name, each)| check_name(input, each, &section.path(""), name));
    let all: Vec<_> = sections.iter().map(|(name, section)| outline(name, section)).collect();
    all.into_iter().collect()
}

/// Whether a quantity belongs to translation; `None` for one of both.
fn is_linear(dimension: Dimension) -> bool {
    use Dimension as D;
    matches!(
        dimension,
        D::Length | D::Speed | D::Mass | D::Force | D::LinearStiffness | D::LinearDamping | D::LinearImpactDamping
    )
}

/// Checks that the given values of these keys have the units of a joint that slides or turns.
fn check_units(input: &SectionInput<'_>, keys: &[&str], linear: bool, of: &str) -> bool {
    let mut is_valid = true;
    for key in keys {
        let wrong = input.dimensions(key).into_iter().find(|dimension| is_linear(*dimension) != linear);
        let Some(wrong) = wrong else { continue };
        let right = input.alternatives(key).into_iter().find(|dimension| is_linear(*dimension) == linear);
        let Some(right) = right else { continue };
        let message = format!("`{}` is {}, but {of} needs {}", input.path(key), wrong.name(), right.name());
        input.report(key, message, right.name(), format!("write it as in \"{}\"", right.example()));
        is_valid = false;
    }
    is_valid
}

fn joint_kind(section: &SectionInput<'_>) -> Option<JointKind> {
    #[derive(Deserialize)]
    struct Kind {
        r#type: Word<JointType>,
        axis: Option<Quantity<Angle>>,
    }
    section.is_valid("type").then_some(())?;
    let Kind { r#type, axis } = section.read_quietly();
    Some(match r#type.0 {
        JointType::Revolute => JointKind::Revolute,
        JointType::Prismatic => JointKind::Prismatic { axis_rad: axis.map_or(0.0, |axis| *axis) },
    })
}

/// Words for messages: whether a joint slides, and its kind.
fn joint_words(kind: JointKind) -> (bool, &'static str) {
    match kind {
        JointKind::Revolute => (false, "a revolute joint"),
        JointKind::Prismatic { .. } => (true, "a prismatic joint"),
    }
}

fn joint(
    name: &str,
    section: &SectionInput<'_>,
    bodies: Option<[Option<usize>; 2]>,
    all_bodies: &[Option<Body>],
    laws: &[(&str, Option<NamedLaw>)],
) -> Option<Joint> {
    let settings: JointSettings = section.read();
    let kind = joint_kind(section)?;
    let (linear, of) = joint_words(kind);
    let keys = [
        "start",
        "start_rate",
        "damping",
        "armature",
        "friction",
        "static_friction",
        "friction_rates",
        "friction_stiffness",
        "lower",
        "upper",
    ];
    let units_fit = check_units(section, &keys, linear, of);
    if settings.start.is_none() {
        section.report_unused("start_rate", "without `start`");
    }
    if section.has("points") {
        section.report_unused("at", "with `points`");
    }
    let limits = [settings.lower, settings.upper].map(|limit| limit.map(|limit| *limit));
    let limit = match (&settings.stop, limits) {
        (None, [None, None]) => None,
        (Some(_), [None, None]) => {
            section.report_unused("stop", "without `lower` or `upper`");
            None
        }
        (None, _) => {
            section.report_missing(
                "stop",
                "add the name of the law of the limits: stop = \"stop\", with a section [laws.stop]",
            );
            return None;
        }
        (Some(stop), _) => Some(law_for(section, "stop", stop, laws, linear, &format!("the limit of {of}"))?.normal),
    };
    if let [Some(lower), Some(upper)] = limits
        && lower >= upper
    {
        let message = format!("`{}` must be below `upper`", section.path("lower"));
        return section.refuse("lower", message, "not below `upper`", "swap the limits, or remove one");
    }
    let friction = joint_friction(section, &settings, linear)?;
    let bodies = bodies?;
    let points_m = match (settings.points, settings.at) {
        (Some(points), _) => points.map(si),
        (None, Some(at)) => {
            let mut points = [si(at); 2];
            for (point, body) in points.iter_mut().zip(bodies) {
                let Some(body) = body else { continue };
                let [x, y, angle] = all_bodies[body].as_ref()?.pose;
                let (sin, cos) = sin_cos(angle);
                *point = rotate(sub(*point, [x, y]), [cos, -sin]);
            }
            points
        }
        (None, None) => return None,
    };
    units_fit.then(|| Joint {
        name: name.to_owned(),
        kind,
        bodies,
        points_m,
        offset_rad: *settings.offset,
        start: settings.start.map(|start| *start),
        start_rate: settings.start_rate.map_or(0.0, |rate| *rate),
        damping: settings.damping.map_or(0.0, |damping| *damping),
        armature: settings.armature.map_or(0.0, |armature| *armature),
        friction,
        lower: limits[0],
        upper: limits[1],
        limit,
    })
}

/// Relaxation time of the bristle of a joint, s.
const BRISTLE_RELAXATION_S: f64 = 1e-3;

/// Friction of a joint, as the law under a normal force of 1; the outer `None` if it is invalid.
fn joint_friction(section: &SectionInput<'_>, settings: &JointSettings, linear: bool) -> Option<Option<FrictionLaw>> {
    let Some(friction) = settings.friction else {
        for key in ["static_friction", "friction_rates", "friction_stiffness"] {
            section.report_unused(key, "without `friction`");
        }
        return Some(None);
    };
    let default_rates = if linear { [1e-3, 2e-3] } else { [0.01, 0.02] };
    let [v_static_m_s, v_dynamic_m_s] = settings.friction_rates.map_or(default_rates, |rates| rates.map(|rate| *rate));
    let law = FrictionLaw {
        mu_static: settings.static_friction.map_or(*friction, |friction| *friction),
        mu_dynamic: *friction,
        v_static_m_s,
        v_dynamic_m_s,
        bristle: settings.friction_stiffness.map(|stiffness| Bristle {
            damping_n_s_per_m: *stiffness * BRISTLE_RELAXATION_S,
            relaxation_s: BRISTLE_RELAXATION_S,
        }),
    };
    if law.mu_static < law.mu_dynamic {
        let message = format!("`{}` is below `friction`", section.path("static_friction"));
        let help = "raise it, or remove it (default: friction)";
        return section.refuse("static_friction", message, "below `friction`", help);
    }
    if v_static_m_s >= v_dynamic_m_s {
        let message = format!("the first of `{}` must be below the second", section.path("friction_rates"));
        return section.refuse("friction_rates", message, "not increasing", "write them in increasing order");
    }
    Some(Some(law))
}

/// The joints that other sections name.
struct Joints<'a> {
    names: &'a [&'a str],
    kinds: &'a [Option<JointKind>],
}

impl Joints<'_> {
    /// Finds a joint and its kind.
    fn find(&self, input: &SectionInput<'_>, key: &str, name: &str) -> Option<(usize, JointKind)> {
        let index = find(input, key, name, "joint", self.names)?;
        Some((index, self.kinds[index]?))
    }
}

fn spring(name: &str, section: &SectionInput<'_>, bodies: &[&str], joints: &Joints<'_>) -> Option<Spring> {
    let settings: LinkageSpringSettings = section.read();
    section.is_valid("type").then_some(())?;
    let (kind, linear, of) = match settings.r#type.0 {
        SpringType::Torsional => {
            let (joint, kind) = joints.find(section, "joint", &settings.joint?)?;
            let (linear, of) = joint_words(kind);
            (
                SpringKind::Torsional {
                    on: JointCombination::of_joint(joint),
                    preload: settings.torque.map_or(0.0, |torque| *torque),
                },
                linear,
                of,
            )
        }
        SpringType::Linear => {
            let bodies = two_bodies(section, bodies, "a linear spring")?;
            (SpringKind::Linear { bodies, points_m: settings.points?.map(si) }, true, "a linear spring")
        }
    };
    check_units(section, &["stiffness", "damping", "rest", "torque"], linear, of).then_some(())?;
    Some(Spring {
        name: name.to_owned(),
        kind,
        stiffness: *settings.stiffness?,
        damping: settings.damping.map_or(0.0, |damping| *damping),
        rest: settings.rest.map_or(0.0, |rest| *rest),
    })
}

fn coupling(name: &str, section: &SectionInput<'_>, joints: &Joints<'_>) -> Option<Coupling> {
    let CouplingSettings { joints: names, factors, value } = section.read();
    let (names, factors) = (names?, factors?);
    if names.len() != factors.len() || names.len() < 2 {
        let message = format!(
            "`{}` has {} joints and {} factors, but needs a factor for each of at least two joints",
            section.path(""),
            names.len(),
            factors.len()
        );
        return section.refuse("factors", message, "one factor per joint", "write as many factors as joints");
    }
    let found: Vec<Option<(usize, JointKind)>> =
        names.iter().map(|name| joints.find(section, "joints", name)).collect();
    let found: Vec<(usize, JointKind)> = found.into_iter().collect::<Option<_>>()?;
    if let Some(repeated) = names.iter().enumerate().find(|(k, name)| names[..*k].contains(name)) {
        let message = format!("`{}` names `{}` twice", section.path("joints"), repeated.1);
        return section.refuse("joints", message, "named twice", "name every joint once, with the sum of its factors");
    }
    let (linear, of) = joint_words(found[0].1);
    check_units(section, &["value"], linear, of).then_some(())?;
    let terms = found.iter().zip(&factors).map(|((joint, _), factor)| (*joint, **factor));
    let on = JointCombination { terms: terms.collect(), offset: value.map_or(0.0, |value| *value) };
    Some(Coupling { name: name.to_owned(), on })
}

/// Keys of an actuator of a joint whose units depend on the joint.
const JOINT_UNIT_KEYS: [&str; 11] =
    ["torque", "force", "torques", "forces", "target", "targets", "kp", "kd", "target_rate", "limit", "no_load_speed"];

fn actuator(name: &str, section: &SectionInput<'_>, joints: &Joints<'_>) -> Option<Actuator> {
    let settings: ActuatorSettings = section.read();
    let (joint, kind) = joints.find(section, "joint", settings.joint.as_ref()?)?;
    let (linear, of) = joint_words(kind);
    let units_fit = check_units(section, &JOINT_UNIT_KEYS, linear, of);
    let commands = ["torque", "force", "torques", "forces", "target", "targets"];
    let given: Vec<&str> = commands.into_iter().filter(|key| section.has(key)).collect();
    let [key] = given[..] else {
        let effort = if linear { "force = \"5 N\"" } else { "torque = \"0.25 N*m\"" };
        let help = format!("write {effort}, or a target with the gains of a controller: target, kp, kd");
        if given.is_empty() {
            let message = format!("actuator `{name}` has neither a torque or force nor a target");
            return section.refuse("", message, "no command", help);
        }
        let message = format!("actuator `{name}` has several commands: {}", given.join(", "));
        return section.refuse(given[1], message, "one command only", format!("keep one of them; {help}"));
    };
    let constant = |value: f64| Some(Profile::Constant { value });
    let profile = match key {
        "torque" => constant(*settings.torque?),
        "force" => constant(*settings.force?),
        "target" => constant(*settings.target?),
        "torques" => values_over_time(section, key, settings.times, settings.torques?),
        "forces" => values_over_time(section, key, settings.times, settings.forces?),
        _ => values_over_time(section, key, settings.times, settings.targets?),
    };
    if !key.ends_with('s') {
        section.report_unused("times", &format!("with `{key}`"));
    }
    let command = if key.starts_with("target") {
        let [kp, kd] = [settings.kp.map(|kp| *kp), settings.kd.map(|kd| *kd)];
        if kp.is_none() && kd.is_none() {
            let help = if linear {
                "kp = \"2e4 N/m\", kd = \"60 N*s/m\""
            } else {
                "kp = \"5 N*m/rad\", kd = \"0.05 N*m*s/rad\""
            };
            section.report_missing("kp", &format!("add the gains of the controller: {help}"));
            return None;
        }
        let rate_hz = settings.rate.map(|rate| *rate);
        Command::Servo { kp: kp.unwrap_or(0.0), kd: kd.unwrap_or(0.0), target: profile?, rate_hz }
    } else {
        ["kp", "kd", "target_rate", "rate"]
            .iter()
            .for_each(|gain| section.report_unused(gain, &format!("with `{key}`: there is no target")));
        Command::Effort(profile?)
    };
    units_fit.then(|| Actuator {
        name: name.to_owned(),
        on: JointCombination::of_joint(joint),
        command,
        limit: settings.limit.map(|limit| *limit),
        no_load_speed: settings.no_load_speed.map(|speed| *speed),
        brake: None,
    })
}

/// Limits the rates of set points, which begin at the coordinates of these poses.
fn limit_target_rates(mechanism: &mut Mechanism, sections: &[(&str, SectionInput<'_>)], poses: &[Pose]) {
    for (actuator, (_, section)) in mechanism.actuators.iter_mut().zip(sections) {
        let ActuatorSettings { target_rate, .. } = section.read_quietly();
        if let (Some(rate), Command::Servo { target, .. }) = (target_rate, &mut actuator.command) {
            let terms = actuator.on.terms.iter();
            let start = terms.map(|(joint, factor)| factor * coordinate_in(&mechanism.joints[*joint], poses));
            *target = target.rate_limited(start.sum::<f64>() - actuator.on.offset, *rate);
        }
    }
}

/// Resolves the actuator of a tendon.
fn pull(name: &str, section: &SectionInput<'_>, names: &[&str], tendons: &mut [Option<Tendon>]) {
    let ActuatorSettings { tendon, tension, tensions, times, .. } = section.read();
    let of_joints = ["joint"].iter().chain(&JOINT_UNIT_KEYS);
    of_joints.for_each(|key| section.report_unused(key, "with `tendon`"));
    let tension = match (tension, tensions) {
        (Some(value), _) => {
            ["times", "tensions"].iter().for_each(|key| section.report_unused(key, "with `tension`"));
            Some(Profile::Constant { value: *value })
        }
        (None, Some(values)) => values_over_time(section, "tensions", times, values),
        (None, None) => {
            section.report_missing("tension", "add the tension: tension = \"30 N\", or times and tensions");
            None
        }
    };
    let index = tendon.and_then(|tendon| find(section, "tendon", &tendon, "tendon", names));
    let Some(tendon) = index.and_then(|index| tendons[index].as_mut()) else { return };
    if let Some(other) = &tendon.actuator {
        let message = format!("the tendon `{}` has two actuators, {} and {name}", tendon.name, other.name);
        section.report("tendon", message, "pulled twice", "remove one of them, and add up the tensions");
    }
    tendon.actuator = tension.map(|tension| TendonActuator { name: name.to_owned(), tension });
}

/// A table of values over increasing times.
fn values_over_time<D, R>(
    section: &SectionInput<'_>,
    key: &str,
    times: Option<Vec<Quantity<Time>>>,
    values: Vec<Quantity<D, R>>,
) -> Option<Profile> {
    let Some(times) = times else {
        section.report_missing("times", &format!("add the times of `{key}`: times = [\"0 ms\", \"20 ms\"]"));
        return None;
    };
    if times.len() != values.len() || times.is_empty() {
        let message = format!("`{}` has {} values for {} times", section.path(key), values.len(), times.len());
        return section.refuse(key, message, "one value per time", "write as many values as times, at least one");
    }
    if let Some(k) = (1..times.len()).find(|k| *times[*k] <= *times[*k - 1]) {
        let message = format!("time {} of `{}` is not after the one before it", k + 1, section.path("times"));
        let span = section.item_span("times", k);
        section.checker.push(Problem::new(
            span,
            message,
            "not increasing",
            "sort the times; two values need two times",
        ));
        return None;
    }
    let points = times.iter().zip(&values).map(|(time, value)| (**time, **value)).collect();
    Some(Profile::Table { points, interpolation: Interpolation::Linear })
}

/// A law with the units of its damper.
struct NamedLaw {
    law: ContactLaw,
    /// Whether damping and transition are those of contacts; `None` if they are not given.
    linear: Option<bool>,
}

fn named_law(section: &SectionInput<'_>) -> Option<NamedLaw> {
    let NamedLawKeys { r#type, stiffness, exponent, damping, restitution, speed, transition } = section.read();
    section.is_valid("type").then_some(())?;
    let friction = law::friction_of(section);
    let given = section.dimensions("damping").first().copied();
    let (of, fits): (_, fn(Dimension) -> bool) = match r#type.0 {
        LawType::HuntCrossley => ("hunt_crossley", |dimension| {
            matches!(dimension, Dimension::LinearImpactDamping | Dimension::AngularImpactDamping)
        }),
        LawType::Restitution => ("restitution", |_| false),
        LawType::SpringDamper => {
            ("spring_damper", |dimension| matches!(dimension, Dimension::LinearDamping | Dimension::AngularDamping))
        }
        LawType::Step => {
            ("step", |dimension| matches!(dimension, Dimension::LinearDamping | Dimension::AngularDamping))
        }
    };
    if let Some(wrong) = given.filter(|given| !fits(*given)) {
        let right: Vec<Dimension> = section.alternatives("damping").into_iter().filter(|d| fits(*d)).collect();
        let examples: Vec<String> = right.iter().map(|d| format!("\"{}\"", d.example())).collect();
        let message = format!("`{}` is {}, which type = \"{of}\" does not have", section.path("damping"), wrong.name());
        return section.refuse("damping", message, "of another law", format!("write {}", examples.join(" or ")));
    }
    let linear: Vec<bool> = given
        .into_iter()
        .chain(section.dimensions("transition"))
        .chain(section.dimensions("speed"))
        .map(is_linear)
        .collect();
    if linear.len() == 2 && linear[0] != linear[1] {
        let message = format!("`{}` and `damping` are for different uses of a law", section.path("transition"));
        let help = "give a length and N*s/m for contacts, or an angle and N*m*s/rad for limits";
        return section.refuse("transition", message, "does not fit `damping`", help);
    }
    let damping_si = damping.map_or(0.0, |damping| *damping);
    let damping = match r#type.0 {
        LawType::HuntCrossley => Damping::HuntCrossley { factor_s_per_m: damping_si },
        LawType::Restitution => damping_from_restitution(*restitution?, *speed?),
        LawType::SpringDamper => Damping::Constant { n_s_per_m: damping_si },
        LawType::Step => Damping::Step { max_n_s_per_m: damping_si, transition_m: *transition? },
    };
    let normal = NormalLaw { stiffness_n_per_m_e: *stiffness?, exponent: *exponent, damping };
    Some(NamedLaw { law: ContactLaw { normal, friction: friction? }, linear: linear.first().copied() })
}

/// Finds a law for a contact or a limit.
fn law_for(
    section: &SectionInput<'_>,
    key: &str,
    name: &str,
    laws: &[(&str, Option<NamedLaw>)],
    linear: bool,
    of: &str,
) -> Option<ContactLaw> {
    let names: Vec<&str> = laws.iter().map(|(name, _)| *name).collect();
    let found = laws[find(section, key, name, "law", &names)?].1.as_ref()?;
    if found.linear.is_some_and(|of_law| of_law != linear) {
        let [has, needs] = [!linear, linear].map(|linear| if linear { "s/m" } else { "s/rad" });
        let message = format!("`{}` has units of {has}, but {of} needs a law with {needs}", section.path(key));
        let help = format!("give {of} a law of its own in [laws.NAME], whose damping and transition have {needs}");
        return section.refuse(key, message, "a law for other units", help);
    }
    Some(found.law)
}

/// Resolves all contact entries.
fn contacts(
    root: &SectionInput<'_>,
    mechanism: &Mechanism,
    laws: &[(&str, Option<NamedLaw>)],
) -> Option<Vec<ContactPair>> {
    let mut all: Vec<ContactPair> = Vec::new();
    let mut is_valid = true;
    for section in root.list("contacts") {
        let Some(pairs) = contact_entry(&section, mechanism, laws) else {
            is_valid = false;
            continue;
        };
        for pair in pairs {
            if all.iter().any(|other| (other.points, other.face) == (pair.points, pair.face)) {
                let [points, face] = [pair.points, pair.face].map(|id| mechanism.outline_name(id));
                let message = format!("`{}` lists `{points}` against `{face}` again", section.path(""));
                section.report("", message, "listed twice", "remove one of the entries, whose forces would add up");
                is_valid = false;
            }
            all.push(pair);
        }
    }
    let count: usize = all.iter().map(|pair| mechanism.outline(pair.points).shape.points().len()).sum();
    if count > MAX_CONTACTS {
        let message = format!("there are {count} contacts, one for each point, but at most {MAX_CONTACTS} are allowed");
        let help = "list fewer pairs of outlines, or give outlines fewer corners";
        return root.subsection("contacts").refuse("", message, "", help);
    }
    is_valid.then_some(all)
}

/// Resolves a contact entry.
fn contact_entry(
    section: &SectionInput<'_>,
    mechanism: &Mechanism,
    laws: &[(&str, Option<NamedLaw>)],
) -> Option<Vec<ContactPair>> {
    let ContactEntry { between, points, face, faces, law, at, rolling_arm, rolling_rate } = section.read();
    if rolling_arm.is_none() {
        section.report_unused("rolling_rate", "without `rolling_arm`");
    }
    let rolling = rolling_arm.map(|arm| FrictionLaw {
        mu_static: *arm,
        mu_dynamic: *arm,
        v_static_m_s: *rolling_rate,
        v_dynamic_m_s: 2.0 * *rolling_rate,
        bristle: None,
    });
    let law = law.and_then(|name| law_for(section, "law", &name, laws, true, "a contact"));
    let pairs = match between {
        Some(between) => {
            ["points", "face", "faces"].iter().for_each(|key| section.report_unused(key, "with `between`"));
            pairs_between(section, &between, mechanism)?
        }
        None => {
            if section.has("face") {
                section.report_unused("faces", "with `face`");
            }
            let key = if face.is_some() { "face" } else { "faces" };
            let points = points.and_then(|name| outline_id(section, "points", 0, &name, mechanism));
            let names: Vec<String> = face.into_iter().chain(faces.into_iter().flatten()).collect();
            let find_face = |(k, name): (usize, &String)| Some((outline_id(section, key, k, name, mechanism)?, k));
            let found: Vec<_> = names.iter().enumerate().map(find_face).collect();
            let points = points?;
            let pairs = found.into_iter().collect::<Option<Vec<_>>>()?.into_iter();
            pairs.map(|(face, k)| ([points, face], section.item_span(key, k))).collect()
        }
    };
    let are_valid: Vec<bool> =
        pairs.iter().map(|(pair, span)| check_pair(section, *pair, span.clone(), mechanism)).collect();
    let law = law.filter(|_| are_valid.into_iter().all(|is_valid| is_valid))?;
    Some(
        pairs
            .into_iter()
            .map(|([points, face], _)| ContactPair { points, face, law, rolling, force_point: at.0 })
            .collect(),
    )
}

/// Pairs of points and a face with their position in the file.
type Pairs = Vec<([OutlineId; 2], Option<std::ops::Range<usize>>)>;

/// All pairs of two patterns in all their directions.
fn pairs_between(section: &SectionInput<'_>, between: &[String; 2], mechanism: &Mechanism) -> Option<Pairs> {
    let ids = outline_ids(mechanism);
    let matching = |k: usize| {
        let is_match = |id: &&OutlineId| {
            let names = [mechanism.outline_name(**id), mechanism.body_name(id.body).to_owned()];
            names.iter().any(|name| matches_pattern(&between[k], name))
        };
        let found: Vec<OutlineId> = ids.iter().filter(is_match).copied().collect();
        if found.is_empty() {
            // The message of an unknown name.
            outline_id(section, "between", k, &between[k], mechanism)?;
        }
        Some(found)
    };
    let (first, second) = (matching(0), matching(1));
    let (first, second) = (first?, second?);
    let mut pairs: Vec<[OutlineId; 2]> = Vec::new();
    for (a, b) in first.iter().flat_map(|a| second.iter().map(move |b| (*a, *b))).filter(|(a, b)| a.body != b.body) {
        for pair in directions([a, b], mechanism) {
            if !pairs.contains(&pair) {
                pairs.push(pair);
            }
        }
    }
    if pairs.is_empty() {
        let message =
            format!("all outlines of `{}` belong to one body, which cannot touch itself", section.path("between"));
        return section.refuse("between", message, "the same body", "name outlines of two bodies");
    }
    let span = section.span("between");
    Some(pairs.into_iter().map(|pair| (pair, span.clone())).collect())
}

/// Points and face of two outlines: both directions if both have corners and sides.
fn directions([a, b]: [OutlineId; 2], mechanism: &Mechanism) -> Vec<[OutlineId; 2]> {
    let rank = |id: OutlineId| match mechanism.outline(id).shape {
        OutlineShape::HalfPlane { .. } => 0,
        OutlineShape::Capsule { .. } | OutlineShape::Polygon { .. } => 1,
        OutlineShape::Disc { .. } => 2,
        OutlineShape::Ellipse { .. } => 3,
    };
    match (rank(a), rank(b)) {
        (1, 1) => vec![[a, b], [b, a]],
        (first, second) if first > second => vec![[a, b]],
        _ => vec![[b, a]],
    }
}

/// Whether a name fits a pattern in which * stands for any letters.
fn matches_pattern(pattern: &str, name: &str) -> bool {
    let Some((first, others)) = pattern.split_once('*') else { return pattern == name };
    let Some(mut rest) = name.strip_prefix(first) else { return false };
    let mut parts = others.split('*');
    let last = parts.next_back().unwrap_or_default();
    for part in parts {
        let Some((_, after)) = rest.split_once(part) else { return false };
        rest = after;
    }
    rest.ends_with(last)
}

/// Checks that two outlines can touch.
fn check_pair(
    section: &SectionInput<'_>,
    [points, face]: [OutlineId; 2],
    span: Option<std::ops::Range<usize>>,
    mechanism: &Mechanism,
) -> bool {
    let [points_name, face_name] = [points, face].map(|id| mechanism.outline_name(id));
    let shapes = [points, face].map(|id| &mechanism.outline(id).shape);
    let (message, label, help) = match shapes {
        _ if points.body == face.body => (
            format!("both outlines belong to `{}`, which cannot touch itself", mechanism.body_name(face.body)),
            "the same body",
            "name outlines of two bodies",
        ),
        [OutlineShape::HalfPlane { .. }, _] => (
            format!("`{points_name}` is a half plane, which has no points"),
            "a half plane",
            "a half plane can only be a face: swap points and face, or give the other body another outline",
        ),
        [_, OutlineShape::Ellipse { .. }] => (
            format!("`{face_name}` is an ellipse, which cannot be a face"),
            "an ellipse",
            "an ellipse touches with its points: swap points and face, or describe one of two ellipses by a polygon",
        ),
        [points, face]
            if points.radius_m() + face.radius_m() == 0.0 && !matches!(face, OutlineShape::HalfPlane { .. }) =>
        {
            (
                format!(
                    "neither `{points_name}` nor `{face_name}` has a radius: at a sharp corner the normal of a contact jumps"
                ),
                "two sharp outlines",
                "give a polygon a rounding that exceeds the penetrations: rounding = \"0.5 mm\"",
            )
        }
        _ => return true,
    };
    let is_about_points = matches!(shapes[0], OutlineShape::HalfPlane { .. }) && points.body != face.body;
    let span = section.span("points").filter(|_| is_about_points).or(span);
    section.checker.push(Problem::new(span, message, label, help));
    false
}

/// All outlines of all bodies, those of the ground last.
fn outline_ids(mechanism: &Mechanism) -> Vec<OutlineId> {
    let outlines = |body: Option<usize>| {
        let outlines = body.map_or(&mechanism.ground_outlines, |body| &mechanism.bodies[body].outlines);
        (0..outlines.len()).map(move |outline| OutlineId { body, outline })
    };
    (0..mechanism.bodies.len()).map(Some).chain([None]).flat_map(outlines).collect()
}

/// Finds an outline by its name `body.outline`.
fn outline_id(
    section: &SectionInput<'_>,
    key: &str,
    index: usize,
    name: &str,
    mechanism: &Mechanism,
) -> Option<OutlineId> {
    let ids = outline_ids(mechanism);
    let names: Vec<String> = ids.iter().map(|id| mechanism.outline_name(*id)).collect();
    let known: Vec<&str> = names.iter().map(String::as_str).collect();
    find_at(section, section.item_span(key, index), key, name, "outline", &known).map(|found| ids[found])
}

/// Settings of a mechanism by section.
pub fn mechanism_settings(mechanism: &Mechanism) -> Table {
    let laws = Laws::of(mechanism);
    let named = |entries: Vec<(String, Table)>| -> Value {
        entries.into_iter().map(|(name, settings)| (name, Value::from(settings))).collect::<Table>().into()
    };
    let body_name = |body: &Option<usize>| Value::from(mechanism.body_name(*body));
    let joint = |joint: &Joint| {
        let (linear, _) = joint_words(joint.kind);
        let units = Units { linear };
        let mut settings = table([
            ("type", if linear { "prismatic" } else { "revolute" }.into()),
            ("bodies", joint.bodies.iter().map(body_name).collect::<Vec<_>>().into()),
            ("points", joint.points_m.iter().map(|point| list(*point)).collect::<Vec<_>>().into()),
            ("offset", joint.offset_rad.into()),
        ]);
        if let JointKind::Prismatic { axis_rad } = joint.kind {
            settings.insert("axis".into(), axis_rad.into());
        }
        let given = |value: f64| Some(value).filter(|value| *value != 0.0);
        let bristle = joint.friction.and_then(|law| law.bristle);
        if let Some(FrictionLaw { v_static_m_s, v_dynamic_m_s, .. }) = joint.friction {
            let rates = [v_static_m_s, v_dynamic_m_s].map(|rate| Value::from(units.text(rate, Kind::Rate)));
            settings.insert("friction_rates".into(), rates.to_vec().into());
        }
        settings.extend(units.texts([
            ("start", joint.start, Kind::Coordinate),
            ("start_rate", given(joint.start_rate).or(joint.start.and(Some(0.0))), Kind::Rate),
            ("damping", given(joint.damping), Kind::Damping),
            ("armature", given(joint.armature), Kind::Inertia),
            ("friction", joint.friction.map(|law| law.mu_dynamic), Kind::Effort),
            ("static_friction", joint.friction.map(|law| law.mu_static), Kind::Effort),
            ("friction_stiffness", bristle.map(|of| of.damping_n_s_per_m / of.relaxation_s), Kind::Stiffness),
            ("lower", joint.lower, Kind::Coordinate),
            ("upper", joint.upper, Kind::Coordinate),
        ]));
        if let (Some(normal), true) = (joint.limit, joint.lower.or(joint.upper).is_some()) {
            settings.insert("stop".into(), laws.name(&ContactLaw { normal, friction: None }, linear).into());
        }
        settings
    };
    let is_jointed = |body: usize| mechanism.joints.iter().any(|joint| joint.bodies.contains(&Some(body)));
    let body = |(index, body): (usize, &Body)| {
        let [x, y, angle] = body.pose;
        let mut settings = table([
            ("mass", body.mass_kg.into()),
            ("inertia", body.inertia_kg_m2.into()),
            ("com", list(body.com_m)),
            ("outlines", named(body.outlines.iter().map(outline_settings).collect())),
        ]);
        let mut pose = table([("at", list([x, y])), ("angle", angle.into())]);
        if is_jointed(index) {
            settings.insert("guess".into(), pose.into());
        } else {
            let [vx, vy, spin] = body.rate;
            pose.extend(table([("velocity", list([vx, vy])), ("spin", spin.into())]));
            settings.insert("start".into(), pose.into());
        }
        (body.name.clone(), settings)
    };
    let linear_joint = |joint: usize| joint_words(mechanism.joints[joint].kind).0;
    let spring = |spring: &Spring| {
        let (mut settings, linear, preload) = match &spring.kind {
            SpringKind::Torsional { on, preload } => {
                let joint = joint_of(on);
                let of = mechanism.joints[joint].name.as_str();
                (table([("type", "torsional".into()), ("joint", of.into())]), linear_joint(joint), Some(*preload))
            }
            SpringKind::Linear { bodies, points_m } => (
                table([
                    ("type", "linear".into()),
                    ("bodies", bodies.iter().map(body_name).collect::<Vec<_>>().into()),
                    ("points", points_m.iter().map(|point| list(*point)).collect::<Vec<_>>().into()),
                ]),
                true,
                None,
            ),
        };
        settings.extend(Units { linear }.texts([
            ("stiffness", Some(spring.stiffness), Kind::Stiffness),
            ("damping", Some(spring.damping), Kind::Damping),
            ("rest", Some(spring.rest), Kind::Coordinate),
            ("torque", preload, Kind::Effort),
        ]));
        (spring.name.clone(), settings)
    };
    let coupling = |coupling: &Coupling| {
        let (joints, factors): (Vec<Value>, Vec<f64>) = coupling
            .on
            .terms
            .iter()
            .map(|(joint, factor)| (Value::from(mechanism.joints[*joint].name.as_str()), *factor))
            .unzip();
        let linear = coupling.on.terms.first().is_some_and(|(joint, _)| linear_joint(*joint));
        let mut settings = table([("joints", joints.into()), ("factors", list(factors))]);
        settings.extend(Units { linear }.texts([("value", Some(coupling.on.offset), Kind::Coordinate)]));
        (coupling.name.clone(), settings)
    };
    let actuators = mechanism.actuators.iter().map(|each| actuator_settings(each, mechanism));
    let pulls = mechanism.tendons.iter().filter_map(|tendon| {
        let TendonActuator { name, tension } = tendon.actuator.as_ref()?;
        let mut settings = table([("tendon", tendon.name.as_str().into())]);
        insert_profile(&mut settings, tension, "tension", &Value::from);
        Some((name.clone(), settings))
    });
    let mut file = table([
        ("bodies", named(mechanism.bodies.iter().enumerate().map(body).collect())),
        ("joints", named(mechanism.joints.iter().map(|each| (each.name.clone(), joint(each))).collect())),
        ("springs", named(mechanism.springs.iter().map(spring).collect())),
        ("tendons", named(mechanism.tendons.iter().map(|each| tendon::tendon_settings(each, mechanism)).collect())),
        ("couplings", named(mechanism.couplings.iter().map(coupling).collect())),
        ("actuators", named(actuators.chain(pulls).collect())),
        ("laws", named(laws.settings())),
    ]);
    let ground = named(mechanism.ground_outlines.iter().map(outline_settings).collect());
    file.insert("ground".into(), table([("outlines", ground)]).into());
    let contact = |contact: &ContactPair| {
        Value::from(table([
            ("points", mechanism.outline_name(contact.points).into()),
            ("face", mechanism.outline_name(contact.face).into()),
            ("law", laws.name(&contact.law, true).into()),
            ("at", contact.force_point.keyword().into()),
            ("rolling_arm", contact.rolling.map_or(f64::NAN, |law| law.mu_static).into()),
            ("rolling_rate", contact.rolling.map_or(f64::NAN, |law| law.v_static_m_s).into()),
        ]))
    };
    file.insert("contacts".into(), mechanism.contacts.iter().map(contact).collect::<Vec<_>>().into());
    file
}

fn actuator_settings(actuator: &Actuator, mechanism: &Mechanism) -> (String, Table) {
    let joint = &mechanism.joints[joint_of(&actuator.on)];
    let linear = joint_words(joint.kind).0;
    let units = Units { linear };
    let mut settings = table([("joint", joint.name.as_str().into())]);
    let (profile, key, kind) = match &actuator.command {
        Command::Effort(profile) => (profile, if linear { "force" } else { "torque" }, Kind::Effort),
        Command::Servo { kp, kd, target, rate_hz } => {
            settings.extend(rate_hz.map(|rate_hz| ("rate".to_string(), format(rate_hz, Dimension::Frequency).into())));
            settings.extend(units.texts([("kp", Some(*kp), Kind::Stiffness), ("kd", Some(*kd), Kind::Damping)]));
            (target, "target", Kind::Coordinate)
        }
    };
    insert_profile(&mut settings, profile, key, &|value| units.text(value, kind).into());
    settings.extend(
        units.texts([("limit", actuator.limit, Kind::Effort), ("no_load_speed", actuator.no_load_speed, Kind::Rate)]),
    );
    (actuator.name.clone(), settings)
}

/// Inserts a constant, or times and values.
fn insert_profile(settings: &mut Table, profile: &Profile, key: &str, setting: &dyn Fn(f64) -> Value) {
    match profile {
        Profile::Table { points, .. } => {
            settings.insert("times".into(), list(points.iter().map(|point| point.0)));
            let values: Vec<Value> = points.iter().map(|point| setting(point.1)).collect();
            settings.insert(format!("{key}s"), values.into());
        }
        other => _ = settings.insert(key.into(), setting(other.at(0.0).0)),
    }
}

/// The joint of a spring or actuator: scene files write combinations only in couplings.
fn joint_of(on: &JointCombination) -> usize {
    on.terms[0].0
}

/// Kind of a quantity whose dimension depends on the joint.
#[derive(Clone, Copy)]
enum Kind {
    Coordinate,
    Rate,
    Stiffness,
    Damping,
    Inertia,
    Effort,
}

/// Units of a joint that slides or turns.
#[derive(Clone, Copy)]
struct Units {
    linear: bool,
}

impl Units {
    fn text(self, si: f64, kind: Kind) -> String {
        use Dimension as D;
        let [angular, linear] = match kind {
            Kind::Coordinate => [D::Angle, D::Length],
            Kind::Rate => [D::AngularRate, D::Speed],
            Kind::Stiffness => [D::AngularStiffness, D::LinearStiffness],
            Kind::Damping => [D::AngularDamping, D::LinearDamping],
            Kind::Inertia => [D::Inertia, D::Mass],
            Kind::Effort => [D::Torque, D::Force],
        };
        format(si, if self.linear { linear } else { angular })
    }

    /// Texts of the given values by key.
    fn texts<const N: usize>(self, values: [(&str, Option<f64>, Kind); N]) -> Table {
        let text =
            |(key, value, kind): (&str, Option<f64>, Kind)| Some((key.to_owned(), self.text(value?, kind).into()));
        values.into_iter().filter_map(text).collect()
    }
}

/// All different laws of a mechanism, which get names by their order, and whether they are those of contacts.
struct Laws(Vec<(ContactLaw, bool)>);

impl Laws {
    fn of(mechanism: &Mechanism) -> Self {
        let limits = mechanism
            .joints
            .iter()
            .filter_map(|joint| Some((ContactLaw { normal: joint.limit?, friction: None }, joint_words(joint.kind).0)));
        let mut all: Vec<(ContactLaw, bool)> = Vec::new();
        for law in mechanism.contacts.iter().map(|contact| (contact.law, true)).chain(limits) {
            if !all.contains(&law) {
                all.push(law);
            }
        }
        Self(all)
    }

    fn name(&self, law: &ContactLaw, linear: bool) -> String {
        let index = self.0.iter().position(|other| *other == (*law, linear)).unwrap_or(0);
        format!("law_{}", index + 1)
    }

    fn settings(&self) -> Vec<(String, Table)> {
        let settings = |(law, linear): &(ContactLaw, bool)| {
            let NormalLaw { stiffness_n_per_m_e, exponent, damping } = law.normal;
            let pick = |[angular, of_length]: [Dimension; 2]| if *linear { of_length } else { angular };
            let mut settings = table([("stiffness", stiffness_n_per_m_e.into()), ("exponent", exponent.into())]);
            let texts = match damping {
                Damping::HuntCrossley { factor_s_per_m } => {
                    let units = pick([Dimension::AngularImpactDamping, Dimension::LinearImpactDamping]);
                    vec![("type", "hunt_crossley".to_owned()), ("damping", format(factor_s_per_m, units))]
                }
                Damping::Constant { n_s_per_m } => vec![
                    ("type", "spring_damper".to_owned()),
                    ("damping", format(n_s_per_m, pick([Dimension::AngularDamping, Dimension::LinearDamping]))),
                ],
                Damping::Step { max_n_s_per_m, transition_m } => vec![
                    ("type", "step".to_owned()),
                    ("damping", format(max_n_s_per_m, pick([Dimension::AngularDamping, Dimension::LinearDamping]))),
                    ("transition", format(transition_m, pick([Dimension::Angle, Dimension::Length]))),
                ],
            };
            settings.extend(texts.into_iter().map(|(key, text)| (key.to_owned(), text.into())));
            if let Some(Value::Table(friction)) =
                law::contact_settings(law).remove("friction").filter(|_| law.friction.is_some())
            {
                settings.insert("friction".into(), friction.into());
            }
            (self.name(law, *linear), settings)
        };
        self.0.iter().map(settings).collect()
    }
}

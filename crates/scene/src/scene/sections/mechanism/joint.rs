//! Joints of a mechanism, and what acts on their coordinates: springs, couplings and rotors.

use schemars::JsonSchema;
use serde::Deserialize;

use super::contact::law_for;
use super::names::{Known, check_units, find_at, two_bodies};
use super::outline::si;
use crate::law::{Bristle, FrictionKind, FrictionLaw};
use crate::mechanism::{Body, Coupling, Joint, JointCombination, JointKind, Rotor, Spring, SpringKind};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{rotate, sub};
use crate::scene::quantity::{
    Angle, Coordinate, CoordinateRate, Effort, JointDamping, JointInertia, JointStiffness, Length, NotNegative, Plain,
    Positive, Quantity, keyword_enum,
};
use crate::scene::section_input::SectionInput;

keyword_enum! {
    pub enum JointType { Revolute = "revolute", Prismatic = "prismatic" }
}

/// A joint of two bodies. Its coordinate is the angle of the second body relative to the first (revolute), or its
/// position along the axis (prismatic).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct JointSettings {
    /// "revolute": a pin; "prismatic": a slider without rotation.
    #[schemars(extend("default" = "revolute"))]
    pub r#type: JointType,
    /// The two bodies: ["ground", "driver"]. Required.
    #[schemars(extend("x-required" = "add the two bodies: bodies = [\"ground\", \"driver\"]"))]
    pub bodies: Option<[String; 2]>,
    /// Point of the joint in each body, in its own frame. Required unless `at` is given.
    #[schemars(extend("x-alternative" = "at",
        "x-required" = "add the point in the frame of each body: points = [[\"0 mm\", \"0 mm\"], [\"30 mm\", \"0 mm\"]]"))]
    pub points: Option<[[Quantity<Length>; 2]; 2]>,
    /// Point of the joint in the world, in place of `points`. The `guess` of both bodies must then be exact.
    pub at: Option<[Quantity<Length>; 2]>,
    /// Direction in which the second body slides, in the frame of the first.
    #[schemars(extend("x-with" = "type = prismatic", "default" = "0 deg"))]
    pub axis: Option<Quantity<Angle>>,
    /// Revolute: angle of the second body relative to the first at which the coordinate is 0. Prismatic: the constant
    /// angle of the second body relative to the first.
    #[schemars(extend("default" = "0 deg"))]
    pub offset: Quantity<Angle>,
    /// Coordinate at the start. Default: it follows from other joints.
    pub start: Option<Quantity<Coordinate>>,
    /// Rate at the start, for a joint with `start`. Default: 0.
    pub start_rate: Option<Quantity<CoordinateRate>>,
    /// Damping. Default: none.
    pub damping: Option<NotNegative<JointDamping>>,
    /// Inertia of rotor and gear, reflected to the joint. Default: none.
    pub armature: Option<NotNegative<JointInertia>>,
    /// Torque (force) of Coulomb friction while the joint moves. Default: none.
    pub friction: Option<Positive<Effort>>,
    /// Largest torque (force) of friction, before the joint moves. Default: `friction`.
    pub static_friction: Option<Positive<Effort>>,
    /// Rate at which friction reaches `static_friction`, and rate from which on it is `friction`. Default: 0.01 and
    /// 0.02 rad/s (prismatic: 1 and 2 mm/s).
    pub friction_rates: Option<[Positive<CoordinateRate>; 2]>,
    /// Stiffness of a bristle, with which friction holds without creep. Default: none; below the first of
    /// `friction_rates`, the joint creeps.
    pub friction_stiffness: Option<Positive<JointStiffness>>,
    /// Lower limit of the coordinate. Default: none.
    pub lower: Option<Quantity<Coordinate>>,
    /// Upper limit of the coordinate. Default: none.
    pub upper: Option<Quantity<Coordinate>>,
    /// Name of the law of the limits. Required with a limit.
    #[schemars(extend("minLength" = 1))]
    pub stop: Option<String>,
}

keyword_enum! {
    pub enum SpringType { Torsional = "torsional", Linear = "linear" }
}

/// A spring with a damper.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct LinkageSpringSettings {
    /// "torsional": acts on the coordinate of a joint; "linear": between points of two bodies.
    #[schemars(extend("default" = "torsional"))]
    pub r#type: SpringType,
    /// Joint of a torsional spring. Required unless `joints` is given.
    #[schemars(extend("minLength" = 1, "x-with" = "type = torsional", "x-alternative" = "joints",
        "x-required" = "add the joint: joint = \"driver\""))]
    pub joint: Option<String>,
    /// Joints of a torsional spring that acts on a sum of their coordinates, in place of `joint`.
    #[schemars(extend("x-with" = "type = torsional"))]
    pub joints: Option<Vec<String>>,
    /// A factor for each of `joints`.
    #[schemars(extend("x-with" = "type = torsional"))]
    pub factors: Option<Vec<Quantity<Plain>>>,
    /// Value of the sum of `joints` that counts as 0. Default: 0.
    #[schemars(extend("x-with" = "type = torsional"))]
    pub offset: Option<Quantity<Coordinate>>,
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
    /// Coordinate or length at which the elastic force is 0. Default: 0.
    pub rest: Option<Quantity<Coordinate>>,
    /// Preload of a torsional spring: a constant additional torque (force). Default: 0.
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

/// Inertia of a rotor whose rotation is the sum of joint coordinates times factors. For the inertia on a single joint,
/// use its `armature`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct RotorSettings {
    /// The joints. Required.
    #[schemars(extend("x-required" = "add the joints: joints = [\"right\", \"left\"]"))]
    pub joints: Option<Vec<String>>,
    /// A factor for each joint. Required.
    #[schemars(extend("x-required" = "add a factor for each joint: factors = [0.5, 0.5] for their mean"))]
    pub factors: Option<Vec<Quantity<Plain>>>,
    /// Moment of inertia (mass). Required.
    #[schemars(extend("x-required" = "add the moment of inertia: inertia = \"2e-6 kg*m^2\""))]
    pub inertia: Option<Positive<JointInertia>>,
}

/// Finds the two bodies of a joint.
pub(super) fn joint_bodies(section: &SectionInput<'_>, names: &[&str]) -> Option<[Option<usize>; 2]> {
    two_bodies(section, section.value("bodies")?, names, "a joint")
}

pub(super) fn joint_kind(section: &SectionInput<'_>) -> Option<JointKind> {
    section.is_valid("type").then_some(())?;
    Some(match section.value("type")? {
        JointType::Revolute => JointKind::Revolute,
        JointType::Prismatic => {
            JointKind::Prismatic { axis_rad: section.value("axis").map_or(0.0, |axis: Quantity<Angle>| *axis) }
        }
    })
}

pub(super) fn joint(
    name: &str,
    section: &SectionInput<'_>,
    bodies: Option<[Option<usize>; 2]>,
    all_bodies: &[Option<Body>],
    known: &Known<'_>,
) -> Option<Joint> {
    let settings: JointSettings = section.read();
    let kind = joint_kind(section)?;
    let (linear, of) = (!kind.is_angle(), kind.name());
    let units_fit = check_units(section, linear, of);
    if settings.start.is_none() {
        section.report_unused(["start_rate"], "without `start`");
    }
    if section.has("points") {
        section.report_unused(["at"], "with `points`");
    }
    let limits = [settings.lower, settings.upper].map(|limit| limit.map(|limit| *limit));
    let limit = match (&settings.stop, limits) {
        (None, [None, None]) => None,
        (Some(_), [None, None]) => {
            section.report_unused(["stop"], "without `lower` or `upper`");
            None
        }
        (None, _) => {
            let help = "add the name of the law of the limits: stop = \"stop\", with a section [laws.stop]";
            return section.refuse_missing("stop", help);
        }
        (Some(stop), _) => Some(law_for(section, "stop", stop, known, linear, &format!("the limit of {of}"))?.normal),
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
        offset_rad: *settings.offset,
        start: settings.start.map(|start| *start),
        start_rate: settings.start_rate.map_or(0.0, |rate| *rate),
        damping: settings.damping.map_or(0.0, |damping| *damping),
        armature: settings.armature.map_or(0.0, |armature| *armature),
        friction,
        lower: limits[0],
        upper: limits[1],
        limit,
        ..Joint::new(name, kind, bodies, points_m)
    })
}

/// Relaxation time of the bristle of a joint, s.
const BRISTLE_RELAXATION_S: f64 = 1e-3;

/// Friction of a joint, as the law under a normal force of 1; the outer `None` if it is invalid.
fn joint_friction(section: &SectionInput<'_>, settings: &JointSettings, linear: bool) -> Option<Option<FrictionLaw>> {
    let Some(friction) = settings.friction else {
        section.report_unused(["static_friction", "friction_rates", "friction_stiffness"], "without `friction`");
        return Some(None);
    };
    let default_rates = if linear { [1e-3, 2e-3] } else { [0.01, 0.02] };
    let [v_static_m_s, v_dynamic_m_s] = settings.friction_rates.map_or(default_rates, |rates| rates.map(|rate| *rate));
    let law = FrictionLaw {
        mu_static: settings.static_friction.map_or(*friction, |friction| *friction),
        mu_dynamic: *friction,
        v_static_m_s,
        v_dynamic_m_s,
        kind: FrictionKind::from(settings.friction_stiffness.map(|stiffness| Bristle {
            damping_n_s_per_m: *stiffness * BRISTLE_RELAXATION_S,
            relaxation_s: BRISTLE_RELAXATION_S,
        })),
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

/// A sum of joint coordinates, whether it has the units of a prismatic joint, and words for messages.
type Combination = (JointCombination, bool, &'static str);

/// Resolves the joint in `joint`, or the combination of at least `fewest` `joints` with `factors`, without its offset.
pub(super) fn combination(
    section: &SectionInput<'_>,
    known: &Known<'_>,
    joint: Option<&String>,
    joints: Option<&Vec<String>>,
    factors: Option<&Vec<Quantity<Plain>>>,
    fewest: usize,
) -> Option<Combination> {
    if let Some(joint) = joint {
        section.report_unused(["joints", "factors", "offset"], "with `joint`");
        let (joint, kind) = known.joint(section, "joint", joint)?;
        let (linear, of) = (!kind.is_angle(), kind.name());
        return Some((JointCombination::of_joint(joint), linear, of));
    }
    let names = joints?;
    let Some(factors) = factors else {
        return section.refuse_missing("factors", "add a factor for each joint: factors = [0.5, 0.5]");
    };
    if names.len() != factors.len() || names.len() < fewest {
        let count = if fewest > 1 { "two joints" } else { "one joint" };
        let message = format!(
            "`{}` has {} joints and {} factors, but needs a factor for each of at least {count}",
            section.path(""),
            names.len(),
            factors.len()
        );
        return section.refuse("factors", message, "one factor per joint", "write as many factors as joints");
    }
    let find = |(k, name): (usize, &String)| {
        let joint = find_at(section, section.item_span("joints", k), "joints", name, "joint", &known.joints)?;
        Some((joint, known.kinds[joint]?))
    };
    let found: Vec<_> = names.iter().enumerate().map(find).collect();
    let found: Vec<(usize, JointKind)> = found.into_iter().collect::<Option<_>>()?;
    if let Some(repeated) = names.iter().enumerate().find(|(k, name)| names[..*k].contains(name)) {
        let message = format!("`{}` names `{}` twice", section.path("joints"), repeated.1);
        return section.refuse("joints", message, "named twice", "name every joint once, with the sum of its factors");
    }
    let (linear, of) = (!found[0].1.is_angle(), found[0].1.name());
    let terms = found.iter().zip(factors).map(|((joint, _), factor)| (*joint, **factor)).collect();
    Some((JointCombination { terms, offset: 0.0 }, linear, of))
}

pub(super) fn spring(name: &str, section: &SectionInput<'_>, known: &Known<'_>) -> Option<Spring> {
    let settings: LinkageSpringSettings = section.read();
    section.is_valid("type").then_some(())?;
    let LinkageSpringSettings { joint, joints, factors, .. } = &settings;
    let (kind, linear, of) = match settings.r#type {
        SpringType::Torsional => {
            let (mut on, linear, of) =
                combination(section, known, joint.as_ref(), joints.as_ref(), factors.as_ref(), 1)?;
            on.offset = settings.offset.map_or(0.0, |offset| *offset);
            (SpringKind::Torsional { on, preload: settings.torque.map_or(0.0, |torque| *torque) }, linear, of)
        }
        SpringType::Linear => {
            let bodies = two_bodies(section, settings.bodies?, &known.bodies, "a linear spring")?;
            (SpringKind::Linear { bodies, points_m: settings.points?.map(si) }, true, "a linear spring")
        }
    };
    check_units(section, linear, of).then_some(())?;
    Some(Spring {
        name: name.to_owned(),
        kind,
        stiffness: *settings.stiffness?,
        damping: settings.damping.map_or(0.0, |damping| *damping),
        rest: settings.rest.map_or(0.0, |rest| *rest),
    })
}

pub(super) fn coupling(name: &str, section: &SectionInput<'_>, known: &Known<'_>) -> Option<Coupling> {
    let CouplingSettings { joints, factors, value } = section.read();
    let (mut on, linear, of) = combination(section, known, None, joints.as_ref(), Some(&factors?), 2)?;
    check_units(section, linear, of).then_some(())?;
    on.offset = value.map_or(0.0, |value| *value);
    Some(Coupling { name: name.to_owned(), on })
}

pub(super) fn rotor(name: &str, section: &SectionInput<'_>, known: &Known<'_>) -> Option<Rotor> {
    let RotorSettings { joints, factors, inertia } = section.read();
    let (on, linear, of) = combination(section, known, None, joints.as_ref(), Some(&factors?), 1)?;
    check_units(section, linear, of).then_some(())?;
    Some(Rotor { name: name.to_owned(), on, inertia: *inertia? })
}

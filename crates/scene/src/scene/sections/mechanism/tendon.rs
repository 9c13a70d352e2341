//! Tendons of a mechanism: their paths, spools, springs and actuators.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use super::mirror::Entries;
use super::names::{GROUND, Known, find};
use crate::limits::MAX_PLACES;
use crate::mechanism::tendon::{center_in, length_in, wraps};
use crate::mechanism::{Mechanism, PathElement, Pose, Tendon};
use crate::scene::quantity::{
    Force, Length, LinearDamping, LinearStiffness, NotNegative, Positive, Quantity, keyword_enum,
};
use crate::scene::section_input::{SectionInput, Subsection};

/// A massless cable without friction. Its tension is the same along its whole length: the force of its spring and
/// damper, which cannot push, plus the tension of an actuator.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct TendonSettings {
    /// Stiffness of the cable. Default: none; only an actuator pulls the cable then.
    pub stiffness: Option<Positive<LinearStiffness>>,
    /// Damping of the cable. Default: none.
    pub damping: Option<NotNegative<LinearDamping>>,
    /// Tension at the start, at rest. It determines the free length. Default: 0.
    pub pretension: Option<NotNegative<Force>>,
    /// Free length of the cable, including the terms of its spools, in place of `pretension`.
    pub rest: Option<Quantity<Length>>,
    /// Eyelets and pulleys in the order of the cable; the first and the last are eyelets. Required without `spools`.
    #[schemars(with = "Vec<PathEntry>")]
    pub path: Subsection,
    /// Spools that wind up the cable.
    #[schemars(with = "Vec<SpoolEntry>")]
    pub spools: Subsection,
}

keyword_enum! {
    pub enum Turn { Clockwise = "cw", CounterClockwise = "ccw" }
}

impl Turn {
    fn sign(self) -> f64 {
        if self == Turn::CounterClockwise { 1.0 } else { -1.0 }
    }

    fn of(sign: f64) -> Self {
        if sign > 0.0 { Turn::CounterClockwise } else { Turn::Clockwise }
    }
}

/// An element of the path of a cable: an eyelet or a pulley.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct PathEntry {
    /// Body of an eyelet. Required unless `pulley` is given.
    #[schemars(extend("minLength" = 1, "x-alternative" = "pulley",
        "x-required" = "add the body: eyelet = \"distal\", or pulley = \"ground\" with radius and turn"))]
    pub eyelet: Option<String>,
    /// Body of a pulley, which does not turn with the cable.
    #[schemars(extend("minLength" = 1))]
    pub pulley: Option<String>,
    /// The eyelet, or the centre of the pulley, in the frame of its body.
    #[schemars(extend("default" = ["0 mm", "0 mm"]))]
    pub at: [Quantity<Length>; 2],
    /// Radius of the pulley.
    pub radius: Option<Positive<Length>>,
    /// Direction in which the cable passes the pulley: "cw" (the centre to its right) or "ccw".
    pub turn: Option<Turn>,
}

/// A spool on a revolute joint, or a pulley concentric with it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct SpoolEntry {
    /// The joint. Required.
    #[schemars(extend("minLength" = 1, "x-required" = "add the joint of the spool: joint = \"winch\""))]
    pub joint: Option<String>,
    /// Radius of the spool. Required.
    #[schemars(extend("x-required" = "add the radius: radius = \"6 mm\""))]
    pub radius: Option<Positive<Length>>,
    /// Rotation of the joint that winds up the cable.
    #[schemars(extend("default" = "ccw"))]
    pub turn: Turn,
}

/// Resolves a tendon without its actuator and its free length; `None` if a part is invalid.
pub(super) fn tendon(name: &str, section: &SectionInput<'_>, known: &Known<'_>) -> Option<Tendon> {
    let TendonSettings { stiffness, damping, .. } = section.read();
    let entries = ["path", "spools"].map(|key| section.list(key));
    for (key, count) in [("path", entries[0].len()), ("spools", entries[1].len())] {
        if count > MAX_PLACES {
            let message = format!("`{}` has {count} entries, but at most {MAX_PLACES} are allowed", section.path(key));
            return section.refuse(key, message, "too many", format!("remove {}", count - MAX_PLACES));
        }
    }
    let elements: Vec<_> = entries[0].iter().map(|entry| element(entry, &known.bodies)).collect();
    let spools: Vec<_> = entries[1].iter().map(|entry| spool(entry, known)).collect();
    if stiffness.is_none() {
        section.report_unused(["damping", "pretension", "rest"], "without `stiffness`");
    }
    if section.has("rest") {
        section.report_unused(["pretension"], "with `rest`");
    }
    let (path, joints): (Vec<PathElement>, Vec<(usize, f64)>) =
        (elements.into_iter().collect::<Option<_>>()?, spools.into_iter().collect::<Option<_>>()?);
    let ends_at_pulley = |end: Option<&PathElement>| end.is_some_and(PathElement::is_pulley);
    if path.len() == 1 || path.is_empty() && joints.is_empty() {
        let message = format!(
            "`{}` has {} places, but a cable leads from one eyelet to another",
            section.path("path"),
            path.len()
        );
        let help =
            "write at least two: path = [{ eyelet = \"ground\", at = [\"0 mm\", \"0 mm\"] }, { eyelet = \"distal\" }]";
        return section.refuse("path", message, "too short", help);
    }
    if ends_at_pulley(path.first()) || ends_at_pulley(path.last()) {
        let message = format!("`{}` begins or ends with a pulley", section.path("path"));
        let help =
            "begin and end with an eyelet; a winch is a spool: spools = [{ joint = \"winch\", radius = \"6 mm\" }]";
        return section.refuse("path", message, "a pulley at an end", help);
    }
    Some(Tendon {
        name: name.to_owned(),
        path,
        joints,
        stiffness_n_per_m: stiffness.map_or(0.0, |stiffness| *stiffness),
        damping_n_s_per_m: damping.map_or(0.0, |damping| *damping),
        rest_m: 0.0,
        actuator: None,
    })
}

fn element(entry: &SectionInput<'_>, bodies: &[&str]) -> Option<PathElement> {
    let PathEntry { eyelet, pulley, at, radius, turn } = entry.read();
    let known: Vec<&str> = [GROUND].into_iter().chain(bodies.iter().copied()).collect();
    let key = if pulley.is_some() { "pulley" } else { "eyelet" };
    if pulley.is_some() {
        entry.report_unused(["eyelet"], "with `pulley`");
        if radius.is_none() {
            entry.report_missing("radius", "add the radius of the pulley: radius = \"4 mm\"");
        }
        if turn.is_none() {
            let help = "add the direction in which the cable passes the pulley: turn = \"cw\" or \"ccw\"";
            entry.report_missing("turn", help);
        }
    } else {
        entry.report_unused(["radius", "turn"], "without `pulley`");
    }
    let (radius_m, side) = if pulley.is_some() { (*radius?, turn?.sign()) } else { (0.0, 1.0) };
    let body = find(entry, key, &pulley.or(eyelet)?, "body", &known)?.checked_sub(1);
    Some(PathElement { body, point_m: at.map(|part| *part), radius_m, side })
}

fn spool(entry: &SectionInput<'_>, known: &Known<'_>) -> Option<(usize, f64)> {
    let SpoolEntry { joint, radius, turn } = entry.read();
    let (joint, kind) = known.joint(entry, "joint", &joint?)?;
    if !kind.is_angle() {
        let message = format!("`{}` names a prismatic joint, which has no spool", entry.path("joint"));
        let help = "name a revolute joint; a cable to a slider ends in an eyelet of its body";
        return entry.refuse("joint", message, "a prismatic joint", help);
    }
    Some((joint, turn.sign() * *radius?))
}

/// Sets the free lengths of all tendons from these poses at the start, and checks that the cables can pass their paths.
pub(super) fn tension(mechanism: &mut Mechanism, entries: &Entries<'_>, poses: &[Pose]) {
    for (index, _, section) in entries.written() {
        let tendon = &mechanism.tendons[index];
        let length_m = length_in(mechanism, tendon, poses);
        let lifted = wraps(&tendon.path, |element| center_in(element, poses)).find(|(_, wrap)| *wrap <= 0.0);
        if length_m.is_nan() {
            let message = format!("the cable of `{}` cannot pass its path at the start", section.path(""));
            let help = "neighbouring places must be apart: an eyelet outside of its neighbouring pulleys, and pulleys that \
                        the cable passes on different sides without overlap";
            section.report("path", message, "places coincide or overlap", help);
        } else if let Some((element, _)) = lifted {
            let text = mechanism.describe_lifted(tendon, element);
            let (message, help) = text.split_once(": ").unwrap_or((&text, ""));
            section.report("path", format!("at the start {message}"), "not on a pulley", help);
        } else if tendon.law().is_none() && tendon.actuator.is_none() {
            let message = format!("`{}` has neither a stiffness nor an actuator, and never pulls", section.path(""));
            let help = format!(
                "add a stiffness: stiffness = \"2e4 N/m\", or an actuator with tendon = \"{}\" and a tension",
                tendon.name
            );
            section.report("", message, "without tension", help);
        }
        let TendonSettings { pretension, rest, .. } = section.quietly(SectionInput::read);
        let tendon = &mut mechanism.tendons[index];
        let stretch_m = pretension.map_or(0.0, |force| *force / tendon.stiffness_n_per_m.max(f64::MIN_POSITIVE));
        tendon.rest_m = rest.map_or(length_m - stretch_m, |rest| *rest);
    }
    // The image of a cable has its free length.
    for (index, partner) in entries.partners().into_iter().enumerate().filter(|(index, _)| entries.is_image(*index)) {
        mechanism.tendons[index].rest_m = mechanism.tendons[partner].rest_m;
    }
}

/// Settings of a tendon.
pub(super) fn tendon_settings(tendon: &Tendon, mechanism: &Mechanism) -> (String, Value) {
    let element = |element: &PathElement| {
        let (body, at) = (mechanism.body_name(element.body), element.point_m);
        match element.is_pulley() {
            true => json!({ "pulley": body, "at": at, "radius": element.radius_m, "turn": Turn::of(element.side) }),
            false => json!({ "eyelet": body, "at": at }),
        }
    };
    let spool = |(joint, factor): &(usize, f64)| json!({ "joint": mechanism.joints[*joint].name, "radius": factor.abs(), "turn": Turn::of(*factor) });
    let elastic = |value: f64| tendon.law().map(|_| value);
    let settings = json!({
        "path": tendon.path.iter().map(element).collect::<Value>(),
        "spools": tendon.joints.iter().map(spool).collect::<Value>(),
        "stiffness": elastic(tendon.stiffness_n_per_m),
        "damping": elastic(tendon.damping_n_s_per_m),
        "rest": elastic(tendon.rest_m),
    });
    (tendon.name.clone(), settings)
}

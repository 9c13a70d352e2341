//! Tendons of a mechanism: their paths, spools, springs and actuators.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use super::mirror::Entries;
use super::names::{GROUND, Known, find};
use crate::law::{Bristle, FrictionKind, FrictionLaw};
use crate::limits::MAX_PLACES;
use crate::mechanism::tendon::{center_in, find_fault, length_in, settled_path};
use crate::mechanism::{Mechanism, PathElement, Pose, Tendon};
use crate::scene::quantity::{
    Force, Length, LinearDamping, LinearStiffness, NotNegative, Plain, Positive, Quantity, Speed, Time, keyword_enum,
};
use crate::scene::section_input::{SectionInput, Subsection};

/// A massless cable. Its tension is the force of its spring and damper, which cannot push, plus the tension of an actuator.
/// Without friction it is the same along the whole length. The cable lifts off a pulley where it would be pushed, and returns.
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
    /// End of the path, "first" or "last", at which the actuator pulls and the spools wind. It matters with friction only.
    #[schemars(extend("default" = "first"))]
    pub from: End,
    /// Friction on all eyelets and pulleys between the ends. Default: none.
    #[schemars(with = "CableFriction")]
    pub friction: Subsection,
    /// Spools that wind up the cable.
    #[schemars(with = "Vec<SpoolEntry>")]
    pub spools: Subsection,
}

keyword_enum! {
    pub enum Turn { Clockwise = "cw", CounterClockwise = "ccw" }
}

keyword_enum! {
    pub enum End { First = "first", Last = "last" }
}

keyword_enum! {
    pub enum SpoolEnd { Near = "near", Far = "far" }
}

/// Friction of a cable on an eyelet or a pulley: the tension behind it is exp(−μ ψ) times the tension before it, with the wrap
/// ψ, where the cable slips towards the end at which it is pulled.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct CableFriction {
    /// Static coefficient, reached at v_static; 0 is frictionless. Required.
    #[schemars(extend("x-required" = "add the static coefficient: mu_static = 0.2, or 0 for no friction"))]
    pub mu_static: Option<NotNegative<Plain>>,
    /// Dynamic coefficient, beyond v_dynamic. Default: 0.7 mu_static.
    pub mu_dynamic: Option<NotNegative<Plain>>,
    /// Speed of the cable at which the static coefficient is reached.
    #[schemars(extend("default" = "5 mm/s"))]
    pub v_static: Positive<Speed>,
    /// Speed of the cable from which the dynamic coefficient applies.
    #[schemars(extend("default" = "10 mm/s"))]
    pub v_dynamic: Positive<Speed>,
    /// Path over which friction at rest grows to the static coefficient. With it the cable holds without creep. Default: none;
    /// below v_static, the cable creeps.
    pub presliding: Option<Positive<Length>>,
    /// Relaxation time of the deflection under `presliding`. Default: 1 ms.
    pub relaxation: Option<Positive<Time>>,
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
    /// Friction here, in place of that of the tendon.
    #[allow(dead_code, reason = "it is read as a section of its own")]
    #[schemars(with = "CableFriction")]
    pub friction: Subsection,
    /// Whether the pulley or eyelet turns freely on a pin: it has no friction.
    #[schemars(extend("default" = false))]
    pub roller: bool,
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
    /// End of the cable: "near", where the actuator pulls, or "far".
    #[schemars(extend("default" = "near"))]
    pub end: SpoolEnd,
}

/// Resolves a tendon without its actuator and its free length; `None` if a part is invalid.
pub(super) fn tendon(name: &str, section: &SectionInput<'_>, known: &Known<'_>) -> Option<Tendon> {
    let TendonSettings { stiffness, damping, from, .. } = section.read();
    let entries = ["path", "spools"].map(|key| section.list(key));
    for (key, count) in [("path", entries[0].len()), ("spools", entries[1].len())] {
        if count > MAX_PLACES {
            let message = format!("`{}` has {count} entries, but at most {MAX_PLACES} are allowed", section.path(key));
            return section.refuse(key, message, "too many", format!("remove {}", count - MAX_PLACES));
        }
    }
    let friction = cable_friction(&section.subsection("friction"));
    let count = entries[0].len();
    let elements: Vec<_> = entries[0]
        .iter()
        .enumerate()
        .map(|(index, entry)| element(entry, &known.bodies, friction.flatten(), index == 0 || index + 1 == count))
        .collect();
    let spools: Vec<_> = entries[1].iter().map(|entry| spool(entry, known)).collect();
    if stiffness.is_none() {
        section.report_unused(["damping", "pretension", "rest"], "without `stiffness`");
    }
    if section.has("rest") {
        section.report_unused(["pretension"], "with `rest`");
    }
    let mut path: Vec<PathElement> = elements.into_iter().collect::<Option<_>>()?;
    let spools: Vec<(usize, f64, SpoolEnd)> = spools.into_iter().collect::<Option<_>>()?;
    let [joints, far_joints]: [Vec<(usize, f64)>; 2] = [SpoolEnd::Near, SpoolEnd::Far].map(|at| {
        let at_end = spools.iter().filter(|(.., end)| *end == at);
        at_end.map(|(joint, factor, _)| (*joint, *factor)).collect()
    });
    friction?;
    let ends_at_pulley = |end: Option<&PathElement>| end.is_some_and(PathElement::is_pulley);
    if path.len() == 1 || path.is_empty() && spools.is_empty() {
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
    if section.has("friction") && path.len() < 3 {
        let message = format!("`{}` has no effect: the path has no place between its ends", section.path("friction"));
        return section.refuse(
            "friction",
            message,
            "no place with friction",
            "remove it, or add an eyelet or a pulley",
        );
    }
    let is_reversed = from == End::Last;
    if is_reversed {
        path.reverse();
        path.iter_mut().filter(|element| element.is_pulley()).for_each(|pulley| pulley.side = -pulley.side);
    }
    Some(Tendon {
        name: name.to_owned(),
        path,
        joints,
        far_joints,
        stiffness_n_per_m: stiffness.map_or(0.0, |stiffness| *stiffness),
        damping_n_s_per_m: damping.map_or(0.0, |damping| *damping),
        rest_m: 0.0,
        actuator: None,
        is_reversed,
    })
}

/// Relaxation time under `presliding`, s.
const RELAXATION_S: f64 = 1e-3;

/// Damping of the bristle of a friction coefficient: its stiffness μ_s/presliding, 1/m, times its relaxation time.
fn bristle_damping(mu_static: f64, presliding_m: f64, relaxation_s: f64) -> f64 {
    mu_static / presliding_m * relaxation_s
}

/// The path that gives a bristle its damping to the last digit.
fn presliding(mu_static: f64, bristle: Bristle) -> f64 {
    let Bristle { damping_n_s_per_m, relaxation_s } = bristle;
    let near = mu_static * relaxation_s / damping_n_s_per_m;
    let (mut above, mut below) = (near, near);
    for _ in 0..4 {
        for presliding_m in [above, below] {
            if bristle_damping(mu_static, presliding_m, relaxation_s) == damping_n_s_per_m {
                return presliding_m;
            }
        }
        (above, below) = (above.next_up(), below.next_down());
    }
    near
}

/// Reads the friction of a cable: `Some(None)` without friction, `None` if it is invalid.
fn cable_friction(section: &SectionInput<'_>) -> Option<Option<FrictionLaw>> {
    if !section.is_present() {
        return Some(None);
    }
    let problem_count = section.checker.count();
    let CableFriction { mu_static, mu_dynamic, v_static, v_dynamic, presliding, relaxation } = section.read();
    if presliding.is_none() {
        section.report_unused(["relaxation"], "without `presliding`");
    }
    if section.checker.count() > problem_count {
        return None;
    }
    let mu_static = *mu_static?;
    // 0.7 μ_s; exactly 0.56 for 0.8.
    let mu_dynamic = mu_dynamic.map_or(7.0 * mu_static / 10.0, |mu_dynamic| *mu_dynamic);
    if mu_dynamic > mu_static {
        let path = section.path("mu_dynamic");
        let message = format!("`{path}` is {mu_dynamic}, but must not exceed mu_static = {mu_static}");
        let help = "lower mu_dynamic, raise mu_static, or remove mu_dynamic (default: 0.7 mu_static)";
        return section.refuse("mu_dynamic", message, &format!("from 0 to {mu_static}"), help);
    }
    if *v_dynamic <= *v_static {
        let path = section.path("v_dynamic");
        let message = format!("`{path}` is {} m/s, but must be above v_static = {} m/s", *v_dynamic, *v_static);
        let help = "raise v_dynamic, lower v_static, or remove both (defaults: 10 mm/s and 5 mm/s)";
        return section.refuse(if section.has("v_dynamic") { "v_dynamic" } else { "v_static" }, message, "", help);
    }
    let relaxation_s = relaxation.map_or(RELAXATION_S, |relaxation| *relaxation);
    let kind = FrictionKind::from(presliding.map(|presliding| Bristle {
        damping_n_s_per_m: bristle_damping(mu_static, *presliding, relaxation_s),
        relaxation_s,
    }));
    let law = FrictionLaw { mu_static, mu_dynamic, v_static_m_s: *v_static, v_dynamic_m_s: *v_dynamic, kind };
    Some((mu_static > 0.0).then_some(law))
}

/// Resolves a path element; `common` is the friction of the tendon.
fn element(
    entry: &SectionInput<'_>,
    bodies: &[&str],
    common: Option<FrictionLaw>,
    is_end: bool,
) -> Option<PathElement> {
    let PathEntry { eyelet, pulley, at, radius, turn, roller, .. } = entry.read();
    let own = entry.subsection("friction");
    let (has_own, own) = (own.is_present(), cable_friction(&own));
    if is_end {
        for key in ["friction", "roller"].into_iter().filter(|key| entry.has(key)) {
            let message = format!("`{}` is at an end of the path, where the cable is fixed", entry.path(key));
            entry.report(key, message, "at an end", "remove it: only places between the ends have friction");
        }
    } else if roller && has_own {
        let message = format!("`{}` has `roller` and `friction`, but a roller has no friction", entry.path(""));
        entry.report("roller", message, "with `friction`", "remove one of them");
    }
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
    let friction = if has_own { own? } else { common };
    let friction = friction.filter(|_| !roller && !is_end);
    Some(PathElement { body, point_m: at.map(|part| *part), radius_m, side, friction })
}

fn spool(entry: &SectionInput<'_>, known: &Known<'_>) -> Option<(usize, f64, SpoolEnd)> {
    let SpoolEntry { joint, radius, turn, end } = entry.read();
    let (joint, kind) = known.joint(entry, "joint", &joint?)?;
    if !kind.is_angle() {
        let message = format!("`{}` names a prismatic joint, which has no spool", entry.path("joint"));
        let help = "name a revolute joint; a cable to a slider ends in an eyelet of its body";
        return entry.refuse("joint", message, "a prismatic joint", help);
    }
    Some((joint, turn.sign() * *radius?, end))
}

/// Sets the free lengths of all tendons from these poses at the start, and checks that the cables can pass their paths.
pub(super) fn tension(mechanism: &mut Mechanism, entries: &Entries<'_>, poses: &[Pose]) {
    for (index, _, section) in entries.written() {
        let tendon = &mechanism.tendons[index];
        let length_m = length_in(mechanism, tendon, poses);
        if length_m.is_nan() {
            let message = format!("the cable of `{}` cannot pass its path at the start", section.path(""));
            let help = "neighbouring places must be apart: an eyelet outside of its neighbouring pulleys, and pulleys that \
                        the cable passes on different sides without overlap";
            section.report("path", message, "places coincide or overlap", help);
        } else if let Some(fault) = {
            let center = |element: &PathElement| center_in(element, poses);
            find_fault(&tendon.path, &settled_path(&tendon.path, center), center)
        } {
            let text = mechanism.describe_cable(tendon, fault);
            let (message, help) = text.split_once(": ").unwrap_or((&text, ""));
            section.report("path", format!("at the start {message}"), "not possible", help);
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
        // The order of the path of the scene.
        let side = if tendon.is_reversed { -element.side } else { element.side };
        let mut settings = match element.is_pulley() {
            true => json!({ "pulley": body, "at": at, "radius": element.radius_m, "turn": Turn::of(side) }),
            false => json!({ "eyelet": body, "at": at }),
        };
        if let Some(law) = element.friction {
            settings["friction"] = cable_friction_settings(law);
        }
        settings
    };
    let spool = |(joint, factor): &(usize, f64), end: Option<SpoolEnd>| {
        let mut settings = json!({
            "joint": mechanism.joints[*joint].name, "radius": factor.abs(), "turn": Turn::of(*factor)
        });
        end.into_iter().for_each(|end| settings["end"] = json!(end));
        settings
    };
    let near = tendon.joints.iter().map(|of| spool(of, None));
    let spools = near.chain(tendon.far_joints.iter().map(|of| spool(of, Some(SpoolEnd::Far))));
    let elastic = |value: f64| tendon.law().map(|_| value);
    let mut path: Vec<Value> = tendon.path.iter().map(element).collect();
    if tendon.is_reversed {
        path.reverse();
    }
    let settings = json!({
        "path": path,
        "from": tendon.is_reversed.then_some(End::Last),
        "spools": spools.collect::<Value>(),
        "stiffness": elastic(tendon.stiffness_n_per_m),
        "damping": elastic(tendon.damping_n_s_per_m),
        "rest": elastic(tendon.rest_m),
    });
    (tendon.name.clone(), settings)
}

/// Settings of the friction of a path element.
fn cable_friction_settings(law: FrictionLaw) -> Value {
    let bristle = match law.kind {
        FrictionKind::Regularised => None,
        FrictionKind::Bristle(bristle) => Some(bristle),
    };
    json!({
        "mu_static": law.mu_static,
        "mu_dynamic": law.mu_dynamic,
        "v_static": law.v_static_m_s,
        "v_dynamic": law.v_dynamic_m_s,
        "presliding": bristle.map(|bristle| presliding(law.mu_static, bristle)),
        "relaxation": bristle.map(|bristle| bristle.relaxation_s),
    })
}

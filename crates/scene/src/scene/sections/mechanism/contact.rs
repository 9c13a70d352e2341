//! Laws and contacts of a mechanism.

use schemars::JsonSchema;
use serde::Deserialize;

use super::names::{Known, NamedLaw, find, find_at};
use crate::law::{ContactLaw, Damping, FrictionKind, FrictionLaw, NormalLaw, damping_from_restitution};
use crate::limits::MAX_CONTACTS;
use crate::mechanism::{ContactPair, ForcePoint, Mechanism, Mirror, OutlineId, OutlineShape};
use crate::scene::quantity::{
    AngularRate, Coordinate, CoordinateRate, LawDamping, Length, NotNegative, Plain, Positive, Quantity, Word,
    keyword_enum, keywords,
};
use crate::scene::section_input::{SectionInput, Subsection};
use crate::scene::sections::law::{self, FrictionSettings};
use crate::scene::{Keyword, Problem};
use crate::units::Dimension;

keyword_enum! {
    pub enum LawType {
        HuntCrossley = "hunt_crossley",
        Restitution = "restitution",
        SpringDamper = "spring_damper",
        Step = "step",
    }
}

/// A law of contacts or joint limits: a normal law, and friction of contacts.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct NamedLawSettings {
    /// "hunt_crossley": k δ^e (1 + 1.5 a δ'), recommended; "restitution": the same with a from the rebound of a free mass;
    /// "spring_damper": k δ^e + c δ'; "step": k δ^e + c δ' with a damper that engages over `transition`.
    #[schemars(extend("default" = "hunt_crossley"))]
    pub r#type: LawType,
    /// Stiffness k in N/m^e (limit: N·m/rad^e), a plain number because its unit depends on the exponent e. Required.
    #[schemars(extend("x-required" = "add the stiffness in N/m^e (limit: N·m/rad^e): stiffness = 1e6"))]
    pub stiffness: Option<Positive<Plain>>,
    /// Exponent e, at least 1.
    #[schemars(extend("default" = 1.5, "minimum" = 1.0))]
    pub exponent: Quantity<Plain>,
    /// Factor a of "hunt_crossley", in s/m (limit: s/rad). For the other types, damping c; with "step", its value
    /// beyond the transition. Default: none.
    #[schemars(extend("x-with" = "type = hunt_crossley|spring_damper|step"))]
    pub damping: Option<NotNegative<LawDamping>>,
    /// Coefficient of restitution of a free mass that impacts at `speed`: above 0, at most 1.
    #[schemars(extend("x-with" = "type = restitution", "exclusiveMinimum" = 0.0, "maximum" = 1.0,
        "x-required" = "add the coefficient of restitution: restitution = 0.6"))]
    pub restitution: Option<Quantity<Plain>>,
    /// Impact speed at which the rebound has this coefficient. Slower impacts have a larger one.
    #[schemars(extend("x-with" = "type = restitution", "x-required" = "add the impact speed: speed = \"0.5 m/s\", or a rate \
        for a limit"))]
    pub speed: Option<Positive<CoordinateRate>>,
    /// Penetration over which the damper engages.
    #[schemars(extend("x-with" = "type = step", "x-required" = "add the penetration over which the damper engages: \
        transition = \"0.1 mm\", or an angle for a limit"))]
    pub transition: Option<Positive<Coordinate>>,
    #[schemars(with = "FrictionSettings")]
    pub friction: Subsection,
}

/// Outlines that may touch.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct ContactEntry {
    /// Two outlines that may touch, each as `body.outline`, as `body` (all its outlines), or as a pattern:
    /// "finger_*.pad" are the pads of all bodies whose names begin with finger_. All corners of each outline touch the
    /// other one; a disc or an ellipse touches only with its points. Required unless `points` is given.
    #[schemars(extend("x-alternative" = "points",
        "x-required" = "add two outlines or bodies: between = [\"palm\", \"object\"]"))]
    pub between: Option<[String; 2]>,
    /// In place of `between`: the outline whose points touch, as `body.outline`. A disc and an ellipse have one point, a
    /// capsule two, a polygon its corners. Two outlines that both have corners need an entry in each direction.
    #[schemars(extend("minLength" = 1))]
    pub points: Option<String>,
    /// Outline that the points touch. Required with `points` unless `faces` is given.
    #[schemars(extend("minLength" = 1, "x-alternative" = "faces|between",
        "x-required" = "add the outline that they touch: face = \"link.pad\", or a list: faces = [\"link.pad\"]"))]
    pub face: Option<String>,
    /// Several outlines that the points touch, in place of `face`.
    pub faces: Option<Vec<String>>,
    /// Name of the law. Required.
    #[schemars(extend("minLength" = 1, "x-required" = "add the name of a law: law = \"pad\", with a section [laws.pad]"))]
    pub law: Option<String>,
    /// Rolling resistance: the lever arm of a moment against the relative rotation, times the normal force. Default: none.
    pub rolling_arm: Option<Positive<Length>>,
    /// Relative rate from which the moment is full; below it, bodies creep.
    #[schemars(extend("default" = "0.1 rad/s"))]
    pub rolling_rate: Positive<AngularRate>,
    /// Where the force acts: on the surface of the face, on the surface of the points, in the middle of the overlap, or
    /// on each body's own surface.
    #[schemars(extend("default" = "face"))]
    pub at: Word<ForcePoint>,
}

keywords! { ForcePoint {
    "face" => ForcePoint::Face,
    "points" => ForcePoint::Points,
    "middle" => ForcePoint::Middle,
    "each" => ForcePoint::Each,
} }

pub(super) fn named_law(section: &SectionInput<'_>) -> Option<NamedLaw> {
    let NamedLawSettings { r#type, stiffness, exponent, damping, restitution, speed, transition, .. } = section.read();
    section.is_valid("type").then_some(())?;
    let friction = law::friction(&[section], 0.0);
    let given = section.dimensions("damping").first().copied();
    let fitting: &[Dimension] = match r#type {
        LawType::HuntCrossley => &[Dimension::LinearImpactDamping, Dimension::AngularImpactDamping],
        LawType::Restitution => &[],
        LawType::SpringDamper | LawType::Step => &[Dimension::LinearDamping, Dimension::AngularDamping],
    };
    if let Some(wrong) = given.filter(|given| !fitting.contains(given)) {
        let examples: Vec<String> = fitting.iter().map(|each| format!("\"{}\"", each.example())).collect();
        let (path, of) = (section.path("damping"), r#type.keyword());
        let message = format!("`{path}` is {}, which type = \"{of}\" does not have", wrong.name());
        return section.refuse("damping", message, "of another law", format!("write {}", examples.join(" or ")));
    }
    let linear: Vec<bool> = given
        .into_iter()
        .chain(section.dimensions("transition"))
        .chain(section.dimensions("speed"))
        .map(Dimension::is_linear)
        .collect();
    if linear.len() == 2 && linear[0] != linear[1] {
        let message = format!("`{}` and `damping` are for different uses of a law", section.path("transition"));
        let help = "give a length and N*s/m for contacts, or an angle and N*m*s/rad for limits";
        return section.refuse("transition", message, "does not fit `damping`", help);
    }
    let damping_si = damping.map_or(0.0, |damping| *damping);
    let damping = match r#type {
        LawType::HuntCrossley => Damping::HuntCrossley { factor_s_per_m: damping_si },
        LawType::Restitution => damping_from_restitution(*restitution?, *speed?),
        LawType::SpringDamper => Damping::Constant { n_s_per_m: damping_si },
        LawType::Step => Damping::Step { max_n_s_per_m: damping_si, transition_m: *transition? },
    };
    let normal = NormalLaw { stiffness_n_per_m_e: *stiffness?, exponent: *exponent, damping };
    Some(NamedLaw { law: ContactLaw { normal, friction: friction? }, linear: linear.first().copied() })
}

/// Finds a law for a contact or a limit.
pub(super) fn law_for(
    section: &SectionInput<'_>,
    key: &str,
    name: &str,
    known: &Known<'_>,
    linear: bool,
    of: &str,
) -> Option<ContactLaw> {
    let names: Vec<&str> = known.laws.iter().map(|(name, _)| *name).collect();
    let found = known.laws[find(section, key, name, "law", &names)?].1.as_ref()?;
    if found.linear.is_some_and(|of_law| of_law != linear) {
        let [has, needs] = [!linear, linear].map(|linear| if linear { "s/m" } else { "s/rad" });
        let message = format!("`{}` has units of {has}, but {of} needs a law with {needs}", section.path(key));
        let help = format!("give {of} a law of its own in [laws.NAME], whose damping and transition have {needs}");
        return section.refuse(key, message, "a law for other units", help);
    }
    Some(found.law)
}

/// A contact pair, and the entry that lists it or its original.
pub(super) type ListedPair<'a> = (ContactPair, SectionInput<'a>);

/// Resolves all contact entries. Two outlines touch once, however often they are listed.
pub(super) fn contacts<'a>(
    root: &SectionInput<'a>,
    mechanism: &Mechanism,
    images: &Mirror<'_>,
    known: &Known<'_>,
) -> Option<Vec<ListedPair<'a>>> {
    let too_many = |count: String| {
        let message = format!("there are {count} contacts, one for each point, but at most {MAX_CONTACTS} are allowed");
        let help = "list fewer pairs of outlines, or give outlines fewer corners";
        root.subsection("contacts").refuse("", message, "", help)
    };
    let mut all: Vec<ListedPair<'a>> = Vec::new();
    let mut is_valid = true;
    let sections = root.list("contacts");
    if sections.len() > MAX_CONTACTS {
        return too_many(format!("{} or more", sections.len()));
    }
    for section in sections {
        let Some(pairs) = contact_entry(&section, mechanism, known) else {
            is_valid = false;
            continue;
        };
        for pair in pairs {
            match listed(&all, &pair, mechanism) {
                None => all.push((pair, section.clone())),
                Some(index) if properties(&all[index].0) == properties(&pair) => {
                    // The points of the direction that describes the whole contact.
                    if mechanism.directions([pair.points, pair.face]).contains(&[pair.points, pair.face]) {
                        all[index].0 = pair;
                    }
                }
                Some(index) => {
                    let [points, face] = [pair.points, pair.face].map(|id| mechanism.outline_name(id));
                    let [entry, other] = [&section, &all[index].1].map(|entry| entry.path(""));
                    let message = format!(
                        "`{entry}` lists `{points}` and `{face}`, which `{other}` lists with another law, `at` or rolling resistance"
                    );
                    let help = format!("remove the pair from one of them, or write in `{entry}` what is in `{other}`");
                    section.report("", message, "listed twice", help);
                    is_valid = false;
                }
            }
            // Each pair has a point; a pattern can match a million pairs.
            if all.len() > MAX_CONTACTS {
                return too_many(format!("more than {MAX_CONTACTS}"));
            }
        }
    }
    for index in 0..all.len() {
        let image = images.contact(&all[index].0);
        if listed(&all, &image, mechanism).is_none() {
            all.push((image, all[index].1.clone()));
        }
    }
    let count: usize = all.iter().map(|(pair, _)| mechanism.outline(pair.points).shape.points().len()).sum();
    if count > MAX_CONTACTS {
        return too_many(count.to_string());
    }
    is_valid.then_some(all)
}

/// Index of the same contact in a list.
fn listed(all: &[ListedPair<'_>], pair: &ContactPair, mechanism: &Mechanism) -> Option<usize> {
    let outlines = |pair: &ContactPair| [pair.points, pair.face];
    all.iter().position(|(other, _)| mechanism.is_same_contact(outlines(other), outlines(pair)))
}

/// What an entry says about a pair.
fn properties(pair: &ContactPair) -> (ContactLaw, Option<FrictionLaw>, ForcePoint) {
    (pair.law, pair.rolling, pair.force_point)
}

/// Resolves a contact entry.
fn contact_entry(section: &SectionInput<'_>, mechanism: &Mechanism, known: &Known<'_>) -> Option<Vec<ContactPair>> {
    let ContactEntry { between, points, face, faces, law, at, rolling_arm, rolling_rate } = section.read();
    if rolling_arm.is_none() {
        section.report_unused(["rolling_rate"], "without `rolling_arm`");
    }
    let rolling = rolling_arm.map(|arm| FrictionLaw {
        mu_static: *arm,
        mu_dynamic: *arm,
        v_static_m_s: *rolling_rate,
        v_dynamic_m_s: 2.0 * *rolling_rate,
        kind: FrictionKind::Regularised,
    });
    let law = law.and_then(|name| law_for(section, "law", &name, known, true, "a contact"));
    let pairs = match between {
        Some(between) => {
            section.report_unused(["points", "face", "faces"], "with `between`");
            pairs_between(section, &between, mechanism)?
        }
        None => {
            if section.has("face") {
                section.report_unused(["faces"], "with `face`");
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
    let pair = |([points, face], _): ([OutlineId; 2], _)| ContactPair {
        name: None,
        points,
        face,
        law,
        rolling,
        force_point: at.0,
        is_reported_on_face: false,
    };
    Some(pairs.into_iter().map(pair).collect())
}

/// Pairs of points and a face with their position in the file.
type Pairs = Vec<([OutlineId; 2], Option<std::ops::Range<usize>>)>;

/// All pairs of two patterns in all their directions.
fn pairs_between(section: &SectionInput<'_>, between: &[String; 2], mechanism: &Mechanism) -> Option<Pairs> {
    let matching = |k: usize| {
        let found = matching_outlines(mechanism, &between[k]);
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
        for pair in mechanism.directions([a, b]) {
            if !pairs.iter().any(|other| mechanism.is_same_contact(*other, pair)) {
                pairs.push(pair);
            }
        }
        // More are refused, and two patterns can match a million.
        if pairs.len() > MAX_CONTACTS {
            break;
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

/// Outlines that fit a name or pattern, by their own name or by that of their body.
pub(super) fn matching_outlines(mechanism: &Mechanism, pattern: &str) -> Vec<OutlineId> {
    let is_match = |id: &OutlineId| {
        let names = [mechanism.outline_name(*id), mechanism.body_name(id.body).to_owned()];
        names.iter().any(|name| matches_pattern(pattern, name))
    };
    outline_ids(mechanism).into_iter().filter(is_match).collect()
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
pub(super) fn outline_id(
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

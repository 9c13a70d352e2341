//! Parses the text of a scene, and resolves it: fills in defaults and checks the physics.
//!
//! Every part is resolved even after another one failed, so that all problems are reported at once.

use std::path::Path;

use serde::Deserialize;
use toml::de::{DeTable, Deserializer};
use toml::{Spanned, Table};

use super::check::Checker;
use super::error::{Problem, SceneError};
use super::keys::{self, closest_match};
use super::keywords::SceneKind;
use super::quantity::Keyword;
use super::schema::{other_schemas, schema_for, top_level};
use super::section_input::{SceneInput, SectionInput};
use super::sections::mechanism::start::deep_overlaps;
use super::sections::{
    CommonLaw, DifferentialSettings, FingerLengths, SceneSettings, SizingResult, Target, bodies, drive, finger, law,
    mechanism, motion, run, start,
};
use super::template::{self, Template};
use super::{Differential, FingerContactLaws, HalfPlane, Hand, HandFinger, Motor, ObjectMotion, Scene, Side};
use crate::mechanism::assemble;
use crate::shape;
use crate::statics::grasp_roles;

/// Parses, checks and resolves the scene of a finger; `file_name` appears in messages and gives the default name.
///
/// # Errors
/// Returns all problems of the text, or an error if the scene is of another kind.
pub fn parse(text: &str, file_name: &str) -> Result<Scene, SceneError> {
    let scene = parse_any(text, file_name)?;
    match scene.kind {
        SceneKind::Finger => Ok(scene),
        kind => Err(invalid(text, file_name)(vec![not_a_finger(text, kind)])),
    }
}

/// Parses, checks and resolves a scene of any kind.
///
/// # Errors
/// Returns all problems of the text.
pub fn parse_any(text: &str, file_name: &str) -> Result<Scene, SceneError> {
    let refuse = invalid(text, file_name);
    let (kind, document, unknown_keys) = document(text).map_err(|error| refuse(vec![syntax_problem(&error)]))?;
    let checker = Checker::new(text, unknown_keys).with_parameters(document.get_ref());
    let input =
        SceneInput::parse(kind, top_level(kind), document).map_err(|error| refuse(vec![syntax_problem(&error)]))?;
    match resolve(&input, &checker, file_name) {
        Some(scene) if checker.is_clean() => Ok(scene),
        _ => Err(refuse(checker.into_problems())),
    }
}

/// Parses the text of a scene without checking its values. Returns its kind, its known keys, and the problems of its
/// other keys. Single entries of lists, such as `"points[0][1]"`, are moved into their lists.
///
/// # Errors
/// Returns the error of a text that is not TOML.
pub fn document(text: &str) -> Result<(SceneKind, Spanned<DeTable<'_>>, Vec<Problem>), toml::de::Error> {
    let mut document = DeTable::parse(text)?;
    let kind = kind(document.get_ref());
    let allowed =
        keys::KeySchemas { kind: kind.keyword(), schema: schema_for(kind), other_kinds: &|| other_schemas(kind) };
    let problems = keys::remove_unknown(document.get_mut(), &allowed);
    Ok((kind, document, problems))
}

/// Returns the values of a scene as written. Single entries of lists are moved into their lists.
///
/// # Errors
/// Returns the error of a text that is not TOML.
pub fn values(text: &str) -> Result<Table, toml::de::Error> {
    Table::deserialize(Deserializer::from(document(text)?.1))
}

/// Parses the scene of a finger as a template for many designs; `file_name` appears in messages and gives the default
/// name.
///
/// # Errors
/// Returns all problems of the text, including keys that tie the scene to one design.
pub fn parse_template(text: &str, file_name: &str) -> Result<Template, SceneError> {
    // Problems of the scene itself are reported first.
    let (scene, refuse) = (parse(text, file_name)?, invalid(text, file_name));
    let (kind, document, unknown_keys) = document(text).map_err(|error| refuse(vec![syntax_problem(&error)]))?;
    let checker = Checker::new(text, unknown_keys).with_parameters(document.get_ref());
    let input =
        SceneInput::parse(kind, top_level(kind), document).map_err(|error| refuse(vec![syntax_problem(&error)]))?;
    template::template(&input, checker, &scene).map_err(refuse)
}

/// Error for problems of a text.
fn invalid<'a>(text: &'a str, file: &'a str) -> impl Fn(Vec<Problem>) -> SceneError + 'a {
    move |problems| SceneError::Invalid { file: file.to_string(), text: text.to_string(), problems }
}

/// Returns the kind of a scene, or the most likely one if it is mistyped: all other keys are checked for this kind.
fn kind(document: &DeTable<'_>) -> SceneKind {
    let Some(text) = document.get("kind").and_then(|value| value.get_ref().as_str()) else {
        return SceneKind::Finger;
    };
    let similar = closest_match(text, &SceneKind::keywords());
    match SceneKind::from_keyword(text).or(similar.and_then(SceneKind::from_keyword)) {
        Some(kind) => kind,
        None if document.contains_key("joints") => SceneKind::Mechanism,
        None if document.contains_key("discs") => SceneKind::Bodies,
        None if ["right", "left", "palm_width"].iter().any(|key| document.contains_key(*key)) => SceneKind::Gripper,
        None => SceneKind::Finger,
    }
}

/// Problem for a valid scene of another kind where the scene of a finger is required.
fn not_a_finger(text: &str, kind: SceneKind) -> Problem {
    let document = DeTable::parse(text).ok();
    Problem::new(
        document.and_then(|document| document.get_ref().get("kind").map(|value| value.span())),
        format!("this is a scene of kind \"{}\", but a scene of kind \"finger\" is required", kind.keyword()),
        "another kind",
        "give the scene of a finger; `phalanx run`, `validate` and `scene` accept the other kinds",
    )
}

/// Converts an error of the TOML parser to a problem.
pub fn syntax_problem(error: &toml::de::Error) -> Problem {
    let help = "a line is a [section] or key = value; strings and quantities are in quotes: radius = \"20 mm\"";
    Problem::new(error.span(), format!("not valid TOML: {}", error.message().trim()), "", help)
}

/// Resolves a scene; its default name is derived from `file_name`.
fn resolve(input: &SceneInput<'_>, checker: &Checker<'_>, file_name: &str) -> Option<Scene> {
    let root = input.top_level(checker);
    let settings: SceneSettings = root.read();
    if settings.extends.is_some() {
        let message = "`extends` refers to another file, but this text is not read from a file";
        let help = "give the scene as a file, or include the contents of the extended scene";
        root.report("extends", message, "relative to no file", help);
    }
    let duration_s = root.is_valid("duration").then_some(*settings.duration);
    let outline = bodies::object_outline(&root);
    let gravity_m_s2 = settings.gravity.map(|component| *component);
    let (mut hand, mut mechanism, mut discs, mut keys) = (Some(Hand::EMPTY), Some(None), None, None);
    match input.kind {
        SceneKind::Mechanism => {
            let found = mechanism::mechanism(&root, gravity_m_s2);
            keys = found.as_ref().and_then(|(_, keys)| keys.clone());
            mechanism = found.map(|(found, _)| Some(found));
        }
        SceneKind::Bodies => discs = bodies::discs(&root, gravity_m_s2),
        _ => hand = self::hand(input, &root, &settings, gravity_m_s2),
    }
    // With an object that is no disc, the scene is one of a mechanism.
    let is_outlined = outline.as_ref().is_some_and(Option::is_some);
    let kind = if is_outlined { SceneKind::Mechanism } else { input.kind };
    let of_run = root.with_schema(kind, top_level(kind));
    let of_integrator = of_run.subsection("integrator");
    let mut integrator = run::integrator(&of_integrator, false);
    let law = discs.as_ref().map(|discs| discs.law);
    let engine = run::engine(&of_run.subsection("engine"), hand.as_ref(), law);
    let bounds = run::bounds(&of_run.subsection("validate"), duration_s);
    let log = run::log(&root.subsection("log"), duration_s);
    if let (Some((outline, inertia)), Some(of_object)) = (outline?, hand.as_mut().filter(|_| checker.is_clean())) {
        match of_object.mechanism_with_object(&outline, inertia) {
            Ok(found) => {
                let section = root.subsection("object").subsection("outline");
                let poses = assemble(&found).map(|start| start.poses).unwrap_or_default();
                let overlaps = if poses.is_empty() { Vec::new() } else { deep_overlaps(&found, &poses) };
                for (_, message) in overlaps {
                    let help = "make the outline smaller, move the object, or open the fingers further";
                    section.report("", message, "starts inside", help);
                }
                // A fixed object is an outline of the ground, which no hand grasps.
                keys = duration_s.map(|duration_s| of_object.grasp_keys(&found, duration_s));
                keys = keys.filter(|keys| keys.object.is_some());
                (*of_object, mechanism) = (Hand::EMPTY, Some(Some(found)));
            }
            Err(error) => {
                let help = "give other angles in [initial], or remove the section, so that they follow from the object";
                return root.subsection("initial").refuse("", error.to_string(), "does not close", help);
            }
        }
    }
    // Initial positions are checked only if everything else is valid.
    if let Some(discs) = discs.filter(|_| checker.is_clean()) {
        bodies::check_initial_positions(&root, &discs);
        mechanism = Some(Some(discs.mechanism()));
    }
    let object_kg = mechanism.as_ref().and_then(Option::as_ref).and_then(|mechanism| {
        let roles = grasp_roles(mechanism, &keys.clone().unwrap_or_default()).ok()?;
        Some(mechanism.bodies[roles.object].mass_kg)
    });
    if object_kg.is_some() {
        integrator = of_integrator.quietly(|input| run::integrator(input, true));
    }
    let thresholds = run::thresholds(&of_run.subsection("criteria"), hand.as_ref(), object_kg, duration_s);
    Some(Scene {
        name: settings.name.unwrap_or_else(|| stem(file_name)),
        kind,
        description: settings.description.unwrap_or_default(),
        source: checker.text.to_string(),
        hand: hand?,
        mechanism: mechanism?,
        duration_s: duration_s?,
        integrator,
        engine,
        bounds,
        thresholds,
        grasp: keys,
        log,
    })
}

/// Name of the file without its extension.
fn stem(file_name: &str) -> String {
    let stem = Path::new(file_name).file_stem().unwrap_or_default().to_string_lossy();
    if stem.trim().is_empty() { "scene".into() } else { stem.into_owned() }
}

/// Resolves the hand; `None` if any part is invalid.
fn hand(
    input: &SceneInput<'_>,
    root: &SectionInput<'_>,
    settings: &SceneSettings,
    gravity_m_s2: [f64; 2],
) -> Option<Hand> {
    let given = bodies::object(root);
    let object = &given.0;
    let fingers_input: Vec<_> = input.sides().iter().map(|side| input.finger(*side, root.checker)).collect();
    let reach_m = shape::max_radius(&object.shape);
    let finger_lengths: Vec<_> = fingers_input.iter().map(|finger| finger::resolve_lengths(finger, reach_m)).collect();
    let resolved_object = match &finger_lengths[..] {
        [finger] => bodies::single_object(root, &given, finger),
        _ => Some(Some(object.clone())),
    };
    let palm_width_m = bodies::palm_width(root, settings, &finger_lengths, object);
    let levels = bodies::levels(root, settings, object);
    let positions = (resolved_object.as_ref(), palm_width_m, levels);
    let targets = bodies::targets(root, input, settings, &finger_lengths, object, positions);

    let section = root.subsection("differential");
    let differential_settings = section.is_present().then(|| section.read::<DifferentialSettings>());
    let differential_settings = differential_settings.filter(|settings| settings.present);
    let curvature_m = shape::curvature_radius(&object.shape);
    let (mut sizings, mut fingers): (Vec<SizingResult>, Vec<Option<HandFinger>>) = Default::default();
    for ((side, finger), (lengths, target)) in
        input.sides().iter().zip(&fingers_input).zip(finger_lengths.iter().zip(&targets))
    {
        let [x, y] = gravity_m_s2;
        let (gravity, has_motor) = ([side.mirror() * x, y], differential_settings.is_none());
        let (sizing, finger) = driven_finger(finger, lengths, gravity, has_motor, curvature_m, target.as_ref());
        sizings.push(sizing);
        fingers.push(finger);
    }
    let differential = match (differential_settings, &sizings[..]) {
        (Some(settings), [right, left]) => {
            let sized = match (*right, *left) {
                (Some(Some(right)), Some(Some(left))) => {
                    Some(Some(drive::combine(right, left, |right, left| right + left)))
                }
                (Some(None), Some(None)) => Some(None),
                _ => None,
            };
            differential(root, &settings, sized).map(Some)
        }
        _ => Some(None),
    };

    let is_fixed = resolved_object.iter().flatten().any(|object| object.motion == ObjectMotion::Fixed);
    let palm_motion = motion::palm_motion(root, is_fixed);
    let mut planes = levels.map(|level| level.map(|level_m| HalfPlane { level_m, contact: None }));
    // The object of one finger is fixed, so nothing can reach the palm.
    if input.sides().len() > 1 {
        let common = CommonLaw::read(root.subsection("contact"), curvature_m);
        for (plane, name) in planes.iter_mut().zip(["palm", "table"]) {
            match plane {
                Some(plane) => plane.contact = Some(common.law_of(name)?),
                None => common.report_unused(name),
            }
        }
    }
    let [palm, table] = planes;
    Some(Hand {
        fingers: fingers.into_iter().collect::<Option<_>>()?,
        palm_width_m: palm_width_m?,
        differential: differential?,
        object: resolved_object?,
        palm,
        table,
        palm_motion,
        gravity_m_s2,
    })
}

/// Resolves a finger with its drive and initial configuration; also returns its sizing. `gravity_m_s2` is in the frame
/// of the finger, `curvature_m` the radius of curvature of the object, and `target` `None` if it is invalid.
fn driven_finger(
    input: &SectionInput<'_>,
    lengths: &FingerLengths,
    gravity_m_s2: [f64; 2],
    has_motor: bool,
    curvature_m: f64,
    target: Option<&Target>,
) -> (SizingResult, Option<HandFinger>) {
    let linkage = finger::linkage(input, lengths);
    let finger_and_target = linkage.as_ref().zip(target);
    let sized = drive::size(input, lengths, finger_and_target, gravity_m_s2);
    let motor = if has_motor { drive::motor(&input.subsection("motor"), sized) } else { Some(Motor::NONE) };
    let spring = drive::spring(&input.subsection("spring"), sized);
    let limit = law::limit(&input.subsection("limit"));
    let contact = CommonLaw::read(input.subsection("contact"), curvature_m);
    let (proximal, distal) = (contact.law_of("proximal"), contact.law_of("distal"));
    let initial = start::initial(input, lengths, finger_and_target, limit);
    let finger = || {
        Some(HandFinger {
            linkage: linkage?,
            motor: motor?,
            spring: spring?,
            limit,
            contact: FingerContactLaws { proximal: proximal?, distal: distal? },
            initial: initial?,
        })
    };
    (sized, finger())
}

/// Resolves the differential: the motor at the input, sized for both fingers, and the seesaw.
fn differential(root: &SectionInput<'_>, settings: &DifferentialSettings, sized: SizingResult) -> Option<Differential> {
    for side in Side::BOTH.map(Side::name) {
        let reason = "with a [differential], which is driven by the motor in [motor]";
        root.subsection(side).report_unused(["motor"], reason);
    }
    let mut motor = drive::motor(&root.subsection("motor"), sized)?;
    motor.inertia_kg_m2 += *settings.input_inertia;
    Some(Differential { motor, seesaw_inertia_kg_m2: *settings.seesaw_inertia })
}

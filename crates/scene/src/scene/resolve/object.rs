//! The grasped object, its positions within the positioning error in the frame of each finger, palm and table.

use super::super::keywords::Motion;
use super::super::section_input::{SceneInput, SectionInput};
use super::super::settings::{HalfPlaneSettings, ObjectSettings, SceneSettings, TableSettings};
use super::super::template::{DENSITY_KG_M3, DEPTH_M};
use super::super::{Disc, DiscMotion, Side};
use super::finger::{FingerLengths, example_base_m};
use crate::numeric::elementary::hypot;
use crate::shape::{self, PlacedShape, Shape, tangent};
use crate::units::{Dimension, format};

/// Largest allowed initial penetration of the object into palm or table.
const MAX_PENETRATION_M: f64 = 1e-3;

fn length(metres: f64) -> String {
    format(metres, Dimension::Length)
}

/// Moves a shape perpendicular to the palm such that it rests on the palm.
pub(crate) fn rest_on_palm(placed: PlacedShape) -> PlacedShape {
    let [x, _] = placed.centre_m;
    let [_, below] = placed.at([x, 0.0]).lowest_point_m();
    placed.at([x, -below])
}

/// Resolves the shape of the object.
pub fn shape(input: &SectionInput<'_>) -> Shape {
    shape_of(&input.subsection("object").read())
}

fn shape_of(settings: &ObjectSettings) -> Shape {
    Shape::Disc { radius_m: settings.radius.map_or(0.020, |radius| *radius) }
}

/// The object as given: of one finger, its position is NaN along the palm if the base determines it.
pub struct Object {
    pub disc: Disc,
    pub is_present: bool,
}

/// Resolves the object, with the defaults that depend on its shape.
pub fn object(input: &SectionInput<'_>) -> Object {
    let settings: ObjectSettings = input.subsection("object").read();
    let shape = shape_of(&settings);
    let coordinate = |value: Option<_>| value.map_or(f64::NAN, |value: super::super::quantity::Quantity<_>| *value);
    let centre_m = match settings.centre {
        Some(centre) => centre.map(|coordinate| *coordinate),
        None => [coordinate(settings.offset), coordinate(settings.height)],
    };
    let mut placed = PlacedShape { shape, centre_m, angle_rad: settings.angle.map_or(0.0, |angle| *angle) };
    if centre_m[1].is_nan() {
        placed = rest_on_palm(placed);
    }
    let mut disc = Disc::fixed_object(placed);
    if settings.motion.is_some_and(|motion| motion.0 == Motion::Free) {
        let mass_kg = settings.mass.map_or_else(|| shape::mass(&shape, DENSITY_KG_M3, DEPTH_M), |mass| *mass);
        let inertia_kg_m2 = Some(settings.inertia.map_or_else(|| shape::inertia(&shape, mass_kg), |inertia| *inertia));
        let velocity_m_s = settings.velocity.map_or([0.0; 2], |velocity| velocity.map(|rate| *rate));
        let spin_rad_s = settings.spin.map_or(0.0, |spin| *spin);
        disc.motion = DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s };
    }
    Object { disc, is_present: settings.present.unwrap_or(true) }
}

/// Resolves the object of a single finger: an empty list without object, `None` if it is invalid.
pub(crate) fn single_object(input: &SectionInput<'_>, object: &Object, finger: &FingerLengths) -> Option<Vec<Disc>> {
    let (section, lengths) = (input.subsection("object"), input.subsection("lengths"));
    if !object.is_present {
        if !input.has("design") {
            section.report_unused("radius", "with present = false and no [design]");
        }
        return Some(Vec::new());
    }
    // An invalid centre has been reported.
    section.is_valid("centre").then_some(())?;
    let placed = object.disc.placed();
    let [x, y] = placed.centre_m;
    if x.is_finite() {
        lengths.report_unused("base", "with object.centre");
        return Some(vec![object.disc.clone()]);
    }
    if finger.base_m.is_none() && lengths.is_present() && !lengths.has("base") {
        let [base, height] = [example_base_m(finger.half_width_m, shape::max_radius(&placed.shape)), y].map(length);
        let help = format!(
            "add the distance along the palm to the object's centre, such as [lengths] base = \"{base}\", or [object] centre = \
             [\"-{base}\", \"{height}\"], or [object] present = false"
        );
        lengths.report_missing("base", &help);
    }
    Some(vec![Disc::fixed_object(placed.at([-finger.base_m?, y]))])
}

/// Lowest and highest coordinate y of the object.
fn heights_m(object: &Disc) -> [f64; 2] {
    [-1.0, 1.0].map(|to| object.placed().furthest_point_m([0.0, to])[1])
}

/// Heights of the lower half plane (palm or ground) and of the table, if present.
pub fn levels(input: &SectionInput<'_>, settings: &SceneSettings, object: &Disc) -> [Option<f64>; 2] {
    let (ground, table) = (input.subsection("half_plane"), input.subsection("table"));
    let below = match input.kind.fingers() {
        0 => ground.is_present().then(|| *ground.read::<HalfPlaneSettings>().level),
        _ => settings.palm.unwrap_or(true).then_some(0.0),
    };
    let table = table.is_present().then(|| table.read::<TableSettings>()).filter(|table| table.present);
    [below, table.map(|table| table.level.map_or_else(|| heights_m(object)[1], |level| *level))]
}

/// Checks that the object does not penetrate palm or table at the start.
fn check_planes(input: &SectionInput<'_>, object: &Disc, [palm, table]: [Option<f64>; 2]) {
    let [lowest, highest] = heights_m(object);
    let (object, table_input) = (input.subsection("object"), input.subsection("table"));
    let planes = [
        ("palm", palm.map(|_| -lowest), &object, "height"),
        ("table", table.map(|level_m| highest - level_m), &table_input, "level"),
    ];
    for (plane, depth, section, key) in planes {
        let Some(depth) = depth.filter(|depth| *depth > MAX_PENETRATION_M) else { continue };
        let limit = length(MAX_PENETRATION_M);
        let message =
            format!("the object starts {:.3} mm inside the {plane}, but at most {limit} is allowed", depth * 1e3);
        let help = "move the object by `object.height`, or the table by `table.level`";
        section.report(key, message, "starts inside", help);
    }
}

/// Resolves the palm width of a gripper: as given, or twice the base of both fingers. 0 in other kinds of scene.
pub fn palm_width(
    input: &SectionInput<'_>,
    settings: &SceneSettings,
    fingers: &[FingerLengths],
    object: &Disc,
) -> Option<f64> {
    let [right, left] = fingers else { return Some(0.0) };
    if input.has("palm_width") {
        for section in [input.clone(), input.subsection("right"), input.subsection("left")] {
            let lengths = section.subsection("lengths");
            input.checker.report_unused_at("lengths.base", lengths.span("base"), "with palm_width");
        }
        return settings.palm_width.map(|width| *width);
    }
    // An invalid base has been reported.
    let lacks_base = !input.subsection("lengths").has("base")
        && fingers.iter().any(|finger| finger.lengths.is_some() && finger.base_m.is_none());
    if lacks_base {
        let example = || example_base_m(right.half_width_m, shape::max_radius(&object.shape));
        let base_m = right.base_m.or(left.base_m).unwrap_or_else(example);
        let [base, width] = [base_m, 2.0 * base_m].map(length);
        let help = format!("add it, such as palm_width = \"{width}\", or half of it: [lengths] base = \"{base}\"");
        input.report_missing("palm_width", &help);
    } else if let (Some(first), Some(second)) = (right.base_m, left.base_m)
        && first != second
    {
        let width = length(first + second);
        let help = format!("add it, because the bases of both fingers differ: palm_width = \"{width}\"");
        input.report_missing("palm_width", &help);
    }
    right.base_m.filter(|_| right.base_m == left.base_m).map(|base_m| 2.0 * base_m)
}

/// The object that a finger closes on, in the frame of the finger.
#[derive(Clone, Debug)]
pub struct Target {
    /// The object; `None` without an object.
    pub object: Option<PlacedShape>,
    /// The object at both ends of the positioning error of a gripper.
    pub ends: Vec<PlacedShape>,
}

/// Returns the target of each finger; `None` if it is invalid.
pub fn targets(
    input: &SectionInput<'_>,
    scene: &SceneInput,
    settings: &SceneSettings,
    fingers: &[FingerLengths],
    object: &Disc,
    (discs, palm_width_m, levels): (Option<&[Disc]>, Option<f64>, [Option<f64>; 2]),
) -> Vec<Option<Target>> {
    if fingers.len() < 2 {
        // The frame of a single finger is that of the scene.
        let target = |object: Option<PlacedShape>| Target { object, ends: object.into_iter().collect() };
        return vec![discs.map(|discs| target(discs.first().map(Disc::placed)))];
    }
    let problem_count = input.checker.count();
    check_planes(input, object, levels);
    let error_m = positioning_error(input, settings, object.centre_m[0]);
    let mut range = palm_width_m.zip(error_m).filter(|_| input.checker.count() == problem_count);
    let mut targets = Vec::new();
    for (side, finger) in scene.sides().iter().zip(fingers) {
        let half_width_m = finger.lengths.map(|lengths| lengths.half_width_m);
        let mut target = range.map(|(palm_width_m, error_m)| {
            let PlacedShape { shape, centre_m: [x, y], angle_rad } = object.placed();
            let angle_rad = side.mirror() * angle_rad;
            let at = |x: f64| PlacedShape { shape, centre_m: [x - 0.5 * palm_width_m, y], angle_rad };
            Target { object: Some(at(side.mirror() * x)), ends: vec![at(-error_m), at(error_m)] }
        });
        if let (Some(candidate), Some(half_width_m)) = (&target, half_width_m)
            && !is_ground_joint_clear(input, *side, candidate, half_width_m)
        {
            // The problem is reported for one finger only.
            (target, range) = (None, None);
        }
        targets.push(target.filter(|_| half_width_m.is_some()));
    }
    targets
}

/// Resolves the positioning error, which must be at least the offset of the object.
fn positioning_error(input: &SectionInput<'_>, settings: &SceneSettings, offset_m: f64) -> Option<f64> {
    input.is_valid("positioning_error").then_some(())?;
    let error_m = settings.positioning_error.map_or(offset_m.abs(), |error| *error);
    if offset_m.abs() <= error_m {
        return Some(error_m);
    }
    let [error, offset] = [error_m, offset_m.abs()].map(length);
    let message = format!("`positioning_error` is {error}, but must be at least the offset of the object, {offset}");
    let help = "raise it, reduce `object.offset`, or remove it (default: the offset of the object)";
    input.report("positioning_error", message, "smaller than the offset", help);
    None
}

/// Checks that the ground joint of a finger is outside of the object, enlarged by half the width of a link, at all
/// positions.
fn is_ground_joint_clear(input: &SectionInput<'_>, side: Side, target: &Target, half_width_m: f64) -> bool {
    let tangent_failure = |placed: &PlacedShape| {
        let reach = tangent(placed, half_width_m).err()?;
        Some((hypot(placed.centre_m[0], placed.centre_m[1]), reach))
    };
    let nearest = target.object.iter().chain(&target.ends).filter_map(tangent_failure);
    let Some((distance, reach)) = nearest.min_by(|nearer, other| nearer.0.total_cmp(&other.0)) else { return true };
    let [distance, reach] = [distance, reach].map(|value| format!("{:.3} mm", value * 1e3));
    let message = format!(
        "the ground joint of the {} finger is {distance} from the object's centre, but must be at least {reach} away: the \
         radius and half a link's width",
        side.name()
    );
    let object = input.subsection("object");
    let help = "increase `palm_width`, or reduce `object.offset` or `positioning_error`";
    match object.has("offset") || !input.has("palm_width") {
        true => object.report("offset", message, "inside the object", help),
        false => input.report("palm_width", message, "inside the object", help),
    }
    false
}

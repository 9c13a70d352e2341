//! The grasped object with its positions within the positioning error, discs, palm, ground and table.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use super::finger::{FingerLengths, example_base_m};
use super::law::{CommonLaw, contact_settings};
use super::mechanism::outline::{OutlineSettings, outline};
use super::{FINGER, FINGERS, GRIPPER, SceneSettings, extend};
use crate::limits::{MAX_DISCS, MAX_START_OVERLAP_M};
use crate::mechanism::{Measure, Mechanism, OutlineShape, PrescribedMotion};
use crate::numeric::decimals;
use crate::numeric::elementary::{hypot, sin_cos};
use crate::scene::discs::PLANE;
use crate::scene::keys::is_name;
use crate::scene::keywords::Motion;
use crate::scene::quantity::{Acceleration, Angle, AngularRate, Inertia, Length, Mass, Positive, Quantity, Speed};
use crate::scene::section_input::{SceneInput, SectionInput, Subsection};
use crate::scene::{Disc, DiscMotion, Discs, Object, ObjectMotion, Problem, Side};
use crate::shape::{self, PlacedShape, Shape, tangent};
use crate::units::{Dimension, format};

/// The object to be grasped, fixed; a disc unless [object.outline] is given.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(extend("x-gripper" = { "description": "The object to be grasped, a disc unless [object.outline] is given." }))]
pub struct ObjectSettings {
    /// Whether there is an object; without one the finger moves freely.
    #[schemars(extend("x-kinds" = FINGER, "default" = true))]
    pub present: Option<bool>,
    /// "free": moves under gravity and contact forces; "fixed": does not move.
    #[schemars(extend("x-kinds" = GRIPPER, "default" = "free", "enum" = ["free", "fixed"]))]
    pub motion: Option<Motion>,
    #[schemars(extend("default" = "20 mm"))]
    pub radius: Option<Positive<Length>>,
    /// Position of the centre. Default: (−base, radius), resting on the palm, with the base of [design] or [lengths].
    #[schemars(extend("x-kinds" = FINGER, "x-with" = "present = true", "x-derived" = true))]
    pub centre: Option<[Quantity<Length>; 2]>,
    /// Positioning error: initial distance of the centre to the right of the middle of the palm.
    #[schemars(extend("x-kinds" = GRIPPER, "default" = "0 mm"))]
    pub offset: Option<Quantity<Length>>,
    /// Initial height of the centre above the palm. Default: the radius, so that the object touches the palm.
    #[schemars(extend("x-kinds" = GRIPPER))]
    pub height: Option<Quantity<Length>>,
    /// Initial angle.
    #[schemars(extend("x-kinds" = GRIPPER, "default" = "0 deg"))]
    pub angle: Option<Quantity<Angle>>,
    /// Mass. Default: that of a homogeneous disc with 1070 kg/m³ and a depth of 40 mm (53.784 g for a radius of 20 mm).
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "motion = free"))]
    pub mass: Option<Positive<Mass>>,
    /// Moment of inertia about the centre. Default: mass × radius² / 2 of a homogeneous disc.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "motion = free"))]
    pub inertia: Option<Positive<Inertia>>,
    /// Initial velocity of the centre.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "motion = free", "default" = ["0 m/s", "0 m/s"]))]
    pub velocity: Option<[Quantity<Speed>; 2]>,
    /// Initial angular rate, counter-clockwise.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "motion = free", "default" = "0 rad/s"))]
    pub spin: Option<Quantity<AngularRate>>,
    /// Outline of an object that is not a disc, about its centre. The scene is then simulated as a mechanism, without
    /// criteria of grasps; `radius` is that of the disc for which the initial configuration and the drive are computed.
    #[schemars(with = "OutlineSettings", extend("x-kinds" = FINGERS))]
    pub outline: Subsection,
}

/// Settings that describe a given object.
pub fn object_settings(object: Option<&Object>) -> Value {
    let Some(object) = object else { return json!({ "present": false }) };
    let (Shape::Disc { radius_m }, [offset, height]) = (object.shape, object.centre_m);
    let mut settings = json!({
        "present": true,
        "motion": Motion::Fixed,
        "radius": radius_m,
        "centre": object.centre_m,
        "offset": offset,
        "height": height,
        "angle": object.angle_rad,
    });
    if let ObjectMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s } = object.motion {
        extend(
            &mut settings,
            json!({
                "motion": Motion::Free,
                "velocity": velocity_m_s,
                "mass": mass_kg,
                "inertia": inertia_kg_m2,
                "spin": spin_rad_s,
            }),
        );
    }
    settings
}

/// A disc.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct DiscSettings {
    #[schemars(extend("x-required" = "add its size: radius = \"10 mm\""))]
    pub radius: Option<Positive<Length>>,
    /// Initial position of the centre. Required.
    #[schemars(extend("x-required" = "add the initial position: centre = [\"0 mm\", \"10 mm\"]"))]
    pub centre: Option<[Quantity<Length>; 2]>,
    /// "free": moves under gravity and contact forces; "driven": moves with `velocity`, `acceleration` and `spin`, not
    /// affected by contacts; "fixed": does not move.
    #[schemars(extend("default" = "free"))]
    pub motion: Motion,
    /// Initial velocity of the centre (motion = "free" or "driven").
    #[schemars(extend("x-with" = "motion = free|driven", "default" = ["0 m/s", "0 m/s"]))]
    pub velocity: [Quantity<Speed>; 2],
    /// Constant acceleration of the centre (motion = "driven").
    #[schemars(extend("x-with" = "motion = driven", "default" = ["0 m/s^2", "0 m/s^2"]))]
    pub acceleration: [Quantity<Acceleration>; 2],
    /// Mass. Required with motion = "free", not allowed otherwise.
    #[schemars(extend("x-with" = "motion = free",
        "x-required" = "add the mass: mass = \"100 g\"; or drive the disc: motion = \"driven\" with velocity"))]
    pub mass: Option<Positive<Mass>>,
    /// Whether contact forces can rotate it (motion = "free").
    #[schemars(extend("x-with" = "motion = free", "default" = true))]
    pub rotates: bool,
    /// Moment of inertia about the centre (motion = "free"). Default: mass × radius² / 2 of a homogeneous disc.
    #[schemars(extend("x-with" = "motion = free"))]
    pub inertia: Option<Positive<Inertia>>,
    /// Initial angular rate, counter-clockwise (motion = "free" or "driven").
    #[schemars(extend("x-with" = "motion = free|driven", "default" = "0 rad/s"))]
    pub spin: Option<Quantity<AngularRate>>,
}

/// Settings that describe discs, the half plane below them, and their contact law.
pub fn discs_settings(mechanism: &Mechanism) -> Value {
    let mut file = json!({ "discs": {} });
    for body in &mechanism.bodies {
        let ([x, y, _], [vx, vy, spin_rad_s]) = (body.pose, body.rate);
        let mut disc = json!({
            "radius": body.outlines.first().map(|outline| outline.shape.radius_m()),
            "centre": [x, y],
            "velocity": [vx, vy],
            "spin": body.rotates().then_some(spin_rad_s),
        });
        let motion = match body.motion {
            Some(PrescribedMotion::ConstantAcceleration { acceleration_m_s2 }) => {
                json!({ "motion": Motion::Driven, "acceleration": acceleration_m_s2 })
            }
            _ => json!({
                "motion": Motion::Free,
                "mass": body.mass_kg,
                "rotates": body.rotates(),
                "inertia": body.rotates().then_some(body.inertia_kg_m2),
            }),
        };
        extend(&mut disc, motion);
        file["discs"][&body.name] = disc;
    }
    for outline in &mechanism.ground_outlines {
        match outline.shape {
            OutlineShape::Disc { center_m, radius_m } => {
                let disc = json!({ "radius": radius_m, "centre": center_m, "motion": Motion::Fixed });
                file["discs"][&outline.name] = disc;
            }
            OutlineShape::HalfPlane { point_m: [_, level_m], .. } => file["half_plane"] = json!({ "level": level_m }),
            _ => {}
        }
    }
    file["contact"] = mechanism.contacts.first().map_or(Value::Null, |pair| contact_settings(&pair.law));
    file
}

/// A solid, fixed half plane below a level. An empty section suffices to add it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct HalfPlaneSettings {
    /// Height y of the surface.
    #[schemars(extend("default" = "0 mm"))]
    pub level: Quantity<Length>,
}

/// A table that supports the object on the side away from the palm: a solid, fixed half plane above a level. An
/// empty section suffices to add it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct TableSettings {
    /// Whether there is a table.
    #[schemars(extend("default" = true))]
    pub present: bool,
    /// Height of the surface above the palm. Default: the top of the object, so that the object touches the table.
    #[schemars(extend("x-with" = "present = true"))]
    pub level: Option<Quantity<Length>>,
}

/// Default density of links and object.
pub const DENSITY_KG_M3: f64 = 1070.0;
/// Default depth of links and object, perpendicular to the plane.
pub const DEPTH_M: f64 = 0.040;

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

/// Resolves the object, with the defaults that depend on its shape; also returns whether it is present. For one finger,
/// its position along the palm is NaN if the base determines it.
pub fn object(input: &SectionInput<'_>) -> (Object, bool) {
    let settings: ObjectSettings = input.subsection("object").read();
    let shape = shape_of(&settings);
    let coordinate = |value: Option<_>| value.map_or(f64::NAN, |value: Quantity<_>| *value);
    let centre_m = match settings.centre {
        Some(centre) => centre.map(|coordinate| *coordinate),
        None => [coordinate(settings.offset), coordinate(settings.height)],
    };
    let mut placed = PlacedShape { shape, centre_m, angle_rad: settings.angle.map_or(0.0, |angle| *angle) };
    if centre_m[1].is_nan() {
        let [lowest, _] = heights_m(input, &Object::fixed(placed.at([0.0; 2])));
        placed = placed.at([centre_m[0], 0.0 - lowest]);
    }
    let mut object = Object::fixed(placed);
    if settings.motion.is_some_and(|motion| motion == Motion::Free) {
        let mass_kg = settings.mass.map_or_else(|| shape::mass(&shape, DENSITY_KG_M3, DEPTH_M), |mass| *mass);
        let inertia_kg_m2 = settings.inertia.map_or_else(|| shape::inertia(&shape, mass_kg), |inertia| *inertia);
        let velocity_m_s = settings.velocity.map_or([0.0; 2], |velocity| velocity.map(|rate| *rate));
        let spin_rad_s = settings.spin.map_or(0.0, |spin| *spin);
        object.motion = ObjectMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s };
    }
    (object, settings.present.unwrap_or(true))
}

/// Resolves the outline of an object that is not a disc. If the object can move, also returns its mass, inertia and
/// centre of mass; those that are not given are those of a homogeneous object. The outer `None` means that the outline
/// is invalid.
pub fn object_outline(input: &SectionInput<'_>) -> Option<Option<(OutlineShape, InertiaAbout)>> {
    let object = input.subsection("object");
    let section = object.subsection("outline");
    if !section.is_present() {
        return Some(None);
    }
    let shape = outline(&section)?;
    let Some(area) = shape.area() else {
        let message = format!("`{}` is a half plane", section.path("type"));
        return section.refuse("type", message, "no object", "write a closed outline");
    };
    let ObjectSettings { mass, inertia, .. } = object.quietly(SectionInput::read);
    let mass_kg = mass.map_or(area.area_m2 * DENSITY_KG_M3 * DEPTH_M, |mass| *mass);
    let inertia_kg_m2 = inertia.map_or(mass_kg * area.polar_m4 / area.area_m2, |inertia| *inertia);
    Some(Some((shape, (mass_kg, inertia_kg_m2, area.centroid_m))))
}

/// Mass, kg; moment of inertia about the centre of mass, kg·m²; centre of mass, m.
pub type InertiaAbout = (f64, f64, [f64; 2]);

/// Resolves the object of a single finger: `Some(None)` without object, `None` if it is invalid.
pub fn single_object(
    input: &SectionInput<'_>,
    given: &(Object, bool),
    finger: &FingerLengths,
) -> Option<Option<Object>> {
    let (object, is_present) = given;
    let (section, lengths) = (input.subsection("object"), input.subsection("lengths"));
    if !is_present {
        if !input.has("design") {
            section.report_unused(["radius"], "with present = false and no [design]");
        }
        return Some(None);
    }
    // An invalid centre has been reported.
    section.is_valid("centre").then_some(())?;
    let placed = object.placed();
    let [x, y] = placed.centre_m;
    if x.is_finite() {
        lengths.report_unused(["base"], "with object.centre");
        return Some(Some(object.clone()));
    }
    if finger.base_m.is_none() && lengths.is_present() && !lengths.has("base") {
        let [base, height] = [example_base_m(finger.half_width_m, shape::max_radius(&placed.shape)), y].map(length);
        let help = format!(
            "add the distance along the palm to the object's centre, such as [lengths] base = \"{base}\", or [object] centre = \
             [\"-{base}\", \"{height}\"], or [object] present = false"
        );
        lengths.report_missing("base", &help);
    }
    Some(Some(Object::fixed(placed.at([-finger.base_m?, y]))))
}

/// Lowest and highest coordinate y of the object.
fn heights_m(input: &SectionInput<'_>, object: &Object) -> [f64; 2] {
    let section = input.subsection("object").subsection("outline");
    match section.is_present().then(|| section.quietly(outline)).flatten() {
        // A half plane is no object.
        Some(shape) if shape.area().is_some() => {
            let (sin, cos) = sin_cos(object.angle_rad);
            [-1.0, 1.0].map(|to| object.centre_m[1] + to * shape.support_m([to * sin, to * cos]))
        }
        _ => [-1.0, 1.0].map(|to| object.placed().furthest_point_m([0.0, to])[1]),
    }
}

/// Heights of the palm and of the table; `None` for one that is missing.
pub fn levels(input: &SectionInput<'_>, settings: &SceneSettings, object: &Object) -> [Option<f64>; 2] {
    let table = input.subsection("table");
    let palm = settings.palm.unwrap_or(true).then_some(0.0);
    let table = table.is_present().then(|| table.read::<TableSettings>()).filter(|table| table.present);
    [palm, table.map(|table| table.level.map_or_else(|| heights_m(input, object)[1], |level| *level))]
}

/// Checks that the object does not penetrate palm or table at the start.
fn check_planes(input: &SectionInput<'_>, object: &Object, [palm, table]: [Option<f64>; 2]) {
    let [lowest, highest] = heights_m(input, object);
    let (object, table_input) = (input.subsection("object"), input.subsection("table"));
    let planes = [
        ("palm", palm.map(|_| -lowest), &object, "height"),
        ("table", table.map(|level_m| highest - level_m), &table_input, "level"),
    ];
    for (plane, depth, section, key) in planes {
        let Some(depth) = depth.filter(|depth| *depth > MAX_START_OVERLAP_M) else { continue };
        let [depth, limit] = Measure::distinct([depth, MAX_START_OVERLAP_M].map(Measure::Length));
        let message = format!("the object starts {depth} inside the {plane}, but at most {limit} is allowed");
        let help = "move the object by `object.height`, or the table by `table.level`";
        section.report(key, message, "starts inside", help);
    }
}

/// Resolves the palm width of a gripper: the given value, or twice the base of the fingers. It is 0 in other kinds of
/// scene.
pub fn palm_width(
    input: &SectionInput<'_>,
    settings: &SceneSettings,
    fingers: &[FingerLengths],
    object: &Object,
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

/// The object that a finger grasps, in the frame of the finger.
#[derive(Clone, Debug)]
pub struct Target {
    /// The object; `None` without an object.
    pub object: Option<PlacedShape>,
    /// The object at the two ends of the positioning error of a gripper.
    pub ends: Vec<PlacedShape>,
}

/// Returns the target of each finger; `None` if it is invalid.
pub fn targets(
    input: &SectionInput<'_>,
    scene: &SceneInput<'_>,
    settings: &SceneSettings,
    fingers: &[FingerLengths],
    object: &Object,
    (resolved_object, palm_width_m, levels): (Option<&Option<Object>>, Option<f64>, [Option<f64>; 2]),
) -> Vec<Option<Target>> {
    if fingers.len() < 2 {
        // The frame of a single finger is that of the scene.
        let target = |object: Option<PlacedShape>| Target { object, ends: object.into_iter().collect() };
        return vec![resolved_object.map(|object| target(object.as_ref().map(Object::placed)))];
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
    input.refuse("positioning_error", message, "smaller than the offset", help)
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
    let decimals = decimals(&[distance * 1e3, reach * 1e3], 3);
    let [distance, reach] = [distance, reach].map(|value| format!("{:.decimals$} mm", value * 1e3));
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

/// Resolves all discs, their half plane and their law; `None` if any is invalid.
pub fn discs(root: &SectionInput<'_>, gravity_m_s2: [f64; 2]) -> Option<Discs> {
    let ground = root.subsection("half_plane");
    let half_plane_m = ground.is_present().then(|| *ground.read::<HalfPlaneSettings>().level);
    let law = CommonLaw::read(root.subsection("contact"), 0.0).law();
    let section = root.subsection("discs");
    let sections = section.subsections();
    let count = sections.len();
    if count == 0 {
        let help = "add at least one disc that moves: [discs.hammer] with radius, centre and mass";
        root.checker.report_missing_at("[discs.NAME]", section.span, help);
        return None;
    }
    if count > MAX_DISCS {
        let message = format!("there are {count} discs, but at most {MAX_DISCS} are allowed");
        return section.refuse("", message, "", format!("remove {} of them", count - MAX_DISCS));
    }
    let all: Vec<Option<Disc>> = sections.iter().map(|(name, keys)| disc(name, keys)).collect();
    let all: Vec<Disc> = all.into_iter().collect::<Option<_>>()?;
    if !all.iter().any(|disc| disc.motion.moves()) {
        let help = "make one of them move: motion = \"free\" with mass, or motion = \"driven\" with velocity";
        section.report("", "all discs are fixed: nothing would move", "", help);
    }
    let is_free = |disc: &Disc| matches!(disc.motion, DiscMotion::Free { .. });
    if gravity_m_s2 != [0.0; 2] && !all.iter().any(is_free) {
        root.report_unused(["gravity"], "without a disc with motion = \"free\"");
    }
    Some(Discs { discs: all, half_plane_m, law: law?, gravity_m_s2 })
}

/// Resolves one disc; `None` if it is invalid.
fn disc(name: &str, input: &SectionInput<'_>) -> Option<Disc> {
    let checked_name = check_name(input, name);
    let settings: DiscSettings = input.read();
    // If the motion is invalid, the required keys are unknown.
    input.is_valid("motion").then_some(())?;
    let radius_m = settings.radius.map(|radius| *radius);
    let velocity_m_s = settings.velocity.map(|rate| *rate);
    let spin_rad_s = settings.spin.map_or(0.0, |spin| *spin);
    let motion = match settings.motion {
        Motion::Fixed => DiscMotion::Fixed,
        Motion::Driven => {
            let acceleration_m_s2 = settings.acceleration.map(|acceleration| *acceleration);
            DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s }
        }
        Motion::Free => {
            let inertia_kg_m2 = inertia(input, name, &settings, radius_m)?;
            DiscMotion::Free { mass_kg: *settings.mass?, inertia_kg_m2, velocity_m_s, spin_rad_s }
        }
    };
    let centre_m = settings.centre?.map(|coordinate| *coordinate);
    Some(Disc { name: checked_name?, radius_m: radius_m?, centre_m, motion })
}

/// Checks a name: names are used in topics, keys and columns, joined by `-` for pairs.
fn check_name(input: &SectionInput<'_>, text: &str) -> Option<String> {
    let problem = match text {
        "" => "the name of a disc is empty".to_string(),
        PLANE => format!("`{PLANE}` cannot be the name of a disc: it is the name of the half plane"),
        _ if is_name(text) => return Some(text.to_string()),
        _ => format!("`{}` cannot be the name of a disc", text.escape_debug()),
    };
    let help =
        "use a letter followed by letters, digits and _, as in [discs.hammer_2]: the name is part of topics and keys";
    input.checker.push(Problem::new(input.name_span.clone(), problem, "invalid name", help));
    None
}

/// Inertia of a free disc: `Some(None)` if it does not rotate, `None` if invalid.
fn inertia(
    input: &SectionInput<'_>,
    name: &str,
    settings: &DiscSettings,
    radius_m: Option<f64>,
) -> Option<Option<f64>> {
    if !settings.rotates {
        input.report_unused(["inertia", "spin"], "with rotates = false");
        return Some(None);
    }
    if input.has("inertia") {
        return settings.inertia.map(|inertia| Some(*inertia));
    }
    let homogeneous = *settings.mass? * shape::inertia(&Shape::Disc { radius_m: radius_m? }, 1.0);
    if homogeneous.is_normal() {
        return Some(Some(homogeneous));
    }
    let message = format!("the mass and radius of `discs.{name}` give an inertia of {homogeneous:e} kg m^2");
    let help = "check mass and radius, give `inertia`, or write rotates = false";
    input.refuse("mass", message, "not a finite number above 0", help)
}

/// Rejects initial positions in which the centre of a disc is inside another disc or the half plane: contact laws do
/// not cover such deep penetrations.
pub(crate) fn check_initial_positions(input: &SectionInput<'_>, Discs { discs, half_plane_m, .. }: &Discs) {
    let section = input.subsection("discs");
    for (index, b) in discs.iter().enumerate() {
        let keys = section.subsection(&b.name);
        for a in &discs[..index] {
            let distance_m = hypot(a.centre_m[0] - b.centre_m[0], a.centre_m[1] - b.centre_m[1]);
            let [radius_a, radius_b] = [a, b].map(|disc| disc.radius_m);
            let moves = a.motion.moves() || b.motion.moves();
            if moves && distance_m <= radius_a.max(radius_b) {
                let message = format!(
                    "discs `{}` and `{}` overlap too deeply at the start: the distance of their centres is {}, but must exceed \
                     the radii {} and {}",
                    a.name,
                    b.name,
                    length(distance_m),
                    length(radius_a),
                    length(radius_b)
                );
                let help =
                    "move them apart: discs may overlap at the start, but the centre of each must be outside the other";
                keys.report("centre", message, "too deep", help);
            }
        }
        if let Some(level_m) = *half_plane_m
            && b.motion.moves()
            && b.centre_m[1] <= level_m
        {
            let message = format!(
                "the centre of `{}` is inside the half plane at the start: y = {}, but must be above its level of {}",
                b.name,
                length(b.centre_m[1]),
                length(level_m)
            );
            let help = "raise the disc, or lower `half_plane.level`: the disc may overlap the half plane at the start, but not its centre";
            keys.report("centre", message, "too deep", help);
        }
    }
}

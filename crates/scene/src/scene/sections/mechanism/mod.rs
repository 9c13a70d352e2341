//! Mechanisms: bodies with outlines, joints, springs, couplings, tendons, actuators, laws and contacts.
//!
//! Sections refer to each other by name. Lists of the [`Mechanism`] are in the order of the names.
//!
//! | file | sections |
//! |---|---|
//! | `joint` | joints, springs, couplings and rotors |
//! | `limit` | limits of sums of joint coordinates |
//! | `actuator` | actuators |
//! | `tendon` | tendons |
//! | `outline` | outlines of bodies |
//! | `powertrain` | gears, motors and feedback of actuators, points of bodies |
//! | `contact` | laws and contacts |
//! | `grasp` | grasp |
//! | `mirror` | mirror |
//! | `moving_base` | no section: the body of moves, vibrations and path |
//! | `names` | no section: names by which sections refer to each other, and checks that they share |
//! | `show` | a mechanism as sections |
//! | `start` | no section: checks of the assembled start |

mod actuator;
mod contact;
mod grasp;
mod joint;
mod limit;
mod mirror;
mod moving_base;
mod names;
pub(crate) mod outline;
mod powertrain;
mod show;
pub(crate) mod start;
pub(crate) mod tendon;

use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

use crate::limits::{MAX_BODIES, MAX_JOINTS, MAX_OUTLINES, MAX_TENDONS};
use crate::mechanism::{AssemblyError, Body, Condition, Mechanism, Mirror, Outline, PlaneArea, Start, assemble};
use crate::scene::quantity::{Angle, AngularRate, Density, Inertia, Length, Mass, Positive, Quantity, Speed};
use crate::scene::section_input::{SectionInput, Subsection};
use crate::statics::GraspKeys;
use actuator::{ActuatorSettings, actuator, limit_target_rates, pulls};
use contact::{ContactEntry, NamedLawSettings, contacts, named_law};
use grasp::grasp;
pub use grasp::{GraspSettings, grasp_settings};
use joint::{
    CouplingSettings, JointSettings, LinkageSpringSettings, RotorSettings, coupling, joint, joint_bodies, joint_kind,
    rotor, spring,
};
use limit::{SumLimitSettings, sum_limit};
use mirror::{Entries, MirrorSettings, check_images, mirror};
use moving_base::move_base;
use names::{Known, check_name};
use outline::{OutlineSettings, outline, si};
use powertrain::{PointSettings, check_feedback, feedback, points};
pub use show::mechanism_settings;
use start::check_start;
use tendon::TendonSettings;

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
    pub mirror: MirrorSettings,
    /// Joints, one section per name. Joints may form loops; the joint that closes a loop is not marked.
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
    /// Actuators of joints and tendons, one section per name. An actuator has a torque (force) over time, or follows a
    /// target.
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub actuators: BTreeMap<String, ActuatorSettings>,
    /// Rotors, one section per name: inertia of a combination of joint coordinates, as at the input of a differential.
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub rotors: BTreeMap<String, RotorSettings>,
    /// Limits of sums of joint coordinates, one section per name: the play of a gear.
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub limits: BTreeMap<String, SumLimitSettings>,
    /// Laws of contacts and joint limits, one section per name.
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub laws: BTreeMap<String, NamedLawSettings>,
    /// Pairs of outlines that may touch, each with the header [[contacts]].
    pub contacts: Vec<ContactEntry>,
}

/// A rigid body with its own frame.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct LinkSettings {
    /// Mass. Required unless `density` is given.
    #[schemars(extend("x-alternative" = "density",
        "x-required" = "add the mass: mass = \"9 g\"; or density and depth of the outlines"))]
    pub mass: Option<Positive<Mass>>,
    /// Moment of inertia about the centre of mass. Required unless `density` is given.
    #[schemars(extend("x-alternative" = "density",
        "x-required" = "add the moment of inertia about the centre of mass: inertia = \"200 g*mm^2\"; or, in place of mass and inertia, \
            density and depth of the outlines"))]
    pub inertia: Option<Positive<Inertia>>,
    /// Centre of mass in the frame of the body.
    #[schemars(extend("default" = ["0 mm", "0 mm"]))]
    pub com: [Quantity<Length>; 2],
    /// Density of the outlines of the body, in place of mass, inertia and centre of mass. The outlines must not overlap.
    pub density: Option<Positive<Density>>,
    /// Depth of the outlines. Required with `density`.
    pub depth: Option<Positive<Length>>,
    #[schemars(with = "GuessSettings")]
    pub guess: Subsection,
    #[schemars(with = "StartSettings")]
    pub start: Subsection,
    /// Outlines in the frame of the body, one section per name: [bodies.link.outlines.face].
    #[schemars(
        with = "BTreeMap<String, OutlineSettings>",
        extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" })
    )]
    pub outlines: Subsection,
    /// Named points in the frame of the body, one section per name: [bodies.jaw.points.tip].
    #[schemars(
        with = "BTreeMap<String, PointSettings>",
        extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" })
    )]
    pub points: Subsection,
}

/// Rough pose of a body with joints, which selects how the loops are assembled. A body that moves by [moves],
/// [vibrations] or [path] starts exactly at this pose.
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

/// The fixed body. Its frame is the world.
#[derive(JsonSchema)]
pub struct GroundSettings {
    /// Outlines in the frame of the world, one section per name: [ground.outlines.floor].
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub outlines: BTreeMap<String, OutlineSettings>,
    /// Named points in the frame of the world, one section per name: [ground.points.pivot].
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub points: BTreeMap<String, PointSettings>,
}

/// Resolves and assembles a mechanism, with its grasp settings; `None` if any part is invalid.
pub fn mechanism(root: &SectionInput<'_>, gravity_m_s2: [f64; 2]) -> Option<(Mechanism, Option<GraspKeys>)> {
    let mirror_section = root.subsection("mirror");
    let mirror = mirror(&mirror_section);
    let [bodies, joints, springs, tendons, couplings, actuators, rotors, limits] =
        ["bodies", "joints", "springs", "tendons", "couplings", "actuators", "rotors", "limits"]
            .map(|key| Entries::new(root, key, mirror.as_ref()));
    if let Some(mirror) = &mirror {
        let lists = [&bodies, &joints, &springs, &tendons, &couplings, &actuators, &rotors, &limits];
        check_images(&mirror_section, mirror, &lists);
    }
    let count = bodies.names().len();
    if count == 0 {
        let help = "add at least one body: [bodies.link] with mass, inertia and guess";
        root.checker.report_missing_at("[bodies.NAME]", root.subsection("bodies").span, help);
        return None;
    }
    let counts = [
        ("bodies", &bodies, MAX_BODIES),
        ("joints", &joints, MAX_JOINTS),
        ("springs", &springs, MAX_JOINTS),
        ("couplings", &couplings, MAX_JOINTS),
        ("actuators", &actuators, MAX_JOINTS),
        ("rotors", &rotors, MAX_JOINTS),
        ("limits", &limits, MAX_JOINTS),
        ("tendons", &tendons, MAX_TENDONS),
    ];
    for (key, entries, most) in counts {
        check_count(root, key, entries.names().len(), most)?;
    }
    let of_bodies = bodies.names().len();
    let outline_counts = (0..of_bodies).map(|body| bodies.section(body).subsection("outlines").subsections().len());
    let of_ground = root.subsection("ground").subsection("outlines").subsections().len();
    let outline_count = outline_counts.sum::<usize>() + of_ground;
    if outline_count > MAX_OUTLINES {
        let message = format!("the bodies have {outline_count} outlines, but at most {MAX_OUTLINES} are allowed");
        let help = format!("remove {}", outline_count - MAX_OUTLINES);
        return root.subsection("bodies").refuse("", message, "", help);
    }
    let ground_outlines = outlines(&root.subsection("ground").subsection("outlines"));
    let ground_points = points(&root.subsection("ground").subsection("points"));
    let laws = root.subsection("laws").subsections();
    laws.iter().for_each(|(name, section)| check_name(section, "laws", name));
    let known = Known {
        bodies: bodies.names(),
        joints: joints.names(),
        kinds: (0..joints.names().len()).map(|index| joint_kind(joints.section(index))).collect(),
        laws: laws.iter().map(|(name, section)| (*name, named_law(section))).collect(),
    };
    let (body_partners, joint_partners) = (bodies.partners(), joints.partners());
    let images = Mirror { body: &body_partners, joint: &joint_partners };
    let joint_bodies = joints.resolve(|_, _, section| joint_bodies(section, &known.bodies));
    let is_jointed = |body: usize| joint_bodies.iter().flatten().flatten().any(|other| *other == Some(body));
    // A joint that names no body may concern any of them.
    let all_known = joints.written().all(|(index, ..)| joint_bodies[index].is_some());
    let mut all_bodies = bodies.resolve(|k, name, section| {
        body(name, section, all_known.then(|| is_jointed(k) || is_jointed(images.body[k])))
    });
    bodies.add_images(&mut all_bodies, |body, name| images.body(body, name));
    let mut all_joints = joints.resolve(|k, name, section| joint(name, section, joint_bodies[k], &all_bodies, &known));
    joints.add_images(&mut all_joints, |joint, name| images.joint(joint, name));
    let mut all_springs = springs.resolve(|_, name, section| spring(name, section, &known));
    springs.add_images(&mut all_springs, |spring, name| images.spring(spring, name));
    let mut all_couplings = couplings.resolve(|_, name, section| coupling(name, section, &known));
    couplings.add_images(&mut all_couplings, |coupling, name| images.coupling(coupling, name));
    let mut all_rotors = rotors.resolve(|_, name, section| rotor(name, section, &known));
    rotors.add_images(&mut all_rotors, |rotor, name| images.rotor(rotor, name));
    let mut all_limits = limits.resolve(|_, name, section| sum_limit(name, section, &known));
    limits.add_images(&mut all_limits, |limit, name| images.sum_limit(limit, name));
    let mut all_tendons = tendons.resolve(|_, name, section| tendon::tendon(name, section, &known));
    tendons.add_images(&mut all_tendons, |tendon, name| images.tendon(tendon, name));
    pulls(&actuators, &tendons, &mut all_tendons);
    let mut motors =
        actuators.resolve(
            |_, name, section| {
                if section.has("tendon") { Some(None) } else { actuator(name, section, &known).map(Some) }
            },
        );
    actuators.add_images(&mut motors, |motor, name| motor.as_ref().map(|motor| images.actuator(motor, name)));
    let mut mechanism = Mechanism {
        gravity_m_s2,
        // Contacts refer to all outlines.
        bodies: all_bodies.into_iter().collect::<Option<_>>()?,
        ground_outlines: ground_outlines?,
        ground_points: ground_points?,
        joints: all_joints.into_iter().collect::<Option<_>>()?,
        couplings: all_couplings.into_iter().collect::<Option<_>>()?,
        springs: all_springs.into_iter().collect::<Option<_>>()?,
        tendons: all_tendons.into_iter().collect::<Option<_>>()?,
        actuators: motors.into_iter().collect::<Option<Vec<_>>>()?.into_iter().flatten().collect(),
        rotors: all_rotors.into_iter().collect::<Option<_>>()?,
        sum_limits: all_limits.into_iter().collect::<Option<_>>()?,
        contacts: Vec::new(),
    };
    feedback(&mut mechanism, &actuators, &body_partners)?;
    let pairs = contacts(root, &mechanism, &images, &known)?;
    mechanism.contacts = pairs.iter().map(|(pair, _)| pair.clone()).collect();
    let mut keys = grasp(&root.subsection("grasp"), &mechanism)?;
    move_base(root, &mut mechanism, &mut keys)?;
    // A start that does not fit is reported only if everything else is valid.
    if root.checker.is_clean() {
        match assemble_images(&mut mechanism, &joints) {
            Ok(start) => {
                tendon::tension(&mut mechanism, &tendons, &start.poses);
                limit_target_rates(&mut mechanism, &start.poses);
                check_start(&mechanism, &start.poses, &pairs, [&joints, &limits]);
                check_feedback(&mechanism, &start.poses, &actuators);
            }
            Err(error) => {
                let (section, key) = match error.condition() {
                    Condition::Joint(joint) => (joints.section(joint), ""),
                    Condition::Coupling(coupling) => (couplings.section(coupling), ""),
                    Condition::Start(joint) => (joints.section(joint), "start"),
                };
                let message = error.to_string();
                let (message, help) = message.split_once(": ").unwrap_or((&message, ""));
                section.report(key, message, "cannot be assembled", help);
            }
        }
    }
    Some((mechanism, keys))
}

/// Checks the number of sections of a kind.
fn check_count(root: &SectionInput<'_>, key: &str, count: usize, most: usize) -> Option<()> {
    if count <= most {
        return Some(());
    }
    let message = format!("there are {count} {key}, but at most {most} are allowed");
    root.subsection(key).refuse("", message, "", format!("remove {}", count - most))
}

/// Assembles a mechanism. The start of an image is removed if it follows from that of the original by a coupling.
fn assemble_images(mechanism: &mut Mechanism, joints: &Entries<'_>) -> Result<Start, AssemblyError> {
    let partners = joints.partners();
    loop {
        let result = assemble(mechanism);
        let redundant = match &result {
            Ok(start) => start.implied.as_slice(),
            Err(
                AssemblyError::RedundantStart { condition: Condition::Start(joint), .. }
                | AssemblyError::RedundantRate { condition: Condition::Start(joint), .. },
            ) => std::slice::from_ref(joint),
            Err(_) => &[],
        };
        let mut candidates = redundant.iter().flat_map(|joint| [*joint, partners[*joint]]);
        let Some(image) = candidates.find(|joint| joints.is_image(*joint)) else { return result };
        let image = &mut mechanism.joints[image];
        if image.start.take().is_none() {
            return result;
        }
        image.start_rate = 0.0;
    }
}

/// Resolves a body; `is_jointed` is `None` if it is unknown.
fn body(name: &str, section: &SectionInput<'_>, is_jointed: Option<bool>) -> Option<Body> {
    let keys: LinkSettings = section.read();
    let (guess, start) = (section.subsection("guess"), section.subsection("start"));
    let outlines = outlines(&section.subsection("outlines"));
    let points = points(&section.subsection("points"));
    match is_jointed {
        Some(true) if start.is_present() => {
            let message = format!("`{}` is for bodies without joints, but `{name}` has joints", start.path(""));
            let help =
                "give its rough pose in `guess`, and the start of its joints: start = \"0 deg\" in [joints.NAME]";
            start.report("", message, "for bodies without joints", help);
        }
        Some(false) if guess.is_present() => {
            let message = format!("`{}` is for bodies with joints, but `{name}` has none", guess.path(""));
            let help = "rename it to `start`, which may also have a velocity and a spin";
            guess.report("", message, "for bodies with joints", help);
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
    Some(Body { com_m, pose, rate, outlines, points: points?, ..Body::new(name, mass_kg, inertia_kg_m2) })
}

/// Mass, moment of inertia and centre of mass of a body.
fn inertia(section: &SectionInput<'_>, keys: &LinkSettings, outlines: &[Outline]) -> Option<(f64, f64, [f64; 2])> {
    let Some(density) = keys.density else {
        section.report_unused(["depth"], "without `density`");
        return Some((*keys.mass?, *keys.inertia?, si(keys.com)));
    };
    section.report_unused(["mass", "inertia", "com"], "with `density`");
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

fn outlines(section: &SectionInput<'_>) -> Option<Vec<Outline>> {
    let sections = section.subsections();
    sections.iter().for_each(|(name, each)| check_name(each, &section.path(""), name));
    let named = |(name, section): &(&str, SectionInput<'_>)| {
        Some(Outline { name: (*name).to_owned(), shape: outline(section)? })
    };
    let all: Vec<_> = sections.iter().map(named).collect();
    all.into_iter().collect()
}

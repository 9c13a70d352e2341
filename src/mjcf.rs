//! Models for MuJoCo (MJCF), to run a scene beside it.
//!
//! The plane of the mechanism is the x–y plane of MuJoCo. A spanning tree of the joints becomes the tree of bodies; each
//! other joint closes a loop and becomes a `connect` constraint. Joints that slide, or that have a limit, a spring or an
//! actuator come first into the tree, because a constraint has none of these. Joint positions in MuJoCo are the
//! coordinates of phalanx. Contacts, limits and friction are MuJoCo's own: its soft constraints do not have the laws of
//! the scene.

use std::collections::HashSet;
use std::fmt::Write as _;

use crate::drive::Profile;
use crate::files::MODEL_MARK;
use crate::mechanism::{
    Actuator, AssemblyError, Body, Command, Joint, JointCombination, JointKind, Mechanism, Outline, OutlineId,
    OutlineShape, Pose, Powertrain, Spring, SpringKind, Start, assemble,
};
use crate::numeric::elementary::{atan2, hypot, sin_cos};
use crate::numeric::plane::{Vector, add, rotate, scale, sub};
use phalanx_show::format::escape_markup;

/// A MuJoCo model, and a list of what it omits.
#[derive(Clone, Debug, PartialEq)]
pub struct MujocoModel {
    /// The model in MJCF. Its key frame `start` is the start of the scene.
    pub xml: String,
    /// Properties of the mechanism that the model does not have, one sentence each.
    pub omissions: Vec<String>,
}

/// Reason why a mechanism cannot be written as a model for MuJoCo.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MjcfError {
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    #[error(
        "the prismatic joint {0} closes a loop of prismatic joints, which MuJoCo has no constraint for: replace one of them \
         by a revolute joint"
    )]
    PrismaticLoop(String),
    #[error("the body {0} has joints but does not rotate, which MuJoCo does not know: give it a moment of inertia")]
    DoesNotRotate(String),
    #[error(
        "the body {0} is too light for MuJoCo, in which mass and moment of inertia are at least {MIN_INERTIA:e} kg and kg·m²: \
         give it more"
    )]
    TooLight(String),
}

/// Least mass, kg, and moment of inertia, kg·m², of a moving body in MuJoCo (mjMINVAL).
const MIN_INERTIA: f64 = 1e-15;

/// Half of the thickness of all geoms out of the plane, m.
const HALF_THICKNESS_M: f64 = 0.01;

/// Half of the edges of the box that stands for a half plane of a moving body, m: MuJoCo has planes of fixed bodies only.
const PLANE_BOX_M: f64 = 1.0;

/// Returns the MuJoCo model of a mechanism. Commands that vary over time are written up to `duration_s`.
///
/// # Errors
/// Returns an error if the mechanism cannot be assembled, or contains something that has no counterpart in MuJoCo.
pub fn mujoco_model(name: &str, mechanism: &Mechanism, duration_s: f64) -> Result<MujocoModel, MjcfError> {
    for (index, body) in mechanism.bodies.iter().enumerate().filter(|(_, body)| body.motion.is_none()) {
        if !body.rotates() && mechanism.has_joint(Some(index)) {
            return Err(MjcfError::DoesNotRotate(body.name.clone()));
        }
        if body.mass_kg.min(body.inertia_kg_m2) < MIN_INERTIA {
            return Err(MjcfError::TooLight(body.name.clone()));
        }
    }
    let start = assemble(mechanism)?;
    let (tree, loops) = spanning_tree(mechanism);
    if let Some(joint) = loops.iter().map(|joint| &mechanism.joints[*joint]).find(|joint| is_prismatic(joint)) {
        return Err(MjcfError::PrismaticLoop(joint.name.clone()));
    }
    let mut writer = Writer {
        mechanism,
        names: &Names::new(mechanism),
        start: &start,
        tree: &tree,
        duration_s,
        positions: Vec::new(),
        rates: Vec::new(),
        xml: String::new(),
        depth: 0,
    };
    writer.xml.push_str(MODEL_MARK);
    writer.nest(&format!("mujoco model=\"{}\"", escape_markup(name)), |writer| {
        writer.element("compiler angle=\"radian\" autolimits=\"true\"");
        let [x, y] = mechanism.gravity_m_s2;
        writer.element(&format!(
            "option timestep=\"1e-4\" gravity=\"{x:?} {y:?} 0\" integrator=\"implicitfast\" cone=\"elliptic\" \
             iterations=\"100\" tolerance=\"1e-12\""
        ));
        writer.nest("default", |writer| {
            writer.element("geom contype=\"0\" conaffinity=\"0\"");
            // By default, constraints yield for 20 ms, in which a light linkage falls apart. These need two steps.
            writer.element("joint solreflimit=\"2e-4 1\"");
            writer.element("pair solref=\"2e-4 1\"");
            writer.element("equality solref=\"2e-4 1\" solimp=\"0.99 0.9999 1e-5\"");
        });
        writer.meshes();
        writer.bodies();
        writer.contacts();
        writer.constraints(&loops);
        writer.tendons();
        let controls = join(&writer.actuators());
        writer.commands();
        let values = [("qpos", join(&writer.positions)), ("qvel", join(&writer.rates)), ("ctrl", controls)];
        let given = values.iter().filter(|(_, list)| !list.is_empty());
        let values: String = given.map(|(key, list)| format!(" {key}=\"{list}\"")).collect();
        writer.nest("keyframe", |writer| writer.element(&format!("key name=\"start\"{values}")));
    });
    Ok(MujocoModel { xml: writer.xml, omissions: omissions(mechanism, &tree, &loops) })
}

/// Names in the model, escaped. MuJoCo has a namespace for each kind of element, in which names must be unique: fixed and
/// spatial tendons share one, as do the constraints of loops and couplings.
struct Names {
    bodies: Vec<String>,
    /// Outlines by body, those of the ground last.
    geoms: Vec<Vec<String>>,
    joints: Vec<String>,
    /// Coordinates x, y and angle of free bodies.
    coordinates: Vec<[String; 3]>,
    /// Tendons.
    couplings: Vec<String>,
    combinations: Vec<String>,
    springs: Vec<String>,
    limits: Vec<String>,
    /// Both ends of a linear spring.
    sites: Vec<[String; 2]>,
    actuators: Vec<String>,
    preloads: Vec<String>,
    /// Constraints.
    loops: Vec<String>,
    ties: Vec<String>,
}

impl Names {
    fn new(mechanism: &Mechanism) -> Self {
        let Mechanism { bodies, joints, couplings, springs, actuators, sum_limits, .. } = mechanism;
        // `world` is the name of MuJoCo's ground, `ground` that of the scene's.
        let mut taken = HashSet::from(["world".to_owned(), "ground".to_owned()]);
        let body_names: Vec<String> = bodies.iter().map(|body| unique(&mut taken, &body.name, "body")).collect();
        let grounds = (&"ground".to_owned(), &mechanism.ground_outlines);
        let mut taken = HashSet::new();
        let of_bodies = body_names.iter().zip(bodies.iter().map(|body| &body.outlines));
        let geoms = of_bodies.chain([grounds]).map(|(body, outlines)| {
            outlines.iter().map(|outline| unique(&mut taken, &format!("{body}.{}", outline.name), "geom")).collect()
        });
        let geoms = geoms.collect();
        let mut taken = HashSet::new();
        let joint_names = joints.iter().map(|joint| unique(&mut taken, &joint.name, "joint")).collect();
        let coordinates = body_names
            .iter()
            .map(|body| ["x", "y", "angle"].map(|axis| unique(&mut taken, &format!("{body}.{axis}"), "coordinate")));
        let coordinates = coordinates.collect();
        let mut taken = HashSet::new();
        let tendons = [
            couplings.iter().map(|coupling| unique(&mut taken, &coupling.name, "coupling")).collect(),
            actuators.iter().map(|actuator| unique(&mut taken, &actuator.name, "actuator")).collect(),
            springs.iter().map(|spring| unique(&mut taken, &spring.name, "spring")).collect::<Vec<_>>(),
            sum_limits.iter().map(|limit| unique(&mut taken, &limit.name, "limit")).collect(),
        ];
        let mut taken = HashSet::new();
        let ends =
            |spring: &Spring| ["from", "to"].map(|end| unique(&mut taken, &format!("{}.{end}", spring.name), "end"));
        let sites = springs.iter().map(ends).collect();
        let mut taken = HashSet::new();
        let actuator_names = actuators.iter().map(|actuator| unique(&mut taken, &actuator.name, "actuator")).collect();
        let preloads = springs.iter().map(|spring| unique(&mut taken, &spring.name, "spring")).collect();
        let mut taken = HashSet::new();
        let loops = joints.iter().map(|joint| unique(&mut taken, &joint.name, "joint")).collect();
        let ties = couplings.iter().map(|coupling| unique(&mut taken, &coupling.name, "coupling")).collect();
        let [couplings, combinations, springs, limits] = tendons;
        Self {
            bodies: body_names,
            geoms,
            joints: joint_names,
            coordinates,
            couplings,
            combinations,
            springs,
            limits,
            sites,
            actuators: actuator_names,
            preloads,
            loops,
            ties,
        }
    }

    fn geom(&self, id: OutlineId) -> &str {
        &self.geoms[id.body.unwrap_or(self.bodies.len())][id.outline]
    }
}

/// Escapes a name, and gives it its kind or a number if it is taken.
fn unique(taken: &mut HashSet<String>, name: &str, kind: &str) -> String {
    // An empty name is none.
    let name = escape_markup(if name.is_empty() { kind } else { name });
    let numbered = (2..).map(|number| format!("{name}.{kind}{number}"));
    let mut candidates = [name.clone(), format!("{name}.{kind}")].into_iter().chain(numbered);
    candidates.find(|candidate| taken.insert(candidate.clone())).expect("numbers do not end")
}

fn is_prismatic(joint: &Joint) -> bool {
    !joint.kind.is_angle()
}

/// Whether a joint has something that MuJoCo knows only of joints in the tree of bodies.
fn has_load(mechanism: &Mechanism, index: usize) -> bool {
    let joint = &mechanism.joints[index];
    let combinations = mechanism.springs.iter().filter_map(Spring::on);
    let combinations = combinations.chain(mechanism.actuators.iter().map(|actuator| &actuator.on));
    let combinations = combinations.chain(mechanism.sum_limits.iter().map(|limit| &limit.on));
    let mut all = combinations.chain(mechanism.couplings.iter().map(|coupling| &coupling.on));
    joint.damping > 0.0
        || joint.armature > 0.0
        || joint.friction.is_some()
        || joint.limit.is_some()
        || all.any(|on| on.factor(index) != 0.0)
}

/// Splits the joints into a spanning tree of the bodies and the joints that close loops.
fn spanning_tree(mechanism: &Mechanism) -> (Vec<usize>, Vec<usize>) {
    let ground = mechanism.bodies.len();
    // Bodies with prescribed motion have no joints in MuJoCo.
    let component = |index: usize| if mechanism.is_base(Some(index)) { ground } else { index };
    let mut component: Vec<usize> = (0..ground).map(component).chain([ground]).collect();
    let mut order: Vec<usize> = (0..mechanism.joints.len()).collect();
    order.sort_by_key(|index| match &mechanism.joints[*index] {
        joint if is_prismatic(joint) => 0,
        _ if has_load(mechanism, *index) => 1,
        _ => 2,
    });
    order.into_iter().partition(|index| {
        let [a, b] = mechanism.joints[*index].bodies.map(|body| component[body.unwrap_or(ground)]);
        component.iter_mut().filter(|other| **other == b).for_each(|other| *other = a);
        a != b
    })
}

/// Sentences on what a model lacks or approximates.
fn omissions(mechanism: &Mechanism, tree: &[usize], loops: &[usize]) -> Vec<String> {
    let mut all = Vec::new();
    if !mechanism.contacts.is_empty() || !mechanism.limits().is_empty() {
        all.push(
            "contacts, limits and friction are MuJoCo's own soft constraints, without the laws of the scene".to_owned(),
        );
    }
    if !loops.is_empty() || !mechanism.couplings.is_empty() {
        all.push("joints that close loops, and couplings, are soft constraints".to_owned());
    }
    all.extend(omissions_of_joints(mechanism, loops));
    let lost_joint = |on: &JointCombination| {
        let lost = on.terms.iter().find(|(joint, _)| !tree.contains(joint));
        lost.map(|(joint, _)| mechanism.joints[*joint].name.as_str())
    };
    let springs = mechanism.springs.iter().filter_map(|spring| Some(("spring", &spring.name, spring.on()?)));
    let couplings = mechanism.couplings.iter().map(|coupling| ("coupling", &coupling.name, &coupling.on));
    let actuators = mechanism.actuators.iter().map(|actuator| ("actuator", &actuator.name, &actuator.on));
    let limits = mechanism.sum_limits.iter().map(|limit| ("limit", &limit.name, &limit.on));
    for (what, name, on) in springs.chain(couplings).chain(actuators).chain(limits) {
        if let Some(joint) = lost_joint(on) {
            all.push(format!("the {what} {name} is missing, because the joint {joint} closes a loop"));
        }
    }
    all.extend(mechanism.rotors.iter().map(|rotor| format!("the rotor {} is missing", rotor.name)));
    for tendon in &mechanism.tendons {
        let pull = tendon.actuator.as_ref().map(|actuator| format!(" with its actuator {}", actuator.name));
        all.push(format!("the tendon {}{} is missing", tendon.name, pull.unwrap_or_default()));
    }
    for body in mechanism.bodies.iter().filter(|body| body.motion.is_some()) {
        let name = &body.name;
        all.push(format!("the body {name} stays at its start, as a mocap body: its prescribed motion is missing"));
    }
    for actuator in mechanism.actuators.iter().filter(|actuator| lost_joint(&actuator.on).is_none()) {
        all.extend(omissions_of_actuator(actuator));
        all.extend(omissions_of_powertrain(actuator));
    }
    for contact in mechanism.contacts.iter().filter(|contact| contact.rolling.is_some()) {
        let [points, face] = [contact.points, contact.face].map(|id| mechanism.outline_name(id));
        all.push(format!("the rolling resistance of {points} and {face} is missing"));
    }
    let is_rounded =
        |outline: &Outline| matches!(outline.shape, OutlineShape::Polygon { radius_m, .. } if radius_m > 0.0);
    let of_bodies = mechanism.bodies.iter().flat_map(|body| &body.outlines);
    if of_bodies.chain(&mechanism.ground_outlines).any(is_rounded) {
        all.push(format!("each rounded corner of a polygon has {ARC_POINTS} points"));
    }
    for body in &mechanism.bodies {
        for outline in body.outlines.iter().filter(|outline| matches!(outline.shape, OutlineShape::HalfPlane { .. })) {
            let (name, edge) = (&outline.name, 2.0 * PLANE_BOX_M);
            all.push(format!(
                "the half plane {}.{name} is a box with edges of {edge} m, because its body moves",
                body.name
            ));
        }
    }
    all
}

/// Sentences on joints: those that close loops, and friction.
fn omissions_of_joints(mechanism: &Mechanism, loops: &[usize]) -> Vec<String> {
    let mut all = Vec::new();
    for (index, joint) in mechanism.joints.iter().enumerate() {
        let name = &joint.name;
        if loops.contains(&index) {
            let losses = [
                ("damping", joint.damping > 0.0),
                ("armature", joint.armature > 0.0),
                ("friction", joint.friction.is_some()),
                ("limits", joint.limit.is_some()),
            ];
            let lost: Vec<&str> = losses.into_iter().filter(|(_, is_lost)| *is_lost).map(|(loss, _)| loss).collect();
            if !lost.is_empty() {
                all.push(format!("the joint {name} closes a loop: missing is its {}", lost.join(", ")));
            }
        } else if let Some(friction) = joint.friction {
            let unit = if is_prismatic(joint) { "N" } else { "N·m" };
            let mut lost = Vec::new();
            if friction.mu_dynamic < friction.mu_static {
                lost.push(format!("its smaller value in motion ({} {unit})", friction.mu_dynamic));
            }
            lost.push("the rates over which it changes".to_owned());
            if friction.has_state() {
                lost.push("its bristle".to_owned());
            }
            let (lost, value) = (lost.join(", "), friction.mu_static);
            all.push(format!("the friction of the joint {name} is a constant {value} {unit}, without {lost}"));
        }
    }
    all
}

/// Sentences on an actuator of the model.
fn omissions_of_actuator(actuator: &Actuator) -> Vec<String> {
    let mut all = Vec::new();
    let name = &actuator.name;
    let changes = command_times(actuator, f64::INFINITY).len() > 1;
    if actuator.brake.is_some() {
        all.push(format!("the brake of the actuator {name} is missing"));
    }
    if changes {
        all.push(format!(
            "the command of the actuator {name} changes over time: a program must set it from the numbers {name}.times and \
             {name}.commands"
        ));
    }
    let has_controller = actuator.powertrain.feedback.is_none();
    if let (true, Command::Servo { rate_hz: Some(rate_hz), .. }) = (has_controller, &actuator.command) {
        all.push(format!("the controller of the actuator {name} is continuous: its rate of {rate_hz} Hz is missing"));
    }
    match actuator.command {
        _ if actuator.no_load_speed.is_none() => {}
        Command::Servo { .. } => all.push(format!("the no-load speed of the actuator {name} is missing")),
        Command::Effort(_) if changes => {
            all.push(format!("the torque of the actuator {name} falls with the speed as its largest torque does"));
        }
        Command::Effort(_) => {}
    }
    all
}

/// Sentences on the gear, the motor and the feedback of an actuator of the model.
fn omissions_of_powertrain(actuator: &Actuator) -> Vec<String> {
    let (name, Powertrain { rotor_kg_m2, loss, motor, feedback, .. }) = (&actuator.name, &actuator.powertrain);
    let mut all = Vec::new();
    if *rotor_kg_m2 > 0.0 && actuator.on.joint().is_none() {
        all.push(format!("the rotor of the actuator {name} is missing, because it turns with several joints"));
    }
    if loss.is_some() {
        all.push(format!("the loss of the gear of the actuator {name} is missing: its efficiency is 1"));
    }
    if motor.is_some_and(|motor| motor.inductance.is_some()) {
        all.push(format!("the inductance of the actuator {name} is missing: its current follows the voltage at once"));
    }
    if motor.is_some() && actuator.limit.is_some() {
        all.push(format!("the voltage limit of the actuator {name} is a limit of its torque, as at rest"));
    }
    if feedback.is_some() {
        all.push(format!(
            "the controller of the actuator {name}, which measures a distance, is missing: its control is a torque"
        ));
    }
    all
}

/// Number of times at which a smooth command is given.
const COMMAND_SAMPLES: usize = 200;

/// Times between which the command of an actuator is linear, up to `end_s`; only the start for a constant command.
fn command_times(actuator: &Actuator, end_s: f64) -> Vec<f64> {
    let mut times = vec![0.0];
    match actuator.command.profile() {
        Profile::Constant { .. } => {}
        Profile::Table { points, .. } => {
            // A step lies between two neighbouring times.
            let both = points.iter().flat_map(|(t, _)| [t.next_down(), *t]);
            times.extend(both.filter(|t| *t > 0.0 && *t < end_s));
            times.push(end_s);
        }
        _ => times.extend((1..=COMMAND_SAMPLES).map(|k| end_s * k as f64 / COMMAND_SAMPLES as f64)),
    }
    times
}

/// Control signal of the actuator in MuJoCo at a time: an effort, which MuJoCo limits, or the position that includes the rate
/// of the target.
fn control(actuator: &Actuator, t: f64) -> f64 {
    let (value, rate) = actuator.command.profile().at(t);
    match actuator.command {
        Command::Effort(_) => value,
        // The control is a torque, see [`omissions_of_powertrain`].
        Command::Servo { .. } if actuator.powertrain.feedback.is_some() => 0.0,
        Command::Servo { kp: 0.0, .. } => rate,
        Command::Servo { kp, kd, .. } => value + kd / kp * rate,
    }
}

fn join(numbers: &[f64]) -> String {
    numbers.iter().map(|number| format!("{number:?}")).collect::<Vec<_>>().join(" ")
}

/// Attributes whose values are names.
const NAMES: [&str; 17] = [
    "name", "model", "class", "mesh", "joint", "joint1", "joint2", "body1", "body2", "geom1", "geom2", "site", "site1",
    "site2", "tendon", "tendon1", "tendon2",
];

/// The text of an element, whose numbers are written as by `{:?}`, with `2` in place of `2.0`. (`{}` would write 1e-200 with 200
/// zeros.)
fn with_short_numbers(text: &str) -> String {
    let short = |word: &str| match word.strip_suffix(".0") {
        Some(whole) if word.parse::<f64>().is_ok() => whole.to_string(),
        _ => word.to_string(),
    };
    let mut key = "";
    let mut parts = Vec::new();
    for (index, part) in text.split('"').enumerate() {
        let is_value = index % 2 == 1;
        if !is_value {
            key = part.trim_start().trim_end_matches('=').rsplit(' ').next().unwrap_or_default();
        }
        parts.push(match is_value && !NAMES.contains(&key) {
            true => part.split(' ').map(short).collect::<Vec<_>>().join(" "),
            false => part.to_string(),
        });
    }
    parts.join("\"")
}

struct Writer<'a> {
    mechanism: &'a Mechanism,
    names: &'a Names,
    start: &'a Start,
    /// Joints of the tree of bodies.
    tree: &'a [usize],
    duration_s: f64,
    /// Joint positions and rates at the start, in the order of the model.
    positions: Vec<f64>,
    rates: Vec<f64>,
    xml: String,
    depth: usize,
}

impl Writer<'_> {
    fn line(&mut self, text: &str) {
        let _ = writeln!(self.xml, "{:1$}{text}", "", 2 * self.depth);
    }

    fn element(&mut self, text: &str) {
        self.line(&format!("<{}/>", with_short_numbers(text)));
    }

    /// Writes an element with children.
    fn nest(&mut self, text: &str, children: impl FnOnce(&mut Self)) {
        self.line(&format!("<{}>", with_short_numbers(text)));
        self.depth += 1;
        children(self);
        self.depth -= 1;
        let name = text.split(' ').next().unwrap_or_default();
        self.line(&format!("</{name}>"));
    }

    fn bodies(&mut self) {
        let mechanism = self.mechanism;
        self.nest("worldbody", |writer| {
            writer.geoms(None);
            writer.sites(None);
            let mut placed = vec![false; mechanism.bodies.len()];
            let bases = || (0..mechanism.bodies.len()).filter(|index| mechanism.is_base(Some(*index)));
            bases().for_each(|index| placed[index] = true);
            bases().for_each(|index| writer.body(index, None, &mut placed, |_| {}));
            writer.children(None, &mut placed);
            while let Some(body) = placed.iter().position(|placed| !placed) {
                writer.free_body(body, &mut placed);
            }
        });
    }

    /// Writes the bodies that joints of the tree attach to a body.
    fn children(&mut self, parent: Option<usize>, placed: &mut Vec<bool>) {
        for &index in self.tree {
            let joint = &self.mechanism.joints[index];
            let (child, is_second) = match joint.bodies {
                [a, Some(b)] if a == parent && !placed[b] => (b, true),
                [Some(a), b] if b == parent && !placed[a] => (a, false),
                _ => continue,
            };
            placed[child] = true;
            self.body(child, parent, placed, |writer| writer.joint(index, is_second));
        }
    }

    fn body(&mut self, index: usize, parent: Option<usize>, placed: &mut Vec<bool>, joints: impl FnOnce(&mut Self)) {
        let body = &self.mechanism.bodies[index];
        let base = parent.map_or([0.0; 3], |parent| self.start.poses[parent]);
        let ([x, y], angle) = relative_pose(base, self.start.poses[index]);
        let (name, mocap) = (&self.names.bodies[index], if body.motion.is_some() { " mocap=\"true\"" } else { "" });
        self.nest(&format!("body name=\"{name}\" pos=\"{x:?} {y:?} 0\" euler=\"0 0 {angle:?}\"{mocap}"), |writer| {
            joints(writer);
            if body.motion.is_none() {
                writer.inertia(body);
            }
            writer.geoms(Some(index));
            writer.sites(Some(index));
            writer.children(Some(index), placed);
        });
    }

    fn inertia(&mut self, body: &Body) {
        let ([x, y], mass) = (body.com_m, body.mass_kg);
        // The moment of inertia of a body that does not rotate has no effect.
        let inertia = if body.rotates() { body.inertia_kg_m2 } else { mass };
        self.element(&format!(
            "inertial pos=\"{x:?} {y:?} 0\" mass=\"{mass:?}\" diaginertia=\"{inertia:?} {inertia:?} {inertia:?}\""
        ));
    }

    /// Writes a body without joints to placed bodies: it moves freely in the plane.
    fn free_body(&mut self, index: usize, placed: &mut Vec<bool>) {
        placed[index] = true;
        let (names, axes) = (self.names, if self.mechanism.bodies[index].rotates() { 3 } else { 2 });
        let (pose, rate) = (self.start.poses[index], self.start.rates[index]);
        self.body(index, None, placed, |writer| {
            // Axes are in the frame of the body at the start.
            let (sin, cos) = sin_cos(pose[2]);
            let slides = [[cos, -sin], [sin, cos]].map(|[x, y]| format!("slide\" axis=\"{x:?} {y:?} 0"));
            let kinds = slides.into_iter().chain(["hinge\" axis=\"0 0 1".to_owned()]);
            for (axis, kind) in kinds.enumerate().take(axes) {
                let name = &names.coordinates[index][axis];
                writer.element(&format!("joint name=\"{name}\" type=\"{kind}\" ref=\"{:?}\"", pose[axis]));
                writer.positions.push(pose[axis]);
                writer.rates.push(rate[axis]);
            }
        });
    }

    fn joint(&mut self, index: usize, is_second: bool) {
        let joint = &self.mechanism.joints[index];
        let own = usize::from(is_second);
        let sign = if is_second { 1.0 } else { -1.0 };
        let [x, y] = joint.points_m[own];
        let (kind, axis) = match joint.kind {
            JointKind::Revolute => ("hinge", format!("0 0 {sign}")),
            JointKind::Prismatic { axis_rad } => {
                // The axis is fixed in the first body; both bodies keep their relative angle.
                let (sin, cos) = sin_cos(if is_second { axis_rad - joint.offset_rad } else { axis_rad });
                ("slide", format!("{:?} {:?} 0", sign * cos, sign * sin))
            }
        };
        let (position, rate) = self.start.joint(joint);
        self.positions.push(position);
        self.rates.push(rate);
        let springs = self.mechanism.springs.iter().filter_map(|spring| match &spring.kind {
            SpringKind::Torsional { on, preload } if on.joint() == Some(index) => Some((spring, preload)),
            _ => None,
        });
        let (mut stiffness, mut effort_at_zero, mut damping) = (0.0, 0.0, joint.damping);
        for (spring, preload) in springs {
            stiffness += spring.stiffness;
            effort_at_zero += spring.stiffness * spring.rest + preload;
            damping += spring.damping;
        }
        // The largest friction, without the range in which it sticks.
        let friction = joint.friction.map_or(0.0, |friction| friction.mu_static);
        let mut text = format!(
            "joint name=\"{}\" type=\"{kind}\" pos=\"{x:?} {y:?} 0\" axis=\"{axis}\" ref=\"{position:?}\" damping=\"{damping:?}\" \
             armature=\"{:?}\" frictionloss=\"{friction:?}\"",
            self.names.joints[index],
            joint.armature + self.rotor_inertia(index)
        );
        if stiffness > 0.0 {
            let _ = write!(text, " stiffness=\"{stiffness:?}\" springref=\"{:?}\"", effort_at_zero / stiffness);
        }
        if joint.limit.is_some() && (joint.lower.is_some() || joint.upper.is_some()) {
            let (lower, upper) = (joint.lower.unwrap_or(-UNLIMITED), joint.upper.unwrap_or(UNLIMITED));
            let _ = write!(text, " range=\"{lower:?} {upper:?}\"");
        }
        self.element(&text);
    }

    /// Inertia of the rotors of all actuators of a joint, reflected to it.
    fn rotor_inertia(&self, joint: usize) -> f64 {
        let own = self.mechanism.actuators.iter().filter(|actuator| actuator.on.joint() == Some(joint));
        own.map(|actuator| actuator.powertrain.reflected_inertia()).sum()
    }

    /// Writes the outlines of a body.
    fn geoms(&mut self, body: Option<usize>) {
        let outlines = body.map_or(&self.mechanism.ground_outlines, |body| &self.mechanism.bodies[body].outlines);
        for (index, outline) in outlines.iter().enumerate() {
            let name = self.names.geom(OutlineId { body, outline: index });
            let shape = geom(name, &outline.shape, body.is_some());
            self.element(&format!("geom name=\"{name}\" {shape}"));
        }
    }

    /// Writes the ends of linear springs on a body.
    fn sites(&mut self, body: Option<usize>) {
        for (index, spring) in self.mechanism.springs.iter().enumerate() {
            let SpringKind::Linear { bodies, points_m } = spring.kind else { continue };
            for end in (0..2).filter(|end| bodies[*end] == body) {
                let [x, y] = points_m[end];
                self.element(&format!("site name=\"{}\" pos=\"{x:?} {y:?} 0\"", self.names.sites[index][end]));
            }
        }
    }

    /// Writes polygons, with their rounding as the outer corners of a prism.
    fn meshes(&mut self) {
        let mechanism = self.mechanism;
        let ids = (0..mechanism.bodies.len()).map(Some).chain([None]);
        self.nest("asset", |writer| {
            for body in ids {
                let outlines = body.map_or(&mechanism.ground_outlines, |body| &mechanism.bodies[body].outlines);
                for (index, outline) in outlines.iter().enumerate() {
                    let OutlineShape::Polygon { vertices_m, radius_m } = &outline.shape else { continue };
                    let corners = rounded_corners(vertices_m, *radius_m);
                    let both = [-HALF_THICKNESS_M, HALF_THICKNESS_M];
                    let prism = both.into_iter().flat_map(|z| corners.iter().flat_map(move |[x, y]| [*x, *y, z]));
                    let vertices = join(&prism.collect::<Vec<_>>());
                    let name = writer.names.geom(OutlineId { body, outline: index });
                    writer.element(&format!("mesh name=\"{name}\" vertex=\"{vertices}\""));
                }
            }
        });
    }

    fn contacts(&mut self) {
        let mechanism = self.mechanism;
        let mut written: Vec<[OutlineId; 2]> = Vec::new();
        self.nest("contact", |writer| {
            for contact in &mechanism.contacts {
                let pair = [contact.points, contact.face];
                if written.iter().any(|other| *other == pair || *other == [pair[1], pair[0]]) {
                    continue;
                }
                written.push(pair);
                let [first, second] = pair.map(|id| writer.names.geom(id));
                let friction = contact.law.friction.map_or(0.0, |friction| friction.mu_static);
                let condim = if friction > 0.0 { 3 } else { 1 };
                writer.element(&format!(
                    "pair geom1=\"{first}\" geom2=\"{second}\" condim=\"{condim}\" friction=\"{friction:?} {friction:?} 0 0 0\""
                ));
            }
        });
    }

    /// Whether the model has all joints of a combination.
    fn has_joints(&self, on: &JointCombination) -> bool {
        on.terms.iter().all(|(joint, _)| self.tree.contains(joint))
    }

    /// Writes the joints that close loops, and the couplings.
    fn constraints(&mut self, loops: &[usize]) {
        let (mechanism, names) = (self.mechanism, self.names);
        self.nest("equality", |writer| {
            for index in loops {
                let joint = &mechanism.joints[*index];
                let (own, other) = if joint.bodies[0].is_some() { (0, 1) } else { (1, 0) };
                let [x, y] = joint.points_m[own];
                let body = |side: usize| joint.bodies[side].map(|body| &names.bodies[body]);
                let mut text = format!("connect name=\"{}\"", names.loops[*index]);
                for (key, side) in [("body1", own), ("body2", other)] {
                    let _ = body(side).map(|name| write!(text, " {key}=\"{name}\""));
                }
                writer.element(&format!("{text} anchor=\"{x:?} {y:?} 0\""));
            }
            for (index, coupling) in mechanism.couplings.iter().enumerate() {
                if writer.has_joints(&coupling.on) {
                    let (name, tendon) = (&names.ties[index], &names.couplings[index]);
                    writer.element(&format!("tendon name=\"{name}\" tendon1=\"{tendon}\""));
                }
            }
        });
    }

    /// Writes linear springs, and the sums of joint positions on which couplings, actuators, springs and limits act.
    fn tendons(&mut self) {
        let (mechanism, names) = (self.mechanism, self.names);
        self.nest("tendon", |writer| {
            for (name, coupling) in names.couplings.iter().zip(&mechanism.couplings) {
                writer.combination(name, &coupling.on, "");
            }
            for (name, actuator) in names.combinations.iter().zip(&mechanism.actuators) {
                if actuator.on.joint().is_none() {
                    writer.combination(name, &actuator.on, "");
                }
            }
            for (name, limit) in names.limits.iter().zip(&mechanism.sum_limits) {
                let (lower, upper) = (limit.lower.unwrap_or(-UNLIMITED), limit.upper.unwrap_or(UNLIMITED));
                writer.combination(name, &limit.on, &format!(" range=\"{lower:?} {upper:?}\""));
            }
            for (index, spring) in mechanism.springs.iter().enumerate() {
                let name = &names.springs[index];
                match &spring.kind {
                    SpringKind::Torsional { on, preload } if on.joint().is_none() => {
                        // The preload of a spring without stiffness is an actuator.
                        let shift = if spring.stiffness > 0.0 { preload / spring.stiffness } else { 0.0 };
                        writer.combination(name, on, &spring_properties(spring, spring.rest + on.offset + shift));
                    }
                    SpringKind::Torsional { .. } => {}
                    SpringKind::Linear { .. } => {
                        let properties = spring_properties(spring, spring.rest);
                        writer.nest(&format!("spatial name=\"{name}\"{properties}"), |writer| {
                            for site in &names.sites[index] {
                                writer.element(&format!("site site=\"{site}\""));
                            }
                        });
                    }
                }
            }
        });
    }

    /// Writes a sum of joint positions as a fixed tendon.
    fn combination(&mut self, name: &str, on: &JointCombination, properties: &str) {
        if !self.has_joints(on) {
            return;
        }
        self.nest(&format!("fixed name=\"{name}\"{properties}"), |writer| {
            for (joint, factor) in &on.terms {
                let name = &writer.names.joints[*joint];
                writer.element(&format!("joint joint=\"{name}\" coef=\"{factor:?}\""));
            }
        });
    }

    /// Attribute that names the joint, or the fixed tendon of this name, on which an actuator acts.
    fn transmission(&self, tendon: &str, on: &JointCombination) -> String {
        match on.joint() {
            Some(joint) => format!("joint=\"{}\"", self.names.joints[joint]),
            None => format!("tendon=\"{tendon}\""),
        }
    }

    /// Writes all actuators and the constant torques of springs; returns the control signals at the start.
    fn actuators(&mut self) -> Vec<f64> {
        let (mechanism, names) = (self.mechanism, self.names);
        let mut controls = Vec::new();
        self.nest("actuator", |writer| {
            for (index, actuator) in mechanism.actuators.iter().enumerate() {
                if !writer.has_joints(&actuator.on) {
                    continue;
                }
                let (gain, [constant, by_position, by_rate]) = gains(actuator);
                let mut text = format!(
                    "general name=\"{}\" {} gaintype=\"fixed\" gainprm=\"{gain:?}\" biastype=\"affine\" biasprm=\"{constant:?} \
                     {by_position:?} {by_rate:?}\"",
                    names.actuators[index],
                    writer.transmission(&names.combinations[index], &actuator.on),
                );
                let gear = actuator.powertrain.gear;
                if gear != 1.0 {
                    let _ = write!(text, " gear=\"{gear:?}\"");
                }
                if let Some(limit) = torque_limit(actuator) {
                    // The limit bounds an effort before it changes with the speed; that of a current bounds the torque itself.
                    let is_command =
                        matches!(actuator.command, Command::Effort(_)) && actuator.powertrain.motor.is_none();
                    let range = if is_command { "ctrlrange" } else { "forcerange" };
                    let _ = write!(text, " {range}=\"{:?} {limit:?}\"", -limit);
                }
                writer.element(&text);
                controls.push(control(actuator, 0.0));
            }
            for (index, spring) in mechanism.springs.iter().enumerate().filter(|(_, spring)| spring.stiffness == 0.0) {
                if let SpringKind::Torsional { on, preload } = &spring.kind
                    && writer.has_joints(on)
                {
                    let transmission = writer.transmission(&names.springs[index], on);
                    writer.element(&format!("motor name=\"{}\" {transmission}", names.preloads[index]));
                    controls.push(*preload);
                }
            }
        });
        controls
    }

    /// Writes the commands that change over time as pairs of lists.
    fn commands(&mut self) {
        let (mechanism, duration_s) = (self.mechanism, self.duration_s);
        self.nest("custom", |writer| {
            for (name, actuator) in writer.names.actuators.iter().zip(&mechanism.actuators) {
                let times = command_times(actuator, duration_s);
                if times.len() > 1 && writer.has_joints(&actuator.on) {
                    let controls: Vec<f64> = times.iter().map(|t| control(actuator, *t)).collect();
                    for (list, numbers) in [("times", &times), ("commands", &controls)] {
                        writer.element(&format!("numeric name=\"{name}.{list}\" data=\"{}\"", join(numbers)));
                    }
                }
            }
        });
    }
}

/// Bound of the side of a joint without a limit, rad or m.
const UNLIMITED: f64 = 1e3;

/// Limit of the torque of the motor, or of the effort of an actuator without a gear.
fn torque_limit(actuator: &Actuator) -> Option<f64> {
    actuator.effort_limit().map(|limit| limit / actuator.powertrain.gear.abs())
}

/// Gain on the control signal, and the constant and the gains on position and rate, of an actuator. Position and rate are
/// those of its motor.
fn gains(actuator: &Actuator) -> (f64, [f64; 3]) {
    let Powertrain { gear, motor, feedback, .. } = &actuator.powertrain;
    if feedback.is_some() {
        return (1.0, [0.0; 3]);
    }
    let (gain, [constant, by_position, by_rate]) = gains_of_command(actuator);
    let (per_volt, back_emf) =
        motor.map_or((1.0, 0.0), |motor| (motor.torque_constant / motor.resistance, motor.back_emf));
    // Those of a controller are on the joint.
    let by_joint = matches!(actuator.command, Command::Servo { .. });
    let ratio = if by_joint { 1.0 / gear } else { 1.0 };
    let bias = [constant, by_position * ratio, by_rate * ratio - back_emf];
    (per_volt * gain, bias.map(|part| per_volt * part))
}

/// [`gains`] of the command of an actuator on its joint.
fn gains_of_command(actuator: &Actuator) -> (f64, [f64; 3]) {
    match &actuator.command {
        // τ − |τ| q̇/ω₀, with the largest torque: MuJoCo's drop does not follow a torque over time.
        Command::Effort(profile) => {
            let largest = profile.largest().min(actuator.limit.unwrap_or(f64::INFINITY));
            (1.0, [0.0, 0.0, actuator.no_load_speed.map_or(0.0, |speed| -largest / speed)])
        }
        Command::Servo { kp: 0.0, kd, .. } => (*kd, [0.0, 0.0, -kd]),
        // MuJoCo's position is the sum without its offset.
        Command::Servo { kp, kd, .. } => (*kp, [kp * actuator.on.offset, -kp, -kd]),
    }
}

/// Attributes of a tendon with a spring of this length at rest.
fn spring_properties(spring: &Spring, rest: f64) -> String {
    // A length of −1 stands for that of the start.
    let rest = if rest == -1.0 { rest.next_down() } else { rest };
    format!(" stiffness=\"{:?}\" damping=\"{:?}\" springlength=\"{rest:?}\"", spring.stiffness, spring.damping)
}

/// Attributes of an outline.
fn geom(name: &str, shape: &OutlineShape, is_of_body: bool) -> String {
    match *shape {
        OutlineShape::Disc { center_m: [x, y], radius_m } => {
            format!("type=\"sphere\" pos=\"{x:?} {y:?} 0\" size=\"{radius_m:?}\"")
        }
        OutlineShape::Capsule { from_m: [x0, y0], to_m: [x1, y1], radius_m } => {
            format!("type=\"capsule\" fromto=\"{x0:?} {y0:?} 0 {x1:?} {y1:?} 0\" size=\"{radius_m:?}\"")
        }
        OutlineShape::Ellipse { center_m: [x, y], semi_axes_m: [a, b], angle_rad } => {
            format!(
                "type=\"ellipsoid\" pos=\"{x:?} {y:?} 0\" euler=\"0 0 {angle_rad:?}\" size=\"{a:?} {b:?} {:?}\"",
                a.min(b)
            )
        }
        OutlineShape::Polygon { .. } => format!("type=\"mesh\" mesh=\"{name}\""),
        OutlineShape::HalfPlane { point_m, normal } if is_of_body => {
            let [x, y] = sub(point_m, scale(normal, PLANE_BOX_M));
            let (angle, half) = (atan2(normal[1], normal[0]), PLANE_BOX_M);
            format!("type=\"box\" pos=\"{x:?} {y:?} 0\" euler=\"0 0 {angle:?}\" size=\"{half:?} {half:?} {half:?}\"")
        }
        OutlineShape::HalfPlane { point_m: [x, y], normal: [nx, ny] } => {
            format!("type=\"plane\" pos=\"{x:?} {y:?} 0\" zaxis=\"{nx:?} {ny:?} 0\" size=\"1 1 0.1\"")
        }
    }
}

/// Pose in the frame of another pose.
fn relative_pose(base: Pose, pose: Pose) -> (Vector<f64>, f64) {
    let (sin, cos) = sin_cos(base[2]);
    (rotate(sub([pose[0], pose[1]], [base[0], base[1]]), [cos, -sin]), pose[2] - base[2])
}

/// Number of points on the arc at each corner of a rounded polygon.
const ARC_POINTS: usize = 5;

/// Points on the outline of a polygon with this radius about its core.
fn rounded_corners(vertices_m: &[Vector<f64>], radius_m: f64) -> Vec<Vector<f64>> {
    let count = vertices_m.len();
    let normal = |k: usize| {
        let [x, y] = sub(vertices_m[(k + 1) % count], vertices_m[k % count]);
        let length = hypot(x, y);
        [y / length, -x / length]
    };
    let arc = |k: usize| {
        let (before, after) = (normal(k + count - 1), normal(k));
        (0..ARC_POINTS).map(move |step| {
            let part = step as f64 / (ARC_POINTS - 1) as f64;
            let [x, y] = add(scale(before, 1.0 - part), scale(after, part));
            add(vertices_m[k], scale([x, y], radius_m / hypot(x, y)))
        })
    };
    match radius_m > 0.0 {
        true => (0..count).flat_map(arc).collect(),
        false => vertices_m.to_vec(),
    }
}

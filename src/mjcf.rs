//! Models for MuJoCo (MJCF), to run a scene beside it.
//!
//! The plane of the mechanism is the x–y plane of MuJoCo. A spanning tree of the joints becomes the tree of bodies; each
//! other joint closes a loop and becomes a `connect` constraint. Joints that slide, or that have a limit, a spring or an
//! actuator come first into the tree, because a constraint has none of these. Joint positions in MuJoCo are the
//! coordinates of phalanx. Contacts, limits and friction are MuJoCo's own: its soft constraints do not have the laws of
//! the scene.

use std::fmt::Write as _;

use crate::drive::Profile;
use crate::files::MODEL_MARK;
use crate::mechanism::{
    Actuator, AssemblyError, Command, Joint, JointCombination, JointKind, Mechanism, Outline, OutlineId, OutlineShape,
    Pose, Spring, SpringKind, Start, assemble,
};
use crate::numeric::elementary::{hypot, sin_cos};
use crate::numeric::plane::{Vector, add, rotate, scale, sub};

/// A model, and what it does not have.
#[derive(Clone, Debug, PartialEq)]
pub struct MujocoModel {
    /// The model in MJCF. Its key frame `start` is the start of the scene.
    pub xml: String,
    /// Properties of the mechanism that the model lacks, one sentence each.
    pub omissions: Vec<String>,
}

/// Reason why a mechanism has no model in MuJoCo.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MjcfError {
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    #[error(
        "the prismatic joint {0} closes a loop of prismatic joints, which MuJoCo has no constraint for: replace one of them \
         by a revolute joint"
    )]
    PrismaticLoop(String),
}

/// Half of the thickness of all geoms out of the plane, m.
const HALF_THICKNESS_M: f64 = 0.01;

/// Returns the MuJoCo model of a mechanism; commands over time are given up to `duration_s`.
///
/// # Errors
/// Returns an error for a mechanism that cannot be assembled, or with a loop of prismatic joints only.
pub fn mujoco_model(name: &str, mechanism: &Mechanism, duration_s: f64) -> Result<MujocoModel, MjcfError> {
    let start = assemble(mechanism)?;
    let (tree, loops) = spanning_tree(mechanism);
    if let Some(joint) = loops.iter().map(|joint| &mechanism.joints[*joint]).find(|joint| is_prismatic(joint)) {
        return Err(MjcfError::PrismaticLoop(joint.name.clone()));
    }
    let mut writer = Writer {
        mechanism,
        start: &start,
        tree: &tree,
        duration_s,
        positions: Vec::new(),
        rates: Vec::new(),
        xml: String::new(),
        depth: 0,
    };
    writer.xml.push_str(MODEL_MARK);
    writer.nest(&format!("mujoco model=\"{}\"", escape(name)), |writer| {
        writer.element("compiler angle=\"radian\" autolimits=\"true\"");
        let [x, y] = mechanism.gravity_m_s2;
        writer.element(&format!(
            "option timestep=\"1e-4\" gravity=\"{x} {y} 0\" integrator=\"implicitfast\" cone=\"elliptic\" \
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
        let (positions, rates) = (join(&writer.positions), join(&writer.rates));
        writer.nest("keyframe", |writer| {
            let key = format!("key name=\"start\" qpos=\"{positions}\" qvel=\"{rates}\" ctrl=\"{controls}\"");
            writer.element(&key);
        });
    });
    Ok(MujocoModel { xml: writer.xml, omissions: omissions(mechanism, &loops) })
}

fn is_prismatic(joint: &Joint) -> bool {
    matches!(joint.kind, JointKind::Prismatic { .. })
}

/// Whether a joint has something that MuJoCo knows only of joints in the tree of bodies.
fn has_load(mechanism: &Mechanism, index: usize) -> bool {
    let joint = &mechanism.joints[index];
    let combinations = mechanism.springs.iter().filter_map(Spring::on);
    let combinations = combinations.chain(mechanism.actuators.iter().map(|actuator| &actuator.on));
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
    let mut component: Vec<usize> = (0..=ground).collect();
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

/// Sentences on what a model lacks.
fn omissions(mechanism: &Mechanism, loops: &[usize]) -> Vec<String> {
    let mut all = Vec::new();
    if !mechanism.contacts.is_empty() || !mechanism.limits().is_empty() {
        all.push(
            "contacts, limits and friction are MuJoCo's own soft constraints, without the laws of the scene".to_owned(),
        );
    }
    for joint in loops.iter().filter(|joint| has_load(mechanism, **joint)) {
        let name = &mechanism.joints[*joint].name;
        all.push(format!(
            "the joint {name} closes a loop: its damping, armature, limits, springs and actuators are missing"
        ));
    }
    let mut missing = |what: &str, name: &str| all.push(format!("the {what} {name} is missing"));
    mechanism.rotors.iter().for_each(|rotor| missing("rotor", &rotor.name));
    mechanism.tendons.iter().for_each(|tendon| missing("tendon", &tendon.name));
    for body in mechanism.bodies.iter().filter(|body| body.motion.is_some() || !body.rotates()) {
        missing("prescribed or purely translational motion of the body", &body.name);
    }
    for actuator in mechanism.actuators.iter().filter(|actuator| actuator.brake.is_some()) {
        missing("brake of the actuator", &actuator.name);
    }
    for actuator in &mechanism.actuators {
        let name = &actuator.name;
        if command_times(actuator, f64::INFINITY).len() > 1 {
            all.push(format!(
                "the command of the actuator {name} changes over time: a program must set it from the numbers {name}.times and \
                 {name}.commands"
            ));
        }
        if actuator.no_load_speed.is_some() && !matches!(actuator.command, Command::Effort(_)) {
            all.push(format!("the no-load speed of the actuator {name} is missing"));
        }
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

/// Control signal of the actuator in MuJoCo at a time: an effort, or the position that includes the rate of the target.
fn control(actuator: &Actuator, t: f64) -> f64 {
    let (value, rate) = actuator.command.profile().at(t);
    match actuator.command {
        Command::Effort(_) => value,
        Command::Servo { kp: 0.0, .. } => rate,
        Command::Servo { kp, kd, .. } => value + kd / kp * rate,
    }
}

fn join(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

struct Writer<'a> {
    mechanism: &'a Mechanism,
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
        self.line(&format!("<{text}/>"));
    }

    /// Writes an element with children.
    fn nest(&mut self, text: &str, children: impl FnOnce(&mut Self)) {
        self.line(&format!("<{text}>"));
        self.depth += 1;
        children(self);
        self.depth -= 1;
        let name = text.split(' ').next().unwrap_or_default();
        self.line(&format!("</{name}>"));
    }

    fn bodies(&mut self) {
        let mechanism = self.mechanism;
        self.nest("worldbody", |writer| {
            mechanism.ground_outlines.iter().for_each(|outline| writer.geom("ground", outline));
            writer.sites(None);
            let mut placed = vec![false; mechanism.bodies.len()];
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
        let name = &body.name;
        self.nest(&format!("body name=\"{name}\" pos=\"{x} {y} 0\" euler=\"0 0 {angle}\""), |writer| {
            joints(writer);
            let ([x, y], mass, inertia) = (body.com_m, body.mass_kg, body.inertia_kg_m2);
            writer.element(&format!(
                "inertial pos=\"{x} {y} 0\" mass=\"{mass}\" diaginertia=\"{inertia} {inertia} {inertia}\""
            ));
            body.outlines.iter().for_each(|outline| writer.geom(name, outline));
            writer.sites(Some(index));
            writer.children(Some(index), placed);
        });
    }

    /// Writes a body without joints to placed bodies: it moves freely in the plane.
    fn free_body(&mut self, index: usize, placed: &mut Vec<bool>) {
        placed[index] = true;
        let name = &self.mechanism.bodies[index].name;
        let (pose, rate) = (self.start.poses[index], self.start.rates[index]);
        self.body(index, None, placed, |writer| {
            for (axis, kind) in
                ["slide\" axis=\"1 0 0", "slide\" axis=\"0 1 0", "hinge\" axis=\"0 0 1"].iter().enumerate()
            {
                let suffix = ["x", "y", "angle"][axis];
                writer.element(&format!("joint name=\"{name}.{suffix}\" type=\"{kind}\" ref=\"{}\"", pose[axis]));
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
                ("slide", format!("{} {} 0", sign * cos, sign * sin))
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
            "joint name=\"{}\" type=\"{kind}\" pos=\"{x} {y} 0\" axis=\"{axis}\" ref=\"{position}\" damping=\"{damping}\" \
             armature=\"{}\" frictionloss=\"{friction}\"",
            joint.name, joint.armature
        );
        if stiffness > 0.0 {
            let _ = write!(text, " stiffness=\"{stiffness}\" springref=\"{}\"", effort_at_zero / stiffness);
        }
        if joint.limit.is_some() && (joint.lower.is_some() || joint.upper.is_some()) {
            let (lower, upper) = (joint.lower.unwrap_or(-UNLIMITED), joint.upper.unwrap_or(UNLIMITED));
            let _ = write!(text, " range=\"{lower} {upper}\"");
        }
        self.element(&text);
    }

    fn geom(&mut self, body: &str, outline: &Outline) {
        let shape = match outline.shape {
            OutlineShape::Disc { center_m: [x, y], radius_m } => {
                format!("type=\"sphere\" pos=\"{x} {y} 0\" size=\"{radius_m}\"")
            }
            OutlineShape::Capsule { from_m: [x0, y0], to_m: [x1, y1], radius_m } => {
                format!("type=\"capsule\" fromto=\"{x0} {y0} 0 {x1} {y1} 0\" size=\"{radius_m}\"")
            }
            OutlineShape::Ellipse { center_m: [x, y], semi_axes_m: [a, b], angle_rad } => {
                format!("type=\"ellipsoid\" pos=\"{x} {y} 0\" euler=\"0 0 {angle_rad}\" size=\"{a} {b} {}\"", a.min(b))
            }
            OutlineShape::Polygon { .. } => format!("type=\"mesh\" mesh=\"{body}.{}\"", outline.name),
            OutlineShape::HalfPlane { point_m: [x, y], normal: [nx, ny] } => {
                format!("type=\"plane\" pos=\"{x} {y} 0\" zaxis=\"{nx} {ny} 0\" size=\"1 1 0.1\"")
            }
        };
        self.element(&format!("geom name=\"{body}.{}\" {shape}", outline.name));
    }

    /// Writes the ends of linear springs on a body.
    fn sites(&mut self, body: Option<usize>) {
        for spring in &self.mechanism.springs {
            let SpringKind::Linear { bodies, points_m } = spring.kind else { continue };
            for end in (0..2).filter(|end| bodies[*end] == body) {
                let [x, y] = points_m[end];
                self.element(&format!("site name=\"{}\" pos=\"{x} {y} 0\"", site_name(&spring.name, end)));
            }
        }
    }

    /// Writes polygons, with their rounding as the outer corners of a prism.
    fn meshes(&mut self) {
        let mechanism = self.mechanism;
        let of_bodies = mechanism.bodies.iter().map(|body| (body.name.as_str(), &body.outlines));
        let all: Vec<_> = of_bodies.chain([("ground", &mechanism.ground_outlines)]).collect();
        self.nest("asset", |writer| {
            for (body, outline) in all.iter().flat_map(|(body, outlines)| outlines.iter().map(move |each| (body, each)))
            {
                if let OutlineShape::Polygon { vertices_m, radius_m } = &outline.shape {
                    let corners = rounded_corners(vertices_m, *radius_m);
                    let both = [-HALF_THICKNESS_M, HALF_THICKNESS_M];
                    let prism = both.into_iter().flat_map(|z| corners.iter().flat_map(move |[x, y]| [*x, *y, z]));
                    let vertices = join(&prism.collect::<Vec<_>>());
                    writer.element(&format!("mesh name=\"{body}.{}\" vertex=\"{vertices}\"", outline.name));
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
                let [first, second] = pair.map(|id| mechanism.outline_name(id));
                let friction = contact.law.friction.map_or(0.0, |friction| friction.mu_static);
                let condim = if friction > 0.0 { 3 } else { 1 };
                writer.element(&format!(
                    "pair geom1=\"{first}\" geom2=\"{second}\" condim=\"{condim}\" friction=\"{friction} {friction} 0 0 0\""
                ));
            }
        });
    }

    /// Writes the joints that close loops, and the couplings.
    fn constraints(&mut self, loops: &[usize]) {
        let mechanism = self.mechanism;
        self.nest("equality", |writer| {
            for index in loops {
                let joint = &mechanism.joints[*index];
                let (own, other) = if joint.bodies[0].is_some() { (0, 1) } else { (1, 0) };
                let [x, y] = joint.points_m[own];
                let mut text =
                    format!("connect name=\"{}\" body1=\"{}\"", joint.name, mechanism.body_name(joint.bodies[own]));
                if joint.bodies[other].is_some() {
                    let _ = write!(text, " body2=\"{}\"", mechanism.body_name(joint.bodies[other]));
                }
                writer.element(&format!("{text} anchor=\"{x} {y} 0\""));
            }
            for coupling in &mechanism.couplings {
                writer.element(&format!("tendon name=\"{0}\" tendon1=\"{0}\"", coupling.name));
            }
        });
    }

    /// Writes linear springs, and the sums of joint positions that couplings keep.
    fn tendons(&mut self) {
        let mechanism = self.mechanism;
        self.nest("tendon", |writer| {
            for coupling in &mechanism.couplings {
                writer.combination(&coupling.name, &coupling.on, "");
            }
            for actuator in mechanism.actuators.iter().filter(|actuator| actuator.on.joint().is_none()) {
                writer.combination(&actuator.name, &actuator.on, "");
            }
            for spring in &mechanism.springs {
                if let Some(on) = spring.on().filter(|on| on.joint().is_none()) {
                    let (stiffness, damping, rest) = (spring.stiffness, spring.damping, spring.rest + on.offset);
                    let properties =
                        format!(" stiffness=\"{stiffness}\" damping=\"{damping}\" springlength=\"{rest}\"");
                    writer.combination(&spring.name, on, &properties);
                }
            }
            for spring in mechanism.springs.iter().filter(|spring| spring.on().is_none()) {
                let (name, stiffness, damping, rest) = (&spring.name, spring.stiffness, spring.damping, spring.rest);
                let text = format!(
                    "spatial name=\"{name}\" stiffness=\"{stiffness}\" damping=\"{damping}\" springlength=\"{rest}\""
                );
                writer.nest(&text, |writer| {
                    (0..2).for_each(|end| writer.element(&format!("site site=\"{}\"", site_name(name, end))));
                });
            }
        });
    }

    /// Writes a sum of joint positions as a fixed tendon.
    fn combination(&mut self, name: &str, on: &JointCombination, properties: &str) {
        self.nest(&format!("fixed name=\"{name}\"{properties}"), |writer| {
            for (joint, factor) in &on.terms {
                let name = &writer.mechanism.joints[*joint].name;
                writer.element(&format!("joint joint=\"{name}\" coef=\"{factor}\""));
            }
        });
    }

    /// Attribute that names the joint or the fixed tendon on which an actuator of this name acts.
    fn transmission(&self, name: &str, on: &JointCombination) -> String {
        match on.joint() {
            Some(joint) => format!("joint=\"{}\"", self.mechanism.joints[joint].name),
            None => format!("tendon=\"{name}\""),
        }
    }

    /// Writes all actuators and the constant torques of springs; returns the control signals at the start.
    fn actuators(&mut self) -> Vec<f64> {
        let (mechanism, tree) = (self.mechanism, self.tree);
        let is_in_tree = |on: &JointCombination| on.terms.iter().all(|(joint, _)| tree.contains(joint));
        let mut controls = Vec::new();
        self.nest("actuator", |writer| {
            for actuator in mechanism.actuators.iter().filter(|actuator| is_in_tree(&actuator.on)) {
                let (gain, bias) = gains(actuator);
                let mut text = format!(
                    "general name=\"{}\" {} gaintype=\"fixed\" gainprm=\"{gain}\" biastype=\"affine\" biasprm=\"0 {} {}\"",
                    actuator.name,
                    writer.transmission(&actuator.name, &actuator.on),
                    bias[0],
                    bias[1]
                );
                if let Some(limit) = actuator.limit {
                    let _ = write!(text, " forcerange=\"{} {limit}\"", -limit);
                }
                writer.element(&text);
                controls.push(control(actuator, 0.0));
            }
            for spring in mechanism.springs.iter().filter(|spring| spring.stiffness == 0.0) {
                if let SpringKind::Torsional { on, preload } = &spring.kind
                    && is_in_tree(on)
                {
                    let transmission = writer.transmission(&spring.name, on);
                    writer.element(&format!("motor name=\"{}\" {transmission}", spring.name));
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
            for actuator in &mechanism.actuators {
                let times = command_times(actuator, duration_s);
                if times.len() > 1 {
                    let controls: Vec<f64> = times.iter().map(|t| control(actuator, *t)).collect();
                    for (list, numbers) in [("times", &times), ("commands", &controls)] {
                        writer.element(&format!(
                            "numeric name=\"{}.{list}\" data=\"{}\"",
                            actuator.name,
                            join(numbers)
                        ));
                    }
                }
            }
        });
    }
}

/// Bound of the side of a joint without a limit, rad or m.
const UNLIMITED: f64 = 1e3;

/// Gain on the control signal, and gains on position and rate, of an actuator.
fn gains(actuator: &Actuator) -> (f64, [f64; 2]) {
    match &actuator.command {
        // τ − |τ| q̇/ω₀, with the largest torque: MuJoCo's drop does not follow a torque over time.
        Command::Effort(profile) => {
            let drop = actuator.no_load_speed.map_or(0.0, |speed| -profile.largest() / speed);
            (1.0, [0.0, drop])
        }
        Command::Servo { kp: 0.0, kd, .. } => (*kd, [0.0, -kd]),
        Command::Servo { kp, kd, .. } => (*kp, [-kp, -kd]),
    }
}

fn site_name(spring: &str, end: usize) -> String {
    format!("{spring}.{}", ["from", "to"][end])
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

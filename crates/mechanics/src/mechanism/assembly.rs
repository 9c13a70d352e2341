//! Assembly of a mechanism: poses and rates that satisfy all joints, couplings and given start coordinates.
//!
//! The poses of the description are guesses. A damped Newton method with steps of least norm (Levenberg and Marquardt)
//! closes all loops; lengths are scaled, so that they compare with angles. Rows that follow from earlier ones are found by
//! orthogonalising the rows in order, which also names the rows that they follow from.

use std::borrow::Cow;
use std::cell::RefCell;

use super::joint::{Terms, coordinate, joint_conditions};
use super::{Body, Joint, JointCombination, JointKind, Mechanism, Pose};
use crate::numeric::MORE_DECIMALS;
use crate::numeric::plane::dot;

/// State of all bodies of an assembled mechanism, in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    pub poses: Vec<Pose>,
    pub rates: Vec<Pose>,
    /// Joints whose given start also follows from the starts of other joints.
    pub implied: Vec<usize>,
}

impl Start {
    /// Returns coordinate and rate of a joint.
    pub fn joint(&self, joint: &Joint) -> (f64, f64) {
        let (value, terms) = coordinate(joint, &self.poses);
        let by_pose = terms.by_pose();
        let rate = |(body, by_pose): (Option<usize>, Pose)| body.map_or(0.0, |body| inner(&by_pose, &self.rates[body]));
        (value, joint.bodies.into_iter().zip(by_pose).map(rate).sum())
    }
}

/// Part of the mechanism from which a condition on the poses comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    Joint(usize),
    Coupling(usize),
    /// Start coordinate of a joint.
    Start(usize),
}

/// A number with the unit that messages use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    Length(f64),
    Angle(f64),
    Speed(f64),
    AngularRate(f64),
}

/// Decimals of a [`Measure`].
const DECIMALS: usize = 4;

impl Measure {
    /// Coordinate of a joint of this kind.
    pub fn of(kind: JointKind, value: f64) -> Self {
        if kind.is_angle() { Measure::Angle(value) } else { Measure::Length(value) }
    }

    /// Rate of a joint of this kind.
    fn rate_of(kind: JointKind, value: f64) -> Self {
        if kind.is_angle() { Measure::AngularRate(value) } else { Measure::Speed(value) }
    }

    /// Returns the texts of two numbers, with enough digits to tell them apart.
    pub fn distinct([a, b]: [Self; 2]) -> [String; 2] {
        let texts = |decimals| [a, b].map(|measure: Self| measure.with_decimals(decimals));
        (DECIMALS..=DECIMALS + MORE_DECIMALS).map(texts).find(|[a, b]| a != b).unwrap_or_else(|| texts(DECIMALS))
    }

    /// Text with this number of decimals, or significant digits of a small number.
    fn with_decimals(self, decimals: usize) -> String {
        let (value, unit) = match self {
            Measure::Length(value) => (value * 1e3, "mm"),
            Measure::Angle(value) => (value.to_degrees(), "deg"),
            Measure::Speed(value) => (value * 1e3, "mm/s"),
            Measure::AngularRate(value) => (value.to_degrees(), "deg/s"),
        };
        if value != 0.0 && value.abs() < 1e-2 {
            return format!("{value:.*e} {unit}", decimals - 1);
        }
        let shown = format!("{value:.decimals$}");
        format!("{} {unit}", shown.trim_end_matches('0').trim_end_matches('.'))
    }
}

impl std::fmt::Display for Measure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.with_decimals(DECIMALS))
    }
}

/// Reason why a mechanism cannot be assembled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AssemblyError {
    #[error(
        "{name} misses by {miss} when all others fit: check the lengths and points of the loop, or give guesses closer to \
         the intended posture"
    )]
    Open { condition: Condition, name: String, miss: Measure },
    #[error(
        "{name} is redundant, because in this posture {}{}: {}remove it, or change the loop",
        follows(.from), posture_from(.couplings), check_factors(.couplings)
    )]
    Redundant {
        condition: Condition,
        name: String,
        from: Vec<String>,
        /// Couplings of the loop that may have led to this posture.
        couplings: Vec<String>,
    },
    #[error(
        "{name} is {}, but in this posture {} ({}): remove one of these values",
        Measure::distinct([*.given, *.found])[0], follows(.from), Measure::distinct([*.given, *.found])[1]
    )]
    RedundantStart { condition: Condition, name: String, given: Measure, found: Measure, from: Vec<String> },
    #[error(
        "{name} has the rate {}, but its coordinate and rate follow from other starts ({}): write this rate, or remove the start",
        Measure::distinct([*.given, *.found])[0], Measure::distinct([*.given, *.found])[1]
    )]
    RedundantRate { condition: Condition, name: String, given: Measure, found: Measure },
    #[error(
        "{name} is {}, but the mechanism reaches only {}: give a value within its range, or guesses closer to the \
         intended posture", Measure::distinct([*.given, *.found])[0], Measure::distinct([*.given, *.found])[1]
    )]
    OutOfReach { condition: Condition, name: String, given: Measure, found: Measure },
}

impl AssemblyError {
    /// Condition that the message names first.
    pub fn condition(&self) -> Condition {
        match self {
            AssemblyError::Open { condition, .. }
            | AssemblyError::Redundant { condition, .. }
            | AssemblyError::RedundantStart { condition, .. }
            | AssemblyError::RedundantRate { condition, .. }
            | AssemblyError::OutOfReach { condition, .. } => *condition,
        }
    }
}

fn follows(from: &[String]) -> String {
    if from.is_empty() { "it restricts nothing".to_owned() } else { format!("it follows from {}", from.join(", ")) }
}

fn posture_from(couplings: &[String]) -> String {
    if couplings.is_empty() {
        String::new()
    } else {
        format!("; the posture follows from {} too", couplings.join(", "))
    }
}

fn check_factors(couplings: &[String]) -> &'static str {
    if couplings.is_empty() { "" } else { "check the signs of the coupling's factors and its value; otherwise " }
}

/// Smallest length of a mechanism, m.
const MIN_LENGTH_M: f64 = 1e-9;
/// Rounding error of scaled residuals.
const ROUNDING: f64 = 1e-14;
/// Largest scaled residual of an assembled mechanism.
const CLOSED: f64 = 1e-11;
/// A row is dependent if orthogonalisation leaves less than this part of it.
const DEPENDENT: f64 = 1e-7;
/// Weight of a condition that is to take up the misfit of all others.
const YIELDING: f64 = 1e-4;
/// Largest difference, in radians or parts of the length scale, of a start from the value that follows from others: the
/// rounding errors of a user who computed it.
const AGREES: f64 = 1e-9;

thread_local! {
    /// The last mechanism that was assembled on this thread, as [`assembly_inputs`], and its start.
    static LAST_ASSEMBLY: RefCell<Option<(Vec<u64>, Start)>> = const { RefCell::new(None) };
}

/// Assembles a mechanism from its guessed poses. Degrees of freedom without a start coordinate stay closest to the
/// guess. Bodies without joints keep their pose and rate. A start that follows from other starts is allowed if it
/// agrees with them.
///
/// The last start of each thread is kept. A scene is assembled when it is read and again for its model, and most variants of a
/// scene differ in a law or a drive only.
pub fn assemble(mechanism: &Mechanism) -> Result<Start, AssemblyError> {
    let inputs = assembly_inputs(mechanism);
    let known = |last: &Option<(Vec<u64>, Start)>| {
        last.as_ref().filter(|(of, _)| *of == inputs).map(|(_, start)| start.clone())
    };
    if let Some(start) = LAST_ASSEMBLY.with_borrow(known) {
        return Ok(start);
    }
    let start = assemble_anew(mechanism)?;
    LAST_ASSEMBLY.set(Some((inputs, start.clone())));
    Ok(start)
}

/// Everything on which the start of a mechanism depends, as bits: frames of the bodies and which of them rotate or are
/// driven, joints without their laws, and couplings.
fn assembly_inputs(mechanism: &Mechanism) -> Vec<u64> {
    let Mechanism { bodies, joints, couplings, .. } = mechanism;
    let mut inputs: Vec<u64> = [bodies.len(), joints.len(), couplings.len()].map(|count| count as u64).into();
    let optional = |value: Option<f64>| [u64::from(value.is_some()), value.unwrap_or(0.0).to_bits()];
    for body in bodies {
        inputs.extend(body.com_m.iter().chain(&body.pose).chain(&body.rate).map(|value| value.to_bits()));
        inputs.extend([body.rotates(), body.motion.is_some()].map(u64::from));
    }
    for joint in joints {
        inputs.extend(optional(joint.kind.axis_rad()));
        inputs.extend(joint.bodies.map(|body| body.map_or(u64::MAX, |body| body as u64)));
        inputs.extend(joint.points_m.as_flattened().iter().map(|value| value.to_bits()));
        inputs.extend(optional(joint.start));
        inputs.extend([joint.offset_rad, joint.start_rate].map(f64::to_bits));
    }
    for coupling in couplings {
        let JointCombination { terms, offset } = &coupling.on;
        inputs.extend([terms.len() as u64, offset.to_bits()]);
        inputs.extend(terms.iter().flat_map(|(joint, factor)| [*joint as u64, factor.to_bits()]));
    }
    inputs
}

fn assemble_anew(mechanism: &Mechanism) -> Result<Start, AssemblyError> {
    let scale_m = Solver::new(mechanism).scale_m;
    let agree = |given: Measure, found: Measure| match (given, found) {
        (Measure::Length(given), Measure::Length(found)) => (given - found).abs() <= AGREES * scale_m,
        (Measure::Angle(given), Measure::Angle(found)) => (given - found).abs() <= AGREES,
        _ => false,
    };
    let (mut independent, mut implied) = (Cow::Borrowed(mechanism), Vec::new());
    let mut start = loop {
        match assemble_independent(&independent) {
            Err(AssemblyError::RedundantStart { condition: Condition::Start(joint), given, found, .. })
                if agree(given, found) =>
            {
                independent.to_mut().joints[joint].start = None;
                implied.push(joint);
            }
            result => break result?,
        }
    };
    for &index in &implied {
        let joint = &mechanism.joints[index];
        let (given, (_, found)) = (joint.start_rate, start.joint(joint));
        let scale = if joint.kind.is_angle() { 1.0 } else { scale_m };
        if (given - found).abs() > AGREES * (scale + given.abs().max(found.abs())) {
            let condition = Condition::Start(index);
            let (name, [given, found]) =
                (start_name(joint), [given, found].map(|rate| Measure::rate_of(joint.kind, rate)));
            return Err(AssemblyError::RedundantRate { condition, name, given, found });
        }
    }
    start.implied = implied;
    Ok(start)
}

fn start_name(joint: &Joint) -> String {
    format!("the start of joint `{}`", joint.name)
}

/// Gradients of all joints and couplings by the scaled poses of all bodies.
pub(super) fn all_gradients(mechanism: &Mechanism, poses: &[Pose]) -> Vec<(Condition, Vec<f64>)> {
    let rows = Solver::new(mechanism).rows(poses).into_iter().map(|row| (row.condition, row.gradient));
    rows.filter(|(condition, _)| !matches!(condition, Condition::Start(_))).collect()
}

/// Assembles a mechanism whose starts are independent of each other.
fn assemble_independent(mechanism: &Mechanism) -> Result<Start, AssemblyError> {
    let solver = Solver::new(mechanism);
    let guess: Vec<Pose> = mechanism.bodies.iter().map(|body| body.pose).collect();
    let mut poses = guess.clone();
    let mut rows = solver.rows(&poses);
    // Guesses that fit up to rounding stay as they are.
    if largest(&rows) > ROUNDING {
        solver.close(&mut poses, &|_| 1.0);
        rows = solver.rows(&poses);
    }
    if largest(&rows) > CLOSED {
        return Err(solver.misfit(guess, &poses));
    }
    let basis = match Basis::of(&rows, 0.0) {
        Ok(basis) => basis,
        Err(dependent) => return Err(solver.redundant(&rows, dependent, &poses)),
    };
    let rate = |body: &Body| if body.rotates() { body.rate } else { [body.rate[0], body.rate[1], 0.0] };
    let mut rates: Vec<Pose> = mechanism.bodies.iter().map(rate).collect();
    let with_prescribed = Solver { moves_prescribed: true, ..solver }.rows(&poses);
    // The second pass removes the rounding errors of the first.
    for _ in 0..2 {
        let scaled = solver.scaled(&rates);
        let missing = |row: &Row| solver.given_rate(row.condition) - inner(&row.gradient, &scaled);
        solver.add(&mut rates, &basis.least_norm(&with_prescribed.iter().map(missing).collect::<Vec<_>>()));
    }
    Ok(Start { poses, rates, implied: Vec::new() })
}

/// One scaled equation: its residual and gradient by all scaled poses.
struct Row {
    condition: Condition,
    residual: f64,
    gradient: Vec<f64>,
}

struct Solver<'a> {
    mechanism: &'a Mechanism,
    /// Length that counts as much as one radian.
    scale_m: f64,
    /// Whether gradients include the poses of bodies with prescribed motion, which the assembly does not change. Angles
    /// of bodies that do not rotate are constant as well.
    moves_prescribed: bool,
}

impl<'a> Solver<'a> {
    fn new(mechanism: &'a Mechanism) -> Self {
        let points = mechanism.joints.iter().flat_map(|joint| joint.points_m);
        let reach = points.chain(mechanism.bodies.iter().map(|body| body.com_m)).map(|p| dot(p, p)).fold(0.0, f64::max);
        // The centre of mass of a symmetrical outline is off by rounding errors, which are no length.
        let scale_m = if reach.sqrt() > MIN_LENGTH_M { reach.sqrt() } else { 1.0 };
        Self { mechanism, scale_m, moves_prescribed: false }
    }

    /// All equations in order: joints, couplings, start coordinates.
    fn rows(&self, poses: &[Pose]) -> Vec<Row> {
        let mut rows = Vec::new();
        let joints = &self.mechanism.joints;
        for (index, joint) in joints.iter().enumerate() {
            for (residual, terms) in joint_conditions(joint, poses) {
                // Conditions in metres are divided by the length scale.
                let scale = if matches!(terms, Terms::Angle) { 1.0 } else { 1.0 / self.scale_m };
                // An angle between bodies that do not rotate is a condition only where it is wrong.
                let rotates = |body: usize| self.mechanism.bodies[body].moves_by_forces()[2];
                let is_constant = matches!(terms, Terms::Angle) && !joint.bodies.into_iter().flatten().any(rotates);
                if is_constant && residual.abs() <= CLOSED {
                    continue;
                }
                let gradient = self.gradient(joint, terms, scale, poses.len());
                rows.push(Row { condition: Condition::Joint(index), residual: residual * scale, gradient });
            }
        }
        for (index, coupling) in self.mechanism.couplings.iter().enumerate() {
            let unit = |(joint, factor): &(usize, f64)| factor.abs() * self.coordinate_scale(&joints[*joint]).recip();
            let scale = coupling.on.terms.iter().map(unit).fold(0.0, f64::max).recip();
            let scale = if scale.is_finite() { scale } else { 1.0 };
            let mut row = Row {
                condition: Condition::Coupling(index),
                residual: scale * coupling.on.value(|joint| coordinate(&joints[joint], poses).0),
                gradient: vec![0.0; 3 * poses.len()],
            };
            for (joint, factor) in &coupling.on.terms {
                let (_, terms) = coordinate(&joints[*joint], poses);
                let gradient = self.gradient(&joints[*joint], terms, factor * scale, poses.len());
                row.gradient.iter_mut().zip(gradient).for_each(|(sum, part)| *sum += part);
            }
            rows.push(row);
        }
        for (index, joint) in joints.iter().enumerate() {
            let Some(start) = joint.start else { continue };
            let ((q, terms), scale) = (coordinate(joint, poses), self.coordinate_scale(joint));
            let gradient = self.gradient(joint, terms, scale, poses.len());
            rows.push(Row { condition: Condition::Start(index), residual: (q - start) * scale, gradient });
        }
        rows
    }

    fn coordinate_scale(&self, joint: &Joint) -> f64 {
        if joint.kind.is_angle() { 1.0 } else { 1.0 / self.scale_m }
    }

    /// Gradient by the scaled poses of all bodies.
    fn gradient(&self, joint: &Joint, terms: Terms, scale: f64, bodies: usize) -> Vec<f64> {
        let mut gradient = vec![0.0; 3 * bodies];
        for (body, [x, y, angle]) in joint.bodies.into_iter().zip(terms.by_pose()) {
            let Some(body) = body else { continue };
            let moves = self.mechanism.bodies[body].moves_by_forces().map(|moves| moves || self.moves_prescribed);
            let parts = [x * self.scale_m, y * self.scale_m, angle].into_iter().zip(moves);
            for (sum, (part, _)) in gradient[3 * body..].iter_mut().zip(parts).filter(|(_, (_, moves))| *moves) {
                *sum += scale * part;
            }
        }
        gradient
    }

    fn scaled(&self, poses: &[Pose]) -> Vec<f64> {
        poses.iter().flat_map(|[x, y, angle]| [x / self.scale_m, y / self.scale_m, *angle]).collect()
    }

    fn add(&self, poses: &mut [Pose], step: &[f64]) {
        for (pose, step) in poses.iter_mut().zip(step.chunks(3)) {
            *pose = [pose[0] + step[0] * self.scale_m, pose[1] + step[1] * self.scale_m, pose[2] + step[2]];
        }
    }

    fn given_rate(&self, condition: Condition) -> f64 {
        match condition {
            Condition::Start(joint) => {
                let joint = &self.mechanism.joints[joint];
                joint.start_rate * self.coordinate_scale(joint)
            }
            Condition::Joint(_) | Condition::Coupling(_) => 0.0,
        }
    }

    /// Moves the poses to the nearest minimum of the weighted residuals; a condition of weight 0 is left out.
    fn close(&self, poses: &mut Vec<Pose>, weight: &dyn Fn(Condition) -> f64) {
        let rows_at = |poses: &[Pose]| {
            let mut rows = self.rows(poses);
            rows.retain(|row| weight(row.condition) > 0.0);
            for row in &mut rows {
                let weight = weight(row.condition);
                row.residual *= weight;
                row.gradient.iter_mut().for_each(|part| *part *= weight);
            }
            rows
        };
        let norm = |rows: &[Row]| rows.iter().map(|row| row.residual * row.residual).sum::<f64>();
        let mut rows = rows_at(poses);
        let mut damping = 1.0;
        // Convergence is quadratic at a closed mechanism, and linear at one that does not close.
        for _ in 0..1000 {
            let before = norm(&rows);
            // The damping vanishes with the residual, so that the last steps are Newton's.
            let Ok(basis) = Basis::of(&rows, (damping * before).sqrt().max(1e-150)) else { return };
            let step = basis.least_norm(&rows.iter().map(|row| -row.residual).collect::<Vec<_>>());
            let mut next = poses.clone();
            self.add(&mut next, &step);
            let next_rows = rows_at(&next);
            let after = norm(&next_rows);
            if after < before {
                (*poses, rows) = (next, next_rows);
                damping *= 0.25;
                if after > (1.0 - 1e-12) * before {
                    return;
                }
            } else {
                damping *= 4.0;
                if step.iter().all(|part| part.abs() < 1e-15) {
                    return;
                }
            }
        }
    }

    /// Explains why the conditions do not fit.
    fn misfit(&self, guess: Vec<Pose>, closest: &[Pose]) -> AssemblyError {
        let is_start = |condition| matches!(condition, Condition::Start(_));
        let mut poses = guess;
        self.close(&mut poses, &|condition| if is_start(condition) { 0.0 } else { 1.0 });
        let mut rows = self.rows(&poses);
        rows.retain(|row| !is_start(row.condition));
        if largest(&rows) > CLOSED {
            let condition = self.worst(closest);
            self.close(&mut poses, &|other| if other == condition { YIELDING } else { f64::from(!is_start(other)) });
            let (name, miss) = (self.name(condition), self.miss(condition, &poses));
            return AssemblyError::Open { condition, name, miss };
        }
        // The loops close without the start coordinates. One of these follows from others, or is out of reach.
        let rows = self.rows(&poses);
        if let Err(dependent) = Basis::of(&rows, 0.0) {
            let condition = rows[dependent.row].condition;
            self.close(&mut poses, &|other| f64::from(other != condition));
            return self.redundant(&rows, dependent, &poses);
        }
        self.close(&mut poses, &|condition| if is_start(condition) { YIELDING } else { 1.0 });
        let rows = self.rows(&poses).into_iter().filter(|row| is_start(row.condition));
        let worst = rows.max_by(|a, b| a.residual.abs().total_cmp(&b.residual.abs()));
        let condition = worst.map_or(Condition::Start(0), |row| row.condition);
        let (given, found) = self.coordinates(condition, &poses);
        AssemblyError::OutOfReach { condition, name: self.name(condition), given, found }
    }

    /// Describes a row that follows from earlier ones.
    fn redundant(&self, rows: &[Row], dependent: Dependent, poses: &[Pose]) -> AssemblyError {
        let condition = rows[dependent.row].condition;
        let (mut from, mut joints): (Vec<String>, Vec<usize>) = Default::default();
        for &row in dependent.from.iter().chain([&dependent.row]) {
            joints.extend(if let Condition::Joint(joint) = rows[row].condition { Some(joint) } else { None });
        }
        for row in dependent.from {
            let name = self.name(rows[row].condition);
            if rows[row].condition != condition && !from.contains(&name) {
                from.push(name);
            }
        }
        let name = self.name(condition);
        if matches!(condition, Condition::Start(_)) {
            // Other start coordinates say more than the joints between them.
            if from.iter().any(|name| name.starts_with("the start")) {
                from.retain(|name| name.starts_with("the start"));
            }
            let (given, found) = self.coordinates(condition, poses);
            return AssemblyError::RedundantStart { condition, name, given, found, from };
        }
        let couplings = self.couplings_of(&joints).into_iter();
        let couplings = couplings.filter(|coupling| *coupling != name && !from.contains(coupling)).collect();
        AssemblyError::Redundant { condition, name, from, couplings }
    }

    /// Names of the couplings of the bodies of these joints.
    fn couplings_of(&self, joints: &[usize]) -> Vec<String> {
        let all = &self.mechanism.joints;
        let bodies: Vec<usize> = joints.iter().flat_map(|joint| all[*joint].bodies).flatten().collect();
        let moves = |joint: usize| all[joint].bodies.into_iter().flatten().any(|body| bodies.contains(&body));
        let concerns =
            |coupling: &usize| self.mechanism.couplings[*coupling].on.terms.iter().any(|(joint, _)| moves(*joint));
        let found = (0..self.mechanism.couplings.len()).filter(concerns);
        found.map(|coupling| self.name(Condition::Coupling(coupling))).collect()
    }

    fn name(&self, condition: Condition) -> String {
        match condition {
            Condition::Joint(joint) => format!("joint `{}`", self.mechanism.joints[joint].name),
            Condition::Coupling(coupling) => format!("coupling `{}`", self.mechanism.couplings[coupling].name),
            Condition::Start(joint) => start_name(&self.mechanism.joints[joint]),
        }
    }

    /// Joint or coupling with the largest residual; the last one of about equal ones.
    fn worst(&self, poses: &[Pose]) -> Condition {
        let mut worst = (Condition::Joint(0), 0.0);
        for row in self.rows(poses).iter().filter(|row| !matches!(row.condition, Condition::Start(_))) {
            if row.residual.abs() > 0.99 * worst.1 {
                worst = (row.condition, row.residual.abs());
            }
        }
        worst.0
    }

    /// Distance or angle by which a joint or coupling misses.
    fn miss(&self, condition: Condition, poses: &[Pose]) -> Measure {
        match condition {
            Condition::Joint(joint) | Condition::Start(joint) => {
                let joint = &self.mechanism.joints[joint];
                let [(first, _), (second, terms)] = joint_conditions(joint, poses);
                match terms {
                    Terms::Angle if second.abs() > first.abs() / self.scale_m => Measure::Angle(second.abs()),
                    Terms::Angle => Measure::Length(first.abs()),
                    Terms::Point(_) => Measure::Length(dot([first, second], [first, second]).sqrt()),
                }
            }
            Condition::Coupling(coupling) => {
                let coupling = &self.mechanism.couplings[coupling];
                let joints = &self.mechanism.joints;
                let value = coupling.on.value(|joint| coordinate(&joints[joint], poses).0);
                let first = coupling.on.terms.first().map_or(JointKind::Revolute, |(joint, _)| joints[*joint].kind);
                Measure::of(first, value.abs())
            }
        }
    }

    /// Given and present coordinate of a joint.
    fn coordinates(&self, condition: Condition, poses: &[Pose]) -> (Measure, Measure) {
        let (Condition::Joint(joint) | Condition::Coupling(joint) | Condition::Start(joint)) = condition;
        let joint = &self.mechanism.joints[joint];
        (Measure::of(joint.kind, joint.start.unwrap_or(0.0)), Measure::of(joint.kind, coordinate(joint, poses).0))
    }
}

fn largest(rows: &[Row]) -> f64 {
    rows.iter().map(|row| row.residual.abs()).fold(0.0, f64::max)
}

fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Orthonormal basis Q of rows A = L Q, from Gram and Schmidt with reorthogonalisation.
struct Basis {
    /// Number of columns of A; Q has one more for each row if the rows are damped.
    columns: usize,
    q: Vec<Vec<f64>>,
    lower: Vec<Vec<f64>>,
}

/// A row that is a combination of earlier ones.
struct Dependent {
    row: usize,
    from: Vec<usize>,
}

impl Basis {
    /// With damping d, the rows are those of (A, d I): the least-norm solution then is that of Levenberg and Marquardt.
    fn of(rows: &[Row], damping: f64) -> Result<Self, Dependent> {
        let columns = rows.first().map_or(0, |row| row.gradient.len());
        let mut basis = Self { columns, q: Vec::new(), lower: Vec::new() };
        for (index, row) in rows.iter().enumerate() {
            let mut rest = row.gradient.clone();
            if damping > 0.0 {
                rest.extend((0..rows.len()).map(|other| if other == index { damping } else { 0.0 }));
            }
            let norm = inner(&rest, &rest).sqrt();
            let mut lower = vec![0.0; index];
            for _ in 0..2 {
                for (q, factor) in basis.q.iter().zip(&mut lower) {
                    let part = inner(&rest, q);
                    *factor += part;
                    rest.iter_mut().zip(q).for_each(|(rest, q)| *rest -= part * q);
                }
            }
            let left = inner(&rest, &rest).sqrt();
            if left <= if damping > 0.0 { 0.0 } else { DEPENDENT * norm } {
                return Err(Dependent { row: index, from: basis.combination(&lower) });
            }
            rest.iter_mut().for_each(|part| *part /= left);
            lower.push(left);
            basis.q.push(rest);
            basis.lower.push(lower);
        }
        Ok(basis)
    }

    /// Rows whose combination has these factors in the basis.
    fn combination(&self, factors: &[f64]) -> Vec<usize> {
        let mut left = factors.to_vec();
        for row in (0..left.len()).rev() {
            left[row] /= self.lower[row][row];
            let (before, share) = (row, left[row]);
            left[..before].iter_mut().zip(&self.lower[row]).for_each(|(factor, part)| *factor -= share * part);
        }
        let largest = left.iter().map(|share| share.abs()).fold(0.0, f64::max);
        (0..left.len()).filter(|row| left[*row].abs() > 1e-6 * largest).collect()
    }

    /// Shortest x with A x = b.
    fn least_norm(&self, b: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; self.columns];
        let mut factors: Vec<f64> = Vec::new();
        for ((lower, q), b) in self.lower.iter().zip(&self.q).zip(b) {
            let factor = (b - inner(lower, &factors)) / lower[factors.len()];
            x.iter_mut().zip(q).for_each(|(x, q)| *x += factor * q);
            factors.push(factor);
        }
        x
    }
}

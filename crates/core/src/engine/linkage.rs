//! Bodies and joints as in rapier, and the joint reactions to forces: a saddle-point (KKT) system over all bodies.
//!
//! Let M be the mass matrix of the bodies, J the Jacobian of the joint openings with respect to body velocities, and A
//! = J M⁻¹ Jᵀ:
//! * joint-consistent velocities: v ← v − M⁻¹ Jᵀ A⁻¹ (J v − b), with the required opening rates b;
//! * response to a generalised impulse c: M⁻¹ (c + Jᵀ λ) with A λ = −J M⁻¹ c, including joint reactions.
//!
//! The system is general in bodies and joints; it uses only rapier's masses and anchors.

use std::f64::consts::TAU;

use super::dense;
use super::plan::{Plan, PlannedGear, PlannedPin};
use super::world::World;
use crate::numeric::elementary::{atan2, cos, hypot, powi, sin};
use crate::numeric::plane::{perp, rotate};

/// Velocity (x, y, angle) of a body, or a force and a torque about its centre of mass.
pub type Twist = [f64; 3];

/// Mass and moment of inertia of a body, and their inverses.
#[derive(Clone, Copy, Debug)]
pub struct Inertia {
    pub mass: f64,
    pub inverse_mass: f64,
    pub inertia: f64,
    pub inverse_inertia: f64,
}

/// One side of a pin, or a wheel of a gear: body, anchor relative to the centre of mass in the body frame (`local`) and
/// in the world frame (`arm`), and the sign of its velocity in the pin's opening rate, 0 for a wheel. Sides on the
/// ground do not move and are omitted.
#[derive(Clone, Copy, Debug)]
struct PinSide {
    pin: usize,
    body: usize,
    sign: f64,
    local: [f64; 2],
    arm: [f64; 2],
    /// Opening rate per angular rate of the body: sign · arm⊥, or the ratios of a gear.
    opening_per_angle: [f64; 2],
}

/// Pose of a body: centre of mass, orientation as (cos, sin), and as a continuous angle.
#[derive(Clone, Copy, Debug)]
pub struct BodyPose {
    pub com: [f64; 2],
    pub direction: [f64; 2],
    pub angle: f64,
}

/// Error for joints or masses whose equations of motion have no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the joint constraints are singular: the mechanism is in or near a singular configuration")]
pub struct SingularConstraints;

/// Masses, poses and joints of all bodies, and the factorised joint system.
pub struct Linkage {
    pub inertias: Vec<Inertia>,
    pub poses: Vec<BodyPose>,
    /// Sides of all pins, pin by pin, then the wheels of all gears.
    sides: Vec<PinSide>,
    pins: usize,
    /// Anchors on the ground; for gears, their initial sums.
    ground_anchors: Vec<[f64; 2]>,
    /// Pairs of sides on the same body, which couple their pins.
    couplings: Vec<(usize, usize)>,
    factor: Vec<f64>,
    /// First nonzero column of each row of the factor: pins that share no body do not couple.
    first_columns: Vec<usize>,
    /// Right-hand side and solution.
    multipliers: Vec<f64>,
}

impl Linkage {
    /// Reads masses, anchors and poses from rapier's bodies.
    pub fn new(world: &World, plan: &Plan) -> Self {
        let pins = &plan.pins;
        let bodies = &world.physics.bodies;
        let rigid = |i: usize| &bodies[world.bodies[i]];
        let inertias = (0..world.bodies.len())
            .map(|i| {
                let properties = rigid(i).mass_properties().local_mprops;
                Inertia {
                    mass: properties.mass(),
                    inverse_mass: properties.inv_mass,
                    inertia: properties.principal_inertia(),
                    inverse_inertia: properties.inv_principal_inertia,
                }
            })
            .collect();
        let side = |pin: usize, body: usize, sign: f64, anchor: [f64; 2]| {
            let com = rigid(body).local_center_of_mass();
            PinSide {
                pin,
                body,
                sign,
                local: [anchor[0] - com.x, anchor[1] - com.y],
                arm: [0.0; 2],
                opening_per_angle: [0.0; 2],
            }
        };
        let sides: Vec<PinSide> = pins
            .iter()
            .enumerate()
            .flat_map(|(index, pin)| {
                let first = pin.first.map(|body| side(index, body, -1.0, pin.anchor_first_m));
                first.into_iter().chain([side(index, pin.second, 1.0, pin.anchor_second_m)])
            })
            .chain(plan.gears.iter().enumerate().flat_map(|(index, gear)| {
                let wheel = |(body, opening_per_angle): &(usize, [f64; 2])| PinSide {
                    pin: pins.len() + index,
                    body: *body,
                    sign: 0.0,
                    local: [0.0; 2],
                    arm: [0.0; 2],
                    opening_per_angle: *opening_per_angle,
                };
                gear.wheels.iter().map(wheel).collect::<Vec<_>>()
            }))
            .collect();
        let share_body = |&(a, b): &(usize, usize)| {
            let (a, b): (&PinSide, &PinSide) = (&sides[a], &sides[b]);
            a.body == b.body && b.pin <= a.pin
        };
        let couplings: Vec<_> =
            (0..sides.len()).flat_map(|a| (0..sides.len()).map(move |b| (a, b))).filter(share_body).collect();
        let first_column = |pin: usize| {
            let coupled = couplings.iter().filter(|(a, _)| sides[*a].pin == pin);
            2 * coupled.map(|(_, b)| sides[*b].pin).min().unwrap_or(pin)
        };
        let initial_pose = |angle: f64| BodyPose { com: [0.0; 2], direction: [cos(angle), sin(angle)], angle };
        let poses = plan.bodies.iter().map(|body| initial_pose(body.angle_rad)).collect();
        let size = 2 * (pins.len() + plan.gears.len());
        let initial_sums = |gear: &PlannedGear| {
            let sum = |row: usize| {
                gear.wheels
                    .iter()
                    .map(|(body, opening_per_angle)| opening_per_angle[row] * plan.bodies[*body].angle_rad)
                    .sum()
            };
            [sum(0), sum(1)]
        };
        let ground_anchor = |pin: &PlannedPin| if pin.first.is_none() { pin.anchor_first_m } else { [0.0; 2] };
        let mut linkage = Self {
            inertias,
            poses,
            pins: pins.len(),
            ground_anchors: pins.iter().map(ground_anchor).chain(plan.gears.iter().map(initial_sums)).collect(),
            factor: vec![0.0; size * size],
            first_columns: (0..size).map(|row| first_column(row / 2)).collect(),
            sides,
            couplings,
            multipliers: vec![0.0; size],
        };
        linkage.read_poses(world);
        linkage
    }

    /// Reads the poses of the bodies from rapier.
    pub(crate) fn read_poses(&mut self, world: &World) {
        for (pose, handle) in self.poses.iter_mut().zip(&world.bodies) {
            let body = &world.physics.bodies[*handle];
            let (com, rotation) = (body.center_of_mass(), body.rotation());
            let direction = [rotation.re, rotation.im];
            // A step rotates by less than half a turn, so the nearest equivalent angle is the continuous one.
            let principal = atan2(direction[1], direction[0]);
            let turns = ((pose.angle - principal) / TAU).round();
            *pose = BodyPose { com: [com.x, com.y], direction, angle: principal + turns * TAU };
        }
        for side in &mut self.sides {
            if side.sign != 0.0 {
                side.arm = rotate(side.local, self.poses[side.body].direction);
                side.opening_per_angle = perp(side.arm).map(|component| side.sign * component);
            }
        }
    }

    /// Factorises A at the current poses; fails if the joint constraints are singular.
    pub(crate) fn factorise(&mut self) -> Result<(), SingularConstraints> {
        let size = self.first_columns.len();
        if size == 0 {
            return Ok(());
        }
        for (row, &first) in self.factor.chunks_exact_mut(size).zip(&self.first_columns) {
            row[first..].fill(0.0);
        }
        for &(a, b) in &self.couplings {
            let (a, b) = (&self.sides[a], &self.sides[b]);
            let inertia = &self.inertias[a.body];
            let (inverse_mass, inverse_inertia) = (a.sign * b.sign * inertia.inverse_mass, inertia.inverse_inertia);
            let (u, v) = (a.opening_per_angle, b.opening_per_angle);
            let offset = 2 * a.pin * size + 2 * b.pin;
            self.factor[offset] += inverse_mass + inverse_inertia * u[0] * v[0];
            self.factor[offset + 1] += inverse_inertia * u[0] * v[1];
            self.factor[offset + size] += inverse_inertia * u[1] * v[0];
            self.factor[offset + size + 1] += inverse_mass + inverse_inertia * u[1] * v[1];
        }
        if dense::factorise(&mut self.factor, &self.first_columns) { Ok(()) } else { Err(SingularConstraints) }
    }

    /// Returns the largest distance between the two anchors of a pin.
    pub(crate) fn max_pin_opening(&self) -> f64 {
        self.pin_openings().take(self.pins).fold(0.0, |largest, [x, y]| largest.max(hypot(x, y)))
    }

    /// Returns the opening of every pin, from its first anchor to its second; for gears, their sums.
    pub(crate) fn pin_openings(&self) -> impl Iterator<Item = [f64; 2]> {
        let mut sides = self.sides.iter().peekable();
        self.ground_anchors.iter().enumerate().map(move |(pin, ground)| {
            let mut open = [-ground[0], -ground[1]];
            while let Some(side) = sides.next_if(|side| side.pin == pin) {
                let BodyPose { com, angle, .. } = self.poses[side.body];
                for axis in 0..2 {
                    open[axis] += match side.sign {
                        0.0 => side.opening_per_angle[axis] * angle,
                        sign => sign * (com[axis] + side.arm[axis]),
                    };
                }
            }
            open
        })
    }

    /// Computes the centripetal accelerations −J̇ v of the anchors into `multipliers`.
    fn centripetal(&mut self, velocities: &[Twist]) {
        self.multipliers.fill(0.0);
        for side in &self.sides {
            let square = side.sign * powi(velocities[side.body][2], 2);
            self.multipliers[2 * side.pin] += square * side.arm[0];
            self.multipliers[2 * side.pin + 1] += square * side.arm[1];
        }
    }

    /// Returns the opening of every pin in a step of `dt` if its bodies move straight on: ½ dt² J̇ v.
    pub(crate) fn overshoot(&mut self, velocities: &[Twist], dt: f64) -> impl Iterator<Item = [f64; 2]> {
        self.centripetal(velocities);
        let scale = -0.5 * dt * dt;
        self.multipliers.chunks_exact(2).map(move |pair| [scale * pair[0], scale * pair[1]])
    }

    /// Transforms a direction from the world to a body frame; `None` is the ground.
    pub(crate) fn direction_in_body(&self, body: Option<usize>, direction: [f64; 2]) -> [f64; 2] {
        body.map_or(direction, |body| {
            let [c, s] = self.poses[body].direction;
            rotate(direction, [c, -s])
        })
    }

    /// Returns the largest opening acceleration of a pin whose bodies move straight on, m/s².
    pub(crate) fn max_opening_acceleration(&mut self, velocities: &[Twist]) -> f64 {
        self.centripetal(velocities);
        self.multipliers.chunks_exact(2).fold(0.0, |largest, pair| largest.max(hypot(pair[0], pair[1])))
    }

    /// Projects velocities onto the joint constraints, with the smallest change in the mass metric.
    pub fn project(&mut self, velocities: &mut [Twist]) {
        self.multipliers.fill(0.0);
        self.correct(velocities);
    }

    /// Computes accelerations M⁻¹ (f + Jᵀ λ) with J a = −J̇ v; those of driven bodies are prescribed.
    pub fn accelerations(&mut self, forces: &[Twist], rates: &[Twist], driven: &[(usize, Twist)], out: &mut [Twist]) {
        self.centripetal(rates);
        self.accelerate(forces, driven, out);
    }

    /// Returns the forces of the pins on their second bodies, after a call of [`Linkage::accelerations`] or
    /// [`Linkage::respond`].
    pub(crate) fn pin_forces(&self) -> impl Iterator<Item = [f64; 2]> {
        self.multipliers.chunks_exact(2).take(self.pins).map(|pair| [pair[0], pair[1]])
    }

    /// Computes the accelerations that rapier produces from the same forces in a step of `dt` from rest, given the pin
    /// openings it starts with: J a = −2 open/dt², so that half a step closes them.
    pub(crate) fn accelerations_closing(
        &mut self,
        forces: &[Twist],
        (open, dt): (&[[f64; 2]], f64),
        driven: &[(usize, Twist)],
        out: &mut [Twist],
    ) {
        for (pin, [x, y]) in open.iter().enumerate() {
            let scale = -2.0 / (dt * dt);
            (self.multipliers[2 * pin], self.multipliers[2 * pin + 1]) = (scale * x, scale * y);
        }
        self.accelerate(forces, driven, out);
    }

    fn accelerate(&mut self, forces: &[Twist], driven: &[(usize, Twist)], out: &mut [Twist]) {
        for ((a, f), inertia) in out.iter_mut().zip(forces).zip(&self.inertias) {
            *a = [f[0] * inertia.inverse_mass, f[1] * inertia.inverse_mass, f[2] * inertia.inverse_inertia];
        }
        for (body, acceleration) in driven {
            out[*body] = *acceleration;
        }
        self.correct(out);
    }

    /// Computes the velocity response to a generalised impulse c, passed in `out`: M⁻¹ (c + Jᵀ λ).
    pub fn respond(&mut self, out: &mut [Twist]) {
        for (v, inertia) in out.iter_mut().zip(&self.inertias) {
            *v = [v[0] * inertia.inverse_mass, v[1] * inertia.inverse_mass, v[2] * inertia.inverse_inertia];
        }
        self.project(out);
    }

    /// v ← v + M⁻¹ Jᵀ A⁻¹ (b − J v), with b passed in `multipliers`.
    fn correct(&mut self, velocities: &mut [Twist]) {
        for side in &self.sides {
            let [x, y, w] = velocities[side.body];
            let b = &mut self.multipliers[2 * side.pin..2 * side.pin + 2];
            b[0] -= side.sign * x + w * side.opening_per_angle[0];
            b[1] -= side.sign * y + w * side.opening_per_angle[1];
        }
        dense::solve_factorised(&self.factor, &self.first_columns, &mut self.multipliers);
        for side in &self.sides {
            let inertia = &self.inertias[side.body];
            let b = &self.multipliers[2 * side.pin..2 * side.pin + 2];
            let v = &mut velocities[side.body];
            v[0] += inertia.inverse_mass * side.sign * b[0];
            v[1] += inertia.inverse_mass * side.sign * b[1];
            v[2] += inertia.inverse_inertia * (side.opening_per_angle[1] * b[1] + side.opening_per_angle[0] * b[0]);
        }
    }
}

//! Bodies and joints as rapier has them, and what the joints make of forces: a saddle-point (KKT) system over all bodies.
//!
//! With M the masses of the bodies, J the rates at which joints open per body velocity, and A = J M⁻¹ Jᵀ:
//! * velocities that keep the joints: v ← v − M⁻¹ Jᵀ A⁻¹ (J v − b), b the wanted opening rate;
//! * response to a generalised impulse c: M⁻¹ (c + Jᵀ λ) with A λ = −J M⁻¹ c, reactions of the joints included.
//!
//! General in bodies and joints: all it is told are rapier's masses and anchors.

use std::f64::consts::TAU;

use super::dense;
use super::plan::{Plan, PlannedGear, PlannedPin};
use super::world::World;
use crate::numeric::elementary::{atan2, cos, hypot, powi, sin};
use crate::numeric::plane::{perp, rotate};

/// (x, y, angle) of a body's velocity, or of a force and a torque about its centre of mass.
pub type Twist = [f64; 3];

#[derive(Clone, Copy, Debug)]
pub struct Inertia {
    pub mass: f64,
    pub inverse_mass: f64,
    pub inertia: f64,
    pub inverse_inertia: f64,
}

/// One side of a pin: the body, its anchor from the centre of mass, in the body and turned into the world, and the sign of
/// its velocity in the pin's opening rate, 0 for a wheel of a gear. A side on the ground does not move and is left out.
#[derive(Clone, Copy, Debug)]
struct Side {
    pin: usize,
    body: usize,
    sign: f64,
    local: [f64; 2],
    arm: [f64; 2],
    /// Opening rate by the body's rate of turning: sign · arm⊥, or the ratios of a gear.
    turn: [f64; 2],
}

/// Where a body is: centre of mass, orientation as (cos, sin), and as an angle without jumps.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub com: [f64; 2],
    pub direction: [f64; 2],
    pub angle: f64,
}

/// Joints or masses for which the system has no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the joints lock each other: the mechanism is in, or next to, a singular configuration")]
pub struct Locked;

pub struct Linkage {
    pub inertias: Vec<Inertia>,
    pub places: Vec<Place>,
    /// Sides of all pins, pin by pin, and gears behind them; the anchors on the ground, or the sums of a gear at the start; pairs of
    /// sides on one body, by which their pins couple.
    sides: Vec<Side>,
    pins: usize,
    grounds: Vec<[f64; 2]>,
    couplings: Vec<(usize, usize)>,
    /// Cholesky factor of A, and where its rows begin: pins that share no body do not couple.
    factor: Vec<f64>,
    first: Vec<usize>,
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
            Side { pin, body, sign, local: [anchor[0] - com.x, anchor[1] - com.y], arm: [0.0; 2], turn: [0.0; 2] }
        };
        let sides: Vec<Side> = pins
            .iter()
            .enumerate()
            .flat_map(|(index, pin)| {
                let first = pin.first.map(|body| side(index, body, -1.0, pin.anchor_first_m));
                first.into_iter().chain([side(index, pin.second, 1.0, pin.anchor_second_m)])
            })
            .chain(plan.gears.iter().enumerate().flat_map(|(index, gear)| {
                let wheel = |(body, turn): &(usize, [f64; 2])| Side {
                    pin: pins.len() + index,
                    body: *body,
                    sign: 0.0,
                    local: [0.0; 2],
                    arm: [0.0; 2],
                    turn: *turn,
                };
                gear.wheels.iter().map(wheel).collect::<Vec<_>>()
            }))
            .collect();
        let on_one_body = |&(a, b): &(usize, usize)| {
            let (a, b): (&Side, &Side) = (&sides[a], &sides[b]);
            a.body == b.body && b.pin <= a.pin
        };
        let couplings: Vec<_> =
            (0..sides.len()).flat_map(|a| (0..sides.len()).map(move |b| (a, b))).filter(on_one_body).collect();
        let first_of = |pin: usize| {
            let coupled = couplings.iter().filter(|(a, _)| sides[*a].pin == pin);
            2 * coupled.map(|(_, b)| sides[*b].pin).min().unwrap_or(pin)
        };
        let at_start = |angle: f64| Place { com: [0.0; 2], direction: [cos(angle), sin(angle)], angle };
        let places = plan.bodies.iter().map(|body| at_start(body.angle_rad)).collect();
        let size = 2 * (pins.len() + plan.gears.len());
        let at_first = |gear: &PlannedGear| {
            let sum =
                |row: usize| gear.wheels.iter().map(|(body, turn)| turn[row] * plan.bodies[*body].angle_rad).sum();
            [sum(0), sum(1)]
        };
        let on_ground = |pin: &PlannedPin| if pin.first.is_none() { pin.anchor_first_m } else { [0.0; 2] };
        let mut linkage = Self {
            inertias,
            places,
            pins: pins.len(),
            grounds: pins.iter().map(on_ground).chain(plan.gears.iter().map(at_first)).collect(),
            factor: vec![0.0; size * size],
            first: (0..size).map(|row| first_of(row / 2)).collect(),
            sides,
            couplings,
            multipliers: vec![0.0; size],
        };
        linkage.read_places(world);
        linkage
    }

    /// Takes over where rapier has put the bodies.
    pub fn read_places(&mut self, world: &World) {
        for (place, handle) in self.places.iter_mut().zip(&world.bodies) {
            let body = &world.physics.bodies[*handle];
            let (com, rotation) = (body.center_of_mass(), body.rotation());
            let direction = [rotation.re, rotation.im];
            // A step turns by less than half a turn: the nearest angle is the one that goes on.
            let exact = atan2(direction[1], direction[0]);
            let turns = ((place.angle - exact) / TAU).round();
            *place = Place { com: [com.x, com.y], direction, angle: exact + turns * TAU };
        }
        for side in &mut self.sides {
            if side.sign != 0.0 {
                side.arm = rotate(side.local, self.places[side.body].direction);
                side.turn = perp(side.arm).map(|part| side.sign * part);
            }
        }
    }

    /// Factorises A at the present places.
    pub fn factorise(&mut self) -> Result<(), Locked> {
        let size = self.first.len();
        if size == 0 {
            return Ok(());
        }
        for (row, &first) in self.factor.chunks_exact_mut(size).zip(&self.first) {
            row[first..].fill(0.0);
        }
        for &(a, b) in &self.couplings {
            let (a, b) = (&self.sides[a], &self.sides[b]);
            let inertia = &self.inertias[a.body];
            let (mass, turn) = (a.sign * b.sign * inertia.inverse_mass, inertia.inverse_inertia);
            let (u, v) = (a.turn, b.turn);
            let at = 2 * a.pin * size + 2 * b.pin;
            self.factor[at] += mass + turn * u[0] * v[0];
            self.factor[at + 1] += turn * u[0] * v[1];
            self.factor[at + size] += turn * u[1] * v[0];
            self.factor[at + size + 1] += mass + turn * u[1] * v[1];
        }
        if dense::factorise(&mut self.factor, &self.first) { Ok(()) } else { Err(Locked) }
    }

    /// Largest distance between the two anchors of a pin.
    pub fn gap(&self) -> f64 {
        self.open().take(self.pins).fold(0.0, |most, [x, y]| most.max(hypot(x, y)))
    }

    /// How far every pin is open: from its first anchor to its second; of a gear, its sums.
    pub fn open(&self) -> impl Iterator<Item = [f64; 2]> {
        let mut sides = self.sides.iter().peekable();
        self.grounds.iter().enumerate().map(move |(pin, ground)| {
            let mut open = [-ground[0], -ground[1]];
            while let Some(side) = sides.next_if(|side| side.pin == pin) {
                let Place { com, angle, .. } = self.places[side.body];
                for axis in 0..2 {
                    open[axis] += match side.sign {
                        0.0 => side.turn[axis] * angle,
                        sign => sign * (com[axis] + side.arm[axis]),
                    };
                }
            }
            open
        })
    }

    /// Accelerations −J̇ v the joints need, those of the anchors' circles, into `multipliers`.
    fn centripetal(&mut self, velocities: &[Twist]) {
        self.multipliers.fill(0.0);
        for side in &self.sides {
            let square = side.sign * powi(velocities[side.body][2], 2);
            self.multipliers[2 * side.pin] += square * side.arm[0];
            self.multipliers[2 * side.pin + 1] += square * side.arm[1];
        }
    }

    /// How far every pin opens in a step of `dt` because its bodies go straight on where the joint turns: ½ dt² J̇ v.
    pub fn overshoot(&mut self, velocities: &[Twist], dt: f64) -> impl Iterator<Item = [f64; 2]> {
        self.centripetal(velocities);
        let scale = -0.5 * dt * dt;
        self.multipliers.chunks_exact(2).map(move |pair| [scale * pair[0], scale * pair[1]])
    }

    /// A direction of the world in the frame of a body; `None` is the ground.
    pub fn in_frame(&self, body: Option<usize>, direction: [f64; 2]) -> [f64; 2] {
        body.map_or(direction, |body| {
            let [c, s] = self.places[body].direction;
            rotate(direction, [c, -s])
        })
    }

    /// Largest rate of rate at which a pin would open if its bodies went straight on, in m/s².
    pub fn opening(&mut self, velocities: &[Twist]) -> f64 {
        self.centripetal(velocities);
        self.multipliers.chunks_exact(2).fold(0.0, |most, pair| most.max(hypot(pair[0], pair[1])))
    }

    /// Makes velocities keep the joints, with the smallest change in the metric of the masses.
    pub fn project(&mut self, velocities: &mut [Twist]) {
        self.multipliers.fill(0.0);
        self.correct(velocities);
    }

    /// Accelerations M⁻¹ (f + Jᵀ λ) at given velocities, with J a = −J̇ v; those of driven bodies are given.
    pub fn accelerations(
        &mut self,
        forces: &[Twist],
        velocities: &[Twist],
        driven: &[(usize, Twist)],
        out: &mut [Twist],
    ) {
        self.centripetal(velocities);
        self.accelerate(forces, driven, out);
    }

    /// The accelerations that rapier will make of the same forces in a step from rest of `dt`, given how far open it finds
    /// each pin: J a = −2 open/dt², so that half a step of it closes them.
    pub fn accelerations_closing(
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

    /// Velocity response to a generalised impulse, which `out` holds on entry; on return M⁻¹ (c + Jᵀ λ).
    pub fn respond(&mut self, out: &mut [Twist]) {
        for (v, inertia) in out.iter_mut().zip(&self.inertias) {
            *v = [v[0] * inertia.inverse_mass, v[1] * inertia.inverse_mass, v[2] * inertia.inverse_inertia];
        }
        self.project(out);
    }

    /// v ← v + M⁻¹ Jᵀ A⁻¹ (b − J v), b being what `multipliers` holds on entry.
    fn correct(&mut self, velocities: &mut [Twist]) {
        for side in &self.sides {
            let [x, y, w] = velocities[side.body];
            let b = &mut self.multipliers[2 * side.pin..2 * side.pin + 2];
            b[0] -= side.sign * x + w * side.turn[0];
            b[1] -= side.sign * y + w * side.turn[1];
        }
        dense::solve_factorised(&self.factor, &self.first, &mut self.multipliers);
        for side in &self.sides {
            let inertia = &self.inertias[side.body];
            let b = &self.multipliers[2 * side.pin..2 * side.pin + 2];
            let v = &mut velocities[side.body];
            v[0] += inertia.inverse_mass * side.sign * b[0];
            v[1] += inertia.inverse_mass * side.sign * b[1];
            v[2] += inertia.inverse_inertia * (side.turn[1] * b[1] + side.turn[0] * b[0]);
        }
    }
}

//! Bodies and joints as rapier has them, and what the joints make of forces: a saddle-point (KKT) system over all bodies.
//!
//! With M the masses of the bodies, J the rates at which joints open per body velocity, and A = J M⁻¹ Jᵀ:
//! * velocities that keep the joints: v ← v − M⁻¹ Jᵀ A⁻¹ (J v − b), b the wanted opening rate;
//! * response to a generalised impulse c: M⁻¹ (c + Jᵀ λ) with A λ = −J M⁻¹ c, reactions of the joints included.
//!
//! General in bodies and joints: all it is told are rapier's masses and anchors.

use std::f64::consts::TAU;

use super::dense;
use super::plan::Plan;
use super::world::World;
use crate::numeric::plane::{cross, dot, perp, rotate};

/// (x, y, angle) of a body's velocity, or of a force and a torque about its centre of mass.
pub type Twist = [f64; 3];

#[derive(Clone, Copy, Debug)]
pub struct Inertia {
    pub mass: f64,
    pub inverse_mass: f64,
    pub inertia: f64,
    pub inverse_inertia: f64,
}

/// One side of a pin: the body, its anchor from the centre of mass, in the body and turned into the world.
#[derive(Clone, Copy, Debug)]
struct Side {
    body: usize,
    local: [f64; 2],
    arm: [f64; 2],
}

#[derive(Clone, Copy, Debug)]
struct Pin {
    /// `None`: an anchor on the ground, which does not move.
    first: Option<Side>,
    second: Side,
    ground: [f64; 2],
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
    pins: Vec<Pin>,
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
        let side = |body: usize, anchor: [f64; 2]| {
            let com = rigid(body).local_center_of_mass();
            Side { body, local: [anchor[0] - com.x, anchor[1] - com.y], arm: [0.0; 2] }
        };
        let at_start = |angle: f64| Place { com: [0.0; 2], direction: [angle.cos(), angle.sin()], angle };
        let places = plan.bodies.iter().map(|body| at_start(body.angle_rad)).collect();
        let size = 2 * pins.len();
        let mut linkage = Self {
            inertias,
            places,
            pins: pins
                .iter()
                .map(|pin| Pin {
                    first: pin.first.map(|body| side(body, pin.anchor_first_m)),
                    second: side(pin.second, pin.anchor_second_m),
                    ground: pin.anchor_first_m,
                })
                .collect(),
            factor: vec![0.0; size * size],
            first: Vec::new(),
            multipliers: vec![0.0; size],
        };
        linkage.first = (0..size).map(|row| 2 * linkage.first_coupled(row / 2)).collect();
        linkage.read_places(world);
        linkage
    }

    /// Takes over where rapier has put the bodies.
    pub fn read_places(&mut self, world: &World) {
        for (place, handle) in self.places.iter_mut().zip(&world.bodies) {
            let body = &world.physics.bodies[*handle];
            let (com, rotation) = (body.center_of_mass(), body.rotation());
            let direction = [rotation.re, rotation.im];
            // A step turns far less than half a turn: the change of the angle has no seam.
            let turned = cross(place.direction, direction).atan2(dot(place.direction, direction));
            let exact = direction[1].atan2(direction[0]);
            let continued = place.angle + turned;
            let turns = ((continued - exact) / TAU).round();
            *place = Place { com: [com.x, com.y], direction, angle: exact + turns * TAU };
        }
        for pin in &mut self.pins {
            for side in pin.first.iter_mut().chain(std::iter::once(&mut pin.second)) {
                side.arm = rotate(side.local, self.places[side.body].direction);
            }
        }
    }

    /// Factorises A at the present places.
    pub fn factorise(&mut self) -> Result<(), Locked> {
        let size = 2 * self.pins.len();
        for p in 0..self.pins.len() {
            for q in self.first[2 * p] / 2..=p {
                let block = self.coupling(&self.pins[p], &self.pins[q]);
                for (row, line) in block.iter().enumerate() {
                    let at = (2 * p + row) * size + 2 * q;
                    self.factor[at..at + 2].copy_from_slice(line);
                }
            }
        }
        if dense::factorise(&mut self.factor, &self.first) { Ok(()) } else { Err(Locked) }
    }

    /// The first pin that shares a body with a pin.
    fn first_coupled(&self, p: usize) -> usize {
        let shares = |q: &Pin| sides(q).any(|(b, _)| sides(&self.pins[p]).any(|(a, _)| a.body == b.body));
        self.pins.iter().position(shares).unwrap_or(p)
    }

    /// Rate at which pin p opens per unit impulse at pin q.
    fn coupling(&self, p: &Pin, q: &Pin) -> [[f64; 2]; 2] {
        let mut block = [[0.0; 2]; 2];
        for (a, sign_a) in sides(p) {
            for (b, sign_b) in sides(q) {
                if a.body != b.body {
                    continue;
                }
                let inertia = &self.inertias[a.body];
                let sign = sign_a * sign_b;
                let (u, v) = (perp(a.arm), perp(b.arm));
                for row in 0..2 {
                    for column in 0..2 {
                        block[row][column] += sign * inertia.inverse_inertia * u[row] * v[column];
                    }
                    block[row][row] += sign * inertia.inverse_mass;
                }
            }
        }
        block
    }

    /// Largest distance between the two anchors of a pin.
    pub fn gap(&self) -> f64 {
        (0..self.pins.len()).map(|pin| self.open(pin)).fold(0.0, |most, [x, y]| most.max(x.hypot(y)))
    }

    /// Acceleration −J̇ v the joints need: that of the anchors' circles.
    fn centripetal(&self, velocities: &[Twist], pin: usize) -> [f64; 2] {
        let mut wanted = [0.0; 2];
        for (side, sign) in sides(&self.pins[pin]) {
            let rate = velocities[side.body][2];
            for (wanted, arm) in wanted.iter_mut().zip(side.arm) {
                *wanted += sign * rate * rate * arm;
            }
        }
        wanted
    }

    /// How far a pin opens in a step of `dt` because its bodies go straight on where the joint turns: ½ dt² J̇ v.
    pub fn overshoot(&self, velocities: &[Twist], pin: usize, dt: f64) -> [f64; 2] {
        self.centripetal(velocities, pin).map(|wanted| -0.5 * dt * dt * wanted)
    }

    /// How far a pin is open: from its first anchor to its second.
    pub fn open(&self, pin: usize) -> [f64; 2] {
        let pin = &self.pins[pin];
        let at = |side: &Side| {
            let com = self.places[side.body].com;
            [com[0] + side.arm[0], com[1] + side.arm[1]]
        };
        let (a, b) = (pin.first.as_ref().map_or(pin.ground, at), at(&pin.second));
        [b[0] - a[0], b[1] - a[1]]
    }

    /// A direction of the world in the frame of a pin's first body.
    pub fn in_first(&self, pin: usize, direction: [f64; 2]) -> [f64; 2] {
        match &self.pins[pin].first {
            None => direction,
            Some(side) => {
                let [c, s] = self.places[side.body].direction;
                rotate(direction, [c, -s])
            }
        }
    }

    /// Largest rate of rate at which a pin would open if its bodies went straight on, in m/s².
    pub fn opening(&self, velocities: &[Twist]) -> f64 {
        (0..self.pins.len()).map(|pin| self.centripetal(velocities, pin)).fold(0.0, |most, [x, y]| most.max(x.hypot(y)))
    }

    /// Makes velocities keep the joints, with the smallest change in the metric of the masses.
    pub fn project(&mut self, velocities: &mut [Twist]) {
        self.multipliers.fill(0.0);
        self.correct(velocities);
    }

    /// Accelerations M⁻¹ (f + Jᵀ λ) at given velocities, with J a = −J̇ v.
    pub fn accelerations(&mut self, forces: &[Twist], velocities: &[Twist], out: &mut [Twist]) {
        for pin in 0..self.pins.len() {
            let [x, y] = self.centripetal(velocities, pin);
            (self.multipliers[2 * pin], self.multipliers[2 * pin + 1]) = (x, y);
        }
        self.accelerate(forces, out);
    }

    /// The accelerations that rapier will make of the same forces in a step from rest of `dt`, given how far open it finds
    /// each pin: J a = −2 open/dt², so that half a step of it closes them.
    pub fn accelerations_closing(&mut self, forces: &[Twist], open: &[[f64; 2]], dt: f64, out: &mut [Twist]) {
        for (pin, [x, y]) in open.iter().enumerate() {
            let scale = -2.0 / (dt * dt);
            (self.multipliers[2 * pin], self.multipliers[2 * pin + 1]) = (scale * x, scale * y);
        }
        self.accelerate(forces, out);
    }

    fn accelerate(&mut self, forces: &[Twist], out: &mut [Twist]) {
        for ((a, f), inertia) in out.iter_mut().zip(forces).zip(&self.inertias) {
            *a = [f[0] * inertia.inverse_mass, f[1] * inertia.inverse_mass, f[2] * inertia.inverse_inertia];
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
        for (p, pin) in self.pins.iter().enumerate() {
            for (side, sign) in sides(pin) {
                let [x, y, w] = velocities[side.body];
                let turn = perp(side.arm);
                self.multipliers[2 * p] -= sign * (x + w * turn[0]);
                self.multipliers[2 * p + 1] -= sign * (y + w * turn[1]);
            }
        }
        dense::solve_factorised(&self.factor, &self.first, &mut self.multipliers);
        for (p, pin) in self.pins.iter().enumerate() {
            let impulse = [self.multipliers[2 * p], self.multipliers[2 * p + 1]];
            for (side, sign) in sides(pin) {
                let inertia = &self.inertias[side.body];
                let v = &mut velocities[side.body];
                v[0] += sign * inertia.inverse_mass * impulse[0];
                v[1] += sign * inertia.inverse_mass * impulse[1];
                v[2] += sign * inertia.inverse_inertia * cross(side.arm, impulse);
            }
        }
    }
}

/// Both sides of a pin with the sign of their velocity in the opening rate.
fn sides(pin: &Pin) -> impl Iterator<Item = (&Side, f64)> {
    pin.first.iter().map(|side| (side, -1.0)).chain(std::iter::once((&pin.second, 1.0)))
}

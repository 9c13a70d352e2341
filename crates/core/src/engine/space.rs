//! Contact space: the few unknowns in which contact is solved, and how they respond to impulses.

use super::linkage::{Linkage, Place, Twist};
use super::plan::Plan;
use super::touch::{RESTING, Row, Touch, elsewhere};
use super::world::World;
use crate::numeric::elementary::sin_cos;

/// One touch in contact space.
#[derive(Clone, Copy, Debug)]
pub struct Site {
    pub touch: Touch,
    /// Index of the normal row, and of the tangent row behind it.
    pub normal: usize,
    pub tangent: Option<usize>,
    /// σ of its bristle at the step's start.
    pub memory: f64,
}

/// W and the free motion of every row, for one step: all of it frozen at the step's start.
#[derive(Clone, Debug, Default)]
pub struct Space {
    pub sites: Vec<Site>,
    pub rows: Vec<Row>,
    /// Contact-space inverse inertia, joints included, row by row: rate of row i per unit impulse along row j.
    pub w: Vec<f64>,
    /// Acceleration of every row without contact.
    pub free: Vec<f64>,
    /// Rate of every row at the start of the step.
    pub rate: Vec<f64>,
    /// Rates that move a gap by its last digits within the step: a finer one is rounding.
    pub finest: Vec<f64>,
    /// Velocity response M⁻¹ (c + Jᵀ λ) to a unit impulse along each row, body by body.
    response: Vec<Twist>,
    places: Vec<Place>,
}

impl Space {
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Takes in the touches that may press within `dt`, judged by gap, rate and acceleration with a margin.
    #[allow(clippy::too_many_arguments)]
    pub fn assemble(
        &mut self,
        world: &World,
        plan: &Plan,
        linkage: &mut Linkage,
        (touches, memories): (&[Touch], &[f64]),
        velocities: &[Twist],
        accelerations: &[Twist],
        dt: f64,
    ) {
        self.sites.clear();
        self.rows.clear();
        for touch in touches.iter().filter(|touch| touch.governed) {
            let (rate, free) = (touch.normal_row.rate(velocities), touch.normal_row.rate(accelerations));
            if touch.gap > SAFETY * dt * (rate.abs() + dt * free.abs()) {
                continue;
            }
            let normal = self.rows.len();
            self.rows.push(touch.normal_row);
            let tangent = touch.has_tangent().then(|| {
                self.rows.push(touch.slip_row);
                normal + 1
            });
            let memory = memories.get(touch.index).copied().unwrap_or(0.0);
            self.sites.push(Site { touch: *touch, normal, tangent, memory });
        }
        if self.rows.is_empty() {
            return;
        }
        self.finest.clear();
        for site in &self.sites {
            self.finest.extend(std::iter::once(site.normal).chain(site.tangent).map(|_| site.touch.rounding / dt));
        }
        self.rate.clear();
        self.rate.extend(self.rows.iter().map(|row| row.rate(velocities)));
        self.free.clear();
        self.free.extend(self.rows.iter().map(|row| row.rate(accelerations)));
        for site in self.sites.iter().filter(|site| !site.touch.has_gap()) {
            let [rate, acceleration] = site.touch.course;
            (self.rate[site.normal], self.free[site.normal]) = (rate, acceleration);
        }
        self.add_curvature(world, plan, linkage, velocities, dt);

        respond(&self.rows, linkage, velocities.len(), &mut self.response, &mut self.w);
    }

    /// Surfaces curve and normals turn as bodies move: the gap's second derivative, and the slip's first, are not the rows'
    /// accelerations alone. The rest is read off the gap and the slip that the present velocities lead to. Accelerations
    /// stay out of it: a contact that holds its bodies does not let them get there.
    fn add_curvature(&mut self, world: &World, plan: &Plan, linkage: &Linkage, velocities: &[Twist], dt: f64) {
        // Long enough that the difference is not rounding, short enough that it stays local.
        let ahead = dt.max(SHORTEST_LOOK_S);
        self.places.clear();
        for (place, v) in linkage.places.iter().zip(velocities) {
            let angle = place.angle + ahead * v[2];
            let (sin, cos) = sin_cos(angle);
            let com = [place.com[0] + ahead * v[0], place.com[1] + ahead * v[1]];
            self.places.push(Place { com, direction: [cos, sin], angle });
        }
        for site in self.sites.iter().filter(|site| site.touch.is_between_surfaces()) {
            let (gap, slip_row) = elsewhere(&site.touch, world, plan, &self.places);
            let straight = site.touch.gap + ahead * self.rate[site.normal];
            let bent = gap - straight;
            // Of surfaces that just touch, and stay so, the gap ahead is rounding.
            if site.touch.gap != 0.0 || bent.abs() > site.touch.rounding {
                self.free[site.normal] += 2.0 * bent / (ahead * ahead);
            }
            if let Some(tangent) = site.tangent {
                self.free[tangent] += (slip_row.rate(velocities) - self.rate[tangent]) / ahead;
            }
        }
    }

    /// Whether the surfaces of a site close at the start of the step, or are at rest there and about to.
    pub fn closes(&self, site: &Site) -> bool {
        let rate = self.rate[site.normal];
        rate < -RESTING || (rate <= RESTING && self.free[site.normal] < 0.0)
    }

    /// Adds what impulses along all rows do to every body, reactions of the joints included, as generalised impulses.
    pub fn add_impulses(&self, linkage: &Linkage, along: &[f64], out: &mut [Twist]) {
        let bodies = out.len();
        for (j, size) in along.iter().enumerate().filter(|(_, size)| **size != 0.0) {
            let response = &self.response[j * bodies..(j + 1) * bodies];
            for ((impulse, v), inertia) in out.iter_mut().zip(response).zip(&linkage.inertias) {
                impulse[0] += size * inertia.mass * v[0];
                impulse[1] += size * inertia.mass * v[1];
                impulse[2] += size * inertia.inertia * v[2];
            }
        }
    }
}

/// Velocity response to a unit impulse along each row, body by body, and with it W row by row.
pub fn respond(rows: &[Row], linkage: &mut Linkage, bodies: usize, response: &mut Vec<Twist>, w: &mut Vec<f64>) {
    let count = rows.len();
    response.clear();
    response.resize(count * bodies, [0.0; 3]);
    w.clear();
    w.resize(count * count, 0.0);
    for (j, response) in response.chunks_exact_mut(bodies).enumerate() {
        rows[j].add_to(response, 1.0);
        linkage.respond(response);
        for (i, row) in rows.iter().enumerate() {
            w[i * count + j] = row.rate(response);
        }
    }
}

/// A touch is taken in when its gap is below this many times what it closes freely in a step.
const SAFETY: f64 = 1.5;
const SHORTEST_LOOK_S: f64 = 1e-7;

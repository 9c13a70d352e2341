//! Contact within one step of the engine: ġ = u_n, u̇ = b + W F(g, u), integrated with W and b frozen.
//!
//! SDIRK2 (Alexander 1977, γ = 1 − 1/√2: two stages, second order, L-stable) with steps chosen from its embedded
//! first-order solution; flight up to the next touch-down in closed form. What comes out are impulses along the rows,
//! split so that the engine's leapfrog is centred: the *early* part moves the bodies within this step, the *late* part
//! is felt from the next one on. With Q = ∫₀ᵈᵗ (dt − s) F ds: early = Q/dt, late = ∫F ds − Q/dt.

use super::implicit::{NotConverged, Stage, Workspace};
use super::space::{Site, Space};
use super::touch::ROUNDING;
use crate::law::{friction_range, normal_force};
use crate::numeric::elementary::{exp, hypot};
use crate::scene::Stepping;

/// Sub-steps are as long as the error of their first-order solution allows, relative to the speed at each site. At 3e-3
/// undamped rebounds were off by 4e-3 rad whatever was asked for; 2e-4 costs a closing of design 95 a tenth of its time.
const RELATIVE_TOLERANCE: f64 = 2e-4;
/// Finer is idle where a long step has frozen the geometry: that goes wrong by hundreds of radians per second.
const RELATIVE_TOLERANCE_PER_S: f64 = 20.0;
const COARSEST_RELATIVE_TOLERANCE: f64 = 0.03;
/// …or absolute, in m/s or rad/s, where it creeps.
const ABSOLUTE_TOLERANCE: f64 = 1e-5;
/// …and of slip no more than this part of the narrowest range of the friction law, within which μ goes from one end to the
/// other.
const SLIP_TOLERANCE: f64 = 0.03;
/// The same where steps of a given length ask for no accuracy: their frozen geometry is worth no finer ones.
const FIXED: Tolerance = Tolerance { relative: 3e-3, relative_per_s: 300.0, absolute: 1e-5, slip: SLIP_TOLERANCE };
/// The tolerance of steps, in m, for which these are meant: the default.
const USUAL_TOLERANCE_M: f64 = 1e-7;
/// However coarse the steps, slip keeps to its range of the friction law by this part of it.
const COARSEST_SLIP_TOLERANCE: f64 = 0.1;
/// By this part of the narrowest range a sub-step may go over the end of one: there μ has moved
/// by three hundredths of the range, with a slope that starts at zero.
const BEYOND_RANGE: f64 = 0.1;
/// Part of the damper's transition that a first sub-step may cross.
const FIRST_CROSSING: f64 = 0.05;
/// Friction, N, that a bristle may always hold as far as errors go.
const BRISTLE_FLOOR: f64 = 1e-3;
const GROWTH: f64 = 4.0;
/// Sub-steps one step may take before the contact counts as unsolved.
const MAX_SUBSTEPS: u32 = 100_000;
const SMALLEST_FRACTION: f64 = 1e-14;

/// SDIRK2.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// Weights of the stage forces in the double integral over a sub-step: Σᵢ bᵢ aᵢⱼ with b = (1 − γ, γ).
const DOUBLE: [f64; 2] = [2.0 * GAMMA * (1.0 - GAMMA), GAMMA * GAMMA];

/// A change of one site within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Time after the start of the step.
    pub after_s: f64,
    /// Index of the site in the contact space.
    pub site: usize,
    pub kind: ChangeKind,
    /// Closing rate, and the normal impulse of this step up to here.
    pub closing: f64,
    pub impulse: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangeKind {
    Meets,
    Parts,
    Presses,
    LetsGo,
    /// A bristle that presses has come to the end of its cone, or is within it again.
    Slips,
    Sticks,
}

/// One site at an instant within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Time after the start of the step.
    pub after_s: f64,
    pub gap: f64,
    pub gap_rate: f64,
    pub slip: f64,
    pub normal: f64,
    pub tangential: f64,
    /// Normal impulse of this step up to here.
    pub impulse: f64,
}

/// What contact did in one step.
#[derive(Clone, Debug, Default)]
pub struct Contact {
    /// Impulses along each row.
    pub early: Vec<f64>,
    pub late: Vec<f64>,
    /// Forces at the end, gaps (per site) and rates there.
    pub force: Vec<f64>,
    pub gap: Vec<f64>,
    pub rate: Vec<f64>,
    /// Memories of bristles there, per site.
    pub memory: Vec<f64>,
    /// Where the normal force of each site is largest, and where its penetration.
    pub peak: Vec<Moment>,
    pub deepest: Vec<Moment>,
    /// Work on the bodies: of contacts and holds, and of motors.
    pub work: f64,
    pub motor_work: f64,
    pub changes: Vec<Change>,
    pub substeps: u32,
    pub iterations: u32,
    /// Worst residual is below the certificate by construction; this counts sub-steps repeated to get there.
    pub repeated: u32,
    /// How finely sub-steps are to be taken.
    pub tolerance: Tolerance,
    work_space: Workspace,
    buffers: Buffers,
}

#[derive(Clone, Debug, Default)]
struct Buffers {
    total: Vec<f64>,
    double: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
    first_force: Vec<f64>,
    base_rate: Vec<f64>,
    base_gap: Vec<f64>,
    base_memory: Vec<f64>,
    error: Vec<f64>,
    touching: Vec<bool>,
    pressing: Vec<bool>,
    slipping: Vec<bool>,
}

/// Errors of rates that one sub-step may make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    relative: f64,
    relative_per_s: f64,
    absolute: f64,
    slip: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        FIXED
    }
}

impl Tolerance {
    /// What a run asks for: errors of sub-steps fall in proportion to its tolerance.
    pub fn of(stepping: Stepping) -> Self {
        let Stepping::Adaptive { tolerance_m, .. } = stepping else { return FIXED };
        let part = tolerance_m / USUAL_TOLERANCE_M;
        Self {
            relative: RELATIVE_TOLERANCE * part,
            relative_per_s: RELATIVE_TOLERANCE_PER_S * part,
            absolute: ABSOLUTE_TOLERANCE * part.min(1.0),
            slip: (SLIP_TOLERANCE * part).min(COARSEST_SLIP_TOLERANCE),
        }
    }

    /// In a long step, which has frozen the geometry, finer is idle.
    fn within(self, dt: f64) -> Self {
        let relative = (self.relative_per_s * dt).max(self.relative).min(COARSEST_RELATIVE_TOLERANCE);
        Self { relative, ..self }
    }
}

/// Contact could not be solved.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Unsolved {
    #[error("the contact solve did not converge (relative residual {residual:.1e} at sub-steps of {h_s:.1e} s)")]
    NotConverged { residual: f64, h_s: f64 },
    #[error("contact needs more than {MAX_SUBSTEPS} sub-steps within one step of {dt_s:.1e} s: take smaller steps")]
    Budget { dt_s: f64 },
    #[error("the contact solve was told to stop")]
    Stopped,
}

impl Contact {
    /// Integrates contact over `dt`.
    pub fn solve(&mut self, space: &Space, dt: f64) -> Result<(), Unsolved> {
        self.solve_while(space, dt, &|| true)
    }

    /// The same for as long as it may `go_on`: a step of many contacts can take minutes.
    pub fn solve_while(&mut self, space: &Space, dt: f64, go_on: &dyn Fn() -> bool) -> Result<(), Unsolved> {
        self.begin(space);
        let (mut now, mut h) = (0.0, dt);
        let tolerance = self.tolerance.within(dt);
        while now < dt {
            let left = dt - now;
            if left <= SMALLEST_FRACTION * dt {
                break;
            }
            let flight = self.until_touch(space, left);
            if !self.buffers.touching.contains(&true) && flight > 0.0 {
                self.fly(space, flight);
                now += flight;
                self.meet(space, now);
                h = self.first_crossing(space, dt);
                continue;
            }
            // Another site may touch on the way: end there.
            let ahead = if flight > SMALLEST_FRACTION * dt { flight } else { left };
            h = h.min(ahead).min(left);
            match self.substep(space, h, left, tolerance) {
                Ok(error) => {
                    let ratio = (1.0 / error.max(1e-300)).sqrt();
                    if error > 1.0 && h > SMALLEST_FRACTION * dt {
                        self.repeated += 1;
                        h *= (0.9 * ratio).clamp(0.1, 0.7);
                        continue;
                    }
                    if let Some(part) = self.leaves_range(space).filter(|_| h > SMALLEST_FRACTION * dt) {
                        self.repeated += 1;
                        h *= part;
                        continue;
                    }
                    self.accept(space, now, h, left);
                    now += h;
                    if self.look(space, now) {
                        h = h.min(self.first_crossing(space, dt));
                    } else {
                        h *= (0.9 * ratio).clamp(0.3, GROWTH);
                    }
                }
                Err(failed) => {
                    self.repeated += 1;
                    h *= 0.25;
                    if h < SMALLEST_FRACTION * dt {
                        return Err(Unsolved::NotConverged { residual: failed.residual, h_s: h });
                    }
                }
            }
            if self.substeps > MAX_SUBSTEPS {
                return Err(Unsolved::Budget { dt_s: dt });
            }
            if !go_on() {
                return Err(Unsolved::Stopped);
            }
        }
        let buffers = &self.buffers;
        for i in 0..space.len() {
            self.early[i] = buffers.double[i] / dt;
            self.late[i] = buffers.total[i] - self.early[i];
        }
        Ok(())
    }

    /// Whether the bristle of a site slips at the end of the step; `None` where it has none or nothing presses.
    pub fn slips(&self, site: usize, space: &Space) -> Option<bool> {
        let at = &space.sites[site];
        let holds = at.touch.has_gap() && at.touch.bristle().is_some() && self.force[at.normal] > 0.0;
        if holds { self.buffers.slipping.get(site).copied() } else { None }
    }

    fn begin(&mut self, space: &Space) {
        let rows = space.len();
        let Buffers { total, double, first, second, first_force, base_rate, error, .. } = &mut self.buffers;
        let own = [&mut self.early, &mut self.late, &mut self.force];
        for list in own.into_iter().chain([total, double, first, second, first_force, base_rate, error]) {
            list.clear();
            list.resize(rows, 0.0);
        }
        self.work_space.resize(rows, space.sites.len());
        self.memory.clear();
        self.memory.extend(space.sites.iter().map(|site| site.memory));
        self.buffers.base_memory.clear();
        self.buffers.base_memory.resize(space.sites.len(), 0.0);
        self.rate.clear();
        self.rate.extend_from_slice(&space.rate);
        self.gap.clear();
        self.gap.extend(space.sites.iter().map(|site| site.touch.gap));
        self.buffers.base_gap.clear();
        self.buffers.base_gap.resize(space.sites.len(), 0.0);
        for list in [&mut self.peak, &mut self.deepest] {
            list.clear();
            list.resize(space.sites.len(), Moment::default());
        }
        self.changes.clear();
        (self.work, self.motor_work) = (0.0, 0.0);
        (self.substeps, self.iterations, self.repeated) = (0, 0, 0);
        self.buffers.touching.clear();
        self.buffers.touching.extend(self.gap.iter().map(|gap| *gap <= 0.0));
        self.buffers.pressing.clear();
        self.buffers.slipping.clear();
        for site in &space.sites {
            let force = normal_force(&site.touch.law, -site.touch.gap, -space.rate[site.normal]).force;
            self.force[site.normal] = force;
            self.buffers.pressing.push(force > 0.0);
            self.buffers.slipping.push(force > 0.0 && slips(site, space, force));
        }
    }

    /// Time until the first site that is apart touches at its present rate and acceleration; `left` if none does.
    fn until_touch(&self, space: &Space, left: f64) -> f64 {
        let rows = space.len();
        let mut soonest = left;
        for (index, site) in space.sites.iter().enumerate() {
            if self.buffers.touching[index] {
                continue;
            }
            let n = site.normal;
            let pushed: f64 = (0..rows).map(|j| space.w[n * rows + j] * self.force[j]).sum();
            soonest = soonest.min(time_to_zero(self.gap[index], self.rate[n], space.free[n] + pushed));
        }
        soonest
    }

    /// Motion without any contact.
    fn fly(&mut self, space: &Space, time: f64) {
        for (gap, site) in self.gap.iter_mut().zip(&space.sites) {
            *gap += time * (self.rate[site.normal] + 0.5 * time * space.free[site.normal]);
        }
        for (rate, free) in self.rate.iter_mut().zip(&space.free) {
            *rate += time * free;
        }
        for (memory, site) in self.memory.iter_mut().zip(&space.sites) {
            *memory *= site.touch.bristle().map_or(1.0, |bristle| exp(-time * bristle.rate()));
        }
    }

    /// Marks the sites that a flight has brought to touch: those whose gap is rounding.
    fn meet(&mut self, space: &Space, now: f64) {
        for (index, site) in space.sites.iter().enumerate() {
            let scale = site.touch.gap.abs().max(site.touch.law.transition_m * 1e-9);
            if !self.buffers.touching[index] && self.gap[index] <= 1e-9 * scale && self.rate[site.normal] < 0.0 {
                self.gap[index] = self.gap[index].min(0.0);
                self.note(space, index, now, ChangeKind::Meets);
                self.buffers.touching[index] = true;
            }
        }
    }

    /// Time in which the fastest closing site crosses the first part of its damper's transition.
    fn first_crossing(&self, space: &Space, dt: f64) -> f64 {
        let mut shortest = dt;
        for (index, site) in space.sites.iter().enumerate() {
            let closing = -self.rate[site.normal];
            if self.buffers.touching[index] && closing > 0.0 {
                shortest = shortest.min(FIRST_CROSSING * site.touch.law.transition_m / closing);
            }
        }
        shortest
    }

    /// Both stages of a sub-step of length h; returns its error in the rates, 1 being what is allowed.
    fn substep(&mut self, space: &Space, h: f64, left: f64, tolerance: Tolerance) -> Result<f64, NotConverged> {
        self.substeps += 1;
        let Buffers { first, second, first_force, base_rate, base_gap, base_memory, error, .. } = &mut self.buffers;
        let implicit = GAMMA * h;

        first.copy_from_slice(&self.rate);
        let stage = Stage { rate: &self.rate, gap: &self.gap, memory: &self.memory, h: implicit };
        self.iterations += self.work_space.solve(space, &stage, first)?;
        first_force.copy_from_slice(&self.work_space.force);

        let ratio = (1.0 - GAMMA) / GAMMA;
        for i in 0..space.len() {
            base_rate[i] = self.rate[i] + ratio * (first[i] - self.rate[i]);
        }
        for (index, site) in space.sites.iter().enumerate() {
            base_gap[index] = self.gap[index] + (1.0 - GAMMA) * h * first[site.normal];
            base_memory[index] = self.memory[index] + ratio * (self.work_space.memory[index] - self.memory[index]);
        }
        second.copy_from_slice(first);
        let stage = Stage { rate: base_rate, gap: base_gap, memory: base_memory, h: implicit };
        self.iterations += self.work_space.solve(space, &stage, second)?;

        // γ h (a₂ − a₁), aᵢ the stages' accelerations; the filter takes out what decays within the sub-step anyway.
        for i in 0..space.len() {
            let (a1, a2) = (first[i] - self.rate[i], second[i] - base_rate[i]);
            error[i] = a2 - a1;
        }
        let size = relative_error(space, (&self.rate, second, &self.work_space.force), error, tolerance);
        if size <= 1.0 && h >= left {
            return Ok(size);
        }
        self.work_space.filter(space, implicit, error);
        Ok(relative_error(space, (&self.rate, second, &self.work_space.force), error, tolerance))
    }

    /// The part of the sub-step after which friction leaves the polynomial it starts on; `None` where it stays there, or goes
    /// over its end by little.
    fn leaves_range(&self, space: &Space) -> Option<f64> {
        let Buffers { second, .. } = &self.buffers;
        let mut part: Option<f64> = None;
        for site in &space.sites {
            let law = site.touch.friction.as_ref().filter(|law| law.bristle.is_none());
            let Some((t, law)) = site.tangent.zip(law) else { continue };
            let (held, holds) = (self.force[site.normal], self.work_space.force[site.normal]);
            if held <= 0.0 && holds <= 0.0 {
                continue;
            }
            let (before, after) = (self.rate[t], second[t]);
            let range = friction_range(law, before);
            let margin = BEYOND_RANGE * law.finest_m_s();
            let room = range.room(law, after);
            if room < -margin {
                // Aim at the middle of the margin, as if slip changed evenly.
                let had = range.room(law, before).max(0.0);
                let share = ((had + 0.5 * margin) / (had - room)).clamp(0.02, 0.9);
                part = Some(part.map_or(share, |part| part.min(share)));
            }
        }
        part
    }

    /// Takes over a sub-step: state, impulses, work and extremes.
    fn accept(&mut self, space: &Space, now: f64, h: f64, left: f64) {
        let Buffers { total, double, first, second, first_force, base_gap, .. } = &mut self.buffers;
        let second_force = &self.work_space.force;
        // ∫ (end − s) F ds over the whole step grows by what has been and by what is coming.
        let rest = left - h;
        for i in 0..space.len() {
            let impulse = h * ((1.0 - GAMMA) * first_force[i] + GAMMA * second_force[i]);
            double[i] += h * h * (DOUBLE[0] * first_force[i] + DOUBLE[1] * second_force[i]) + rest * impulse;
            total[i] += impulse;
        }
        let work = |i: usize| h * ((1.0 - GAMMA) * first_force[i] * first[i] + GAMMA * second_force[i] * second[i]);
        for site in &space.sites {
            let of = if site.touch.drive.is_some() { &mut self.motor_work } else { &mut self.work };
            // The normal of a hold or a motor moves nothing.
            let normal = site.touch.has_gap().then_some(site.normal);
            normal.into_iter().chain(site.tangent).for_each(|row| *of += work(row));
        }
        for (index, site) in space.sites.iter().enumerate() {
            let n = site.normal;
            let gap_before = std::mem::replace(&mut self.gap[index], base_gap[index] + GAMMA * h * second[n]);
            let moment = |after_s, gap, rate: &[f64], force: &[f64], impulse| Moment {
                after_s,
                gap,
                gap_rate: rate[n],
                slip: site.tangent.map_or(0.0, |t| rate[t]),
                normal: force[n],
                tangential: site.tangent.map_or(0.0, |t| force[t]),
                impulse,
            };
            let impulse = h * ((1.0 - GAMMA) * first_force[n] + GAMMA * second_force[n]);
            let (peak, deepest) = (&mut self.peak[index], &mut self.deepest[index]);
            if first_force[n] > peak.normal {
                let (implicit, given) = (GAMMA * h, total[n] - impulse + GAMMA * h * first_force[n]);
                *peak = moment(now + implicit, gap_before + implicit * first[n], first, first_force, given);
            }
            let end = moment(now + h, self.gap[index], second, second_force, total[n]);
            if end.normal > peak.normal {
                *peak = end;
            }
            if end.gap < deepest.gap {
                *deepest = end;
            }
        }
        self.memory.copy_from_slice(&self.work_space.memory);
        self.rate.copy_from_slice(second);
        self.force.copy_from_slice(second_force);
    }

    /// Notes what has changed since the last look; true if a site has just met.
    fn look(&mut self, space: &Space, now: f64) -> bool {
        let mut met = false;
        for (index, site) in space.sites.iter().enumerate() {
            let (touching, pressing) = (self.gap[index] <= 0.0, self.force[site.normal] > 0.0);
            let rounding = ROUNDING * site.touch.law.transition_m;
            if !self.buffers.touching[index] && self.gap[index] <= rounding && self.rate[site.normal] < 0.0 {
                self.note(space, index, now, ChangeKind::Meets);
                (self.buffers.touching[index], met) = (true, true);
                continue;
            }
            if site.touch.has_gap() && site.touch.bristle().is_some() {
                let slips = pressing && self.work_space.slips[index];
                if slips != self.buffers.slipping[index] && pressing {
                    self.note(space, index, now, if slips { ChangeKind::Slips } else { ChangeKind::Sticks });
                }
                self.buffers.slipping[index] = slips;
            }
            if pressing != self.buffers.pressing[index] {
                let kind = if pressing { ChangeKind::Presses } else { ChangeKind::LetsGo };
                self.note(space, index, now, kind);
                self.buffers.pressing[index] = pressing;
            }
            if self.buffers.touching[index] && !touching && !pressing {
                self.note(space, index, now, ChangeKind::Parts);
                self.buffers.touching[index] = false;
            }
        }
        met
    }

    fn note(&mut self, space: &Space, site: usize, after_s: f64, kind: ChangeKind) {
        let normal = space.sites[site].normal;
        let (closing, impulse) = (-self.rate[normal], self.buffers.total[normal]);
        self.changes.push(Change { after_s, site, kind, closing, impulse });
    }
}

/// Whether the bristle of a site is at the end of its cone where a step starts, under so much force.
fn slips(site: &Site, space: &Space, force: f64) -> bool {
    let held = site.touch.bristle().and(site.tangent);
    held.is_some_and(|t| site.touch.friction_after([space.rate[t], site.memory, force], 0.0).by_normal != 0.0)
}

/// Largest error of any site's rates, relative to what its speed allows, and, where friction depends on it, what the ranges
/// of its law allow.
fn relative_error(
    space: &Space,
    (from, rate, force): (&[f64], &[f64], &[f64]),
    error: &[f64],
    tolerance: Tolerance,
) -> f64 {
    let of = |site: &Site| {
        let n = site.normal;
        let Some(t) = site.tangent else {
            return error[n].abs() / (tolerance.absolute + tolerance.relative * rate[n].abs());
        };
        // A hold or a motor has no gap whose rate counts.
        let closing = if site.touch.has_gap() { rate[n] } else { 0.0 };
        let allowed = tolerance.absolute + tolerance.relative * hypot(rate[t], closing);
        if let Some(bristle) = site.touch.bristle() {
            let most = site.touch.friction.map_or(0.0, |law| law.mu_static) * force[n] + BRISTLE_FLOOR;
            let held = tolerance.slip * most / bristle.damping_n_s_per_m;
            let sticks = force[t].abs() < most && rate[t].abs() < most / bristle.damping_n_s_per_m;
            let slip_allowed = if sticks { held.min(allowed) } else { allowed };
            return (error[n].abs() / allowed).max(error[t].abs() / slip_allowed);
        }
        let slip = site.touch.friction.filter(|law| from[t].abs().min(rate[t].abs()) <= law.v_dynamic_m_s);
        let slip_allowed = slip.map_or(allowed, |law| allowed.min(tolerance.slip * law.finest_m_s()));
        (error[n].abs() / allowed).max(error[t].abs() / slip_allowed)
    };
    space.sites.iter().map(of).fold(0.0, f64::max)
}

/// Smallest positive time at which gap + rate t + ½ acceleration t² is zero; infinite if none.
pub fn time_to_zero(gap: f64, rate: f64, acceleration: f64) -> f64 {
    if gap <= 0.0 {
        return if rate < 0.0 { 0.0 } else { f64::INFINITY };
    }
    let discriminant = rate * rate - 2.0 * acceleration * gap;
    if discriminant < 0.0 {
        return f64::INFINITY;
    }
    // The root of the smaller time, without cancellation.
    let time = 2.0 * gap / (-rate + discriminant.sqrt());
    if time > 0.0 { time } else { f64::INFINITY }
}

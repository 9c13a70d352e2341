//! Newton's equations of the moving discs, their exact Jacobian, and everything about one state.

use super::pair::{Meeting, Other, PairRates};
use super::{DiscMode, SiteState, branch};
use crate::integrator::{Linearised, Rates, State, System};
use crate::law::{Bristle, ContactLaw, elastic_energy, friction_with_memory, normal_over_gap};
use crate::numeric::plane::{add, perp, scale};
use crate::numeric::{Dual, Real};
use crate::scene::{self, DiscMotion, Partner};

/// Pairs a model may have.
pub const PAIRS: usize = 12;

/// Quadratures carried along: normal impulses of the pairs, work of all contact forces on all discs, work of the drives.
pub const QUADRATURES: usize = PAIRS + 2;

/// What moves one disc.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mover {
    /// 0 for a driven disc; inverse inertia also 0 for one that does not turn.
    pub inverse_mass: f64,
    pub inverse_inertia: f64,
    /// Of kinetic and gravity energy: 0 for a driven disc.
    mass: f64,
    inertia: f64,
    /// Without contact.
    acceleration: [f64; 2],
}

/// The model of a scene with N/3 moving discs, or fewer and a memory for each pair's bristle behind their coordinates, among the rates;
/// M = 2 N is the number of variables its Jacobian is taken in.
#[derive(Clone, Debug)]
pub struct Discs<const N: usize, const M: usize> {
    pub(super) movers: Vec<Mover>,
    pub(super) meetings: Vec<Meeting>,
    pub(super) law: ContactLaw,
    gravity: [f64; 2],
}

/// Energies of one state, in J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DiscEnergies {
    pub kinetic: f64,
    pub gravity: f64,
    pub elastic: f64,
}

/// One pair in one state.
#[derive(Clone, Copy, Debug)]
pub struct PairReading {
    /// δ, its rate, and slip.
    pub delta: f64,
    pub delta_rate: f64,
    pub slip: f64,
    /// Normal force with the clamp, and friction force.
    pub normal_force: f64,
    pub tangential_force: f64,
    /// From the partner to the disc.
    pub normal: [f64; 2],
    /// On the surface of the disc.
    pub point: [f64; 2],
}

impl<const N: usize, const M: usize> Discs<N, M> {
    /// Builds the model; the system has as many moving discs and no more pairs than there is room for.
    pub fn new(system: &scene::System) -> Self {
        let mover = |motion: &DiscMotion| match *motion {
            DiscMotion::Fixed => None,
            DiscMotion::Driven { acceleration_m_s2, .. } => Some(Mover {
                inverse_mass: 0.0,
                inverse_inertia: 0.0,
                mass: 0.0,
                inertia: 0.0,
                acceleration: acceleration_m_s2,
            }),
            DiscMotion::Free { mass_kg, inertia_kg_m2, .. } => Some(Mover {
                inverse_mass: 1.0 / mass_kg,
                inverse_inertia: inertia_kg_m2.map_or(0.0, f64::recip),
                mass: mass_kg,
                inertia: inertia_kg_m2.unwrap_or(0.0),
                acceleration: system.gravity_m_s2,
            }),
        };
        let place = |disc: usize| system.discs[..disc].iter().filter(|disc| disc.motion.moves()).count();
        let meetings = system.pairs().into_iter().map(|pair| Meeting {
            disc: place(pair.disc),
            radius: system.discs[pair.disc].radius_m,
            other: match pair.partner {
                Partner::Disc(other) => {
                    let disc = &system.discs[other];
                    match disc.motion.moves() {
                        true => Other::Moving { disc: place(other), radius: disc.radius_m },
                        false => Other::Fixed { centre: disc.centre_m, radius: disc.radius_m },
                    }
                }
                Partner::HalfPlane => {
                    Other::HalfPlane { level: system.palm.map_or(f64::NEG_INFINITY, |plane| plane.level_m) }
                }
            },
        });
        let model = Self {
            movers: system.discs.iter().filter_map(|disc| mover(&disc.motion)).collect(),
            meetings: meetings.collect(),
            law: system.between_discs.expect("discs that touch by a law"),
            gravity: system.gravity_m_s2,
        };
        let memories = if model.bristle().is_some() { N - 3 * model.movers.len() } else { PAIRS };
        assert!(3 * model.movers.len() <= N && 2 * N == M && model.meetings.len() <= memories.min(PAIRS));
        model
    }

    /// The bristle of every pair.
    fn bristle(&self) -> Option<Bristle> {
        self.law.bristle()
    }

    /// Where the memory of a pair's bristle is among the rates.
    #[inline(always)]
    pub(super) fn memory(&self, pair: usize) -> Option<usize> {
        self.bristle().map(|_| 3 * self.movers.len() + pair)
    }

    /// Coordinates and rates at the start.
    pub fn start(system: &scene::System) -> State<N, QUADRATURES> {
        let mut state = State { q: [0.0; N], v: [0.0; N], z: [0.0; QUADRATURES] };
        for (index, disc) in system.discs.iter().filter(|disc| disc.motion.moves()).enumerate() {
            let (velocity, spin) = match disc.motion {
                DiscMotion::Fixed => continue,
                DiscMotion::Driven { velocity_m_s, spin_rad_s, .. } => (velocity_m_s, spin_rad_s),
                DiscMotion::Free { velocity_m_s, spin_rad_s, .. } => (velocity_m_s, spin_rad_s),
            };
            let [x, y] = disc.centre_m;
            state.q[3 * index..3 * index + 3].copy_from_slice(&[x, y, disc.angle_rad]);
            state.v[3 * index..3 * index + 3].copy_from_slice(&[velocity[0], velocity[1], spin]);
        }
        state
    }

    /// Number of pairs.
    pub fn pairs(&self) -> usize {
        self.meetings.len()
    }

    /// Accelerations and the rates of the quadratures.
    #[inline(always)]
    pub(super) fn accelerations<T: Real>(&self, q: &[T; N], v: &[T; N], mode: &DiscMode) -> ([T; N], [T; QUADRATURES]) {
        let mut a = [T::zero(); N];
        for (index, mover) in self.movers.iter().enumerate() {
            a[3 * index] = T::constant(mover.acceleration[0]);
            a[3 * index + 1] = T::constant(mover.acceleration[1]);
        }
        if let Some(bristle) = self.bristle() {
            let first = 3 * self.movers.len();
            for memory in first..first + self.meetings.len() {
                a[memory] = v[memory] * -bristle.rate();
            }
        }
        let mut quadratures = [T::zero(); QUADRATURES];
        for (index, meeting) in self.meetings.iter().enumerate() {
            if matches!(mode[index], SiteState::Free | SiteState::Released) {
                continue;
            }
            let geometry = meeting.geometry(q);
            let rates = meeting.rates(geometry.normal, v);
            let PairRates { gap_rate, slip, own, other } = rates;
            let law = &self.law;
            let normal = normal_over_gap(|d, rate| branch(&law.normal, mode[index], d, rate), geometry.gap, gap_rate);
            let memory = self.memory(index);
            let friction = |law| friction_with_memory(law, slip, memory.map(|memory| v[memory]), normal);
            let tangential = law.friction.as_ref().map_or(T::zero(), friction);
            if let Some((memory, bristle)) = memory.zip(self.bristle()) {
                a[memory] += -tangential * bristle.driven();
            }
            let force = add(scale(geometry.normal, normal), scale(perp(geometry.normal), tangential));
            let mut push = |disc: usize, sign: f64, radius: f64| {
                let mover = &self.movers[disc];
                a[3 * disc] += force[0] * (sign * mover.inverse_mass);
                a[3 * disc + 1] += force[1] * (sign * mover.inverse_mass);
                // On either side the surface point lies so that friction turns the disc against its sense.
                a[3 * disc + 2] -= tangential * (radius * mover.inverse_inertia);
            };
            push(meeting.disc, 1.0, meeting.radius);
            let power = |rates: [T; 2]| normal * rates[0] + tangential * rates[1];
            quadratures[index] = normal;
            quadratures[PAIRS] += power([gap_rate, slip]);
            if self.movers[meeting.disc].mass == 0.0 {
                quadratures[PAIRS + 1] -= power(own);
            }
            if let Other::Moving { disc, radius } = meeting.other {
                push(disc, -1.0, radius);
                if self.movers[disc].mass == 0.0 {
                    quadratures[PAIRS + 1] -= power(other);
                }
            }
        }
        (a, quadratures)
    }

    /// Everything there is to know of one pair in one state.
    pub fn reading(&self, q: &[f64; N], v: &[f64; N], pair: usize, state: SiteState) -> PairReading {
        let meeting = &self.meetings[pair];
        let geometry = meeting.geometry(q);
        let rates = meeting.rates(geometry.normal, v);
        let (delta, delta_rate) = (-geometry.gap, -rates.gap_rate);
        let normal_force = branch(&self.law.normal, state, delta, delta_rate).force.max(0.0);
        let memory = self.memory(pair).map(|memory| v[memory]);
        let friction = |law| friction_with_memory(law, rates.slip, memory, normal_force);
        let tangential_force = self.law.friction.as_ref().map_or(0.0, friction);
        let [x, y] = geometry.normal;
        let disc = 3 * meeting.disc;
        PairReading {
            delta,
            delta_rate,
            slip: rates.slip,
            normal_force,
            tangential_force,
            normal: geometry.normal,
            point: [q[disc] - meeting.radius * x, q[disc + 1] - meeting.radius * y],
        }
    }

    /// Energies of a state.
    pub fn energies(&self, q: &[f64; N], v: &[f64; N]) -> DiscEnergies {
        let mut energies = DiscEnergies::default();
        for ((mover, q), v) in self.movers.iter().zip(q.chunks_exact(3)).zip(v.chunks_exact(3)) {
            energies.kinetic += 0.5 * (mover.mass * (v[0] * v[0] + v[1] * v[1]) + mover.inertia * v[2] * v[2]);
            energies.gravity -= mover.mass * (self.gravity[0] * q[0] + self.gravity[1] * q[1]);
        }
        let elastic = |meeting: &Meeting| elastic_energy(&self.law.normal, -meeting.geometry(q).gap);
        energies.elastic = self.meetings.iter().map(elastic).sum();
        if let Some(bristle) = self.bristle() {
            energies.elastic += v[3 * self.movers.len()..].iter().map(|memory| bristle.energy(*memory)).sum::<f64>();
        }
        energies
    }
}

impl<const N: usize, const M: usize> System<N, QUADRATURES> for Discs<N, M> {
    type Mode = DiscMode;

    #[inline(always)]
    fn rates(&self, _: f64, q: &[f64; N], v: &[f64; N], mode: &DiscMode) -> Rates<N, QUADRATURES> {
        let (a, g) = self.accelerations(q, v, mode);
        Rates { a, g }
    }

    fn linearise(&self, _: f64, q: &[f64; N], v: &[f64; N], mode: &DiscMode) -> Linearised<N, QUADRATURES> {
        let q = std::array::from_fn(|i| Dual::<M>::variable(q[i], i));
        let v = std::array::from_fn(|i| Dual::<M>::variable(v[i], N + i));
        let (a, g) = self.accelerations(&q, &v, mode);
        let by_q = |x: Dual<M>| std::array::from_fn(|j| x.grad[j]);
        let by_v = |x: Dual<M>| std::array::from_fn(|j| x.grad[N + j]);
        Linearised {
            rates: Rates { a: a.map(|x| x.value), g: g.map(|x| x.value) },
            a_q: a.map(by_q),
            a_v: a.map(by_v),
            a_t: [0.0; N],
            g_q: g.map(by_q),
            g_v: g.map(by_v),
            g_t: [0.0; QUADRATURES],
        }
    }
}

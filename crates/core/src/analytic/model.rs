//! The analytic model of one finger: accelerations, their exact Jacobian, and the state of every contact.
//!
//! Coordinates are q_a = (q11, q21). Where friction holds, the rates behind theirs are the memories σ of the bristles of both phalanges: of
//! coordinates that nothing depends on.

use super::contact::Geometry;
use super::finger::{FingerModel, Passive};
use super::mode::SiteState;
use crate::fivebar::dynamics::{Dynamics, Terms, kinetic_energy, solve_mass, terms};
use crate::fivebar::kinematics::{Directions, PassiveRates};
use crate::gripper::Site;
use crate::integrator::{Linearised, Rates, State, System};
use crate::law::{
    Bristle, FrictionLaw, NormalForce, NormalLaw, elastic_energy, friction_force, friction_with_memory, normal_force,
    normal_over_gap, unclamped_normal_force,
};
use crate::numeric::plane::dot;
use crate::numeric::{Dual, Real, each, from_each};
use crate::scene::{self, Actuation, DrivenFinger, Initial, Side, torque};
use crate::shape::{Placed, Support};

/// Quadratures carried along: normal impulses of the three sites, work of all contact forces on the finger, work of the motor.
pub const QUADRATURES: usize = 5;

/// Guards of the three sites: of their normal laws, then of their slips, then of their dampers.
pub const GUARDS: usize = 9;

/// Branches of all sites, in the order of [`Site::ALL`].
pub type FingerMode = super::mode::Mode<3>;

/// Coordinates of a finger.
pub(super) const OWN: usize = 2;

/// Memories of bristles: of the proximal and the distal one.
const MEMORIES: usize = 2;

/// The analytic model of a scene, with everything that does not change in time worked out; of N coordinates, and with W = N + 2 variables
/// that its Jacobian is taken in: q11, q21, and all rates.
#[derive(Clone, Debug)]
pub struct FingerMotion<const N: usize, const W: usize> {
    pub(super) finger: FingerModel,
    pub(super) actuation: Actuation,
    pub(super) object: Option<Placed>,
}

/// That of a scene whose friction has no memory.
pub type Model = FingerMotion<OWN, { 2 * OWN }>;

/// That of a scene whose friction holds: with the memories of the proximal and the distal bristle.
pub type HoldingModel = FingerMotion<{ OWN + MEMORIES }, { 2 * OWN + MEMORIES }>;

/// Energies of one state, in J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    pub kinetic: f64,
    pub gravity: f64,
    pub spring: f64,
    pub elastic: f64,
}

/// Everything about one state.
#[derive(Clone, Copy, Debug)]
pub struct Snapshot {
    pub passive: Passive,
    /// In the order of [`Site::ALL`]; `None` where the scene has no such contact.
    pub sites: [Option<SiteReading>; 3],
    pub energies: Energies,
}

/// One site in one state.
#[derive(Clone, Copy, Debug)]
pub struct SiteReading {
    pub geometry: Geometry<f64>,
    /// δ, its rate, and slip.
    pub delta: f64,
    pub delta_rate: f64,
    pub slip: f64,
    /// Normal force (limit: torque) with the clamp, and friction force.
    pub normal: f64,
    pub tangential: f64,
}

impl<const N: usize, const W: usize> FingerMotion<N, W> {
    /// Whether there are memories of bristles.
    const HOLDS: bool = N > OWN;

    /// Builds the model of a scene; one whose friction holds needs the room for what it remembers.
    pub fn new(system: &scene::System) -> Self {
        assert!(Self::HOLDS == system.holds() && W == OWN + N, "the finger's coordinates, and memories");
        let DrivenFinger { linkage, motor, spring, limit, contact, initial } = system.finger(Side::Right);
        Self {
            finger: FingerModel::new(linkage, (*spring, *limit), *contact, initial, system.gravity_m_s2),
            actuation: motor.actuation.clone(),
            object: system.object().map(|object| object.placed()),
        }
    }

    /// Coordinates and rates at the start.
    pub fn start(system: &scene::System) -> State<N, QUADRATURES> {
        let Initial { q11_rad, q21_rad, qd11_rad_s, qd21_rad_s } = system.finger(Side::Right).initial;
        State { q: spread([q11_rad, q21_rad]), v: spread([qd11_rad_s, qd21_rad_s]), z: [0.0; QUADRATURES] }
    }

    pub fn dynamics(&self) -> &Dynamics {
        &self.finger.dynamics
    }

    /// Where the memory of a site's bristle is among the rates; the joint limit has none.
    #[inline(always)]
    pub(super) fn memory_of(site: Site) -> Option<usize> {
        if Self::HOLDS && site != Site::Limit { Some(OWN + site as usize) } else { None }
    }

    /// The bristle of a site, where friction holds.
    pub(crate) fn bristle(&self, site: Site) -> Option<Bristle> {
        self.finger.friction_law(site).and_then(|friction| friction.bristle)
    }

    /// All bristles, with the places of their memories.
    #[inline(always)]
    fn bristles(&self) -> impl Iterator<Item = (usize, Bristle)> {
        let of = |site| Self::memory_of(site).zip(self.bristle(site));
        Site::ALL.into_iter().filter_map(of)
    }

    /// Friction of a site at these rates; a law without memory asks for none.
    #[inline(always)]
    fn friction<T: Real>(law: &FrictionLaw, site: Site, slip: T, v: &[T; N], normal: T) -> T {
        match Self::memory_of(site) {
            Some(memory) if Self::HOLDS => friction_with_memory(law, slip, Some(v[memory]), normal),
            _ => friction_force(law, slip, normal),
        }
    }

    /// Geometry of one site; `None` where the scene has no such contact.
    #[inline(always)]
    pub(super) fn geometry<T: Real>(
        &self,
        pose: &Directions<T>,
        rates: &PassiveRates<T>,
        site: Site,
    ) -> Option<Geometry<T>> {
        if site == Site::Limit {
            return self.finger.limit.map(|_| self.finger.limit_geometry(pose, rates));
        }
        let Placed { shape, centre_m, angle_rad } = self.object?;
        let centre_m = [T::constant(centre_m[0]), T::constant(centre_m[1])];
        let object = Placed { shape, centre_m, angle_rad: T::constant(angle_rad) };
        Some(self.finger.phalanx(pose, rates, site, &object))
    }

    /// q̈_a and the rates of the memories and of the quadratures (2.24), from the position-dependent terms and the geometry of the sites
    /// that press.
    #[inline(always)]
    fn accelerations<T: Real>(
        &self,
        motor_torque: T,
        terms: &Terms<T>,
        geometry: impl Fn(Site) -> Option<Geometry<T>>,
        mode: &FingerMode,
        v: [T; N],
    ) -> ([T; N], [T; QUADRATURES]) {
        let own = own(&v);
        let mut driven = [T::zero(); MEMORIES];
        if Self::HOLDS {
            self.bristles().for_each(|(memory, bristle)| driven[memory - OWN] = v[memory] * -bristle.rate());
        }
        let mut load = self.finger.load(motor_torque, terms, own);
        let mut quadratures = [T::zero(); QUADRATURES];
        let mut contact_power = T::zero();
        for site in Site::ALL {
            let index = site as usize;
            if !mode[index].presses() {
                continue;
            }
            let (Some(geometry), Some(law)) = (geometry(site), self.finger.normal_law(site)) else { continue };
            let gap_rate = dot(geometry.normal_row, own);
            let normal = normal_over_gap(|d, rate| branch(law, mode[index], d, rate), geometry.gap, gap_rate);
            load[0] += geometry.normal_row[0] * normal;
            load[1] += geometry.normal_row[1] * normal;
            contact_power += normal * gap_rate;
            quadratures[index] = normal;
            if let Some(friction) = self.finger.friction_law(site) {
                let slip = dot(geometry.tangent_row, own);
                let tangential = Self::friction(friction, site, slip, &v, normal);
                load[0] += geometry.tangent_row[0] * tangential;
                load[1] += geometry.tangent_row[1] * tangential;
                contact_power += tangential * slip;
                if let Some((memory, bristle)) = Self::memory_of(site).zip(friction.bristle) {
                    driven[memory - OWN] += -tangential * bristle.driven();
                }
            }
        }
        quadratures[3] = contact_power;
        quadratures[4] = motor_torque * own[0];
        let turning = solve_mass(&terms.mass, load);
        let mut all = [T::zero(); N];
        all[..OWN].copy_from_slice(&turning);
        all[OWN..].copy_from_slice(&driven[..N - OWN]);
        (all, quadratures)
    }

    /// Everything there is to know of one site in one state; `None` where the scene has no such contact.
    pub fn reading(&self, q: [f64; N], v: [f64; N], site: Site, state: SiteState) -> Option<SiteReading> {
        let (pose, rates) = self.finger.place(own(&q));
        self.reading_at(&pose, &rates, &v, site, state)
    }

    fn reading_at(
        &self,
        pose: &Directions<f64>,
        rates: &PassiveRates<f64>,
        v: &[f64; N],
        site: Site,
        state: SiteState,
    ) -> Option<SiteReading> {
        let geometry = self.geometry(pose, rates, site)?;
        let law = self.finger.normal_law(site)?;
        let (delta, delta_rate) = (-geometry.gap, -dot(geometry.normal_row, own(v)));
        let slip = dot(geometry.tangent_row, own(v));
        let normal = branch(law, state, delta, delta_rate).force.max(0.0);
        let friction = |law| Self::friction(law, site, slip, v, normal);
        let tangential = self.finger.friction_law(site).map_or(0.0, friction);
        Some(SiteReading { geometry, delta, delta_rate, slip, normal, tangential })
    }

    /// Passive joints, contacts and energies of a state, all from one evaluation of the model.
    pub fn snapshot(&self, q: [f64; N], v: [f64; N], mode: &FingerMode) -> Snapshot {
        self.snapshot_of(q, v, mode, (true, true))
    }

    /// The same, of which the passive joints and the energies may be left out: they are zeros then.
    pub(crate) fn snapshot_of(
        &self,
        q: [f64; N],
        v: [f64; N],
        mode: &FingerMode,
        (passive, energies): (bool, bool),
    ) -> Snapshot {
        let (pose, rates) = self.finger.place(own(&q));
        let sites = Site::ALL.map(|site| self.reading_at(&pose, &rates, &v, site, mode[site as usize]));
        let joints = || self.finger.passive(&pose, &rates, own(&q), own(&v));
        let passive = if passive { joints() } else { Passive::default() };
        let energies = if energies { self.energies(v, &pose, &sites) } else { Energies::default() };
        Snapshot { passive, sites, energies }
    }

    /// Energies of a state whose contacts are read.
    fn energies(&self, v: [f64; N], pose: &Directions<f64>, sites: &[Option<SiteReading>; 3]) -> Energies {
        let springs = Site::ALL.map(|site| match (self.finger.normal_law(site), &sites[site as usize]) {
            (Some(law), Some(reading)) => elastic_energy(law, reading.delta),
            _ => 0.0,
        });
        let mut elastic = springs.iter().sum();
        if Self::HOLDS {
            elastic += self.bristles().map(|(memory, bristle)| bristle.energy(v[memory])).sum::<f64>();
        }
        let [gravity, spring] = self.finger.potential(pose);
        let kinetic = kinetic_energy(&terms(&self.finger.dynamics, *pose).mass, own(&v));
        Energies { kinetic, gravity, spring, elastic }
    }

    /// Motor torque at time `t`, in N·m.
    pub fn motor_torque(&self, t: f64) -> f64 {
        torque(&self.actuation, t).0
    }
}

/// A finger's own of all coordinates, or of their rates.
#[inline(always)]
pub(super) fn own<T: Copy, const N: usize>(all: &[T; N]) -> [T; OWN] {
    [all[0], all[1]]
}

/// A finger's own among all, with zeros behind.
#[inline(always)]
pub(super) fn spread<const N: usize>(own: [f64; OWN]) -> [f64; N] {
    let mut all = [0.0; N];
    all[..OWN].copy_from_slice(&own);
    all
}

/// Normal law on the branch of `state`.
#[inline(always)]
pub(super) fn branch(law: &NormalLaw, state: SiteState, delta: f64, rate: f64) -> NormalForce {
    match state {
        SiteState::Free | SiteState::Released => NormalForce::default(),
        SiteState::Active => unclamped_normal_force(law, delta, rate),
        SiteState::Natural => normal_force(law, delta, rate),
    }
}

impl<const N: usize, const W: usize> System<N, QUADRATURES> for FingerMotion<N, W> {
    type Mode = FingerMode;

    #[inline(always)]
    fn rates(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &FingerMode) -> Rates<N, QUADRATURES> {
        let terms = self.finger.terms(own(q));
        let torque = torque(&self.actuation, t).0;
        let geometry = |site| self.geometry(&terms.pose, &terms.rates, site);
        let (a, g) = self.accelerations(torque, &terms, geometry, mode, *v);
        Rates { a, g }
    }

    #[inline(always)]
    fn linearise(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &FingerMode) -> Linearised<N, QUADRATURES> {
        // Positions first, with two derivatives; rates only then, with all.
        let narrow = self.finger.terms([Dual::<OWN>::variable(q[0], 0), Dual::variable(q[1], 1)]);
        let wide = narrow.widen();
        let rate = each(|i| Dual::<W>::variable(v[i], OWN + i));
        let (torque, slope) = torque(&self.actuation, t);
        let geometry = |site| self.geometry(&narrow.pose, &narrow.rates, site).map(Geometry::widen);
        let (a, g) = self.accelerations(Dual::constant(torque), &wide, geometry, mode, rate);
        let mass = from_each(narrow.mass, |m| m.value);
        Linearised {
            rates: Rates { a: from_each(a, |x| x.value), g: from_each(g, |x| x.value) },
            a_q: by_q(&a),
            a_v: by_v(&a),
            a_t: spread(solve_mass(&mass, [slope, 0.0])),
            g_q: by_q(&g),
            g_v: by_v(&g),
            g_t: [0.0, 0.0, 0.0, 0.0, slope * v[0]],
        }
    }
}

/// Derivatives of R numbers by N positions, of which a finger's own alone have any.
#[inline(always)]
fn by_q<const N: usize, const W: usize, const R: usize>(of: &[Dual<W>; R]) -> [[f64; N]; R] {
    let mut rows = [[0.0; N]; R];
    for (row, x) in rows.iter_mut().zip(of) {
        row[..OWN].copy_from_slice(&x.grad[..OWN]);
    }
    rows
}

/// By N rates.
#[inline(always)]
fn by_v<const N: usize, const W: usize, const R: usize>(of: &[Dual<W>; R]) -> [[f64; N]; R] {
    let mut rows = [[0.0; N]; R];
    for (row, x) in rows.iter_mut().zip(of) {
        row.copy_from_slice(&x.grad[OWN..]);
    }
    rows
}

impl Geometry<Dual<2>> {
    #[inline(always)]
    fn widen<const W: usize>(self) -> Geometry<Dual<W>> {
        Geometry {
            gap: self.gap.among(),
            normal_row: from_each(self.normal_row, Dual::among),
            tangent_row: from_each(self.tangent_row, Dual::among),
            normal: from_each(self.normal, Dual::among),
            point: from_each(self.point, Dual::among),
            support: Support { distance: self.support.distance.among(), slope: self.support.slope.among() },
        }
    }
}

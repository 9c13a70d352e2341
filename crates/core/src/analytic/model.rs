//! The analytic model of one scene: accelerations, their exact Jacobian, and the state of every contact.

use super::contact::Geometry;
use super::finger::{FingerModel, Passive};
use super::mode::SiteState;
use crate::fivebar::dynamics::{Dynamics, Terms, kinetic_energy, solve_mass};
use crate::fivebar::kinematics::{Directions, PassiveRates};
use crate::gripper::Site;
use crate::integrator::{Linearised, Rates, System};
use crate::law::{
    NormalForce, NormalLaw, elastic_energy, friction_force, normal_force, normal_over_gap, unclamped_normal_force,
};
use crate::numeric::plane::dot;
use crate::numeric::{Dual, Real};
use crate::scene::{Actuation, Disc, Scene, torque};

/// Quadratures carried along: normal impulses of the three sites, work of all contact forces on the finger, work of the motor.
pub const QUADRATURES: usize = 5;

/// Guards of the three sites: of their normal laws, then of their slips, then of their dampers.
pub const GUARDS: usize = 9;

/// Branches of all sites, in the order of [`Site::ALL`].
pub type Mode = super::mode::Mode<3>;

/// The analytic model of a scene, with everything that does not change in time worked out.
#[derive(Clone, Debug)]
pub struct Model {
    pub(super) finger: FingerModel,
    pub(super) actuation: Actuation,
    pub(super) object: Option<Disc>,
}

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

impl Model {
    /// Builds the model of a scene.
    pub fn new(scene: &Scene) -> Self {
        let Scene { finger, spring, limit, contact, initial, gravity_m_s2, .. } = scene;
        Self {
            finger: FingerModel::new(finger, (*spring, *limit), *contact, initial, *gravity_m_s2),
            actuation: scene.actuation.clone(),
            object: scene.object,
        }
    }

    pub fn dynamics(&self) -> &Dynamics {
        &self.finger.dynamics
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
        let disc = self.object?;
        Some(self.finger.phalanx(pose, rates, site, (disc.centre_m.map(T::constant), disc.radius_m)))
    }

    /// q̈_a and the rates of the quadratures (2.24), from the position-dependent terms and the geometry of the sites that press.
    #[inline(always)]
    fn accelerations<T: Real>(
        &self,
        motor_torque: T,
        terms: &Terms<T>,
        geometry: impl Fn(Site) -> Option<Geometry<T>>,
        mode: &Mode,
        v: [T; 2],
    ) -> ([T; 2], [T; QUADRATURES]) {
        let mut load = self.finger.load(motor_torque, terms, v);
        let mut quadratures = [T::zero(); QUADRATURES];
        let mut contact_power = T::zero();
        for site in Site::ALL {
            let index = site as usize;
            if !mode[index].presses() {
                continue;
            }
            let (Some(geometry), Some(law)) = (geometry(site), self.finger.normal_law(site)) else { continue };
            let gap_rate = dot(geometry.normal_row, v);
            let normal = normal_over_gap(|d, rate| branch(law, mode[index], d, rate), geometry.gap, gap_rate);
            load[0] += geometry.normal_row[0] * normal;
            load[1] += geometry.normal_row[1] * normal;
            contact_power += normal * gap_rate;
            quadratures[index] = normal;
            if let Some(friction) = self.finger.friction_law(site) {
                let slip = dot(geometry.tangent_row, v);
                let tangential = friction_force(friction, slip, normal);
                load[0] += geometry.tangent_row[0] * tangential;
                load[1] += geometry.tangent_row[1] * tangential;
                contact_power += tangential * slip;
            }
        }
        quadratures[3] = contact_power;
        quadratures[4] = motor_torque * v[0];
        (solve_mass(&terms.mass, load), quadratures)
    }

    /// Everything there is to know of one site in one state; `None` where the scene has no such contact.
    pub fn reading(&self, q: [f64; 2], v: [f64; 2], site: Site, state: SiteState) -> Option<SiteReading> {
        let (pose, rates) = self.finger.place(q);
        self.reading_at(&pose, &rates, v, site, state)
    }

    fn reading_at(
        &self,
        pose: &Directions<f64>,
        rates: &PassiveRates<f64>,
        v: [f64; 2],
        site: Site,
        state: SiteState,
    ) -> Option<SiteReading> {
        let geometry = self.geometry(pose, rates, site)?;
        let law = self.finger.normal_law(site)?;
        let (delta, delta_rate) = (-geometry.gap, -dot(geometry.normal_row, v));
        let slip = dot(geometry.tangent_row, v);
        let normal = branch(law, state, delta, delta_rate).force.max(0.0);
        let tangential = self.finger.friction_law(site).map_or(0.0, |f| friction_force(f, slip, normal));
        Some(SiteReading { geometry, delta, delta_rate, slip, normal, tangential })
    }

    /// Passive joints, contacts and energies of a state, all from one evaluation of the model.
    pub fn snapshot(&self, q: [f64; 2], v: [f64; 2], mode: &Mode) -> Snapshot {
        let terms = self.finger.terms(q);
        let sites = Site::ALL.map(|site| self.reading_at(&terms.pose, &terms.rates, v, site, mode[site as usize]));
        let elastic = Site::ALL.map(|site| match (self.finger.normal_law(site), &sites[site as usize]) {
            (Some(law), Some(reading)) => elastic_energy(law, reading.delta),
            _ => 0.0,
        });
        let [gravity, spring] = self.finger.potential(&terms.pose);
        let energies =
            Energies { kinetic: kinetic_energy(&terms.mass, v), gravity, spring, elastic: elastic.iter().sum() };
        Snapshot { passive: self.finger.passive(&terms.pose, &terms.rates, q, v), sites, energies }
    }

    /// Motor torque at time `t`, in N·m.
    pub fn motor_torque(&self, t: f64) -> f64 {
        torque(&self.actuation, t).0
    }
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

impl System<2, QUADRATURES> for Model {
    type Mode = Mode;

    #[inline(always)]
    fn rates(&self, t: f64, q: &[f64; 2], v: &[f64; 2], mode: &Mode) -> Rates<2, QUADRATURES> {
        let terms = self.finger.terms(*q);
        let torque = torque(&self.actuation, t).0;
        let geometry = |site| self.geometry(&terms.pose, &terms.rates, site);
        let (a, g) = self.accelerations(torque, &terms, geometry, mode, *v);
        Rates { a, g }
    }

    #[inline(always)]
    fn linearise(&self, t: f64, q: &[f64; 2], v: &[f64; 2], mode: &Mode) -> Linearised<2, QUADRATURES> {
        // Positions first, with two derivatives; rates only then, with four.
        let narrow = self.finger.terms([Dual::<2>::variable(q[0], 0), Dual::variable(q[1], 1)]);
        let wide = narrow.widen();
        let rate = [Dual::<4>::variable(v[0], 2), Dual::variable(v[1], 3)];
        let (torque, slope) = torque(&self.actuation, t);
        let geometry = |site| self.geometry(&narrow.pose, &narrow.rates, site).map(Geometry::widen);
        let (a, g) = self.accelerations(Dual::constant(torque), &wide, geometry, mode, rate);
        let mass = narrow.mass.map(|m| m.value);
        Linearised {
            rates: Rates { a: a.map(|x| x.value), g: g.map(|x| x.value) },
            a_q: a.map(|x| [x.grad[0], x.grad[1]]),
            a_v: a.map(|x| [x.grad[2], x.grad[3]]),
            a_t: solve_mass(&mass, [slope, 0.0]),
            g_q: g.map(|x| [x.grad[0], x.grad[1]]),
            g_v: g.map(|x| [x.grad[2], x.grad[3]]),
            g_t: [0.0, 0.0, 0.0, 0.0, slope * v[0]],
        }
    }
}

impl Geometry<Dual<2>> {
    #[inline(always)]
    fn widen(self) -> Geometry<Dual<4>> {
        Geometry {
            gap: self.gap.widen(),
            normal_row: self.normal_row.map(Dual::widen),
            tangent_row: self.tangent_row.map(Dual::widen),
            normal: self.normal.map(Dual::widen),
            point: self.point.map(Dual::widen),
        }
    }
}

impl Directions<Dual<2>> {
    #[inline(always)]
    pub(super) fn widen(&self) -> Directions<Dual<4>> {
        let Directions { e1, e2, e3, e4 } = *self;
        Directions {
            e1: e1.map(Dual::widen),
            e2: e2.map(Dual::widen),
            e3: e3.map(Dual::widen),
            e4: e4.map(Dual::widen),
        }
    }
}

impl PassiveRates<Dual<2>> {
    #[inline(always)]
    pub(super) fn widen(&self) -> PassiveRates<Dual<4>> {
        PassiveRates {
            a3: self.a3.map(Dual::widen),
            a4: self.a4.map(Dual::widen),
            inverse_sine: self.inverse_sine.widen(),
        }
    }
}

impl Terms<Dual<2>> {
    #[inline(always)]
    fn widen(&self) -> Terms<Dual<4>> {
        Terms {
            pose: self.pose.widen(),
            rates: self.rates.widen(),
            mass: self.mass.map(Dual::widen),
            quadratic: self.quadratic.map(|row| row.map(Dual::widen)),
            gravity: self.gravity.map(Dual::widen),
        }
    }
}

//! Turns a node of the engine model into a sample.

use super::{ContactSample, Energy, Instant, Sample, Site};
use crate::engine::{self, L11, L12, L21, L22, Motion, Plan, Touch, Twist, kinetic, potential};
use crate::law::{elastic_energy, friction_force, normal_force};
use crate::numeric::plane::{angle_between, near_turn, opening_angle, rotate};

/// Reads the nodes of a motion.
pub(super) trait EngineReader {
    type Sample: Instant;

    /// The place of contact that a stop or contact of the plan is.
    fn place(&self, plan: &Plan, index: usize) -> usize;

    /// The index of a place among the stops and contacts of the plan; `None` where there is nothing to touch.
    fn index(&self, plan: &Plan, place: usize) -> Option<usize>;

    /// The node, where these are its energies; `impulses` are those of all places since the start.
    fn sample(&self, motion: &Motion, energy: Energy, impulses: &[f64]) -> Self::Sample;

    /// Coordinates and rates of `sample` as free motion from `from` makes them, given the accelerations of all bodies.
    fn fly(&self, sample: &mut Self::Sample, from: &Self::Sample, accelerations: &[Twist]);

    /// Takes over the rates of another sample.
    fn take_rates(&self, sample: &mut Self::Sample, from: &Self::Sample);
}

/// The stored energies of the node.
pub(super) fn stored(motion: &Motion) -> Energy {
    let (gravity_j, spring_j) = potential(motion.plan, &motion.linkage);
    let governed = motion.touches.iter().filter(|touch| touch.governed);
    Energy {
        kinetic_j: kinetic(&motion.linkage, &motion.velocities),
        gravity_j,
        spring_j,
        elastic_j: governed.map(|touch| elastic_energy(&touch.law, -touch.gap)).sum(),
        ..Energy::default()
    }
}

/// A contact at the node; `index` is that of the plan.
pub(super) fn contact(motion: &Motion, index: Option<usize>, impulse_n_s: f64) -> ContactSample {
    let touch = index.and_then(|index| motion.touches.iter().find(|touch| touch.index == index));
    touch.map_or(ContactSample::NONE, |touch| {
        let (normal_n, tangential_n) = pressing(motion, touch);
        ContactSample {
            gap_m: touch.gap,
            gap_rate_m_s: touch.normal_row.rate(&motion.velocities),
            slip_m_s: touch.slip_row.rate(&motion.velocities),
            normal_n,
            tangential_n,
            impulse_n_s,
            point_m: touch.point,
            normal: touch.normal,
        }
    })
}

/// Normal and tangential force of a touch at the end of the last step; before the first one, from the laws themselves.
fn pressing(motion: &Motion, touch: &Touch) -> (f64, f64) {
    if motion.last_dt_s > 0.0 {
        return motion.forces(touch.index);
    }
    if !touch.governed {
        return (0.0, 0.0);
    }
    let [rate, slip] = [&touch.normal_row, &touch.slip_row].map(|row| row.rate(&motion.velocities));
    let normal = normal_force(&touch.law, -touch.gap, -rate).force;
    let friction = touch.friction.filter(|_| normal > 0.0);
    (normal, friction.map_or(0.0, |law| friction_force(&law, slip, normal)))
}

/// A finger whose l22 is bent by φ22.
pub(super) struct FingerReader {
    pub phi22_rad: f64,
}

impl EngineReader for FingerReader {
    type Sample = Sample;

    fn place(&self, plan: &Plan, index: usize) -> usize {
        engine::site(plan, index) as usize
    }

    fn index(&self, plan: &Plan, place: usize) -> Option<usize> {
        engine::index_of(plan, Site::ALL[place])
    }

    /// Bodies count their turns; passive angles do not. Their turn is the one both models show: q12 is the angle between two
    /// directions, and q22 is measured from the straight line by the bend q22 + φ22, whose seam is at −90°.
    fn sample(&self, motion: &Motion, energy: Energy, impulses: &[f64]) -> Sample {
        let places = &motion.linkage.places;
        let (angle, rate) = (|body: usize| places[body].angle, |body: usize| motion.velocities[body][2]);
        let direction = |body: usize| places[body].direction;
        let (sin, cos) = self.phi22_rad.sin_cos();
        let bend = opening_angle(direction(L21), rotate(direction(L22), [cos, sin]));
        let q12_rad = near_turn(angle(L12) - angle(L11), angle_between(direction(L11), direction(L12)));
        let q22_rad = near_turn(angle(L22) - angle(L21), bend - self.phi22_rad);
        let at = |site: Site| contact(motion, engine::index_of(motion.plan, site), impulses[site as usize]);
        let time_s = motion.clock.now();
        Sample {
            time_s,
            q11_rad: angle(L11),
            q21_rad: angle(L21),
            q12_rad,
            q22_rad,
            q13_rad: angle(L21) + q22_rad,
            qd11_rad_s: rate(L11),
            qd21_rad_s: rate(L21),
            qd12_rad_s: rate(L12) - rate(L11),
            qd22_rad_s: rate(L22) - rate(L21),
            motor_torque_n_m: motion.plan.motor_torque(L11, time_s, rate),
            proximal: at(Site::Proximal),
            distal: at(Site::Distal),
            limit: at(Site::Limit),
            energy,
        }
    }

    fn fly(&self, sample: &mut Sample, from: &Sample, accelerations: &[Twist]) {
        let time = sample.time_s - from.time_s;
        let [a11, a12, a21, a22] = [L11, L12, L21, L22].map(|body| accelerations[body][2]);
        let angle = |q: f64, rate: f64, a: f64| q + time * (rate + 0.5 * time * a);
        sample.q11_rad = angle(from.q11_rad, from.qd11_rad_s, a11);
        sample.q21_rad = angle(from.q21_rad, from.qd21_rad_s, a21);
        sample.q12_rad = angle(from.q12_rad, from.qd12_rad_s, a12 - a11);
        sample.q22_rad = angle(from.q22_rad, from.qd22_rad_s, a22 - a21);
        sample.q13_rad = sample.q21_rad + sample.q22_rad;
        sample.qd11_rad_s = from.qd11_rad_s + time * a11;
        sample.qd21_rad_s = from.qd21_rad_s + time * a21;
        sample.qd12_rad_s = from.qd12_rad_s + time * (a12 - a11);
        sample.qd22_rad_s = from.qd22_rad_s + time * (a22 - a21);
    }

    fn take_rates(&self, sample: &mut Sample, from: &Sample) {
        *sample = Sample {
            qd11_rad_s: from.qd11_rad_s,
            qd21_rad_s: from.qd21_rad_s,
            qd12_rad_s: from.qd12_rad_s,
            qd22_rad_s: from.qd22_rad_s,
            ..*sample
        };
    }
}

//! Turns a node of the engine model into a sample.

use super::{ContactSample, Energy, Sample, Site};
use crate::engine::{self, L11, L12, L21, L22, Motion, Touch, kinetic, potential};
use crate::law::{elastic_energy, friction_force, normal_force};
use crate::numeric::plane::{angle_between, near_turn, opening_angle, rotate};

/// Energies at the start of the run, from which works and losses count.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    kinetic: f64,
    gravity: f64,
    spring: f64,
    elastic: f64,
}

impl Start {
    pub fn new(motion: &Motion) -> Self {
        let (gravity, spring) = potential(motion.plan, &motion.linkage);
        Self { kinetic: kinetic(&motion.linkage, &motion.velocities), gravity, spring, elastic: elastic(motion) }
    }
}

pub(super) fn elastic(motion: &Motion) -> f64 {
    let governed = motion.touches.iter().filter(|touch| touch.governed);
    governed.map(|touch| elastic_energy(&touch.law, -touch.gap)).sum()
}

/// Everything about the node; `impulses` are those of the three sites since the start, `phi22_rad` is the bend of l22.
///
/// Bodies count their turns; passive angles do not. Their turn is the one both models show: q12 is the angle between two
/// directions, and q22 is measured from the straight line by the bend q22 + φ22, whose seam is at −90°.
pub(super) fn sample(motion: &Motion, phi22_rad: f64, start: &Start, impulses: &[f64; 3]) -> Sample {
    let places = &motion.linkage.places;
    let (angle, rate) = (|body: usize| places[body].angle, |body: usize| motion.velocities[body][2]);
    let direction = |body: usize| places[body].direction;
    let (sin, cos) = phi22_rad.sin_cos();
    let bend = opening_angle(direction(L21), rotate(direction(L22), [cos, sin]));
    let q12_rad = near_turn(angle(L12) - angle(L11), angle_between(direction(L11), direction(L12)));
    let q22_rad = near_turn(angle(L22) - angle(L21), bend - phi22_rad);
    let now = Start::new(motion);
    let gained = (now.kinetic - start.kinetic) + (now.gravity - start.gravity) + (now.spring - start.spring);
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
        motor_torque_n_m: motion.plan.motor_torque(time_s),
        proximal: contact(motion, Site::Proximal, impulses),
        distal: contact(motion, Site::Distal, impulses),
        limit: contact(motion, Site::Limit, impulses),
        energy: Energy {
            kinetic_j: now.kinetic,
            gravity_j: now.gravity,
            spring_j: now.spring,
            elastic_j: now.elastic,
            dissipated_j: start.elastic - now.elastic - motion.contact_work_j,
            motor_work_j: motion.motor_work_j,
            balance_j: gained - motion.contact_work_j - motion.motor_work_j,
        },
    }
}

fn touch<'a>(motion: &'a Motion, site: Site) -> Option<&'a Touch> {
    let index = engine::index_of(motion.plan, site)?;
    motion.touches.iter().find(|touch| touch.index == index)
}

/// Normal and tangential force of a site at the end of the last step.
pub(super) fn forces(motion: &Motion, site: Site) -> (f64, f64) {
    engine::index_of(motion.plan, site).map_or((0.0, 0.0), |index| motion.forces(index))
}

/// Normal and tangential force of a touch at the end of the last step; before the first one, from the laws themselves.
pub(super) fn pressing(motion: &Motion, touch: &Touch) -> (f64, f64) {
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

fn contact(motion: &Motion, site: Site, impulses: &[f64; 3]) -> ContactSample {
    let Some(touch) = touch(motion, site) else {
        return ContactSample::NONE;
    };
    let (normal_n, tangential_n) = pressing(motion, touch);
    ContactSample {
        gap_m: touch.gap,
        gap_rate_m_s: touch.normal_row.rate(&motion.velocities),
        slip_m_s: touch.slip_row.rate(&motion.velocities),
        normal_n,
        tangential_n,
        impulse_n_s: impulses[site as usize],
        point_m: touch.point,
        normal: touch.normal,
    }
}

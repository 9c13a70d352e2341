//! Reproducible random designs.

use phalanx::gripper::{Assembly, Design, Finger, ProximalLength, bodies, disc, lengths, start_posture};
use phalanx::law::{FrictionKind, FrictionLaw};
use phalanx::scene::{HandFinger, Initial, Motor, Object, Placement, Profile, Scene, Spring, SpringKind};
use phalanx::sizing::{OPENING_RAD, Rule, Sizing, Task, size};

const DENSITY_KG_M3: f64 = 1070.0;
const DEPTH_M: f64 = 0.040;

/// Choice of motor torque and spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// Random τ11 of 0.3–0.7 N·m and k_s of 0.08–0.18 N·m: many fingers are driven much too strongly or weakly.
    Random,
    /// Sized for the test trajectory of the thesis.
    Sized,
}

/// SplitMix64 random number generator (Steele, Lea & Flood 2014).
pub struct Rng(u64);

impl Rng {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns a uniformly distributed number between `low` and `high`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        low + (high - low) * (z >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Returns the next random design as a variant of `template`; `None` if the random parameters give no finger that can grasp
/// the disc.
pub fn random_design(rng: &mut Rng, template: &Scene, drive: Drive) -> Option<Scene> {
    let base_m = rng.uniform(0.012, 0.0225);
    let l21 = ProximalLength::Fraction(rng.uniform(0.0, 1.0));
    let phi22 = rng.uniform(90.0, 120.0).to_radians();
    let design = Design::thesis(base_m, l21, phi22, rng.uniform(1.0 / 3.0, 2.0 / 3.0));
    let is_frictionless = rng.uniform(0.0, 1.0) < 0.5;
    let mu_static = rng.uniform(0.0, 0.8);
    let random = Sizing { motor_n_m: rng.uniform(0.3, 0.7), spring_n_m: rng.uniform(0.08, 0.18) };

    let lengths = lengths(&design).ok()?;
    let object = disc(&design);
    let finger =
        Finger { lengths, bodies: bodies(&lengths, DENSITY_KG_M3, DEPTH_M).ok()?, assembly: Assembly::Reference };
    let start = start_posture(&lengths, object, OPENING_RAD).ok()?;
    let Sizing { motor_n_m, spring_n_m } = match drive {
        Drive::Random => random,
        Drive::Sized => {
            let task = Task { gravity_m_s2: template.hand.gravity_m_s2, ..Task::thesis(object) };
            size(&finger, &task, Rule::Rigid).ok()?
        }
    };

    let friction = (!is_frictionless).then_some(FrictionLaw {
        mu_static,
        mu_dynamic: 0.7 * mu_static,
        v_static_m_s: 0.1,
        v_dynamic_m_s: 0.2,
        kind: FrictionKind::Regularised,
    });
    let mut contact = template.finger().contact;
    (contact.proximal.friction, contact.distal.friction) = (friction, friction);
    let mut scene = template.clone();
    scene.hand.object = Some(Object::fixed(object));
    *scene.finger_mut() = HandFinger {
        linkage: finger,
        contact,
        motor: Motor::from_actuation(Profile::Constant { value: motor_n_m }),
        spring: Some(Spring { kind: SpringKind::Constant { torque_n_m: spring_n_m }, placement: Placement::Phalanges }),
        initial: Initial { q11_rad: start.q11_rad, q21_rad: start.q21_rad, qd11_rad_s: 0.0, qd21_rad_s: 0.0 },
        limit: template.finger().limit,
    };
    Some(scene)
}

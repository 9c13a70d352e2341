//! All quantities along the test trajectory, sample by sample (thesis Figs. 3.1–3.3).

use super::phases::{BendingPhase, RigidPhase};
use super::{Closing, INTERVALS, Rule, Sizing, SizingError, Task, closing, size_with};
use crate::gripper::{Finger, Placement, positive};

/// The test trajectory with its required torques and the resulting sizing.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    pub closing: Closing,
    /// Sizing by [`Rule::Rigid`] with the spring at q22.
    pub rigid: Sizing,
    /// Sizing by [`Rule::Whole`] with the spring at q22.
    pub whole: Sizing,
    /// Largest relative change of these torques when the number of samples is doubled.
    pub convergence: f64,
    /// k_s for each placement of the spring, in the order of [`Placement::ALL`].
    pub placements_n_m: [f64; 4],
    /// Torque of the torsional spring over its extension: k_s/q_p.
    pub torsional_n_m_per_rad: f64,
    pub points: Vec<ProfilePoint>,
}

/// One sample of the trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfilePoint {
    pub time_s: f64,
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub q22_rad: f64,
    pub qd11_rad_s: f64,
    pub qdd11_rad_s2: f64,
    /// k_s(t) for each placement of the spring, in the order of [`Placement::ALL`]; `None` after the proximal contact.
    pub springs_n_m: Option<[f64; 4]>,
    /// Net motor torque r1 + r2; `None` after the proximal contact.
    pub net_n_m: Option<f64>,
    /// Motor torque against the constant spring k_s.
    pub constant_n_m: f64,
    /// Motor torque against the torsional spring whose torque is k_s when the finger is straight.
    pub torsional_n_m: f64,
}

/// Evaluates the test trajectory at `samples` equal time steps; the contact is an additional point, once on each side.
///
/// `preload_rad` is q_p, the deflection of the torsional spring when the finger is straight: c_s = k_s/q_p (2.30).
///
/// # Errors
/// See [`super::size`]; also returns an error if the preload is not above 0.
pub fn profile(finger: &Finger, task: &Task, preload_rad: f64, samples: usize) -> Result<Profile, SizingError> {
    positive(&[("preload_rad", preload_rad)])?;
    let closing = closing(finger, task)?;
    let size_both = |intervals| -> Result<[Sizing; 2], SizingError> {
        let size_by = |rule| size_with(finger, task, rule, Placement::Phalanges, intervals);
        Ok([size_by(Rule::Rigid)?, size_by(Rule::Whole)?])
    };
    let [rigid, whole] = size_both(INTERVALS)?;
    let finer = size_both(2 * INTERVALS)?;
    let change = |a: f64, b: f64| if b == 0.0 { a.abs() } else { (a / b - 1.0).abs() };
    let convergence = [rigid, whole]
        .iter()
        .zip(&finer)
        .flat_map(|(a, b)| [change(a.motor_n_m, b.motor_n_m), change(a.spring_n_m, b.spring_n_m)])
        .fold(0.0, f64::max);
    let mut placements_n_m = [0.0; 4];
    for (torque, placement) in placements_n_m.iter_mut().zip(Placement::ALL) {
        *torque = size_with(finger, task, Rule::Rigid, placement, INTERVALS)?.spring_n_m;
    }
    let torsional_n_m_per_rad = rigid.spring_n_m / preload_rad;

    let rigid_phase = RigidPhase::new(finger, &closing, task.gravity_m_s2);
    let bending_phase = BendingPhase::new(finger, &closing, task.gravity_m_s2);
    let k_s = rigid.spring_n_m;
    let point = |x: f64, straight: bool| {
        let motion = closing.trajectory.at(x);
        let common = ProfilePoint {
            time_s: x * closing.trajectory.length_s,
            q11_rad: motion.angle_rad,
            q21_rad: closing.q21_contact_rad,
            q22_rad: closing.start.q22_rad,
            qd11_rad_s: motion.rate_rad_s,
            qdd11_rad_s2: motion.acceleration_rad_s2,
            springs_n_m: None,
            net_n_m: None,
            constant_n_m: 0.0,
            torsional_n_m: 0.0,
        };
        if straight {
            let r2 = rigid_phase.torques(&motion)[1];
            let motor = rigid_phase.motor_with_spring(&motion, k_s);
            return ProfilePoint {
                q21_rad: motion.angle_rad - closing.start.q11_rad + closing.start.q21_rad,
                springs_n_m: Some(Placement::ALL.map(|placement| r2 / rigid_phase.spring_lever(placement).abs())),
                net_n_m: Some(rigid_phase.net_torque(&motion)),
                constant_n_m: motor,
                torsional_n_m: motor,
                ..common
            };
        }
        let q22_rad = bending_phase.q22(&motion);
        let [r1, lever] = bending_phase.row(&motion);
        let extension = q22_rad - closing.start.q22_rad;
        ProfilePoint {
            q22_rad,
            constant_n_m: r1 + lever * k_s,
            torsional_n_m: r1 + lever * (k_s + torsional_n_m_per_rad * extension),
            ..common
        }
    };
    let mut points = Vec::with_capacity(samples + 3);
    let xs = (0..=samples).map(|i| i as f64 / samples.max(1) as f64);
    let (swing, bend): (Vec<f64>, Vec<f64>) = xs.partition(|x| *x < closing.contact_x);
    for x in swing.into_iter().chain([closing.contact_x]) {
        points.push(point(x, true));
    }
    for x in [closing.contact_x].into_iter().chain(bend.into_iter().filter(|x| *x > closing.contact_x)) {
        points.push(point(x, false));
    }
    Ok(Profile { closing, rigid, whole, convergence, placements_n_m, torsional_n_m_per_rad, points })
}

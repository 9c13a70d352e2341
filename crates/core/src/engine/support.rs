//! Supports: bodies with prescribed motion, and the ground under a moving palm. They supply the work of contacts, joints
//! and smooth forces on them.

use super::coordinate::{Twist, power};
use super::forces::{PalmFrame, prescribed_pose, rotor_moment};
use super::linkage::Linkage;
use super::plan::Plan;
use crate::mechanism::PrescribedMotion;
use crate::numeric::plane::cross;
use crate::scene::Pose;

/// A body with prescribed motion that does work in the frame of the plan.
#[derive(Clone, Copy, Debug)]
pub(super) enum Support {
    /// A driven body; a palm does no work in its own frame.
    Driven(usize),
    /// The ground, which moves in the frame of a palm.
    Ground,
}

pub(super) fn supports(plan: &Plan) -> impl Iterator<Item = Support> + Clone {
    let driven = plan.drives.iter().filter_map(|drive| match drive.motion {
        PrescribedMotion::ConstantAcceleration { .. } => Some(Support::Driven(drive.body)),
        PrescribedMotion::Palm(_) => None,
    });
    driven.chain(plan.palm().map(|_| Support::Ground))
}

impl Support {
    /// Force and moment on the support that loads on bodies and the joints exert, after a call as for
    /// [`Linkage::reactions`]. For the ground, the moment is about the origin.
    pub fn reaction(self, linkage: &Linkage, loads: impl Iterator<Item = (usize, Twist)>) -> Twist {
        let mut sum = [0.0; 3];
        let support = match self {
            Support::Driven(body) => Some(body),
            Support::Ground => None,
        };
        for (body, [x, y, moment]) in loads.chain(linkage.reactions(support)) {
            let (pose, inertia) = (&linkage.poses[body], &linkage.inertias[body]);
            let part = match self {
                Support::Driven(support) if support == body => [x, y, moment],
                Support::Driven(_) => continue,
                // All forces are internal, with the ground, which prevents the rotation of bodies that do not rotate.
                Support::Ground => {
                    let is_prevented = inertia.inverse_mass > 0.0 && inertia.inverse_inertia == 0.0;
                    let moment = if is_prevented { 0.0 } else { moment };
                    [-x, -y, -moment - cross(pose.com, [x, y])]
                }
            };
            (0..3).for_each(|axis| sum[axis] += part[axis]);
        }
        sum
    }

    /// Velocity of the support at a time in the last or next step, in the frame of a palm.
    fn velocity(self, plan: &Plan, t: f64) -> Twist {
        let pose = match self {
            Support::Driven(body) => plan.drives.iter().find(|drive| drive.body == body),
            Support::Ground => None,
        };
        let Pose { position: [x, y, _], rate, .. } =
            pose.map_or_else(Pose::default, |drive| prescribed_pose(plan, drive, t));
        let transport = PalmFrame::at(plan, t).transport_velocity([x, y]);
        std::array::from_fn(|axis| rate[axis] - transport[axis])
    }
}

/// Returns the work of contacts on supports over the step that starts at `t`, J, directly and through joints; the supports
/// have to supply it.
pub(super) fn contact_work(
    plan: &Plan,
    on_supports: &[Twist],
    [early_impulses, late_impulses]: [&[f64]; 2],
    (t, dt): (f64, f64),
) -> f64 {
    let count = supports(plan).count();
    let mut work = 0.0;
    for (index, support) in supports(plan).enumerate() {
        let [start, end] = [t, t + dt].map(|t| support.velocity(plan, t));
        let rows = on_supports.iter().skip(index).step_by(count);
        for ((early_impulse, late_impulse), reaction) in early_impulses.iter().zip(late_impulses).zip(rows) {
            // ∫ F ds and ∫ s F ds, from the early and late impulses.
            work += early_impulse * power(reaction, &start) + late_impulse * power(reaction, &end);
        }
    }
    work
}

/// Returns the power of supports against joints and smooth forces at a node, W, with these forces and accelerations of
/// driven bodies.
pub(super) fn power_of_supports(
    plan: &Plan,
    linkage: &mut Linkage,
    (forces, velocities): (&[Twist], &[Twist]),
    t: f64,
    (driven, accelerations): (&[(usize, Twist)], &mut [Twist]),
) -> f64 {
    let carries = |support: &Support| !matches!(support, Support::Ground) || plan.ground_carries;
    if !supports(plan).any(|support| carries(&support)) {
        return 0.0;
    }
    linkage.accelerations(forces, velocities, driven, accelerations);
    let [gx, gy] = plan.gravity_m_s2;
    // The moments on rotors are inertial.
    let internal = |body: usize| {
        let ([x, y, moment], mass) = (forces[body], linkage.inertias[body].mass);
        (body, [x - mass * gx, y - mass * gy, moment - rotor_moment(plan, body, t)])
    };
    let loads = || (0..forces.len()).map(internal);
    let on = |support: Support| power(&support.reaction(linkage, loads()), &support.velocity(plan, t));
    -supports(plan).filter(carries).map(on).sum::<f64>()
}

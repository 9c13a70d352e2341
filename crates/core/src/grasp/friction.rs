//! Force closure and balanced accelerations of a grasp with one or several friction coefficients.

use std::f64::consts::TAU;

use crate::mechanism::point_in;
use crate::statics::{
    ContactAtRest, ForceClosure, FrictionContact, MechanismAtRest, MechanismBalance, StaticsError, force_closure,
    mechanism_balance,
};

/// Force closure and balanced accelerations for one friction coefficient.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionCase {
    /// Friction coefficient; `None` for the coefficients of the scene.
    pub mu_static: Option<f64>,
    pub force_closure: ForceClosure,
    /// Balanced accelerations in evenly spaced directions: first with the drives blocked, then with the drives at their
    /// effort.
    pub polar: [Vec<MechanismBalance>; 2],
}

impl FrictionCase {
    /// Angle, from x towards y, of every `stride`-th direction, with the balances for blocked drives and for drives at
    /// their effort.
    pub fn directions(&self, stride: usize) -> impl Iterator<Item = (f64, [&MechanismBalance; 2])> {
        let [blocked, at_effort] = &self.polar;
        let count = blocked.len() as f64;
        let both = move |(index, (blocked, at_effort))| (TAU * index as f64 / count, [blocked, at_effort]);
        blocked.iter().zip(at_effort).enumerate().step_by(stride).map(both)
    }
}

/// The held body, and the length by which moments are divided in Q1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    pub body: usize,
    pub radius_m: f64,
}

/// Returns one case for each coefficient, or that of the scene if there are none. The mechanism has the same posture and
/// contacts with its drives blocked, and at their effort.
pub(super) fn friction_cases(
    both: &[MechanismAtRest<'_>; 2],
    held: Held,
    mu_static: &[f64],
    directions: usize,
) -> Result<Vec<FrictionCase>, StaticsError> {
    let MechanismAtRest { mechanism, poses, .. } = both[0];
    let centre_m = point_in(Some(held.body), mechanism.bodies[held.body].com_m, poses);
    let case = |mu_static: Option<f64>| {
        let with_friction = |contact: &ContactAtRest| ContactAtRest { mu: mu_static.unwrap_or(contact.mu), ..*contact };
        let contacts: Vec<ContactAtRest> = both[0].contacts.iter().map(with_friction).collect();
        let on_held = contacts.iter().filter_map(|contact| {
            Some(FrictionContact { point_m: contact.point_m, push: contact.push_on(held.body)?, mu: contact.mu })
        });
        let polar = |at_rest: &MechanismAtRest<'_>| {
            mechanism_balance(&MechanismAtRest { contacts: &contacts, ..at_rest.clone() }, directions)
        };
        Ok(FrictionCase {
            mu_static,
            force_closure: force_closure(&on_held.collect::<Vec<_>>(), centre_m, held.radius_m),
            polar: [polar(&both[0])?, polar(&both[1])?],
        })
    };
    match mu_static {
        [] => Ok(vec![case(None)?]),
        given => given.iter().map(|mu| case(Some(*mu))).collect(),
    }
}

//! A finger with all that drives it, and where it starts.

use super::super::check::Checker;
use super::super::table::keys::Keys;
use super::super::{DrivenFinger, Motor, Side};
use super::finger::Plan;
use super::room::ends_sized;
use super::seen::Seen;
use super::sizing::Sized;
use super::{contact, drive, finger, start};

/// What a finger stands in.
pub struct Stand {
    pub side: Side,
    pub gravity_m_s2: [f64; 2],
    /// Whether it has a motor of its own.
    pub has_motor: bool,
    /// Radius of curvature of the object.
    pub curvature_m: f64,
    /// What it closes on; `None` where something is wrong with that.
    pub seen: Option<Seen>,
}

/// The finger, and what its motor and spring were sized to.
pub fn driven(c: &mut Checker<'_>, raw: &Keys<'_>, plan: &Plan, stand: Stand) -> (Sized, Option<DrivenFinger>) {
    let Stand { side, gravity_m_s2: [x, y], has_motor, curvature_m, seen } = stand;
    let linkage = finger::finger(c, raw, plan);
    let sound = linkage.as_ref().zip(seen.as_ref());
    let sized = ends_sized(c, raw, &plan.said, sound, [side.mirror() * x, y]);
    let motor = match has_motor {
        true => drive::motor(c, &raw.inner("motor"), sized),
        false => Some(Motor::NONE),
    };
    let spring = drive::spring(c, &raw.inner("spring"), sized);
    let limit = contact::limit(c, &raw.inner("limit"));
    let contact = contact::contacts(c, &raw.inner("contact"), curvature_m);
    let initial = start::initial(c, raw, plan, sound, limit);
    let whole = (linkage, motor, spring, contact, initial);
    let (Some(linkage), Some(motor), Some(spring), Some(contact), Some(initial)) = whole else { return (sized, None) };
    (sized, Some(DrivenFinger { linkage, motor, spring, limit, contact, initial }))
}

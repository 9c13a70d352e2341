//! All of a system, part by part.

use super::super::check::Checker;
use super::super::raw::Raw;
use super::super::table::differential::Seesaw;
use super::super::table::top::Top;
use super::super::table::{Table, read};
use super::super::{DiscMotion, DrivenFinger, HalfPlane, System};
use super::driven::{Stand, driven};
use super::sizing::Sized;
use super::{contact, differential, disc, finger, motion, object, plane, room};
use crate::shape;

/// `None` where a part is wrong; that is noted.
pub fn system(c: &mut Checker<'_>, raw: &Raw, top: &Top) -> Option<System> {
    let (whole, gravity_m_s2) = (raw.whole(), top.gravity_m_s2);
    let said = object::said(c, &whole);
    let plans: Vec<_> =
        raw.sides().iter().map(|side| finger::plan(c, &raw.finger(*side), shape::reach(&said.shape))).collect();
    let discs = match raw.sides().len() {
        0 => disc::discs(c, raw, gravity_m_s2),
        1 => object::beside(c, &whole, said, plans[0].base_m),
        _ => Some(vec![said.disc()]),
    };
    let palm_width_m = room::palm_width(c, &whole, top, &plans, &said);
    let levels = plane::levels(c, &whole, top, said);
    let seen = room::seen(c, raw, top, &plans, said, (discs.as_deref(), palm_width_m, levels));

    let seesaw = whole.inner("differential");
    let seesaw = seesaw.is_given().then(|| read(c, "differential", &seesaw, Seesaw::usual()));
    let seesaw = seesaw.filter(|seesaw| seesaw.present);
    let (mut sized, mut fingers): (Vec<Sized>, Vec<Option<DrivenFinger>>) = Default::default();
    for ((side, plan), seen) in raw.sides().iter().zip(&plans).zip(seen) {
        let stand = Stand {
            side: *side,
            gravity_m_s2,
            has_motor: seesaw.is_none(),
            curvature_m: shape::curvature(&said.shape),
            seen,
        };
        let (sizing, finger) = driven(c, &raw.finger(*side), plan, stand);
        sized.push(sizing);
        fingers.push(finger);
    }
    let fingers: Option<Vec<DrivenFinger>> = fingers.into_iter().collect();
    let differential = match (seesaw, &sized[..]) {
        (Some(seesaw), [right, left]) => {
            differential::differential(c, raw, seesaw, right.of_both_motors(*left)).map(Some)
        }
        _ => Some(None),
    };

    let is_fixed = discs.iter().flatten().any(|disc| disc.motion == DiscMotion::Fixed);
    let palm_motion = motion::palm_motion(c, &whole, is_fixed);
    let law = whole.inner("contact");
    let [between_discs, palm_law, table_law] = match raw.sides().len() {
        0 => [contact::common(c, &law); 3],
        // Nothing that moves can reach a palm.
        1 => [None; 3],
        _ => {
            let [palm, table] =
                contact::planes(c, &law, levels.map(|level| level.is_some()), shape::curvature(&said.shape))?;
            [None, palm, table]
        }
    };
    let [palm, table] = [(levels[0], palm_law), (levels[1], table_law)]
        .map(|(level, contact)| level.map(|level_m| HalfPlane { level_m, contact }));
    Some(System {
        fingers: fingers?,
        palm_width_m: palm_width_m?,
        differential: differential?,
        discs: discs?,
        between_discs,
        palm,
        table,
        palm_motion,
        gravity_m_s2,
    })
}

/// Static friction of the proximal contact of the first finger, or else of discs; 0 without friction.
pub fn mu_static(system: &System) -> Option<f64> {
    let proximal = system.fingers.first().map(|finger| finger.contact.proximal);
    proximal.or(system.between_discs).map(|law| law.friction.map_or(0.0, |friction| friction.mu_static))
}

//! Where the object may be, and what each finger sees of it.

use std::ops::Range;

use super::super::check::Checker;
use super::super::raw::Raw;
use super::super::table::finger::Links;
use super::super::table::keys::Keys;
use super::super::table::object::Object;
use super::super::table::top::Top;
use super::super::{Disc, Side};
use super::finger::Plan;
use super::object::example_base_m;
use super::seen::Seen;
use super::sizing::Sized;
use super::{plane, sizing};
use crate::gripper::Finger;
use crate::numeric::elementary::hypot;
use crate::shape::{Placed, tangent};
use crate::units::{Dimension, format};

/// Given, or twice the base that both fingers are made for; 0 of one finger, and of none.
pub fn palm_width(c: &mut Checker<'_>, raw: &Keys<'_>, top: &Top, plans: &[Plan], object: &Object) -> Option<f64> {
    let [right, left] = plans else { return Some(0.0) };
    if raw.has("palm_width") {
        for of in [raw.clone(), raw.inner("right"), raw.inner("left")] {
            c.unused_at("lengths.base", of.inner("lengths").span("base"), "beside palm_width");
        }
        return Some(top.palm_width_m).filter(|width_m| !width_m.is_nan());
    }
    let (right, left) = (right.base_m, left.base_m);
    // A wrong base is noted already.
    let by_lengths =
        !raw.inner("lengths").has("base") && plans.iter().any(|plan| plan.lengths.is_some() && plan.base_m.is_none());
    let length = |metres| format(metres, Dimension::Length);
    if by_lengths {
        let base_m = right.or(left).unwrap_or_else(|| example_base_m(raw, &object.shape));
        let (base, width) = (length(base_m), length(2.0 * base_m));
        let help = format!("add it, such as palm_width = \"{width}\", or half of it: [lengths] base = \"{base}\"");
        c.lacks("palm_width", None, &help);
    } else if let (Some(one), Some(other)) = (right, left)
        && one != other
    {
        let width = length(one + other);
        let help = format!("the fingers are made for different bases, so none says it: palm_width = \"{width}\"");
        c.lacks("palm_width", None, &help);
    }
    right.filter(|_| right == left).map(|base_m| 2.0 * base_m)
}

/// What each finger sees; `None` where something is wrong with that.
pub fn seen(
    c: &mut Checker<'_>,
    raw: &Raw,
    top: &Top,
    plans: &[Plan],
    object: Object,
    (discs, palm_width_m, levels): (Option<&[Disc]>, Option<f64>, [Option<f64>; 2]),
) -> Vec<Option<Seen>> {
    if plans.len() < 2 {
        return vec![discs.map(Seen::alone)];
    }
    let (whole, before) = (raw.whole(), c.count());
    plane::judge_object(c, &whole, object, levels);
    let mut room = palm_width_m.and_then(|palm_width_m| room(c, &whole, top, object, palm_width_m));
    room = room.filter(|_| c.count() == before);
    let said = whole.inner("object");
    let place = said.span("offset").or(whole.span("palm_width")).or(said.span);
    let mut seen = Vec::new();
    for (side, plan) in Side::BOTH.into_iter().zip(plans) {
        let half_width_m = plan.lengths.map(|lengths| lengths.half_width_m);
        let mut one = room.map(|room| room.seen(side, object));
        if let (Some(sight), Some(half_width_m)) = (&one, half_width_m)
            && !is_clear(c, place.clone(), side, sight, half_width_m)
        {
            one = None;
            // The other finger would say the same again.
            room = None;
        }
        seen.push(one.filter(|_| half_width_m.is_some()));
    }
    seen
}

/// Where the object may be that fingers are sized and opened for.
#[derive(Clone, Copy)]
struct Room {
    half_palm_m: f64,
    error_m: f64,
}

/// The palm's width and the positioning error, which must be no less than the object's.
fn room(c: &mut Checker<'_>, raw: &Keys<'_>, top: &Top, object: Object, palm_width_m: f64) -> Option<Room> {
    let offset = object.centre_m[0];
    let error_m = if raw.has("positioning_error") { top.positioning_error_m } else { offset.abs() };
    if error_m.is_nan() {
        return None;
    }
    let room = Room { half_palm_m: 0.5 * palm_width_m, error_m };
    if offset.abs() <= error_m {
        return Some(room);
    }
    let [error, offset] = [error_m, offset.abs()].map(|value| format(value, Dimension::Length));
    c.push(
        raw.span("positioning_error"),
        format!("`positioning_error` is {error}, but the object is {offset} off the middle of the palm"),
        "the object is further off",
        "raise it, bring `object.offset` nearer to 0, or leave it out: it is the object's own then",
    );
    None
}

impl Room {
    fn seen(&self, side: Side, object: Object) -> Seen {
        let Placed { shape, centre_m: [x, y], angle_rad } = object.placed();
        let angle_rad = side.mirror() * angle_rad;
        let at = |x: f64| Placed { shape, centre_m: [x - self.half_palm_m, y], angle_rad };
        Seen { object: Some(at(side.mirror() * x)), ends: vec![at(-self.error_m), at(self.error_m)] }
    }
}

/// Whether the ground joint of a finger is outside of the object grown by half a link's width, wherever that may be.
fn is_clear(c: &mut Checker<'_>, place: Option<Range<usize>>, side: Side, seen: &Seen, half_width_m: f64) -> bool {
    let near = |placed: &Placed| {
        let reach = tangent(placed, half_width_m).err()?;
        Some((hypot(placed.centre_m[0], placed.centre_m[1]), reach))
    };
    let nearest = seen.object.iter().chain(&seen.ends).filter_map(near);
    let Some((distance, reach)) = nearest.min_by(|one, other| one.0.total_cmp(&other.0)) else { return true };
    let [distance, reach] = [distance, reach].map(|value| format!("{:.3} mm", value * 1e3));
    c.push(
        place,
        format!("the ground joint of the {} finger is {distance} from the object's centre, but must be at least {reach} away: the radius and half a link's width", side.word()),
        "inside the object",
        "widen the palm (`palm_width`), or bring the object nearer to its middle (`object.offset`, `positioning_error`)",
    );
    false
}

/// Motor and spring that do at either end of the positioning error (thesis §4.2.1.3), of which one may be out of the finger's reach: it
/// meets the object only when the other finger has brought it.
pub fn ends_sized(
    c: &mut Checker<'_>,
    raw: &Keys<'_>,
    said: &Links,
    sound: Option<(&Finger, &Seen)>,
    gravity_m_s2: [f64; 2],
) -> Sized {
    let Some((finger, Seen { object: Some(_), ends })) = sound else {
        return sizing::sizing(c, raw, said, sound.map(|(finger, _)| (finger, &None)), gravity_m_s2);
    };
    let differ = ends.windows(2).any(|pair| pair[0] != pair[1]);
    let tried: Vec<_> = ends
        .iter()
        .map(|disc| {
            let mut aside = c.aside();
            let sized = sizing::sizing(&mut aside, raw, said, Some((finger, &Some(*disc))), gravity_m_s2);
            if differ {
                let base = -disc.centre_m[0] * 1e3;
                let more = format!(
                    " where the positioning error brings it, {base:.3} mm from the ground joint along the palm"
                );
                aside.add_to(sizing::NOT_SIZED, &more);
            }
            (sized, aside)
        })
        .collect();
    let reaches = |sized: Sized| matches!(sized, Sized::By(_));
    let reached = tried.iter().filter(|(sized, _)| reaches(*sized)).count();
    let mut all = None;
    for (sized, aside) in tried {
        if reached == 0 || reaches(sized) {
            c.extend(aside.into_problems());
            all = Some(all.map_or(sized, |before: Sized| before.for_both(sized)));
        }
    }
    all.unwrap_or(Sized::Wrong)
}

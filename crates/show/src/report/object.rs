//! The grasp of an object by a hand: JSON document and text.

use serde::{Serialize, Serializer};

use super::contacts::{ContactReport, Contacts};
use super::named::{Named, Object};
use super::tables::{DEGREES, milliseconds, resolved};
use crate::criteria::{
    ActuatorCriteria, CycleCriteria, Failure, Fate, Firmness, Margin, ObjectCriteria, PairCriteria, firmness,
};
use crate::format::format_duration;
use crate::format::numbers::{G_M_S2, format_number, or_dash};
use crate::format::report::{Report, table_of};
use crate::playback::{PlayedGrasp, PlayedState};
use crate::scene::Scene;
use crate::statics::ForceClosure;
use crate::units::Dimension;

/// The slowest creep that the answer names, m/s: 1 µm in a second.
const MIN_CREEP_M_S: f64 = 1e-6;

/// Report on the grasp of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectReport {
    pub criteria: ObjectCriteria,
    /// How firmly the object is held; `None` unless it is held or carried, and without the scene.
    firmness: Option<Firmness>,
    /// Whether x is measured along a palm from its middle, as for a five-bar hand.
    has_palm_frame: bool,
}

impl ObjectReport {
    /// Builds the report; without the scene, it contains no margin.
    pub fn new(found: &ObjectCriteria, scene: Option<&Scene>) -> Self {
        ObjectReport {
            criteria: found.clone(),
            firmness: scene.and_then(|scene| firmness(scene, found)),
            has_palm_frame: scene.is_some_and(|scene| scene.finger_count() == 2),
        }
    }

    /// Pairs that have touched.
    fn touched(&self) -> impl Iterator<Item = &PairCriteria> {
        self.criteria.pairs.iter().filter(|pair| pair.first_s.is_some())
    }

    /// Names of the pairs that have not touched.
    fn untouched(&self) -> Vec<&str> {
        let untouched = self.criteria.pairs.iter().filter(|pair| pair.first_s.is_none());
        untouched.map(|pair| pair.name.as_str()).collect()
    }

    /// Whether a contact of this name is a point of a pair.
    pub(super) fn has_point(&self, index: usize) -> bool {
        self.criteria.pairs.iter().any(|pair| pair.points.contains(&index))
    }

    /// The answer in one sentence: fate and time, then forces, friction, slip and margin, or the reason.
    pub fn answer(&self) -> String {
        let found = &self.criteria;
        let ms = |time_s: f64| format!("{} ms", format_number(time_s * 1e3, 4));
        match found.fate {
            Fate::Held => {
                let parts = [
                    Some(self.presses()),
                    found.friction_used().map(|used| format!("friction used {} %", percent(used))),
                    found.slip.map(|slip| format!("slips {}", distance(slip.displacement_m))),
                    found
                        .creep_m_s
                        .filter(|creep| *creep > MIN_CREEP_M_S)
                        .map(|creep| format!("creeps {}/s", distance(creep))),
                    self.firmness.as_ref().map(|firmness| balances(&firmness.driven)),
                ];
                let parts: Vec<String> = parts.into_iter().flatten().collect();
                format!("held since {}: {}", ms(found.held_since_s.unwrap_or_default()), parts.join("; "))
            }
            Fate::Carried => {
                let since_s = found.states.last().map(|(since_s, _)| *since_s);
                let parts = [Some(self.presses()), self.firmness.as_ref().map(|firmness| balances(&firmness.driven))];
                let parts: Vec<String> = parts.into_iter().flatten().collect();
                format!("carried since {} without a grip: {}", ms(since_s.unwrap_or_default()), parts.join("; "))
            }
            Fate::Placed { until_s } | Fate::Dropped { since_s: until_s } => {
                format!("{} at {}: {}", found.fate.name(), ms(until_s), found.reason)
            }
            Fate::Escaped { at_s } | Fate::Ejected { at_s } => {
                format!("{} at {}: {}", found.fate.name(), ms(at_s), found.reason)
            }
            Fate::NotGrasped => format!("not grasped: {}", found.reason),
        }
    }

    /// The pairs of the hand that press at the end, with their forces.
    fn presses(&self) -> String {
        let pressing = self.criteria.pairs.iter().filter(|pair| pair.is_hand && pair.active_since_s.is_some());
        let pressing: Vec<&PairCriteria> = pressing.collect();
        let outline = |pair: &PairCriteria| {
            let other = pair.name.split('/').next().unwrap_or_default();
            other.rsplit('.').next().unwrap_or_default().to_string()
        };
        let first = pressing.first().map(|pair| outline(pair));
        let is_same = pressing.iter().all(|pair| Some(outline(pair)) == first);
        let word = first.filter(|_| is_same).unwrap_or_else(|| "contact".to_string());
        let forces: Vec<String> =
            pressing.iter().map(|pair| format!("{} N", format_number(pair.normal_n, 3))).collect();
        let forces = match &forces[..] {
            [] => return "nothing presses".to_string(),
            [force] => return format!("1 {word} presses with {force}"),
            [first @ .., last] => format!("{} and {last}", first.join(", ")),
        };
        format!("{} {} press with {forces}", pressing.len(), plural(&word))
    }

    /// The answer and its notes.
    pub fn heading(&self) -> String {
        let mut lines = vec![self.answer()];
        if let Some(Firmness { driven: Margin::Limited { failure, .. }, .. }) = &self.firmness {
            lines.push(format!("fails first: {}", describe_failure(failure)));
        }
        lines.push(format!("object: {}, base: {}", self.criteria.object, self.criteria.base));
        let blocked =
            self.firmness.as_ref().filter(|firmness| balances(&firmness.blocked) != balances(&firmness.driven));
        lines.extend(blocked.map(|firmness| {
            let because = if firmness.blocked == Margin::Any { ": friction grows with their force" } else { "" };
            format!("with actuators that never yield it {}{because}", balances(&firmness.blocked))
        }));
        if !self.criteria.assumed_hand.is_empty() {
            let names = self.criteria.assumed_hand.join(", ");
            let (counts, it) = if self.criteria.assumed_hand.len() == 1 { ("counts", "it") } else { ("count", "them") };
            lines.push(format!(
                "note: {names} {counts} as part of the hand; list {it} under [grasp] surroundings if the object only lies there"
            ));
        }
        lines.join("\n") + "\n"
    }

    /// The grasp in the form in which a page shows it.
    pub fn played(&self) -> PlayedGrasp {
        let found = &self.criteria;
        let states = found.states.iter().map(|(from_s, state)| PlayedState { from_s: *from_s, name: state.name() });
        let released = found.cycle.release_s.map(|from_s| PlayedState { from_s, name: "released" });
        PlayedGrasp { answer: self.answer(), states: states.chain(released).collect() }
    }

    /// Note for a run that ends because the object leaves the hand.
    pub fn leaving(&self) -> Option<String> {
        let (left_s, what) = match self.criteria.fate {
            Fate::Ejected { at_s } => (at_s, "reach of both fingers"),
            _ => (self.criteria.left_s?, "hand"),
        };
        Some(format!("the object left the {what} at {}, which ends the run", format_duration(left_s)))
    }

    /// Cycle of a hand that transports, releases or brakes its object.
    fn cycle(&self) -> Option<&CycleCriteria> {
        let cycle = &self.criteria.cycle;
        let has_brakes = cycle.brake_slip_rad.iter().any(Option::is_some);
        (cycle.motion_start_s.is_some() || cycle.release_s.is_some() || has_brakes).then_some(cycle)
    }

    /// Sentences about the position of the object in the hand, and about the cycle.
    pub fn motion(&self) -> String {
        let found = &self.criteria;
        let angle = |angle_rad: f64| resolved(angle_rad, Dimension::Angle, DEGREES, 4);
        let mut lines = Vec::new();
        // The middle of a palm is the origin of its frame.
        if let Some(ratio) = found.offset_ratio().filter(|_| self.has_palm_frame) {
            let effect = if ratio < 1.0 { "centres" } else { "does not centre" };
            let [start, end] = [found.start, found.last].map(|state| format_number(state.centre_m[0] * 1e3, 4));
            lines.push(format!(
                "the grasp {effect} the object: its offset from the middle changes from {start} mm to {end} mm"
            ));
        }
        let Some(cycle) = self.cycle() else { return lines.into_iter().map(|line| line + "\n").collect() };
        if let Some((from_s, slip)) = cycle.motion_start_s.zip(cycle.motion_travel) {
            lines.push(format!(
                "transport from {} {}: the object travels {} in the hand and rotates {} deg",
                ms(from_s),
                cycle.release_s.map_or("to the end".to_string(), |until_s| format!("to {}", ms(until_s))),
                distance(slip.displacement_m),
                angle(slip.rotation_rad)
            ));
        }
        let brake_slip = cycle.brake_slip_rad.iter().flatten().copied().reduce(f64::max);
        lines.extend(brake_slip.map(|rad| format!("joints with brakes rotate by up to {} deg", angle(rad))));
        lines.extend(cycle.release_s.map(|released_s| match cycle.opened_s.zip(opening_s(cycle)) {
            Some((opened_s, opening_s)) => format!(
                "released at {}; the hand is clear of the object {} later; cycle time {}",
                ms(released_s),
                ms(opening_s),
                ms(opened_s)
            ),
            None => format!("released at {}; the hand is not clear of the object at the end", ms(released_s)),
        }));
        lines.into_iter().map(|line| line + "\n").collect()
    }

    /// Table of the pairs that touched each other, and a line that names those that did not.
    pub fn pairs(&self, contacts: Option<&Contacts>) -> Report {
        let of_points = |pair: &PairCriteria, of: &dyn Fn(&ContactReport) -> Option<f64>| -> Vec<f64> {
            let points = pair.points.iter().filter_map(|index| contacts?.all.0.get(*index));
            points.filter_map(|(_, contact)| of(contact)).collect()
        };
        let depth_m = |pair: &PairCriteria| {
            let depths = of_points(pair, &|contact| match contact {
                ContactReport::Surface(surface) => surface.max_penetration_m,
                ContactReport::Limit(_) => None,
            });
            depths.into_iter().reduce(f64::max)
        };
        let impulse = |pair: &PairCriteria| {
            let impulses = of_points(pair, &|contact| match contact {
                ContactReport::Surface(surface) => Some(surface.impulse_n_s),
                ContactReport::Limit(_) => None,
            });
            impulses.into_iter().sum::<f64>()
        };
        let force = |force_n: f64| resolved(force_n, Dimension::Force, 1.0, 4);
        let centre = |[x, y]: [f64; 2]| {
            let [x, y] = [x, y].map(|part| resolved(part, Dimension::Length, 1e3, 4));
            format!("({x}, {y})")
        };
        let name = |name: &str| contacts.map_or_else(|| name.to_string(), |contacts| contacts.display_name(name));
        let mut text = Report::default();
        if self.touched().next().is_some() {
            text.push(table_of(
                self.touched(),
                &[
                    ("pair", &|pair| name(&pair.name)),
                    ("", &|pair| if pair.is_hand { "hand" } else { "surroundings" }.to_string()),
                    ("first, ms", &|pair| milliseconds(pair.first_s)),
                    ("normal, N", &|pair| force(pair.normal_n)),
                    ("friction, N", &|pair| force(pair.friction_n)),
                    ("used, %", &|pair| or_dash(pair.friction_used, percent)),
                    ("at, mm", &|pair| or_dash(pair.pressure_centre_m, centre)),
                    ("depth, µm", &|pair| or_dash(depth_m(pair), |depth_m| format_number(depth_m * 1e6, 4))),
                    ("impulse, mN·s", &|pair| format_number(impulse(pair) * 1e3, 4)),
                    ("lost", &|pair| pair.times_lost.to_string()),
                ],
            ));
        }
        let untouched: Vec<String> = self.untouched().into_iter().map(name).collect();
        text.push((!untouched.is_empty()).then(|| format!("never touched: {}\n", untouched.join(", "))));
        text
    }

    /// Table of the actuators.
    pub fn actuators(&self) -> Option<Report> {
        let all = &self.criteria.actuators;
        all.first()?;
        let unit = |actuator: &ActuatorCriteria, [linear, angular]: [&str; 2]| {
            if actuator.is_linear { linear.to_string() } else { angular.to_string() }
        };
        Some(table_of(
            all,
            &[
                ("actuator", &|actuator| actuator.name.clone()),
                ("largest effort", &|actuator| {
                    format!("{} {}", format_number(actuator.largest_effort, 4), unit(actuator, ["N", "N·m"]))
                }),
                ("rate", &|actuator| {
                    format!("{} {}", format_number(actuator.largest_rate, 4), unit(actuator, ["m/s", "rad/s"]))
                }),
                ("power, W", &|actuator| format_number(actuator.largest_power_w, 4)),
                ("energy, mJ", &|actuator| format_number(actuator.energy_j * 1e3, 4)),
                ("saturated", &|actuator| if actuator.saturated { "yes" } else { "no" }.to_string()),
            ],
        ))
    }
}

/// Time from the release until no body of the hand presses on the object.
fn opening_s(cycle: &CycleCriteria) -> Option<f64> {
    cycle.opened_s.zip(cycle.release_s).map(|(opened_s, released_s)| opened_s - released_s)
}

/// A time in milliseconds.
fn ms(time_s: f64) -> String {
    format!("{} ms", format_number(time_s * 1e3, 6))
}

/// Plural of a noun.
fn plural(word: &str) -> String {
    let ending = if ["s", "x", "ch", "sh"].iter().any(|ending| word.ends_with(ending)) { "es" } else { "s" };
    format!("{word}{ending}")
}

/// A fraction in percent.
fn percent(fraction: f64) -> String {
    format_number(fraction * 100.0, 2)
}

/// A length in the unit that suits it.
fn distance(length_m: f64) -> String {
    match length_m {
        length_m if length_m < 1e-9 => "0 µm".to_string(),
        length_m if length_m < 1e-3 => format!("{} µm", format_number(length_m * 1e6, 2)),
        length_m => format!("{} mm", format_number(length_m * 1e3, 3)),
    }
}

/// Describes a margin.
fn balances(margin: &Margin) -> String {
    match margin {
        Margin::Any => "balances any acceleration".to_string(),
        Margin::Limited { acceleration_m_s2, directions_rad, .. } => {
            let directions: Vec<String> =
                directions_rad.iter().map(|angle| format!("{:.0}", angle * DEGREES)).collect();
            let several = if directions.len() > 1 { "directions" } else { "direction" };
            // Limits that are rounding errors are 0.
            let size = match acceleration_m_s2 / G_M_S2 {
                small if small < 1e-9 => "0".to_string(),
                size => format_number(size, 2),
            };
            format!("balances {size} g in the worst {several} ({} deg)", directions.join(", "))
        }
        Margin::NotAtRest { remainder } => {
            format!("is not at rest at the end: {} % of the largest load is not balanced", percent(*remainder))
        }
        Margin::Undecided { reason } => format!("has an undecided margin: {reason}"),
    }
}

/// What moves beyond a limit, as a sentence without a full stop.
fn describe_failure(failure: &Failure) -> String {
    // The other outline of a pair is that of the object.
    let list = |names: &[String]| {
        let own: Vec<&str> = names.iter().map(|name| name.split('/').next().unwrap_or(name)).collect();
        match &own[..] {
            [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
            own => own.concat(),
        }
    };
    let verb = |names: &[String], one: &str, several: &str| (if names.len() == 1 { one } else { several }).to_string();
    let parts = [
        (&failure.slipping, ["slips", "slip"]),
        (&failure.tilting, ["tilts", "tilt"]),
        (&failure.separating, ["comes apart", "come apart"]),
        (&failure.yielding, ["yields", "yield"]),
        (&failure.rubbing, ["rubs", "rub"]),
    ];
    let moving = parts.into_iter().filter(|(names, _)| !names.is_empty());
    let text: Vec<String> =
        moving.map(|(names, [one, several])| format!("{} {}", list(names), verb(names, one, several))).collect();
    if text.is_empty() { "the whole hand moves".to_string() } else { text.join("; ") }
}

/// JSON of a margin: the acceleration is the text `any` without a limit, and null where there is none.
fn margin(found: &Margin) -> Object<'_> {
    match found {
        Margin::Any => Object::default().with("acceleration_m_s2", "any"),
        Margin::Limited { acceleration_m_s2, directions_rad, failure } => Object::default()
            .with("acceleration_m_s2", acceleration_m_s2)
            .with("directions_rad", directions_rad)
            .with("failure", failure),
        Margin::NotAtRest { remainder } => {
            Object::default().with("acceleration_m_s2", None::<f64>).with("unbalanced", remainder)
        }
        Margin::Undecided { reason } => Object::default().with("acceleration_m_s2", None::<f64>).with("reason", reason),
    }
}

impl Serialize for ObjectReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let found = &self.criteria;
        let pairs: Named<_> = found.pairs.iter().map(|pair| (pair.name.clone(), pair)).collect();
        let actuators: Named<_> = found.actuators.iter().map(|one| (one.name.clone(), one)).collect();
        let firmness = self.firmness.as_ref();
        let margins = firmness.map(|found| {
            Object::default().with("driven", margin(&found.driven)).with("blocked", margin(&found.blocked))
        });
        let position = self.has_palm_frame.then(|| found.offset_ratio());
        let cycle = self.cycle().map(|cycle| {
            Object::default()
                .with("carries_s", cycle.motion_start_s)
                .with("releases_s", cycle.release_s)
                .with("carried", cycle.motion_travel)
                .with("opened_s", cycle.opened_s)
                .with("opening_s", opening_s(cycle))
                .with("brake_slip_rad", &cycle.brake_slip_rad)
        });
        let states: Vec<(f64, &str)> = found.states.iter().map(|(time_s, state)| (*time_s, state.name())).collect();
        Object::default()
            // `held`, `carried`, `placed`, `dropped`, `ejected`, `escaped` or `not grasped`.
            .with("fate", found.fate.name())
            .with("fate_reason", &found.reason)
            .with("answer", self.answer())
            .with("object", &found.object)
            .with("base", &found.base)
            .with("assumed_hand", &found.assumed_hand)
            // Changes of the state, each with its time.
            .with("states", states)
            .with("grasped_s", found.grasped_s)
            .with("held_since_s", found.held_since_s)
            .with("tts_s", found.tts_s)
            // Time since which the object is no longer held, or at which it left a five-bar hand.
            .with("until_s", found.until_s)
            .with("escaped_s", found.escaped_s)
            .with("left_s", found.left_s)
            .with("contacts_lost", found.contacts_lost())
            .with("slip", found.slip)
            .with("creep_m_s", found.creep_m_s)
            .with("grip_n", found.grip_n())
            .with("friction_used", found.friction_used())
            .with("margin", margins)
            .with("form_closed", firmness.and_then(|found| found.form_closed))
            .with("q1", firmness.map(|found| found.force_closure.q1_l1))
            .with("force_closure", firmness.map(|found| force_closure(&found.force_closure)))
            .with("speed_m_s", found.end_speed_m_s())
            .with("travel", found.travel)
            // Position of the object along the palm from its middle; the ratio is null if it started centred.
            .with_some("x_start_m", position.map(|_| found.start.centre_m[0]))
            .with_some("x_end_m", position.map(|_| found.last.centre_m[0]))
            .with_some("offset_ratio", position)
            .with_some("cycle", cycle)
            .with("pairs", pairs)
            .with("never_touched", self.untouched())
            .with("actuators", actuators)
            .serialize(serializer)
    }
}

/// JSON object of a force closure. A wrench is a force and a moment divided by the object's radius, for normal forces
/// that add up to 1 (`q1_l1`) or are at most 1 each (`q1_linf`).
pub(super) fn force_closure(found: &ForceClosure) -> Object<'static> {
    Object::default()
        .with("closed", found.closed)
        .with("q1_l1", found.q1_l1)
        .with("q1_linf", found.q1_linf)
        .with("weakest", found.weakest)
}

#[cfg(test)]
mod tests {
    #[test]
    fn plurals_of_outlines_are_those_of_their_endings() {
        for (word, expected) in [("pad", "pads"), ("boss", "bosses"), ("box", "boxes"), ("notch", "notches")] {
            assert_eq!(super::plural(word), expected);
        }
    }
}

//! The contacts of a playback. All points of a pair of outlines are one contact, since a flat pad touches with several.

use crate::mechanism::{Mechanism, OutlineId};
use crate::numeric::elementary::hypot;
use crate::numeric::plane::{add, scale};
use crate::scene::Scene;
use crate::trace::schema::State;
use crate::trace::{ContactSample, Event, Sample};

/// Maximum number of contacts shown if none closes.
const MAX_IDLE: usize = 6;
/// Number of contacts up to which all are shown.
const MAX_ALWAYS: usize = 2;

/// A contact as pages show it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ShownContact {
    pub name: String,
    /// Its contacts in samples, and the signs of their normals.
    points: Vec<(usize, f64)>,
}

impl ShownContact {
    /// Whether a contact of samples belongs to this contact.
    pub fn contains(&self, contact: usize) -> bool {
        self.points.iter().any(|(index, _)| *index == contact)
    }

    /// State of the contact: the sums of the forces, which act at their common centre, and the smallest gap.
    pub fn state(&self, sample: &Sample) -> ContactSample {
        let point = |&(index, sign): &(usize, f64)| {
            let contact = sample.contact(index);
            ContactSample { normal: scale(contact.normal, sign), ..contact }
        };
        let points: Vec<ContactSample> = self.points.iter().map(point).collect();
        let closest = points.iter().copied().min_by(|a, b| a.gap_m.total_cmp(&b.gap_m)).expect("a point");
        let normal_n: f64 = points.iter().map(|point| point.normal_n).sum();
        // The state of a single point is unchanged to the bit.
        if points.len() == 1 || normal_n <= 0.0 {
            return closest;
        }
        let mean = |value: fn(&ContactSample) -> [f64; 2]| {
            points.iter().fold([0.0; 2], |sum, point| add(sum, scale(value(point), point.normal_n / normal_n)))
        };
        let [x, y] = mean(|point| point.normal);
        ContactSample {
            normal_n,
            tangential_n: points.iter().map(|point| point.tangential_n).sum(),
            point_m: mean(|point| point.point_m),
            normal: scale([x, y], hypot(x, y).recip()),
            ..closest
        }
    }

    /// Returns the quantity of [`ContactSample`] with this key.
    pub fn value(&self, sample: &Sample, key: &str) -> f64 {
        let index = ContactSample::QUANTITIES.iter().position(|quantity| quantity.key == key);
        self.state(sample).values()[index.expect("a key of contacts")]
    }
}

/// Returns the contacts that a page shows: those that close; all of a few, and the first ones if none closes.
pub(super) fn shown_contacts(scene: &Scene, samples: &[Sample], events: &[Event]) -> Vec<ShownContact> {
    let mut all = pairs_of_outlines(&scene.drawn_mechanism());
    all.iter_mut().for_each(|contact| contact.name = display_name(scene, &contact.name));
    if all.len() <= MAX_ALWAYS {
        return all;
    }
    let closes = |contact: &ShownContact| {
        let presses = |sample: &Sample| contact.points.iter().any(|(index, _)| sample.contact(*index).normal_n > 0.0);
        events.iter().any(|event| contact.contains(event.contact)) || samples.iter().any(presses)
    };
    let closing: Vec<ShownContact> = all.iter().filter(|contact| closes(contact)).cloned().collect();
    all.truncate(MAX_IDLE);
    if closing.is_empty() { all } else { closing }
}

/// Name of a contact of samples. Keys of hands become words; names given by the user are unchanged.
pub(super) fn display_name(scene: &Scene, name: &str) -> String {
    if scene.hand.fingers.is_empty() { name.to_owned() } else { name.replace('_', " ") }
}

/// The pairs of outlines of a mechanism. The first outline of a pair is that of a link rather than of an object, and of
/// an object rather than of the ground; forces act on it.
fn pairs_of_outlines(mechanism: &Mechanism) -> Vec<ShownContact> {
    let order = |id: OutlineId| (id.body.is_none(), !mechanism.has_joint(id.body), id.body, id.outline);
    let mut pairs: Vec<([OutlineId; 2], ShownContact)> = Vec::new();
    for (index, contact) in mechanism.point_contacts().iter().enumerate() {
        let pair = &mechanism.contacts[contact.pair];
        let is_first = order(pair.points) <= order(pair.face);
        let key = if is_first { [pair.points, pair.face] } else { [pair.face, pair.points] };
        let sign = if is_first == pair.is_reported_on_face { -1.0 } else { 1.0 };
        match pairs.iter_mut().find(|(other, _)| *other == key) {
            Some((_, shown)) => shown.points.push((index, sign)),
            None => {
                let of_outlines = || key.map(|id| label(mechanism, id)).join(" / ");
                let name = pair.name.clone().unwrap_or_else(of_outlines);
                pairs.push((key, ShownContact { name, points: vec![(index, sign)] }));
            }
        }
    }
    pairs.into_iter().map(|(_, shown)| shown).collect()
}

/// Name of an outline; that of its body if no other outline of the body makes contact.
fn label(mechanism: &Mechanism, id: OutlineId) -> String {
    let mut outlines = mechanism.contacts.iter().flat_map(|contact| [contact.points, contact.face]);
    let is_only = outlines.all(|other| other.body != id.body || other.outline == id.outline);
    if id.body.is_some() && is_only { mechanism.body_name(id.body).to_owned() } else { mechanism.outline_name(id) }
}

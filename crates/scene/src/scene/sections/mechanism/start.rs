//! Checks of the assembled start: no outlines deep in each other, and no joint beyond its limit.

use super::contact::ListedPair;
use super::mirror::Entries;
use crate::limits::{MAX_START_EXCESS_M, MAX_START_EXCESS_RAD, MAX_START_OVERLAP_M};
use crate::mechanism::{Joint, Limit, Measure, Mechanism, Pose};
use crate::scene::section_input::SectionInput;

/// Reports outlines that overlap deeply at the start at the entries of their contacts, and joints beyond their limits at
/// their sections.
pub(super) fn check_start(mechanism: &Mechanism, poses: &[Pose], pairs: &[ListedPair<'_>], joints: &Entries<'_>) {
    for (index, message) in deep_overlaps(mechanism, poses) {
        let help = "move the bodies apart at the start: `guess` or `start` of the bodies, `start` of the joints; or remove the \
                    pair from the contacts";
        pairs[index].1.report("", message, "starts inside", help);
    }
    let exceeded = mechanism.exceeded_limits(poses, MAX_START_EXCESS_RAD, MAX_START_EXCESS_M);
    let partners = joints.partners();
    let is_exceeded = |joint: usize| exceeded.iter().any(|(limit, ..)| limit.joint == joint);
    for &(limit, coordinate, excess) in &exceeded {
        // An image has the limits of its original.
        if !joints.is_image(limit.joint) || !is_exceeded(partners[limit.joint]) {
            report_excess(joints.section(limit.joint), &mechanism.joints[limit.joint], limit, coordinate, excess);
        }
    }
}

fn report_excess(section: &SectionInput<'_>, joint: &Joint, limit: Limit, coordinate: f64, excess: f64) {
    let measure = |value: f64| Measure::of(joint.kind, value);
    let (side, allowed) = if limit.side > 0.0 { ("upper", "most") } else { ("lower", "least") };
    let [coordinate, value] = Measure::distinct([coordinate, limit.value].map(measure));
    let message = format!(
        "the joint `{}` starts {} beyond its {side} limit: its coordinate is {coordinate}, but must be at {allowed} {value}",
        joint.name,
        measure(excess)
    );
    let key = if section.has("start") { "start" } else { side };
    let help = format!("change the start, from which all coordinates follow, or move the limit: `{side}`");
    section.report(key, message, "beyond the limit", help);
}

/// Pairs of contacts that overlap deeply in these poses, with a message.
pub(crate) fn deep_overlaps(mechanism: &Mechanism, poses: &[Pose]) -> Vec<(usize, String)> {
    let message = |(index, depth_m): (usize, f64)| {
        let pair = &mechanism.contacts[index];
        let [points, face] = [pair.points, pair.face].map(|id| mechanism.outline_name(id));
        let [depth, limit] = Measure::distinct([depth_m, MAX_START_OVERLAP_M].map(Measure::Length));
        (index, format!("`{points}` starts {depth} inside `{face}`, but at most {limit} is allowed"))
    };
    mechanism.deep_overlaps(poses, MAX_START_OVERLAP_M).into_iter().map(message).collect()
}

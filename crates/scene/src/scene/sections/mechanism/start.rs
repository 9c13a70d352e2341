//! Checks of the assembled start: no outlines deep in each other, and no joint beyond its limit.

use super::contact::ListedPair;
use super::mirror::Entries;
use crate::limits::{MAX_START_EXCESS_M, MAX_START_EXCESS_RAD, MAX_START_OVERLAP_M};
use crate::mechanism::{Limit, Limited, Measure, Mechanism, Pose};
use crate::scene::section_input::SectionInput;

/// Reports outlines that overlap deeply at the start at the entries of their contacts, and joints beyond their limits at
/// their sections.
pub(super) fn check_start(
    mechanism: &Mechanism,
    poses: &[Pose],
    pairs: &[ListedPair<'_>],
    [joints, sums]: [&Entries<'_>; 2],
) {
    for (index, message) in deep_overlaps(mechanism, poses) {
        let help = "move the bodies apart at the start: `guess` or `start` of the bodies, `start` of the joints; or remove the \
                    pair from the contacts";
        pairs[index].1.report("", message, "starts inside", help);
    }
    let exceeded = mechanism.exceeded_limits(poses, MAX_START_EXCESS_RAD, MAX_START_EXCESS_M);
    for &(limit, coordinate, excess) in &exceeded {
        let (entries, index, partner): (_, _, fn(usize) -> Limited) = match limit.of {
            Limited::Joint(joint) => (joints, joint, Limited::Joint),
            Limited::Sum(sum) => (sums, sum, Limited::Sum),
        };
        let partner = partner(entries.partners()[index]);
        // An image has the limits of its original.
        if !entries.is_image(index) || !exceeded.iter().any(|(limit, ..)| limit.of == partner) {
            report_excess(mechanism, entries.section(index), limit, coordinate, excess);
        }
    }
}

fn report_excess(mechanism: &Mechanism, section: &SectionInput<'_>, limit: Limit, coordinate: f64, excess: f64) {
    let joint = &mechanism.joints[mechanism.limited(&limit).terms[0].0];
    let what = match limit.of {
        Limited::Joint(_) => format!("joint `{}`", joint.name),
        Limited::Sum(sum) => format!("sum of the limits `{}`", mechanism.sum_limits[sum].name),
    };
    let measure = |value: f64| Measure::of(joint.kind, value);
    let (side, allowed) = if limit.side > 0.0 { ("upper", "most") } else { ("lower", "least") };
    let [coordinate, value] = Measure::distinct([coordinate, limit.value].map(measure));
    let message = format!(
        "the {what} starts {} beyond its {side} limit: its coordinate is {coordinate}, but must be at {allowed} {value}",
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

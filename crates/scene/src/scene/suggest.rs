//! Suggestions for mistyped keys and keywords, and for features that phalanx does not support.

/// Unsupported features, one per line: the section they are expected in (empty: any), their keys, the reason, and the
/// alternative.
const UNSUPPORTED: &str = "\
|l31 l32 t32 phi32 q31 q32 phalanges n_phalanges third_phalanx medial middle intermediate links n_links joints n_joints|\
    a finger has two phalanges, l21 and t22|leave further ones out; t22 and phi22 shape the distal phalanx
|fingers n_fingers thumb|a scene has one finger, or two that face each other|choose by kind = \"finger\" or kind = \"gripper\"
|shape box square rectangle cuboid polygon vertices ellipse cylinder sphere sides corners diameter|every object is a disc|\
    give its radius; replace a rounded body by a disc with its curvature at the contact
|ground pivot pivots ground_pivot ground_pivots ground_joint ground_joints ground_link base_link base_joint anchor l0 l01|\
    l11 and l21 share one ground joint|place the object by the base of [design] or [lengths]; palm_width is the distance of two fingers
|control controller pid pd kp ki kd gain gains servo setpoint target target_angle position position_control velocity_control feedback|\
    a motor has a torque over time and no controller|set [motor] profile = \"ramp\", \"reversal\" or \"table\"; to hold a position, use the brake of a gripper
contact|law model normal type restitution hunt-crossley hunt_crossley kelvin-voigt hertz|\
    the normal law is stiffness × depth^exponent with a damper that engages over `transition`|\
    set these four, or [contact.materials] for Hertz; there are two friction laws: contact.friction.law = \"regularised\" or \"bristle\"";

/// Returns why phalanx does not support a key or value in a section, and the alternative.
pub(crate) fn find_unsupported(path: &str, word: &str) -> Option<(&'static str, &'static str)> {
    let word = word.to_lowercase();
    UNSUPPORTED.lines().find_map(|line| {
        let [section, unsupported_words, reason, instead] = line.split('|').collect::<Vec<_>>().try_into().ok()?;
        let is_expected_here = section.is_empty() || path.split('.').any(|part| part == section);
        (is_expected_here && unsupported_words.split(' ').any(|known| known == word)).then_some((reason, instead))
    })
}

/// Returns the candidate nearest to `word`, if it is similar enough to suggest.
pub fn closest_match<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let word = word.to_lowercase();
    // Among candidates that contain the word, the shortest is preferred: `pfp_n` before `static_pfp_n`.
    let containing = candidates.iter().filter(|candidate| word.len() > 2 && candidate.to_lowercase().contains(&word));
    if let Some(containing_candidate) =
        containing.min_by_key(|candidate| (!candidate.to_lowercase().starts_with(&word), candidate.len()))
    {
        return Some(containing_candidate);
    }
    candidates
        .iter()
        .map(|candidate| (strsim::damerau_levenshtein(&word, &candidate.to_lowercase()), *candidate))
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len().max(word.len()) / 4)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggests_similar_words_only() {
        let keys = ["radius", "centre", "present"];
        assert_eq!(closest_match("raduis", &keys), Some("radius"));
        assert_eq!(closest_match("center", &keys), Some("centre"));
        assert_eq!(closest_match("Radius", &keys), Some("radius"));
        assert_eq!(closest_match("sine", &["ramp", "half-sine"]), Some("half-sine"));
        let columns = ["static_pfp_n", "peak_pfp_n", "pfp_n", "pfp_share"];
        assert_eq!(
            ["pfp", "pfp_N", "static"].map(|word| closest_match(word, &columns)),
            ["pfp_n", "pfp_n", "static_pfp_n"].map(Some)
        );
        assert_eq!(closest_match("colour", &keys), None);
        assert_eq!(closest_match("", &keys), None);
    }
}

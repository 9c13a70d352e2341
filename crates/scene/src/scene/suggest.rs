//! The allowed word a mistyped one was probably meant to be, and what is looked for in vain.

/// What phalanx does not have, a line each: the section in which it is looked for (none: any), its words, why, and what to do instead.
const ABSENT: &str = "\
|l31 l32 t32 phi32 q31 q32 phalanges n_phalanges third_phalanx medial middle intermediate links n_links joints n_joints|\
    a finger has two phalanges, l21 and t22|leave further ones out; t22 and phi22 shape the distal phalanx
|fingers n_fingers thumb|a scene has one finger, or two that face each other|choose by kind = \"finger\" or kind = \"gripper\"
|shape box square rectangle cuboid polygon vertices ellipse cylinder sphere sides corners diameter|every object is a disc|\
    give its radius; a rounded body is a disc of the curvature that it has where it is touched
|ground pivot pivots ground_pivot ground_pivots ground_joint ground_joints ground_link base_link base_joint anchor l0 l01|\
    l11 and l21 turn about one ground joint|place the object by the base of [design] or [lengths]; two fingers are palm_width apart
|control controller pid pd kp ki kd gain gains servo setpoint target target_angle position position_control velocity_control feedback|\
    a motor has a torque over time and no controller|give it: [motor] profile = \"ramp\", \"reversal\" or \"table\"; a gripper's brake holds
contact|law model normal type restitution hunt-crossley hunt_crossley kelvin-voigt hertz|\
    the normal law is stiffness × depth^exponent with a damper that engages over `transition`|\
    give these four, or [contact.materials] for Hertz; there are two laws of friction: contact.friction.law = \"regularised\" or \"bristle\"";

/// Why phalanx has no such key or value at a place, and what to do instead.
pub fn absent(path: &str, word: &str) -> Option<(&'static str, &'static str)> {
    let word = word.to_lowercase();
    ABSENT.lines().find_map(|line| {
        let [section, words, why, instead] = line.split('|').collect::<Vec<_>>().try_into().ok()?;
        let is_there = section.is_empty() || path.split('.').any(|part| part == section);
        (is_there && words.split(' ').any(|known| known == word)).then_some((why, instead))
    })
}

/// The candidate nearest to `word`, if it is near enough to be worth a question.
pub fn nearest<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let word = word.to_lowercase();
    // Of those that contain the word, the one that adds least to it: `pfp_n` before `static_pfp_n`.
    let containing = candidates.iter().filter(|c| word.len() > 2 && c.to_lowercase().contains(&word));
    if let Some(whole) = containing.min_by_key(|c| (!c.to_lowercase().starts_with(&word), c.len())) {
        return Some(whole);
    }
    candidates
        .iter()
        .map(|c| (strsim::damerau_levenshtein(&word, &c.to_lowercase()), *c))
        .filter(|(distance, c)| *distance <= 1 + c.len().max(word.len()) / 4)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, c)| c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_words_are_suggested_and_far_ones_are_not() {
        let keys = ["radius", "centre", "present"];
        assert_eq!(nearest("raduis", &keys), Some("radius"));
        assert_eq!(nearest("center", &keys), Some("centre"));
        assert_eq!(nearest("Radius", &keys), Some("radius"));
        assert_eq!(nearest("sine", &["ramp", "half-sine"]), Some("half-sine"));
        let columns = ["static_pfp_n", "peak_pfp_n", "pfp_n", "pfp_share"];
        assert_eq!(
            ["pfp", "pfp_N", "static"].map(|word| nearest(word, &columns)),
            ["pfp_n", "pfp_n", "static_pfp_n"].map(Some)
        );
        assert_eq!(nearest("colour", &keys), None);
        assert_eq!(nearest("", &keys), None);
    }
}

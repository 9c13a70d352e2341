//! The allowed word a mistyped one was probably meant to be.

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

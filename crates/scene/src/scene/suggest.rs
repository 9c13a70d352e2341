//! The allowed word a mistyped one was probably meant to be.

/// The candidate nearest to `word`, if it is near enough to be worth a question.
pub fn nearest<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let word = word.to_lowercase();
    let part = |c: &&&str| word.len() > 2 && c.contains(&word);
    if let Some(whole) = candidates.iter().find(part) {
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
        assert_eq!(nearest("colour", &keys), None);
        assert_eq!(nearest("", &keys), None);
    }
}

//! Pictures that read on a dark ground too: each colour of the light scheme has one that stands for it.

/// Colours as they are written in a picture, and what stands for them on a dark ground; the same as in the style sheet of
/// the page, where it has them.
const COLOURS: [(&str, &str); 22] = [
    ("#FFFFFF", "#1b1f26"),
    ("#000000", "#eceff3"),
    ("#787878", "#a7b0bd"),
    ("#E8E8E8", "#3a424e"),
    ("#F6F6F6", "#2a3039"),
    ("#0072B2", "#56b4e9"),
    ("#D55E00", "#ff9a52"),
    ("#009E73", "#3ccb9c"),
    ("#AA508C", "#dd95c7"),
    ("#C88C00", "#e3b84a"),
    // The finger, its object and its palm.
    ("#B9C2CF", "#4c5766"),
    ("#D3D9E2", "#3a4350"),
    ("#A9D2EC", "#1f5678"),
    ("#F5C7A1", "#7d4316"),
    ("#E3DCCB", "#4a453a"),
    ("#E4E7EC", "#262c35"),
    // Grounds of words: these change with them.
    ("#CEE4F5", "#1f4560"),
    ("#E69F00", "#7a5400"),
    ("#5E184A", "#d39cc0"),
    ("#B2D3E9", "#1f5678"),
    ("#D8D8D8", "#4a525e"),
    // What is not stable stays apart from the ground, which is where there is no finger.
    ("#2B2F36", "#5d6570"),
];

/// The picture with both schemes. Only a picture that is a document of its own takes the scheme of its reader: one within a
/// page has that of the page, which may be another.
pub(super) fn with_dark(svg: &str) -> String {
    let Some((head, rest)) = svg.split_once('>') else { return svg.to_string() };
    let mut rules = String::new();
    for (light, dark) in COLOURS {
        for property in ["fill", "stroke"] {
            if rest.contains(&format!("{property}=\"{light}\"")) {
                rules += &format!("svg:root [{property}=\"{light}\"]{{{property}:{dark}}}\n");
            }
        }
    }
    format!("{head}>\n<style>@media (prefers-color-scheme:dark){{\n{rules}}}</style>{rest}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_colour_of_a_picture_has_one_for_the_dark() {
        let svg = "<svg width=\"9\">\n<rect fill=\"#FFFFFF\"/><path stroke=\"#0072B2\" fill=\"none\"/></svg>\n";
        let both = with_dark(svg);
        assert!(both.contains("svg:root [fill=\"#FFFFFF\"]{fill:#1b1f26}"));
        assert!(both.contains("svg:root [stroke=\"#0072B2\"]{stroke:#56b4e9}"));
        assert!(!both.contains("#009E73"), "only what is there");
        // Nothing else is changed.
        let (head, rest) = both.split_once("\n<style>").expect("a style");
        assert_eq!(head.to_string() + rest.split_once("</style>").expect("its end").1, svg);
    }
}

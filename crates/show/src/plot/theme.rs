//! Colours of pictures and pages, on a light and on a dark ground: the one place where each is said. A picture has them as attributes,
//! which everything that shows pictures reads, and a style sheet by which variables of these names take their place; pages set those.

use std::collections::BTreeSet;
use std::fmt::{Display, Formatter, Result, Write};

/// Red, green and blue, on a light ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Colour(pub u8, pub u8, pub u8);

impl Display for Colour {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "#{:02X}{:02X}{:02X}", self.0, self.1, self.2)
    }
}

pub const PAPER: Colour = Colour(255, 255, 255);
pub const INK: Colour = Colour(27, 31, 38);
/// Of what is said beside, lines of the grid and those between them.
pub const SOFT: Colour = Colour(86, 94, 107);
pub const LINE: Colour = Colour(213, 217, 224);
pub const FAINT: Colour = Colour(233, 236, 240);
/// Colours that stay apart for every kind of eye (Okabe and Ito), so dark that words in them can be read.
pub const BLUE: Colour = Colour(0, 114, 178);
pub const ORANGE: Colour = Colour(199, 83, 0);
pub const GREEN: Colour = Colour(0, 135, 95);
pub const PURPLE: Colour = Colour(156, 69, 132);
pub const AMBER: Colour = Colour(143, 100, 0);
pub const GREY: Colour = Colour(95, 103, 115);
/// Of curves, in turn.
pub const SERIES: [Colour; 6] = [BLUE, ORANGE, GREEN, PURPLE, AMBER, GREY];
/// The parts of a finger and what is around it.
pub const DRIVER: Colour = Colour(185, 194, 207);
pub const COUPLER: Colour = Colour(211, 217, 226);
pub const PROXIMAL: Colour = Colour(169, 210, 236);
pub const DISTAL: Colour = Colour(245, 199, 161);
pub const OBJECT: Colour = Colour(227, 220, 203);
pub const PALM: Colour = Colour(228, 231, 236);
/// Letters of angles and of forces.
pub const ANGLE: Colour = Colour(0, 90, 156);
pub const FORCE: Colour = Colour(179, 38, 30);
/// Cells of a table of colours; words can stand on the first three.
pub const FINE: Colour = Colour(206, 228, 245);
pub const DOUBTFUL: Colour = Colour(230, 159, 0);
pub const BROKEN: Colour = Colour(94, 24, 74);
pub const PALE_BLUE: Colour = Colour(178, 211, 233);
pub const NEUTRAL: Colour = Colour(216, 216, 216);
/// Classes and other verdicts, from good to bad.
pub const VERDICTS: [Colour; 4] = [BLUE, PALE_BLUE, DOUBTFUL, NEUTRAL];
/// Where a grasp is not stable.
pub const UNSTABLE: Colour = Colour(43, 47, 54);

/// Colours that change with the ground: each with its variable and what it is on a dark ground.
const THEME: [(Colour, &str, &str); 25] = [
    (PAPER, "panel", "#1b1f26"),
    (INK, "ink", "#eceff3"),
    (SOFT, "soft", "#a7b0bd"),
    (LINE, "line", "#3a424e"),
    (FAINT, "faint", "#2a3039"),
    (BLUE, "s0", "#56b4e9"),
    (ORANGE, "s1", "#ff9a52"),
    (GREEN, "s2", "#3ccb9c"),
    (PURPLE, "s3", "#dd95c7"),
    (AMBER, "s4", "#e3b84a"),
    (GREY, "s5", "#aab2be"),
    (DRIVER, "driver", "#4c5766"),
    (COUPLER, "coupler", "#3a4350"),
    (PROXIMAL, "proximal", "#1f5678"),
    (DISTAL, "distal", "#7d4316"),
    (OBJECT, "object", "#4a453a"),
    (PALM, "palm", "#262c35"),
    (ANGLE, "accent", "#63b7f0"),
    (FORCE, "force", "#ff8078"),
    (FINE, "fine", "#1f4560"),
    (DOUBTFUL, "doubtful", "#7a5400"),
    (BROKEN, "broken", "#d39cc0"),
    (PALE_BLUE, "pale", "#1f5678"),
    (NEUTRAL, "neutral", "#4a525e"),
    // What is not stable stays apart from the ground, which is where there is no finger.
    (UNSTABLE, "unstable", "#5d6570"),
];

/// The variables of a page, in its light scheme and in its dark one.
pub fn variables() -> String {
    let light: String = THEME.iter().map(|(colour, name, _)| format!("--{name}:{colour};")).collect();
    let dark: String = THEME.iter().map(|(_, name, colour)| format!("--{name}:{colour};")).collect();
    format!(":root{{{light}}}\n:root[data-theme=\"dark\"]{{{dark}}}\n")
}

/// The variable of a colour on a page.
pub fn variable(colour: Colour) -> &'static str {
    THEME.iter().find(|(known, ..)| *known == colour).map_or("ink", |(_, name, _)| name)
}

/// The style sheet of a picture that has these attributes. Only a picture that is a document of its own takes the scheme of its reader: one
/// within a page has that of the page. What knows no variables does not read the first rule, and keeps to the attributes.
pub fn style(used: &BTreeSet<(&'static str, Colour)>) -> String {
    let (mut rules, mut dark) = (String::new(), BTreeSet::new());
    for (colour, name, on_dark) in THEME {
        for (attribute, _) in used.iter().filter(|(_, of)| *of == colour) {
            // Writing to a string cannot fail.
            let _ = writeln!(rules, "[{attribute}=\"{colour}\"]{{{attribute}:var(--{name},{colour})}}");
            dark.insert(format!("--{name}:{on_dark}"));
        }
    }
    let dark: Vec<String> = dark.into_iter().collect();
    format!(
        "@supports(fill:var(--ink)){{\n{rules}}}\n@media(prefers-color-scheme:dark){{svg:root{{{}}}}}\n",
        dark.join(";")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_colour_that_is_there_has_a_variable_and_one_for_the_dark() {
        let sheet = style(&BTreeSet::from([("fill", PAPER), ("stroke", BLUE), ("fill", Colour(1, 2, 3))]));
        assert!(sheet.contains("[fill=\"#FFFFFF\"]{fill:var(--panel,#FFFFFF)}"));
        assert!(sheet.contains("[stroke=\"#0072B2\"]{stroke:var(--s0,#0072B2)}"));
        assert!(sheet.contains("dark){svg:root{--panel:#1b1f26;--s0:#56b4e9}}"), "{sheet}");
        assert!(!sheet.contains(&GREEN.to_string()) && !sheet.contains("#010203"), "only what is there and changes");
    }

    #[test]
    fn a_colour_has_one_variable_and_a_variable_one_colour() {
        let (colours, names): (BTreeSet<_>, BTreeSet<_>) =
            THEME.iter().map(|(colour, name, _)| (*colour, *name)).unzip();
        assert_eq!([colours.len(), names.len()], [THEME.len(); 2]);
        let page = variables();
        assert!(page.starts_with(":root{--panel:#FFFFFF;") && page.contains("[data-theme=\"dark\"]{--panel:#1b1f26;"));
    }
}

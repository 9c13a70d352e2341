//! Colours of pictures and pages for light and dark backgrounds. A picture contains them as attributes, which every
//! viewer supports, and a style sheet that replaces them by CSS variables, which pages set.

use std::collections::BTreeSet;
use std::fmt::{Display, Formatter, Result, Write};

/// Red, green and blue, for a light background.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Colour(pub u8, pub u8, pub u8);

impl Display for Colour {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "#{:02X}{:02X}{:02X}", self.0, self.1, self.2)
    }
}

/// Background.
pub const PAPER: Colour = Colour(255, 255, 255);
/// Primary text and outlines.
pub const INK: Colour = Colour(27, 31, 38);
/// Secondary text and lines.
pub const SOFT: Colour = Colour(86, 94, 107);
/// Major grid lines.
pub(crate) const LINE: Colour = Colour(213, 217, 224);
/// Minor grid lines.
pub(crate) const FAINT: Colour = Colour(233, 236, 240);
/// First curve colour.
pub const BLUE: Colour = Colour(0, 114, 178);
/// Second curve colour.
pub const ORANGE: Colour = Colour(199, 83, 0);
/// Third curve colour.
pub const GREEN: Colour = Colour(0, 135, 95);
/// Fourth curve colour.
pub const PURPLE: Colour = Colour(156, 69, 132);
/// Fifth curve colour.
pub const AMBER: Colour = Colour(143, 100, 0);
/// Sixth curve colour.
pub(crate) const GREY: Colour = Colour(95, 103, 115);
/// Colours of successive curves: distinguishable with colour blindness (Okabe and Ito), and dark enough for text.
pub const SERIES: [Colour; 6] = [BLUE, ORANGE, GREEN, PURPLE, AMBER, GREY];
/// Driven link l11.
pub(crate) const DRIVER: Colour = Colour(185, 194, 207);
/// Coupler l12.
pub(crate) const COUPLER: Colour = Colour(211, 217, 226);
/// Proximal phalanx l21.
pub(crate) const PROXIMAL: Colour = Colour(169, 210, 236);
/// Distal phalanx l22.
pub(crate) const DISTAL: Colour = Colour(245, 199, 161);
/// Grasped object.
pub const OBJECT: Colour = Colour(227, 220, 203);
/// Palm.
pub const PALM: Colour = Colour(228, 231, 236);
/// Arcs and symbols of angles.
pub const ANGLE: Colour = Colour(0, 90, 156);
/// Arrows and symbols of forces.
pub const FORCE: Colour = Colour(179, 38, 30);
/// Cell of an accurate run; dark text is legible on it.
pub const FINE: Colour = Colour(206, 228, 245);
/// Cell of an inaccurate run or of the third verdict; dark text is legible on it.
pub const DOUBTFUL: Colour = Colour(230, 159, 0);
/// Cell of a failed run; light text is legible on it.
pub const BROKEN: Colour = Colour(94, 24, 74);
/// Cell of the second-best verdict.
pub const PALE_BLUE: Colour = Colour(178, 211, 233);
/// Cell of the worst verdict.
pub const NEUTRAL: Colour = Colour(216, 216, 216);
/// Classes and other verdicts, from best to worst.
pub const VERDICTS: [Colour; 4] = [BLUE, PALE_BLUE, DOUBTFUL, NEUTRAL];
/// Region of unstable grasps.
pub const UNSTABLE: Colour = Colour(43, 47, 54);

/// Colours with their variables and their values on a dark background.
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
    // Unstable regions must differ from the background, which marks regions without a finger.
    (UNSTABLE, "unstable", "#5d6570"),
];

/// CSS variables of a page for its light and dark schemes.
pub fn variables() -> String {
    let light: String = THEME.iter().map(|(colour, name, _)| format!("--{name}:{colour};")).collect();
    let dark: String = THEME.iter().map(|(_, name, colour)| format!("--{name}:{colour};")).collect();
    format!(":root{{{light}}}\n:root[data-theme=\"dark\"]{{{dark}}}\n")
}

/// Name of the CSS variable of a colour.
pub fn variable(colour: Colour) -> &'static str {
    THEME.iter().find(|(known, ..)| *known == colour).map_or("ink", |(_, name, _)| name)
}

/// Style sheet of a picture with these attributes and colours. Only a standalone picture follows the colour scheme of
/// the viewer; one in a page follows the page. Viewers without support for variables ignore the first rule and use the
/// attributes.
pub fn style(used: &BTreeSet<(&'static str, Colour)>) -> String {
    let (mut rules, mut dark) = (String::new(), BTreeSet::new());
    for (colour, name, on_dark) in THEME {
        for (attribute, _) in used.iter().filter(|(_, other_colour)| *other_colour == colour) {
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
    fn style_sheet_contains_exactly_the_themed_colours_in_use() {
        let sheet = style(&BTreeSet::from([("fill", PAPER), ("stroke", BLUE), ("fill", Colour(1, 2, 3))]));
        assert!(sheet.contains("[fill=\"#FFFFFF\"]{fill:var(--panel,#FFFFFF)}"));
        assert!(sheet.contains("[stroke=\"#0072B2\"]{stroke:var(--s0,#0072B2)}"));
        assert!(sheet.contains("dark){svg:root{--panel:#1b1f26;--s0:#56b4e9}}"), "{sheet}");
        assert!(!sheet.contains(&GREEN.to_string()) && !sheet.contains("#010203"), "only themed colours in use");
    }

    #[test]
    fn colours_and_variables_correspond_one_to_one() {
        let (colours, names): (BTreeSet<_>, BTreeSet<_>) =
            THEME.iter().map(|(colour, name, _)| (*colour, *name)).unzip();
        assert_eq!([colours.len(), names.len()], [THEME.len(); 2]);
        let page = variables();
        assert!(page.starts_with(":root{--panel:#FFFFFF;") && page.contains("[data-theme=\"dark\"]{--panel:#1b1f26;"));
    }
}

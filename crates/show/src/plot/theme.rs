//! Colours of pictures and pages for light and dark backgrounds, and colour scales. A picture contains colours as
//! attributes, which every viewer supports, and a style sheet that replaces them by CSS variables, which pages set.

use std::collections::BTreeSet;
use std::fmt::{Display, Formatter, Result, Write};

/// A colour for a light background. A themed colour also has a CSS variable and a value for a dark background.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour {
    rgb: [u8; 3],
    /// Name of the CSS variable; empty for a colour that is the same on all backgrounds.
    variable: &'static str,
    on_dark: &'static str,
}

impl Colour {
    const fn fixed(rgb: [u8; 3]) -> Colour {
        Colour { rgb, variable: "", on_dark: "" }
    }

    const fn themed(rgb: [u8; 3], variable: &'static str, on_dark: &'static str) -> Colour {
        Colour { rgb, variable, on_dark }
    }

    /// Name of the CSS variable; for a colour without a variable, that of the text colour.
    pub fn variable(self) -> &'static str {
        if self.variable.is_empty() { INK.variable } else { self.variable }
    }
}

impl Display for Colour {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let [red, green, blue] = self.rgb;
        write!(f, "#{red:02X}{green:02X}{blue:02X}")
    }
}

/// Background.
pub const PAPER: Colour = Colour::themed([255, 255, 255], "panel", "#1b1f26");
/// Primary text and outlines.
pub const INK: Colour = Colour::themed([27, 31, 38], "ink", "#eceff3");
/// Secondary text and lines.
pub const SOFT: Colour = Colour::themed([86, 94, 107], "soft", "#a7b0bd");
/// Major grid lines.
pub(crate) const LINE: Colour = Colour::themed([213, 217, 224], "line", "#3a424e");
/// Minor grid lines.
pub(crate) const FAINT: Colour = Colour::themed([233, 236, 240], "faint", "#2a3039");
pub const BLUE: Colour = Colour::themed([0, 114, 178], "s0", "#56b4e9");
pub const ORANGE: Colour = Colour::themed([199, 83, 0], "s1", "#ff9a52");
pub const GREEN: Colour = Colour::themed([0, 135, 95], "s2", "#3ccb9c");
pub const PURPLE: Colour = Colour::themed([156, 69, 132], "s3", "#dd95c7");
pub const AMBER: Colour = Colour::themed([143, 100, 0], "s4", "#e3b84a");
const GREY: Colour = Colour::themed([95, 103, 115], "s5", "#aab2be");
/// Colours of successive curves. They can be distinguished with colour blindness (Okabe and Ito), and are dark enough
/// for text.
pub const SERIES: [Colour; 6] = [BLUE, ORANGE, GREEN, PURPLE, AMBER, GREY];
/// Driven link l11, coupler l12, proximal phalanx l21 and distal phalanx l22.
pub(crate) const DRIVER: Colour = Colour::themed([185, 194, 207], "driver", "#4c5766");
pub(crate) const COUPLER: Colour = Colour::themed([211, 217, 226], "coupler", "#3a4350");
pub(crate) const PROXIMAL: Colour = Colour::themed([169, 210, 236], "proximal", "#1f5678");
pub(crate) const DISTAL: Colour = Colour::themed([245, 199, 161], "distal", "#7d4316");
pub const OBJECT: Colour = Colour::themed([227, 220, 203], "object", "#4a453a");
pub const PALM: Colour = Colour::themed([228, 231, 236], "palm", "#262c35");
/// Arcs and symbols of angles.
pub const ANGLE: Colour = Colour::themed([0, 90, 156], "accent", "#63b7f0");
/// Arrows and symbols of forces.
pub const FORCE: Colour = Colour::themed([179, 38, 30], "force", "#ff8078");
/// Colour of the cell of an accurate run. Dark text is legible on it.
pub const FINE: Colour = Colour::themed([206, 228, 245], "fine", "#1f4560");
/// Colour of the cell of an inaccurate run, or of the third-best verdict. Dark text is legible on it.
pub const DOUBTFUL: Colour = Colour::themed([230, 159, 0], "doubtful", "#7a5400");
/// Colour of the cell of a failed run. Light text is legible on it.
pub const BROKEN: Colour = Colour::themed([94, 24, 74], "broken", "#d39cc0");
/// Colour of the cell of the second-best verdict.
pub const PALE_BLUE: Colour = Colour::themed([178, 211, 233], "pale", "#1f5678");
/// Colour of the cell of the worst verdict.
pub const NEUTRAL: Colour = Colour::themed([216, 216, 216], "neutral", "#4a525e");
/// Colours of classes and other verdicts, from best to worst.
pub const VERDICTS: [Colour; 4] = [BLUE, PALE_BLUE, DOUBTFUL, NEUTRAL];
/// Colour of the region of unstable grasps. It must differ from the background, which marks regions without a finger.
pub const UNSTABLE: Colour = Colour::themed([43, 47, 54], "unstable", "#5d6570");

/// Colours with a variable.
const THEME: [Colour; 25] = [
    PAPER, INK, SOFT, LINE, FAINT, BLUE, ORANGE, GREEN, PURPLE, AMBER, GREY, DRIVER, COUPLER, PROXIMAL, DISTAL, OBJECT,
    PALM, ANGLE, FORCE, FINE, DOUBTFUL, BROKEN, PALE_BLUE, NEUTRAL, UNSTABLE,
];

/// CSS variables of a page for its light and dark schemes.
pub fn variables() -> String {
    let light: String = THEME.iter().map(|colour| format!("--{}:{colour};", colour.variable)).collect();
    let dark: String = THEME.iter().map(|colour| format!("--{}:{};", colour.variable, colour.on_dark)).collect();
    format!(":root{{{light}}}\n:root[data-theme=\"dark\"]{{{dark}}}\n")
}

/// Style sheet of a picture with these elements. Only a standalone picture follows the colour scheme of the viewer; one
/// in a page follows the page. Viewers without support for variables ignore the first rule and use the attributes.
pub(crate) fn style(elements: &str) -> String {
    let (mut rules, mut dark) = (String::new(), BTreeSet::new());
    for colour @ Colour { variable, on_dark, .. } in THEME {
        for attribute in ["fill", "stroke"] {
            // Quotation marks in texts are escaped, so that only attributes match. The document itself has the fill INK.
            if elements.contains(&format!(" {attribute}=\"{colour}\"")) || (attribute, colour) == ("fill", INK) {
                // Writing to a string cannot fail.
                let _ = writeln!(rules, "[{attribute}=\"{colour}\"]{{{attribute}:var(--{variable},{colour})}}");
                dark.insert(format!("--{variable}:{on_dark}"));
            }
        }
    }
    let dark: Vec<String> = dark.into_iter().collect();
    format!(
        "@supports(fill:var(--ink)){{\n{rules}}}\n@media(prefers-color-scheme:dark){{svg:root{{{}}}}}\n",
        dark.join(";")
    )
}

/// Stops of a colour scale, from the smallest to the largest value. They are those of viridis (van der Walt and Smith)
/// without its dark end, which would resemble the unstable region.
pub const SEQUENTIAL: [Colour; 6] = [
    Colour::fixed([71, 72, 142]),
    Colour::fixed([49, 107, 142]),
    Colour::fixed([31, 146, 139]),
    Colour::fixed([60, 180, 112]),
    Colour::fixed([144, 214, 66]),
    Colour::fixed([253, 231, 37]),
];
/// Stops for negative values, in ascending order.
pub const NEGATIVE: [Colour; 3] =
    [Colour::fixed([184, 74, 0]), Colour::fixed([240, 150, 66]), Colour::fixed([255, 224, 190])];
/// Stops for positive values, in ascending order. They differ from [`NEGATIVE`] at zero, which makes the sign visible.
pub const POSITIVE: [Colour; 3] =
    [Colour::fixed([196, 226, 245]), Colour::fixed([74, 160, 212]), Colour::fixed([0, 92, 158])];
/// Colours of false and true.
pub const FLAG: [Colour; 2] = [Colour::fixed([222, 226, 232]), GREEN];

/// Number of steps of a scale. More would not be distinguishable; adjacent tiles of equal colour are drawn as one.
const STEPS: f64 = 40.0;

/// Mapping of values to colours, interpolated between stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Between the smallest and the largest value.
    Range {
        from: f64,
        to: f64,
    },
    /// Symmetric about zero; values below `-limit` have the colour of `-limit`.
    Signed {
        limit: f64,
    },
    Flag,
}

impl Scale {
    /// Returns the scale from the smallest to the largest value. If the sign matters, the scale is symmetric about
    /// zero, and its limit is the largest value, because values below the negative limit need not be distinguished.
    pub fn from_values(values: impl Iterator<Item = f64>, is_signed: bool) -> Scale {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        match () {
            () if low > high => Scale::Range { from: 0.0, to: 1.0 },
            () if is_signed => {
                Scale::Signed { limit: if high > 0.0 { high } else { low.abs().max(f64::MIN_POSITIVE) } }
            }
            () if high > low => Scale::Range { from: low, to: high },
            () => Scale::Range { from: low - 0.5 * low.abs().max(1e-12), to: high + 0.5 * high.abs().max(1e-12) },
        }
    }

    /// Returns the smallest and the largest value with a distinct colour.
    pub fn range(&self) -> [f64; 2] {
        match *self {
            Scale::Range { from, to } => [from, to],
            Scale::Signed { limit } => [-limit, limit],
            Scale::Flag => [0.0, 1.0],
        }
    }

    pub fn colour(&self, value: f64) -> Colour {
        let (stops, fraction) = match *self {
            Scale::Range { from, to } => (&SEQUENTIAL[..], (value - from) / (to - from)),
            Scale::Signed { limit } if value < 0.0 => (&NEGATIVE[..], 1.0 + value / limit),
            Scale::Signed { limit } => (&POSITIVE[..], value / limit),
            Scale::Flag => return FLAG[usize::from(value > 0.5)],
        };
        let step = (fraction.clamp(0.0, 1.0) * STEPS).round() / STEPS;
        let position = step * (stops.len() - 1) as f64;
        let below = (position as usize).min(stops.len() - 2);
        let [low, high] = [below, below + 1].map(|stop| stops[stop].rgb.map(f64::from));
        Colour::fixed([0, 1, 2].map(|k| (low[k] + (position - below as f64) * (high[k] - low[k])).round() as u8))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn style_sheet_contains_exactly_the_themed_colours_in_use() {
        let sheet = style(" fill=\"#FFFFFF\" stroke=\"#0072B2\" fill=\"#010203\" &quot;fill=&quot;#00875F&quot;");
        assert!(sheet.contains("[fill=\"#FFFFFF\"]{fill:var(--panel,#FFFFFF)}"));
        assert!(sheet.contains("[stroke=\"#0072B2\"]{stroke:var(--s0,#0072B2)}"));
        assert!(sheet.contains("dark){svg:root{--ink:#eceff3;--panel:#1b1f26;--s0:#56b4e9}}"), "{sheet}");
        assert!(!sheet.contains(&GREEN.to_string()) && !sheet.contains("#010203"), "only themed colours in use");
    }

    #[test]
    fn colours_and_variables_correspond_one_to_one() {
        let (colours, names): (BTreeSet<_>, BTreeSet<_>) =
            THEME.iter().map(|colour| (colour.rgb, colour.variable)).unzip();
        assert_eq!([colours.len(), names.len()], [THEME.len(); 2]);
        let page = variables();
        assert!(page.starts_with(":root{--panel:#FFFFFF;") && page.contains("[data-theme=\"dark\"]{--panel:#1b1f26;"));
    }

    #[test]
    fn scales_show_the_sign_and_are_not_empty() {
        let scale = Scale::from_values([-100.0, 3.0, 20.0].into_iter(), true);
        assert_eq!(scale, Scale::Signed { limit: 20.0 });
        assert_eq!(scale.colour(-1e-9), NEGATIVE[2]);
        assert_eq!(scale.colour(0.0), POSITIVE[0]);
        assert_eq!(scale.colour(20.0), POSITIVE[2]);
        assert_eq!((scale.colour(-20.0), scale.colour(-100.0)), (NEGATIVE[0], NEGATIVE[0]));
        let scale = Scale::from_values([2.0, 4.0].into_iter(), false);
        assert_eq!((scale.colour(2.0), scale.colour(4.0)), (SEQUENTIAL[0], SEQUENTIAL[5]));
        for (values, signed) in [vec![], vec![0.0], vec![-3.0]].into_iter().zip([false, true, false]) {
            let [from, to] = Scale::from_values(values.iter().copied(), signed).range();
            assert!(from < to, "{values:?}");
        }
    }
}

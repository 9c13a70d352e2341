//! Limits of sums of joint coordinates.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use super::contact::law_for;
use super::joint::combination;
use super::names::{Known, check_units};
use crate::mechanism::SumLimit;
use crate::scene::quantity::{Coordinate, Plain, Quantity};
use crate::scene::section_input::SectionInput;

/// Limits of the sum of joint coordinates times factors: the play of a gear between two bodies, the opening of two jaws
/// together. For a single joint, use its `lower` and `upper`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct SumLimitSettings {
    /// The joints, all revolute or all prismatic. Required.
    #[schemars(extend("x-required" = "add the joints: joints = [\"out\", \"motor\"]"))]
    pub joints: Option<Vec<String>>,
    /// A factor for each joint. Required.
    #[schemars(extend("x-required" = "add a factor for each joint: factors = [1, -0.2] for a gear of 5 : 1"))]
    pub factors: Option<Vec<Quantity<Plain>>>,
    /// Lower limit of the sum. Default: none.
    pub lower: Option<Quantity<Coordinate>>,
    /// Upper limit of the sum. Default: none.
    pub upper: Option<Quantity<Coordinate>>,
    /// Name of the law of the limits. Required.
    #[schemars(extend("minLength" = 1,
        "x-required" = "add the name of the law of the limits: stop = \"stop\", with a section [laws.stop]"))]
    pub stop: Option<String>,
}

pub(super) fn sum_limit(name: &str, section: &SectionInput<'_>, known: &Known<'_>) -> Option<SumLimit> {
    let SumLimitSettings { joints, factors, lower, upper, stop } = section.read();
    let (on, linear, of) = combination(section, known, None, joints.as_ref(), factors.as_ref(), 2)?;
    let is_angle = |(joint, _): &(usize, f64)| known.kinds[*joint].is_some_and(|kind| kind.is_angle());
    if let Some(place) = on.terms.iter().position(|term| is_angle(term) == linear) {
        let message = format!(
            "`{}` sums angles and lengths: the joint `{}` is not of the kind of the first one",
            section.path("joints"),
            known.joints[on.terms[place].0]
        );
        let help = "name joints of one kind; or couple the slider to a joint that turns with it ([couplings.NAME] with factors = \
                    [1, -0.01] for 10 mm per radian), and limit that joint";
        return section.refuse("joints", message, "angles and lengths", help);
    }
    let units_fit = check_units(section, linear, of);
    let [lower, upper] = [lower, upper].map(|limit| limit.map(|limit| *limit));
    match (lower, upper) {
        (None, None) => {
            let message = format!("the limits `{name}` have neither `lower` nor `upper`");
            return section.refuse("", message, "no limit", "write lower, upper, or both: lower = \"-0.5 deg\"");
        }
        (Some(lower), Some(upper)) if lower >= upper => {
            let message = format!("`{}` must be below `upper`", section.path("lower"));
            return section.refuse("lower", message, "not below `upper`", "swap the limits, or remove one");
        }
        _ => {}
    }
    let law = law_for(section, "stop", &stop?, known, linear, &format!("the limit of {of}"))?.normal;
    units_fit.then(|| SumLimit { name: name.to_owned(), on, lower, upper, law })
}

/// Settings of the limits of a sum, without its joints and factors; `law` is the name of the law.
pub(super) fn sum_limit_settings(limit: &SumLimit, law: String) -> Value {
    json!({ "lower": limit.lower, "upper": limit.upper, "stop": law })
}

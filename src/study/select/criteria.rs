//! Selection criteria: their keys, names and evaluation.

use phalanx_show::format::object::Object;
use serde::{Serialize, Serializer};

use super::Weights;
use super::candidates::Candidate;
use crate::criteria::Class;
use crate::study::quantity::ColumnFormat;
use crate::study::sweep::Status;
use crate::table::Value;

/// Criteria for a design. The default is that of thesis §4.3: the design is form-closed, statically stable, and
/// dynamically stable or semi-stable, and its palm force from the final simulated forces is ≥ 0.
#[derive(Clone, Debug, PartialEq)]
pub struct SelectionCriteria {
    /// Whether both static forces in the final configuration must be positive.
    pub force_positive: bool,
    pub form_closed: bool,
    /// Worst class that is allowed; `None` if any class is allowed.
    pub worst_class: Option<Class>,
    /// Bounds on numeric columns, in the order of application.
    pub bounds: Vec<Bound>,
    pub weights: Weights,
}

impl Default for SelectionCriteria {
    fn default() -> Self {
        SelectionCriteria {
            force_positive: true,
            form_closed: true,
            worst_class: Some(Class::SemiStable),
            bounds: vec![Bound { column: "pfp_n".to_string(), side: Side::AtLeast, value: 0.0 }],
            weights: Weights::default(),
        }
    }
}

/// Bound for a numeric column, in the unit of the column.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    pub column: String,
    pub side: Side,
    pub value: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    AtLeast,
    AtMost,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Criterion {
    /// The run is complete; otherwise it cannot be ranked.
    Completed,
    /// The finger can grasp its object. Applied only if some runs cannot.
    Graspable,
    ForcePositive,
    FormClosed,
    Class(Class),
    Bound(Bound),
    /// The time to stability exists. Applied only if it is weighted and no class criterion implies it.
    Settled,
}

impl SelectionCriteria {
    /// Criteria in the order of application. Those known before the simulation come first.
    pub fn criteria(&self) -> Vec<Criterion> {
        let mut list = vec![Criterion::Completed];
        list.extend(self.force_positive.then_some(Criterion::ForcePositive));
        list.extend(self.form_closed.then_some(Criterion::FormClosed));
        list.extend(self.worst_class.filter(|&class| class != Class::Unstable).map(Criterion::Class));
        let implies_settling = list.iter().any(|criterion| matches!(criterion, Criterion::Class(_)));
        list.extend(self.bounds.iter().cloned().map(Criterion::Bound));
        let is_weighted = self.weights.named().iter().any(|(term, weight)| *term == "tts" && *weight > 0.0);
        list.extend((!implies_settling && is_weighted).then_some(Criterion::Settled));
        list
    }
}

impl Criterion {
    /// Returns the key in documents and the name in tables.
    fn key_and_name(&self) -> (&str, String) {
        let (key, name) = match self {
            Criterion::Completed => ("completed", "simulated to the end"),
            Criterion::Graspable => ("graspable", "can grasp its object"),
            Criterion::ForcePositive => ("force_positive", "statically stable"),
            Criterion::FormClosed => ("form_closed", "form-closed"),
            Criterion::Settled => ("settled", "comes to rest"),
            Criterion::Class(Class::Stable) => ("class", "stable"),
            Criterion::Class(worst) => return ("class", format!("at least {}", worst.name())),
            Criterion::Bound(Bound { column, side, value }) => {
                let quantity = ColumnFormat::for_column(column);
                let gap = if quantity.unit.is_empty() { "" } else { " " };
                let name = if column == "pfp_n" { "PFP" } else { &quantity.name };
                let sign = if *side == Side::AtLeast { "≥" } else { "≤" };
                let value = quantity.value(&Value::Number(*value), 6);
                return (column, format!("{name} {sign} {value}{gap}{}", quantity.unit));
            }
        };
        (key, name.to_string())
    }

    /// Returns the key: `completed`, `graspable`, `force_positive`, `form_closed`, `class` or `settled`; for a bound,
    /// the column.
    pub fn key(&self) -> &str {
        self.key_and_name().0
    }

    /// Returns the name in tables.
    pub(crate) fn name(&self) -> String {
        self.key_and_name().1
    }

    /// Evaluates the criterion for a run; `bounded_value` is the value of the bounded column. `None` means that the
    /// figure is missing, because the run was filtered, refused or failed: the criterion is not met.
    pub(super) fn evaluate(&self, run: &Candidate, bounded_value: Option<f64>) -> Option<bool> {
        let completed = run.status == Status::Completed;
        match self {
            Criterion::Completed => Some(completed),
            Criterion::Graspable => completed.then(|| !run.cannot_grasp()),
            Criterion::ForcePositive => run.force_positive,
            Criterion::FormClosed => run.form_closed,
            Criterion::Settled => completed.then_some(run.tts_s.is_some()),
            // The variants are declared in the order of `Class::ALL`.
            Criterion::Class(worst) => run.class.map(|class| class as u8 <= *worst as u8),
            Criterion::Bound(Bound { side, value, column }) => {
                match bounded_value.filter(|number| number.is_finite()) {
                    Some(number) if *side == Side::AtLeast => Some(number >= *value),
                    Some(number) => Some(number <= *value),
                    // A completed run that does not settle exceeds any bound on these columns.
                    None => {
                        let may_be_missing = ["tts_s", "t_geo_s", "rebound_percent"].contains(&column.as_str());
                        (completed && may_be_missing).then_some(false)
                    }
                }
            }
        }
    }
}

/// Serialises key, name, and the lowest accepted class or the bound in its unit.
impl Serialize for Criterion {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (key, name) = self.key_and_name();
        let (at_least, at_most) = match self {
            Criterion::Class(worst) => (Some(Value::from(worst.name())), None),
            Criterion::Bound(Bound { side: Side::AtLeast, value, .. }) => (Some(Value::Number(*value)), None),
            Criterion::Bound(Bound { side: Side::AtMost, value, .. }) => (None, Some(*value)),
            _ => (None, None),
        };
        let object = Object::default().with("criterion", key).with("words", name);
        object.with("at_least", at_least).with("at_most", at_most).serialize(serializer)
    }
}

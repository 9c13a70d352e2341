//! Selection criteria and their evaluation.

use super::candidates::Candidate;
use super::{SelectError, Weights};
use crate::criteria::Class;
use crate::study::sweep::Status;
use crate::table::Table;

/// Criteria for a design. The default is that of thesis §4.3: form-closed, statically stable, dynamically stable or
/// semi-stable, and a palm force ≥ 0 from the final simulated forces.
#[derive(Clone, Debug, PartialEq)]
pub struct SelectionCriteria {
    /// Whether both static forces in the final configuration must be positive.
    pub force_positive: bool,
    pub form_closed: bool,
    /// Worst permitted dynamic class; `None` for any.
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

/// Bound on a numeric column, in its unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    pub column: String,
    pub side: Side,
    pub value: f64,
}

/// Direction of a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    AtLeast,
    AtMost,
}

impl Side {
    /// Relational symbol.
    pub fn sign(self) -> &'static str {
        match self {
            Side::AtLeast => "≥",
            Side::AtMost => "≤",
        }
    }
}

/// A single criterion.
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

/// Result of a criterion for one run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    Holds,
    Fails,
    /// The figure is missing, because the run was filtered, refused or failed. The criterion is not met.
    Unknown,
}

impl SelectionCriteria {
    /// Criteria in the order of application: those known before the simulation first.
    pub fn criteria(&self) -> Vec<Criterion> {
        let mut list = vec![Criterion::Completed];
        list.extend(self.force_positive.then_some(Criterion::ForcePositive));
        list.extend(self.form_closed.then_some(Criterion::FormClosed));
        list.extend(self.worst_class.filter(|&class| class != Class::Unstable).map(Criterion::Class));
        let implies_settling = list.iter().any(|criterion| matches!(criterion, Criterion::Class(_)));
        list.extend(self.bounds.iter().cloned().map(Criterion::Bound));
        list.extend((!implies_settling && self.weights.tts > 0.0).then_some(Criterion::Settled));
        list
    }
}

impl Criterion {
    /// Evaluates the criterion for a run; `bounded_value` is the value of the bounded column.
    pub(super) fn evaluate(&self, run: &Candidate, bounded_value: Option<f64>) -> Verdict {
        let completed = run.status == Status::Completed;
        let verdict = |holds: Option<bool>| match holds {
            Some(true) => Verdict::Holds,
            Some(false) => Verdict::Fails,
            None => Verdict::Unknown,
        };
        match self {
            Criterion::Completed => verdict(Some(completed)),
            Criterion::Graspable => verdict(completed.then(|| !run.cannot_grasp())),
            Criterion::ForcePositive => verdict(run.force_positive),
            Criterion::FormClosed => verdict(run.form_closed),
            // The variants are declared in the order of `CLASSES`.
            Criterion::Class(worst) => verdict(run.class.map(|class| class as u8 <= *worst as u8)),
            Criterion::Bound(Bound { side, value, column }) => {
                match bounded_value.filter(|number| number.is_finite()) {
                    Some(number) if *side == Side::AtLeast => verdict(Some(number >= *value)),
                    Some(number) => verdict(Some(number <= *value)),
                    // A completed run that does not settle exceeds any bound on these columns.
                    None if completed && (column == "tts_s" || column == "t_geo_s" || column == "rebound_percent") => {
                        Verdict::Fails
                    }
                    None => Verdict::Unknown,
                }
            }
            Criterion::Settled if completed => verdict(Some(run.tts_s.is_some())),
            Criterion::Settled => Verdict::Unknown,
        }
    }
}

/// Values of the bounded column by row for each criterion; `None` for criteria that are not bounds.
pub(super) fn bound_columns(
    table: &Table,
    criteria: &[Criterion],
) -> Result<Vec<Option<Vec<Option<f64>>>>, SelectError> {
    let numbers = |criterion: &Criterion| match criterion {
        Criterion::Bound(bound) => Ok(Some(table.numbers(&bound.column)?)),
        _ => Ok(None),
    };
    criteria.iter().map(numbers).collect()
}

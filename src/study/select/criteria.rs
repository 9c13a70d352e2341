//! What a run must meet, and whether it does.

use super::candidates::Candidate;
use super::{SelectError, Weights};
use crate::criteria::Class;
use crate::study::sweep::Status;
use crate::table::Table;

/// What is asked of a design. The default is the thesis's §4.3: form-closed, statically stable, stable or semi-stable, and
/// a palm force ≥ 0 from the final simulated forces.
#[derive(Clone, Debug, PartialEq)]
pub struct SelectionCriteria {
    /// Both static forces at the final configuration are positive.
    pub force_positive: bool,
    pub form_closed: bool,
    /// The worst dynamic class allowed; `None` for any.
    pub least_class: Option<Class>,
    /// Further bounds on columns of numbers, in the order in which they are applied.
    pub bounds: Vec<Bound>,
    pub weights: Weights,
}

impl Default for SelectionCriteria {
    fn default() -> Self {
        SelectionCriteria {
            force_positive: true,
            form_closed: true,
            least_class: Some(Class::SemiStable),
            bounds: vec![Bound { column: "pfp_n".to_string(), side: Side::AtLeast, value: 0.0 }],
            weights: Weights::default(),
        }
    }
}

/// A column of numbers and a limit in its unit.
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

impl Side {
    pub fn sign(self) -> &'static str {
        match self {
            Side::AtLeast => "≥",
            Side::AtMost => "≤",
        }
    }
}

/// One criterion, as it is applied.
#[derive(Clone, Debug, PartialEq)]
pub enum Criterion {
    /// The run came to its end; without that there is nothing to rank.
    Completed,
    /// The finger can grasp its object. Only where there are runs in which it cannot.
    Graspable,
    ForcePositive,
    FormClosed,
    Class(Class),
    Bound(Bound),
    /// There is a time to stability to rank by. Only where no class asks for it already.
    Settled,
}

/// What is known of a criterion for one run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    Holds,
    Fails,
    /// The run has no such figure: it was filtered, refused, or failed before. It does not count as met.
    Unknown,
}

impl SelectionCriteria {
    /// The criteria in the order in which they are applied: what is known first comes first.
    pub fn list(&self) -> Vec<Criterion> {
        let mut list = vec![Criterion::Completed];
        list.extend(self.force_positive.then_some(Criterion::ForcePositive));
        list.extend(self.form_closed.then_some(Criterion::FormClosed));
        list.extend(self.least_class.filter(|&class| class != Class::Unstable).map(Criterion::Class));
        let settles = list.iter().any(|criterion| matches!(criterion, Criterion::Class(_)));
        list.extend(self.bounds.iter().cloned().map(Criterion::Bound));
        list.extend((!settles && self.weights.tts > 0.0).then_some(Criterion::Settled));
        list
    }
}

impl Criterion {
    /// Whether a run meets it; `bound` is the value of the bound's column.
    pub(super) fn judge(&self, run: &Candidate, bound: Option<f64>) -> Verdict {
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
            // In the order of `CLASSES`.
            Criterion::Class(least) => verdict(run.class.map(|class| class as u8 <= *least as u8)),
            Criterion::Bound(Bound { side, value, column }) => match bound.filter(|found| found.is_finite()) {
                Some(found) if *side == Side::AtLeast => verdict(Some(found >= *value)),
                Some(found) => verdict(Some(found <= *value)),
                // A completed run that never settles has no time to be within.
                None if completed && (column == "tts_s" || column == "t_geo_s" || column == "rebound_percent") => {
                    Verdict::Fails
                }
                None => Verdict::Unknown,
            },
            Criterion::Settled if completed => verdict(Some(run.tts_s.is_some())),
            Criterion::Settled => Verdict::Unknown,
        }
    }
}

/// For each criterion that is a bound, its column by row.
pub(super) fn bounded(table: &Table, list: &[Criterion]) -> Result<Vec<Option<Vec<Option<f64>>>>, SelectError> {
    let numbers = |criterion: &Criterion| match criterion {
        Criterion::Bound(bound) => Ok(Some(table.numbers(&bound.column)?)),
        _ => Ok(None),
    };
    list.iter().map(numbers).collect()
}

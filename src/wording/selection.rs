//! Criteria, conditions and counts as people say them.

use crate::study::select::{Bound, Condition, Criterion};
use crate::table::Value;
use crate::wording::quantity::Quantity;

/// A criterion in a few words.
pub fn criterion_name(criterion: &Criterion) -> String {
    match criterion {
        Criterion::Completed => "simulated to the end".to_string(),
        Criterion::Graspable => "can grasp its object".to_string(),
        Criterion::ForcePositive => "statically stable".to_string(),
        Criterion::FormClosed => "form-closed".to_string(),
        Criterion::Class(crate::criteria::Class::Stable) => "stable".to_string(),
        Criterion::Class(least) => format!("at least {}", least.name()),
        Criterion::Bound(Bound { column, side, value }) => {
            let quantity = Quantity::of(column);
            let gap = if quantity.unit.is_empty() { "" } else { " " };
            let name = if column == "pfp_n" { "PFP" } else { &quantity.name };
            format!("{name} {} {}{gap}{}", side.sign(), quantity.value(&Value::Number(*value), 6), quantity.unit)
        }
        Criterion::Settled => "comes to rest".to_string(),
    }
}

/// The word for a criterion in JSON.
pub fn criterion_key(criterion: &Criterion) -> &str {
    match criterion {
        Criterion::Completed => "completed",
        Criterion::Graspable => "graspable",
        Criterion::ForcePositive => "force_positive",
        Criterion::FormClosed => "form_closed",
        Criterion::Class(_) => "class",
        Criterion::Bound(bound) => &bound.column,
        Criterion::Settled => "settled",
    }
}

/// What a condition is: `mu_static 0.8`; "all runs" where there is but one.
pub fn condition_name(condition: &Condition) -> String {
    if condition.values.is_empty() {
        return "all runs".to_string();
    }
    let said: Vec<String> = condition.values.iter().map(|(column, value)| Quantity::of(column).said(value)).collect();
    said.join(", ")
}

/// A count as a share, in percent with one decimal; a dash of nothing.
pub fn percent_of(count: usize, of: usize) -> String {
    if of == 0 { "–".to_string() } else { format!("{:.1} %", 100.0 * count as f64 / of as f64) }
}

//! Names of criteria and conditions, and shares of counts.

use crate::format::quantity::Quantity;
use crate::study::select::{Bound, Condition, Criterion};
use crate::table::Value;

/// Short description of a criterion.
pub fn criterion_name(criterion: &Criterion) -> String {
    match criterion {
        Criterion::Completed => "simulated to the end".to_string(),
        Criterion::Graspable => "can grasp its object".to_string(),
        Criterion::ForcePositive => "statically stable".to_string(),
        Criterion::FormClosed => "form-closed".to_string(),
        Criterion::Class(crate::criteria::Class::Stable) => "stable".to_string(),
        Criterion::Class(min_class) => format!("at least {}", min_class.name()),
        Criterion::Bound(Bound { column, side, value }) => {
            let quantity = Quantity::for_column(column);
            let gap = if quantity.unit.is_empty() { "" } else { " " };
            let name = if column == "pfp_n" { "PFP" } else { &quantity.name };
            format!("{name} {} {}{gap}{}", side.sign(), quantity.value(&Value::Number(*value), 6), quantity.unit)
        }
        Criterion::Settled => "comes to rest".to_string(),
    }
}

/// Key of a criterion in JSON.
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

/// Name of a condition, such as `mu_static 0.8`; "all runs" for a condition without values.
pub fn condition_name(condition: &Condition) -> String {
    if condition.values.is_empty() {
        return "all runs".to_string();
    }
    let names: Vec<String> =
        condition.values.iter().map(|(column, value)| Quantity::for_column(column).name_and_value(value)).collect();
    names.join(", ")
}

/// Returns a count as a share of `total`, in percent with one decimal; a dash if `total` is 0.
pub fn percent_of(count: usize, total: usize) -> String {
    if total == 0 { "–".to_string() } else { format!("{:.1} %", 100.0 * count as f64 / total as f64) }
}

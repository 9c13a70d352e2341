//! The table as Markdown, for the documentation.

use serde_json::Value;

use super::bounds::{BodiesBounds, Bounds};
use super::engine::Engine;
use super::integrator::Integrator;
use super::log::LogRates;
use super::{Field, Table, default, range};

/// Every section of the table with its keys.
pub fn markdown() -> String {
    [
        section::<Integrator>("`[integrator]`"),
        section::<Engine>("`[engine]`"),
        section::<Bounds>("`[validate]`"),
        section::<BodiesBounds>("`[validate]` of a scene of discs"),
        section::<LogRates>("`[log]`"),
    ]
    .join("\n")
}

fn section<T: Table>(title: &str) -> String {
    let rows: String = T::LINES.iter().map(|line| row(*line)).collect();
    format!("{title}:{}\n\n| key | default | allowed | what it is |\n|---|---|---|---|\n{rows}", T::DOC)
}

fn row<T: Table>(line: &dyn Field<T>) -> String {
    let about = line.about();
    let default = match default(line) {
        Some(Value::String(text)) => text,
        Some(value) => value.to_string(),
        None => about.needed.map_or("", |_| "required").to_string(),
    };
    format!("| `{}` | {default} | {} | {} |\n", about.key, range(line), about.doc.trim_start())
}

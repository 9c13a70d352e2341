//! Formats numbers and text for reports, pictures and pages.
//!
//! | file | job |
//! |---|---|
//! | `numbers` | numbers with a given number of digits, durations |
//! | `object` | JSON objects whose keys keep their order |
//! | `report` | paragraphs, tables and figures, rendered as text, Markdown or HTML |
//! | `escape` | escaping of foreign text in a page or a picture |

mod escape;
pub mod numbers;
pub mod object;
pub mod report;

pub use escape::{escape_markup, is_unsafe_char};
pub use numbers::format_duration;
pub use report::{Report, ToReport};

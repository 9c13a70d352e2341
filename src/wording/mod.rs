//! How figures and words are put before people, whatever shows them: reports, pictures, pages.
//!
//! | file | job |
//! |---|---|
//! | `figures` | numbers of a chosen number of digits, lengths of time |
//! | `quantity` | columns and keys with a short name and a unit of everyday size |
//! | `selection` | criteria, conditions and counts of a selection |
//! | `sheet` | words and tables, laid out where they are shown |
//! | `escape` | text of others within a page or a picture |

mod escape;
pub mod figures;
pub mod quantity;
mod selection;
pub mod sheet;

pub use escape::escaped;
pub use figures::duration;
pub use quantity::Quantity;
pub use selection::{condition_name, criterion_key, criterion_name, percent_of};
pub use sheet::Sheet;

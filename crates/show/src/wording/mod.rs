//! How figures and words are put before people, whatever shows them: reports, pictures, pages.
//!
//! | file | job |
//! |---|---|
//! | `figures` | numbers of a chosen number of digits, lengths of time |
//! | `report` | words, tables and figures, laid out where they are shown: text, Markdown, elements of a page |
//! | `escape` | text of others within a page or a picture |

mod escape;
pub mod figures;
pub mod report;

pub use escape::{acts, escaped};
pub use figures::duration;
pub use report::{Report, Reported};

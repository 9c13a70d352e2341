//! How figures and words are put before people, whatever shows them: reports, pictures, pages.
//!
//! | file | job |
//! |---|---|
//! | `figures` | numbers of a chosen number of digits, lengths of time |
//! | `sheet` | words and tables, laid out where they are shown |
//! | `escape` | text of others within a page or a picture |

mod escape;
pub mod figures;
pub mod sheet;

pub use escape::escaped;
pub use figures::duration;
pub use sheet::Sheet;

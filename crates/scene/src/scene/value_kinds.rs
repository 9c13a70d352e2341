//! Kinds of values of the keys of study files.

use std::marker::PhantomData;

use schemars::{Schema, json_schema};
use toml::{Spanned, Value};

use super::error::Problem;
pub use super::quantity::Keyword;
use super::toml_value::TomlValue;
use super::value::ValueType;
pub use super::value::{problem_at, read_keyword, read_quantity};

/// A kind of value: how it is read from a file, and its schema.
pub trait InputKind {
    type Value;
    const NAME: &'static str;

    /// Reads the value of `key`, given with its full path for messages.
    fn read(key: &str, value: &Spanned<TomlValue>) -> Result<Self::Value, Vec<Problem>>;

    fn schema() -> Schema;
}

/// Implements [`InputKind`] for a type of value.
macro_rules! input_kinds {
    ($($(#[doc = $doc:literal])* $name:ident: $value:ty = $value_type:expr, $variant:ident, $convert:expr, $schema:tt;)*) => {$(
        $(#[doc = $doc])*
        #[derive(Debug)]
        pub struct $name;

        impl InputKind for $name {
            type Value = $value;
            const NAME: &'static str = stringify!($name);

            fn read(key: &str, value: &Spanned<TomlValue>) -> Result<$value, Vec<Problem>> {
                match $value_type.read(key, value)? {
                    Value::$variant(read) => Ok($convert(read)),
                    _ => Err(Vec::new()),
                }
            }

            fn schema() -> Schema {
                json_schema!($schema)
            }
        }
    )*};
}

input_kinds! {
    /// A positive integer.
    Count: u64 = ValueType::Integer(1, i64::MAX), Integer, i64::unsigned_abs, { "type": "integer", "minimum": 1 };
    /// `true` or `false`.
    Flag: bool = ValueType::Flag, Boolean, bool::from, { "type": "boolean" };
    /// Non-empty text.
    Text: String = ValueType::Text, String, String::from, { "type": "string", "minLength": 1 };
}

/// One keyword of a closed list.
#[derive(Debug)]
pub struct Choice<W>(PhantomData<W>);

impl<W: Keyword> InputKind for Choice<W> {
    type Value = W;
    const NAME: &'static str = "Choice";

    fn read(key: &str, value: &Spanned<TomlValue>) -> Result<W, Vec<Problem>> {
        read_keyword(key, value, &W::keywords()).map(|index| W::KEYWORDS[index].1.clone())
    }

    fn schema() -> Schema {
        json_schema!({ "type": "string", "enum": W::keywords() })
    }
}

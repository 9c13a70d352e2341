//! Types of the values of settings: quantities with a dimension and a range, plain numbers, keywords.
//!
//! A value is a number in SI units as soon as it is read; its schema says which units a file may use.

use std::borrow::Cow;
use std::fmt::Debug;
use std::marker::PhantomData;
use std::mem::discriminant;
use std::ops::Deref;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error};
use serde::{Serialize, Serializer};

use crate::units::Dimension;

/// The dimension of a [`Quantity`], or several ones if the meaning of the key depends on another key; none for a plain
/// number.
pub(crate) trait Measure {
    const DIMENSIONS: &'static [Dimension];
}

/// The range of a [`Quantity`], given as keywords of JSON Schema with limits in SI units.
pub trait Range {
    const LIMITS: &'static [(&'static str, f64)];
}

macro_rules! markers {
    ($trait:ident: $($(#[doc = $doc:literal])* $name:ident { $($constant:tt)* })*) => {$(
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $name;

        impl $trait for $name {
            $($constant)*
        }
    )*};
}

macro_rules! dimensions {
    ($($name:ident)*) => { markers!(Measure: $($name { const DIMENSIONS: &'static [Dimension] = &[Dimension::$name]; })*); };
}

dimensions!(Length Angle Time Mass Force Torque Speed AngularRate Acceleration Density Inertia Frequency Pressure);
dimensions!(AngularStiffness LinearStiffness LinearDamping AngularDamping);
dimensions!(Voltage Current Resistance Inductance TorqueConstant BackEmf);

markers! { Measure:
    /// A ratio, or a value in SI units if its unit has a fractional power.
    Plain { const DIMENSIONS: &'static [Dimension] = &[]; }
    /// Coordinate of a joint: an angle or a length.
    Coordinate { const DIMENSIONS: &'static [Dimension] = &[Dimension::Angle, Dimension::Length]; }
    CoordinateRate { const DIMENSIONS: &'static [Dimension] = &[Dimension::AngularRate, Dimension::Speed]; }
    JointStiffness { const DIMENSIONS: &'static [Dimension] = &[Dimension::AngularStiffness, Dimension::LinearStiffness]; }
    JointDamping { const DIMENSIONS: &'static [Dimension] = &[Dimension::AngularDamping, Dimension::LinearDamping]; }
    JointInertia { const DIMENSIONS: &'static [Dimension] = &[Dimension::Inertia, Dimension::Mass]; }
    /// Torque or force of a joint.
    Effort { const DIMENSIONS: &'static [Dimension] = &[Dimension::Torque, Dimension::Force]; }
    /// Gain of a controller on the error of a coordinate or a distance: a torque, a force or a voltage per angle or length.
    Gain {
        const DIMENSIONS: &'static [Dimension] = &[
            Dimension::AngularStiffness,
            Dimension::LinearStiffness,
            Dimension::Force,
            Dimension::AngularVoltage,
            Dimension::LinearVoltage,
        ];
    }
    /// Gain of a controller on the error of the rate.
    RateGain {
        const DIMENSIONS: &'static [Dimension] = &[
            Dimension::AngularDamping,
            Dimension::LinearDamping,
            Dimension::Impulse,
            Dimension::BackEmf,
            Dimension::LinearVoltageDamping,
        ];
    }
    /// Damping of a normal law of contacts or limits.
    LawDamping {
        const DIMENSIONS: &'static [Dimension] = &[
            Dimension::LinearImpactDamping,
            Dimension::AngularImpactDamping,
            Dimension::LinearDamping,
            Dimension::AngularDamping,
        ];
    }
}

markers! { Range:
    /// Any finite number.
    Finite { const LIMITS: &'static [(&'static str, f64)] = &[]; }
    /// Numbers above 0.
    Above0 { const LIMITS: &'static [(&'static str, f64)] = &[("exclusiveMinimum", 0.0)]; }
    /// Numbers above 0, up to 1.
    UpTo1 { const LIMITS: &'static [(&'static str, f64)] = &[("exclusiveMinimum", 0.0), ("maximum", 1.0)]; }
    /// Numbers from 0.
    From0 { const LIMITS: &'static [(&'static str, f64)] = &[("minimum", 0.0)]; }
}

/// A number in SI units; the type contains its dimension and range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct Quantity<D, R = Finite>(f64, PhantomData<(D, R)>);

/// A quantity above 0.
pub type Positive<D> = Quantity<D, Above0>;
/// A quantity of at least 0.
pub(crate) type NotNegative<D> = Quantity<D, From0>;

impl<D, R> From<f64> for Quantity<D, R> {
    fn from(si: f64) -> Self {
        Quantity(si, PhantomData)
    }
}

impl<D, R> Deref for Quantity<D, R> {
    type Target = f64;

    fn deref(&self) -> &f64 {
        &self.0
    }
}

impl<D: Measure, R: Range> JsonSchema for Quantity<D, R> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Quantity".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let units = D::DIMENSIONS.iter().flat_map(|dimension| dimension.units()).map(|unit| unit.name);
        let mut schema = match D::DIMENSIONS {
            [] => json_schema!({ "type": "number" }),
            dimensions => json_schema!({
                "type": "string",
                // A number with its unit, or an expression.
                "pattern": r"^\s*(=|[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*\S).*$",
                "examples": dimensions.iter().map(|dimension| dimension.example()).collect::<Vec<_>>(),
                "x-units": units.collect::<Vec<_>>(),
            }),
        };
        // JSON Schema has limits for numbers only.
        let prefix = if D::DIMENSIONS.is_empty() { "" } else { "x-" };
        for (keyword, limit) in R::LIMITS {
            schema.insert(format!("{prefix}{keyword}"), (*limit).into());
        }
        schema
    }
}

/// The SI values of a list of quantities; empty if it is not given.
pub(crate) fn si_values<D, R>(values: Option<Vec<Quantity<D, R>>>) -> Vec<f64> {
    values.into_iter().flatten().map(|value| *value).collect()
}

/// A type whose values are written as keywords.
pub trait Keyword: Clone + 'static {
    const KEYWORDS: &'static [(&'static str, Self)];

    /// Returns the keyword of a value, which depends on its variant only.
    fn keyword(&self) -> &'static str {
        Self::KEYWORDS.iter().find(|(_, v)| discriminant(v) == discriminant(self)).map_or("", |(w, _)| w)
    }

    /// Returns the value of a keyword.
    fn from_keyword(keyword: &str) -> Option<Self> {
        Self::KEYWORDS.iter().find(|(known, _)| *known == keyword).map(|(_, value)| value.clone())
    }

    /// All keywords.
    fn keywords() -> Vec<&'static str> {
        Self::KEYWORDS.iter().map(|(keyword, _)| *keyword).collect()
    }
}

/// Defines an enum whose variants are written as keywords.
macro_rules! keyword_enum {
    ($(#[$attribute:meta])* pub enum $name:ident {
        $($(#[$variant_attribute:meta])* $variant:ident = $keyword:literal),* $(,)?
    }) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[schemars(inline)]
        pub enum $name {
            $($(#[$variant_attribute])* #[serde(rename = $keyword)] $variant),*
        }

        $crate::scene::quantity::keywords! { $name { $($keyword => $name::$variant),* } }
    };
}

/// Gives the values of a type their keywords.
macro_rules! keywords {
    ($name:ty { $($keyword:expr => $value:expr),* $(,)? }) => {
        impl $crate::scene::Keyword for $name {
            const KEYWORDS: &'static [(&'static str, Self)] = &[$(($keyword, $value)),*];
        }
    };
}

pub(crate) use {keyword_enum, keywords};

/// A value of another crate that is written as a keyword. The default is its first keyword.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Word<K>(pub K);

impl<K: Keyword> Default for Word<K> {
    fn default() -> Self {
        Word(K::KEYWORDS[0].1.clone())
    }
}

impl<K: Keyword> Serialize for Word<K> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.keyword())
    }
}

impl<'de, K: Keyword> Deserialize<'de> for Word<K> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let keyword = String::deserialize(deserializer)?;
        K::from_keyword(&keyword).map(Word).ok_or_else(|| D::Error::custom(format!("unknown keyword `{keyword}`")))
    }
}

impl<K: Keyword> JsonSchema for Word<K> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Word".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "enum": K::keywords() })
    }
}

//! A scene as it is written: keys, and after them sections.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

use schemars::{Schema, SchemaGenerator};
use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::Value;

use super::entry::Section;
use super::table::Table;
use super::table::keys::{self, Keys};

/// A scene of one kind; `T` has the keys before its sections.
pub trait Sections<T>: Default {
    const TITLE: &'static str;

    /// Reads the section of this name, if there is one of it.
    ///
    /// # Errors
    /// That of the deserialisation.
    fn take<'de, A: MapAccess<'de>>(&mut self, name: &str, map: &mut A) -> Result<bool, A::Error>;

    fn put(&mut self, keys: Section<Keys<T>>);

    fn schemas(generator: &mut SchemaGenerator) -> Vec<(&'static str, Schema)>;
}

/// Makes the struct of a scene as it is written from its title, its name, what has the keys before its sections (these are its
/// `keys`), and its sections with what is in them.
macro_rules! sections {
    ($title:literal, $raw:ident: $keys:ty { $($section:ident: $body:ty,)* }) => {
        #[derive(Debug, Default)]
        pub struct $raw {
            pub keys: Section<Keys<$keys>>,
            $(pub $section: Section<$body>,)*
        }

        impl $crate::scene::sections::Sections<$keys> for $raw {
            const TITLE: &'static str = $title;

            fn take<'de, A>(&mut self, name: &str, map: &mut A) -> Result<bool, A::Error>
            where
                A: serde::de::MapAccess<'de>,
            {
                match name {
                    $(stringify!($section) => self.$section = map.next_value()?,)*
                    _ => return Ok(false),
                }
                Ok(true)
            }

            fn put(&mut self, keys: Section<Keys<$keys>>) {
                self.keys = keys;
            }

            fn schemas(generator: &mut schemars::SchemaGenerator) -> Vec<(&'static str, schemars::Schema)> {
                vec![$((stringify!($section), <$body as schemars::JsonSchema>::json_schema(generator))),*]
            }
        }

        impl<'de> serde::Deserialize<'de> for $raw {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                $crate::scene::sections::read(deserializer)
            }
        }

        impl schemars::JsonSchema for $raw {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($raw).into()
            }

            fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                $crate::scene::sections::schema::<Self, $keys>(generator)
            }
        }
    };
}

pub(super) use sections;

/// A scene whose keys are known.
///
/// # Errors
/// That of the deserialisation.
pub fn read<'de, T, R: Sections<T>, D: Deserializer<'de>>(deserializer: D) -> Result<R, D::Error> {
    deserializer.deserialize_map(Whole(PhantomData))
}

struct Whole<T, R>(PhantomData<(T, R)>);

impl<'de, T, R: Sections<T>> Visitor<'de> for Whole<T, R> {
    type Value = R;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a scene")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<R, A::Error> {
        let (mut raw, mut given) = (R::default(), BTreeMap::new());
        while let Some(key) = map.next_key::<String>()? {
            if !raw.take(&key, &mut map)? {
                given.insert(key, map.next_value()?);
            }
        }
        raw.put(Section::whole(Keys::of(given)));
        Ok(raw)
    }
}

/// JSON Schema of a scene.
pub fn schema<R: Sections<T>, T: Table>(generator: &mut SchemaGenerator) -> Schema {
    let mut schema = keys::schema::<T>();
    schema.insert("title".into(), R::TITLE.into());
    if let Some(Value::Object(properties)) = schema.get_mut("properties") {
        properties.extend(R::schemas(generator).into_iter().map(|(name, section)| (name.into(), section.to_value())));
    }
    schema
}

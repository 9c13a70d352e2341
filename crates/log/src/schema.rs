//! Message schemas: phalanx' own are in the package `phalanx`, Foxglove's in `foxglove`.
//!
//! `derive(Encode)` puts every message into a package of its own name (`state.State`). Older logs have these names;
//! they are read as if they had the current ones.

use std::borrow::Cow;

use foxglove::{Encode, Schema};
use prost_reflect::prost::Message;
use prost_reflect::prost_types::FileDescriptorSet;

/// Package of phalanx' own messages.
const PACKAGE: &str = "phalanx";

/// Returns the schema of a message as written to logs.
pub fn schema_of<M: Encode>() -> Option<Schema> {
    let derived = M::get_schema()?;
    let data = current_data(&derived.name, &derived.data).into_owned();
    Some(Schema::new(current_name(&derived.name), derived.encoding, data))
}

/// Returns the current name of a schema: `phalanx.State` for `state.State`.
pub fn current_name(name: &str) -> Cow<'_, str> {
    match derived_message_name(name) {
        Some(message) => Cow::Owned(format!("{PACKAGE}.{message}")),
        None => Cow::Borrowed(name),
    }
}

/// Returns schema data with the current names. Data that is not a descriptor set is returned unchanged.
pub fn current_data<'a>(name: &str, data: &'a [u8]) -> Cow<'a, [u8]> {
    let renamed = derived_message_name(name).and_then(|message| {
        let mut set = FileDescriptorSet::decode(data).ok()?;
        for file in &mut set.file {
            file.name = Some(format!("{PACKAGE}/{message}.proto"));
            file.package = Some(PACKAGE.to_string());
        }
        Some(set.encode_to_vec())
    });
    renamed.map_or(Cow::Borrowed(data), Cow::Owned)
}

/// Returns the message name if the package has the same name in lower case.
fn derived_message_name(name: &str) -> Option<&str> {
    let (package, message) = name.split_once('.')?;
    (!message.is_empty() && package == message.to_lowercase()).then_some(message)
}

#[cfg(test)]
mod tests {
    use prost_reflect::DescriptorPool;

    use super::super::messages::State;
    use super::*;

    #[test]
    fn own_messages_are_in_the_package_phalanx_with_unchanged_fields() {
        let (derived, phalanx_schema) =
            (State::get_schema().expect("derived"), schema_of::<State>().expect("a schema"));
        assert_eq!((derived.name.as_str(), phalanx_schema.name.as_str()), ("state.State", "phalanx.State"));
        let fields = |schema: &Schema| {
            let pool = DescriptorPool::decode(&*schema.data).expect("descriptors");
            let message = pool.get_message_by_name(&schema.name).expect("the message");
            message.fields().map(|field| (field.number(), field.name().to_string(), field.kind())).collect::<Vec<_>>()
        };
        assert_eq!(fields(&phalanx_schema), fields(&derived));
        assert_eq!(fields(&phalanx_schema).len(), 11);
        // A current schema is unchanged.
        assert_eq!(current_data(&phalanx_schema.name, &phalanx_schema.data), phalanx_schema.data);
    }

    #[test]
    fn other_messages_keep_their_names() {
        for name in ["foxglove.Log", "foxglove.SceneUpdate", "Log", "", ".", "state.Other", "phalanx.State"] {
            assert!(matches!(current_name(name), Cow::Borrowed(same) if same == name), "{name}");
        }
        // Invalid descriptor data is unchanged.
        assert!(matches!(current_data("state.State", &[255; 9]), Cow::Borrowed(_)));
    }
}

//! The schemas of messages: our own are under `phalanx.`, those of Foxglove under `foxglove.`.
//!
//! The derive puts every message into a package of its own name (`state.State`), and so did logs once: they are read as if
//! theirs were of today.

use std::borrow::Cow;

use foxglove::{Encode, Schema};
use prost_reflect::prost::Message;
use prost_reflect::prost_types::FileDescriptorSet;

/// The package of our own messages.
const PACKAGE: &str = "phalanx";

/// The schema of a message as logs have it.
pub fn schema_of<M: Encode>() -> Option<Schema> {
    let derived = M::get_schema()?;
    let data = current_data(&derived.name, &derived.data).into_owned();
    Some(Schema::new(current_name(&derived.name), derived.encoding, data))
}

/// The name that a schema has today: `phalanx.State` of `state.State`.
pub fn current_name(name: &str) -> Cow<'_, str> {
    match own(name) {
        Some(message) => Cow::Owned(format!("{PACKAGE}.{message}")),
        None => Cow::Borrowed(name),
    }
}

/// The descriptors that a schema of this name has today; what are none stay as they are.
pub fn current_data<'a>(name: &str, data: &'a [u8]) -> Cow<'a, [u8]> {
    let renamed = own(name).and_then(|message| {
        let mut set = FileDescriptorSet::decode(data).ok()?;
        for file in &mut set.file {
            file.name = Some(format!("{PACKAGE}/{message}.proto"));
            file.package = Some(PACKAGE.to_string());
        }
        Some(set.encode_to_vec())
    });
    renamed.map_or(Cow::Borrowed(data), Cow::Owned)
}

/// The message in a package of its own name.
fn own(name: &str) -> Option<&str> {
    let (package, message) = name.split_once('.')?;
    (!message.is_empty() && package == message.to_lowercase()).then_some(message)
}

#[cfg(test)]
mod tests {
    use prost_reflect::DescriptorPool;

    use super::super::messages::State;
    use super::*;

    #[test]
    fn our_messages_are_under_our_name_and_keep_their_fields() {
        let (derived, ours) = (State::get_schema().expect("derived"), schema_of::<State>().expect("a schema"));
        assert_eq!((derived.name.as_str(), ours.name.as_str()), ("state.State", "phalanx.State"));
        let fields = |schema: &Schema| {
            let pool = DescriptorPool::decode(&*schema.data).expect("descriptors");
            let message = pool.get_message_by_name(&schema.name).expect("the message");
            message.fields().map(|field| (field.number(), field.name().to_string(), field.kind())).collect::<Vec<_>>()
        };
        assert_eq!(fields(&ours), fields(&derived));
        assert_eq!(fields(&ours).len(), 11);
        // What is of today stays.
        assert_eq!(current_data(&ours.name, &ours.data), ours.data);
    }

    #[test]
    fn the_messages_of_others_keep_their_names() {
        for name in ["foxglove.Log", "foxglove.SceneUpdate", "Log", "", ".", "state.Other", "phalanx.State"] {
            assert!(matches!(current_name(name), Cow::Borrowed(same) if same == name), "{name}");
        }
        // What claims to be ours and is no set of descriptors is left alone.
        assert!(matches!(current_data("state.State", &[255; 9]), Cow::Borrowed(_)));
    }
}

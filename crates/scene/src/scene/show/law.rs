//! Writes the law of a contact.

use super::super::table::law::ContactSettings;
use super::super::table::show;
use super::toml_writer::TomlWriter;
use crate::law::ContactLaw;

pub fn write_contact(out: &mut TomlWriter, path: &str, law: &ContactLaw) {
    show(out, path, &ContactSettings(law.normal));
    let path = format!("{path}.friction");
    match &law.friction {
        Some(friction) => show(out, &path, friction),
        None => {
            out.section(&path);
            out.float("mu_static", 0.0);
        }
    }
}

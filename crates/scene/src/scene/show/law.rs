//! The law of a contact.

use super::super::table::law::Contact;
use super::super::table::show;
use super::out::Out;
use crate::law::ContactLaw;

pub fn contact(out: &mut Out, path: &str, law: &ContactLaw) {
    show(out, path, &Contact(law.normal));
    let path = format!("{path}.friction");
    match &law.friction {
        Some(friction) => show(out, &path, friction),
        None => {
            out.section(&path);
            out.float("mu_static", 0.0);
        }
    }
}

//! What both kinds of scene have.

use super::super::table::law::Contact;
use super::super::table::show;
use super::super::table::top::Heading;
use super::super::words::SceneKind;
use super::out::Out;
use crate::law::ContactLaw;

/// Begins a scene; its name, description, kind, duration and gravity.
pub fn heading(out: &mut Out, kind: SceneKind, of: (&str, &str, f64, [f64; 2])) -> Heading {
    out.comment("Scene with every default filled in; masses and lengths as simulated.");
    let (name, description, duration_s, gravity_m_s2) = of;
    let (name, description) = (name.to_string(), description.to_string());
    Heading { extends: String::new(), name, description, kind, duration_s, gravity_m_s2 }
}

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

//! What both kinds of scene have.

use super::super::kinds::Words;
use super::super::table::law::Contact;
use super::super::table::show;
use super::super::words::SceneKind;
use super::out::Out;
use crate::law::ContactLaw;
use crate::units::Dimension;

/// Name, description, kind, duration and gravity.
pub fn heading(out: &mut Out, kind: SceneKind, of: (&str, &str, f64, [f64; 2])) {
    let (name, description, duration_s, gravity_m_s2) = of;
    out.comment("Scene with every default filled in; masses and lengths as simulated.");
    out.text("name", name);
    if !description.is_empty() {
        out.text("description", description);
    }
    out.text("kind", kind.word());
    out.quantity("duration", duration_s, Dimension::Time);
    out.quantities("gravity", &gravity_m_s2, Dimension::Acceleration);
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

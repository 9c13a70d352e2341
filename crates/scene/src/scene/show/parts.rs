//! What all kinds of scene have.

use super::super::Scene;
use super::super::table::law::Contact;
use super::super::table::show;
use super::super::table::top::Heading;
use super::out::Out;
use crate::law::ContactLaw;

/// Begins a scene; its name, description, kind, duration and gravity.
pub fn heading(out: &mut Out, scene: &Scene) -> Heading {
    out.comment("Scene with every default filled in; masses and lengths as simulated.");
    Heading {
        extends: String::new(),
        name: scene.name.clone(),
        description: scene.description.clone(),
        kind: scene.kind(),
        duration_s: scene.duration_s,
        gravity_m_s2: scene.system.gravity_m_s2,
    }
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

//! What both kinds of scene have.

use super::super::kinds::Words;
use super::super::words::SceneKind;
use super::out::Out;
use crate::law::{ContactLaw, FrictionLaw};
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
    out.section(path);
    out.float("stiffness_si", law.normal.stiffness_n_per_m_e);
    out.float("exponent", law.normal.exponent);
    out.quantity("damping", law.normal.damping_max_n_s_per_m, Dimension::LinearDamping);
    out.quantity("transition", law.normal.transition_m, Dimension::Length);
    out.section(&format!("{path}.friction"));
    match &law.friction {
        None => out.float("mu_static", 0.0),
        Some(FrictionLaw { mu_static, mu_dynamic, v_static_m_s, v_dynamic_m_s }) => {
            out.float("mu_static", *mu_static);
            out.float("mu_dynamic", *mu_dynamic);
            out.quantity("v_static", *v_static_m_s, Dimension::Speed);
            out.quantity("v_dynamic", *v_dynamic_m_s, Dimension::Speed);
        }
    }
}

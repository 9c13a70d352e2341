//! What both kinds of scene have.

use super::super::kinds::Words;
use super::super::words::{EngineLaw, SceneKind, StepSizes};
use super::super::{Engine, Integrator, LogRates, Response, Stepping};
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

pub fn integrator(out: &mut Out, integrator: &Integrator) {
    out.section("integrator");
    out.text("preset", integrator.preset.word());
    out.text("method", integrator.method.word());
    out.float("rtol", integrator.rtol);
    out.quantity("atol_angle", integrator.atol_angle_rad, Dimension::Angle);
    out.quantity("atol_rate", integrator.atol_rate_rad_s, Dimension::AngularRate);
    out.raw("max_steps", integrator.max_steps);
}

pub fn engine(out: &mut Out, engine: &Engine) {
    out.section("engine");
    out.text("construction", engine.construction.word());
    match engine.response {
        Response::Laws => out.text("law", EngineLaw::Scene.word()),
        Response::Rapier { friction, restitution } => {
            out.text("law", EngineLaw::Rapier.word());
            out.float("friction", friction);
            out.float("restitution", restitution);
        }
    }
    match engine.stepping {
        Stepping::Fixed { step_s } => {
            out.text("stepping", StepSizes::Fixed.word());
            out.quantity("step", step_s, Dimension::Time);
        }
        Stepping::Adaptive { tolerance_m, max_step_s } => {
            out.text("stepping", StepSizes::Adaptive.word());
            out.quantity("tolerance", tolerance_m, Dimension::Length);
            out.quantity("max_step", max_step_s, Dimension::Time);
        }
    }
    out.raw("iterations", engine.iterations);
    out.raw("max_steps", engine.max_steps);
}

pub fn log(out: &mut Out, log: LogRates) {
    out.section("log");
    out.quantity("numeric_rate", log.numeric_hz, Dimension::Frequency);
    out.quantity("picture_rate", log.picture_hz, Dimension::Frequency);
}

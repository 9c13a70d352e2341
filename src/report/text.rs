//! The report for people: short tables with units.

use std::fmt::Write;

use super::check;
use super::document::{
    Contacts, Dynamics, Energies, EngineUsed, Failure, Final, IntegratorUsed, PhalanxReport, RunReport, WorkReport,
};
use crate::wording::duration;
use crate::wording::figures::{figure, row};
use crate::wording::sheet::{Sheet, table};

/// The whole summary, with a line end.
pub fn text(report: &RunReport) -> Sheet {
    let mut sections = vec![heading(&Heading {
        scene: &report.scene,
        model: &report.model,
        duration_s: report.duration_s,
        steps: report.steps,
        wall_s: report.wall_s,
        end_s: report.end_s,
        error: report.error.as_ref(),
        work: report.work.as_ref(),
        integrator: report.integrator.as_ref(),
        engine: report.engine.as_ref(),
        joints: true,
        loop_gap_m: report.loop_gap_m,
        log: report.log.as_deref(),
        page: report.page.as_deref(),
    })];
    if let (Some(last), Some(end_s)) = (&report.last, report.end_s) {
        sections.push(final_state(last, end_s));
    }
    if let Some(all) = &report.contacts {
        sections.push(contacts(all));
    }
    if let Some(energy) = &report.energy {
        sections.push(energies(energy));
    }
    if let Some(criteria) = &report.criteria {
        sections.push(dynamics(criteria));
    }
    if let Some(line) = check::line(report.check.as_ref(), report.steps) {
        sections.push(line);
    }
    Sheet::join(sections)
}

/// What every summary begins with.
pub(super) struct Heading<'a> {
    pub scene: &'a str,
    pub model: &'a str,
    pub duration_s: f64,
    pub steps: Option<u64>,
    pub wall_s: f64,
    pub end_s: Option<f64>,
    pub error: Option<&'a Failure>,
    pub work: Option<&'a WorkReport>,
    pub integrator: Option<&'a IntegratorUsed>,
    pub engine: Option<&'a EngineUsed>,
    /// Whether the scene has joints to speak of.
    pub joints: bool,
    pub loop_gap_m: Option<f64>,
    pub log: Option<&'a str>,
    pub page: Option<&'a str>,
}

pub(super) fn heading(report: &Heading<'_>) -> Sheet {
    let mut text = Sheet::default();
    // Writing to a sheet cannot fail.
    let _ = writeln!(
        text,
        "{}: {} model{}",
        report.scene,
        report.model,
        report
            .integrator
            .map(integrator)
            .or_else(|| report.engine.map(|used| engine(used, report.joints)))
            .unwrap_or_default()
    );
    let _ = writeln!(text, "{}{} of wall time", cost(report), duration(report.wall_s));
    if let Some(gap_m) = report.loop_gap_m {
        let _ = writeln!(text, "joints open by at most {} µm", figure(gap_m * 1e6, 3));
    }
    if let Some(error) = report.error {
        let _ = writeln!(
            text,
            "NOT COMPLETED: stopped at {} of {}: {}",
            duration(error.time_s),
            duration(report.duration_s),
            error.reason
        );
    }
    if let Some(log) = report.log {
        let _ = writeln!(text, "log: {log}");
    }
    if let Some(page) = report.page {
        let _ = writeln!(text, "page: {page}");
    }
    text
}

pub(super) fn integrator(used: &IntegratorUsed) -> String {
    format!(", {} (rtol {:e}, {} preset)", used.method, used.rtol, used.preset)
}

pub(super) fn engine(used: &EngineUsed, joints: bool) -> String {
    let stepping = match (used.step_s, used.tolerance_m, used.max_step_s) {
        (Some(step_s), ..) => format!("steps of {}", duration(step_s)),
        (None, Some(tolerance_m), Some(max_step_s)) => {
            let what = if joints { "joints" } else { "discs" };
            format!("{what} within {} m a step, steps up to {}", figure(tolerance_m, 3), duration(max_step_s))
        }
        _ => String::new(),
    };
    let law = if used.law == "rapier" { ", rapier's own contact" } else { "" };
    match joints {
        true => format!(", {} construction ({stepping}, {} sweeps{law})", used.construction, used.iterations),
        false => format!(", {stepping}{law}"),
    }
}

fn cost(report: &Heading<'_>) -> String {
    let (Some(end_s), Some(steps), Some(work)) = (report.end_s, report.steps, report.work) else {
        return String::new();
    };
    let effort = match report.engine {
        None => format!("{} evaluations, {} Jacobians", work.rhs_evaluations, work.jacobian_evaluations),
        Some(_) => {
            format!("{} contact sub-steps, {} Newton iterations", work.contact_substeps, work.newton_iterations)
        }
    };
    let (rejected, events) = (work.rejected_steps, work.events);
    let plural = if events == 1 { "" } else { "s" };
    format!("{} in {steps} steps ({rejected} rejected), {effort}, {events} event{plural}; ", duration(end_s))
}

pub(super) fn final_state(last: &Final, end_s: f64) -> Sheet {
    let degrees = |angle: f64| format!("{:.6}", angle.to_degrees());
    table(&[
        row([&format!("at {}", duration(end_s)), "q11", "q21", "q22"]),
        row(["angle, deg", &degrees(last.q11_rad), &degrees(last.q21_rad), &degrees(last.q22_rad)]),
        row(["rate, rad/s", &figure(last.qd11_rad_s, 5), &figure(last.qd21_rad_s, 5)]),
    ])
}

pub(super) fn contacts(contacts: &Contacts) -> Sheet {
    let phalanx = |name: &str, report: &PhalanxReport| {
        row([
            name,
            &milliseconds(report.first_s),
            &report.touchdowns.to_string(),
            &figure(report.final_normal_n, 6),
            &figure(report.final_tangential_n, 6),
            &figure(report.peak_normal_n, 5),
            &figure(report.max_penetration_m * 1e6, 5),
            &figure(report.impulse_n_s * 1e3, 5),
        ])
    };
    let limit = &contacts.limit;
    let mut text = table(&[
        row([
            "contact",
            "first, ms",
            "touch-downs",
            "normal, N",
            "friction, N",
            "peak, N",
            "depth, µm",
            "impulse, mN·s",
        ]),
        phalanx("proximal", &contacts.proximal),
        phalanx("distal", &contacts.distal),
    ]);
    text.push('\n');
    text.push(table(&[
        row(["", "first, ms", "touch-downs", "torque, N·m", "peak, N·m", "depth, µrad", "impulse, mN·m·s"]),
        row([
            "joint limit",
            &milliseconds(limit.first_s),
            &limit.touchdowns.to_string(),
            &figure(limit.final_torque_n_m, 6),
            &figure(limit.peak_torque_n_m, 5),
            &figure(limit.max_penetration_rad * 1e6, 5),
            &figure(limit.impulse_n_m_s * 1e3, 5),
        ]),
    ]));
    text
}

pub(super) fn energies(energy: &Energies) -> Sheet {
    let mj = |joule: f64| figure(joule * 1e3, 5);
    table(&[
        row(["energy", "kinetic", "gravity", "spring", "contact", "dissipated", "motor work", "balance"]),
        row([
            "mJ",
            &mj(energy.kinetic_j),
            &mj(energy.gravity_j),
            &mj(energy.spring_j),
            &mj(energy.elastic_j),
            &mj(energy.dissipated_j),
            &mj(energy.motor_work_j),
            &mj(energy.balance_j),
        ]),
    ])
}

pub(super) fn dynamics(criteria: &Dynamics) -> Sheet {
    let rebound = match criteria.rebound_percent {
        Some(percent) => format!("{} %", figure(percent, 4)),
        None => "–".to_string(),
    };
    let mut text = table(&[
        row(["criteria", "class", "tts, ms", "rebound", "in position first, ms"]),
        row(["", criteria.class, &milliseconds(criteria.tts_s), &rebound, &milliseconds(criteria.t_geo_s)]),
    ]);
    if !criteria.statically_stable {
        text.push_str("Unstable in statics: at rest a phalanx would have to pull (phalanx statics says which).\n");
    }
    text
}

pub(super) fn milliseconds(time_s: Option<f64>) -> String {
    time_s.map_or("–".to_string(), |time_s| format!("{:.6}", time_s * 1e3))
}

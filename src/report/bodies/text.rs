//! The report of a run of discs for people: short tables with units.

use std::collections::BTreeMap;

use super::super::check;
use super::super::document::Energies;
use super::super::text::{Heading, heading, milliseconds};
use super::document::{BodiesReport, DiscReport, PairReport};
use crate::wording::duration;
use crate::wording::figures::{figure, row};
use crate::wording::sheet::{Sheet, table};

/// The whole summary, with a line end.
pub fn bodies_text(report: &BodiesReport) -> Sheet {
    let mut sections = vec![heading(&Heading {
        scene: &report.scene,
        model: report.model,
        duration_s: report.duration_s,
        steps: report.steps,
        wall_s: report.wall_s,
        end_s: report.end_s,
        error: report.error.as_ref(),
        work: report.work.as_ref(),
        integrator: report.integrator.as_ref(),
        engine: report.engine.as_ref(),
        joints: false,
        loop_gap_m: None,
        log: report.log.as_deref(),
        page: report.page.as_deref(),
    })];
    if let (Some(all), Some(end_s)) = (&report.discs, report.end_s) {
        sections.push(discs(all, end_s));
    }
    if let Some(all) = report.contacts.as_ref().filter(|all| !all.is_empty()) {
        sections.push(contacts(all));
    }
    if let Some(energy) = &report.energy {
        sections.push(energies(energy));
    }
    if let Some(line) = check::line(report.check.as_ref(), report.steps) {
        sections.push(line);
    }
    Sheet::join(sections)
}

pub(in crate::report) fn discs(discs: &BTreeMap<String, DiscReport>, end_s: f64) -> Sheet {
    let at = format!("at {}", duration(end_s));
    let mut rows = vec![row([&at, "", "x, mm", "y, mm", "angle, deg", "vx, m/s", "vy, m/s", "spin, rad/s"])];
    for (name, disc) in discs {
        rows.push(row([
            name,
            disc.motion,
            &figure(disc.x_m * 1e3, 7),
            &figure(disc.y_m * 1e3, 7),
            &figure(disc.angle_rad.to_degrees(), 6),
            &figure(disc.vx_m_s, 6),
            &figure(disc.vy_m_s, 6),
            &figure(disc.spin_rad_s, 6),
        ]));
    }
    table(&rows)
}

pub(in crate::report) fn contacts(pairs: &BTreeMap<String, PairReport>) -> Sheet {
    let mut rows = vec![row([
        "contact",
        "first, ms",
        "touch-downs",
        "normal, N",
        "friction, N",
        "peak, N",
        "depth, µm",
        "impulse, mN·s",
        "restitution",
    ])];
    for (name, pair) in pairs {
        rows.push(row([
            name,
            &milliseconds(pair.first_s),
            &pair.touchdowns.to_string(),
            &figure(pair.final_normal_n, 6),
            &figure(pair.final_tangential_n, 6),
            &figure(pair.peak_normal_n, 5),
            &figure(pair.max_penetration_m * 1e6, 5),
            &figure(pair.impulse_n_s * 1e3, 5),
            &pair.restitution.map_or("–".to_string(), |ratio| figure(ratio, 5)),
        ]));
    }
    table(&rows)
}

pub(in crate::report) fn energies(energy: &Energies) -> Sheet {
    let mj = |joule: f64| figure(joule * 1e3, 5);
    table(&[
        row(["energy", "kinetic", "gravity", "contact", "dissipated", "drive work", "balance"]),
        row([
            "mJ",
            &mj(energy.kinetic_j),
            &mj(energy.gravity_j),
            &mj(energy.elastic_j),
            &mj(energy.dissipated_j),
            &mj(energy.motor_work_j),
            &mj(energy.balance_j),
        ]),
    ])
}

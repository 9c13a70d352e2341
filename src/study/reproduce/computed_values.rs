//! Computed values by figure key, in SI units.

use std::collections::BTreeMap;

use super::Reproduction;
use crate::criteria::Class;
use crate::gripper::total_mass;
use crate::study::select::Candidate;
use crate::study::volume::{Intersection, count_volume, intersections, percent};
use crate::trace::FingerContact;

/// Number of the design that the thesis chooses.
pub const CHOSEN_DESIGN: i64 = 95;

/// Returns a value for every key of [`super::figures`].
pub fn computed_values(found: &Reproduction) -> BTreeMap<String, f64> {
    let mut values = BTreeMap::new();
    let mut set = |key: &str, value: f64| {
        values.insert(key.to_string(), value);
    };
    let (sizing, designs) = (&found.sizing, &found.designs);
    set("sizing.motor_rigid_n_m", sizing.rigid.motor_n_m);
    set("sizing.motor_whole_n_m", sizing.whole.motor_n_m);
    set("sizing.spring_n_m", sizing.rigid.spring_n_m);
    set("sizing.best_places", sizing.last_placements_weakest as f64);
    set("sizing.constant_better", sizing.constant_spring_weaker as f64);

    set("design.l21_m", designs.lengths.l21_m);
    set("design.l12_m", designs.lengths.l12_m);
    set("design.l22_m", designs.lengths.l22_m);
    set("design.t22_m", designs.lengths.t22_m);
    set("design.mass_l11_kg", designs.bodies.l11.mass_kg);
    set("design.mass_l21_kg", designs.bodies.l21.mass_kg);
    set("design.mass_l12_kg", designs.bodies.l12.mass_kg);
    set("design.mass_l22_kg", designs.bodies.l22.mass_kg);
    set("design.mass_kg", total_mass(&designs.bodies));
    set("design.mass_min_kg", designs.mass_kg[0]);
    set("design.mass_max_kg", designs.mass_kg[1]);
    set("design.trajectory_min_rad", designs.trajectory_rad[0]);
    set("design.trajectory_max_rad", designs.trajectory_rad[1]);

    let necessary = &designs.necessary_count;
    set("statics.form_closed_quarters", designs.form_closed_quarters as f64);
    set("statics.constraints", (necessary.contacts + necessary.motors) as f64);
    set("statics.constraints_needed", (necessary.hand + necessary.object + 1) as f64);
    for (condition, mu) in [(0, "0"), (1, "0.8")] {
        let classes = found.selection.classes.get(condition);
        set(&format!("statics.stable_mu_{mu}"), classes.map_or(f64::NAN, |counts| counts.statically_stable as f64));
        set(&format!("sweep.stable_mu_{mu}"), classes.map_or(f64::NAN, |counts| counts.dynamically_stable() as f64));
    }
    set("statics.form_closed", found.selection.classes.first().map_or(f64::NAN, |counts| counts.form_closed as f64));
    let is_palm_stable = |run: &&Candidate| {
        let stable = matches!(run.class, Some(Class::Stable | Class::SemiStable));
        run.condition == 0 && stable && run.pfp_n.is_some_and(|pfp_n| pfp_n >= 0.0)
    };
    set("sweep.palm_stable_mu_0", found.selection.runs.iter().filter(is_palm_stable).count() as f64);

    volumes(found, &mut set);

    set("selection.selected", found.selection.ranking.len() as f64);
    let ranked =
        found.selection.ranking.iter().find(|entry| found.selection.runs[entry.run_index].design == CHOSEN_DESIGN);
    set("selection.place_95", ranked.map_or(f64::NAN, |entry| entry.rank as f64));
    set("selection.r_wc_95", ranked.map_or(f64::NAN, |entry| entry.r_wc));

    let (chosen, cad) = (&found.chosen, &found.cad);
    set("design_95.pfp_n", chosen.pfp_n);
    set("design_95.tts_s", chosen.criteria.tts_s.unwrap_or(f64::NAN));
    set("design_95.f21_n", chosen.outcome.last.contact(FingerContact::Proximal).normal_n);
    set("design_95.f22_n", chosen.outcome.last.contact(FingerContact::Distal).normal_n);
    set("cad.mass_kg", cad.mass_kg);
    set("cad.saved_percent", 100.0 * (1.0 - cad.mass_kg / chosen.mass_kg));
    set("cad.tts_s", cad.criteria.tts_s.unwrap_or(f64::NAN));
    values
}

fn volumes(found: &Reproduction, set: &mut impl FnMut(&str, f64)) {
    for volume in &found.volumes {
        let counts = count_volume(volume);
        let (base, mu) = (format!("base_{}_mm", rounded_mm(1e3 * volume.base_m)), volume.mu_static);
        set(&format!("volume.stable_percent.{base}.mu_{mu}"), percent(counts.stable, counts.points));
        set(&format!("volume.palm_percent.{base}.mu_{mu}"), percent(counts.palm_positive, counts.points));
        set(&format!("volume.pfp_max_n.{base}.mu_{mu}"), counts.best.map_or(f64::NAN, |best| best.pfp_n));
        // Table 3.5 counts form-closed points of the stable region without friction.
        if mu == 0.0 {
            set(&format!("volume.closed_percent.{base}"), percent(counts.form_closed, counts.points));
        }
    }
    for counts in intersections(&found.volumes) {
        let Intersection { mu_static: mu, points, .. } = counts;
        set(&format!("volume.stable_percent.all.mu_{mu}"), percent(counts.stable, points));
        set(&format!("volume.palm_percent.all.mu_{mu}"), percent(counts.palm_positive, points));
        if mu == 0.0 {
            set("volume.closed_percent.all", percent(counts.form_closed, points));
        }
    }
}

/// Returns a length in mm without the rounding error of its conversion.
fn rounded_mm(value_mm: f64) -> f64 {
    (value_mm * 1e6).round() / 1e6
}

//! Computed values by figure key, in SI units.

use std::collections::BTreeMap;

use super::Reproduction;
use super::simulations::{CHOSEN_DESIGN, Run, is_stable};
use crate::gripper::{Finger, total_mass};
use crate::text::rounded_mm;
use crate::trace::FingerContact;
use crate::volume::{count_volume, intersections};

/// Returns a value for every key of [`figures`](super::figures).
pub fn computed_values(found: &Reproduction) -> BTreeMap<String, f64> {
    let Reproduction { sizing, simulations, necessary_count: necessary, chosen, cad, .. } = found;
    let count = |condition: usize, property: fn(&Run) -> bool| simulations.count(condition, property) as f64;
    let ranked = simulations.ranking.iter().find(|ranked| simulations.runs[ranked.run].design == CHOSEN_DESIGN);
    let Some(Finger { lengths, bodies, .. }) = simulations.chosen().map(|run| run.scene.finger().linkage) else {
        return BTreeMap::new();
    };
    let final_force_n = |contact| chosen.outcome.last.finger_contact(contact).normal_n;
    let statically_stable = |run: &Run| run.force_positive == Some(true);
    let palm_stable = |run: &Run| is_stable(run.class) && run.pfp_n.is_some_and(|pfp_n| pfp_n >= 0.0);
    let values = [
        ("sizing.motor_rigid_n_m", sizing.rigid.motor_n_m),
        ("sizing.motor_whole_n_m", sizing.whole.motor_n_m),
        ("sizing.spring_n_m", sizing.rigid.spring_n_m),
        ("sizing.best_places", sizing.last_placements_weakest as f64),
        ("sizing.constant_better", sizing.constant_spring_weaker as f64),
        ("design.l21_m", lengths.l21_m),
        ("design.l12_m", lengths.l12_m),
        ("design.l22_m", lengths.l22_m),
        ("design.t22_m", lengths.t22_m),
        ("design.mass_l11_kg", bodies.l11.mass_kg),
        ("design.mass_l21_kg", bodies.l21.mass_kg),
        ("design.mass_l12_kg", bodies.l12.mass_kg),
        ("design.mass_l22_kg", bodies.l22.mass_kg),
        ("design.mass_kg", total_mass(&bodies)),
        ("design.mass_min_kg", simulations.mass_kg[0]),
        ("design.mass_max_kg", simulations.mass_kg[1]),
        ("design.trajectory_min_rad", simulations.trajectory_rad[0]),
        ("design.trajectory_max_rad", simulations.trajectory_rad[1]),
        ("statics.form_closed_quarters", found.form_closed_quarters as f64),
        ("statics.constraints", (necessary.contacts + necessary.motors) as f64),
        ("statics.constraints_needed", (necessary.hand + necessary.object + 1) as f64),
        ("statics.stable_mu_0", count(0, statically_stable)),
        ("statics.stable_mu_0.8", count(1, statically_stable)),
        ("statics.form_closed", count(0, |run| run.form_closed == Some(true))),
        ("sweep.stable_mu_0", count(0, |run| is_stable(run.class))),
        ("sweep.stable_mu_0.8", count(1, |run| is_stable(run.class))),
        ("sweep.palm_stable_mu_0", count(0, palm_stable)),
        ("selection.selected", simulations.ranking.len() as f64),
        ("selection.place_95", ranked.map_or(f64::NAN, |ranked| ranked.rank as f64)),
        ("selection.r_wc_95", ranked.map_or(f64::NAN, |ranked| ranked.r_wc)),
        ("design_95.pfp_n", chosen.pfp_n),
        ("design_95.tts_s", chosen.criteria.tts_s.unwrap_or(f64::NAN)),
        ("design_95.f21_n", final_force_n(FingerContact::Proximal)),
        ("design_95.f22_n", final_force_n(FingerContact::Distal)),
        ("cad.mass_kg", cad.mass_kg),
        ("cad.saved_percent", 100.0 * (1.0 - cad.mass_kg / chosen.mass_kg)),
        ("cad.tts_s", cad.criteria.tts_s.unwrap_or(f64::NAN)),
    ];
    values.into_iter().map(|(key, value)| (key.to_string(), value)).chain(volume_values(found)).collect()
}

fn volume_values(found: &Reproduction) -> Vec<(String, f64)> {
    let mut values = Vec::new();
    let bases = found.volumes.iter().map(|volume| {
        let found = count_volume(volume);
        let largest_n = found.largest_palm_force.map_or(f64::NAN, |best| best.static_pfp_n);
        (format!("base_{}_mm", rounded_mm(volume.base_m)), volume.mu_static, found.counts, Some(largest_n))
    });
    let all = intersections(&found.volumes);
    let all = all.iter().map(|found| ("all".to_string(), found.mu_static, found.counts, None));
    for (base, mu, counts, largest_n) in bases.chain(all) {
        values.push((format!("volume.stable_percent.{base}.mu_{mu}"), counts.percent(counts.stable)));
        values.push((format!("volume.palm_percent.{base}.mu_{mu}"), counts.percent(counts.palm_positive)));
        values.extend(largest_n.map(|largest_n| (format!("volume.pfp_max_n.{base}.mu_{mu}"), largest_n)));
        // Table 3.5 counts form-closed points of the stable region without friction.
        if mu == 0.0 {
            values.push((format!("volume.closed_percent.{base}"), counts.percent(counts.form_closed)));
        }
    }
    values
}

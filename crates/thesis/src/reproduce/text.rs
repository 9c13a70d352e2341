//! Text report of a reproduction.

use super::runs::{describe_checks, list_runs};
use super::{Comparison, MAX_TTS_DIFFERENCE_S, Reproduction, Verdict};
use crate::format::format_duration;
use crate::format::numbers::row;
use crate::format::report::{Report, ToReport, table};

/// Tables of all comparisons, the near-chaotic runs, and the number of values outside their tolerance.
impl ToReport for Reproduction {
    fn report(&self) -> Report {
        let mut text = Report::default();
        for comparisons in self.comparisons.chunk_by(|a, b| a.section == b.section) {
            let header = row([comparisons[0].section, "thesis", "ours", "expected", ""]);
            let rows: Vec<_> = std::iter::once(header).chain(comparisons.iter().map(line)).collect();
            text.push(table(&rows).with("\n"));
        }
        let chaos = &self.near_chaotic;
        let changed: Vec<i64> = chaos.class_changes.iter().map(|change| change.run).collect();
        let mut add = |line: String| text.push_str(&(line + "\n"));
        add(format!(
            "runs whose class changes with the method, the tolerance or a torque perturbed by up to 1e-7: {}",
            list_runs(&changed)
        ));
        add(describe_checks(&self.checks));
        add(format!(
            "runs whose time to stability changes by more than {}: {}",
            format_duration(MAX_TTS_DIFFERENCE_S),
            list_runs(&chaos.drifting_runs)
        ));
        for (counts, condition) in chaos.conditions.iter().zip(&self.simulations.conditions) {
            let spread = || counts.by_variation.iter().chain([&counts.study]);
            add(format!(
                "dynamically stable, {condition}: {} to {} by variation, {} in all of them, {} in any",
                spread().min().unwrap_or(&0),
                spread().max().unwrap_or(&0),
                counts.in_all,
                counts.in_any
            ));
        }
        add(match self.outside {
            0 => format!("all {} values with an expected value are within tolerance", self.judged),
            outside => format!("{outside} of {} values with an expected value are outside tolerance", self.judged),
        });
        text
    }
}

fn line(comparison: &Comparison) -> Vec<String> {
    vec![
        format!("  {}", comparison.quantity),
        comparison.thesis_text(),
        comparison.ours_text(),
        comparison.expected_text(),
        if comparison.verdict == Verdict::Outside { "outside" } else { "" }.to_string(),
    ]
}

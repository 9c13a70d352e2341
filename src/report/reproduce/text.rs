//! Text report of a reproduction.

use super::sweep::describe_checks;
use super::{Comparison, ReproductionReport, Verdict};
use crate::format::format_duration;
use crate::format::numbers::row;
use crate::format::report::{Report, ToReport, table};
use crate::study::reproduce::MAX_TTS_DIFFERENCE_S;

/// Tables of all comparisons, the near-chaotic runs, and the number of values outside their tolerance.
impl ToReport for ReproductionReport<'_> {
    fn report(&self) -> Report {
        let mut text = Report::default();
        let mut section = "";
        let mut rows = Vec::new();
        let flush = |text: &mut Report, rows: &mut Vec<Vec<String>>| {
            if !rows.is_empty() {
                text.push(table(rows).with('\n'));
                rows.clear();
            }
        };
        for comparison in &self.comparisons {
            if comparison.section != section {
                flush(&mut text, &mut rows);
                section = comparison.section;
                rows.push(row([section, "thesis", "ours", "expected", ""]));
            }
            rows.push(line(comparison));
        }
        flush(&mut text, &mut rows);
        let changed: Vec<String> = self.near_chaotic.class_changes.iter().map(|flip| flip.run.to_string()).collect();
        text.push_str(&match changed.is_empty() {
            true => "no run changes its class with the tolerances\n".to_string(),
            false => format!(
                "runs whose class changes with the method, the tolerance or a torque perturbed by up to 1e-7: {}\n",
                changed.join(", ")
            ),
        });
        text.push_str(&format!("{}\n", describe_checks(&self.reproduction.checks)));
        let drifting: Vec<String> = self.near_chaotic.drifting_runs.iter().map(i64::to_string).collect();
        text.push_str(&match drifting.is_empty() {
            true => format!("no time to stability changes by more than {}\n", format_duration(MAX_TTS_DIFFERENCE_S)),
            false => {
                format!(
                    "runs whose time to stability changes by more than {}: {}\n",
                    format_duration(MAX_TTS_DIFFERENCE_S),
                    drifting.join(", ")
                )
            }
        });
        for (counts, condition) in self.near_chaotic.conditions.iter().zip(&self.reproduction.selection.conditions) {
            let spread = counts.by_variation.iter().chain([&counts.study]);
            text.push_str(&format!(
                "dynamically stable, {}: {} to {} by variation, {} in all of them, {} in any\n",
                crate::format::condition_name(condition),
                spread.clone().min().unwrap_or(&0),
                spread.max().unwrap_or(&0),
                counts.in_all,
                counts.in_any
            ));
        }
        text.push_str(&match self.outside {
            0 => format!("all {} values with an expected value are within tolerance\n", self.judged),
            outside => format!("{outside} of {} values with an expected value are outside tolerance\n", self.judged),
        });
        text
    }
}

fn line(comparison: &Comparison) -> Vec<String> {
    let verdict = match comparison.verdict {
        Verdict::Outside => "outside",
        _ => "",
    };
    vec![
        format!("  {}", comparison.quantity),
        comparison.thesis_text(),
        comparison.ours_text(),
        comparison.expected_text(),
        verdict.to_string(),
    ]
}

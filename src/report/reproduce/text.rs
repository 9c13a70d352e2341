//! A table for the terminal.

use super::sweep::checked;
use super::{Comparison, ReproductionReport, Verdict};
use crate::study::reproduce::DRIFT_S;
use crate::wording::duration;
use crate::wording::figures::row;
use crate::wording::report::{Report, Reported, table};

/// Every figure with its verdict, the near-chaotic runs, and what is outside.
impl Reported for ReproductionReport<'_> {
    fn report(&self) -> Report {
        let mut text = Report::default();
        let mut section = "";
        let mut rows = Vec::new();
        let flush = |text: &mut Report, rows: &mut Vec<Vec<String>>| {
            if !rows.is_empty() {
                text.push(table(rows).and('\n'));
                rows.clear();
            }
        };
        for one in &self.figures {
            if one.section != section {
                flush(&mut text, &mut rows);
                section = one.section;
                rows.push(row([section, "thesis", "ours", "expected", ""]));
            }
            rows.push(line(one));
        }
        flush(&mut text, &mut rows);
        let chaotic: Vec<String> = self.near_chaotic.runs.iter().map(|flip| flip.run.to_string()).collect();
        text.push_str(&match chaotic.is_empty() {
            true => "no run changes its class with the tolerances\n".to_string(),
            false => format!(
                "class changes with the method, the tolerance or a torque nudged by up to 1e-7: runs {}\n",
                chaotic.join(", ")
            ),
        });
        text.push_str(&format!("{}\n", checked(&self.found.checks)));
        let drifting: Vec<String> = self.near_chaotic.drifting_runs.iter().map(i64::to_string).collect();
        text.push_str(&match drifting.is_empty() {
            true => format!("no time to stability moves by more than {}\n", duration(DRIFT_S)),
            false => {
                format!("time to stability moves by more than {}: runs {}\n", duration(DRIFT_S), drifting.join(", "))
            }
        });
        for (of, condition) in self.near_chaotic.conditions.iter().zip(&self.found.selection.conditions) {
            let spread = of.by_variation.iter().chain([&of.study]);
            text.push_str(&format!(
                "dynamically stable, {}: {} to {} by variation, {} in all of them, {} in any\n",
                crate::wording::condition_name(condition),
                spread.clone().min().unwrap_or(&0),
                spread.max().unwrap_or(&0),
                of.in_all,
                of.in_any
            ));
        }
        text.push_str(&match self.outside {
            0 => format!("all {} figures with an expectation are within it\n", self.judged),
            outside => format!("{outside} of {} figures with an expectation are outside of it\n", self.judged),
        });
        text
    }
}

fn line(one: &Comparison) -> Vec<String> {
    let verdict = match one.verdict {
        Verdict::Outside => "outside",
        _ => "",
    };
    vec![format!("  {}", one.what), one.thesis_text(), one.ours_text(), one.expected_text(), verdict.to_string()]
}

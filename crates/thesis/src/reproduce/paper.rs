//! The paper: its sections in order, with those on sizing, statics, design 95 and the errata. The text report.

use super::chaos::MAX_TTS_DIFFERENCE_S;
use super::figures::{Comparison, Verdict};
use super::sections::{self, cells, describe_checks, list_runs};
use super::{Closing, OtherSizing, Reproduction, designs};
use crate::format::format_duration;
use crate::format::numbers::{format_number, row};
use crate::format::report::{Cell, Report, ToReport, table};
use crate::plot;
use crate::sizing::ProfilePoint;
use crate::text::count_and_share;
use crate::trace::FingerContact;

/// Main values, which the summary shows: starts and ends of their keys.
const MAIN_VALUES: [(&str, &str); 14] = [
    ("design.trajectory_", "_rad"),
    ("design.mass_m", "_kg"),
    ("design.mass_kg", ""),
    ("statics.stable_", ""),
    ("sweep.stable_", ""),
    ("statics.form_closed", "_closed"),
    ("sweep.palm_stable_", ""),
    ("selection.selected", ""),
    ("volume.stable_percent.base_", ".mu_0"),
    ("volume.stable_percent.base_", ".mu_0.8"),
    ("volume.closed_percent.base_", ""),
    ("design_95.pfp_n", ""),
    ("sizing.motor_rigid_n_m", ""),
    ("sizing.spring_n_m", ""),
];

impl Reproduction {
    /// Creates the paper.
    pub fn paper(&self) -> Report {
        let sections = [
            summary(self),
            sizing(self),
            all_designs(self),
            statics(self),
            sections::volumes(self),
            sections::simulations(self),
            sections::selection(self),
            closings(self),
            errata(self.errata),
        ];
        let paper = sections.into_iter().fold(Report::default(), Report::with);
        Report { title: "Reproduction of the thesis".to_string(), ..paper }
    }

    /// Returns the comparison with a key.
    pub(super) fn find(&self, key: &str) -> Option<&Comparison> {
        self.comparisons.iter().find(|comparison| comparison.figure.key == key)
    }

    /// Adds a table of the comparisons of a section of `thesis.csv`.
    pub(super) fn section_table<'a>(&'a self, section: Report, caption: &str, names: &[&'a str]) -> Report {
        let of_section = |name: &'a str| self.comparisons.iter().filter(move |found| found.figure.section == name);
        comparison_table(section, caption, &names.iter().copied().flat_map(of_section).collect::<Vec<_>>())
    }
}

/// Adds a table of comparisons to a section, with each reason once below it.
fn comparison_table(section: Report, caption: &str, comparisons: &[&Comparison]) -> Report {
    let mut reasons: Vec<String> = Vec::new();
    let mut letter = |reason: String| {
        if reason.is_empty() {
            return String::new();
        }
        let index = reasons.iter().position(|known| *known == reason).unwrap_or_else(|| {
            reasons.push(reason);
            reasons.len() - 1
        });
        note_letter(index)
    };
    let row = |comparison: &&Comparison| {
        vec![
            Cell::prose(&comparison.figure.quantity),
            Cell::new(comparison.thesis_text()),
            comparison.cell(),
            Cell::new(comparison.expected_text()),
            Cell::prose(&comparison.figure.source),
            Cell::prose(letter(comparison.reason_text())),
        ]
    };
    let rows = comparisons.iter().map(row).collect();
    let header = ["quantity", "thesis", "ours", "expected", "source", "reason"];
    let section = section.with_table(caption, &header, rows);
    let notes: Vec<String> =
        reasons.iter().enumerate().map(|(index, reason)| format!("{}: {reason}", note_letter(index))).collect();
    if notes.is_empty() { section } else { section.with_notes(notes) }
}

/// Returns the letter that identifies a reason.
fn note_letter(index: usize) -> String {
    char::from(b'a' + (index % 26) as u8).to_string()
}

fn summary(found: &Reproduction) -> Report {
    let Reproduction { judged, near_chaotic, .. } = found;
    let outside = found.comparisons.iter().filter(|comparison| comparison.verdict == Verdict::Outside);
    let outside: Vec<&str> = outside.map(|comparison| comparison.figure.quantity.as_str()).collect();
    let verdict = match outside.len() {
        0 => format!("All {judged} values with an expected value are within tolerance."),
        count => {
            format!("{count} of {judged} values with an expected value are outside tolerance: {}.", outside.join("; "))
        }
    };
    let quick = match found.quick {
        true => " This is a quick run: volumes have fewer points and are not judged.",
        false => "",
    };
    let chaotic = format!(
        "Simulations whose class changes with the method, the tolerance or a torque perturbed by up to 1e-7: {} of {}. \
         Simulations whose time to stability changes by more than {}: {}.",
        near_chaotic.class_changes.len(),
        found.simulations.runs.len(),
        format_duration(MAX_TTS_DIFFERENCE_S),
        near_chaotic.drifting_runs.len()
    );
    let section = Report::section("Summary")
        .with_paragraph(
            "This report compares the values printed in the thesis with the values that phalanx computes from the corrected \
             equations, and explains the differences. No definition was changed to match a number. \"Expected\" values \
             come from an independent implementation of the same definitions.",
        )
        .with_paragraph(format!("{verdict}{quick} {chaotic}"));
    let main = MAIN_VALUES.iter().flat_map(|(start, end)| {
        let is_main = move |of: &&Comparison| of.figure.key.starts_with(start) && of.figure.key.ends_with(end);
        found.comparisons.iter().filter(is_main)
    });
    comparison_table(section, "Main values.", &main.collect::<Vec<_>>())
}

/// Section on sizing (thesis §3.3.2, Figs. 3.1–3.3).
fn sizing(found: &Reproduction) -> Report {
    let profile = &found.sizing.example;
    let section = Report::section("Sizing of spring and motor").with_paragraph(
        "The motor link follows a 7th-order polynomial from start to end in 10 ms. The spring must keep the finger rigid until \
         the proximal phalanx contacts the object; the motor torque is the RMS of the required torque.",
    );
    let section = found.section_table(section, "Sizing of design 95 and of all designs.", &["sizing"]);
    let row = |name: &str, torque_n_m: f64| cells([name.to_string(), format_number(torque_n_m * 1e3, 5)]);
    let positions = ["q21 − q11", "q12", "q22", "q11 + q12 − (q21 + q22)"].into_iter().zip(profile.placements_n_m);
    // Before the contact, both springs give the same torque.
    let after_contact = || profile.points.iter().filter(|point| point.net_n_m.is_none());
    let largest = |torque: fn(&ProfilePoint) -> f64| after_contact().map(torque).fold(f64::NEG_INFINITY, f64::max);
    let [trajectory, springs, spring_types] = plot::sizing("example", profile);
    section
        .with_table(
            "Smallest spring torque by position of the spring, finger of Fig. 3.2 (base 12 mm, l21 18.9 mm, φ22 100°, r_l 0.5).",
            &["spring at", "k_s, N·mm"],
            positions.map(|(name, torque_n_m)| row(name, torque_n_m)).collect(),
        )
        .with_table(
            "Largest closing torque of the motor after the proximal contact by type of spring, same finger. The torsional spring is \
             deflected by 90° when the finger is straight, which the thesis does not specify.",
            &["spring", "largest torque, N·mm"],
            vec![
                row("constant", largest(|point| point.constant_n_m)),
                row("torsional", largest(|point| point.torsional_n_m)),
            ],
        )
        .with_figure("trajectory.svg", "Test trajectory (Fig. 3.1).", trajectory)
        .with_figure(
            "springs.svg",
            "Required spring torque during the swing by position of the spring (Fig. 3.2).",
            springs,
        )
        .with_figure(
            "spring-types.svg",
            "Motor torque with a constant and a torsional spring (Fig. 3.3).",
            spring_types,
        )
}

/// Section on lengths, masses and trajectories (Figs. 4.1, 4.2).
fn all_designs(found: &Reproduction) -> Report {
    let section = Report::section("The 192 designs").with_paragraph(
        "Four bases, four lengths of l21 within the range that each base allows, four angles φ22 and three ratios l22/l11. \
         Everything else follows from them.",
    );
    found.section_table(section, "Lengths, masses and trajectories.", &["designs"]).with_figure(
        "designs.svg",
        "Varied quantities (blue, Fig. 4.1) and derived quantities (green, Fig. 4.2) by design.",
        found.simulations.pictures[4].clone(),
    )
}

/// Section on static stability and form closure (thesis §4.2.1, Figs. 4.3, A.16, A.17, A.24).
fn statics(found: &Reproduction) -> Report {
    let section = Report::section("Statics and form closure").with_paragraph(
        "A grasp is statically stable if no contact force is tensile (thesis, eq. 2.32), and form-closed if the object and the \
         fingers cannot move with the motors blocked (eqs. 1.15–1.19).",
    );
    let row = |sizing: &OtherSizing| {
        let counts = [sizing.statically_stable_mu_0, sizing.statically_stable_mu_0_8]
            .map(|count| Cell::new(count_and_share(count, found.simulations.designs())));
        [vec![Cell::prose(sizing.torques)], counts.to_vec()].concat()
    };
    let section = found.section_table(section, "Static stability and form closure.", &["statics"]);
    let table = section.with_table(
        "Influence of sizing: statically stable designs with other torques. The printed ratios are the ratios of the thesis's \
         torques for design 95 to ours.",
        &["torques", "μ_s = 0", "μ_s = 0.8"],
        found.other_sizings.iter().map(row).collect(),
    );
    let caption = "Static stability, designs sorted by each variable (Figs. 4.3, A.16, A.17).";
    table.with_figure("static.svg", caption, found.simulations.pictures[2].clone())
}

/// Section on design 95 and its CAD model (thesis §4.3, §4.4, Table 4.2, Fig. 4.8).
fn closings(found: &Reproduction) -> Report {
    let section = Report::section("Design 95 and its CAD model").with_paragraph(
        "The chosen design closes with the torques printed in the thesis (480 and 132.6 N·mm) and μ_s = 0.8, once with the \
         masses of its planar outlines and once with those of the final parts.",
    );
    let section = found.section_table(section, "Design 95 and the final parts.", &["design 95", "CAD model"]);
    let both = [&found.chosen, &found.cad];
    let row = |name: &str, digits: usize, value: &dyn Fn(&Closing) -> Option<f64>| {
        let text = |closing| value(closing).map_or("–".to_string(), |value| format_number(value, digits));
        cells([name.to_string(), text(both[0]), text(both[1])])
    };
    let first_ms = |closing: &Closing, contact| closing.outcome.finger_contact(contact).first_s.map(|s| s * 1e3);
    let final_n = |closing: &Closing, contact| Some(closing.outcome.last.finger_contact(contact).normal_n);
    section
        .with_table(
            "Both closings.",
            &["", both[0].name, both[1].name],
            vec![
                row("mass, g", 4, &|closing| Some(closing.mass_kg * 1e3)),
                row("proximal contact, ms", 5, &|closing| first_ms(closing, FingerContact::Proximal)),
                row("distal contact, ms", 5, &|closing| first_ms(closing, FingerContact::Distal)),
                row("time to stability, ms", 5, &|closing| closing.criteria.tts_s.map(|s| s * 1e3)),
                row("rebound, %", 4, &|closing| closing.criteria.rebound_percent),
                row("F21 at the end, N", 4, &|closing| final_n(closing, FingerContact::Proximal)),
                row("F22 at the end, N", 4, &|closing| final_n(closing, FingerContact::Distal)),
                row("PFP, N", 4, &|closing| Some(closing.pfp_n)),
            ],
        )
        .with_figure(
            "closing.svg",
            "Angles of both closings (Fig. 4.8): the lighter finger is faster.",
            designs::plot_closings("Design 95 and its CAD model", &both),
        )
}

/// Section on the errata, from a Markdown table.
fn errata(markdown: &str) -> Report {
    let cells = |line: &str| -> Vec<String> {
        let text = line.trim().trim_start_matches('|').trim_end_matches('|').replace("\\|", "\u{0}");
        text.split('|').map(|cell| cell.trim().replace('\u{0}', "|").replace("**", "").replace('`', "")).collect()
    };
    let mut rows = markdown.lines().filter(|line| line.starts_with('|')).map(cells);
    let header = rows.next().unwrap_or_default();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let row = |row: Vec<String>| {
        let cell = |(index, text)| if index == 0 { Cell::new(text) } else { Cell::prose(text) };
        row.into_iter().enumerate().map(cell).collect()
    };
    Report::section("Errata").with_table(
        "Errors of the thesis and their corrections in phalanx; T marks errata with a test.",
        &header,
        // The line after the header is the Markdown rule.
        rows.skip(1).map(row).collect(),
    )
}

/// Tables of all comparisons, the near-chaotic runs, and the number of values outside their tolerance.
impl ToReport for Reproduction {
    fn report(&self) -> Report {
        let mut text = Report::default();
        for comparisons in self.comparisons.chunk_by(|a, b| a.figure.section == b.figure.section) {
            let header = row([&comparisons[0].figure.section, "thesis", "ours", "expected", ""]);
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
        format!("  {}", comparison.figure.quantity),
        comparison.thesis_text(),
        comparison.ours_text(),
        comparison.expected_text(),
        if comparison.verdict == Verdict::Outside { "outside" } else { "" }.to_string(),
    ]
}

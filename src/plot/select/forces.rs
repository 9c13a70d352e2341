//! Final forces and palm force by design (Figs. 4.5, A.20–A.23).

use super::criteria::designs;
use crate::plot::axis::Axis;
use crate::plot::canvas::{
    Area, Entry, FOOT, HEAD as TITLE, Mark, THIN, WIDTH, frame, legend_across, level, picture, points, words_from,
};
use crate::plot::theme::{AMBER, BLUE, Colour, GREEN, INK, ORANGE, PURPLE, SOFT};
use crate::study::select::{Candidate, Selection};
use crate::wording::condition_name;

const KEY: f64 = 34.0;
const HEAD: f64 = 26.0;
const PANEL: f64 = 170.0;
/// One for each condition, as far as they go.
const COLOURS: [Colour; 5] = [BLUE, ORANGE, GREEN, PURPLE, AMBER];

/// The figure of a panel.
type Figure = fn(&Candidate) -> Option<f64>;

/// The picture: F21, F22 and PFP of the runs that end at rest on the object. Others end in a rebound, where a force is that
/// of the moment.
pub fn selection_forces(title: &str, selection: &Selection) -> String {
    let panels: [(&str, Figure); 3] = [
        ("F21, normal force of the proximal phalanx on the object, N", |run| run.f21_n),
        ("F22, normal force of the distal phalanx on the object, N", |run| run.f22_n),
        ("PFP, force of the object on the palm, by each finger, N", |run| run.pfp_n),
    ];
    let designs = designs(selection);
    let (first, last) = (designs.first().copied().unwrap_or(0), designs.last().copied().unwrap_or(1));
    let x = Axis::over("design", first as f64 - 1.0, last as f64 + 1.0);
    // The first condition shows around the others where they agree.
    let marks = [Mark::Circle, Mark::SmallDot];
    let many = selection.runs.len() > 4000;
    let title = format!("{title}: final forces of the runs that come to rest");
    picture(&title, TITLE + KEY + 3.0 * (HEAD + PANEL) + FOOT, |svg| {
        let mut entries: Vec<Entry> = Vec::new();
        for (index, condition) in selection.conditions.iter().enumerate().take(COLOURS.len()) {
            entries.push(Entry::new(marks[index.min(1)], COLOURS[index], &condition_name(condition)));
        }
        if selection.conditions.len() > COLOURS.len() {
            entries.push(Entry::new(Mark::SmallDot, SOFT, "others"));
        }
        entries.push(Entry::new(Mark::Ring, INK, "selected"));
        legend_across(svg, &entries);
        for (place, (name, figure)) in panels.into_iter().enumerate() {
            let foot = place + 1 == panels.len();
            let top = KEY + (HEAD + PANEL) * place as f64 + HEAD;
            words_from(svg, name, [86.0, top - 0.5 * HEAD + 2.0], 15.0, INK);
            let shown = |run: &&Candidate| run.tts_s.is_some();
            let y = Axis::linear("", selection.runs.iter().filter(shown).filter_map(figure).chain([0.0]));
            let area = Area { left: 0.0, top, width: WIDTH, height: PANEL + if foot { FOOT } else { 0.0 } };
            let on = frame(svg, area, &x, &y, foot);
            level(svg, &on, 0.0, THIN, SOFT);
            let at = |run: &Candidate| Some((run.design as f64, figure(run)?));
            for condition in 0..selection.conditions.len() {
                let mark = if many { Mark::Speck } else { marks[condition.min(1)] };
                let colour = COLOURS.get(condition).copied().unwrap_or(SOFT);
                let of = selection.runs.iter().filter(shown).filter(|run| run.condition == condition);
                points(svg, &on, of.filter_map(at), mark, colour);
            }
            let best = selection.ranking.iter().take(WIDTH as usize).map(|ranked| &selection.runs[ranked.run_index]);
            points(svg, &on, best.filter(shown).filter_map(at), Mark::Ring, INK);
        }
    })
}

//! Final forces and palm force by design (Figs. 4.5, A.20–A.23).

use plotters::style::RGBColor;

use super::criteria::designs;
use crate::plot::axis::Axis;
use crate::plot::canvas::{
    AMBER, BLACK, BLUE, DrawError, Entry, GREEN, GREY, Mark, ORANGE, PURPLE, WIDTH, frame, legend_across, line,
    picture, point, titled, words_from,
};
use crate::study::select::{Candidate, Selection};
use crate::wording::condition_name;

const TITLE: u32 = 40;
const KEY: u32 = 34;
const HEAD: u32 = 26;
const PANEL: u32 = 170;
const FOOT: u32 = 44;
/// One for each condition, as far as they go.
const COLOURS: [RGBColor; 5] = [BLUE, ORANGE, GREEN, PURPLE, AMBER];

/// The figure of a panel.
type Figure = fn(&Candidate) -> Option<f64>;

/// The picture: F21, F22 and PFP of the runs that end at rest on the object. Others end in a rebound, where a force is that
/// of the moment.
pub fn selection_forces(title: &str, selection: &Selection) -> Result<String, DrawError> {
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
    picture(TITLE + KEY + 3 * (HEAD + PANEL) + FOOT, |area| {
        let rest = titled(area, &format!("{title}: final forces of the runs that come to rest"))?;
        let (key, mut rest) = rest.split_vertically(KEY);
        let mut entries: Vec<Entry> = Vec::new();
        for (index, condition) in selection.conditions.iter().enumerate().take(COLOURS.len()) {
            entries.push(Entry::new(marks[index.min(1)], COLOURS[index], &condition_name(condition)));
        }
        if selection.conditions.len() > COLOURS.len() {
            entries.push(Entry::new(Mark::SmallDot, GREY, "others"));
        }
        entries.push(Entry::new(Mark::Ring, BLACK, "selected"));
        legend_across(&key, &entries)?;
        for (place, (name, figure)) in panels.into_iter().enumerate() {
            let foot = place + 1 == panels.len();
            let (of, below) = rest.split_vertically(HEAD + PANEL + if foot { FOOT } else { 0 });
            rest = below;
            let (head, body) = of.split_vertically(HEAD);
            words_from(&head, name, (86, HEAD as i32 / 2 + 2), 15, BLACK)?;
            let shown = |run: &&Candidate| run.tts_s.is_some();
            let values = selection.runs.iter().filter(shown).filter_map(figure).chain([0.0]);
            let y = Axis::linear("", values);
            let mut chart = frame(&body, &x, &y, foot)?;
            line(&mut chart, vec![(x.from, 0.0), (x.to, 0.0)], Mark::Line { width: 1 }, GREY)?;
            for run in selection.runs.iter().filter(shown) {
                if let Some(value) = figure(run) {
                    let mark = if many { Mark::Speck } else { marks[run.condition.min(1)] };
                    let colour = COLOURS.get(run.condition).copied().unwrap_or(GREY);
                    point(&mut chart, (run.design as f64, value), mark, colour)?;
                }
            }
            for ranked in selection.ranking.iter().take(WIDTH as usize) {
                let run = &selection.runs[ranked.run_index];
                if let (Some(value), true) = (figure(run), run.tts_s.is_some()) {
                    point(&mut chart, (run.design as f64, value), Mark::Ring, BLACK)?;
                }
            }
        }
        Ok(())
    })
}

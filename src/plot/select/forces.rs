//! Final forces and palm force by design (Figs. 4.5, A.20–A.23).

use plotters::style::RGBColor;

use super::criteria::designs;
use crate::plot::axis::Axis;
use crate::plot::canvas::{
    AMBER, BLACK, BLUE, DrawError, Entry, GREEN, GREY, Mark, ORANGE, PURPLE, WIDTH, frame, legend_across, line,
    picture, point, titled, words_from,
};
use crate::report::condition_name;
use crate::study::select::{Candidate, Selection};

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
        ("F21, normal force of the proximal phalanx, N", |run| run.f21_n),
        ("F22, normal force of the tip, N", |run| run.f22_n),
        ("PFP, force on the palm, N", |run| run.pfp_n),
    ];
    let designs = designs(selection);
    let (first, last) = (designs.first().copied().unwrap_or(0), designs.last().copied().unwrap_or(1));
    let x = Axis::over("design", first as f64 - 1.0, last as f64 + 1.0);
    let many = selection.runs.len() > 4000;
    picture(TITLE + KEY + 3 * (HEAD + PANEL) + FOOT, |area| {
        let rest = titled(area, &format!("{title}: final forces of the runs that come to rest"))?;
        let (key, mut rest) = rest.split_vertically(KEY);
        let entries = selection.conditions.iter().zip(COLOURS);
        let mut entries: Vec<Entry> =
            entries.map(|(condition, colour)| Entry::new(Mark::Dot, colour, &condition_name(condition))).collect();
        entries.push(Entry::new(Mark::SmallRing, BLACK, "selected"));
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
                    // The first condition shows around the others where they agree.
                    let mark = match (many, run.condition) {
                        (true, _) => Mark::Speck,
                        (false, 0) => Mark::Dot,
                        (false, _) => Mark::SmallDot,
                    };
                    point(&mut chart, (run.design as f64, value), mark, COLOURS[run.condition % COLOURS.len()])?;
                }
            }
            for ranked in selection.ranking.iter().take(WIDTH as usize) {
                let run = &selection.runs[ranked.run_index];
                if let (Some(value), true) = (figure(run), run.tts_s.is_some()) {
                    point(&mut chart, (run.design as f64, value), Mark::SmallRing, BLACK)?;
                }
            }
        }
        Ok(())
    })
}

//! A scene of discs.

use super::super::check::Checker;
use super::super::entry::Section;
use super::super::error::Problem;
use super::super::raw_bodies::RawBodiesScene;
use super::super::table::half_plane::Ground;
use super::super::table::keys::Keys;
use super::super::table::top::{BODIES_GRAVITY_M_S2, BodiesKeys};
use super::super::table::{Table, read};
use super::super::{Construction, DiscMotion, Engine, HalfPlane, Integrator, Scene, System};
use super::disc::{Placed, disc, judge_starts};
use super::{contact, heading, run};
use crate::limits::MOST_DISCS;

/// Resolves a scene of discs; `file_name` gives its default name.
pub fn bodies(raw: &RawBodiesScene, mut c: Checker<'_>, file_name: &str) -> Result<Scene, Vec<Problem>> {
    let BodiesKeys { heading: said } = read(&mut c, "", &raw.keys, BodiesKeys::usual());
    let (name, duration) = heading(&mut c, &raw.keys, &said, file_name);
    let gravity_m_s2 = said.gravity_m_s2;
    let discs = discs(&mut c, raw, gravity_m_s2);
    let half_plane = raw.half_plane.is_given().then(|| read(&mut c, "half_plane", &raw.half_plane, Ground::usual()));
    let contact = contact::contact(&mut c, &raw.contact);
    let integrator = read(&mut c, "integrator", &raw.integrator, Integrator::usual());
    let mu_static = contact.map(|law| law.friction.map_or(0.0, |law| law.mu_static));
    let engine = run::engine(&mut c, &raw.engine, mu_static);
    refuse_joints(&mut c, &raw.engine, engine);
    let bounds = run::bounds(&mut c, &raw.validate, duration);
    let log = run::log(&mut c, &raw.log, duration);
    // Starts are judged only if everything they stand on is sound.
    if let (Some(discs), true) = (&discs, c.is_clean()) {
        judge_starts(&mut c, discs, half_plane);
    }
    match (discs, contact, duration) {
        (Some(discs), Some(contact), Some(duration_s)) if c.is_clean() => Ok(Scene {
            name,
            description: said.description,
            source: c.text.to_string(),
            system: System {
                fingers: Vec::new(),
                palm_width_m: 0.0,
                differential: None,
                discs: discs.into_iter().map(|placed| placed.disc).collect(),
                between_discs: Some(contact),
                palm: half_plane.map(|Ground { level_m }| HalfPlane { level_m, contact: Some(contact) }),
                table: None,
                palm_motion: None,
                gravity_m_s2,
            },
            duration_s,
            integrator,
            engine,
            bounds,
            log,
        }),
        _ => Err(c.into_problems()),
    }
}

/// All discs in the order of their names; `None` where something is wrong with one, or with all.
fn discs(c: &mut Checker<'_>, raw: &RawBodiesScene, gravity_m_s2: [f64; 2]) -> Option<Vec<Placed>> {
    let named = &raw.discs.0;
    if named.is_empty() {
        let help = "a scene of discs needs one that moves: [discs.hammer] with radius, centre and mass";
        c.missing("[discs.NAME]", &raw.discs, help);
        return None;
    }
    if named.len() > MOST_DISCS {
        let count = named.len();
        c.push(
            raw.discs.span.clone(),
            format!("there are {count} discs, but at most {MOST_DISCS} are simulated: any two of them may touch"),
            "",
            format!("leave {} of them out", count - MOST_DISCS),
        );
        return None;
    }
    let all: Vec<Option<Placed>> = named.iter().map(|(name, raw)| disc(c, name, raw)).collect();
    let all: Vec<Placed> = all.into_iter().collect::<Option<_>>()?;
    if !all.iter().any(|placed| placed.disc.motion.moves()) {
        c.push(
            raw.discs.span.clone(),
            "every disc is fixed: nothing would happen",
            "",
            "let one of them move: motion = \"free\" with mass, or motion = \"driven\" with velocity",
        );
    }
    let free = |placed: &Placed| matches!(placed.disc.motion, DiscMotion::Free { .. });
    if gravity_m_s2 != BODIES_GRAVITY_M_S2 && !all.iter().any(free) {
        c.unused_at("gravity", raw.keys.span("gravity"), "without a disc of motion = \"free\"");
    }
    Some(all)
}

/// The other construction is one of joints.
fn refuse_joints(c: &mut Checker<'_>, raw: &Section<Keys<Engine>>, engine: Engine) {
    if engine.construction == Construction::Reduced {
        c.push(
            raw.span("construction"),
            "`engine.construction` is \"reduced\", but a scene of discs has no joints to make coordinates of",
            "no joints",
            "leave it out: every disc moves freely in the engine",
        );
    }
}

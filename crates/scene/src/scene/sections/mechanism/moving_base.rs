//! The body of a mechanism that moves, vibrates or follows a path.

use super::names::{GROUND, find};
use crate::mechanism::{Mechanism, PrescribedMotion};
use crate::palm_motion::PalmMotion;
use crate::scene::section_input::SectionInput;
use crate::scene::sections::motion::{MOTION_SECTIONS, palm_motion};
use crate::statics::{GraspKeys, NoGrasp, default_base, default_object, move_ground};

/// Gives the moving body its motion; without motion, nothing changes. Keys of the grasp follow the outlines of the ground.
pub(super) fn move_base(
    root: &SectionInput<'_>,
    mechanism: &mut Mechanism,
    keys: &mut Option<GraspKeys>,
) -> Option<()> {
    let Some(motion) = palm_motion(root, false) else { return Some(()) };
    let first = MOTION_SECTIONS.into_iter().find(|section| root.has(section)).unwrap_or_default();
    let body = match named_body(root, mechanism)? {
        Some((section, body)) => {
            check_body(&section, "body", mechanism, body, keys.as_ref())?;
            body
        }
        None => {
            let base = base(&root.subsection(first), mechanism, keys.as_ref())?;
            check_body(root, first, mechanism, base, keys.as_ref())?;
            base
        }
    };
    match body {
        Some(body) => {
            let initial_pose = mechanism.bodies[body].pose;
            mechanism.bodies[body].motion = Some(PrescribedMotion::Palm(PalmMotion { initial_pose, ..motion }));
        }
        None => move_ground(mechanism, keys, motion),
    }
    Some(())
}

/// The body that the sections name, with the first section that names it; `None` is the ground. One body can move.
fn named_body<'a>(root: &SectionInput<'a>, mechanism: &Mechanism) -> Option<Option<(SectionInput<'a>, Option<usize>)>> {
    let known: Vec<&str> = [GROUND].into_iter().chain(mechanism.bodies.iter().map(|body| body.name.as_str())).collect();
    let [moves, vibrations, path] = MOTION_SECTIONS.map(|section| root.subsection(section));
    let named = moves.subsections().into_iter().chain(vibrations.subsections()).map(|(_, section)| section);
    let mut found: Option<(SectionInput<'_>, Option<usize>)> = None;
    for section in named.chain([path]) {
        let Some(name) = section.text("body") else { continue };
        let body = find(&section, "body", name, "body", &known)?.checked_sub(1);
        match &found {
            Some((first, other)) if *other != body => {
                let message = format!(
                    "`{}` is `{name}`, but `{}` is `{}`: one body can move",
                    section.path("body"),
                    first.path("body"),
                    mechanism.body_name(*other)
                );
                let help = "give all sections of [moves], [vibrations] and [path] the same body; other bodies are moved by \
                            actuators";
                return section.refuse("body", message, "another body", help);
            }
            Some(_) => {}
            None => found = Some((section, body)),
        }
    }
    Some(found)
}

/// The base of the grasp; the ground without a grasp.
fn base(section: &SectionInput<'_>, mechanism: &Mechanism, keys: Option<&GraspKeys>) -> Option<Option<usize>> {
    if let Some(base) = keys.and_then(|keys| keys.base) {
        return Some(base);
    }
    let object = keys.and_then(|keys| keys.object).map_or_else(|| default_object(mechanism), Ok);
    match object {
        Ok(object) => Some(default_base(mechanism, object, keys.map_or(&[], |keys| &keys.surroundings))),
        Err(error @ NoGrasp::SeveralObjects(_)) => {
            let message = format!("the body that moves is the base of the grasp, but {error}");
            let help = "do so, or name the body that moves: body = \"ground\"";
            section.refuse("", message, "no known base", help)
        }
        Err(_) => Some(None),
    }
}

/// Reports a body that cannot move by prescription, at a key.
fn check_body(
    section: &SectionInput<'_>,
    key: &str,
    mechanism: &Mechanism,
    body: Option<usize>,
    keys: Option<&GraspKeys>,
) -> Option<()> {
    let Some(body) = body else { return Some(()) };
    let name = &mechanism.bodies[body].name;
    let is_named = section.has("body");
    let subject =
        if is_named { format!("`{}` is `{name}`", section.path(key)) } else { format!("the base is `{name}`") };
    let ground = "write body = \"ground\" to move the ground with all bodies on it";
    let object = keys.and_then(|keys| keys.object).or_else(|| default_object(mechanism).ok());
    if object == Some(body) {
        let message = format!("{subject}, the grasped body, which moves by forces");
        return section.refuse(key, message, "the object", format!("name the base of the hand, or {ground}"));
    }
    if mechanism.bodies[body].rate != [0.0; 3] {
        let message = format!("{subject}, which starts with a velocity, but a prescribed motion starts at rest");
        let help = format!("remove `velocity` and `spin` from [bodies.{name}.start]");
        return section.refuse(key, message, "starts at rest", help);
    }
    let joints = joints_to_ground(mechanism, body);
    if joints.is_empty() {
        return Some(());
    }
    let names: Vec<String> = joints.iter().map(|joint| format!("`{}`", mechanism.joints[*joint].name)).collect();
    let (joint, connect) = if names.len() == 1 { ("the joint", "connects") } else { ("the joints", "connect") };
    let message = format!(
        "{subject}, which {joint} {} {connect} with the ground: a prescribed motion leaves no freedom to a joint",
        names.join(" and ")
    );
    let help = format!("{ground}; or move `{name}` by an actuator of its joints; or remove these joints");
    section.refuse(key, message, "connected with the ground", help)
}

/// Joints on the ground that connect a body with it, directly or through others.
fn joints_to_ground(mechanism: &Mechanism, body: usize) -> Vec<usize> {
    let mut reached = vec![false; mechanism.bodies.len()];
    let mut next = vec![body];
    let mut found = Vec::new();
    while let Some(body) = next.pop() {
        if std::mem::replace(&mut reached[body], true) {
            continue;
        }
        for (index, joint) in mechanism.joints.iter().enumerate() {
            match joint.bodies {
                [Some(a), Some(b)] if a == body || b == body => next.push(if a == body { b } else { a }),
                [None, other] | [other, None] if other == Some(body) => found.push(index),
                _ => {}
            }
        }
    }
    found.sort_unstable();
    found
}

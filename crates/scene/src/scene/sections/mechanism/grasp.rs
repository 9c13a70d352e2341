//! Object, base and surroundings of a grasp, and its release.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use super::contact::{matching_outlines, outline_id};
use super::names::{GROUND, find};
use crate::mechanism::Mechanism;
use crate::scene::quantity::{Positive, Time};
use crate::scene::section_input::SectionInput;
use crate::statics::{GraspKeys, carries, default_object};

/// The grasp that is judged. With this section, a run ends when the object leaves the hand. Without it, a run is judged
/// with the defaults and does not end early.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct GraspSettings {
    /// The body that is grasped. Default: the body called `object`, or else the only body that has contacts and no
    /// joints.
    #[schemars(extend("minLength" = 1))]
    pub object: Option<String>,
    /// The palm: the body relative to which travel and slip are measured, and which a load accelerates. Default: the
    /// last body that carries all bodies of the hand that can touch the object and from which two joints lead on to
    /// them, or else `ground`.
    #[schemars(extend("minLength" = 1))]
    pub base: Option<String>,
    /// Bodies or outlines that do not belong to the hand, written as in `between` of a contact: surroundings =
    /// ["ground.table"]. Bodies without joints never belong to it. Outlines of the ground belong to it only if the base
    /// is the ground.
    #[schemars(extend("default" = []))]
    pub surroundings: Vec<String>,
    /// Time at which the hand releases the object. The fate of the grasp is that at this time. Default: the end.
    pub release: Option<Positive<Time>>,
}

/// Resolves `[grasp]`. The outer `None` means that a part is invalid.
pub fn grasp(section: &SectionInput<'_>, mechanism: &Mechanism) -> Option<Option<GraspKeys>> {
    if !section.is_present() {
        return Some(None);
    }
    let GraspSettings { object, base, surroundings, release } = section.read();
    let bodies: Vec<&str> = mechanism.bodies.iter().map(|body| body.name.as_str()).collect();
    let object = object.map(|name| {
        let found = find(section, "object", &name, "body", &bodies)?;
        if mechanism.bodies[found].motion.is_some() {
            let message = format!("`{}` has a prescribed motion, which no force affects", section.path("object"));
            let help = "name a body that moves by forces";
            return section.refuse("object", message, "cannot be grasped", help);
        }
        Some(found)
    });
    let base = base.map(|name| {
        let known: Vec<&str> = [GROUND].into_iter().chain(bodies.iter().copied()).collect();
        find(section, "base", &name, "body", &known).map(|found| found.checked_sub(1))
    });
    if let (Some(Some(object)), Some(Some(Some(base)))) = (object, base)
        && object == base
    {
        let message = format!("`{}` is the grasped body", section.path("base"));
        return section.refuse("base", message, "the object", "name a body of the hand, or `ground`");
    }
    let surroundings = surroundings.iter().enumerate().map(|(index, pattern)| {
        let found = matching_outlines(mechanism, pattern);
        if found.is_empty() {
            // The message of an unknown name.
            outline_id(section, "surroundings", index, pattern, mechanism)?;
        }
        Some(found)
    });
    let surroundings: Vec<_> = surroundings.collect();
    let mut surroundings = surroundings.into_iter().collect::<Option<Vec<_>>>()?.concat();
    surroundings.sort_by_key(|id| (id.body.map_or(usize::MAX, |body| body), id.outline));
    surroundings.dedup();
    let (object, base) = (all_or(object)?, all_or(base)?);
    // Without an object, there is no grasp and thus no wrong base.
    if let (Some(Some(base)), Some(grasped)) = (base, object.or_else(|| default_object(mechanism).ok())) {
        let carries = |base: usize| carries(mechanism, (grasped, base), &surroundings);
        if !carries(base) {
            let message = format!(
                "`{}` is `{}`, which is not the base of the hand: joints connect other bodies that can touch `{}` with the \
                 ground without it",
                section.path("base"),
                bodies[base],
                bodies[grasped]
            );
            let allowed = (0..bodies.len()).filter(|body| carries(*body)).map(|body| format!("`{}`", bodies[body]));
            let allowed: Vec<String> = allowed.chain([format!("`{GROUND}`")]).collect();
            let help = format!("name a body that carries all of them: {}", allowed.join(", "));
            return section.refuse("base", message, "does not carry the hand", help);
        }
    }
    Some(Some(GraspKeys { object, base, surroundings, release_s: release.map(|time| *time) }))
}

/// A name that is not given is valid; one that is given must be found.
fn all_or<T>(found: Option<Option<T>>) -> Option<Option<T>> {
    match found {
        None => Some(None),
        Some(found) => found.map(Some),
    }
}

/// Settings that describe a grasp.
pub fn grasp_settings(keys: &GraspKeys, mechanism: &Mechanism) -> Value {
    json!({
        "object": keys.object.map(|body| mechanism.body_name(Some(body))),
        "base": keys.base.map(|body| mechanism.body_name(body)),
        "surroundings": keys.surroundings.iter().map(|id| mechanism.outline_name(*id)).collect::<Value>(),
        "release": keys.release_s,
    })
}

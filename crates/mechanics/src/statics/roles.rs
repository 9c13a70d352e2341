//! Roles of the bodies of a mechanism in a grasp: the object, its pairs of outlines with the hand and the surroundings, the
//! base, which is accelerated, and the bodies that are balanced.
//!
//! Bodies are connected by joints, couplings, springs, cables, actuators, and contacts that can push. The ground, the base
//! and what carries the base do not move relative to the base. The object, the bodies of the hand that can touch it, and
//! all bodies that are connected with these otherwise have to be at rest. Other bodies have no effect on the grasp.

use crate::mechanism::{
    Body, ContactPair, JointCombination, Mechanism, OutlineId, OutlinePair, OutlineShape, SpringKind,
};
use crate::numeric::elementary::hypot;
use crate::numeric::plane::sub;
use crate::palm_motion::PalmMotion;

/// Grasp settings of a scene. Missing settings have defaults.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GraspKeys {
    pub object: Option<usize>,
    /// Base of the hand; `Some(None)` is the ground.
    pub base: Option<Option<usize>>,
    /// Outlines that are not part of the hand.
    pub surroundings: Vec<OutlineId>,
    /// Time at which the hand releases the object.
    pub release_s: Option<f64>,
}

/// Roles in the grasp of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct GraspRoles {
    pub object: usize,
    /// The body relative to which the travel of the object is measured; `None` is the ground.
    pub base: Option<usize>,
    /// Largest distance from the centre of mass of the object to its outlines, m.
    pub radius_m: f64,
    /// Pairs of the object with the hand and the surroundings.
    pub pairs: Vec<GraspPair>,
    /// Outlines listed as surroundings.
    pub surroundings: Vec<OutlineId>,
    /// Outlines of the ground that count as part of the hand although no key says so.
    pub assumed_hand: Vec<OutlineId>,
}

/// An outline of the object and one of another body, with all their contact points.
#[derive(Clone, Debug, PartialEq)]
pub struct GraspPair {
    /// Name such as `left.pad/object.skin`.
    pub name: String,
    /// Outline of the other body.
    pub other: OutlineId,
    /// Whether the other outline belongs to the hand; otherwise it belongs to the surroundings.
    pub is_hand: bool,
    /// Indices of the contact points, in the order of [`Mechanism::point_contacts`].
    pub points: Vec<usize>,
}

/// Reason why a scene has no grasp.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoGrasp {
    /// No joints, no body without joints that moves by forces, or no contact pair of the object with the hand.
    #[error(
        "there is no contact pair of a hand with a body that it could grasp: connect the bodies of the hand by joints, and list \
         a pair of one of their outlines with the object in [[contacts]]"
    )]
    Nothing,
    #[error("{} have contacts and no joints: name the one that is grasped with `object` in [grasp]", .0.join(" and "))]
    SeveralObjects(Vec<String>),
    #[error(
        "the outline `{0}` of the object is a half plane, which has no extent: give it another shape, such as a box"
    )]
    HalfPlane(String),
}

/// Returns the roles in the grasp of a scene.
///
/// # Errors
/// Returns the reason why there is no grasp.
pub fn grasp_roles(mechanism: &Mechanism, keys: &GraspKeys) -> std::result::Result<GraspRoles, NoGrasp> {
    if mechanism.joints.is_empty() {
        return Err(NoGrasp::Nothing);
    }
    let object = keys.object.map_or_else(|| default_object(mechanism), Ok)?;
    let base = keys.base.unwrap_or_else(|| default_base(mechanism, object, &keys.surroundings));
    let is_hand = |id: OutlineId| {
        let has_role = match id.body {
            body if body == mechanism.frame() => base == body,
            None => false,
            body => mechanism.has_joint(body),
        };
        has_role && !keys.surroundings.contains(&id)
    };
    let of_object =
        mechanism.outline_pairs(Some(object)).into_iter().filter(|pair| pair.outlines[1].body == Some(object));
    let pairs: Vec<GraspPair> = of_object
        .map(|OutlinePair { name, outlines: [other, _], points }| GraspPair {
            name,
            other,
            is_hand: is_hand(other),
            points,
        })
        .collect();
    if !pairs.iter().any(|pair| pair.is_hand) {
        return Err(NoGrasp::Nothing);
    }
    let outlines = &mechanism.bodies[object].outlines;
    if let Some(outline) = outlines.iter().position(|outline| matches!(outline.shape, OutlineShape::HalfPlane { .. })) {
        let id = OutlineId { body: Some(object), outline };
        return Err(NoGrasp::HalfPlane(mechanism.outline_name(id)));
    }
    let is_of_frame = |pair: &&GraspPair| pair.is_hand && pair.other.body == mechanism.frame();
    let of_ground = pairs.iter().filter(is_of_frame).map(|pair| pair.other);
    let mut assumed_hand: Vec<OutlineId> = of_ground.filter(|_| keys.base.is_none()).collect();
    assumed_hand.sort_by_key(|id| id.outline);
    assumed_hand.dedup();
    let (radius_m, surroundings) = (radius_m(&mechanism.bodies[object]), keys.surroundings.clone());
    Ok(GraspRoles { object, base, radius_m, pairs, surroundings, assumed_hand })
}

/// Returns the body that a hand grasps: the body called `object`, or the only body with contacts that has no joints and
/// moves by forces.
///
/// # Errors
/// Returns an error if there is no such body, or several.
pub fn default_object(mechanism: &Mechanism) -> std::result::Result<usize, NoGrasp> {
    let bodies = &mechanism.bodies;
    let moves = |body: &usize| bodies[*body].motion.is_none();
    if let Some(called) = (0..bodies.len()).filter(moves).find(|body| bodies[*body].name == "object") {
        return Ok(called);
    }
    let touches =
        |body: &usize| mechanism.contacts.iter().any(|pair| [pair.points.body, pair.face.body].contains(&Some(*body)));
    let free = (0..bodies.len()).filter(moves).filter(|body| !mechanism.has_joint(Some(*body)));
    match free.filter(touches).collect::<Vec<_>>()[..] {
        [] => Err(NoGrasp::Nothing),
        [object] => Ok(object),
        ref several => {
            Err(NoGrasp::SeveralObjects(several.iter().map(|body| format!("`{}`", bodies[*body].name)).collect()))
        }
    }
}

/// Largest distance from the centre of mass of a body to its outlines, m; infinite with a half plane.
pub fn radius_m(body: &Body) -> f64 {
    let reach = |shape: &OutlineShape| match shape {
        OutlineShape::HalfPlane { .. } => f64::INFINITY,
        OutlineShape::Ellipse { center_m, semi_axes_m: [a, b], .. } => {
            let [x, y] = sub(*center_m, body.com_m);
            hypot(x, y) + a.max(*b)
        }
        other => {
            let distances = other.vertices_m().into_iter().map(|vertex| {
                let [x, y] = sub(vertex, body.com_m);
                hypot(x, y)
            });
            distances.fold(0.0, f64::max) + other.radius_m()
        }
    };
    body.outlines.iter().map(|outline| reach(&outline.shape)).fold(f64::MIN_POSITIVE, f64::max)
}

/// Roles of all bodies in the grasp of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Roles {
    /// The body that is accelerated; `None` is the ground.
    pub base: Option<usize>,
    /// For each body, whether it moves with the base: the base itself, bodies that carry it, and bodies with a
    /// prescribed motion.
    pub moves_with_base: Vec<bool>,
    /// For each body, whether forces have to balance it.
    pub is_balanced: Vec<bool>,
}

/// Returns the roles of all bodies in the grasp of `object`. `surroundings` are outlines that do not belong to the
/// hand; `contacts` are the pairs of bodies of the contacts that can push.
pub fn roles(
    mechanism: &Mechanism,
    (object, base): (usize, Option<usize>),
    surroundings: &[OutlineId],
    contacts: impl Iterator<Item = [Option<usize>; 2]>,
) -> Roles {
    let graph = Graph { mechanism, object, surroundings };
    let mut moves_with_base: Vec<bool> = mechanism.bodies.iter().map(|body| body.motion.is_some()).collect();
    if let Some(base) = base.filter(|base| mechanism.bodies[*base].motion.is_none()) {
        let carriers = graph.ground_side(base);
        moves_with_base.iter_mut().zip(carriers).for_each(|(moves, carries)| *moves |= carries);
        moves_with_base[base] = true;
    }
    let mut found = Roles { base, moves_with_base, is_balanced: Vec::new() };
    let mut edges = graph.edges();
    edges.extend(contacts.filter(|bodies| !found.is_surroundings(mechanism, *bodies)).map(|bodies| bodies.to_vec()));
    let mut is_balanced = vec![false; mechanism.bodies.len()];
    let starts = graph.touching().into_iter().chain([object]);
    starts.filter(|body| !found.moves_with_base[*body]).for_each(|body| is_balanced[body] = true);
    loop {
        let before = is_balanced.clone();
        for bodies in &edges {
            let moving = || bodies.iter().flatten().filter(|body| !found.moves_with_base[**body]);
            if moving().any(|body| is_balanced[*body]) {
                moving().for_each(|body| is_balanced[*body] = true);
            }
        }
        if is_balanced == before {
            found.is_balanced = is_balanced;
            return found;
        }
    }
}

/// Returns the base of the hand that holds an object; `None` is the ground.
///
/// A body qualifies as the base if every path of joints from the ground to the bodies that can touch the object leads
/// through it, and if at least two of its joints lead on to such bodies. An example is the palm of a hand on a lift. A
/// body with a prescribed motion that carries all of them qualifies as well. The base is the last of these bodies, seen
/// from the ground. Without such a body, the base is the frame of the mechanism: the ground, or the body that stands
/// for it. Outlines listed as surroundings do not count as touching.
pub fn default_base(mechanism: &Mechanism, object: usize, surroundings: &[OutlineId]) -> Option<usize> {
    let graph = Graph { mechanism, object, surroundings };
    let touching = graph.touching();
    let candidates = (0..mechanism.bodies.len()).filter(|body| graph.leads_to(*body, &touching) >= 2);
    let carriers = |body: &usize| graph.ground_side(*body).into_iter().filter(|carries| *carries).count();
    let base = candidates.filter(|body| carries(mechanism, (object, *body), surroundings)).max_by_key(carriers);
    base.or(mechanism.frame())
}

/// Whether `base` carries the hand: every path of joints from the ground to the bodies that can touch the object leads
/// through it.
pub fn carries(mechanism: &Mechanism, (object, base): (usize, usize), surroundings: &[OutlineId]) -> bool {
    let graph = Graph { mechanism, object, surroundings };
    let without = graph.ground_side(base);
    let can_carry = mechanism.has_joint(Some(base)) && base != object;
    can_carry && graph.touching().into_iter().all(|body| body == base || !without[body])
}

/// For each body, whether it carries the base of a hand: whether joints connect it with the ground, or with a
/// prescribed motion, without passing the base.
pub fn carriers(mechanism: &Mechanism, (object, base): (usize, usize)) -> Vec<bool> {
    Graph { mechanism, object, surroundings: &[] }.ground_side(base)
}

/// Moves the ground with everything fixed to it, except outlines listed as surroundings. `keys` are updated
/// accordingly.
pub fn move_ground(mechanism: &mut Mechanism, keys: &mut Option<GraspKeys>, motion: PalmMotion) {
    let listed = keys.as_ref().map_or(&[][..], |keys| &keys.surroundings);
    let places = mechanism.move_frame(motion, |outline| listed.contains(&OutlineId { body: None, outline }));
    let Some(keys) = keys else { return };
    for id in keys.surroundings.iter_mut().filter(|id| id.body.is_none()) {
        *id = places[id.outline];
    }
    if keys.base == Some(None) {
        keys.base = Some(mechanism.frame());
    }
}

impl Roles {
    /// Whether one of the bodies of a contact belongs to the surroundings: it is the ground or a body with a prescribed
    /// motion, and it is not the base.
    pub fn is_surroundings(&self, mechanism: &Mechanism, bodies: [Option<usize>; 2]) -> bool {
        let is_other = |body: Option<usize>| mechanism.is_base(body) && body != self.base;
        self.base.is_some() && bodies.into_iter().any(is_other)
    }

    /// Whether a combination of joints moves the base. This is the case if none of its joints moves relative to the
    /// base.
    pub fn moves_base(&self, mechanism: &Mechanism, on: &JointCombination) -> bool {
        let bodies = on.terms.iter().flat_map(|(joint, _)| mechanism.joints[*joint].bodies);
        bodies.flatten().all(|body| self.moves_with_base[body])
    }

    /// Whether a combination of joints moves a body that is balanced.
    pub fn moves_balanced(&self, mechanism: &Mechanism, on: &JointCombination) -> bool {
        let bodies = on.terms.iter().flat_map(|(joint, _)| mechanism.joints[*joint].bodies);
        bodies.flatten().any(|body| self.is_balanced[body])
    }
}

/// Bodies without the object, connected by joints.
struct Graph<'a> {
    mechanism: &'a Mechanism,
    object: usize,
    /// Outlines that are no part of the hand.
    surroundings: &'a [OutlineId],
}

impl Graph<'_> {
    /// Bodies with joints and a contact pair with the object, without those of a prescribed motion.
    fn touching(&self) -> Vec<usize> {
        let Self { mechanism, object, surroundings } = *self;
        let is_touching = |body: &usize| {
            let touches = |pair: &ContactPair| {
                let sides = [[pair.points, pair.face], [pair.face, pair.points]];
                let is_of_body = |own: OutlineId| own.body == Some(*body) && !surroundings.contains(&own);
                sides.into_iter().any(|[own, other]| is_of_body(own) && other.body == Some(object))
            };
            *body != object && mechanism.bodies[*body].motion.is_none() && mechanism.contacts.iter().any(touches)
        };
        (0..mechanism.bodies.len()).filter(is_touching).filter(|body| mechanism.has_joint(Some(*body))).collect()
    }

    /// Bodies that joints connect with the starts, without passing the ground, the object, or a body.
    fn reached(&self, starts: impl Iterator<Item = usize>, without: usize) -> Vec<bool> {
        let passes = |body: usize| body != without && body != self.object && !self.mechanism.is_base(Some(body));
        let mut reached = vec![false; self.mechanism.bodies.len()];
        let mut next: Vec<usize> = starts.filter(|body| passes(*body)).collect();
        while let Some(body) = next.pop() {
            if !std::mem::replace(&mut reached[body], true) {
                next.extend(self.neighbours(Some(body)).flatten().filter(|body| passes(*body)));
            }
        }
        reached
    }

    /// Bodies that joints connect with the ground, or with a prescribed motion, without passing a body.
    fn ground_side(&self, without: usize) -> Vec<bool> {
        let prescribed = (0..self.mechanism.bodies.len()).map(Some).filter(|body| self.mechanism.is_base(*body));
        let roots = prescribed.chain([None]).filter(|body| *body != Some(without));
        self.reached(roots.flat_map(|root| self.neighbours(root)).flatten(), without)
    }

    /// Number of joints of a body that lead on to the bodies that can touch the object.
    fn leads_to(&self, body: usize, touching: &[usize]) -> usize {
        let carriers = self.ground_side(body);
        let leads = |next: usize| {
            let reached = self.reached(std::iter::once(next), body);
            !carriers[next] && touching.iter().any(|other| reached[*other])
        };
        self.neighbours(Some(body)).flatten().filter(|next| leads(*next)).count()
    }

    fn neighbours(&self, body: Option<usize>) -> impl Iterator<Item = Option<usize>> + '_ {
        let joints = self.mechanism.joints.iter().filter(move |joint| joint.bodies.contains(&body));
        joints.map(move |joint| if joint.bodies[0] == body { joint.bodies[1] } else { joint.bodies[0] })
    }

    /// Sets of bodies that joints and force elements connect.
    fn edges(&self) -> Vec<Vec<Option<usize>>> {
        let Mechanism { joints, couplings, springs, tendons, actuators, .. } = &self.mechanism;
        let of_joints = |terms: &[(usize, f64)]| -> Vec<Option<usize>> {
            terms.iter().flat_map(|(joint, _)| joints[*joint].bodies).collect()
        };
        let mut edges: Vec<_> = joints.iter().map(|joint| joint.bodies.to_vec()).collect();
        edges.extend(couplings.iter().map(|coupling| of_joints(&coupling.on.terms)));
        edges.extend(actuators.iter().map(|actuator| of_joints(&actuator.on.terms)));
        edges.extend(springs.iter().map(|spring| match &spring.kind {
            SpringKind::Torsional { on, .. } => of_joints(&on.terms),
            SpringKind::Linear { bodies, .. } => bodies.to_vec(),
        }));
        edges.extend(tendons.iter().map(|tendon| {
            let path = tendon.path.iter().map(|element| element.body);
            path.chain(of_joints(&tendon.joints)).chain(of_joints(&tendon.far_joints)).collect()
        }));
        edges
    }
}

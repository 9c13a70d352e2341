//! The frame of a mechanism: the ground, or a body that stands for it and moves.

use super::{Body, Mechanism, OutlineId, PrescribedMotion, SpringKind};
use crate::palm_motion::PalmMotion;

/// Name of the ground, and of a body that stands for the ground.
pub const GROUND: &str = "ground";

impl Mechanism {
    /// The body to which the frame of the mechanism is fixed: the ground (`None`), or the body that stands for it.
    pub fn frame(&self) -> Option<usize> {
        self.palm().map(|(palm, _)| palm).filter(|palm| self.bodies[*palm].name == GROUND)
    }

    /// Moves the frame of the mechanism. The joints, springs, cables, contacts and outlines of the ground become those
    /// of a new body; outlines that stay in the world are the exception. Returns the new places of all outlines of the
    /// ground.
    pub fn move_frame(&mut self, motion: PalmMotion, stays: impl Fn(usize) -> bool) -> Vec<OutlineId> {
        let frame = self.bodies.len();
        self.rename_bodies(|body| body.or(Some(frame)));
        let mut body = Body { is_reported: false, ..Body::new(GROUND, 0.0, 0.0) };
        body.pose = motion.initial_pose;
        body.motion = Some(PrescribedMotion::Palm(motion));
        let mut places = Vec::new();
        for (index, outline) in std::mem::take(&mut self.ground_outlines).into_iter().enumerate() {
            let (body, outlines) = match stays(index) {
                true => (None, &mut self.ground_outlines),
                false => (Some(frame), &mut body.outlines),
            };
            places.push(OutlineId { body, outline: outlines.len() });
            outlines.push(outline);
        }
        body.points = std::mem::take(&mut self.ground_points);
        self.bodies.push(body);
        for id in self.contacts.iter_mut().flat_map(|pair| [&mut pair.points, &mut pair.face]) {
            if id.body == Some(frame) {
                *id = places[id.outline];
            }
        }
        places
    }

    /// Replaces the bodies to which joints, springs, cables, contacts and feedback refer.
    pub fn rename_bodies(&mut self, renamed: impl Fn(Option<usize>) -> Option<usize>) {
        let joints = self.joints.iter_mut().flat_map(|joint| &mut joint.bodies);
        let springs = self.springs.iter_mut().filter_map(|spring| match &mut spring.kind {
            SpringKind::Linear { bodies, .. } => Some(bodies),
            SpringKind::Torsional { .. } => None,
        });
        let elements = self.tendons.iter_mut().flat_map(|tendon| &mut tendon.path).map(|element| &mut element.body);
        let pairs = self.contacts.iter_mut().flat_map(|pair| [&mut pair.points.body, &mut pair.face.body]);
        let feedback = self.actuators.iter_mut().filter_map(|actuator| actuator.powertrain.feedback.as_mut());
        let points = feedback.flat_map(|feedback| &mut feedback.points).map(|id| &mut id.body);
        let all = joints.chain(springs.flatten()).chain(elements).chain(pairs).chain(points);
        all.for_each(|body| *body = renamed(*body));
    }
}

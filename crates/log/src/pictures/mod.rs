//! What a 3-D view shows of a run: the shapes of the bodies once, then where their frames are, and forces as arrows.
//!
//! | file | job |
//! |---|---|
//! | `shapes` | bodies as foxglove primitives, and their colours |
//! | `arrows` | contact points and forces as foxglove primitives |
//!
//! Pictures are made of samples, on a grid of their own; besides, within an impact, whenever an arrow has changed by a
//! twentieth of the longest one. Where nothing has moved since the last picture there is none: viewers keep what they have.

mod arrows;
mod frame;
mod shapes;

pub use frame::WORLD;
use frame::about_z;
use std::io::Write;

use foxglove::messages::{FrameTransform, FrameTransforms, SceneUpdate, Timestamp, Vector3};
use mcap::McapError;

use self::arrows::Arrows;
use super::core::{ChannelId, Core, stamp};
use phalanx_core::drawing::{Drawing, Pose};
use phalanx_core::trace::ContactSample;

/// Part of the longest arrow by which one changes before it is drawn anew within an impact.
const ARROW_CHANGE: f64 = 0.05;
/// Changes of a picture that nobody sees, as parts of the longest arrow and of the view.
const INVISIBLE: f64 = 1e-5;

/// The channels, and what the last picture showed.
pub struct Pictures {
    transforms_id: ChannelId,
    /// `None` where nothing can touch.
    forces_id: Option<ChannelId>,
    interval_s: f64,
    /// When the next picture of the grid is due.
    next_s: f64,
    /// Width and height of the view, m.
    view_m: f64,
    /// Which bodies move; a message has these in this order.
    moving: Vec<bool>,
    transforms: FrameTransforms,
    shown: Vec<Pose>,
    arrows: Arrows,
    /// Shapes that are still to be drawn: a frame has to be somewhere before anything stands in it.
    shapes: Option<(ChannelId, SceneUpdate)>,
}

impl Pictures {
    /// Registers the channels and writes the frames that do not move; `None` where no pictures are wanted.
    pub fn register<W: Write>(
        core: &mut Core<W>,
        drawing: &Drawing,
        start: &[Pose],
        picture_hz: f64,
    ) -> Result<Option<Self>, McapError> {
        if picture_hz <= 0.0 {
            return Ok(None);
        }
        let fixed_id = core.channel::<FrameTransforms>("/tf_static")?;
        let transforms_id = core.channel::<FrameTransforms>("/tf")?;
        let shapes_id = core.channel::<SceneUpdate>("/scene")?;
        let touching = !drawing.contacts.is_empty();
        let forces_id = touching.then(|| core.channel::<SceneUpdate>("/forces")).transpose()?;

        let log_time = core.tick(0.0);
        let bodies = || drawing.bodies.iter().zip(start);
        let frames = |fixed: bool| {
            let of = bodies().filter(|(body, _)| body.fixed == fixed);
            FrameTransforms { transforms: of.map(|(body, pose)| frame(&body.name, pose)).collect() }
        };
        core.put(fixed_id, log_time, &stamped(frames(true), stamp(log_time)))?;
        Ok(Some(Pictures {
            transforms_id,
            forces_id,
            interval_s: 1.0 / picture_hz,
            next_s: 0.0,
            view_m: drawing.view_m(),
            moving: drawing.bodies.iter().map(|body| !body.fixed).collect(),
            transforms: frames(false),
            shown: start.to_vec(),
            arrows: Arrows::new(drawing),
            shapes: Some((shapes_id, shapes::scene(drawing))),
        }))
    }

    /// Draws a sample if a picture is due; `contacts` are those of the drawing, in its order.
    pub fn sample<'a, W: Write>(
        &mut self,
        core: &mut Core<W>,
        time_s: f64,
        poses: impl FnOnce() -> Vec<Pose>,
        contacts: impl Iterator<Item = &'a ContactSample> + Clone,
    ) -> Result<(), McapError> {
        let due = time_s >= self.next_s;
        if !due && self.arrows.change(contacts.clone()) <= ARROW_CHANGE {
            return Ok(());
        }
        if due {
            self.next_s = ((time_s / self.interval_s).floor() + 1.0) * self.interval_s;
        }
        let poses = poses();
        let log_time = core.tick(time_s);
        let moved = self.moved(&poses);
        let first = self.shapes.take();
        if first.is_some() || moved {
            let moving = poses.iter().zip(&self.moving).filter(|(_, moving)| **moving);
            for ((pose, _), transform) in moving.zip(&mut self.transforms.transforms) {
                set(transform, pose);
                transform.timestamp = Some(stamp(log_time));
            }
            core.put(self.transforms_id, log_time, &self.transforms)?;
            self.shown = poses;
        }
        let started = first.is_none();
        if let Some((shapes_id, mut shapes)) = first {
            shapes.entities.iter_mut().for_each(|entity| entity.timestamp = Some(stamp(log_time)));
            core.put(shapes_id, log_time, &shapes)?;
        }
        if let Some(forces_id) = self.forces_id
            && (!started || self.arrows.change(contacts.clone()) > INVISIBLE || (moved && self.arrows.any()))
        {
            core.put(forces_id, log_time, self.arrows.draw(contacts, stamp(log_time)))?;
        }
        Ok(())
    }

    /// Whether a body has moved by what could be seen.
    fn moved(&self, poses: &[Pose]) -> bool {
        poses.iter().zip(&self.shown).any(|(now, shown)| {
            let [x, y] = [0, 1].map(|k| (now.position_m[k] - shown.position_m[k]).abs());
            let turned = (now.angle_rad - shown.angle_rad).abs();
            x.max(y) > INVISIBLE * self.view_m || turned > INVISIBLE
        })
    }
}

fn frame(name: &str, pose: &Pose) -> FrameTransform {
    let mut transform = FrameTransform {
        timestamp: None,
        parent_frame_id: WORLD.to_string(),
        child_frame_id: name.to_string(),
        translation: None,
        rotation: None,
    };
    set(&mut transform, pose);
    transform
}

fn set(transform: &mut FrameTransform, pose: &Pose) {
    let [x, y] = pose.position_m;
    transform.translation = Some(Vector3 { x, y, z: 0.0 });
    transform.rotation = Some(about_z(pose.angle_rad));
}

fn stamped(mut frames: FrameTransforms, stamp: Timestamp) -> FrameTransforms {
    frames.transforms.iter_mut().for_each(|transform| transform.timestamp = Some(stamp));
    frames
}

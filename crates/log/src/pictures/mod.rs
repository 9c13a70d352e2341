//! Channels of the 3-D view: body shapes once, then body frames, and forces as arrows.
//!
//! | file | job |
//! |---|---|
//! | `shapes` | bodies as foxglove primitives, and their colours |
//! | `arrows` | contact points and forces as foxglove primitives |
//! | `frame` | the world frame, rotations about z |
//!
//! Pictures are drawn from samples on a separate time grid, and within an impact also whenever an arrow has changed by
//! a twentieth of the longest one. If nothing has moved since the last picture, none is written; viewers keep showing
//! it.

mod arrows;
mod frame;
mod shapes;

pub use frame::WORLD;
use frame::rotation_about_z;
use std::io::Write;

use foxglove::messages::{FrameTransform, FrameTransforms, SceneUpdate, Timestamp, Vector3};
use mcap::McapError;

use self::arrows::Arrows;
use super::mcap_writer::{ChannelId, McapWriter, to_timestamp};
use phalanx_core::drawing::{Drawing, Pose};
use phalanx_core::trace::ContactSample;

/// Change of an arrow that triggers a new picture within an impact, relative to the longest arrow.
const MIN_ARROW_CHANGE: f64 = 0.05;
/// Changes below this are not drawn, relative to the longest arrow and to the view.
const NEGLIGIBLE_CHANGE: f64 = 1e-5;

/// Channels of the 3-D view and the contents of the last picture.
pub struct Pictures {
    transforms_channel: ChannelId,
    /// Channel of the force arrows; `None` for scenes without drawn contacts.
    forces_channel: Option<ChannelId>,
    interval_s: f64,
    /// When the next picture of the grid is due.
    next_s: f64,
    /// Width and height of the view, m.
    view_m: f64,
    /// Which bodies move; a message contains these in this order.
    is_moving: Vec<bool>,
    transforms: FrameTransforms,
    last_poses: Vec<Pose>,
    arrows: Arrows,
    /// Shapes not yet written: a frame needs a pose before shapes can be drawn in it.
    shapes: Option<(ChannelId, SceneUpdate)>,
}

impl Pictures {
    /// Registers the channels and writes the fixed frames; returns `None` if pictures are disabled (`picture_hz` ≤ 0).
    pub fn register<W: Write>(
        out: &mut McapWriter<W>,
        drawing: &Drawing,
        start: &[Pose],
        picture_hz: f64,
    ) -> Result<Option<Self>, McapError> {
        if picture_hz <= 0.0 {
            return Ok(None);
        }
        let fixed_channel = out.register_channel::<FrameTransforms>("/tf_static")?;
        let transforms_channel = out.register_channel::<FrameTransforms>("/tf")?;
        let shapes_channel = out.register_channel::<SceneUpdate>("/scene")?;
        let has_contacts = !drawing.contacts.is_empty();
        let forces_channel = has_contacts.then(|| out.register_channel::<SceneUpdate>("/forces")).transpose()?;

        let log_time = out.log_time_ns(0.0);
        let bodies = || drawing.bodies.iter().zip(start);
        let frames = |fixed: bool| {
            let selected = bodies().filter(|(body, _)| body.fixed == fixed);
            FrameTransforms { transforms: selected.map(|(body, pose)| frame_transform(&body.name, pose)).collect() }
        };
        out.write_message(fixed_channel, log_time, &with_timestamp(frames(true), to_timestamp(log_time)))?;
        Ok(Some(Pictures {
            transforms_channel,
            forces_channel,
            interval_s: 1.0 / picture_hz,
            next_s: 0.0,
            view_m: drawing.view_m(),
            is_moving: drawing.bodies.iter().map(|body| !body.fixed).collect(),
            transforms: frames(false),
            last_poses: start.to_vec(),
            arrows: Arrows::new(drawing),
            shapes: Some((shapes_channel, shapes::scene(drawing))),
        }))
    }

    /// Draws a sample if a picture is due; `contacts` are in the order of the drawing.
    pub fn sample<'a, W: Write>(
        &mut self,
        out: &mut McapWriter<W>,
        time_s: f64,
        poses: impl FnOnce() -> Vec<Pose>,
        contacts: impl Iterator<Item = &'a ContactSample> + Clone,
    ) -> Result<(), McapError> {
        let is_due = time_s >= self.next_s;
        if !is_due && self.arrows.largest_change(contacts.clone()) <= MIN_ARROW_CHANGE {
            return Ok(());
        }
        if is_due {
            self.next_s = ((time_s / self.interval_s).floor() + 1.0) * self.interval_s;
        }
        let poses = poses();
        let log_time = out.log_time_ns(time_s);
        let has_moved = self.has_moved(&poses);
        let pending_shapes = self.shapes.take();
        if pending_shapes.is_some() || has_moved {
            let moving = poses.iter().zip(&self.is_moving).filter(|(_, moving)| **moving);
            for ((pose, _), transform) in moving.zip(&mut self.transforms.transforms) {
                set_pose(transform, pose);
                transform.timestamp = Some(to_timestamp(log_time));
            }
            out.write_message(self.transforms_channel, log_time, &self.transforms)?;
            self.last_poses = poses;
        }
        let has_started = pending_shapes.is_none();
        if let Some((shapes_channel, mut shapes)) = pending_shapes {
            shapes.entities.iter_mut().for_each(|entity| entity.timestamp = Some(to_timestamp(log_time)));
            out.write_message(shapes_channel, log_time, &shapes)?;
        }
        if let Some(forces_channel) = self.forces_channel
            && (!has_started
                || self.arrows.largest_change(contacts.clone()) > NEGLIGIBLE_CHANGE
                || (has_moved && self.arrows.any_visible()))
        {
            out.write_message(forces_channel, log_time, self.arrows.draw(contacts, to_timestamp(log_time)))?;
        }
        Ok(())
    }

    /// Whether a body has moved visibly since the last picture.
    fn has_moved(&self, poses: &[Pose]) -> bool {
        poses.iter().zip(&self.last_poses).any(|(pose, last_pose)| {
            let [dx, dy] = [0, 1].map(|k| (pose.position_m[k] - last_pose.position_m[k]).abs());
            let rotation_rad = (pose.angle_rad - last_pose.angle_rad).abs();
            dx.max(dy) > NEGLIGIBLE_CHANGE * self.view_m || rotation_rad > NEGLIGIBLE_CHANGE
        })
    }
}

fn frame_transform(name: &str, pose: &Pose) -> FrameTransform {
    let mut transform = FrameTransform {
        timestamp: None,
        parent_frame_id: WORLD.to_string(),
        child_frame_id: name.to_string(),
        translation: None,
        rotation: None,
    };
    set_pose(&mut transform, pose);
    transform
}

fn set_pose(transform: &mut FrameTransform, pose: &Pose) {
    let [x, y] = pose.position_m;
    transform.translation = Some(Vector3 { x, y, z: 0.0 });
    transform.rotation = Some(rotation_about_z(pose.angle_rad));
}

fn with_timestamp(mut frames: FrameTransforms, timestamp: Timestamp) -> FrameTransforms {
    frames.transforms.iter_mut().for_each(|transform| transform.timestamp = Some(timestamp));
    frames
}

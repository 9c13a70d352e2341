//! Channels of the 3-D view: body shapes once, then body frames, and forces as arrows.
//!
//! | file | job |
//! |---|---|
//! | `shapes` | bodies as foxglove primitives, and their colours |
//! | `arrows` | contact points and forces as foxglove primitives |
//!
//! Pictures are drawn from samples on a separate time grid, and within an impact also whenever an arrow has changed by
//! a twentieth of the longest one. If nothing has moved since the last picture, none is written; viewers keep showing
//! it.

mod arrows;
mod shapes;

use std::io::Write;

use foxglove::Encode;
use foxglove::messages::{FrameTransform, FrameTransforms, SceneUpdate, Vector3};

use self::arrows::{Arrows, WORLD, rotation_about_z};
use super::mcap_file::{ChannelId, McapFile, to_timestamp};
use phalanx_core::drawing::{Drawing, FramePose};
use phalanx_core::trace::{ContactSample, SinkError};

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
    /// Names of the bodies that move; `None` for fixed ones.
    moving: Vec<Option<String>>,
    last_poses: Vec<FramePose>,
    arrows: Arrows,
    /// Shapes not yet written: a frame needs a pose before shapes can be drawn in it.
    shapes: Option<(ChannelId, SceneUpdate)>,
}

impl Pictures {
    /// Registers the channels and writes the fixed frames; returns `None` if pictures are disabled (`picture_hz` ≤ 0).
    pub fn register<W: Write>(
        out: &mut McapFile<W>,
        drawing: &Drawing,
        start: &[FramePose],
        picture_hz: f64,
    ) -> Result<Option<Self>, SinkError> {
        if picture_hz <= 0.0 {
            return Ok(None);
        }
        let fixed_channel = out.register("/tf_static", FrameTransforms::get_schema())?;
        let transforms_channel = out.register("/tf", FrameTransforms::get_schema())?;
        let shapes_channel = out.register("/scene", SceneUpdate::get_schema())?;
        let has_contacts = !drawing.contacts.is_empty();
        let forces_channel = has_contacts.then(|| out.register("/forces", SceneUpdate::get_schema())).transpose()?;

        let log_time = out.log_time_ns(0.0);
        let names = |fixed: bool| -> Vec<Option<String>> {
            drawing.bodies.iter().map(|body| (body.fixed == fixed).then(|| body.name.clone())).collect()
        };
        out.write_message(fixed_channel, log_time, &transforms(&names(true), start, log_time))?;
        Ok(Some(Pictures {
            transforms_channel,
            forces_channel,
            interval_s: 1.0 / picture_hz,
            next_s: 0.0,
            view_m: drawing.view_m(),
            moving: names(false),
            last_poses: start.to_vec(),
            arrows: Arrows::new(drawing),
            shapes: Some((shapes_channel, shapes::scene(drawing))),
        }))
    }

    /// Draws a sample if a picture is due; `contacts` are in the order of the drawing.
    pub fn sample<W: Write>(
        &mut self,
        out: &mut McapFile<W>,
        time_s: f64,
        poses: impl FnOnce() -> Vec<FramePose>,
        contacts: impl Iterator<Item = ContactSample> + Clone,
    ) -> Result<(), SinkError> {
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
            out.write_message(self.transforms_channel, log_time, &transforms(&self.moving, &poses, log_time))?;
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
    fn has_moved(&self, poses: &[FramePose]) -> bool {
        poses.iter().zip(&self.last_poses).any(|(pose, last_pose)| {
            let [dx, dy] = [0, 1].map(|k| (pose.position_m[k] - last_pose.position_m[k]).abs());
            let rotation_rad = (pose.angle_rad - last_pose.angle_rad).abs();
            dx.max(dy) > NEGLIGIBLE_CHANGE * self.view_m || rotation_rad > NEGLIGIBLE_CHANGE
        })
    }
}

/// Returns the frames of the named bodies.
fn transforms(names: &[Option<String>], poses: &[FramePose], log_time_ns: u64) -> FrameTransforms {
    let transform = |(name, pose): (&String, &FramePose)| FrameTransform {
        timestamp: Some(to_timestamp(log_time_ns)),
        parent_frame_id: WORLD.to_string(),
        child_frame_id: name.clone(),
        translation: Some(Vector3 { x: pose.position_m[0], y: pose.position_m[1], z: 0.0 }),
        rotation: Some(rotation_about_z(pose.angle_rad)),
    };
    let named = names.iter().zip(poses).filter_map(|(name, pose)| Some((name.as_ref()?, pose)));
    FrameTransforms { transforms: named.map(transform).collect() }
}

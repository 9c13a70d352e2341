//! All points of all volumes, on as many threads as asked for: the same points whatever their number.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;

use super::point::{Point, close, design, hold};
use super::{Volume, VolumeError, VolumeRequest};
use crate::study::pool;

/// Designs that a thread takes at a time: a few milliseconds of work.
const SHARE: usize = 64;

/// Points in all, above which a request is refused: they are kept in memory, some 150 bytes each, and as a table four times that.
pub const MOST_POINTS: usize = 2_000_000;

/// The volumes of every base and coefficient of friction, bases slowest.
///
/// # Errors
/// What is wrong with the request.
pub fn volumes(request: &VolumeRequest, threads: usize) -> Result<Vec<Volume>, VolumeError> {
    volumes_with(request, threads, &mut |_, _| (), &|| true)
}

/// [`volumes`] that `show`s how many of how many designs are done, for as long as it may `go_on`.
///
/// # Errors
/// What is wrong with the request, or that it was stopped.
pub fn volumes_with(
    request: &VolumeRequest,
    threads: usize,
    show: &mut dyn FnMut(usize, usize),
    go_on: &dyn Fn() -> bool,
) -> Result<Vec<Volume>, VolumeError> {
    request.check()?;
    let designs = request.axes.len();
    let total = designs * request.bases_m.len();
    let shares = (0..designs).step_by(SHARE).map(|from| from..designs.min(from + SHARE));
    let bases = request.bases_m.iter();
    let jobs: Vec<_> = bases.flat_map(|&base_m| shares.clone().map(move |share| (base_m, share))).collect();
    let (stopped, mut done) = (AtomicBool::new(false), 0);
    let work = |(base_m, designs): &(f64, Range<usize>), sender: &Sender<usize>| {
        let points = (!stopped.load(Ordering::Relaxed)).then(|| share(request, *base_m, designs.clone()))?;
        // Nobody listens any more where the listener panicked.
        sender.send(designs.len()).unwrap_or_else(|_| stopped.store(true, Ordering::Relaxed));
        Some(points)
    };
    let found = pool::map(threads, &jobs, work, |more| {
        done += more;
        show(done, total);
        if !go_on() {
            stopped.store(true, Ordering::Relaxed);
        }
    });
    let found: Option<Vec<_>> = found.into_iter().collect();
    let mut found = found.ok_or(VolumeError::Stopped { done, total })?.into_iter();
    let mut volumes = Vec::with_capacity(request.bases_m.len() * request.mu_static.len());
    for &base_m in &request.bases_m {
        let start = volumes.len();
        for &mu_static in &request.mu_static {
            volumes.push(Volume { base_m, mu_static, axes: request.axes, points: Vec::with_capacity(designs) });
        }
        for share in found.by_ref().take(shares.len()) {
            for (volume, points) in volumes[start..].iter_mut().zip(share) {
                volume.points.extend(points);
            }
        }
    }
    Ok(volumes)
}

/// The points of some designs of one base, a list for each coefficient of friction.
fn share(request: &VolumeRequest, base_m: f64, designs: Range<usize>) -> Vec<Vec<Point>> {
    let mut lists: Vec<Vec<Point>> = request.mu_static.iter().map(|_| Vec::with_capacity(designs.len())).collect();
    for index in designs {
        let at = request.axes.at(index);
        let [l21_fraction, phi22_rad, arm_ratio] = at;
        let closed = close(&request.template, &design(&request.template, base_m, at), request.rule);
        for (list, &mu_static) in lists.iter_mut().zip(&request.mu_static) {
            let state = closed.as_ref().map_err(Clone::clone).and_then(|closed| hold(closed, mu_static));
            list.push(Point { l21_fraction, phi22_rad, arm_ratio, state });
        }
    }
    lists
}

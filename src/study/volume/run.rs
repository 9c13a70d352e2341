//! Computation of all points of all volumes on several threads. The result does not depend on their number.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;

use super::point::{Point, close_finger, design_at, solve_grasp};
use super::{Volume, VolumeError, VolumeRequest};
use crate::study::pool;

/// Number of designs per job: a few milliseconds of work.
const CHUNK_SIZE: usize = 64;

/// Maximum total number of points. Points are kept in memory, with about 150 bytes each, and four times that as a
/// table.
pub const MAX_POINTS: usize = 2_000_000;

/// Computes the volumes of every base and friction coefficient; the base varies slowest.
///
/// # Errors
/// Returns an error if the request is invalid.
pub fn volumes(request: &VolumeRequest, threads: usize) -> Result<Vec<Volume>, VolumeError> {
    volumes_with(request, threads, &mut |_, _| (), &|| true)
}

/// Like [`volumes`], with progress and interruption: `progress` receives the completed and the total number of designs.
///
/// # Errors
/// Returns an error if the request is invalid, or `keep_running` returned `false`.
pub fn volumes_with(
    request: &VolumeRequest,
    threads: usize,
    progress: &mut dyn FnMut(usize, usize),
    keep_running: &dyn Fn() -> bool,
) -> Result<Vec<Volume>, VolumeError> {
    request.check()?;
    let designs = request.axes.len();
    let total = designs * request.bases_m.len();
    let chunks = (0..designs).step_by(CHUNK_SIZE).map(|from| from..designs.min(from + CHUNK_SIZE));
    let bases = request.bases_m.iter();
    let jobs: Vec<_> = bases.flat_map(|&base_m| chunks.clone().map(move |chunk| (base_m, chunk))).collect();
    let (stopped, mut done) = (AtomicBool::new(false), 0);
    let work = |(base_m, designs): &(f64, Range<usize>), sender: &Sender<usize>| {
        let points = (!stopped.load(Ordering::Relaxed)).then(|| evaluate_designs(request, *base_m, designs.clone()))?;
        // The receiver is gone if the calling thread panicked.
        sender.send(designs.len()).unwrap_or_else(|_| stopped.store(true, Ordering::Relaxed));
        Some(points)
    };
    let found = pool::map(threads, &jobs, work, |completed| {
        done += completed;
        progress(done, total);
        if !keep_running() {
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
        for chunk in found.by_ref().take(chunks.len()) {
            for (volume, points) in volumes[start..].iter_mut().zip(chunk) {
                volume.points.extend(points);
            }
        }
    }
    Ok(volumes)
}

/// Computes the points of some designs of one base; one list for each friction coefficient.
fn evaluate_designs(request: &VolumeRequest, base_m: f64, designs: Range<usize>) -> Vec<Vec<Point>> {
    let mut lists: Vec<Vec<Point>> = request.mu_static.iter().map(|_| Vec::with_capacity(designs.len())).collect();
    for index in designs {
        let coordinates = request.axes.at(index);
        let [l21_fraction, phi22_rad, arm_ratio] = coordinates;
        let closed = close_finger(&request.template, &design_at(&request.template, base_m, coordinates), request.rule);
        for (list, &mu_static) in lists.iter_mut().zip(&request.mu_static) {
            let state = closed.as_ref().map_err(Clone::clone).and_then(|closed| solve_grasp(closed, mu_static));
            list.push(Point { l21_fraction, phi22_rad, arm_ratio, state });
        }
    }
    lists
}

//! All points of all volumes, on as many threads as asked for: the same points whatever their number.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use super::point::{Point, close, design, hold};
use super::{Volume, VolumeError, VolumeRequest};

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
    let shares = designs.div_ceil(SHARE);
    let jobs = shares * request.bases_m.len();
    let mut found: Vec<Option<Vec<Vec<Point>>>> = (0..jobs).map(|_| None).collect();
    let (next, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        for _ in 0..threads.clamp(1, jobs.max(1)) {
            let (send, next, stopped) = (send.clone(), &next, &stopped);
            scope.spawn(move || {
                while !stopped.load(Ordering::Relaxed) {
                    let job = next.fetch_add(1, Ordering::Relaxed);
                    if job >= jobs {
                        break;
                    }
                    let from = job % shares * SHARE;
                    let points = share(request, request.bases_m[job / shares], from..designs.min(from + SHARE));
                    if send.send((job, points)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        let mut done = 0;
        for (job, points) in receive {
            done += points.first().map_or(0, Vec::len);
            found[job] = Some(points);
            show(done, total);
            if !go_on() {
                stopped.store(true, Ordering::Relaxed);
            }
        }
        if done < total { Err(VolumeError::Stopped { done, total }) } else { Ok(()) }
    })?;

    let mut found = found.into_iter().flatten();
    let mut volumes = Vec::with_capacity(request.bases_m.len() * request.mu_static.len());
    for &base_m in &request.bases_m {
        let start = volumes.len();
        for &mu_static in &request.mu_static {
            volumes.push(Volume { base_m, mu_static, axes: request.axes, points: Vec::with_capacity(designs) });
        }
        for share in found.by_ref().take(shares) {
            for (volume, points) in volumes[start..].iter_mut().zip(share) {
                volume.points.extend(points);
            }
        }
    }
    Ok(volumes)
}

/// The points of some designs of one base, a list for each coefficient of friction.
fn share(request: &VolumeRequest, base_m: f64, designs: std::ops::Range<usize>) -> Vec<Vec<Point>> {
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

/// The cores of this machine.
pub fn all_cores() -> usize {
    thread::available_parallelism().map_or(1, NonZeroUsize::get)
}

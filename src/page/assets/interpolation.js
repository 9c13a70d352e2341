// Evaluates a run at a time: a sample, or the interpolant between two samples.

// Index of the last sample at or before the time; 0 before the first.
function sampleIndexAt(times, time) {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle + 1;
    else high = middle;
  }
  return Math.max(low - 1, 0);
}

// If the mean of two rates differs from the slope between the samples by more than this fraction, a rate has jumped.
const JUMP_TOLERANCE = 0.25;

// Locates a time among the samples: at the given fraction of the interval `step` between samples `i` and `j`.
function locateSample(run, time) {
  const i = sampleIndexAt(run.time, time);
  const j = Math.min(i + 1, run.samples - 1);
  const step = run.time[j] - run.time[i];
  const fraction = step > 0 && time > run.time[i] ? (time - run.time[i]) / step : 0;
  return { i, j, fraction, step };
}

// Value at a position; exact at a sample. Between two samples: the cubic Hermite polynomial of values and rates, or a
// straight line without rates or where a rate has jumped.
function interpolate(values, { i, j, fraction, step }, rates) {
  const first = values[i];
  if (fraction === 0) return first;
  const last = values[j];
  if (!Number.isFinite(first) || !Number.isFinite(last)) return first;
  const linear = first + (last - first) * fraction;
  if (!rates) return linear;
  const [firstSlope, lastSlope] = [rates[i] * step, rates[j] * step];
  const largestSlope = Math.max(Math.abs(firstSlope), Math.abs(lastSlope));
  if (!(Math.abs(last - first - (firstSlope + lastSlope) / 2) <= JUMP_TOLERANCE * largestSlope)) return linear;
  const remaining = 1 - fraction;
  return linear + fraction * remaining * (remaining * (firstSlope - (last - first)) - fraction * (lastSlope - (last - first)));
}

// Pose of a body.
function poseAt(body, position) {
  return {
    x_m: interpolate(body.x_m, position, body.vx_m_s),
    y_m: interpolate(body.y_m, position, body.vy_m_s),
    angle_rad: interpolate(body.angle_rad, position, body.spin_rad_s),
  };
}

// Time of the next sample of any visible run, forward (1) or backward (−1).
function nextSampleTime(runs, time, direction) {
  let nearest = null;
  for (const run of runs) {
    if (!run.visible) continue;
    let i = sampleIndexAt(run.time, time);
    if (direction > 0) i = run.time[i] > time ? i : i + 1;
    else while (i >= 0 && run.time[i] >= time) i--;
    if (i < 0 || i >= run.samples) continue;
    const candidate = run.time[i];
    if (nearest === null || (direction > 0 ? candidate < nearest : candidate > nearest)) nearest = candidate;
  }
  return nearest ?? time;
}

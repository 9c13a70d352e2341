// What a run is at a time: a sample, or what its values and rates say of the time between two.

// Index of the last sample that is not after the time; 0 before the first.
function indexAt(times, time) {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle + 1;
    else high = middle;
  }
  return Math.max(low - 1, 0);
}

// Rates that miss the mean slope between two samples by more than this part of themselves have jumped in between.
const JUMP = 0.25;

// Where a time lies among the samples: between `i` and `j`, `step` apart, `part` of the way.
function placeAt(run, time) {
  const i = indexAt(run.time, time);
  const j = Math.min(i + 1, run.samples - 1);
  const step = run.time[j] - run.time[i];
  const part = step > 0 && time > run.time[i] ? (time - run.time[i]) / step : 0;
  return { i, j, part, step };
}

// The value there; a sample itself is exact. Between two samples: the cubic of their values and rates (Hermite), where
// there are rates and they fit the values; else a straight line.
function valueAt(values, { i, j, part, step }, rates) {
  const from = values[i];
  if (part === 0) return from;
  const to = values[j];
  if (!Number.isFinite(from) || !Number.isFinite(to)) return from;
  const line = from + (to - from) * part;
  if (!rates) return line;
  const [before, after] = [rates[i] * step, rates[j] * step];
  const size = Math.max(Math.abs(before), Math.abs(after));
  if (!(Math.abs(to - from - (before + after) / 2) <= JUMP * size)) return line;
  const left = 1 - part;
  return line + part * left * (left * (before - (to - from)) - part * (after - (to - from)));
}

// Where a body is.
function poseAt(body, place) {
  return {
    x_m: valueAt(body.x_m, place, body.vx_m_s),
    y_m: valueAt(body.y_m, place, body.vy_m_s),
    angle_rad: valueAt(body.angle_rad, place, body.spin_rad_s),
  };
}

// The time of the next sample of any shown run, forth (1) or back (−1).
function neighbour(runs, time, way) {
  let best = null;
  for (const run of runs) {
    if (!run.visible) continue;
    let i = indexAt(run.time, time);
    if (way > 0) i = run.time[i] > time ? i : i + 1;
    else while (i >= 0 && run.time[i] >= time) i--;
    if (i < 0 || i >= run.samples) continue;
    const found = run.time[i];
    if (best === null || (way > 0 ? found < best : found > best)) best = found;
  }
  return best ?? time;
}

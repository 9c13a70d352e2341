// What a run is at a time: a sample, or a straight line between two.

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

// Where a time lies among the samples: between `i` and `j`, `part` of the way.
function placeAt(run, time) {
  const i = indexAt(run.time, time);
  const j = Math.min(i + 1, run.samples - 1);
  const step = run.time[j] - run.time[i];
  const part = step > 0 && time > run.time[i] ? (time - run.time[i]) / step : 0;
  return { i, j, part };
}

// The value there; a sample itself is exact.
function valueAt(values, { i, j, part }) {
  const from = values[i];
  if (part === 0) return from;
  const to = values[j];
  return Number.isFinite(from) && Number.isFinite(to) ? from + (to - from) * part : from;
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

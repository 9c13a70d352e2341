// The simulation time of the playback. "Wall-clock" durations are those of the viewer.

const MIN_SPEED = 1e-5;
// Automatic speed, in wall-clock seconds: duration of a run without impacts; time constant of the approach to an
// impact.
const CRUISE_DURATION_S = 8;
const APPROACH_TIME_CONSTANT_S = 0.4;
// Wall-clock pause at the end before a looping playback restarts, s.
const END_PAUSE_S = 1.5;
const MAX_SLOWED_IMPACTS = 8;
const MANTISSAS = [1, 2, 5];

// Speeds of the slider: 1, 2 and 5 in each decade up to real time.
const notchSpeed = (notch) => MANTISSAS[notch % 3] * MIN_SPEED * 10 ** Math.floor(notch / 3);
const NOTCH_COUNT = 16;

// Time from an event until the normal force at its contact has fallen to half of its first peak.
function impactDuration(event) {
  const { run, place: contactName, time_s } = event;
  const contact = run.contacts.find((candidate) => candidate.name === contactName);
  const span = run.time[run.samples - 1] - run.time[0];
  if (!contact) return span * 1e-3;
  let peak = 0;
  let i = sampleIndexAt(run.time, time_s);
  const first = i;
  for (; i < run.samples; i++) {
    peak = Math.max(peak, contact.normal_n[i]);
    if (peak > 0 && contact.normal_n[i] < 0.5 * peak) return run.time[i] - time_s;
  }
  // A lasting contact has no such end; the samples after the event indicate the time scale.
  const timeAround = run.time[Math.min(first + 20, run.samples - 1)] - time_s;
  return timeAround > 0 ? timeAround : span * 1e-3;
}

// The touch-downs at which the playback slows down: the first of each contact and the hardest others, except contacts
// that are closed at the start.
function selectImpacts(events, start) {
  const touchDowns = events.filter((event) => event.kind === "touch-down" && event.time_s > start);
  const first = new Map();
  for (const event of touchDowns) {
    const key = event.run.index + event.place;
    if (!first.has(key)) first.set(key, event);
  }
  const rest = touchDowns.filter((event) => ![...first.values()].includes(event)).sort((a, b) => b.figure - a.figure);
  const chosen = [...first.values(), ...rest].slice(0, MAX_SLOWED_IMPACTS);
  return chosen.map((event) => ({ time: event.time_s, duration: impactDuration(event) })).sort((a, b) => a.time - b.time);
}

class Clock {
  constructor(playback, onChange) {
    this.playback = playback;
    this.onChange = onChange;
    this.time = playback.start;
    this.playing = false;
    this.auto = true;
    this.notch = 8;
    // Whether the playback restarts after its end.
    this.loops = false;
    this.endPause_s = 0;
    this.reload();
  }

  // Adopts the present playback at the same fraction of its duration.
  reload() {
    const { playback, span } = this;
    if (span) this.time = Math.min(playback.start + (this.time - span[0]) / (span[1] - span[0]) * (playback.end - playback.start), playback.end);
    this.span = [playback.start, playback.end];
    this.impacts = selectImpacts(playback.events, playback.start + 1e-4 * (playback.end - playback.start));
    this.cruiseSpeed = Math.min(1, (playback.end - playback.start) / CRUISE_DURATION_S);
  }

  get speed() {
    return this.auto ? this.speedAt(this.time) : notchSpeed(this.notch);
  }

  // Speed of the automatic mode: proportional to the time from the nearest impact, within bounds.
  speedAt(time) {
    let speed = this.cruiseSpeed;
    for (const { time: impactTime, duration } of this.impacts) {
      // An impact is visible for about half a second.
      const minSpeed = Math.min(this.cruiseSpeed, Math.max(MIN_SPEED, duration / 0.5));
      const timeSince = time - impactTime;
      const distance = timeSince < 0 ? -timeSince : Math.max(0, timeSince - duration);
      speed = Math.min(speed, Math.max(minSpeed, distance / APPROACH_TIME_CONSTANT_S));
    }
    return speed;
  }

  // The nearest impact, or the given event if there is no impact.
  nearest(event) {
    const distance = (impact) => Math.abs(impact.time - this.time);
    const best = this.impacts.reduce((best, impact) => (best && distance(best) <= distance(impact) ? best : impact), null);
    return best ?? (event && { time: event.time_s, duration: impactDuration(event) });
  }

  seek(time) {
    this.time = Math.min(Math.max(time, this.playback.start), this.playback.end);
    this.onChange();
  }

  play() {
    if (this.time >= this.playback.end) this.time = this.playback.start;
    this.playing = true;
    this.onChange();
  }

  pause() {
    this.playing = false;
    this.onChange();
  }

  // The simulation time after a wall-clock duration.
  timeAfter(time, seconds) {
    if (!this.auto) return time + notchSpeed(this.notch) * seconds;
    // Steps are short compared with the approach, so that no impact is skipped.
    for (let remaining = seconds; remaining > 0; remaining -= 2e-3) time += this.speedAt(time) * Math.min(remaining, 2e-3);
    return time;
  }

  // Advances by a wall-clock duration.
  advance(seconds) {
    if (!this.playing) return;
    if (this.loops && this.time >= this.playback.end) {
      this.endPause_s += seconds;
      if (this.endPause_s >= END_PAUSE_S) this.seek(this.playback.start);
      return;
    }
    this.endPause_s = 0;
    const time = this.timeAfter(this.time, seconds);
    if (time >= this.playback.end) this.playing = this.loops;
    this.seek(time);
  }
}

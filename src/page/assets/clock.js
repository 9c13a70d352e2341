// The time of the film and how it passes.

const SLOWEST = 1e-5;
// Seconds of the reader's in which the whole run passes where nothing happens, and in which an approach halves.
const CRUISE_S = 8;
const APPROACH_S = 0.4;
// Seconds of the reader's for which a film that starts again shows its end.
const REST_S = 1.5;
const MOST_MOMENTS = 8;
const MANTISSAS = [1, 2, 5];

// Speeds of the slider: 1, 2 and 5 of every decade up to real time.
const speedOf = (notch) => MANTISSAS[notch % 3] * SLOWEST * 10 ** Math.floor(notch / 3);
const NOTCHES = 16;

// Time from an event until the force at its place has had its first peak and half of it is gone again.
function lengthOf(event) {
  const { run, place, time_s } = event;
  const contact = run.contacts.find((each) => each.name === place);
  const span = run.time[run.samples - 1] - run.time[0];
  if (!contact) return span * 1e-3;
  let peak = 0;
  let i = indexAt(run.time, time_s);
  const first = i;
  for (; i < run.samples; i++) {
    peak = Math.max(peak, contact.normal_n[i]);
    if (peak > 0 && contact.normal_n[i] < 0.5 * peak) return run.time[i] - time_s;
  }
  // A contact that stays has no such end: the samples around its start say how fast things go.
  const near = run.time[Math.min(first + 20, run.samples - 1)] - time_s;
  return near > 0 ? near : span * 1e-3;
}

// The touch-downs at which playing slows down: the first of each place, and the hardest; not what touches from the start.
function momentsOf(events, start) {
  const downs = events.filter((event) => event.kind === "touch-down" && event.time_s > start);
  const first = new Map();
  for (const event of downs) {
    const key = event.run.index + event.place;
    if (!first.has(key)) first.set(key, event);
  }
  const rest = downs.filter((event) => ![...first.values()].includes(event)).sort((a, b) => b.figure - a.figure);
  const chosen = [...first.values(), ...rest].slice(0, MOST_MOMENTS);
  return chosen.map((event) => ({ time: event.time_s, length: lengthOf(event) })).sort((a, b) => a.time - b.time);
}

class Clock {
  constructor(film, changed) {
    this.film = film;
    this.changed = changed;
    this.time = film.start;
    this.playing = false;
    this.auto = true;
    this.notch = 8;
    // Whether the film starts again when it has ended.
    this.loops = false;
    this.rested = 0;
    this.renew();
  }

  // Takes the film as it is now: the same part of it has passed.
  renew() {
    const { film, span } = this;
    if (span) this.time = Math.min(film.start + (this.time - span[0]) / (span[1] - span[0]) * (film.end - film.start), film.end);
    this.span = [film.start, film.end];
    this.moments = momentsOf(film.events, film.start + 1e-4 * (film.end - film.start));
    this.cruise = Math.min(1, (film.end - film.start) / CRUISE_S);
  }

  get speed() {
    return this.auto ? this.speedAt(this.time) : speedOf(this.notch);
  }

  // Speed of the automatic mode: proportional to the distance from the nearest impact, within bounds.
  speedAt(time) {
    let speed = this.cruise;
    for (const { time: at, length } of this.moments) {
      // An impact is seen for about half a second.
      const least = Math.min(this.cruise, Math.max(SLOWEST, length / 0.5));
      const past = time - at;
      const away = past < 0 ? -past : Math.max(0, past - length);
      speed = Math.min(speed, Math.max(least, away / APPROACH_S));
    }
    return speed;
  }

  // The nearest impact; where nothing is one, the event given instead.
  nearest(event) {
    const away = (moment) => Math.abs(moment.time - this.time);
    const best = this.moments.reduce((best, moment) => (best && away(best) <= away(moment) ? best : moment), null);
    return best ?? (event && { time: event.time_s, length: lengthOf(event) });
  }

  seek(time) {
    this.time = Math.min(Math.max(time, this.film.start), this.film.end);
    this.changed();
  }

  play() {
    if (this.time >= this.film.end) this.time = this.film.start;
    this.playing = true;
    this.changed();
  }

  pause() {
    this.playing = false;
    this.changed();
  }

  // The time after so many seconds of the reader's.
  after(time, seconds) {
    if (!this.auto) return time + speedOf(this.notch) * seconds;
    // Steps short against the approach, so that no impact is jumped over.
    for (let left = seconds; left > 0; left -= 2e-3) time += this.speedAt(time) * Math.min(left, 2e-3);
    return time;
  }

  // So many seconds of the reader's go by.
  pass(seconds) {
    if (!this.playing) return;
    if (this.loops && this.time >= this.film.end) {
      // The end is what is looked at most.
      this.rested += seconds;
      if (this.rested >= REST_S) this.seek(this.film.start);
      return;
    }
    this.rested = 0;
    const time = this.after(this.time, seconds);
    if (time >= this.film.end) this.playing = this.loops;
    this.seek(time);
  }
}

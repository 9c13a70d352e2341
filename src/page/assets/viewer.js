// What shows a film: the clock, the animation, plots, events and their controls, drawn when something has changed.

// `keyed` ties the keyboard to what it does.
function viewer(film, keyed) {
  const app = { film, dirty: true };
  let span = [film.start, film.end];

  app.range = () => span;
  app.changed = () => { app.dirty = true; };
  app.clock = new Clock(film, () => {
    keepInWindow();
    app.changed();
  });
  app.stage = new Stage(film, byId("stage"));

  // The window of the time axis goes along with the cursor.
  function keepInWindow() {
    const [from, to] = span;
    const { time } = app.clock;
    if (time >= from && time <= to) return;
    const wide = to - from;
    app.window(time < from ? time - 0.1 * wide : time - 0.9 * wide, time < from ? time + 0.9 * wide : time + 0.1 * wide);
  }

  app.window = (from, to) => {
    const least = 1e-7 * (film.end - film.start);
    const wide = Math.min(Math.max(to - from, least), film.end - film.start);
    const start = Math.min(Math.max(from, film.start), film.end - wide);
    span = [start, start + wide];
    app.changed();
  };
  app.zoomTime = (factor, about = app.clock.time) => {
    const [from, to] = span;
    const at = Math.min(Math.max(about, from), to);
    app.window(at - (at - from) * factor, at + (to - at) * factor);
  };
  app.moveTime = (part) => {
    const [from, to] = span;
    const by = part * (to - from);
    app.window(from + by, to + by);
  };
  // Another film in place of this one. The view, the window of the time axis and the part of the run that has passed stay.
  app.replace = (next) => {
    const whole = span[0] <= film.start && span[1] >= film.end;
    Object.assign(film, next);
    for (const each of [app.clock, app.stage, app.plots]) each.renew();
    if (whole) app.window(film.start, film.end);
    else app.window(...span);
    choices(app);
  };
  app.windowEvent = () => {
    const moment = app.clock.nearest(app.events.nearest(app.clock.time));
    if (!moment) return;
    const { time, length } = moment;
    app.window(time - 0.6 * length, time + 2.4 * length);
    app.seek(time);
  };

  app.seek = (time) => app.clock.seek(time);
  app.pause = () => app.clock.pause();
  app.toggle = () => (app.clock.playing ? app.clock.pause() : app.clock.play());
  app.step = (way) => {
    app.pause();
    app.seek(neighbour(film.runs, app.clock.time, way));
  };
  app.jump = (way) => {
    const event = app.events.next(app.clock.time, way);
    app.pause();
    app.seek(event ? event.time_s : way > 0 ? film.end : film.start);
  };
  app.setNotch = (notch) => {
    app.clock.notch = Math.min(Math.max(Math.round(notch), 0), NOTCHES - 1);
    app.clock.auto = false;
    app.changed();
  };
  app.faster = (by) => app.setNotch((app.clock.auto ? Math.round(3 * Math.log10(app.clock.speed / SLOWEST)) : app.clock.notch) + by);
  app.setAuto = (auto) => {
    app.clock.auto = auto;
    app.changed();
  };
  app.show = (index, visible) => {
    film.runs[index].visible = visible;
    app.changed();
  };
  app.follow = (name) => {
    app.stage.camera.followContact(name);
    app.changed();
  };
  app.nextView = () => {
    const views = [null, ...app.stage.camera.deepest.keys()];
    app.follow(views[(views.indexOf(app.stage.camera.follow) + 1) % views.length]);
  };
  app.zoom = (factor) => {
    app.stage.camera.zoomBy(factor);
    app.changed();
  };
  app.fit = () => {
    app.stage.camera.fit();
    app.changed();
  };
  app.toggleLetters = () => {
    app.stage.named = !app.stage.named;
    app.changed();
  };
  app.setArrows = (kind) => {
    app.stage.arrowsToScale = kind === "linear";
    app.changed();
  };

  app.theme = (name) => {
    document.documentElement.dataset.theme = name;
    byId("theme").setAttribute("aria-pressed", name === "dark");
    forgetColours();
    app.changed();
  };
  app.toggleTheme = () => app.theme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  app.theme(dark.matches ? "dark" : "light");
  dark.addEventListener("change", () => app.theme(dark.matches ? "dark" : "light"));

  app.plots = new Plots(film, byId("plots"), app);
  app.plots.zoomTime = app.zoomTime;
  app.plots.moveTime = app.moveTime;
  app.events = new Events(film, byId("events"), app.seek);
  const refreshControls = controls(app);
  keyed(app);
  // What else is brought up to date when something has been drawn.
  app.drawn = [];

  app.render = () => {
    if (!app.dirty) return;
    app.dirty = false;
    const { time } = app.clock;
    app.stage.draw(time);
    app.plots.draw(time);
    app.readings = app.plots.read(time);
    app.events.show(time);
    refreshControls();
    app.drawn.forEach((each) => each(app));
  };
  new ResizeObserver(app.changed).observe(document.body);
  new ResizeObserver(app.changed).observe(app.stage.canvas);
  // On a phone the controls lie over what is behind them: they leave with the animation.
  const past = ([entry]) => document.body.classList.toggle("past", !entry.isIntersecting);
  new IntersectionObserver(past, { rootMargin: "0px 0px -60% 0px" }).observe(byId("film"));
  let before = null;
  const frame = (now) => {
    // A tab that was in the background does not jump.
    if (before !== null) app.clock.pass(Math.min((now - before) / 1000, 0.1));
    before = now;
    app.render();
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
  return app;
}

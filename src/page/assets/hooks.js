// What a test may look at, and the controls as functions. Nothing here changes the samples.
function forTests(app) {
  const { clock, stage, film } = app;
  const state = () => {
    app.render();
    const [from, to] = app.range();
    return {
      time_s: clock.time,
      playing: clock.playing,
      auto: clock.auto,
      speed: clock.speed,
      window_s: [from, to],
      letters: stage.letters,
      view: { centre_m: [...stage.camera.centre], px_per_m: stage.camera.scale, follow: stage.camera.follow },
      runs: stage.drawn.map(({ run, place, bodies, contacts, arrows }) => ({
        label: run.label,
        sample: place.i,
        bodies,
        contacts,
        arrows,
        readings: app.readings[run.index],
      })),
    };
  };
  return Object.freeze({
    state,
    span_s: Object.freeze([film.start, film.end]),
    play: () => clock.play(),
    pause: app.pause,
    seek: app.seek,
    step: app.step,
    jump: app.jump,
    setSpeed: (speed) => app.setNotch(Math.round(3 * Math.log10(speed / SLOWEST))),
    setAuto: app.setAuto,
    setArrows: app.setArrows,
    toggleLetters: app.toggleLetters,
    show: app.show,
    follow: app.follow,
    zoom: app.zoom,
    fit: app.fit,
    window: app.window,
    theme: app.theme,
  });
}

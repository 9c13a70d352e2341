// The list of events and the way from one to the next.

class Events {
  constructor(film, holder, seek) {
    Object.assign(this, { film, holder, seek });
    this.renew();
  }

  // The list of the film as it is now.
  renew() {
    const { film, holder, seek } = this;
    holder.replaceChildren();
    this.rows = film.events.map((event) => {
      const figure = event.figure === null ? "" : withUnit(event.figure, event.unit, 4);
      const row = element(
        "button",
        { type: "button", class: "event" },
        strokeSample(event.run),
        element("span", {}, timeText(event.time_s, film.unit)),
        element("span", { class: "what" }, `${event.place}: ${event.kind}`),
        element("span", { class: "figure soft" }, figure),
      );
      if (film.runs.length > 1) row.title = event.run.label;
      row.setAttribute("aria-label", `${event.run.label}, ${timeText(event.time_s, film.unit)}, ${event.place}: ${event.kind} ${figure}`);
      row.addEventListener("click", () => seek(event.time_s));
      holder.append(row);
      return row;
    });
    if (film.events.length === 0) holder.append(element("p", { class: "none soft" }, "Nothing touches in this run."));
    this.current = -1;
  }

  // The next event of a shown run, forth (1) or back (−1); `null` where there is none.
  next(time, way) {
    const shown = this.film.events.filter((event) => event.run.visible);
    const found = way > 0 ? shown.find((event) => event.time_s > time) : shown.findLast((event) => event.time_s < time);
    return found ?? null;
  }

  nearest(time) {
    let best = null;
    for (const event of this.film.events) {
      if (event.run.visible && (best === null || Math.abs(event.time_s - time) < Math.abs(best.time_s - time))) best = event;
    }
    return best;
  }

  // Marks the last event up to now, and brings it into view within the list.
  show(time) {
    const events = this.film.events;
    let current = -1;
    while (current + 1 < events.length && events[current + 1].time_s <= time) current++;
    if (current === this.current) return;
    this.rows[this.current]?.removeAttribute("aria-current");
    this.current = current;
    const row = this.rows[current];
    if (!row) return;
    row.setAttribute("aria-current", "true");
    const [top, bottom] = [row.offsetTop, row.offsetTop + row.offsetHeight];
    const list = this.holder;
    if (top < list.scrollTop) list.scrollTop = top;
    else if (bottom > list.scrollTop + list.clientHeight) list.scrollTop = bottom - list.clientHeight;
  }
}

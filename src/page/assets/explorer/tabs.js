// Panels, one shown at a time: plots, figures, map, …; the variables too where there is no column for them.

function tabs(list, changed) {
  const buttons = [...list.querySelectorAll("[role='tab']")];
  const there = () => buttons.filter((each) => each.offsetWidth > 0);
  let chosen = null;
  const show = (button, focus) => {
    if (!there().includes(button)) return;
    chosen = button;
    for (const each of buttons) {
      each.setAttribute("aria-selected", each === chosen);
      each.tabIndex = each === chosen ? 0 : -1;
      byId(each.getAttribute("aria-controls")).hidden = each !== chosen;
    }
    if (focus) button.focus();
    changed();
  };
  // The window has become so wide that the tab is gone.
  const kept = () => there().includes(chosen) || show(there()[0]);
  addEventListener("resize", kept);
  buttons.forEach((button) => {
    button.addEventListener("click", () => show(button));
    button.addEventListener("keydown", (event) => {
      const all = there();
      const index = all.indexOf(button);
      const to = { ArrowLeft: index - 1, ArrowRight: index + 1, Home: 0, End: all.length - 1 }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      show(all.at(to % all.length), true);
    });
  });
  return {
    kept,
    shown: () => chosen?.getAttribute("aria-controls"),
    show: (id) => show(buttons.find((each) => each.getAttribute("aria-controls") === id)),
  };
}

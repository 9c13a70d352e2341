// Panels of which one is shown: plots, figures, map, …

function tabs(list, changed) {
  const buttons = [...list.querySelectorAll("[role='tab']")];
  const show = (button, focus) => {
    for (const each of buttons) {
      const chosen = each === button;
      each.setAttribute("aria-selected", chosen);
      each.tabIndex = chosen ? 0 : -1;
      byId(each.getAttribute("aria-controls")).hidden = !chosen;
    }
    if (focus) button.focus();
    changed();
  };
  buttons.forEach((button, index) => {
    button.addEventListener("click", () => show(button));
    button.addEventListener("keydown", (event) => {
      const to = { ArrowLeft: index - 1, ArrowRight: index + 1, Home: 0, End: buttons.length - 1 }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      show(buttons.at(to % buttons.length), true);
    });
  });
  return {
    shown: () => buttons.find((each) => each.getAttribute("aria-selected") === "true").getAttribute("aria-controls"),
    show: (id) => show(buttons.find((each) => each.getAttribute("aria-controls") === id)),
  };
}

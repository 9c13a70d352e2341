// Tabs of panels; the fields are a tab on screens without a column for them.

function createTabs(list, onChange) {
  const buttons = [...list.querySelectorAll("[role='tab']")];
  const visibleButtons = () => buttons.filter((tab) => tab.offsetWidth > 0);
  let selected = null;
  const show = (button, focus) => {
    if (!visibleButtons().includes(button)) return;
    selected = button;
    for (const tab of buttons) {
      tab.setAttribute("aria-selected", tab === selected);
      tab.tabIndex = tab === selected ? 0 : -1;
      byId(tab.getAttribute("aria-controls")).hidden = tab !== selected;
    }
    if (focus) button.focus();
    onChange();
  };
  // Selects another tab if a wider window has hidden the present one.
  const ensureVisibleTab = () => visibleButtons().includes(selected) || show(visibleButtons()[0]);
  addEventListener("resize", ensureVisibleTab);
  buttons.forEach((button) => {
    button.addEventListener("click", () => show(button));
    button.addEventListener("keydown", (event) => {
      const visible = visibleButtons();
      const index = visible.indexOf(button);
      const targetIndex = { ArrowLeft: index - 1, ArrowRight: index + 1, Home: 0, End: visible.length - 1 }[event.key];
      if (targetIndex === undefined) return;
      event.preventDefault();
      show(visible.at(targetIndex % visible.length), true);
    });
  });
  return {
    ensureVisibleTab,
    shown: () => selected?.getAttribute("aria-controls"),
    show: (id) => show(buttons.find((tab) => tab.getAttribute("aria-controls") === id)),
  };
}

(() => {
"use strict";
const dark = matchMedia("(prefers-color-scheme: dark)");
const button = document.getElementById("theme");
const show = (name) => { document.documentElement.dataset.theme = name; };
show(dark.matches ? "dark" : "light");
dark.addEventListener("change", () => show(dark.matches ? "dark" : "light"));
button.hidden = false;
button.addEventListener("click", () => show(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
})();

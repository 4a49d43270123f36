// Dark or light colours: the system's, until the page's button changes them.
// The browser keeps that choice.

import { drawSamples } from "#player/legend.js";

const KEPT = "worldgen-theme"; // key in the browser's storage

function setTheme(theme, button, changed) {
  document.documentElement.dataset.theme = theme;
  button.textContent = theme === "dark" ? "Light" : "Dark";
  button.setAttribute("aria-label", theme === "dark" ? "Use light colours" : "Use dark colours");
  drawSamples(document);
  changed();
}

// Returns the stored choice, or an empty string if the browser has not stored one.
function keptTheme() {
  try {
    return localStorage.getItem(KEPT) ?? "";
  } catch {
    return "";
  }
}

function keepTheme(theme, system) {
  try {
    if (theme === system) localStorage.removeItem(KEPT);
    else localStorage.setItem(KEPT, theme);
  } catch {
    // after a reload, the page follows the system
  }
}

/**
 * Follows the system until the button is used. `changed` redraws the canvases.
 * @param {HTMLElement} button
 * @param {() => void} changed
 */
export function followSystem(button, changed) {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const system = () => (dark.matches ? "dark" : "light");
  const other = () => (document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  setTheme(keptTheme() || system(), button, changed);
  dark.addEventListener("change", () => setTheme(system(), button, changed));
  button.addEventListener("click", () => {
    setTheme(other(), button, changed);
    keepTheme(other() === "dark" ? "light" : "dark", system());
  });
}

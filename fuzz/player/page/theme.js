// Dark or light colours: those of the system, until the page's button changes them.

function setTheme(theme, button, changed) {
  document.documentElement.dataset.theme = theme;
  button.textContent = theme === "dark" ? "Light" : "Dark";
  button.setAttribute("aria-label", theme === "dark" ? "Use light colours" : "Use dark colours");
  changed();
}

/**
 * Follows the system until the button is used. `changed` redraws the canvases.
 * @param {HTMLElement} button
 * @param {() => void} changed
 */
export function followSystem(button, changed) {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const follow = () => setTheme(dark.matches ? "dark" : "light", button, changed);
  const other = () => (document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  follow();
  dark.addEventListener("change", follow);
  button.addEventListener("click", () => setTheme(other(), button, changed));
}

// Dark or light: as the system has it, until the page's button says otherwise.

function setTheme(theme, button, changed) {
  document.documentElement.dataset.theme = theme;
  button.textContent = theme === "dark" ? "Light" : "Dark";
  button.setAttribute("aria-label", theme === "dark" ? "Use light colours" : "Use dark colours");
  changed();
}

/**
 * Follows the system; the button changes over. `changed` draws again what is drawn on canvases.
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

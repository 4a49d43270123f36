// Copies texts to the clipboard.

import { el, say } from "#player/dom.js";

/**
 * Copies a text and confirms that on the button; if the browser does not allow it, shows the text
 * for manual copying.
 * @param {HTMLElement} button
 * @param {string} text
 * @returns {Promise<void>}
 */
export async function copied(button, text) {
  const words = button.textContent;
  try {
    await navigator.clipboard.writeText(text);
    button.textContent = "Copied";
    say(`Copied: ${text.split("\n")[0]}`);
    setTimeout(() => (button.textContent = words), 1500);
  } catch {
    const shown = el("textarea", { readonly: true, rows: 6, "aria-label": words, class: "by-hand" });
    shown.value = text;
    const actions = button.closest(".actions");
    if (actions?.nextElementSibling?.matches(".by-hand")) actions.nextElementSibling.remove();
    actions?.after(shown);
    shown.select();
  }
}

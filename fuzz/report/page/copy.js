// Buttons that copy a text.

import { el, say } from "#player/dom.js";

const SHOWN = 1500; // ms for which the button confirms what it did

/**
 * Returns a button that copies a text, or reports that it could not.
 * @param {string} words
 * @param {() => string | Promise<string>} text
 * @returns {HTMLButtonElement}
 */
export function copyButton(words, text) {
  const button = el("button", { type: "button" }, words);
  button.addEventListener("click", async () => {
    button.textContent = (await copied(await text())) ? "Copied" : "Not copied";
    say(button.textContent);
    setTimeout(() => {
      button.textContent = words;
    }, SHOWN);
  });
  return button;
}

// A page opened from disk may not use the clipboard, so a hidden text area does the copying.
async function copied(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = el("textarea", { readonly: true, class: "hidden" }, text);
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    return done;
  }
}

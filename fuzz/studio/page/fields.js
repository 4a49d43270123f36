// Form fields that panels share.

import { choice, el } from "/player/dom.js";

let count = 0;

/** A label above a field. */
export function labelled(words, input, { unit = "", help = "" } = {}) {
  count += 1;
  input.id ||= `field-${count}`;
  const note = help ? el("small", { id: `${input.id}-help`, class: "quiet" }, help) : null;
  if (note) input.setAttribute("aria-describedby", note.id);
  return el(
    "div",
    { class: "labelled" },
    el("label", { for: input.id }, words, unit ? el("span", { class: "quiet" }, ` ${unit}`) : null),
    input,
    note,
  );
}

export function number(value, change, { low = null, high = null, step = "any" } = {}) {
  return el("input", {
    type: "number",
    value,
    min: low,
    max: high,
    step,
    onchange: (event) => {
      const given = event.target.valueAsNumber;
      if (Number.isFinite(given)) change(given);
    },
  });
}

/** A field for a parameter as the server declares it: { name, default, kind, choices, low, high }. */
export function parameterField(parameter, value, change) {
  const { kind, choices, low, high } = parameter;
  if (kind === "bool") {
    return el("input", { type: "checkbox", checked: value, onchange: (event) => change(event.target.checked) });
  }
  if (choices.length > 0) {
    return choice(
      choices.map((word) => [word, word]),
      value,
      (event) => change(event.target.value),
    );
  }
  if (kind === "str") return el("input", { type: "text", value, onchange: (event) => change(event.target.value) });
  return number(value, change, { low, high, step: kind === "int" ? 1 : "any" });
}

export function words(name) {
  return name.replaceAll("_", " ").replace(/^./, (letter) => letter.toUpperCase());
}

/** An address of bytes that the browser keeps as a file. */
export function download(name, base64) {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const address = URL.createObjectURL(new Blob([bytes]));
  const link = el("a", { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

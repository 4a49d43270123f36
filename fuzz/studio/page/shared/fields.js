// Form fields that panels share.

import { choice, el } from "#player/dom.js";
import { Refused } from "#studio/shared/refusals.js";

let count = 0;

/**
 * Makes a label above a field.
 * @param {string} words
 * @param {HTMLElement} input
 * @param {{unit?: string, help?: string}} [more]
 * @returns {HTMLElement}
 */
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

/**
 * Makes a list of motion models by name, with a description of the chosen one below it.
 * @param {MotionMessage[]} motions
 * @param {string} chosen
 * @param {(name: string) => void} change
 * @returns {{element: HTMLElement, show: (name: string) => void}}
 */
export function motionField(motions, chosen, change) {
  const list = choice(
    motions.map(({ name }) => [name, name]),
    chosen,
    (event) => change(event.target.value),
  );
  const element = labelled("Motion model", list, { help: " " });
  const show = (name) => {
    list.value = name;
    const note = element.querySelector("small");
    if (note) note.textContent = motions.find((one) => one.name === name)?.about ?? "";
  };
  return { element, show };
}

/**
 * @param {number | string} value
 * @param {(value: number) => void} change
 * @param {{low?: number | null, high?: number | null, step?: number | string}} [bounds]
 * @returns {HTMLInputElement}
 */
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

/**
 * Makes a field for a parameter as the server declares it: { name, default, kind, choices, low,
 * high }, and `chosen`, a single number that is allowed in addition to the range.
 * @param {ParameterMessage} parameter
 * @param {any} value
 * @param {(value: any) => void} change
 * @returns {HTMLInputElement | HTMLSelectElement}
 */
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
  const { chosen } = parameter,
    // this number stands for "automatic", and is shown as an empty field
    isAutomatic = typeof chosen === "number";
  const input = number(value === chosen ? "" : value, change, { low, high, step: kind === "int" ? 1 : "any" });
  if (isAutomatic) {
    input.placeholder = "automatic";
    input.addEventListener("change", () => input.value === "" && !input.validity.badInput && change(chosen));
  }
  if (kind !== "int" && kind !== "float") return input;
  input.addEventListener("input", () => {
    const empty = isAutomatic && input.value === "" && !input.validity.badInput;
    input.setCustomValidity(empty ? "" : boundsFault(parameter, input.valueAsNumber));
    const fault = faultOf(input);
    input.setAttribute("aria-invalid", String(fault !== ""));
    input.closest(".labelled")?.classList.toggle("wrong", fault !== "");
  });
  return input;
}

/**
 * Returns what is wrong with a parameter's value; a browser's field cannot express all of its
 * bounds.
 * @param {ParameterMessage} parameter
 * @param {number} value
 * @returns {string}
 */
function boundsFault(parameter, value) {
  const { name, kind, low, high, above } = parameter;
  const fits =
    Number.isFinite(value) &&
    (kind === "float" || Number.isInteger(value)) &&
    (low === null || value > low || (value === low && !above)) &&
    (high === null || value <= high);
  if (fits) return "";
  const range = rangeWords(parameter);
  return `${words(name)} must be ${kind === "int" ? "a whole number" : "a number"}${range ? `, ${range}` : ""}.`;
}

/**
 * Describes a parameter's range, such as "1 to 20 cells", from its bounds; empty if it has none.
 * @param {ParameterMessage} parameter
 * @returns {string}
 */
export function rangeWords({ low, high, above, chosen, unit }) {
  const [from, to] = [low, high].map((end) => end?.toLocaleString("en-US"));
  const least = above ? `more than ${from}` : high === null ? `at least ${from}` : from;
  const range = low !== null && high !== null ? `${least} to ${to}` : low !== null ? least : high !== null ? `at most ${to}` : "";
  return [range, range && unit ? ` ${unit}` : "", typeof chosen === "number" ? `${range ? "; " : ""}empty for automatic` : ""].join("");
}

/**
 * Makes fields for the options of a format; the values that a user enters are stored in `given` by
 * name.
 * @param {ParameterMessage[]} options
 * @param {Record<string, any>} given
 * @returns {HTMLElement[]}
 */
export function optionFields(options, given) {
  return options.map((option) => {
    const input = parameterField(option, option.default, (value) => {
      given[option.name] = value;
    });
    return labelled(words(option.name), input, { help: [option.help.replaceAll("`", ""), rangeWords(option)].filter(Boolean).join(" ") });
  });
}

/**
 * Refuses an invalid value in one of these fields, and moves the focus there.
 * @param {HTMLElement} place
 */
export function checkOptions(place) {
  const bad = firstFault(place);
  if (!bad) return;
  bad.focus();
  throw new Refused(faultOf(bad));
}

/**
 * Returns the first invalid field in a part of the page.
 * @param {HTMLElement} place
 * @returns {HTMLInputElement | undefined}
 */
export function firstFault(place) {
  return [...place.querySelectorAll("input")].find((input) => faultOf(input) !== "");
}

/**
 * @param {string} name
 * @returns {string}
 */
export function words(name) {
  return name.replaceAll("_", " ").replace(/^./, (letter) => letter.toUpperCase());
}

/**
 * Return whether something is a form field that the user types into or ticks.
 * @param {EventTarget | null} target
 * @returns {target is HTMLInputElement}
 */
export function isField(target) {
  return /** @type {HTMLElement | null} */ (target)?.matches?.("input") ?? false;
}

/**
 * Returns whether a field's value is valid; if not, shows why below the field.
 * @param {HTMLInputElement} input
 * @returns {boolean}
 */
export function isGood(input) {
  const fault = faultOf(input);
  const place = input.closest(".labelled, .budget"),
    id = `${input.id}-fault`;
  document.getElementById(id)?.remove();
  const about = (input.getAttribute("aria-describedby") || "").split(" ").filter((one) => one && one !== id);
  if (fault) {
    place?.append(el("small", { id, class: "fault" }, fault));
    about.push(id);
  }
  if (fault) input.setAttribute("aria-invalid", "true");
  else input.removeAttribute("aria-invalid");
  if (about.length > 0) input.setAttribute("aria-describedby", about.join(" "));
  else input.removeAttribute("aria-describedby");
  return fault === "";
}

/**
 * Returns what is wrong with a field and what to enter instead; empty if nothing is.
 * @param {Pick<HTMLInputElement, "validity" | "min" | "max" | "step" | "title" |
 *   "validationMessage">} input
 * @returns {string}
 */
export function faultOf({ validity, min, max, step, title, validationMessage }) {
  if (validity.customError) return validationMessage;
  const kind = step === "any" ? "a number" : "a whole number";
  const from = min === "" ? "" : max === "" ? ` from ${min} on` : ` from ${min} to ${Number(max).toLocaleString("en-US")}`;
  if (validity.badInput || validity.rangeUnderflow || validity.rangeOverflow || validity.stepMismatch) return `Enter ${kind}${from}.`;
  return validity.valueMissing || validity.patternMismatch ? title : "";
}

/**
 * Marks the chosen one of several tabs. The Tab key stops there; arrow keys lead to the others.
 * @param {HTMLElement[]} tabs
 * @param {string} chosen
 */
export function showTabs(tabs, chosen) {
  for (const tab of tabs) {
    tab.setAttribute("aria-selected", String(tab.id === chosen));
    tab.tabIndex = tab.id === chosen ? 0 : -1;
  }
}

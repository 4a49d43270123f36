// Builds elements without parsing any markup: whatever a name contains is treated as text.

import { SIGNS } from "#player/picture/marks.js";

// The name of SVG's namespace comes from the browser, so that this file contains no web address.
const SVG = new DOMParser().parseFromString("<svg/>", "text/html").querySelector("svg")?.namespaceURI;

function make(space, tag, attributes, children) {
  const element = space ? document.createElementNS(space, tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return element;
}

/**
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag
 * @param {Record<string, any>} [attributes]
 * @param {...Content} children
 * @returns {HTMLElementTagNameMap[T]}
 */
export function el(tag, attributes = {}, ...children) {
  return make(null, tag, attributes, children);
}

/**
 * @template {keyof SVGElementTagNameMap} T
 * @param {T} tag
 * @param {Record<string, any>} [attributes]
 * @param {...Content} children
 * @returns {SVGElementTagNameMap[T]}
 */
export function svg(tag, attributes = {}, ...children) {
  return make(SVG, tag, attributes, children);
}

const ICONS = {
  play: "M4 2v12l10-6z",
  pause: "M3 2h4v12H3zM9 2h4v12H9z",
  back: "M10 2v12L3 8zM11 2h2v12h-2z",
  on: "M6 2v12l7-6zM3 2h2v12H3z",
  first: "M13 2v12L6 8zM3 2h2v12H3z",
  last: "M3 2v12l7-6zM11 2h2v12h-2z",
};

/**
 * @param {keyof typeof ICONS} name
 * @returns {SVGElement}
 */
export function icon(name) {
  return svg("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" }, svg("path", { d: ICONS[name] }));
}

/**
 * Makes a button with a keyboard shortcut.
 * @param {Content} content
 * @param {string} label
 * @param {string} key
 * @param {(event: MouseEvent) => void} act
 * @param {Record<string, any>} [more]
 * @returns {HTMLButtonElement}
 */
export function keyButton(content, label, key, act, more = {}) {
  const attributes = {
    type: "button",
    "aria-label": label,
    title: `${label} (${key})`,
    "aria-keyshortcuts": key,
    ...more,
  };
  return el("button", { ...attributes, onclick: act }, content);
}

/**
 * Replaces what an element holds; a control in it that has the focus keeps it, by its place among all.
 * @param {HTMLElement} element
 * @param {() => void} replace
 */
export function keepFocus(element, replace) {
  const controls = () => /** @type {HTMLElement[]} */ ([...element.querySelectorAll("button, input")]);
  const focused = controls().findIndex((one) => one === document.activeElement);
  replace();
  controls()[focused]?.focus({ preventScroll: true });
}

/**
 * Makes a drop-down list from pairs of value and text.
 * @param {(string | number)[][]} pairs
 * @param {string | number | null} chosen
 * @param {(event: any) => void} change
 * @returns {HTMLSelectElement}
 */
export function choice(pairs, chosen, change) {
  return el(
    "select",
    { onchange: change },
    pairs.map(([value, words]) => el("option", { value, selected: value === chosen }, words)),
  );
}

/**
 * Returns a robot's name with its options; a line may break before each option.
 * @param {string} name
 * @returns {Content[]}
 */
export function breakable(name) {
  return name.split(/(?=\+)/).flatMap((part, k) => (k > 0 ? [el("wbr"), part] : [part]));
}

/**
 * Returns a robot's name without the folders of its file: mine.py:Robot for /robots/mine.py:Robot.
 * @param {string} name
 * @returns {string}
 */
export function shortName(name) {
  return name.replace(/^(lib:)?[^:]*[/\\](?=[^/\\:]+\.(py|so):)/, "$1");
}

/**
 * @param {string} id
 * @returns {any}
 */
export function byId(id) {
  return document.getElementById(id);
}

/**
 * @param {number} number
 * @returns {string}
 */
export function grouped(number) {
  return Math.round(number).toLocaleString("en-US");
}

/**
 * @param {number} count
 * @param {string} one
 * @param {string} [many]
 * @returns {string}
 */
export function plural(count, one, many = `${one}s`) {
  return `${grouped(count)} ${count === 1 ? one : many}`;
}

/**
 * Returns round numbers from 0 up to the largest value, about as many as wanted.
 * @param {number} most
 * @param {number} [count]
 * @returns {number[]}
 */
export function ticks(most, count = 5) {
  const raw = most / count,
    power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((value) => value >= raw * 0.999) ?? 10 * power;
  return Array.from({ length: Math.floor(most / step + 1e-9) + 1 }, (_, k) => Number((k * step).toPrecision(12)));
}

/**
 * Announces a visible change to screen readers.
 * @param {string} text
 */
export function say(text) {
  byId("said").textContent = text;
}

/**
 * Returns the sign of a verdict.
 * @param {string} verdict
 * @returns {string}
 */
const signOf = (verdict) => ({ ...SIGNS, "still driving": "…", "stopped by you": "■" })[verdict] ?? "✗";

/**
 * Returns a cause in words: `stands still`. The reason of an error names places in code, so it
 * stays as it is: `crash-KeyError-mine.act-3f2a`.
 * @param {string} name
 * @returns {string}
 */
export function causeWords(name) {
  return /^[a-z-]+$/.test(name) ? name.replaceAll("-", " ") : name;
}

/**
 * Makes a sign for a verdict next to robots: a shape in the text's colour, because colours stand
 * for robots there.
 * @param {string} verdict
 * @returns {HTMLElement}
 */
export function verdictSign(verdict) {
  return el("span", { class: "verdict-mark", "aria-hidden": "true" }, signOf(verdict));
}

/**
 * @param {string} verdict
 * @returns {HTMLElement}
 */
export function verdictDot(verdict) {
  return el("span", { class: "dot", "data-verdict": verdict, "aria-hidden": "true" });
}

// Returns what to say of a failure that shrinking has not finished; nothing if it has.
/**
 * @param {string} shrinking
 * @returns {string}
 */
export function unfinished(shrinking) {
  if (shrinking === "done") return "";
  return shrinking === "cut short" ? "shrinking was cut short" : "as found, not shrunk";
}

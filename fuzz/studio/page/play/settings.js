// The options of a motion model under headings, one of which is open at a time: behaviours,
// sensor, faults, forces.

import { el } from "#player/dom.js";
import { isGood, labelled, parameterField, words } from "#studio/shared/fields.js";

const DEGREES = { rad: "°", "rad/s": "°/s" }; // the page shows angles in degrees

/**
 * Makes the settings; `change` is called whenever one of them changes.
 * @param {() => void} change
 * @returns {any}
 */
export function makeSettings(change) {
  const settings = { values: {}, change, options: [], open: "", buttons: {}, groups: {} };
  const element = el("div", { class: "settings" });
  return {
    element,
    /* Shows options; `values` contains the changed ones by name and is kept up to date. */
    offer: (options, values) => offer(Object.assign(settings, { options, values }), element),
    open: (heading) => open(settings, heading || firstHeading(settings)),
    headingOf: (input) => Object.keys(settings.groups).find((heading) => settings.groups[heading].contains(input)),
  };
}

// The behaviours' heading, to which Ctrl+B leads, if these robots have behaviours.
function firstHeading(settings) {
  return settings.groups.Behaviours ? "Behaviours" : Object.keys(settings.groups)[0];
}

function offer(settings, element) {
  const { options } = settings;
  const headings = [...new Set(options.map(({ group }) => group))];
  if (!headings.includes(settings.open)) settings.open = "";
  settings.buttons = Object.fromEntries(headings.map((heading) => [heading, button(settings, heading)]));
  settings.groups = Object.fromEntries(headings.map((heading) => [heading, group(settings, heading)]));
  element.replaceChildren(
    el("div", { class: "headings", role: "group", "aria-label": "Settings of the robots" }, Object.values(settings.buttons)),
    ...Object.values(settings.groups),
  );
  show(settings);
}

function button(settings, heading) {
  return el("button", { type: "button", "aria-controls": idOf(heading), onclick: () => toggle(settings, heading) });
}

const idOf = (heading) => `settings-${heading.toLowerCase().replaceAll(" ", "-")}`;

function group(settings, heading) {
  const own = settings.options.filter((option) => option.group === heading);
  return el("div", { class: "group", id: idOf(heading) }, own.map((option) => field(settings, option)));
}

function field(settings, option) {
  const { values, change } = settings,
    { name, unit } = option,
    angle = unit in DEGREES;
  const shown = angle ? { ...option, default: inDegrees(option.default), low: inDegrees(option.low), high: inDegrees(option.high) } : option;
  const given = values[name] ?? option.default;
  const input = parameterField(shown, angle ? inDegrees(given) : given, (typed) => {
    if (input.type === "number" && !isGood(input)) return change();
    if (typed === shown.default) delete values[name];
    else values[name] = angle ? Math.min(option.high, (typed * Math.PI) / 180) : typed;
    show(settings);
    change();
  });
  input.title = `+${name}${option.kind === "bool" ? "" : "=…"} after a robot's name`;
  const element = labelled(words(name), input, { unit: name.endsWith(unit) ? "" : DEGREES[unit] || unit, help: option.help.replaceAll("``", "") });
  if (option.kind === "bool") element.classList.add("switch");
  return element;
}

const inDegrees = (value) => (value === null ? null : Number(((value * 180) / Math.PI).toFixed(6)));

function toggle(settings, heading) {
  settings.open = settings.open === heading ? "" : heading;
  show(settings);
  if (settings.open) settings.groups[heading].scrollIntoView({ block: "nearest" });
}

/* Opens a heading and moves the focus to its first field. */
function open(settings, heading) {
  if (!heading) return;
  settings.open = heading;
  show(settings);
  settings.groups[heading].querySelector("input, select").focus();
}

// Shows which heading is open, and how many options under each differ from their defaults.
function show(settings) {
  for (const [heading, one] of Object.entries(settings.buttons)) {
    const changed = settings.options.filter(({ name, group }) => group === heading && name in settings.values).length;
    one.replaceChildren(heading, changed ? el("span", { class: "count" }, ` ${changed}`, el("span", { class: "away" }, " changed")) : "");
    one.setAttribute("aria-expanded", String(heading === settings.open));
    settings.groups[heading].hidden = heading !== settings.open;
  }
}

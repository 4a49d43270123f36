/* The parts of a browser that the pages' scripts need in Node: a tree of elements with events, a
   canvas that records what is drawn, storage, frames that a test asks for. It lays out nothing and
   judges nothing; whatever depends on how a browser shows a page, or on its rules for fields,
   is tested in a browser. */

const SVG = "the namespace of SVG";
const FLAGS = new Set(["checked", "disabled", "hidden", "open", "required"]);
const TEXTS = ["id", "type", "min", "max", "step", "title", "role", "name", "placeholder"];

// Calls listeners at once, so that an error in one fails the test that caused it.
class Listened {
  #acts = new Map();

  addEventListener(name, act) {
    if (!this.#acts.has(name)) this.#acts.set(name, new Set());
    this.#acts.get(name).add(act);
  }

  hear(event) {
    for (const act of [...(this.#acts.get(event.type) || [])]) act(event);
  }
}

export class Element_ extends Listened {
  parentElement = null;
  nodeType = 1;

  constructor(tag, namespaceURI = null) {
    super();
    Object.assign(this, { tagName: tag.toUpperCase(), namespaceURI, attributes: new Map(), childNodes: [], style: {}, clientWidth: 640, clientHeight: 480, tabIndex: 0 });
    this.dataset = new Proxy({}, {
      get: (_, name) => this.getAttribute(dataName(name)) ?? undefined,
      set: (_, name, value) => (this.setAttribute(dataName(name), value), true),
    });
    const classes = () => new Set((this.getAttribute("class") || "").split(/\s+/).filter(Boolean));
    const change = (act) => {
      const all = classes();
      act(all);
      this.setAttribute("class", [...all].join(" "));
    };
    this.classList = {
      contains: (name) => classes().has(name),
      add: (name) => change((all) => all.add(name)),
      remove: (name) => change((all) => all.delete(name)),
      toggle: (name, on = !classes().has(name)) => change((all) => (on ? all.add(name) : all.delete(name))),
    };
  }

  getAttribute(name) {
    return this.attributes.get(name) ?? null;
  }

  setAttribute(name, value) {
    this.attributes.set(name, String(value));
  }

  hasAttribute(name) {
    return this.attributes.has(name);
  }

  removeAttribute(name) {
    this.attributes.delete(name);
  }

  get children() {
    return this.childNodes.filter((one) => one instanceof Element_);
  }

  get className() {
    return this.getAttribute("class") || "";
  }

  set className(value) {
    this.setAttribute("class", value);
  }

  get textContent() {
    return this.childNodes.map((one) => (one instanceof Element_ ? one.textContent : one)).join("");
  }

  set textContent(text) {
    this.replaceChildren(text);
  }

  // The value of a list is its selected option's; that of a field is its text,
  // or else its attribute.
  get value() {
    if (this.tagName !== "SELECT") return this.typed ?? this.getAttribute("value") ?? "";
    const options = this.querySelectorAll("option");
    return this.typed ?? (options.find((one) => one.hasAttribute("selected")) || options[0])?.getAttribute("value") ?? "";
  }

  set value(text) {
    this.typed = String(text);
  }

  get valueAsNumber() {
    return this.value === "" ? NaN : Number(this.value);
  }

  append(...nodes) {
    for (const one of nodes) {
      const child = one instanceof Element_ ? one : String(one);
      if (child instanceof Element_) {
        child.remove();
        child.parentElement = this;
      }
      this.childNodes.push(child);
    }
  }

  replaceChildren(...nodes) {
    for (const one of this.children) one.parentElement = null;
    this.childNodes = [];
    this.append(...nodes);
  }

  remove() {
    const { parentElement: parent } = this;
    if (parent) parent.childNodes = parent.childNodes.filter((one) => one !== this);
    this.parentElement = null;
  }

  contains(other) {
    return other === this || Boolean(other?.parentElement && this.contains(other.parentElement));
  }

  closest(selector) {
    return this.matches(selector) ? this : (this.parentElement?.closest(selector) ?? null);
  }

  matches(selector) {
    return partsOf(selector, ",").some((one) => fits(this, partsOf(one.trim(), " ")));
  }

  querySelectorAll(selector) {
    return this.children.flatMap((one) => [...(one.matches(selector) ? [one] : []), ...one.querySelectorAll(selector)]);
  }

  querySelector(selector) {
    return this.querySelectorAll(selector)[0] ?? null;
  }

  // Events bubble up to the window, as in a browser.
  dispatchEvent(event) {
    if (event.target === null) Object.defineProperty(event, "target", { value: this });
    Object.defineProperty(event, "currentTarget", { value: this, configurable: true });
    this.hear(event);
    if (event.stopped) return;
    if (this.parentElement) this.parentElement.dispatchEvent(event);
    else heard.hear(event);
  }

  focus() {
    const before = document.activeElement;
    if (before === this) return;
    document.activeElement = this;
    before?.dispatchEvent(new Event_("blur", { silent: true }));
  }

  blur() {
    if (document.activeElement !== this) return;
    document.activeElement = document.body;
    this.dispatchEvent(new Event_("blur", { silent: true }));
  }

  click() {
    if (!this.disabled) this.dispatchEvent(new Event_("click"));
  }

  // The only rule for fields is the error that the page itself has set.
  get validity() {
    return { customError: Boolean(this.validationMessage) };
  }

  setCustomValidity(fault) {
    this.validationMessage = fault;
  }

  setPointerCapture() {}
  scrollIntoView() {}

  getBoundingClientRect() {
    return { left: 0, top: 0, right: this.clientWidth, bottom: this.clientHeight, width: this.clientWidth, height: this.clientHeight };
  }

  getContext() {
    this.context ||= new Context(this);
    return this.context;
  }
}

for (const name of TEXTS)
  Object.defineProperty(Element_.prototype, name, {
    get() {
      return this.getAttribute(name) ?? "";
    },
    set(value) {
      this.setAttribute(name, value);
    },
  });
for (const name of FLAGS)
  Object.defineProperty(Element_.prototype, name, {
    get() {
      return this.hasAttribute(name);
    },
    set(value) {
      if (value) this.setAttribute(name, "");
      else this.removeAttribute(name);
    },
  });

const dataName = (name) => `data-${name.replace(/[A-Z]/g, (letter) => `-${letter.toLowerCase()}`)}`;

// Splits a selector at separators outside brackets.
function partsOf(selector, separator) {
  const parts = [""];
  let depth = 0;
  for (const letter of selector) {
    depth += "([".includes(letter) - ")]".includes(letter);
    if (letter === separator && depth === 0) parts.push("");
    else parts[parts.length - 1] += letter;
  }
  return parts.map((one) => one.trim()).filter(Boolean);
}

function fits(element, compounds) {
  const [last, ...before] = [...compounds].reverse();
  if (!isOne(element, last)) return false;
  if (before.length === 0) return true;
  for (let above = element.parentElement; above; above = above.parentElement)
    if (fits(above, before.reverse())) return true;
  return false;
}

const SIMPLE = /^(?:([a-z][a-z0-9]*)|#([\w-]+)|\.([\w-]+)|\[([\w-]+)(?:="?([^\]"]*)"?)?\]|:not\(([^)]*)\)|:(checked|disabled|focus-visible))/i;

function isOne(element, compound) {
  let rest = compound;
  while (rest) {
    const found = SIMPLE.exec(rest);
    if (!found) throw new Error(`the stand-in knows no such selector: ${compound}`);
    const [whole, tag, id, name, attribute, value, other, state] = found;
    rest = rest.slice(whole.length);
    if (tag && element.tagName !== tag.toUpperCase()) return false;
    if (id && element.id !== id) return false;
    if (name && !element.classList.contains(name)) return false;
    if (attribute && (value === undefined ? !element.hasAttribute(attribute) : element.getAttribute(attribute) !== value)) return false;
    if (other && element.matches(other)) return false;
    if (state && !element[state]) return false;
  }
  return true;
}

class Event_ extends Event {
  constructor(type, { silent = false, ...parts } = {}) {
    super(type, { cancelable: true });
    Object.assign(this, parts);
    this.stopped = silent; // does not bubble
  }

  stopPropagation() {
    this.stopped = true;
  }
}

/* Makes a context that records what is drawn: `calls` has [name, ...arguments,
   settings] of each. */
export class Context {
  constructor(canvas) {
    Object.assign(this, { canvas, calls: [], fillStyle: "", strokeStyle: "", lineWidth: 1, globalAlpha: 1, font: "", saved: [], dash: [] });
    this.matrix = { a: 1 };
  }

  getTransform() {
    return this.matrix;
  }

  setTransform(a) {
    this.matrix = { a };
  }

  save() {
    this.saved.push([this.fillStyle, this.strokeStyle, this.lineWidth, this.globalAlpha, this.matrix]);
  }

  restore() {
    [this.fillStyle, this.strokeStyle, this.lineWidth, this.globalAlpha, this.matrix] = this.saved.pop();
  }

  setLineDash(dash) {
    this.dash = dash;
  }

  measureText(text) {
    return { width: 7 * String(text).length };
  }

  createImageData(width, height) {
    return { width, height, data: new Uint8ClampedArray(4 * width * height) };
  }

  getImageData(x, y, width, height) {
    return this.createImageData(width, height);
  }

  createRadialGradient() {
    return { addColorStop() {} };
  }

  /** Returns the arguments of all calls of a name. */
  of(name) {
    return this.calls.filter((call) => call.name === name);
  }
}

for (const name of ["beginPath", "closePath", "moveTo", "lineTo", "rect", "arc", "clip", "fill", "stroke", "fillRect", "strokeRect", "clearRect", "fillText", "strokeText", "drawImage", "putImageData"])
  Context.prototype[name] = function (...given) {
    const { fillStyle, strokeStyle, lineWidth, globalAlpha, dash } = this;
    this.calls.push({ name, given, fillStyle, strokeStyle, lineWidth, globalAlpha, dash });
  };

class Canvas extends Element_ {
  constructor(width, height) {
    super("canvas");
    Object.assign(this, { width, height });
  }
}

class Storage_ {
  constructor() {
    Object.defineProperty(this, "room", { value: Infinity, writable: true });
  }

  getItem(name) {
    return Object.hasOwn(this, name) ? this[name] : null;
  }

  setItem(name, text) {
    if (String(text).length > this.room) throw new Error("QuotaExceededError");
    this[name] = String(text);
  }

  removeItem(name) {
    delete this[name];
  }

  clear() {
    for (const name of Object.keys(this)) delete this[name];
  }
}

const heard = new Listened();
const frames = [];

/** Makes the page draw its next frame, at a time in ms. */
export function frame(now) {
  for (const act of frames.splice(0)) act(now);
}

/** Presses a key at the focus, or at an element; returns whether the page handled it. */
export function press(key, { at = document.activeElement, ...held } = {}) {
  const event = new Event_("keydown", { key, ctrlKey: false, shiftKey: false, altKey: false, metaKey: false, ...held });
  at.dispatchEvent(event);
  return event.defaultPrevented;
}

/** Performs a pointer action at a place in an element. */
export function point(element, type, [clientX, clientY], more = {}) {
  element.dispatchEvent(new Event_(type, { clientX, clientY, pointerId: 1, button: 0, buttons: 1, altKey: false, ...more }));
}

/** Types into a field and leaves it. */
export function type(field, text) {
  field.value = text;
  for (const name of ["input", "change"]) field.dispatchEvent(new Event_(name));
}

/** Ticks or clears a box. */
export function tick(box, on = true) {
  box.checked = on;
  box.dispatchEvent(new Event_("change"));
}

/** Returns the page's element with this id, created if missing. */
export function element(id, tag = "div") {
  const known = document.getElementById(id);
  if (known) return known;
  const made = new Element_(tag);
  made.id = id;
  document.body.append(made);
  return made;
}

const body = new Element_("body");
Object.assign(globalThis, {
  document: {
    body,
    activeElement: body,
    documentElement: new Element_("html"),
    createElement: (tag) => (tag === "canvas" ? new Canvas(300, 150) : new Element_(tag)),
    createElementNS: (space, tag) => new Element_(tag, space),
    getElementById: (id) => body.querySelector(`#${id}`),
    querySelectorAll: (selector) => body.querySelectorAll(selector),
  },
  DOMParser: class {
    parseFromString() {
      return { querySelector: () => ({ namespaceURI: SVG }) };
    }
  },
  OffscreenCanvas: Canvas,
  ImageData: class {
    constructor(width, height) {
      Object.assign(this, { width, height, data: new Uint8ClampedArray(4 * width * height) });
    }
  },
  window: { devicePixelRatio: 1 },
  innerWidth: 1280,
  innerHeight: 900,
  location: { host: "studio.test", search: "", hash: "", pathname: "/" },
  // a colour is its own name
  getComputedStyle: () => ({ getPropertyValue: (name) => name.slice(2) }),
  IntersectionObserver: class {
    observe() {}
    unobserve() {}
  },
  matchMedia: () => ({ matches: false, addEventListener() {} }),
  ResizeObserver: class {
    observe() {}
  },
  requestAnimationFrame: (act) => frames.push(act),
  cancelAnimationFrame: () => frames.splice(0),
  localStorage: new Storage_(),
  sessionStorage: new Storage_(),
  addEventListener: (name, act) => heard.addEventListener(name, act),
  removeEventListener: () => {},
  CSS: { escape: (text) => text },
});
element("said");

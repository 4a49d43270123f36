// Keeps unsaved drawings in the browser, one per tab, in case the page or the server ends.

import { messageOf, worldOf } from "#studio/shared/world_message.js";

const DRAFT = "worldgen-studio-draft-"; // followed by the tab's name
const TAB = "worldgen-studio-tab";
const OPENED = "worldgen-studio-opened";
const TAKEN = "taken"; // replaces a draft that another tab has taken over
const LARGEST = 4e6; // characters that every browser can store
const PATIENCE = 5; // attempts to get a lock, because the previous page may not have ended yet
const WAIT = 60; // ms

/* The drafts of this browser, as seen from this tab.
     key      of this tab's draft; "": nothing can be kept
     left     { key, at } of drafts whose tabs no longer existed when this one began, the newest first
     taken    the key of the one that this tab continues
     letGo    releases the lock on this tab's draft; null without a lock
     kept     the version of the model in the draft
     link     what a link to the draft that was found contains, if it was generated; else null */
/**
 * @type {{key: string, left: {key: string, at: number}[], taken: string, letGo: (() => void) |
 *   null, kept: number | null, link: Record<string, string> | null}}
 */
const state = { key: "", left: [], taken: "", letGo: null, kept: null, link: null };

/**
 * Finds the drawing that this tab had before it was reloaded, or else one left by a closed tab.
 * Returns null if neither exists.
 * @returns {Promise<EditedWorld | null>}
 */
export async function findDraft() {
  try {
    state.key = await claim();
    const live = await held();
    const kept = Object.keys(localStorage).filter((key) => key.startsWith(DRAFT) && !live.has(key));
    const others = kept.filter((key) => key !== state.key).map((key) => ({ key, at: timeOf(key) }));
    state.left = others.sort((a, b) => b.at - a.at);
    const own = read(state.key);
    state.taken = own ? "" : state.left[0]?.key || "";
    return own || read(state.taken);
  } catch {
    return null; // the browser stores nothing
  }
}

/**
 * Returns what a link to the draft that was found contains, if that is a generated world; else null.
 * @returns {Record<string, string> | null}
 */
export const linkOfDraft = () => state.link;

// Returns the key of this tab's draft, with its lock.
async function claim() {
  let name = sessionStorage.getItem(TAB);
  if (!name || !(await hold(DRAFT + name))) {
    name = `${Date.now().toString(36)}-${Math.random().toString(36).slice(2)}`;
    sessionStorage.setItem(TAB, name); // a new tab, or a duplicate of one, with the same name
    await hold(DRAFT + name);
  }
  return DRAFT + name;
}

// Holds a lock until the page ends or releases it; false if another page has it.
async function hold(key) {
  // not available on this connection: duplicated tabs share a draft
  if (!navigator.locks) return true;
  for (let k = 0; k < PATIENCE; k += 1) {
    const had = await new Promise((done) => {
      navigator.locks.request(key, { ifAvailable: true }, (lock) => {
        done(lock !== null);
        return lock ? new Promise((letGo) => (state.letGo = () => letGo(null))) : null;
      });
    });
    if (had) return true;
    await new Promise((done) => setTimeout(done, WAIT));
  }
  return false;
}

/**
 * Releases the draft when the server is lost, so that the tab opened by a restarted server may
 * continue the drawing.
 * @param {import("#player/edit/model.js").Model} model
 */
export function lendDraft(model) {
  if (!state.letGo) return; // already released, or this tab is still starting
  if (state.kept !== model.version) keepDraft(model);
  state.letGo();
  state.letGo = null;
}

/**
 * Takes the draft back when the server answers again; returns whether another tab has continued the
 * drawing in the meantime.
 * @param {import("#player/edit/model.js").Model} model
 * @returns {Promise<boolean>}
 */
export async function reclaimDraft(model) {
  if (state.key === "" || state.letGo || !navigator.locks) return false;
  try {
    const taken = isTaken(model);
    state.key = await claim();
    return taken;
  } catch {
    return false; // the browser stores nothing
  }
}

// Returns whether another tab has taken over exactly this drawing,
// so that it need not be kept twice.
function isTaken(model) {
  return model.unsaved && state.kept === model.version && localStorage.getItem(state.key) === TAKEN;
}

// Returns the keys of all open tabs.
async function held() {
  const locks = navigator.locks ? (await navigator.locks.query()).held : [];
  return new Set((locks ?? []).map(({ name }) => name).filter((name) => name !== state.key));
}

function read(key) {
  try {
    const { name, file, world, link } = JSON.parse(localStorage.getItem(key) ?? "null");
    const kept = worldOf(world, String(name || ""), file || null);
    if (!isWhole(kept)) return null;
    state.link = link ?? null;
    return kept;
  } catch {
    return null;
  }
}

// Returns whether a draft is complete, because another version of the page may have written it.
function isWhole({ width, height, start, target, cell_size: cell, robot_speed: speed, robot_radius: radius }) {
  const triple = (place) => Array.isArray(place) && place.length === 3 && place.every(Number.isFinite);
  const lengths = [cell, speed].every((value) => Number.isFinite(value) && value > 0) && Number.isFinite(radius);
  return triple(start) && triple(target) && lengths && Number.isInteger(width) && Number.isInteger(height);
}

function timeOf(key) {
  try {
    return JSON.parse(localStorage.getItem(key) ?? "null").at || 0;
  } catch {
    return 0;
  }
}

/**
 * Keeps the drawing; returns whether the browser has everything that is not saved.
 * @param {import("#player/edit/model.js").Model} model
 * @returns {boolean}
 */
export function keepDraft(model) {
  const { name, file } = model.world;
  try {
    sessionStorage.setItem(OPENED, model.unsaved ? "" : name);
    if (!model.unsaved) localStorage.removeItem(state.key);
    else if (state.key === "") return false;
    else if (!isTaken(model)) {
      const draft = { name, file, at: Date.now(), world: messageOf(model.world), link: model.link };
      let text = JSON.stringify(draft);
      if (text.length > LARGEST) text = JSON.stringify({ ...draft, world: { ...draft.world, others: [], source: null } });
      store(text);
      state.kept = model.version;
    }
    return true;
  } catch {
    // the browser stores nothing, or not that much: the page asks before the user leaves it
    return !model.unsaved;
  }
}

// If space runs out, removes drafts of closed tabs, oldest first. A tab that only lost its server
// has written its draft again since.
function store(text) {
  for (;;) {
    try {
      localStorage.setItem(state.key, text);
      return;
    } catch (error) {
      const oldest = state.left.pop();
      if (!oldest) throw error;
      if (timeOf(oldest.key) === oldest.at) localStorage.removeItem(oldest.key);
    }
  }
}

/**
 * Adopts the draft that was found as this tab's own.
 * @param {import("#player/edit/model.js").Model} model
 */
export function takeOver(model) {
  if (!state.taken || !keepDraft(model)) return;
  localStorage.setItem(state.taken, TAKEN);
  state.left = state.left.filter(({ key }) => key !== state.taken);
}

/**
 * Returns the file that was open when this tab was reloaded; empty if there was none.
 * @returns {string}
 */
export function openedBefore() {
  try {
    return sessionStorage.getItem(OPENED) || "";
  } catch {
    return "";
  }
}

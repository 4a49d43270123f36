// What is drawn and not saved is kept in the browser, for each tab by itself, in case the page or the server ends.

import { messageOf, worldOf } from "./model.js";

const DRAFT = "worldgen-studio-draft-"; // and the tab's name
const TAB = "worldgen-studio-tab";
const OPENED = "worldgen-studio-opened";
const TAKEN = "taken"; // stands where a draft was that another tab has taken over
const LARGEST = 4e6; // characters: what browsers keep at least
const PATIENCE = 5; // times that a lock is asked for: the page of before may be ending just now
const WAIT = 60; // ms

/* The drafts of this browser, seen from this tab.
     key      of this tab's draft; "": nothing can be kept
     left     { key, at } of drafts whose tabs were gone when this one began, the newest first
     taken    the key of the one of them that this tab goes on with
     letGo    gives up the lock on this tab's draft; null while it has none
     kept     the version of the model that the draft holds */
/** @type {{key: string, left: {key: string, at: number}[], taken: string, letGo: (() => void) | null, kept: number | null}} */
const state = { key: "", left: [], taken: "", letGo: null, kept: null };

/**
 * Finds what this tab has drawn before it was loaded anew, or else what a tab has left that is gone; null: nothing.
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
    return null; // a browser that keeps nothing
  }
}

// The key of this tab's draft, with its lock.
async function claim() {
  let name = sessionStorage.getItem(TAB);
  if (!name || !(await hold(DRAFT + name))) {
    name = `${Date.now().toString(36)}-${Math.random().toString(36).slice(2)}`;
    sessionStorage.setItem(TAB, name); // a new tab; one that was doubled has come with the other's name
    await hold(DRAFT + name);
  }
  return DRAFT + name;
}

// Holds a lock until the page ends or lets it go; false where another page has it.
async function hold(key) {
  if (!navigator.locks) return true; // not over this connection: a doubled tab shares the draft
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
 * The server is gone: the tab that its next start opens may go on with what is drawn here.
 * @param {import("./model.js").Model} model
 */
export function lendDraft(model) {
  if (!state.letGo) return; // it is lent already, or this tab is still beginning
  if (state.kept !== model.version) keepDraft(model);
  state.letGo();
  state.letGo = null;
}

/**
 * The server is there again; says whether another tab has gone on meanwhile with all that is drawn here.
 * @param {import("./model.js").Model} model
 * @returns {Promise<boolean>}
 */
export async function reclaimDraft(model) {
  if (state.key === "" || state.letGo || !navigator.locks) return false;
  try {
    const taken = isTaken(model);
    state.key = await claim();
    return taken;
  } catch {
    return false; // a browser that keeps nothing
  }
}

// Whether what is drawn is that which another tab has taken over: it is not kept twice.
function isTaken(model) {
  return model.unsaved && state.kept === model.version && localStorage.getItem(state.key) === TAKEN;
}

// The keys of all tabs that are there.
async function held() {
  const locks = navigator.locks ? (await navigator.locks.query()).held : [];
  return new Set((locks ?? []).map(({ name }) => name).filter((name) => name !== state.key));
}

function read(key) {
  try {
    const { name, file, world } = JSON.parse(localStorage.getItem(key) ?? "null");
    const kept = worldOf(world, String(name || ""), file || null);
    return isWhole(kept) ? kept : null;
  } catch {
    return null;
  }
}

// Whether a draft has all that is drawn: another version of the page may have kept it.
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
 * Keeps what is drawn; says whether the browser has all that is not saved.
 * @param {import("./model.js").Model} model
 * @returns {boolean}
 */
export function keepDraft(model) {
  const { name, file } = model.world;
  try {
    sessionStorage.setItem(OPENED, model.unsaved ? "" : name);
    if (!model.unsaved) localStorage.removeItem(state.key);
    else if (state.key === "") return false;
    else if (!isTaken(model)) {
      const draft = { name, file, at: Date.now(), world: messageOf(model.world) };
      let text = JSON.stringify(draft);
      if (text.length > LARGEST) text = JSON.stringify({ ...draft, world: { ...draft.world, source: null } });
      store(text);
      state.kept = model.version;
    }
    return true;
  } catch {
    return !model.unsaved; // a browser that keeps nothing, or not so much: the page asks before it is left
  }
}

// Where there is no room, what tabs have left that are gone makes some, the oldest first; a tab that was only without a
// server has kept its draft anew since.
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
 * What was found is this tab's own now.
 * @param {import("./model.js").Model} model
 */
export function takeOver(model) {
  if (!state.taken || !keepDraft(model)) return;
  localStorage.setItem(state.taken, TAKEN);
  state.left = state.left.filter(({ key }) => key !== state.taken);
}

/**
 * The file that was open when this tab was loaded anew; empty where there was none.
 * @returns {string}
 */
export function openedBefore() {
  try {
    return sessionStorage.getItem(OPENED) || "";
  } catch {
    return "";
  }
}

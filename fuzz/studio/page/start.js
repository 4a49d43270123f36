// The studio: everything that the pages share, which page is visible,
// and whether the server answers.

import { askToOpen } from "#studio/shared/asking.js";
import { byId, el, keyButton, say, shortName } from "#player/dom.js";
import { followSystem } from "#player/theme.js";
import { makeCampaign } from "#studio/campaign/campaign.js";
import { makeCompare } from "#studio/compare/compare.js";
import { exampleButtons } from "#studio/draw/examples.js";
import { Ended, makeConnection, shareToken, takeToken } from "#studio/shared/connection.js";
import { findDraft, keepDraft, lendDraft, linkOfDraft, openedBefore, reclaimDraft, takeOver } from "#studio/shared/drafts.js";
import { makeDraw } from "#studio/draw/draw.js";
import { listenToEdits, stillOffered } from "#studio/shared/edits.js";
import { isField } from "#studio/shared/fields.js";
import { openFile, saveAs } from "#studio/draw/files.js";
import { listen, showKeys } from "#studio/shared/keys.js";
import { Model, emptyWorld } from "#player/edit/model.js";
import { worldOf } from "#studio/shared/world_message.js";
import { makePlay } from "#studio/play/play.js";
import { listenToBoard } from "#player/edit/pointer.js";
import { makeProver } from "#studio/draw/proof.js";
import { linkTo, madeIn, madeOf, readLink } from "#studio/shared/links.js";
import { Refused, refusalWords } from "#studio/shared/refusals.js";
import { makeTour } from "#studio/shared/tour.js";

const PAGES = { draw: ["Draw", "1"], play: ["Play", "2"], campaign: ["Campaign", "3"], compare: ["Compare", "4"] };
/** @type {Given} */
const given = JSON.parse(byId("given").textContent);
const SIDE = 40; // cells of the initial world
const SLOW = 2000; // ms after which the page explains the delay

/** @type {Studio} */
const studio = {
  model: new Model(emptyWorld(SIDE, SIDE, given.world), () => changed()),
  connection: /** @type {any} */ (null), // made when the page begins
  folder: "", // the server's opened folder
  usual: given.world,
  limits: null,
  offered: null, // the choices that the server offers
  code: [], // the files whose code the server runs
  widest: null,
  draw: null,
  play: null,
  campaign: null,
  compare: null,
  askWidest: () => prove.widest(),
  say: (words) => say(words),
  page: () => (Object.hasOwn(PAGES, readLink(location.hash).page) ? readLink(location.hash).page : "draw"),
  go: (page) => {
    location.hash = page;
    route(); // now, because the next action may need the page before the browser reports the change
  },
  show,
  generate,
  showName,
  showLink,
  // cancels the current stroke first
  undo: () => studio.draw.cancel() || step("Undone", studio.model.undo()),
  redo: () => studio.draw.cancel() || step("Redone", studio.model.redo()),
  save,
  run: () => (studio.page() === "play" ? studio.play.run() : studio.go("play")),
};
const prove = makeProver(studio, setProof, setWidest);
let scheduled = 0;
let keeping = 0;
/** @type {Map<string, string>} */
const codeFiles = new Map(); // digest of each file of the user's code
let followed = false; // whether the link that the page was opened with has been followed
let refused = false; // whether the server refused the last attempt to save
let misled = false; // whether a message about the last link is visible

// Redraws everything after changes, at most once per frame.
function changed() {
  if (!studio.draw) return;
  studio.draw.board.proof = null;
  if (!scheduled)
    scheduled = requestAnimationFrame(() => {
      scheduled = 0;
      studio.draw.refresh();
      showName();
      if (studio.page() === "play") studio.play.begin(); // another world is there
    });
  studio.play?.changed();
  studio.compare?.changed();
  prove();
  studio.draw.senseSignal();
  clearTimeout(keeping);
  keeping = setTimeout(() => keepDraft(studio.model), 800);
}

function step(what, label) {
  if (label) say(`${what}: ${label}`);
}

function setProof(proof) {
  studio.draw.board.proof = proof;
  studio.draw.refresh();
}

function setWidest(widest) {
  if (studio.widest === widest) return;
  studio.widest = widest;
  studio.draw.refresh();
}

// Keeps the address up to date, as a link to what the page shows.
function showLink() {
  if (!followed) return; // the link that the page was opened with is still to be followed
  const page = studio.page();
  const own = { campaign: studio.campaign, compare: studio.compare }[page];
  const { world, link: made } = studio.model;
  const shown = made ?? { world: world.name };
  const shows = own ? own.link() : { ...shown, ...(page === "play" ? studio.play.link() : {}) };
  const link = linkTo(page, shows);
  if (link !== location.hash) history.replaceState(null, "", `${location.pathname}${link}`);
}

// Shows what a link names: the world with its robots, or the failure in its folder. Returns why it
// cannot be followed in full.
async function followLink() {
  const { page, shows } = readLink(location.hash);
  followed = true;
  if (misled) notice("");
  misled = false;
  if (page === "campaign") {
    studio.campaign.follow(shows);
    return [];
  }
  if (page === "compare") {
    studio.compare.follow(shows);
    return [];
  }
  const faults = [];
  try {
    const message = shows.family ? madeIn(shows) : null;
    if (message && !isShown(message)) await generate(message, `${message.family} ${message.seed}`);
    else if (shows.world && shows.world !== studio.model.world.name)
      await openFile(studio, { name: shows.world, world: /\.grid(\.gz)?$/.test(shows.world) });
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    if (error instanceof Refused) faults.push(error.message);
  }
  if (page !== "play") return faults;
  // now, because a failure's file names its own robot, and so does a link with robots
  faults.push(...studio.play.follow(shows));
  studio.play.run();
  return faults;
}

// Returns whether the page shows the unchanged world of a request to generate it.
function isShown(message) {
  const { link } = studio.model;
  return link !== null && linkTo("", link) === linkTo("", madeOf(message));
}

// Says why a link cannot be followed, until another one is, or another world is opened.
function mislead(faults) {
  if (faults.length === 0) return;
  misled = true;
  notice([byId("gone").dataset.words, ...faults].filter(Boolean).join(" "));
}

/**
 * Generates a world and shows it.
 * @param {{family: string, seed: string, parameters: object, difficulty?: number, where?: string}} message
 * @param {string} label
 * @param {(part: any) => void} [progress]
 * @returns {Promise<OpenedMessage>}
 */
async function generate(message, label, progress) {
  const answer = await askToOpen(studio.connection, "generate", message, progress);
  show(answer, "", label);
  const searched = message.difficulty !== undefined || message.where !== undefined;
  if (!searched) studio.model.markMade(madeOf(message));
  showLink();
  return answer;
}

// Shows the subject of the current page: the drawn world, or the folder whose failures are shown.
function showName() {
  const { unsaved, past, future, world } = studio.model;
  if (studio.page() === "campaign") {
    const { shown, running, stopping } = studio.campaign.name();
    byId("name").replaceChildren(shown, running ? el("span", { class: "quiet" }, ` · ${stopping ? "stopping" : "running"}`) : "");
    document.title = `${running && !stopping ? "▶ " : ""}${shown} - worldgen studio`;
    showLink();
    return;
  }
  byId("name").replaceChildren(
    world.name || "not saved yet",
    unsaved ? el("span", { class: "quiet" }, " · changed") : "",
  );
  document.title = `${unsaved ? "• " : ""}${world.name || "new world"} - worldgen studio`;
  showLink();
  byId("undo").disabled = past.length === 0;
  byId("redo").disabled = future.length === 0;
}

/** Replaces the drawn world with another one; undo brings it back. */
function show(answer, name, label) {
  const world = worldOf(answer.world, name, answer.file || null);
  studio.draw.cancel();
  studio.model.change(`open ${label}`, world);
  studio.draw.board.view = studio.draw.board.selection = null;
  if (name) studio.model.markSaved(name, world.source, world.file, studio.model.mark());
  if (answer.failure) studio.play.prefer(answer.failure);
  else studio.play.forget();
  if (misled) notice(""); // the message about the last link no longer applies
  misled = false;
  say(`Opened ${label}`);
}

async function save() {
  const { name } = studio.model.world;
  if (!name) {
    studio.go("draw");
    studio.draw.panel("files");
    byId("save-name").focus();
    return;
  }
  try {
    say(await saveAs(studio, null, name));
    if (refused) notice(""); // the message about the last attempt no longer applies
    refused = false;
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    notice(error.message);
    refused = true;
  }
}

let restored = 0; // changes of the board that brought an unsaved drawing back
let routed = ""; // the visible page

function route() {
  const page = studio.page();
  if (page === routed) return;
  routed = page;
  for (const name of Object.keys(PAGES)) byId(name).hidden = name !== page;
  for (const name of ["undo", "redo"]) byId(name).hidden = page !== "draw";
  byId("save-drawn").hidden = page === "campaign"; // it saves the drawing
  byId("tabs").replaceChildren(
    ...Object.entries(PAGES).map(([name, [words, key]]) =>
      el("a", { href: `#${name}`, "aria-current": name === page ? "page" : null, "aria-keyshortcuts": key }, words),
    ),
  );
  if (page !== "play") studio.play.pause();
  if (page === "play") studio.play.begin();
  else if (page === "campaign") studio.campaign.begin();
  else if (page === "compare") studio.compare.begin();
  else studio.draw.refresh();
  showName();
}

function notice(words, closable = true) {
  const told = byId("gone");
  if (told.dataset.words === words) return; // so that a screen reader reads it only once
  told.dataset.words = words;
  const close = el("button", { type: "button" }, "Close");
  close.addEventListener("click", () => notice(""));
  told.replaceChildren(el("span", {}, words), closable ? close : "");
  told.hidden = words === "";
}

// Called each time the connection is established; repeats requests that failed.
async function begun(begins) {
  const first = studio.offered === null;
  const moved = !first && begins.folder !== studio.folder;
  const told = moved ? [`The studio now has another folder open: ${begins.folder}. Files are saved there.`] : [];
  if (await reclaimDraft(studio.model)) told.push("Another tab has continued this drawing.");
  notice(told.join(" "));
  if (moved) studio.model.world.name = ""; // a file of the other folder
  studio.folder = begins.folder;
  studio.limits = begins.limits;
  studio.draw.refresh();
  listenToEdits(studio.connection, codeFiles, codeEdited, (files) => {
    studio.code = files;
    studio.play.changed();
    studio.compare.changed();
  });
  let faults = []; // of the link
  try {
    const offered = await hello(told);
    told.push(...unusable(offered.controllers));
    studio.offered = sameIfEqual(studio.offered, stillOffered(studio.offered, offered));
    const { shows } = readLink(location.hash);
    const file = shows.world || shows.family ? "" : openedBefore() || begins.file;
    // nothing but an earlier drawing of this tab has been put on the board in the meantime
    const untouched = () => studio.model.past.length === restored;
    if (first && (untouched() || ["campaign", "compare"].includes(studio.page()))) faults = await followLink();
    followed = true;
    if (first && file && restored === 0 && untouched())
      await openFile(studio, { name: file, world: /\.grid(\.gz)?$/.test(file) }, untouched);
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    if (error instanceof Refused) told.push(error.message);
  }
  if (told.length > 0) notice(told.join(" "));
  mislead(faults);
  studio.play.refresh();
  studio.campaign.refresh();
  studio.compare.refresh();
  changed();
  if (studio.page() === "play") studio.play.begin();
}

/**
 * Asks for the choices that the server offers, and shows which controller delays the answer.
 * @param {string[]} told
 * @returns {Promise<Offered>}
 */
async function hello(told) {
  let slow = 0;
  const loading = (words) => notice([...told, words].join(" "), false);
  try {
    const offered = await studio.connection.ask("hello", {}, (label) => {
      clearTimeout(slow);
      slow = setTimeout(() => loading(`Loading the controller ${label} …`), SLOW);
    });
    notice(told.join(" "));
    return offered;
  } finally {
    clearTimeout(slow);
  }
}

// Returns the former object if nothing has changed, so that the pages have nothing to do.
const sameIfEqual = (before, now) => (before && JSON.stringify(before) === JSON.stringify(now) ? before : now);

// Runs edited code immediately, and finds out which controllers can be loaded now.
async function codeEdited(files) {
  studio.play.edited(files);
  studio.campaign.edited(files);
  studio.compare.edited(files);
  try {
    const offered = await hello([]);
    notice(unusable(offered.controllers).join(" "));
    studio.offered = sameIfEqual(studio.offered, stillOffered(studio.offered, offered));
    studio.play.refresh();
    studio.campaign.refresh();
    studio.compare.refresh();
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
  }
}

// Describes the faults of controllers that were named at the start, because no list shows them.
function unusable(controllers) {
  const broken = controllers.filter(({ fault }) => fault !== null);
  return broken.map(({ name, fault }) => `${shortName(name)} cannot run. ${refusalWords(fault)}.`);
}

function lost(forbidden, why) {
  studio.draw.board.proof = null;
  lendDraft(studio.model);
  if (why) {
    notice(`${why} This page reconnects automatically.`, false);
    return;
  }
  notice(
    forbidden
      ? "The studio was restarted and no longer accepts this page. Open the address that it has printed in this tab; your drawing will be kept."
      : "The studio does not answer. Your drawing stays here. If the studio has ended, start it again and open the address that it prints; your drawing will be kept.",
    false,
  );
}

// The first click into a number's field selects its contents, so that typing replaces them. A panel
// may have moved when the button is released, so the element under the pointer does not matter
// then.
function selectNumbers() {
  /** @type {HTMLInputElement | null} */
  let fresh = null;
  document.addEventListener("pointerdown", ({ target }) => {
    fresh = isField(target) && target.type === "number" && target !== document.activeElement ? target : null;
  });
  document.addEventListener("click", () => {
    if (fresh && fresh === document.activeElement) fresh.select();
    fresh = null;
  });
}

// Makes the menu for first-time users: three worlds, and the tour.
function startMenu(tour) {
  const close = () => (menu.open = false);
  const take = el("button", { type: "button", id: "take-tour", onclick: () => (close(), tour.begin()) }, "One-minute tour");
  const list = el("div", { class: "menu" }, el("b", {}, "Example worlds"), exampleButtons(studio, (words) => (close(), say(words))), take);
  const menu = el("details", { class: "start-menu", id: "start-menu" }, el("summary", { class: "button" }, "Start here"), list);
  menu.addEventListener("keydown", ({ key }) => key === "Escape" && close());
  return menu;
}

function begin() {
  takeToken();
  byId("skip").addEventListener("click", toContent);
  selectNumbers();
  byId("tools").append(
    keyButton("↶", "Undo", "Control+Z", studio.undo, { id: "undo" }),
    keyButton("↷", "Redo", "Control+Y", studio.redo, { id: "redo" }),
    keyButton("Save", "Save", "Control+S", save, { id: "save-drawn" }),
    el("button", { type: "button", id: "theme", "aria-keyshortcuts": "d" }),
    keyButton(["Keys ", el("kbd", {}, "?")], "Keys", "?", showKeys),
  );
  const tour = makeTour(studio);
  document.body.append(tour.element);
  byId("tools").prepend(startMenu(tour));
  studio.draw = makeDraw(byId("draw"), studio);
  studio.play = makePlay(byId("play"), studio);
  studio.campaign = makeCampaign(byId("campaign"), studio);
  studio.compare = makeCompare(byId("compare"), studio);
  listenToBoard(studio.draw);
  followSystem(byId("theme"), () => {
    if (studio.draw.board.signal) studio.draw.board.signal.picture = null;
    studio.draw.redraw();
    studio.play.redraw();
    studio.campaign.redraw();
  });
  listen(studio);
  takeDrops();
  addEventListener("hashchange", ({ newURL }) => {
    // by now, showLink may have written a link into the address
    const { shows } = readLink(new URL(newURL).hash);
    // another link was put into the address
    if (followed && Object.keys(shows).length > 0) followLink().then(mislead);
    route();
  });
  addEventListener("beforeunload", (event) => {
    // too large to be kept, so the browser asks the user
    if (!keepDraft(studio.model)) event.preventDefault();
  });
  // Find the draft first: after sharing the token, other tabs may connect.
  studio.connection = makeConnection(given, begun, lost, goOn().finally(shareToken));
  route();
}

// Restores an unsaved drawing.
async function goOn() {
  const kept = await findDraft();
  if (!kept) return;
  studio.model.change("the unsaved drawing", kept);
  restored = studio.model.past.length;
  const link = linkOfDraft();
  if (link) studio.model.markMade(link);
  takeOver(studio.model);
}

// Moves the focus past the header to the contents of the page.
function toContent() {
  const first = { draw: "#board", play: "#play button, #play select", campaign: "#campaign select", compare: "#compare select" };
  document.querySelector(first[studio.page()]).focus();
}

function takeDrops() {
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    const files = [...(event.dataTransfer?.files ?? [])];
    if (files.length === 0) return;
    studio.go("draw"); // this page shows the world, or the reason why it cannot be read
    studio.draw.bring(files);
  });
}

begin();

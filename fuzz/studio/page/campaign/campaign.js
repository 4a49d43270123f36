// The campaign page: the chosen folder, the state of its campaign, and the failures in it.

import { askAbout } from "#studio/shared/asking.js";
import { byId, el, plural, say } from "#player/dom.js";
import { makeArchive } from "#studio/campaign/archive.js";
import { makeFailurePanel } from "#studio/campaign/failure.js";
import { makeForm } from "#studio/campaign/form.js";
import { makeStatus } from "#studio/campaign/status.js";
import { makeWall } from "#studio/campaign/wall.js";
import { Ended } from "#studio/shared/connection.js";
import { runsOneOf } from "#studio/shared/edits.js";
import { showTabs } from "#studio/shared/fields.js";
import { keep, keptOf } from "#studio/shared/kept.js";
import { Refused, refusalWords } from "#studio/shared/refusals.js";

const CHOSEN = "folder"; // key for the last chosen folder, in the browser's storage
const LOOKING = "Looking through the opened folder …";
const PANELS = { new: "New campaign", failure: "Failure", archive: "Archive" };

/**
 * Makes the page.
 * @param {HTMLElement} section
 * @param {Studio} studio
 * @returns {any}
 */
export function makeCampaign(section, studio) {
  /** @type {any} */
  const campaign = { studio, folder: null, shown: null, states: new Map(), folders: [], isListed: false, stamp: "", read: null, watched: null, stopping: "", beginning: new Set() };
  campaign.listed = new Promise((done) => (campaign.foundOut = done));
  const parts = {
    said: el("p", { class: "said", role: "status", id: "campaign-said" }),
    folders: el("select", { id: "campaign-folder", disabled: true, onchange: (event) => choose(campaign, event.target.value) }, el("option", {}, "…")),
  };
  Object.assign(campaign, { parts, select: (one) => select(campaign, one), trying: (act) => trying(campaign, act) });
  campaign.begin = (message, begins) => start(campaign, "begin", message, begins);
  campaign.goOn = (message) => goOn(campaign, message);
  campaign.halt = (folder) => halt(campaign, folder);
  campaign.stop = () => trying(campaign, () => stop(campaign));
  campaign.openFile = (file) => openInWall(campaign, file);
  campaign.reload = () => reloadWall(campaign);
  campaign.form = makeForm(campaign);
  campaign.status = makeStatus(campaign);
  campaign.wall = makeWall(campaign);
  campaign.failure = makeFailurePanel(campaign);
  campaign.archive = makeArchive(campaign);
  section.replaceChildren(
    el(
      "div",
      { class: "middle" },
      el("div", { class: "strip" }, el("label", { class: "field" }, "Folder", parts.folders), campaign.status.actions),
      parts.said,
      campaign.status.element,
      campaign.wall.element,
    ),
    sidePart(campaign),
  );
  openPanel(campaign, "new");
  parts.tabs.at(-1).hidden = true;
  campaign.wall.wait(LOOKING);
  return {
    begin: () => begin(campaign),
    refresh: () => refresh(campaign),
    name: () => nameOf(campaign),
    link: () => ({ folder: campaign.folder, failure: campaign.wanted || campaign.failure.name() }),
    follow: (shows) => follow(campaign, shows),
    edited: (files) => edited(campaign, files),
    redraw: () => (campaign.wall.redraw(), campaign.failure.redraw()),
  };
}

// Returns the display name of the chosen folder, and whether its campaign is running or being
// stopped.
function nameOf({ folder, states, stopping, isListed }) {
  if (folder === null) return { shown: isListed ? "no failures yet" : "looking …", running: false, stopping: false };
  const running = Boolean(states.get(folder)?.running);
  return { shown: folder || "the whole opened folder", running, stopping: running && stopping === folder };
}

function sidePart(campaign) {
  const { parts } = campaign;
  const bodies = { new: campaign.form.element, failure: campaign.failure.element, archive: campaign.archive.element };
  parts.tabs = Object.entries(PANELS).map(([name, words]) =>
    el(
      "button",
      { type: "button", role: "tab", id: `tab-${name}`, "aria-controls": `panel-${name}`, onclick: () => openPanel(campaign, name) },
      words,
    ),
  );
  parts.panels = Object.entries(bodies).map(([name, body]) =>
    el("div", { class: "panel", role: "tabpanel", id: `panel-${name}`, "aria-labelledby": `tab-${name}` }, body),
  );
  return el("div", { class: "side" }, el("div", { class: "panel-tabs", role: "tablist", "aria-label": "Panels" }, parts.tabs), parts.panels);
}

function openPanel({ parts, form }, name) {
  showTabs(parts.tabs, `tab-${name}`);
  for (const panel of parts.panels) panel.hidden = panel.id !== `panel-${name}`;
  if (name === "new") form.refresh();
}

// Runs an action that the server may refuse, and shows the result.
async function trying({ parts }, act) {
  try {
    const words = await act();
    parts.said.className = "said quiet";
    parts.said.textContent = words || "";
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    parts.said.className = error instanceof Refused ? "said bad" : "said quiet";
    parts.said.textContent = error instanceof Refused ? error.message : "";
  }
}

// Lists the campaigns after the page is opened or the connection is restored.
async function begin(campaign) {
  if (!campaign.studio.offered) return;
  await trying(campaign, () => list(campaign));
  campaign.foundOut(); // even after an error, because the form waits for it
  await look(campaign);
}

async function list(campaign) {
  const answer = await campaign.studio.connection.ask("campaigns");
  campaign.folders = [...answer.folders, ...answer.archives.map((name) => ({ name, worlds: null }))];
  campaign.states = new Map(answer.campaigns.map((state) => [state.folder, state]));
  const names = [...campaign.states.keys(), ...answer.folders.map(({ name }) => name), ...answer.archives];
  const running = answer.campaigns.find((state) => state.running);
  const gone = campaign.folder && !names.includes(campaign.folder) ? [`There is no folder ${campaign.folder} with failures.`] : [];
  if (campaign.folder === null || !names.includes(campaign.folder)) {
    const kept = keptOf(campaign.studio.folder, CHOSEN);
    campaign.folder = running ? running.folder : names.includes(kept) ? kept : (names[0] ?? null);
  }
  campaign.isListed = true;
  campaign.form.refresh();
  showFolders(campaign);
  return [...gone, ...answer.faults.map(refusalWords)].join(" ");
}

// Chooses the folder that a link names, and the failure once the folder has been read.
function follow(campaign, { folder, failure }) {
  campaign.wanted = failure ?? null;
  if (folder === undefined) return;
  campaign.folder = folder;
  keep(campaign.studio.folder, CHOSEN, folder);
}

function showFolders({ parts, folder, folders, states }) {
  const counts = new Map(folders.map(({ name, worlds }) => [name, worlds]));
  const option = (value, words) => el("option", { value, selected: value === folder }, words);
  const campaigns = [...states.values()].map((state) => {
    const worlds = `(${counts.get(state.folder) || 0})`;
    return option(state.folder, `${state.folder} ${state.running ? "· running" : worlds}`);
  });
  const others = folders
    .filter(({ name, worlds }) => !states.has(name) && worlds !== null)
    .map(({ name, worlds }) => option(name, `${name || "the whole opened folder"} (${worlds})`));
  const archives = folders.filter(({ worlds }) => worlds === null).map(({ name }) => option(name, name));
  const group = (label, options) => (options.length > 0 ? el("optgroup", { label }, options) : null);
  parts.folders.replaceChildren(...[group("Campaigns", campaigns), group("Other folders", others), group("Archives", archives)].filter(Boolean));
  parts.folders.disabled = campaigns.length + others.length + archives.length === 0;
  if (parts.folders.disabled) parts.folders.append(option("", "none yet"));
}

function choose(campaign, folder) {
  campaign.folder = folder;
  campaign.parts.said.textContent = "";
  keep(campaign.studio.folder, CHOSEN, folder);
  return look(campaign);
}

// Shows the chosen folder, and follows its campaign while that runs.
async function look(campaign) {
  const { folder } = campaign;
  campaign.stamp = campaign.states.get(folder)?.failures ?? "";
  campaign.watched = null;
  if (folder !== null && folder !== campaign.shown) {
    campaign.shown = folder;
    campaign.read = null;
    campaign.status.sizes(null);
    campaign.wall.wait(`Looking through ${folder || "the opened folder"} …`);
  }
  showState(campaign, campaign.states.get(campaign.folder) || null);
  await reloadWall(campaign);
  const running = [campaign.folder, ...campaign.states.keys()].find((name) => isBelow(name, campaign.folder) && campaign.states.get(name)?.running);
  if (running !== undefined) watch(campaign, running);
}

// Returns whether a folder equals another one or is below it; "" is the opened folder.
function isBelow(name, folder) {
  return name !== null && folder !== null && (name === folder || folder === "" || name.startsWith(`${folder}/`));
}

async function watch(campaign, folder) {
  if (campaign.watched === folder) return;
  campaign.watched = folder;
  try {
    const ended = await campaign.studio.connection.ask("watch", { folder }, (state) => take(campaign, state));
    if (ended) take(campaign, ended);
    say(`The campaign in ${folder} has ended: ${plural(ended?.worlds ?? 0, "world")}.`);
    if (campaign.watched === folder) {
      await trying(campaign, () => list(campaign));
      await reloadWall(campaign); // explains why, if there are no failures
    }
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
  }
  if (campaign.watched === folder) campaign.watched = null;
}

function take(campaign, state) {
  campaign.states.set(state.folder, state);
  if (!state.running && campaign.stopping === state.folder) campaign.stopping = "";
  if (state.folder === campaign.folder) showState(campaign, state);
  else if (state.folder !== campaign.watched) return;
  if (state.failures !== campaign.stamp) reloadWall(campaign, state.failures);
}

// Shows the state of the folder's campaign: numbers, behaviours, and the page's title. Null if
// there is no campaign.
function showState(campaign, state) {
  const { parts } = campaign;
  campaign.status.show(state);
  campaign.wall.refreshEmpty();
  campaign.archive.show(state?.archive);
  const tab = parts.tabs.at(-1);
  tab.hidden = !state?.archive;
  if (tab.hidden && tab.getAttribute("aria-selected") === "true") openPanel(campaign, "new");
  campaign.studio.showName();
}

async function reloadWall(campaign, stamp = campaign.stamp) {
  const { folder } = campaign;
  campaign.stamp = stamp;
  if (folder === null) {
    campaign.wall.show(null);
    return;
  }
  try {
    const reading = ({ done, of }) => campaign.wall.reading(done, of);
    const answer = await askAbout(campaign.studio.connection, () => `${campaign.folder} ${campaign.stamp}`, "failures", { folder }, reading);
    campaign.read = stamp;
    campaign.wall.show(answer);
    const wanted = answer.failures.find(({ name }) => name === campaign.wanted);
    if (wanted) campaign.wall.choose(wanted);
    else if (campaign.wanted) campaign.wall.refuse(`${campaign.wanted} is not in ${folder || "the opened folder"}.`);
    campaign.wanted = null;
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    if (error instanceof Refused) campaign.wall.refuse(error.message);
  }
}

// Begins or resumes a campaign and shows it; `begins` is called when it can be stopped.
async function start(campaign, kind, message, begins) {
  const isEmpty = campaign.folder === null;
  if (isEmpty) campaign.wall.wait("Beginning: the campaign's process is being started. Nothing has been tried yet.");
  const state = await campaign.studio.connection.ask(kind, message, begins).catch((error) => {
    if (isEmpty) campaign.wall.show(null);
    throw error;
  });
  campaign.folder = state.folder;
  keep(campaign.studio.folder, CHOSEN, state.folder);
  await list(campaign);
  take(campaign, state);
  look(campaign);
  return "";
}

// Resumes the chosen campaign.
async function goOn(campaign, message) {
  const { parts, folder, beginning } = campaign;
  const show = () => showState(campaign, campaign.states.get(campaign.folder) || null);
  const begins = () => {
    beginning.add(folder);
    show();
  };
  parts.said.className = "said quiet";
  parts.said.textContent = "Beginning …";
  try {
    await trying(campaign, () => start(campaign, "resume", { folder, ...message }, begins));
  } finally {
    beginning.delete(folder);
    show();
  }
}

// Stops a campaign that has not begun yet; the request that started it is answered accordingly.
async function halt(campaign, folder) {
  try {
    await campaign.studio.connection.ask("stop", { folder });
  } catch (error) {
    // the other request is answered anyway
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
  }
}

async function stop(campaign) {
  const { folder } = campaign;
  campaign.stopping = folder;
  showState(campaign, campaign.states.get(folder));
  try {
    const state = await campaign.studio.connection.ask("stop", { folder });
    if (state) take(campaign, state);
  } catch (error) {
    campaign.stopping = ""; // it continues, and can be stopped again
    showState(campaign, campaign.states.get(campaign.folder) || null);
    throw error;
  }
  return "";
}

// After an edit of a controller's code, its failures are run again, and its campaigns report that
// they run the old code.
function edited(campaign, files) {
  const runs = ({ controller }) => files.some(({ controllers }) => runsOneOf(controller, controllers));
  campaign.wall.forget(runs);
  campaign.failure.forget(runs);
  if (!byId("campaign").hidden) trying(campaign, () => list(campaign)).then(() => showState(campaign, campaign.states.get(campaign.folder) || null));
}

// Shows a file of the campaign's folder.
function openInWall(campaign, file) {
  const name = campaign.folder ? `${campaign.folder}/${file}` : file;
  campaign.wanted = name;
  return reloadWall(campaign);
}

function select(campaign, failure) {
  openPanel(campaign, "failure");
  campaign.failure.show(failure);
  campaign.studio.showLink();
}

function refresh(campaign) {
  campaign.watched = null;
  campaign.form.refresh();
  if (!byId("campaign").hidden) begin(campaign);
}

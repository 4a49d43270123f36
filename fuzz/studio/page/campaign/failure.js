// The chosen failure: what happened, and the actions for it.

import { causeWords, el, keepFocus, plural, unfinished, verdictDot } from "#player/dom.js";
import { legendOfCells } from "#player/legend.js";
import { drawSmall } from "#player/picture/map.js";
import { framesPart } from "#player/robots.js";
import { copied } from "#studio/shared/clipboard.js";
import { openFile } from "#studio/draw/files.js";
import { refusalWords } from "#studio/shared/refusals.js";

const OTHER_RUN = "This is not the run that was found: the controller's code has changed since. The file still records that run.";

/**
 * @param {any} campaign
 * @returns {any}
 */
export function makeFailurePanel(campaign) {
  const element = el("div", { id: "failure-panel" }, el("p", { class: "quiet" }, "Choose a picture."));
  /** @type {any} */
  const panel = { campaign, element, failure: null, look: null, canvas: null };
  return { element, name: () => panel.failure?.name ?? "", show: (failure) => show(panel, failure), follow: (failures) => follow(panel, failures), redraw: () => redraw(panel), forget: (which) => panel.failure && which(panel.failure) && show(panel, panel.failure) };
}

function redraw({ canvas, look }) {
  if (canvas && look) drawSmall(canvas, look, { touched: true, cells: true });
}

// Updates the panel after the failures were read again, if the chosen one was shrunk or marked in
// the meantime.
function follow(panel, failures) {
  const before = panel.failure,
    now = before && failures.find((one) => one.name === before.name);
  if (!now || (now.digest === before.digest && now.known === before.known)) return;
  keepFocus(panel.element, () => show(panel, now));
}

function show(panel, failure) {
  Object.assign(panel, { failure, look: null });
  panel.canvas = el("canvas", { class: "large", role: "img", "aria-label": "The world and the robot's path" });
  const words = el("p", {}, "…");
  const why = el("p", { id: "failure-cause" });
  const legend = el("div");
  const changed = el("p", { class: "notice", hidden: true }, OTHER_RUN);
  const facts = [
    ["Controller", `${failure.controller} under ${failure.motion}`],
    ["World", `${failure.width} x ${failure.height} cells, ${failure.solid} solid${failure.events ? `, ${plural(failure.events, "change")}` : ""}${unfinished(failure.shrinking) && `; ${unfinished(failure.shrinking)}`}`],
    ["First seen", failure.seen ? new Date(failure.seen * 1000).toLocaleString("sv") : "unknown"],
    ["File", failure.name],
  ];
  const rows = facts.map(([name, value]) => el("tr", {}, el("th", { scope: "row" }, name), el("td", {}, value)));
  panel.element.replaceChildren(
    el("h2", {}, verdictDot(failure.verdict), " ", causeWords(failure.group)),
    panel.canvas,
    legend,
    why,
    words,
    changed,
    actions(panel),
    el("table", { class: "numbers" }, el("tbody", {}, rows)),
  );
  panel.campaign.trying(async () => {
    const look = await panel.campaign.look(failure);
    if (panel.failure !== failure) return;
    panel.look = look;
    words.replaceChildren([look.error ? refusalWords(look.error) : look.words, ...look.notes].join("; "), framesPart(look.error?.frames) ?? "");
    const who = look.others?.length ? "The fleet" : "It";
    const more = [look.repeats && `It ${look.repeats}.`, look.why && `${who} ${look.why}.`].filter(Boolean);
    why.replaceChildren(...(look.sentence ? [el("b", {}, look.sentence), ` ${[look.advice, ...more].join(" ")}`] : []));
    legend.replaceChildren(look.error ? "" : legendOfCells(look));
    changed.hidden = look.error !== null || look.same !== false;
    redraw(panel);
  });
}

function actions(panel) {
  const { campaign, failure } = panel;
  const open = (page) => () =>
    campaign.trying(async () => {
      await openFile(campaign.studio, { name: failure.name, world: true });
      campaign.studio.go(page);
    });
  const button = (words, act, more = {}) => el("button", { type: "button", onclick: act, ...more }, words);
  const known = button(failure.known ? "No longer known" : "Mark as known", () => mark(panel), { id: "mark-known" });
  const copyLine = button("Copy replay line", (event) => campaign.trying(async () => copied(event.target, (await campaign.look(failure)).replay)));
  const copyTest = button("Copy test", (event) =>
    campaign.trying(async () => {
      const text = await campaign.studio.connection.ask("snippet", { name: failure.name });
      await copied(event.target, text);
    }),
  );
  return el(
    "div",
    { class: "actions" },
    button("Play", open("play"), { class: "main", id: "open-play" }),
    button("Edit", open("draw"), { id: "open-draw" }),
    known,
    copyLine,
    copyTest,
  );
}

function mark(panel) {
  const { campaign, failure } = panel;
  return campaign.trying(async () => {
    await campaign.studio.connection.ask("know", { name: failure.name, known: !failure.known });
    failure.known = !failure.known;
    if (panel.failure === failure) {
      show(panel, failure);
      panel.element.querySelector("#mark-known").focus();
    }
    await campaign.reload();
    return failure.known ? "A copy is in known/. Campaigns that you start here count this cause but keep no failures of it." : "";
  });
}

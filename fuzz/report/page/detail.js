// One failure: its replay, the world before and after shrinking, numbers,
// the command to replay it, its file.

import { buildPlayer, dragToMove } from "#player/controls.js";
import { byId, causeWords, el, grouped, plural, say, verdictDot } from "#player/dom.js";
import { drawSmall, pictureLabel } from "#player/picture/map.js";
import { besideIn } from "#player/pair.js";
import { copyButton } from "#report/copy.js";
import { insidePart, reactionsPart } from "#report/inside.js";

/**
 * @param {HTMLElement} section
 * @param {ReportFailure} failure
 * @param {Neighbours} neighbours
 * @returns {Detail}
 */
export function makeDetail(section, failure, neighbours) {
  const canvas = el("canvas", { id: "stage", role: "img" });
  const under = el("div"),
    stage = el("div", { class: "stage" }, canvas),
    pair = el("div", { class: "pair" });
  /** @type {{ player: Player | null, shown: DrawnFailure | null }} */
  const state = { player: null, shown: null };
  const load = (drawn, words, other = null) => {
    if (state.player) state.player.play(false);
    canvas.setAttribute("aria-label", `${words}. ${pictureLabel(drawn)}`);
    const beside = besideIn(stage, other, ["As found", "Shrunk"]);
    state.player = buildPlayer(canvas, under, { ...drawn, beside, says: sentencesOf(failure) }, state.player);
    state.shown = drawn;
    for (const button of pair.querySelectorAll("button")) {
      const which = button.dataset.which ?? "";
      const here = which === "both" ? beside !== null : !beside && failure[which] === drawn;
      button.setAttribute("aria-pressed", String(here));
    }
  };
  section.replaceChildren(
    topOf(failure, neighbours),
    el(
      "div",
      { class: "two" },
      el(
        "div",
        {},
        failure.now.world ? [stage, under] : tooLarge(failure.now),
        insidePart(failure.inside),
        reactionsPart(failure.reactions),
        pairPart(failure, pair, load),
      ),
      el("div", { class: "side" }, replayPart(failure), ...failure.groups.map(numbersPart)),
    ),
  );
  const drawPair = () => {
    for (const small of pair.querySelectorAll("canvas")) drawSmall(small, failure[small.dataset.which ?? ""], { touched: true, cells: true });
  };
  if (failure.now.world) load(failure.now, causeWords(failure.group));
  drawPair();
  dragToMove(stage, state);
  return {
    player: () => state.player,
    swap: () => {
      if (!state.player || !failure.before || !failure.before.world) return;
      if (state.shown === failure.now) load(failure.before, "As found");
      else load(failure.now, causeWords(failure.group));
    },
    redraw: () => {
      if (state.player) state.player.draw();
      drawPair();
    },
  };
}

function topOf(failure, [before, after]) {
  const step = (id, words, key) =>
    id
      ? el("a", { class: "button", href: `#${id}`, "aria-keyshortcuts": key }, words)
      : el("button", { type: "button", disabled: true }, words);
  return el(
    "div",
    {},
    el(
      "div",
      { class: "trace" },
      el("a", { class: "button", href: "#" }, "← All failures"),
      el("span", { class: "space" }),
      step(before, "Previous", "p"),
      step(after, "Next", "n"),
    ),
    el("h2", { tabindex: "-1" }, verdictDot(failure.verdict), " ", causeWords(failure.group)),
    el("p", { class: "words" }, `${failure.sentence || `${failure.words}.`} ${failure.advice}`),
    failure.repeats ? el("p", { class: "words why" }, `It ${failure.repeats}.`) : null,
    failure.why
      ? el("p", { class: "words why" }, `${failure.now.others?.length ? "The fleet" : "It"} ${failure.why}.`)
      : null,
    el("p", { class: "words quiet" }, `${failure.controller} under ${failure.motion}${failure.sentence ? `: ${failure.words}` : ""}.`),
    failure.shrinking === "done"
      ? null
      : el("p", { class: "notice" }, `${failure.shrinking === "cut short" ? "Shrinking this world was cut short" : "This world is as it was found"}, so some of its walls may not matter. worldgen shrink makes it small.`),
    failure.changed ? el("p", { class: "notice" }, `${failure.changed}.`) : null,
    failure.confirmed
      ? null
      : el("p", { class: "notice" }, `Running it again for this report did not confirm it: ${failure.reason}`),
  );
}

/**
 * Returns what happened, for a picture to keep.
 * @param {ReportFailure} failure
 * @returns {string[]}
 */
function sentencesOf(failure) {
  const why = failure.why ? `${failure.now.others?.length ? "The fleet" : "It"} ${failure.why}.` : "";
  const who = `${failure.controller} under ${failure.motion}: ${failure.words || failure.verdict}.`;
  return [`${failure.verdict}: ${causeWords(failure.group)}`, failure.sentence, failure.repeats ? `It ${failure.repeats}.` : "", why, who].filter(Boolean);
}

function tooLarge(drawn) {
  return el(
    "p",
    { class: "notice" },
    `The world of ${drawn.size} cells is too large to draw here. You can download its file and draw it with worldgen show.`,
  );
}

function pairPart(failure, pair, load) {
  if (!failure.before) return null;
  const figure = (drawn, which, title) =>
    el(
      "figure",
      {},
      drawn.world
        ? el("canvas", { role: "img", "data-which": which, "aria-label": `${title}: ${pictureLabel(drawn)}` })
        : tooLarge(drawn),
      el(
        "figcaption",
        {},
        el("span", {}, el("b", {}, title), el("br"), el("span", { class: "quiet" }, pairWords(drawn))),
        drawn.world && failure.now.world
          ? el(
              "button",
              { type: "button", "data-which": which, "aria-pressed": "false", onclick: () => load(drawn, title) },
              "Replay above",
            )
          : null,
      ),
    );
  pair.append(figure(failure.before, "before", "As found"), figure(failure.now, "now", "Shrunk"));
  const both = { type: "button", "data-which": "both", "aria-pressed": "false" };
  const together =
    failure.before.run && failure.before.world && failure.now.run && failure.now.world
      ? el("button", { ...both, onclick: () => load(failure.now, causeWords(failure.group), failure.before) }, "Play side by side")
      : null;
  if (together) pair.append(el("div", { class: "together" }, together));
  return el("div", { class: "part" }, el("h3", {}, "Before and after shrinking"), pair);
}

function pairWords(drawn) {
  const facts = [drawn.size, `${grouped(drawn.solid)} solid`];
  if (drawn.run) facts.push(plural(drawn.run.steps, "step"));
  return facts.join(", ");
}

function replayPart(failure) {
  const copy = el("button", { type: "button", id: "copy", onclick: () => copyText(failure.replay, copy) }, "Copy");
  const file = (drawn, words) =>
    el(
      "a",
      { class: "button", download: drawn.name, href: `data:application/octet-stream;base64,${drawn.file}` },
      words,
    );
  return el(
    "div",
    { class: "part" },
    el("h3", {}, "Replay it"),
    el("div", { class: "command" }, el("code", { id: "command" }, failure.replay), copy),
    el(
      "div",
      { class: "actions" },
      file(failure.now, `Download ${failure.now.name}`),
      failure.before ? file(failure.before, "Download as found") : null,
      copyButton("Copy test", () => failure.test),
    ),
    el("details", {}, el("summary", {}, "Test to paste"), el("pre", { class: "test" }, failure.test)),
  );
}

async function copyText(text, button) {
  try {
    await navigator.clipboard.writeText(text);
    button.textContent = "Copied";
  } catch {
    getSelection()?.selectAllChildren(byId("command"));
    button.textContent = document.execCommand("copy") ? "Copied" : "Selected";
  }
  say(`${button.textContent}: ${text}`);
  setTimeout(() => {
    button.textContent = "Copy";
  }, 1500);
}

function numbersPart([title, rows, isRaw]) {
  const body = el(
    "table",
    { class: "numbers" },
    el(
      "tbody",
      {},
      rows.map(([name, value]) => el("tr", {}, el("th", { scope: "row" }, name), el("td", {}, value))),
    ),
  );
  return el(
    "div",
    { class: "part" },
    isRaw ? el("details", {}, el("summary", {}, title), body) : [el("h3", {}, title), body],
  );
}

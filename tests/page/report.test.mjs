// The report's list of failures and its charts.

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { element, press, type } from "./stand_in.mjs";
import { makeAnswer } from "#report/answer.js";
import { makeCampaign } from "#report/charts.js";
import { makeOverview } from "#report/overview.js";

const CAUSES = { loop: "circles-an-obstacle", tunnel: "goes-through-a-wall", stalled: "wanders" };

function failure(id, verdict, solid, more = {}) {
  const now = { size: "9 x 3", solid, events: 0, run: { steps: 10 * solid, loop: null }, world: null };
  return { id, verdict, group: CAUSES[verdict], controller: "turn-right", motion: "swept", path: `${id}.grid`, strategy: "native", solid, place: 100 - solid, size: "9 x 3", met: 1, confirmed: true, cause: CAUSES[verdict], example: false, now, ...more };
}

const FAILURES = [failure("one", "loop", 20), failure("two", "tunnel", 8, { met: 30 }), failure("three", "tunnel", 12, { controller: "bug1" }), failure("four", "stalled", 9, { confirmed: false })];

let list;
beforeEach(() => {
  list = element("overview");
  list.replaceChildren();
  makeOverview(list, FAILURES);
});

const cards = () => list.querySelectorAll(".card").map((card) => card.id.slice(5));
const set = (words, value) => type(list.querySelectorAll(".field").find((one) => one.textContent.startsWith(words)).querySelector("select"), value);
const find = (words) => type(list.querySelector("#find"), words);
const headings = () => list.querySelectorAll("h2").map((one) => one.textContent);

test("failures are grouped by cause, each group with its number of failures", () => {
  assert.deepEqual(headings(), ["circles an obstacle 1", "goes through a wall 2", "wanders 1"]);
  set("Group by", "verdict");
  assert.deepEqual(headings(), ["loop 1", "tunnel 2", "stalled 1"]);
  set("Group by", "controller");
  assert.deepEqual(headings(), ["turn-right under swept 3", "bug1 under swept 1"]);
  set("Group by", "none");
  assert.deepEqual(headings(), []);
});

test("an error is grouped by its reason, and a failure without a cause by what it is filed under", () => {
  list.replaceChildren();
  const reason = "crash-KeyError-mine.act-3f2a";
  makeOverview(list, [failure("a", "crash", 20, { group: reason, cause: "crashes" }), failure("b", "loop", 9, { group: "loop-bumps-nook" })]);
  assert.deepEqual(headings(), [`${reason} 1`, "loop bumps nook 1"]);
  find("crashes");
  assert.deepEqual(cards(), ["a"]);
});

test("the clearest failure of a cause comes first", () => {
  list.replaceChildren();
  makeOverview(list, [failure("a", "loop", 9), failure("b", "loop", 20, { example: true }), failure("c", "loop", 30)]);
  assert.deepEqual(cards(), ["b", "a", "c"]);
});

test("cards beyond the first fifty are made when they are wanted", () => {
  list.replaceChildren();
  const many = (verdict, count) => Array.from({ length: count }, (_, k) => failure(`${verdict}-${k}`, verdict, 9));
  makeOverview(list, [...many("loop", 48), ...many("tunnel", 5), ...many("stalled", 3)]);
  assert.deepEqual([cards().length, headings().length], [50, 3]);
  const more = () => list.querySelectorAll("button.rest").map((one) => one.textContent);
  assert.deepEqual(more(), ["Show 3 more", "Show 3 more"]);
  list.querySelectorAll("button.rest")[0].click();
  assert.deepEqual([cards().length, more().length], [53, 1]);
});

test("groups of causes have the answer's order, the worst first", () => {
  list.replaceChildren();
  makeOverview(list, FAILURES, new Map([["goes-through-a-wall", "tunnel"], ["circles-an-obstacle", "loop"], ["wanders", "loop"]]));
  assert.deepEqual(headings(), ["goes through a wall 2", "circles an obstacle 1", "wanders 1"]);
  // A cause has one colour on the page, whatever its first failure's verdict.
  assert.deepEqual(list.querySelectorAll("h2 .dot").map((one) => one.dataset.verdict), ["tunnel", "loop", "loop"]);
});

test("the answer has advice for every cause, and a command if no change was tried", () => {
  const cause = (name, more) => ({ cause: name, sentence: `It ${name}.`, advice: `Mend ${name}.`, severity: "never-arrives", state: "", met: 3, verdicts: { loop: 2, stalled: 1 }, natural: 2, groups: ["a"], file: "one.grid", why: "", ...more });
  const natural = { worlds: 40, arrived: 4, unsensed: 0, share: 0.1, low: 0.03, high: 0.24, families: { trap: { worlds: 40, arrived: 4 } }, clearances: { "1 to 2": { worlds: 40, arrived: 4 }, "2 to 3": { worlds: 0, arrived: 0 } }, turns: {}, percent: 10, never: ["gaps of 2 to 3 robot radii", "paths with no quarter turns"] };
  const answer = { controller: "c", motion: "m", causes: [cause("circles-an-obstacle"), cause("wanders", { file: "", why: "arrives if cell (1, 1) is free" })], natural, headline: { who: "c under m", words: "rarely arrives", rest: "; 2 causes", tone: "never-arrives", more: "" }, comparison: null, campaign: 0, reactions: [] };
  const shown = element("answer");
  makeAnswer(shown, { failures: [failure("one", "loop", 20, { explain: "worldgen explain one.grid", replay: "worldgen replay one.grid", test: "" })], extras: [], campaigns: [], answers: [answer] });
  for (const words of ["It rarely arrives.", "examined: 2 loop, 1 stalled", "Mend circles-an-obstacle.", "Mend wanders.", "worldgen explain one.grid", "Never tried: gaps of 2 to 3 robot radii; paths with no quarter turns."])
    assert.ok(shown.textContent.includes(words), words);
});

test("one cause at a time shows its example, the first until another one is chosen", () => {
  const cause = (name, more) => ({ cause: name, sentence: `It ${name}.`, advice: `Mend ${name}.`, severity: "never-arrives", state: "", met: 3, verdicts: { loop: 3 }, natural: null, groups: ["a"], why: "", ...more });
  const causes = [cause("circles-an-obstacle", { file: "one.grid" }), cause("wanders", { file: "two.grid", why: "arrives if cell (1, 1) is free" }), cause("stands-still", { file: "" })];
  const failures = [failure("one", "loop", 20), failure("two", "loop", 30)];
  const shown = element("answer");
  makeAnswer(shown, { failures, extras: [], campaigns: [], answers: [{ controller: "c", motion: "m", causes, natural: null, headline: { who: "c under m", words: "rarely arrives", rest: "; 2 causes", tone: "never-arrives", more: "" }, comparison: null, campaign: 0, reactions: [] }] });
  const folded = () => shown.querySelectorAll(".cause .folded").map((one) => one.hidden);
  const pressed = () => shown.querySelectorAll(".cause button[aria-pressed]").map((one) => one.getAttribute("aria-pressed"));
  assert.deepEqual([folded().slice(0, 2), pressed().slice(0, 2)], [[false, true], ["true", "false"]]);
  const second = shown.querySelectorAll(".cause")[1];
  assert.ok(second.textContent.includes("In its example it arrives if cell (1, 1) is free."));
  second.querySelector("button").click();
  assert.deepEqual([folded().slice(0, 2), pressed().slice(0, 2)], [[true, false], ["false", "true"]]);
  assert.equal(shown.querySelectorAll(".cause")[2].querySelector("button").hidden, true);
});

test("without an answer, the page says why and what would bring one", () => {
  const headline = { who: "c under m", words: "no answer", rest: ": none of the 5 worlds was finished; 0 worlds searched", tone: "none", more: "worldgen fuzz --resume a --budget 5m" };
  const shown = element("answer");
  makeAnswer(shown, { failures: [], extras: [], campaigns: [], answers: [{ controller: "c", motion: "m", causes: [], natural: null, headline, comparison: null, campaign: 0, reactions: [] }] });
  assert.equal(shown.querySelector(".headline").textContent, "No answer: none of the 5 worlds was finished; 0 worlds searched.");
  assert.equal(shown.querySelector("code").textContent, headline.more);
});

test("verdicts and a search filter the cards, and a note says if none match", () => {
  const chip = list.querySelectorAll(".chips button").find((one) => one.textContent === "tunnel 2");
  chip.click();
  assert.deepEqual(cards(), ["two", "three"]);
  assert.equal(chip.getAttribute("aria-pressed"), "true");
  find("BUG1 swept");
  assert.deepEqual(cards(), ["three"]);
  assert.match(list.textContent, /1 of 4 shown/);
  find("zzz");
  assert.match(list.textContent, /No failure matches/);
  chip.click();
  find("");
  assert.equal(cards().length, 4);
});

test("cards are sorted as requested", () => {
  set("Group by", "none");
  const orders = { small: "one,three,four,two", large: "two,four,three,one", steps: "one,three,four,two", met: "two,one,three,four" };
  for (const [order, names] of Object.entries(orders)) {
    set("Order", order);
    assert.equal(cards().join(), names, order);
  }
});

test("a card names its failure, and says that it was not confirmed here", () => {
  const [card] = list.querySelectorAll(".card").filter((one) => one.id === "card-four");
  assert.match(card.textContent, /wanders9 x 3, 9 solid90 stepscause met 1×turn-right, sweptas found, not shrunknot confirmed here/);
  assert.equal(card.getAttribute("href"), "#four");
});

test("markup in names is only text", () => {
  list.replaceChildren();
  const hostile = "<img src=x onerror=alert(1)></script>";
  makeOverview(list, [failure("one", "loop", 20, { group: hostile })]);
  assert.equal(list.querySelector(".kind").textContent, hostile);
  assert.equal(list.querySelectorAll("img, script").length, 0);
});

test("arrow keys move from card to card", () => {
  const [first, second] = list.querySelectorAll(".card");
  first.focus();
  assert.ok(press("ArrowRight"));
  assert.equal(document.activeElement, second);
  press("ArrowLeft");
  assert.equal(document.activeElement, first);
  press("ArrowLeft");
  assert.equal(document.activeElement, first); // already the first one
});

const CAMPAIGN = {
  controller: "turn-right", motion: "swept", folder: "mine", seed: "1", units: 4, worlds: 900, steps: 120_000, seconds: 3.5,
  verdicts: { reached: 700, loop: 12 }, met: { "circles-an-obstacle": 17, "goes-through-a-wall": 2 },
  strategies: [{ strategy: "native", units: 3, worlds: 800, steps: 100_000, failures: 9, variants: 1 }, { strategy: "archive", units: 1, worlds: 100, steps: 20_000, failures: 2, variants: 2 }],
  found: [
    { unit: 0, strategy: "native", cause: "circles-an-obstacle", solid_cells: 40, worlds: 12, steps: 900, seconds: 0.2 },
    { unit: 1, strategy: "archive", cause: "goes-through-a-wall", solid_cells: 9, worlds: 300, steps: 40_000, seconds: 1.2 },
    { unit: 2, strategy: "native", cause: "circles-an-obstacle", solid_cells: 4, worlds: 500, steps: 70_000, seconds: 2.5 },
  ],
  archive: { names: ["detour", "density"], edges: [[1.5, 2], [0.1]], cells: [[0, 0, 1.5, "reached"], [2, 1, 4, "loop"]], axes: [{ name: "detour", edges: [1.5, 2] }, { name: "density", edges: [0.1] }] },
};

function charts(campaigns = [CAMPAIGN]) {
  const place = element("campaign");
  place.replaceChildren();
  makeCampaign(place, campaigns, [failure("one", "loop", 20, { campaign: 0 })]);
  return place;
}

test("a campaign has charts, each with a label and a table", () => {
  const place = charts();
  const titles = place.querySelectorAll("h3").map((one) => one.textContent);
  assert.deepEqual(titles, ["Found over time", "By search strategy", "Archive: detour and density", "Causes, by how often they were met", "Verdicts at screening"]);
  assert.ok(place.querySelectorAll("svg.plot").every((one) => one.getAttribute("aria-label")));
  assert.deepEqual([place.querySelectorAll(".heat").length, place.querySelectorAll(".chart circle").length], [2, 2]);
});

test("the curve rises where each cause is first met, and its text says when the last one was found", () => {
  const place = charts();
  assert.match(place.textContent, /2 causes; the last new one after 300 of 900 worlds\./);
  assert.match(place.textContent, /Strategy archive was the first to find 2 variants of these causes\./);
});

test("a cause links to its failure on the page", () => {
  const place = charts();
  const links = place.querySelectorAll("a").map((one) => [one.textContent, one.getAttribute("href")]);
  assert.ok(links.length > 1 && links.every(([name, to]) => name === "circles an obstacle" && to === "#one"));
});

test("several campaigns are each shown with their names", () => {
  const place = charts([CAMPAIGN, { ...CAMPAIGN, found: [], folder: "other" }]);
  assert.deepEqual(place.querySelectorAll("h2").map((one) => one.textContent), ["turn-right under swept, mine", "turn-right under swept, other"]);
  assert.match(place.textContent, /Nothing was found\./);
});

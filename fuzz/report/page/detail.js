// One failure: its replay, the world before and after shrinking, numbers, the line that replays it, its file.

const LAYERS = {
  trail: ["Trail", "t"], touched: ["Touched walls", "u"], sensors: ["Sensors", "s"], signal: ["Signal", "i"], witness: ["Witness", "w"],
};

function makeDetail(section, failure, neighbours) {
  const canvas = el("canvas", { id: "stage", role: "img" });
  const under = el("div"), pair = el("div", { class: "pair" });
  const state = { player: null };
  const load = (drawn, words) => {
    if (state.player) state.player.play(false);
    canvas.setAttribute("aria-label", `${words}. ${pictureLabel(drawn)}`);
    state.player = buildPlayer(canvas, under, drawn, state.player);
    pair.querySelectorAll("button").forEach((button) => button.setAttribute("aria-pressed", String(button.dataset.name === drawn.name)));
  };
  section.replaceChildren(
    topOf(failure, neighbours),
    el(
      "div", { class: "two" },
      el("div", {}, failure.now.world ? [el("div", { class: "stage" }, canvas), under] : tooLarge(failure.now), legend(failure), pairPart(failure, pair, load)),
      el("div", { class: "side" }, replayPart(failure), ...failure.groups.map(numbersPart)),
    ),
  );
  if (failure.now.world) load(failure.now, failure.kind);
  pair.querySelectorAll("canvas").forEach((small) => drawSmall(small, small.dataset.which === "before" ? failure.before : failure.now));
  dragToMove(canvas, state);
  return {
    player: () => state.player,
    swap: () => {
      if (failure.before && failure.before.world && state.player) {
        const now = state.player.drawn === failure.now;
        load(now ? failure.before : failure.now, now ? "As found" : failure.kind);
      }
    },
    redraw: () => {
      if (state.player) state.player.draw();
      pair.querySelectorAll("canvas").forEach((small) => drawSmall(small, small.dataset.which === "before" ? failure.before : failure.now));
    },
  };
}

function topOf(failure, [before, after]) {
  const step = (id, words, key) => id
    ? el("a", { class: "button", href: `#${id}`, "aria-keyshortcuts": key }, words)
    : el("button", { type: "button", disabled: true }, words);
  return el(
    "div", {},
    el("div", { class: "trace" },
      el("a", { class: "button", href: "#" }, "← All failures"), el("span", { class: "space" }), step(before, "Previous", "p"), step(after, "Next", "n")),
    el("h2", { tabindex: "-1" }, verdictDot(failure.verdict), " ", failure.kind),
    el("p", { class: "words" }, `${failure.controller} under ${failure.motion}: ${failure.words}`),
    failure.confirmed ? null : el("p", { class: "notice" }, `Running it again for this report did not confirm it: ${failure.reason}`),
  );
}

function tooLarge(drawn) {
  return el("p", { class: "notice" }, `The world of ${drawn.size} cells is too large to draw here; its file can be downloaded, and worldgen show draws it.`);
}

function legend(failure) {
  const loop = failure.now.run && failure.now.run.loop;
  const items = [["start", "start"], ["target", "target"], loop ? ["way", "the way in"] : null, ["loop", loop ? "the period, for ever" : "the robot's way"],
    ["square touched", "wall touched"],
    failure.now.run && failure.now.run.marks.some((mark) => mark.cell) ? ["square breach", "where it goes wrong"] : null,
    failure.now.events ? ["square fire", "burning"] : null];
  return el("ul", { class: "legend", "aria-label": "Colours" }, items.filter(Boolean).map(([name, words]) => el("li", {}, el("i", { class: name }), words)));
}

// The controls under the stage. What was chosen before, such as layers, stays.
function buildPlayer(canvas, under, drawn, former) {
  const parts = {};
  fitStage(canvas, drawn.world);
  const player = makePlayer(canvas, drawn, (now) => showState(now, parts));
  if (former) Object.assign(player.show, former.show);
  if (!drawn.run) {
    under.replaceChildren(el("p", { class: "notice" }, "The controller could not be run here, so the world is shown without the robot's way."), viewButtons(player, parts));
    player.draw();
    return player;
  }
  under.replaceChildren(scrubBar(player, parts), controls(player, parts), layers(player, parts), ...thinNote(drawn.run));
  player.update();
  return player;
}

// As high as the world asks for at this width, but no higher than leaves the controls in the window.
function fitStage(canvas, world) {
  const wanted = canvas.clientWidth * ((world.height + 0.5) / (world.width + 0.5));
  canvas.style.height = `${Math.round(Math.max(240, Math.min(wanted, innerHeight * 0.58)))}px`;
}

function viewButtons(player, parts) {
  const button = (words, label, key, act) => el("button", { type: "button", "aria-label": label, title: `${label} (${key})`, "aria-keyshortcuts": key, onclick: act }, words);
  parts.follow = player.drawn.run ? button("Robot", "Follow the robot", "r", () => player.robot()) : null;
  return el("div", { class: "view", role: "group", "aria-label": "View" },
    button("−", "Zoom out", "-", () => player.zoom(1 / 1.4)), button("+", "Zoom in", "+", () => player.zoom(1.4)), button("Fit", "Show the whole world", "0", () => player.fit()), parts.follow);
}

function scrubBar(player, parts) {
  const { run } = player.drawn;
  parts.scrub = el("input", {
    type: "range", min: 0, max: run.steps, step: 1, id: "scrub", "aria-label": "Step",
    oninput: (event) => {
      player.play(false);
      player.go(Number(event.target.value));
    },
  });
  return el("div", { class: "scrub" }, scrubMarks(player), parts.scrub);
}

// Above the bar: the period of a loop, the steps that matter, the world's changes.
function scrubMarks(player) {
  const { run, world } = player.drawn, share = (step) => (1000 * Math.min(step, run.steps)) / Math.max(1, run.steps);
  const parts = [svg("rect", { class: "rail", x: 0, y: 11, width: 1000, height: 2 })];
  if (run.loop) parts.push(svg("rect", { class: "period", x: share(run.loop[0]), y: 3, width: Math.max(2, share(run.loop[0] + run.loop[1]) - share(run.loop[0])), height: 11 }));
  for (const step of changeSteps(world, run)) parts.push(svg("rect", { class: "tick change", x: share(step) - 0.75, y: 8, width: 1.5, height: 6 }));
  for (const mark of run.marks) parts.push(svg("rect", { class: `tick ${mark.kind}`, x: share(mark.step) - 1.5, y: 0, width: 3, height: 14 }, svg("title", {}, `step ${mark.step}: ${mark.text}`)));
  return svg("svg", { viewBox: "-8 0 1016 14", preserveAspectRatio: "none", "aria-hidden": "true" }, parts);
}

function changeSteps(world, run) {
  const { events } = openWorld(world);
  if (!events) return [];
  const pixels = new Set([...events.ms].map((ms) => Math.round((300 * ms) / (run.dt * 1000 * Math.max(1, run.steps)))));
  return [...pixels].filter((place) => place <= 300).map((place) => (place * run.steps) / 300);
}

function controls(player, parts) {
  const { run } = player.drawn;
  const button = (name, label, key, act) => el("button", { type: "button", "aria-label": label, title: `${label} (${key})`, "aria-keyshortcuts": key, onclick: act }, icon(name));
  parts.play = el("button", { type: "button", class: "main", id: "play", "aria-keyshortcuts": "Space", onclick: () => player.play(!player.playing) });
  parts.speed = choice(SPEEDS.map((speed) => [speed, `${speed}×`]), player.speed, (event) => { player.speed = Number(event.target.value); });
  parts.readout = el("span", { class: "readout", id: "readout" });
  const jumps = run.marks.map((mark) => [mark.step, mark.name, mark.text]);
  if (run.loop) jumps.push([run.loop[0] + run.loop[1], "End of period", "the state of the entry has come back"]);
  return el(
    "div", { class: "controls" },
    button("first", "To the start", "Home", () => player.go(0)), button("back", "One step back", "←", () => stepBy(player, -1)),
    parts.play,
    button("on", "One step on", "→", () => stepBy(player, 1)), button("last", "To the end", "End", () => player.go(run.steps)),
    run.loop ? (parts.period = el("button", { type: "button", "aria-pressed": "false", "aria-keyshortcuts": "l", title: "Play one period again and again (l)", onclick: () => playPeriod(player) }, "One period")) : null,
    ...jumps.map(([step, words, text]) => el("button", { type: "button", class: "jump", title: `Step ${step}: ${text}`, onclick: () => { player.play(false); player.go(step); } }, `${words} ${grouped(step)}`)),
    el("label", { class: "field" }, "Speed", parts.speed),
    parts.readout,
  );
}

function stepBy(player, steps) {
  player.play(false);
  player.go(steps > 0 ? Math.floor(player.step) + steps : Math.ceil(player.step) + steps);
}

// To the next step that matters; from the last to the first.
function nextMark(player) {
  const { marks } = player.drawn.run;
  const next = marks.find((mark) => mark.step > player.step) || marks[0];
  player.play(false);
  if (next) player.go(next.step);
}

function playPeriod(player) {
  const { loop } = player.drawn.run;
  player.period = !player.period;
  if (player.period) {
    player.step = loop[0];
    player.speed = usualSpeed(loop[1], player.drawn.run.dt);
    player.play(true);
  }
  player.update();
}

function layers(player, parts) {
  const { drawn } = player;
  const has = { sensors: drawn.sensors, signal: drawn.sensors && drawn.sensors.signal, witness: drawn.world.witness || drawn.world.cut };
  parts.layers = {};
  return el("div", { class: "controls" }, el("div", { class: "layers", role: "group", "aria-label": "Layers" }, Object.entries(LAYERS).filter(([name]) => !(name in has) || has[name]).map(([name, [words, key]]) => {
    parts.layers[name] = el("input", {
      type: "checkbox", "aria-keyshortcuts": key,
      onchange: (event) => {
        player.show[name] = event.target.checked;
        player.update();
      },
    });
    return el("label", { class: "check", title: `Key ${key}` }, parts.layers[name], name === "witness" && drawn.world.cut ? "Cut" : words);
  })), viewButtons(player, parts));
}

function thinNote(run) {
  if (run.thinned === 1) return [];
  return [el("p", { class: "quiet" }, `A long run of ${grouped(run.steps)} steps: the page holds those that matter, of the others at worst one in ${run.thinned}, and draws straight lines between.`)];
}

function showState(player, parts) {
  const { run } = player.drawn;
  if (!run) return;
  const step = Math.min(run.steps, Math.floor(player.step + 1e-9));
  parts.scrub.value = step;
  parts.scrub.setAttribute("aria-valuetext", `step ${step} of ${run.steps}${momentOf(run, step)}`);
  parts.play.replaceChildren(icon(player.playing ? "pause" : "play"), player.playing ? "Pause" : "Play");
  parts.speed.value = player.speed;
  if (parts.period) parts.period.setAttribute("aria-pressed", String(player.period));
  if (parts.follow) parts.follow.setAttribute("aria-pressed", String(player.follow));
  for (const [name, box] of Object.entries(parts.layers)) box.checked = player.show[name];
  parts.readout.replaceChildren("step ", el("b", {}, grouped(step)), ` of ${grouped(run.steps)}, ${(step * run.dt).toFixed(2)} s${momentOf(run, step)}`);
}

function momentOf(run, step) {
  const mark = run.marks.find((one) => one.step === step);
  if (mark) return `: ${mark.text}`;
  if (!run.loop || step < run.loop[0]) return "";
  return step === run.loop[0] + run.loop[1] ? ": the state of the entry again" : `, ${step - run.loop[0]} into the period`;
}

function pairPart(failure, pair, load) {
  if (!failure.before) return null;
  const figure = (drawn, which, title) => el(
    "figure", {},
    drawn.world ? el("canvas", { role: "img", "data-which": which, "aria-label": `${title}: ${pictureLabel(drawn)}` }) : tooLarge(drawn),
    el("figcaption", {},
      el("span", {}, el("b", {}, title), el("br"), el("span", { class: "quiet" }, `${drawn.size}, ${drawn.solid} solid${drawn.run ? `, ${plural(drawn.run.steps, "step")}` : ""}`)),
      drawn.world && failure.now.world ? el("button", { type: "button", "data-name": drawn.name, "aria-pressed": "false", onclick: () => load(drawn, title) }, "Replay above") : null),
  );
  pair.append(figure(failure.before, "before", "As found"), figure(failure.now, "now", "Shrunk"));
  return el("div", { class: "part" }, el("h3", {}, "Before and after shrinking"), pair);
}

function replayPart(failure) {
  const copy = el("button", { type: "button", id: "copy", onclick: () => copyText(failure.replay, copy) }, "Copy");
  const file = (drawn, words) => el("a", { class: "button", download: drawn.name, href: `data:application/octet-stream;base64,${drawn.file}` }, words);
  return el(
    "div", { class: "part" },
    el("h3", {}, "Replay it"),
    el("div", { class: "command" }, el("code", { id: "command" }, failure.replay), copy),
    el("div", { class: "actions" }, file(failure.now, `Download ${failure.now.name}`), failure.before ? file(failure.before, "Download as found") : null),
  );
}

async function copyText(text, button) {
  try {
    await navigator.clipboard.writeText(text);
    button.textContent = "Copied";
  } catch {
    getSelection().selectAllChildren(byId("command"));
    button.textContent = document.execCommand("copy") ? "Copied" : "Selected";
  }
  say(`${button.textContent}: ${text}`);
  setTimeout(() => { button.textContent = "Copy"; }, 1500);
}

function numbersPart([title, rows]) {
  const body = el("table", { class: "numbers" }, el("tbody", {}, rows.map(([name, value]) => el("tr", {}, el("th", { scope: "row" }, name), el("td", {}, value)))));
  const raw = title === "Options" || title === "Evidence";
  return el("div", { class: "part" }, raw ? el("details", {}, el("summary", {}, title), body) : [el("h3", {}, title), body]);
}

function dragToMove(canvas, state) {
  let last = null;
  canvas.addEventListener("pointerdown", (event) => {
    if (!state.player || !state.player.view) return;
    last = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!last) return;
    state.player.move(event.clientX - last[0], event.clientY - last[1]);
    last = [event.clientX, event.clientY];
  });
  canvas.addEventListener("pointerup", () => { last = null; });
}

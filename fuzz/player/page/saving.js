// Saves what the player shows as files: a picture of this moment with its words and its legend, or a film of the whole run. If
// two runs are side by side, the file shows both.

import { el, say } from "#player/dom.js";
import { composed } from "#player/picture/composed.js";
import { palette } from "#player/picture/pen.js";
import { usualSpeed } from "#player/player.js";

// the best first
const FILMS = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];
const FILM_RATE = 30; // frames a second
const FILM_BITS = 4_000_000; // a second
const REST = 800; // ms that a film shows its last picture

/**
 * Makes the menu: everything that any page can save, and `drawn.saves`, pairs of a label and a
 * function for this page.
 * @param {Player} player
 * @returns {HTMLElement}
 */
export function saveMenu(player) {
  const { drawn } = player;
  const request = { stop: false }; // set when the user stops saving
  const summary = el("summary", { class: "button" }, "Save");
  const menu = el("details", { class: "save", onkeydown: (event) => close(event, menu) }, summary);
  const one = ([words, act]) => el("button", { type: "button", onclick: () => save(menu, words, act, request) }, words);
  summary.addEventListener("click", (event) => {
    if (!menu.dataset.saving) return;
    event.preventDefault(); // a click during saving stops it
    request.stop = true;
    player.play(false);
    if (drawn.stopSaving) drawn.stopSaving();
  });
  /** @type {Drawn["saves"]} */
  const film = drawn.run && filmKind() ? [[`Film, ${ending(filmKind()) === "mp4" ? "MP4" : "WebM"}`, () => keepFilm(player, request)]] : [];
  /** @type {NonNullable<Drawn["saves"]>} */
  const items = [["Picture, PNG", () => keepPicture(player)], ...film, ...(drawn.saves || [])];
  menu.append(el("div", { class: "menu" }, items.map(one)));
  return menu;
}

async function save(menu, words, act, request) {
  request.stop = false;
  const summary = menu.querySelector("summary");
  menu.open = false;
  summary.textContent = "Stop saving";
  menu.dataset.saving = "yes";
  summary.focus();
  try {
    say((await act()) || `Saved: ${words}`);
  } finally {
    summary.textContent = "Save";
    delete menu.dataset.saving;
  }
}

function close(event, menu) {
  if (event.key !== "Escape" || !menu.open) return;
  menu.open = false;
  menu.querySelector("summary").focus();
  event.stopPropagation();
}

/**
 * Downloads bytes as a file.
 * @param {string} name
 * @param {Blob} blob
 */
export function keep(name, blob) {
  const address = URL.createObjectURL(blob);
  const link = el("a", { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

function nameOf(player, kind) {
  return `${(player.drawn.name || "run").replace(/^.*\//, "").replace(/\.grid(\.gz)?$/, "")}.${kind}`;
}

async function keepPicture(player) {
  const canvas = composed(player);
  const blob = await new Promise((/** @type {BlobCallback} */ done) => canvas.toBlob(done, "image/png"));
  if (blob) keep(nameOf(player, "png"), blob);
}

// Returns the canvas or, for two runs side by side, a canvas that shows both and is updated
// with each frame.
async function together(player) {
  const { canvas, drawn } = player;
  if (!drawn.beside) return canvas;
  const both = el("canvas"),
    left = drawn.beside.canvas,
    gap = 2;
  both.width = left.width + gap + canvas.width;
  both.height = Math.max(left.height, canvas.height);
  player.drawnMore = () => {
    const context = /** @type {CanvasRenderingContext2D} */ (both.getContext("2d")),
      colours = palette();
    context.fillStyle = colours.rule;
    context.fillRect(0, 0, both.width, both.height);
    context.drawImage(left, 0, 0);
    context.drawImage(canvas, left.width + gap, 0);
    const ratio = window.devicePixelRatio || 1;
    context.font = `600 ${14 * ratio}px system-ui, sans-serif`;
    context.textAlign = "right";
    context.fillStyle = colours.ink;
    const [before, after] = drawn.beside.words;
    context.fillText(before, left.width - 8 * ratio, 20 * ratio);
    context.fillText(after, both.width - 8 * ratio, 20 * ratio);
  };
  player.drawnMore();
  return both;
}

function filmKind() {
  return window.MediaRecorder && FILMS.find((kind) => MediaRecorder.isTypeSupported(kind));
}

function ending(kind) {
  return kind.startsWith("video/mp4") ? "mp4" : "webm";
}

/* Plays the run from start to end, or a loop once, at the chosen speed,
   and records the canvas. Pausing ends the film. */
async function keepFilm(player, request) {
  const recorder = new MediaRecorder((await together(player)).captureStream(FILM_RATE), {
    mimeType: filmKind(),
    videoBitsPerSecond: FILM_BITS,
  });
  const parts = [];
  recorder.addEventListener("dataavailable", (event) => parts.push(event.data));
  const stopped = new Promise((done) => recorder.addEventListener("stop", done));
  player.play(false);
  // instead of the speed for playing a period
  if (player.period) player.speed = usualSpeed(player.last, player.drawn.run.dt);
  player.period = false;
  player.go(0);
  const begun = new Promise((done) => recorder.addEventListener("start", done));
  recorder.start();
  await begun; // on a busy machine the run could otherwise end before the recording begins
  player.play(!request.stop);
  await untilItEnds(player);
  for (let rest = 0; rest < REST; rest += REST / 8) {
    await new Promise((done) => setTimeout(done, REST / 8));
    player.draw(); // a film includes a still picture only if it is drawn again
  }
  recorder.stop();
  await stopped;
  player.drawnMore = null;
  keep(nameOf(player, ending(recorder.mimeType)), new Blob(parts, { type: recorder.mimeType.split(";")[0] }));
}

/**
 * @param {Player} player
 * @returns {Promise<void>}
 */
function untilItEnds(player) {
  return new Promise((done) => {
    let before = 0;
    const look = () => {
      if (player.playing && player.step >= before) {
        before = player.step;
        requestAnimationFrame(look);
        return;
      }
      if (player.playing) player.go(player.last); // it was about to repeat
      player.play(false);
      done();
    };
    requestAnimationFrame(look);
  });
}

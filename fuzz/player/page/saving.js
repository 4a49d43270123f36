// What the player shows, as files that the browser keeps: a picture of this moment, a film of the whole run.

import { el, say } from "./dom.js";
import { usualSpeed } from "./player.js";

const FILMS = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];
const FILM_RATE = 30; // frames a second
const FILM_BITS = 4_000_000; // a second
const REST = 800; // ms that a film stays on its last picture

// The menu: what every page can save, and `drawn.saves`, what this one can: pairs of words and what to do.
export function saveMenu(player) {
  const { drawn } = player;
  const menu = el("details", { class: "save", onkeydown: (event) => close(event, menu) }, el("summary", { class: "button" }, "Save"));
  const one = ([words, act]) => el("button", { type: "button", onclick: () => save(menu, words, act) }, words);
  const film = drawn.run && filmKind() ? [[`Film, ${ending(filmKind()) === "mp4" ? "MP4" : "WebM"}`, () => keepFilm(player)]] : [];
  const items = [["Picture, PNG", () => keepPicture(player)], ...film, ...(drawn.saves || [])];
  menu.append(el("div", { class: "menu" }, items.map(one)));
  return menu;
}

async function save(menu, words, act) {
  const summary = menu.querySelector("summary");
  menu.open = false;
  summary.textContent = "Saving …";
  summary.focus();
  try {
    say((await act()) || `Saved: ${words}`);
  } finally {
    summary.textContent = "Save";
  }
}

function close(event, menu) {
  if (event.key !== "Escape" || !menu.open) return;
  menu.open = false;
  menu.querySelector("summary").focus();
  event.stopPropagation();
}

// Hands bytes to the browser as a file.
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
  player.draw();
  keep(nameOf(player, "png"), await new Promise((done) => player.canvas.toBlob(done, "image/png")));
}

function filmKind() {
  return window.MediaRecorder && FILMS.find((kind) => MediaRecorder.isTypeSupported(kind));
}

function ending(kind) {
  return kind.startsWith("video/mp4") ? "mp4" : "webm";
}

// Plays the run from its start to its end, or once round its loop, and records the canvas meanwhile; Pause ends it.
async function keepFilm(player) {
  const recorder = new MediaRecorder(player.canvas.captureStream(FILM_RATE), {
    mimeType: filmKind(),
    videoBitsPerSecond: FILM_BITS,
  });
  const parts = [];
  recorder.addEventListener("dataavailable", (event) => parts.push(event.data));
  const stopped = new Promise((done) => recorder.addEventListener("stop", done));
  player.play(false);
  player.period = false;
  player.speed = usualSpeed(player.drawn.run.steps, player.drawn.run.dt);
  player.go(0);
  recorder.start();
  player.play(true);
  await untilItEnds(player);
  await new Promise((done) => setTimeout(done, REST));
  recorder.stop();
  await stopped;
  keep(nameOf(player, ending(recorder.mimeType)), new Blob(parts, { type: recorder.mimeType.split(";")[0] }));
}

function untilItEnds(player) {
  return new Promise((done) => {
    let before = 0;
    const look = () => {
      if (player.playing && player.step >= before) {
        before = player.step;
        requestAnimationFrame(look);
        return;
      }
      if (player.playing) player.go(player.last); // it was about to go round
      player.play(false);
      done();
    };
    requestAnimationFrame(look);
  });
}

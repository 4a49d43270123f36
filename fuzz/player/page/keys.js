// What the keys do while a player is on the page.

import { LAYERS, jumpTo, nextMark, playPeriod, stepBy } from "./controls.js";

export function cameraKeys(player) {
  const nearer = () => player.zoom(1.4);
  return { "+": nearer, "=": nearer, "-": () => player.zoom(1 / 1.4), 0: () => player.fit() };
}

export function layerKeys(player) {
  const toggle = (name) => () => {
    player.show[name] = !player.show[name];
    player.update();
  };
  return Object.fromEntries(Object.entries(LAYERS).map(([name, [, key]]) => [key, toggle(name)]));
}

export function clockKeys(player, steps) {
  const { run } = player.drawn;
  return {
    " ": () => player.play(!player.playing),
    ArrowLeft: () => stepBy(player, -steps),
    ArrowRight: () => stepBy(player, steps),
    Home: () => jumpTo(player, 0),
    End: () => jumpTo(player, player.last),
    r: () => (player.follow ? player.fit() : player.robot()),
    e: () => nextMark(player),
    l: () => run.loop && playPeriod(player),
  };
}

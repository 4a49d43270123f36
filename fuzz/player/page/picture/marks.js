// Written by `python -m build_tools.page_marks` from worldgen/render/marks.json; not edited.

/** By name, the lowest first. @type {Record<string, MarkLook>} */
export const MARKS = {
  "floor": {"colour": "floor", "width": 0.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 0.0, "fade": [], "on_cards": true, "label": ""},
  "grid": {"colour": "grid", "width": 1.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 0.0, "fade": [], "on_cards": false, "label": ""},
  "signal": {"colour": "target", "width": 1.0, "dash": [], "opacity": 0.22, "casing": 0.0, "fill": 0.5, "size": 0.0, "fade": [], "on_cards": false, "label": "signal, halves per ring"},
  "drift": {"colour": "push", "width": 1.6, "dash": [], "opacity": 0.45, "casing": 0.0, "fill": 0.0, "size": 9.0, "fade": [], "on_cards": true, "label": "tilted floor"},
  "missed": {"colour": "missed", "width": 0.0, "dash": [], "opacity": 0.6, "casing": 0.0, "fill": 0.25, "size": 0.0, "fade": [], "on_cards": true, "label": "not covered"},
  "remembered": {"colour": "memory", "width": 1.6, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.5, "size": 3.2, "fade": [], "on_cards": false, "label": "the robot's own map"},
  "burnt": {"colour": "burnt", "width": 0.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 1.0, "size": 0.0, "fade": [], "on_cards": true, "label": "burnt floor"},
  "wall": {"colour": "wall", "width": 0.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 0.0, "fade": [], "on_cards": true, "label": ""},
  "fire": {"colour": "fire", "width": 0.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.7, "size": 0.0, "fade": [], "on_cards": true, "label": "burning"},
  "burns": {"colour": "fire", "width": 1.5, "dash": [], "opacity": 0.85, "casing": 0.0, "fill": 0.3, "size": 7.0, "fade": [], "on_cards": true, "label": "burns later"},
  "closes": {"colour": "quiet", "width": 1.5, "dash": [], "opacity": 0.85, "casing": 0.0, "fill": 0.3, "size": 7.0, "fade": [], "on_cards": true, "label": "closes later"},
  "opens": {"colour": "start", "width": 1.5, "dash": [], "opacity": 0.85, "casing": 0.0, "fill": 0.6, "size": 7.0, "fade": [], "on_cards": true, "label": "opens later"},
  "touched": {"colour": "touched", "width": 4.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 0.0, "fade": [], "on_cards": true, "label": "wall touched"},
  "cut": {"colour": "breach", "width": 3.0, "dash": [], "opacity": 1.0, "casing": 5.0, "fill": 0.0, "size": 16.0, "fade": [], "on_cards": true, "label": "cut: every gap too narrow"},
  "cut-poses": {"colour": "breach", "width": 1.4, "dash": [], "opacity": 0.85, "casing": 0.0, "fill": 0.4, "size": 7.0, "fade": [], "on_cards": true, "label": "cut: no heading fits; lighter: some do not"},
  "band": {"colour": "loop", "width": 11.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.2, "size": 0.0, "fade": [], "on_cards": true, "label": ""},
  "start": {"colour": "start", "width": 2.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.25, "size": 4.0, "fade": [], "on_cards": true, "label": "start; the tick is its heading"},
  "began": {"colour": "start", "width": 0.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 1.0, "size": 5.0, "fade": [], "on_cards": true, "label": "start"},
  "end": {"colour": "robot", "width": 1.6, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.08, "size": 4.0, "fade": [], "on_cards": true, "label": "end"},
  "nearest": {"colour": "robot", "width": 1.6, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.08, "size": 4.0, "fade": [], "on_cards": true, "label": "where it gets nearest to the target while it repeats itself"},
  "witness": {"colour": "start", "width": 2.0, "dash": [6.0, 4.0], "opacity": 1.0, "casing": 4.0, "fill": 0.0, "size": 0.0, "fade": [], "on_cards": true, "label": "a path that fits"},
  "witness-body": {"colour": "start", "width": 1.1, "dash": [], "opacity": 0.55, "casing": 0.0, "fill": 0.0, "size": 0.0, "fade": [], "on_cards": true, "label": ""},
  "tightest": {"colour": "breach", "width": 1.8, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.3, "size": 0.0, "fade": [], "on_cards": true, "label": ""},
  "ahead": {"colour": "ahead", "width": 1.25, "dash": [], "opacity": 0.45, "casing": 0.0, "fill": 0.0, "size": 0.0, "fade": [], "on_cards": true, "label": "still to be driven"},
  "trail": {"colour": "loop", "width": 2.2, "dash": [], "opacity": 1.0, "casing": 4.2, "fill": 0.0, "size": 9.0, "fade": [0.2, 0.3, 0.4, 0.6, 1.0], "on_cards": true, "label": "the robot's path"},
  "approach": {"colour": "loop", "width": 1.8, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 0.0, "fade": [0.25, 0.35, 0.45, 0.55, 0.65], "on_cards": true, "label": "the path into the loop"},
  "loop": {"colour": "loop", "width": 3.4, "dash": [], "opacity": 1.0, "casing": 5.4, "fill": 0.0, "size": 13.0, "fade": [], "on_cards": true, "label": "the period, repeated forever"},
  "stay": {"colour": "loop", "width": 2.2, "dash": [], "opacity": 1.0, "casing": 4.2, "fill": 0.0, "size": 13.0, "fade": [], "on_cards": true, "label": "second half of the run: nothing new"},
  "spot": {"colour": "loop", "width": 3.4, "dash": [], "opacity": 1.0, "casing": 5.4, "fill": 0.2, "size": 7.0, "fade": [], "on_cards": true, "label": "the period, forever on this spot"},
  "body": {"colour": "loop", "width": 1.2, "dash": [], "opacity": 0.6, "casing": 0.0, "fill": 0.08, "size": 0.0, "fade": [], "on_cards": true, "label": ""},
  "heading": {"colour": "start", "width": 3.4, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 0.0, "fade": [], "on_cards": true, "label": ""},
  "pushed": {"colour": "push", "width": 3.0, "dash": [], "opacity": 1.0, "casing": 5.4, "fill": 0.0, "size": 13.0, "fade": [], "on_cards": true, "label": "push"},
  "pushes": {"colour": "push", "width": 2.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.3, "size": 0.0, "fade": [], "on_cards": true, "label": "place that pushes"},
  "decoy": {"colour": "target", "width": 2.4, "dash": [3.0, 4.0], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 8.0, "fade": [], "on_cards": true, "label": "decoy source"},
  "memory": {"colour": "memory", "width": 1.6, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 3.2, "fade": [], "on_cards": false, "label": ""},
  "plan": {"colour": "memory", "width": 2.4, "dash": [2.0, 4.0], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 0.0, "fade": [], "on_cards": false, "label": ""},
  "pierced": {"colour": "pierced", "width": 2.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.25, "size": 4.0, "fade": [], "on_cards": true, "label": "wall that the robot went into"},
  "caught": {"colour": "pierced", "width": 2.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.25, "size": 0.0, "fade": [], "on_cards": true, "label": "cell that caught or burned the robot, or must not be touched"},
  "overlap": {"colour": "pierced", "width": 2.6, "dash": [], "opacity": 1.0, "casing": 4.6, "fill": 0.0, "size": 7.0, "fade": [], "on_cards": true, "label": "overlap"},
  "breach": {"colour": "pierced", "width": 4.0, "dash": [], "opacity": 1.0, "casing": 7.0, "fill": 0.0, "size": 7.0, "fade": [], "on_cards": true, "label": "through a wall"},
  "target": {"colour": "target", "width": 2.2, "dash": [], "opacity": 1.0, "casing": 4.6, "fill": 0.1, "size": 5.0, "fade": [], "on_cards": true, "label": "target, which the robot's centre must enter"},
  "waypoint": {"colour": "target", "width": 2.2, "dash": [], "opacity": 1.0, "casing": 4.6, "fill": 0.1, "size": 9.0, "fade": [], "on_cards": true, "label": "waypoint, with its place in the order"},
  "goal": {"colour": "target", "width": 1.4, "dash": [4.0, 4.0], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 12.0, "fade": [], "on_cards": true, "label": ""},
  "barred": {"colour": "target", "width": 2.6, "dash": [], "opacity": 1.0, "casing": 5.0, "fill": 0.0, "size": 6.0, "fade": [], "on_cards": true, "label": "the wall that stops it on the straight line to the target"},
  "short": {"colour": "target", "width": 2.6, "dash": [], "opacity": 1.0, "casing": 5.0, "fill": 0.0, "size": 6.0, "fade": [], "on_cards": true, "label": "distance left to the target, with nothing in between"},
  "since": {"colour": "robot", "width": 0.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 14.0, "fade": [], "on_cards": true, "label": ""},
  "beam": {"colour": "target", "width": 1.0, "dash": [], "opacity": 0.3, "casing": 0.0, "fill": 0.0, "size": 0.0, "fade": [], "on_cards": false, "label": ""},
  "bearing": {"colour": "target", "width": 3.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 0.0, "fade": [], "on_cards": false, "label": ""},
  "driving": {"colour": "robot", "width": 1.75, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.22, "size": 3.0, "fade": [], "on_cards": false, "label": ""},
  "blocked": {"colour": "robot", "width": 3.0, "dash": [], "opacity": 1.0, "casing": 5.4, "fill": 0.0, "size": 12.0, "fade": [], "on_cards": true, "label": "is blocked by"},
  "number": {"colour": "robot", "width": 0.0, "dash": [], "opacity": 1.0, "casing": 4.0, "fill": 0.0, "size": 13.0, "fade": [], "on_cards": true, "label": ""},
  "named": {"colour": "named", "width": 3.0, "dash": [], "opacity": 1.0, "casing": 6.0, "fill": 0.0, "size": 5.0, "fade": [], "on_cards": true, "label": "cell named in the text"},
  "off": {"colour": "target", "width": 0.0, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 10.0, "fade": [], "on_cards": true, "label": ""},
  "scale": {"colour": "ink", "width": 1.5, "dash": [], "opacity": 1.0, "casing": 0.0, "fill": 0.0, "size": 11.0, "fade": [], "on_cards": true, "label": ""},
};

/** Names of the marks in a legend, in its order. @type {string[]} */
export const LEGEND = ["start", "began", "target", "waypoint", "signal", "witness", "cut", "cut-poses", "approach", "loop", "stay", "spot", "trail", "ahead", "end", "nearest", "barred", "short", "touched", "pierced", "caught", "overlap", "breach", "blocked", "pushed", "pushes", "missed", "remembered", "drift", "decoy", "fire", "burnt", "burns", "closes", "opens", "named"];

/** What a small picture shows of a large world. */
export const CARD = {"side": 190.0, "robot": 14.0, "around": 3.0, "small": 0.6};

/** Signs of the verdicts. @type {Record<string, string>} */
export const SIGNS = {"reached": "✓", "covered": "✓", "loop": "↻", "livelock": "↻", "deadlock": "‖", "starved": "‖", "stalled": "‖", "timeout": "…", "tunnel": "⇥", "overlap": "⇥", "collision": "⇥", "contact": "⇥", "burned": "✹", "crash": "✗", "hang": "✗", "invalid-command": "✗"};

/** Number of colours of robots. */
export const ROBOTS = 6;

// Finds the pages' modules: what the studio serves as /player/ and /studio/ is in fuzz/player/page and fuzz/studio/page.

const FUZZ = new URL("../../fuzz/", import.meta.url).href;

export function resolve(specifier, context, next) {
  const served = /^\/(player|studio)\/(.+)$/.exec(specifier);
  return next(served ? `${FUZZ}${served[1]}/page/${served[2]}` : specifier, context);
}

export function load(url, context, next) {
  return next(url, url.startsWith(FUZZ) ? { ...context, format: "module" } : context);
}

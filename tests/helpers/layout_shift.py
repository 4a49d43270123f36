"""Find out whether a page's parts change places while a run plays in it."""

_SCRIPT = """async (count) => {
  let moved = [];
  const observer = new PerformanceObserver((list) => {
    for (const one of list.getEntries())
      moved.push(...one.sources.map(({ node, previousRect: a, currentRect: b }) =>
        `${node?.nodeName} ${node?.className ?? ""}: ${a.y}+${a.height} -> ${b.y}+${b.height}, ${a.x} -> ${b.x}`));
  });
  observer.observe({ type: "layout-shift" });
  const bar = document.querySelector("#scrub"), heights = new Set();
  const frames = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  const [first, last] = [Number(bar.min), Number(bar.max)];
  for (let k = 0; k <= count; k += 1) {
    bar.value = String(Math.round(first + ((last - first) * k) / count));
    bar.dispatchEvent(new Event("input"));
    await frames();
    heights.add(document.documentElement.scrollHeight);
  }
  await frames();
  observer.disconnect();
  return { moved: [...new Set(moved)], heights: [...heights] };
}"""


def shifts(page, *, steps=80):
    """Move a player through its run, without input events; return what moved, and page heights.

    Args:
        page: The page, whose player is visible.
        steps: Number of steps to show.
    """
    return page.evaluate(_SCRIPT, steps)

// Accessibility checks that run in the page: each function returns complaints, as sentences.
// The numbers are those of WCAG 2.2: 1.4.3 and 1.4.11 (contrast), 2.5.8 (size of targets).
(() => {
  const CONTROLS = "button, a[href], input, select, textarea, summary, [tabindex='0']";
  const pixel = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });

  function rgba(colour) {
    pixel.clearRect(0, 0, 1, 1);
    pixel.fillStyle = colour;
    pixel.fillRect(0, 0, 1, 1);
    const [red, green, blue, alpha] = pixel.getImageData(0, 0, 1, 1).data;
    return [red, green, blue, alpha / 255];
  }

  const over = (top, below) => [0, 1, 2].map((k) => top[k] * top[3] + below[k] * (1 - top[3])).concat(1);

  // The colour behind an element: its own and its ancestors' backgrounds, one over the other.
  function behind(element) {
    if (!element) return [255, 255, 255, 1];
    const own = rgba(getComputedStyle(element).backgroundColor);
    return own[3] === 1 ? own : over(own, behind(element.parentElement));
  }

  function contrast(one, other) {
    const light = (colour) => {
      const [red, green, blue] = colour.slice(0, 3).map((value) => {
        const share = value / 255;
        return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
      });
      return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    };
    const [low, high] = [light(one), light(other)].sort((a, b) => a - b);
    return (high + 0.05) / (low + 0.05);
  }

  const seen = (element) => element.checkVisibility({ visibilityProperty: true, opacityProperty: true }) && !element.closest(".away");
  const name = (element) => `<${element.tagName.toLowerCase()} ${element.id || element.className}> ${(element.textContent || "").trim().slice(0, 30)}`;
  // Everything that can be used now: only the dialog, if one is open.
  const controls = () => {
    const all = (document.querySelector("dialog[open]") || document).querySelectorAll(CONTROLS);
    return [...all].filter((one) => seen(one) && !one.disabled && !one.closest(".skip"));
  };

  function text() {
    const faint = [];
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    const judge = (element, colour) => {
      const style = getComputedStyle(element),
        size = parseFloat(style.fontSize);
      const large = size >= 24 || (size >= 18.66 && style.fontWeight >= 700);
      const ground = behind(element),
        found = contrast(over(rgba(colour), ground), ground);
      if (found < (large ? 3 : 4.5)) faint.push(`${name(element)}: text at ${found.toFixed(2)}`);
    };
    while (walker.nextNode()) {
      const element = walker.currentNode.parentElement;
      if (!walker.currentNode.data.trim() || !seen(element) || element.closest(":disabled, script, noscript, option")) continue;
      judge(element, getComputedStyle(element).color);
    }
    for (const input of document.querySelectorAll("[placeholder]"))
      if (seen(input)) judge(input, getComputedStyle(input, "::placeholder").color);
    return faint;
  }

  // The contrast of a field's or framed button's edge with its surroundings, or of its filling if
  // that stands out more.
  function edges() {
    const framed = "select, textarea, button, .button, input:not([type=checkbox], [type=radio], [type=range], [type=file])";
    return [...document.querySelectorAll(framed)].filter((one) => seen(one) && !one.disabled).flatMap((one) => {
      const style = getComputedStyle(one),
        edge = rgba(style.borderBottomColor);
      if (parseFloat(style.borderBottomWidth) === 0 || edge[3] === 0) return [];
      const around = behind(one.parentElement);
      const found = Math.max(contrast(over(edge, around), around), contrast(behind(one), around));
      return found < 3 ? [`${name(one)}: edge at ${found.toFixed(2)}`] : [];
    });
  }

  function targets(least) {
    return controls().flatMap((one) => {
      const label = one.matches("input[type=checkbox], input[type=radio]") && one.labels[0],
        box = (label || one).getBoundingClientRect();
      if (one.matches("canvas, [role=region]")) return [];
      const size = label ? box.height : Math.min(box.width, box.height);
      return size < least - 0.5 ? [`${name(one)}: ${box.width.toFixed(0)} x ${box.height.toFixed(0)}`] : [];
    });
  }

  function twice() {
    const ids = [...document.querySelectorAll("[id]")].map((one) => one.id);
    return ids.filter((id, k) => ids.indexOf(id) !== k);
  }

  // The controls at which Tab should stop: only the chosen one in a group of radio buttons, tabs or
  // tools.
  function stops() {
    const grouped = (one) => one.matches("input[type=radio]:not(:checked)") || (one.tabIndex < 0 && one.closest("[role=tablist], [role=toolbar]"));
    return controls().filter((one) => !grouped(one));
  }

  // Whether the focused element shows the focus by an outline that stands out from its
  // surroundings.
  function focus() {
    const one = document.activeElement,
      style = getComputedStyle(one),
      around = behind(one.parentElement);
    const wide = parseFloat(style.outlineWidth) >= 2 && style.outlineStyle !== "none";
    return wide && contrast(over(rgba(style.outlineColor), around), around) >= 3;
  }

  // What does not fit: the page itself, or text that is cut off.
  function overflow() {
    const wide = document.documentElement.scrollWidth > innerWidth ? [`the page is ${document.documentElement.scrollWidth} wide`] : [];
    const cut = [...document.querySelectorAll("button, label, th, td, p, legend, h2, h3, .proof, .place")].filter(
      (one) => seen(one) && one.scrollWidth > one.clientWidth + 1 && one.clientWidth > 0 && getComputedStyle(one).overflow !== "visible" && !one.title,
    );
    return [...wide, ...cut.map(name)];
  }

  // Headings that skip a level, header cells without words, and landmarks inside others.
  function structure() {
    const shown = (selector) => [...document.querySelectorAll(selector)].filter((one) => one.checkVisibility());
    const levels = shown("h1, h2, h3, h4, h5, h6");
    const skipped = levels.filter((one, k) => k > 0 && Number(one.tagName[1]) > Number(levels[k - 1].tagName[1]) + 1);
    const silent = shown("th").filter((one) => !(one.textContent || "").trim());
    return [...skipped, ...silent, ...shown("main aside")].map(name);
  }

  globalThis.accessibility = { structure, text, edges, targets, twice, stops, focus, overflow, name };
})();

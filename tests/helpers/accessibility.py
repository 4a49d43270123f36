"""Find barriers in the studio for people without a mouse, with low vision or colour blindness."""

from pathlib import Path

SCRIPT = Path(__file__).with_suffix(".js").read_text("utf-8")
FINE, COARSE = 24, 44  # px: minimum size of targets for a mouse or a finger
NAMED = {
    "button", "link", "checkbox", "radio", "combobox", "textbox", "searchbox", "spinbutton", "slider", "tab",
    "application", "image", "Canvas", "dialog", "progressbar", "DisclosureTriangle", "region", "tabpanel",
}  # fmt: skip


def complaints(page, *, least=FINE):
    """Return all problems visible in the page as sentences; none if nothing is wrong."""
    page.evaluate(SCRIPT)
    said = page.evaluate(
        "least => ({twice: accessibility.twice(), text: accessibility.text(), edges: "
        "accessibility.edges(),"
        " targets: accessibility.targets(least), overflow: accessibility.overflow(), structure:"
        " accessibility.structure()})",
        least,
    )
    return [f"{kind}: {what}" for kind, found in said.items() for what in found] + nameless(page)


def badly_structured(page):
    """Return visible headings, header cells and landmarks that a screen reader would misread."""
    page.evaluate(SCRIPT)
    return page.evaluate("accessibility.structure()")


def nameless(page):
    """Return the controls and pictures without a name in Chromium's accessibility tree."""
    tree = page.context.new_cdp_session(page).send("Accessibility.getFullAXTree")["nodes"]
    shown = [node for node in tree if not node["ignored"] and node["role"]["value"] in NAMED]
    assert shown
    return [
        f"no name: {node['role']['value']}"
        for node in shown
        if not node.get("name", {}).get("value", "").strip()
    ]


def tab_through(page):
    """Presses Tab until all stops have been met.

    Return those that were not, or that do not show the focus.
    """
    page.evaluate(SCRIPT)
    page.evaluate("document.activeElement.blur()")
    page.evaluate("globalThis.left = new Set(accessibility.stops())")
    unseen = []
    for _ in range(2 * page.evaluate("left.size") + 10):
        page.keyboard.press("Tab")
        here = page.evaluate(
            "() => { const one = document.activeElement; left.delete(one);"
            # An answer that arrives meanwhile may replace controls.
            " for (const other of left) if (!other.isConnected) left.delete(other);"
            " return [one === document.body || accessibility.focus(), accessibility.name(one), "
            "left.size] }"
        )
        unseen += [] if here[0] else [f"no focus seen: {here[1]}"]
        if here[2] == 0:
            break
    return unseen + page.evaluate(
        "[...left].map((one) => `not reached by Tab: ${accessibility.name(one)}`)"
    )

"""What a page shows belongs to its address: after a reload, and in whatever order answers arrive."""

import json
import re

import pytest

from tests.helpers.browser import eventually, expect
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import opened

# Holds back the server's answers to requests of these kinds until `letAnswer` is called.
LATE = """(() => {
  const kinds = KINDS;
  const late = [];
  const send = WebSocket.prototype.send;
  const numbers = new Map();
  WebSocket.prototype.send = function (text) {
    const { id, do: kind } = JSON.parse(text);
    numbers.set(id, kind);
    send.call(this, text);
  };
  const listen = WebSocket.prototype.addEventListener;
  WebSocket.prototype.addEventListener = function (name, act) {
    if (name !== "message") return listen.call(this, name, act);
    return listen.call(this, name, (event) => {
      const kind = numbers.get(JSON.parse(event.data).id);
      if (!kinds.includes(kind)) return act(event);
      if (window.isLate) return late.push(() => act(event));
      act(event);
      window.answered += 1;
    });
  };
  window.isLate = false;
  window.answered = 0;
  window.lateCount = () => late.length;
  window.letAnswer = () => ((window.isLate = false), late.splice(0).forEach((go) => go()));
})()"""


def hold_answers(page, *kinds):
    page.add_init_script(LATE.replace("KINDS", json.dumps(kinds)))
    page.reload()
    page.wait_for_selector("#proof.good, #proof.bad")


def wait_for_its_run(page):
    # Until the world of a link arrives, the page may run the one that it showed before.
    page.wait_for_function("() => window.answered > 0")
    page.locator("#play .result .digest").first.wait_for()
    page.wait_for_function("() => !document.querySelector('#play .stage').matches('.stale')")


def digest_and_address(page):
    page.locator("#play .result .digest").first.wait_for()
    page.wait_for_function("() => document.getElementById('stop-run').hidden")
    return page.locator("#play .result .digest").first.inner_text(), page.url.partition("#")[2]


@pytest.mark.gate
def test_a_reload_brings_back_the_generated_world_the_settings_and_the_result(browser, tmp_path):
    with studio_of(tmp_path) as gate, opened(browser, gate) as page:
        hold_answers(page, "generate")
        base = page.url.partition("#")[0]
        page.goto(f"{base}#play?family=trap&world_seed=3&robots=turn-left&motion=swept&seed=5")
        wait_for_its_run(page)
        page.get_by_label("Steps", exact=True).fill("321")
        page.keyboard.press("Tab")
        page.locator("#run").click()
        page.wait_for_function("() => !document.querySelector('#play .stage').matches('.stale')")
        before = digest_and_address(page)
        assert "family=trap" in before[1] and "world_seed=3" in before[1]
        page.reload()
        eventually(page, lambda: digest_and_address(page), lambda seen: seen == before)
        expect(page.get_by_label("Steps", exact=True)).to_have_value("321")
        expect(page.locator(".stage.stale")).to_have_count(0)
        assert page.complaints == []


@pytest.mark.gate
def test_a_world_that_arrives_during_a_run_never_wears_the_other_world_s_verdict(browser, tmp_path):
    with studio_of(tmp_path) as gate, opened(browser, gate) as page:
        hold_answers(page, "generate")
        base = page.url.partition("#")[0]
        page.goto(f"{base}#play?family=trap&world_seed=3&robots=turn-left&motion=swept")
        wait_for_its_run(page)
        first = digest_and_address(page)
        # The next world is asked for on Draw, and arrives while Play shows the first one.
        page.evaluate("window.isLate = true")
        page.keyboard.press("1")
        page.locator("#tab-maker").click()
        page.locator("#maker-seed").fill("4")
        page.get_by_role("button", name="Generate", exact=True).click()
        page.wait_for_function("() => window.lateCount() > 0")
        page.keyboard.press("2")
        page.wait_for_function("() => location.hash.includes('world_seed=3')")
        grey = page.evaluate("""() => {
          window.letAnswer();
          return new Promise((done) => setTimeout(() => done([
            location.hash, document.querySelector("#play .stage").classList.contains("stale")
          ]), 0));
        }""")
        assert re.search(r"family=maze&world_seed=4", grey[0]) and grey[1] is True
        page.wait_for_function(
            "() => !document.querySelector('#play .stage').classList.contains('stale')"
        )
        second = digest_and_address(page)
        assert second[0] != first[0] and "family=maze" in second[1]
        assert page.complaints == []

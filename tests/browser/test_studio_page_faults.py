"""The studio's page when something goes wrong.

Lost connections, full storage, late answers.
"""

import contextlib

import pytest

from tests.helpers.browser import WAIT, expect
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import drag, expect_solid_cells, opened, solid_cells

# While `held` is a list, the page's messages are held back; `letGo` sends them and ends when all
# are answered.
HOLDING = """
window.held = null;
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (text) {
  window.socket = this;
  if (window.held) window.held.push(text);
  else send.call(this, text);
};
window.letGo = () => {
  const all = window.held.splice(0);
  window.held = null;
  return Promise.all(all.map((text) => new Promise((done) => {
    window.socket.addEventListener("message", ({ data }) => {
      const said = JSON.parse(data);
      if (said.id === JSON.parse(text).id && !("part" in said)) done();
    });
    send.call(window.socket, text);
  })));
};
true;
"""
NO_ROOM = """
const { setItem } = Storage.prototype;
window.refused = 0;
Storage.prototype.setItem = function (...given) {
  if (this === localStorage) {
    window.refused += 1;
    throw new DOMException("full", "QuotaExceededError");
  }
  setItem.apply(this, given);
};
true;
"""
BOTH_KEPT = (
    "() => Object.values(localStorage).filter((text) => text.includes('\"world\"')).length === 2"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("studio")


@pytest.fixture(scope="module")
def gate(folder):
    with studio_of(folder) as gate:
        yield gate


@pytest.fixture
def page(page):
    page.evaluate(HOLDING)
    return page


def draw_a_wall(page):
    drag(page, (20, 5), (20, 9))
    page.locator("#name", has_text="changed").wait_for()


def reconnect(page):
    """The connection breaks and is restored."""
    page.wait_for_function(
        "() => Boolean(window.socket)"
    )  # the proof of the drawing is requested soon
    page.evaluate("window.held = null; window.socket.close()")
    page.get_by_text("The studio does not answer.").wait_for()
    page.locator("#gone").wait_for(state="hidden")


def another_tab(page, address=None):
    other = page.context.new_page()
    other.set_default_timeout(WAIT)  # the new server is still starting its processes
    other.complaints = []
    other.on("pageerror", lambda error: other.complaints.append(str(error)))
    other.goto(address or page.url)
    other.locator("#proof.good").wait_for()
    return other


@pytest.mark.nightly
def test_numbers_of_a_world_that_has_changed_meanwhile_are_not_shown(page):
    page.evaluate("window.held = []")
    page.locator("#measure").click()
    page.get_by_text("Measuring").wait_for()
    draw_a_wall(page)
    page.evaluate("window.letGo()")
    expect(page.locator(".numbers")).to_have_count(0)
    page.locator("#measure").click()
    page.locator(".numbers").wait_for()


@pytest.mark.nightly
def test_a_run_that_the_lost_connection_has_ended_is_asked_for_again(page):
    page.evaluate("window.held = []")
    page.keyboard.press("2")
    page.locator("#run-said", has_text="Preparing").wait_for()
    reconnect(page)
    page.locator(".result").wait_for()


@pytest.mark.nightly
def test_results_can_be_looked_at_until_those_of_the_next_run_are_there(page):
    page.keyboard.press("2")
    page.locator(".result").wait_for()
    page.get_by_label("thesis-1 (turn-right)").check()
    page.locator("#run").click()
    page.locator(".result[data-controller=thesis-1]").wait_for()
    page.evaluate("window.held = []")
    page.locator("#run").click()
    page.locator("[aria-current] .result[data-controller=thesis-2]").wait_for()
    page.locator(".result[data-controller=thesis-1]").click()
    page.locator("[aria-current] .result[data-controller=thesis-1]").wait_for()


@pytest.mark.gate
def test_a_file_that_is_no_map_is_refused_where_it_is_seen_on_whatever_page_it_is_dropped(page):
    page.keyboard.press("3")
    page.locator("#campaign").wait_for()
    page.evaluate("""() => {
      const files = new DataTransfer();
      files.items.add(new File(["nonsense"], "nonsense.xyz"));
      dispatchEvent(new DragEvent("drop", { dataTransfer: files, bubbles: true, cancelable: true }));
    }""")
    page.locator("#panel-files .bad", has_text="nonsense.xyz").wait_for()


@pytest.mark.nightly
def test_what_went_wrong_when_saving_is_no_longer_said_when_it_went_well(page, folder):
    page.keyboard.press("Control+s")
    page.keyboard.type("wrong")
    page.keyboard.press("Enter")
    page.get_by_text("Saved wrong.grid").wait_for()
    (folder / "wrong.grid").unlink()
    (folder / "wrong.grid").mkdir()
    draw_a_wall(page)
    page.on("dialog", lambda dialog: dialog.accept())
    page.keyboard.press("Control+s")
    page.locator("#gone").wait_for()
    (folder / "wrong.grid").rmdir()
    page.keyboard.press("Control+s")
    page.locator("#gone").wait_for(state="hidden")


@pytest.mark.parametrize(
    ("label", "wrong"),
    [
        pytest.param("Cell size", "1e308", marks=pytest.mark.gate),
        pytest.param("Cell size", "1e-300", marks=pytest.mark.nightly),
        pytest.param("Heading", "1e308", marks=pytest.mark.nightly),
    ],
)
def test_a_number_out_of_its_bounds_is_told_and_changes_nothing(page, label, wrong):
    draw_a_wall(page)
    field = page.get_by_label(label).first
    before = field.input_value()
    field.fill(wrong)
    field.press("Tab")
    page.locator(".fault", has_text="Enter a number from").wait_for()
    page.locator("#proof.good").wait_for()
    expect(field).to_have_value(wrong)
    # the drawing is unchanged, because a world with such a number could not be stored
    page.reload()
    page.wait_for_selector("#proof.good")
    page.keyboard.press("Control+z")
    page.locator("#name", has_text="not saved yet").wait_for()
    expect(field).to_have_value(before)
    assert page.complaints == []


@pytest.mark.nightly
def test_after_a_new_start_a_new_tab_goes_on_with_what_an_open_one_has_drawn_and_nothing_is_lost(
    browser, folder
):
    with contextlib.ExitStack() as both:
        server = both.enter_context(contextlib.ExitStack())
        first = server.enter_context(studio_of(folder))
        page = both.enter_context(opened(browser, first))
        draw_a_wall(page)
        other = another_tab(page)
        drag(other, (10, 5), (10, 8))
        other.locator("#name", has_text="changed").wait_for()
        drawn = [solid_cells(one) for one in (page, other)]
        server.close()
        for one in (page, other):
            one.get_by_text("The studio does not answer.").wait_for()
        again = both.enter_context(studio_of(folder, port=first.port))
        fresh = another_tab(page, again.address)
        other.get_by_text("Another tab has continued this drawing.").wait_for()
        page.locator("#gone").wait_for(state="hidden")
        for one, count in zip((page, other, fresh), (*drawn, drawn[1]), strict=True):
            expect_solid_cells(one, count)
        page.wait_for_function(BOTH_KEPT)
        fresh.evaluate(NO_ROOM)
        drag(fresh, (30, 5), (30, 8))
        fresh.wait_for_function("() => window.refused > 0")  # it has tried to make room
        for one in (page, other):
            with one.expect_event("close"):
                one.close(run_before_unload=True)
        assert drawn[0] != drawn[1]
        expect_solid_cells(another_tab(fresh), drawn[0])
        expect(another_tab(fresh).locator("#name")).not_to_contain_text("changed")


@pytest.mark.nightly
def test_a_tab_that_has_gone_on_by_itself_keeps_its_draft_from_new_ones(page):
    draw_a_wall(page)
    reconnect(page)
    other = another_tab(page)
    expect(other.locator("#name")).not_to_contain_text("changed")
    page.reload()
    page.locator("#name", has_text="changed").wait_for()


@pytest.mark.nightly
def test_after_a_new_start_with_other_controllers_an_open_page_offers_those(browser, folder):
    old, new = (f"thesis-1+{option}+motion=stepped" for option in ("noise", "repaired"))
    with contextlib.ExitStack() as both:
        server = both.enter_context(contextlib.ExitStack())
        first = server.enter_context(studio_of(folder, named=[old]))
        page = both.enter_context(opened(browser, first))
        page.keyboard.press("3")
        page.locator("#campaign-controller option", has_text=old).wait_for(state="attached")
        page.keyboard.press("2")
        page.locator(f".result[data-controller='{old}']").wait_for()
        server.close()
        page.get_by_text("The studio does not answer.").wait_for()
        again = both.enter_context(studio_of(folder, port=first.port, named=[new]))
        another_tab(page, again.address)
        robots = page.locator("#play .robots")
        robots.get_by_label(new, exact=True).wait_for()
        expect(robots.get_by_label(new, exact=True)).to_be_checked()
        expect(robots.get_by_label(old, exact=True)).to_have_count(0)
        page.keyboard.press("3")
        page.locator("#campaign-controller option", has_text=new).wait_for(state="attached")
        expect(page.locator("#campaign-controller option", has_text=old)).to_have_count(0)


@pytest.mark.nightly
def test_a_page_too_many_says_so_and_comes_when_another_one_is_closed(browser, folder, monkeypatch):
    monkeypatch.setattr("fuzz.studio.app.MOST_PAGES", 1)
    with studio_of(folder) as gate, opened(browser, gate) as page:
        other = page.context.new_page()
        other.goto(page.url)
        other.get_by_text("1 pages are open, which is the limit; close another one.").wait_for()
        page.close()
        other.locator("#proof.good").wait_for()
        expect(other.locator("#gone")).to_be_hidden()

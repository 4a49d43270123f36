"""The drawing board by mouse, keys and fingers: undo and the visible part."""

import pytest

from tests.helpers.browser import expect
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import drag, expect_solid_cells, opened, place

BORDER = 156  # solid cells of an empty world of 40 x 40
TABLET = {"viewport": {"width": 820, "height": 1180}, "has_touch": True}


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    with studio_of(tmp_path_factory.mktemp("board")) as gate:
        yield gate


@pytest.fixture
def tablet(browser, gate):
    with opened(browser, gate, **TABLET) as page:
        yield page


def press(page, *keys):
    for key in keys:
        page.keyboard.press(key)


def pinch(page, *cells):
    """Put two fingers down at cells, one after another, and lift them again."""
    fingers = [{"x": x, "y": y} for x, y in (place(page, *cell) for cell in cells)]
    touch = page.context.new_cdp_session(page)
    for points in (fingers[:1], fingers, []):
        kind = "touchStart" if points else "touchEnd"
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})


@pytest.mark.nightly
def test_what_is_undone_while_something_is_drawn_is_that(page):
    page.locator("#board").focus()
    press(page, "l", "Space", "Shift+ArrowRight", "Space")
    expect_solid_cells(page, BORDER + 6)
    press(page, "ArrowUp", "Space", "Shift+ArrowRight", "Control+z", "Escape")
    expect_solid_cells(page, BORDER + 6)
    press(page, "Control+z", "Space", "Shift+ArrowLeft", "Control+y", "Control+y")
    expect_solid_cells(page, BORDER + 6)


@pytest.mark.nightly
def test_a_brush_that_is_taken_while_a_line_is_drawn_by_keys_does_not_paint_by_itself(page):
    page.locator("#board").focus()
    press(page, "l", "Space", "ArrowRight", "b")
    page.mouse.move(*place(page, 5.5, 30.5))
    page.mouse.move(*place(page, 15.5, 30.5), steps=5)
    expect_solid_cells(page, BORDER)


@pytest.mark.nightly
def test_two_fingers_leave_the_selection_and_what_had_been_undone(tablet):
    for x in (5, 10):
        tablet.touchscreen.tap(*place(tablet, x + 0.5, 20.5))
    tablet.locator("#undo").tap()
    expect_solid_cells(tablet, BORDER + 1)
    pinch(tablet, (20, 20), (24, 20))
    tablet.locator("#redo").tap()
    expect_solid_cells(tablet, BORDER + 2)
    tablet.locator("[data-tool=select]").tap()
    drag(tablet, (4, 19), (11, 21))
    pinch(tablet, (30, 30), (34, 30))
    tablet.get_by_role("button", name="Clear", exact=True).first.tap()
    expect_solid_cells(tablet, BORDER)


@pytest.mark.gate
def test_what_was_copied_is_pasted_without_the_board_moving_away(page):
    before = page.locator("#board").bounding_box()
    drag(page, (5, 5), (9, 5))
    page.keyboard.press("s")
    drag(page, (5, 5), (9, 5))
    press(page, "Control+c", "Control+v")
    page.get_by_role("combobox", name="Stamp").wait_for()
    assert page.locator("#board").bounding_box() == before


@pytest.mark.gate
def test_the_whole_world_lies_beside_the_rulers(tablet):
    left = place(tablet, 0, 20)[0] - tablet.locator("#board").bounding_box()["x"]
    assert left > 40
    column = tablet.evaluate(
        """(at) => {
          const board = document.getElementById("board"), scale = board.width / board.clientWidth;
          const pen = board.getContext("2d"), row = Math.round(board.height / 2 + 40);
          return [at + 1, at + 8].map((x) => pen.getImageData(Math.round(x * scale), row, 1, 1).data[0]);
        }""",
        left,
    )
    assert column[0] == column[1] < 128  # the wall is as dark next to the ruler as farther in


@pytest.mark.parametrize(
    "ratio",
    [pytest.param(1.25, marks=pytest.mark.gate), pytest.param(1.5, marks=pytest.mark.nightly)],
)
def test_a_wall_has_no_seams_on_a_screen_whose_pixels_are_no_whole_part_of_the_page_s(
    browser, gate, ratio
):
    how = {"viewport": {"width": 853, "height": 480}, "device_scale_factor": ratio}
    with opened(browser, gate, **how) as page:
        box = page.locator("#board").bounding_box()
        x, low, high = (
            place(page, 0.5, y)[k] - box[name]
            for y, k, name in ((20, 0, "x"), (1, 1, "y"), (39, 1, "y"))
        )
        shades = page.evaluate(
            """([x, high, low, ratio]) => {
              const pen = document.getElementById("board").getContext("2d");
              const [left, top, deep] = [x * ratio, high * ratio, (low - high) * ratio].map(Math.round);
              const { data } = pen.getImageData(left, top, 1, deep);
              return [...new Set(data.filter((_, k) => k % 4 === 0))];
            }""",
            [x, high, low, ratio],
        )
        assert len(shades) == 1


@pytest.mark.parametrize(
    "size",
    [
        pytest.param((820, 1180), marks=pytest.mark.gate, id="upright"),
        pytest.param((1180, 820), marks=pytest.mark.nightly, id="wide"),
    ],
)
def test_on_a_tablet_the_board_stays_where_it_is_whatever_the_tool(browser, gate, size):
    with opened(
        browser, gate, viewport={"width": size[0], "height": size[1]}, has_touch=True
    ) as page:
        places = {}
        for tool in page.locator("[data-tool]").evaluate_all(
            "all => all.map((one) => one.dataset.tool)"
        ):
            if page.locator(f"button[data-tool={tool}]").count():
                page.locator(f"button[data-tool={tool}]").tap()
                places[tool] = page.locator("#board").bounding_box()["y"]
                overflow = page.locator(".options").evaluate(
                    "one => one.scrollHeight - one.clientHeight"
                )
                assert overflow <= 1, tool
        assert len(set(places.values())) == 1, places


@pytest.mark.nightly
def test_in_a_large_world_the_widest_robot_is_found_on_demand(page):
    page.get_by_label("Columns").first.fill("250")
    page.get_by_label("Rows").first.fill("250")
    page.get_by_role("button", name="New").click()
    page.locator("#widest", has_text="In a large world this takes up to a minute.").wait_for()
    page.get_by_role("button", name="Find the widest robot that passes").press("Enter")
    page.locator("#widest", has_text="Robots with a radius of up to").wait_for()
    page.locator("#find-widest").wait_for(state="hidden")
    expect(page.locator("#radius")).to_be_focused()
    drag(page, (20, 20), (60, 60))
    page.locator("#find-widest").wait_for()


@pytest.mark.nightly
def test_a_world_is_generated_by_enter_in_any_field_with_what_was_typed_there(page):
    page.locator("#tab-maker").click()
    page.locator("#maker-seed").fill("7")
    page.locator("#maker-seed").press("Enter")
    page.get_by_text("Generated by maze, version 1, seed 7.").wait_for()
    page.get_by_role("spinbutton", name="Size", exact=True).fill("12")
    page.keyboard.press("Enter")
    page.locator("#place", has_text="12 x 12 cells").wait_for()

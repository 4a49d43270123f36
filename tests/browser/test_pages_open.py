"""The default tier's browser checks: a report and the studio open and do their main job."""

import re

import pytest

from fuzz.report import write_report
from tests.helpers.browser import page_in
from tests.helpers.campaign_folder import campaign_folder
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import drag, expect_solid_cells, opened


@pytest.mark.gate
def test_a_report_opens_from_disk_and_plays(browser, tmp_path):
    write_report([campaign_folder(tmp_path / "failures")], tmp_path / "report.html")
    with page_in(browser) as page:
        page.goto((tmp_path / "report.html").as_uri())
        page.locator(".card", has_text="returns to a wall").click()
        page.keyboard.press("Home")
        page.locator("#play-pause").click()
        page.locator("#readout", has_text=re.compile("step [1-9]")).wait_for()
        asked = {address for address in page.requested if not address.startswith("data:")}
        assert asked == {(tmp_path / "report.html").as_uri()}
        assert page.complaints == []


@pytest.mark.gate
@pytest.mark.parametrize("made", ["source", "text", "module"])
def test_a_script_that_gets_into_a_report_is_not_run(browser, tmp_path, made):
    code = "document.title = 'broken'"
    set_up = {
        "source": f"script.src = {'data:text/javascript,' + code!r};",
        "text": f"script.textContent = {code!r};",
        "module": f"script.type = 'module'; script.src = {'data:text/javascript,' + code!r};",
    }
    write_report([campaign_folder(tmp_path / "failures")], tmp_path / "report.html")
    with page_in(browser) as page:
        page.goto((tmp_path / "report.html").as_uri())
        page.evaluate(f"""new Promise((done) => {{
            const script = document.createElement("script");
            script.onload = script.onerror = () => done();
            {set_up[made]}
            document.body.append(script);
            if (!script.src) done();  // its text has run by now, if it is run at all
        }})""")
        assert page.title() != "broken"


@pytest.mark.gate
def test_the_studio_is_one_request_and_one_connection(browser, tmp_path):
    with studio_of(tmp_path) as gate, opened(browser, gate) as page:
        asked = [
            address for address in page.requested if not address.startswith(("data:", "blob:"))
        ]
        assert asked == [gate.address] and page.complaints == []


@pytest.mark.nightly
def test_the_studio_opens_draws_and_proves(browser, tmp_path):
    with studio_of(tmp_path) as gate, opened(browser, gate) as page:
        page.keyboard.press("l")
        drag(page, (0, 20), (39, 20))
        page.locator("#proof.bad", has_text="blocked").wait_for()
        page.keyboard.press("Control+z")
        page.locator("#proof.good").wait_for()
        expect_solid_cells(page, 156)  # the border alone
        assert page.complaints == []

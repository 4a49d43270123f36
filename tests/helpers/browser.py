"""Chromium, driven through Debian's chromedriver, without network."""

import json
import shutil
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.chrome.service import Service

_FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--window-size=1280,900",
)  # fmt: skip


def missing_browser():
    """What a test of the page lacks here; empty if nothing."""
    if chromium() is None:
        return "no Chromium here: the report is not tested in a browser (apt-get install chromium chromium-driver)"
    if shutil.which("chromedriver") is None:
        return "no chromedriver here: the report is not tested in a browser (apt-get install chromium-driver)"
    return ""


def start_browser(profile: Path, downloads: Path):
    """A browser with a fresh profile that logs its console and every request."""
    options = webdriver.ChromeOptions()
    options.binary_location = str(chromium())
    for flag in (*_FLAGS, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.add_experimental_option("prefs", {"download.default_directory": str(downloads)})
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))


def requested(browser):
    """The addresses that the browser has asked for since the last call, those of data in the page left out."""
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    sent = [message for message in messages if message["method"] == "Network.requestWillBeSent"]
    addresses = [message["params"]["request"]["url"] for message in sent]
    return [address for address in addresses if not address.startswith("data:")]


def colour_scheme(browser, name):
    """Makes the system seem ``dark`` or ``light``."""
    features = [{"name": "prefers-color-scheme", "value": name}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})


def chromium():
    """The browser's program, or None."""
    found = (shutil.which(name) for name in ("chromium", "chromium-browser", "google-chrome"))
    return next((path for path in found if path is not None), None)

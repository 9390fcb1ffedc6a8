"""Pages of the program in a browser. Chromium is Debian's (`apt-get install chromium`) or that of $CHROMIUM."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parents[2]
WIDTHS = (390, 900, 1400)
QUIET = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run"]


@pytest.fixture(scope="session")
def program():
    """The program: $SPINEBENCH, or that of a release build."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    path = Path(os.environ.get("SPINEBENCH", target / "release" / "spinebench"))
    if not path.is_file():
        pytest.fail(f"{path} is not there: cargo build --release")
    return path


@pytest.fixture(scope="session")
def run(program):
    """Runs the program in the checkout; returns what it prints."""

    def call(*arguments):
        done = subprocess.run([program, *map(str, arguments)], cwd=ROOT, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return call


@pytest.fixture
def serve(program):
    """Starts `spinebench view`; returns the address of its page."""
    started = []

    def start(*arguments):
        command = [program, "view", "--no-open", *map(str, arguments)]
        process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
        started.append(process)
        line = process.stdout.readline()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/[0-9a-f]{32}/\n", line), line
        return line.strip()

    yield start
    for process in started:
        process.kill()
        process.wait()


@pytest.fixture(scope="session")
def chromium():
    path = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
    if not path:
        pytest.fail("Chromium is not there: apt-get install chromium, or $CHROMIUM")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=QUIET)
        yield browser
        browser.close()


@pytest.fixture
def page(chromium):
    """A page that fails its test where the console shows an error or something is fetched from elsewhere."""
    context = chromium.new_context(viewport={"width": 1400, "height": 900})
    page = context.new_page()
    faults = []
    page.on("console", lambda message: faults.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: faults.append(str(error)))

    def request(asked):
        if not asked.url.startswith(("http://127.0.0.1:", "file:", "data:", "blob:")):
            faults.append(f"fetched {asked.url}")

    page.on("request", request)
    yield page
    context.close()
    assert not faults, faults


@pytest.fixture(scope="session")
def screenshots():
    """Pictures of pages at three widths, into target/tmp/screenshots, to be looked at."""
    folder = ROOT / "target" / "tmp" / "screenshots"
    folder.mkdir(parents=True, exist_ok=True)

    def take(page, name):
        for width in WIDTHS:
            page.set_viewport_size({"width": width, "height": 900})
            page.wait_for_timeout(150)
            page.screenshot(path=folder / f"{name}_{width}.png", full_page=True)
            wide = page.evaluate("document.documentElement.scrollWidth")
            assert wide <= width, f"{name}: {wide} px of content at {width} px"
        page.set_viewport_size({"width": 1400, "height": 900})

    return take


def ink(page, selector):
    """Number of different colours on a canvas: an empty one has one."""
    return page.evaluate(
        """(selector) => {
          const canvas = document.querySelector(selector);
          const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
          const colours = new Set();
          for (let i = 0; i < data.length; i += 4) colours.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
          return colours.size;
        }""",
        selector,
    )

"""The live view: sliders move the tip to where `simulate` says."""

import csv
import json
import math

from conftest import ROOT, ink
from playwright.sync_api import expect


def settled_tip(page):
    """The tip once it has stopped, metres."""
    before = None
    for _ in range(60):
        page.wait_for_timeout(100)
        now = json.loads(page.get_attribute("#live-tip", "data-tip"))
        if before and math.dist(now, before) < 1e-6:
            return now
        before = now
    raise AssertionError("the tip does not come to rest")


def simulated_tip(run, folder, pulls, effects="[]"):
    model = folder / "model.yaml"
    text = (ROOT / "models/nominal.yaml").read_text().replace("effects: []", f"effects: {effects}")
    model.write_text(text)
    columns = ",".join(f"tendon_{k + 1}_m" for k in range(len(pulls)))
    (folder / "in.csv").write_text(f"trial,time_s,{columns}\n0,0,{','.join(map(str, pulls))}\n")
    run("simulate", "--static", "--model", model, "--commands", folder / "in.csv", "--out", folder / "out.csv")
    row = next(csv.DictReader(open(folder / "out.csv")))
    return [float(row[f"tip_{axis}_m"]) for axis in "xyz"]


def pull(page, tendon, value_m):
    slider = page.locator(f'input[data-name="tendon_{tendon}"]')
    slider.evaluate("(input, value) => { input.value = value; input.dispatchEvent(new Event('input')); }", value_m)
    return float(slider.input_value())


def test_sliders_move_the_tip_to_where_simulate_says(page, serve, run, tmp_path):
    page.goto(serve("models/nominal.yaml"))
    expect(page.locator("#live-status")).to_have_text("converged")
    home = settled_tip(page)
    assert math.dist(home, simulated_tip(run, tmp_path, [0, 0, 0, 0])) < 1e-4
    page.check("#live-static")
    pulls = [pull(page, 1, 0.006), 0, pull(page, 3, -0.006), 0]
    there = settled_tip(page)
    assert math.dist(there, simulated_tip(run, tmp_path, pulls)) < 2e-5
    assert math.dist(there, home) > 0.015
    page.get_by_label("tip load").check()
    mass = float(page.locator('input[data-name="mass_kg"]').input_value())
    loaded = settled_tip(page)
    assert math.dist(loaded, simulated_tip(run, tmp_path, pulls, f"[{{tip_load: {{mass_kg: {mass}}}}}]")) < 2e-5
    assert math.dist(loaded, there) > 1e-3
    page.get_by_label("tip load").uncheck()
    page.click("#live-home")
    page.uncheck("#live-static")
    assert math.dist(settled_tip(page), home) < 1e-4
    assert "mm" in page.text_content("#live-tip")
    assert "N;" in page.text_content("#live-tensions")


def test_keys_turn_and_move(page, serve):
    page.goto(serve("models/nominal.yaml"))
    expect(page.locator("#live-status")).to_have_text("converged")
    assert ink(page, "#live-canvas") > 20
    picture = lambda: page.locator("#live-canvas").screenshot()
    settled_tip(page)
    first = picture()
    page.focus("#live-canvas")
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("+")
    page.wait_for_timeout(100)
    assert picture() != first
    before = settled_tip(page)
    page.focus('input[data-name="tendon_1"]')
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    assert math.dist(settled_tip(page), before) > 1e-3
    expect(page.locator("#live-state")).to_contain_text("Tip x")


def test_an_effect_that_cannot_be_is_said(page, serve):
    page.goto(serve("models/nominal.yaml"))
    expect(page.locator("#live-status")).to_have_text("converged")
    names = page.locator(".live-effect > label").all_text_contents()
    assert len(names) >= 24
    # Every effect of the catalogue with its first values, one after the other: no page error, and an answer.
    for name in names:
        box = page.locator(".live-effect > label", has_text=name).first.locator("input")
        box.check()
        page.wait_for_timeout(120)
        box.uncheck()
    expect(page.locator("#live-status")).to_have_text("converged")


def test_values_without_a_solution_are_dimmed(page, serve):
    page.goto(serve("models/nominal.yaml"))
    expect(page.locator("#live-status")).to_have_text("converged")
    settled_tip(page)
    assert page.locator(".live-stale").count() == 0
    page.evaluate(
        """() => document.querySelectorAll('.live-effect').forEach((effect) => {
          const box = effect.querySelector('input[type=checkbox]');
          if (!box.checked) box.click();
          effect.querySelectorAll('input[type=range]').forEach((input) => { input.value = input.max; input.dispatchEvent(new Event('input')); });
        })"""
    )
    expect(page.locator(".live-stale")).to_have_count(1, timeout=20_000)
    assert page.locator("#live-error").inner_text()


def test_sixty_frames_a_second(page, serve):
    page.goto(serve("models/nominal.yaml"))
    expect(page.locator("#live-status")).to_have_text("converged")
    rate = page.evaluate(
        """() => new Promise((done) => {
          let answers = 0;
          const watch = new MutationObserver(() => { answers += 1; });
          watch.observe(document.getElementById('live-time'), { childList: true, characterData: true, subtree: true });
          let drawn = 0;
          const begun = performance.now();
          const count = () => { drawn += 1; if (performance.now() - begun < 3000) requestAnimationFrame(count); else done([answers / 3, drawn / 3]); };
          requestAnimationFrame(count);
        })"""
    )
    print(f"answers {rate[0]:.1f}/s, pictures {rate[1]:.1f}/s")
    assert rate[0] > 30, rate


def test_looks(page, serve, screenshots):
    page.goto(serve("models/nominal.yaml"))
    expect(page.locator("#live-status")).to_have_text("converged")
    pull(page, 1, 0.008)
    pull(page, 2, 0.004)
    page.get_by_label("tip load").check()
    page.wait_for_timeout(1500)
    screenshots(page, "live")
    page.emulate_media(color_scheme="dark")
    screenshots(page, "live_dark")

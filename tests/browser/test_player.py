"""The player: play, scrub, keys, speed, print, and a page without scripts."""

import re

import pytest
from conftest import ROOT, ink

RECORDING = ("tests/data/twin/r12.csv", "--model", "models/nominal.yaml", "--trial", "2")


@pytest.fixture
def player(page, serve):
    page.goto(serve(*RECORDING))
    page.wait_for_selector(".scene-ready")
    return page


def time_s(page):
    return float(page.text_content(".scene-clock").split()[0])


def test_play_scrub_and_keys(player):
    assert ink(player, "canvas") > 20
    end = time_s(player)
    assert end > 1, "the last frame is shown first"
    player.click(".scene-play")
    player.wait_for_timeout(700)
    now = time_s(player)
    assert 0.3 < now < 1.5, now
    assert player.text_content(".scene-play") == "Pause"
    player.focus("canvas")
    player.keyboard.press(" ")
    stopped = time_s(player)
    player.wait_for_timeout(200)
    assert time_s(player) == stopped
    slider = player.locator(".scene-time")
    slider.evaluate("(input) => { input.value = 1; input.dispatchEvent(new Event('input')); }")
    player.wait_for_timeout(60)
    assert time_s(player) == 1.0
    assert player.text_content(".scene-state").startswith("At 1.0 s.")
    assert re.search(r"tip x -?\d+\.\d, y -?\d+\.\d, z -?\d+\.\d mm", player.text_content("output"))
    player.select_option(".scene-speed", "4")
    player.click(".scene-play")
    player.wait_for_timeout(500)
    player.click(".scene-play")
    assert time_s(player) > 2, "four times as fast"
    before = player.locator("canvas").screenshot()
    player.focus("canvas")
    for key in ("ArrowLeft", "ArrowUp", "+"):
        player.keyboard.press(key)
    player.wait_for_timeout(60)
    assert player.locator("canvas").screenshot() != before
    player.click(".scene-reset")
    player.focus(".scene-play")
    player.wait_for_timeout(60)
    box = player.locator("canvas").bounding_box()
    player.mouse.move(box["x"] + 100, box["y"] + 100)
    before = player.locator("canvas").screenshot()
    player.mouse.down()
    player.mouse.move(box["x"] + 160, box["y"] + 120)
    player.mouse.up()
    player.wait_for_timeout(60)
    assert player.locator("canvas").screenshot() != before


def test_without_scripts_a_still_remains(chromium, page, serve):
    address = serve(*RECORDING)
    context = chromium.new_context(java_script_enabled=False)
    plain = context.new_page()
    plain.goto(address)
    assert plain.locator('.scene-panel svg[role="img"]').is_visible()
    assert not plain.locator("canvas").is_visible()
    assert not plain.locator(".scene-controls").is_visible()
    context.close()


def test_a_recording_without_a_solution_says_so(page, serve, tmp_path):
    rows = ["trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m,tip_x_m,tip_y_m,tip_z_m"]
    rows += [f"0,{0.2 * step:.1f},{0.3 * step},0,0,0,0,0,0.22" for step in range(3)]
    (tmp_path / "far.csv").write_text("\n".join(rows) + "\n")
    page.goto(serve(tmp_path / "far.csv", "--model", "models/nominal.yaml"))
    page.wait_for_selector(".scene-ready")
    assert "no solution at this time" in page.locator("output").first.text_content()


def test_looks(player, screenshots):
    player.locator(".scene-time").evaluate("(input) => { input.value = 3; input.dispatchEvent(new Event('input')); }")
    screenshots(player, "player")
    player.emulate_media(color_scheme="dark")
    screenshots(player, "player_dark")


def test_a_discovery_shows_the_robot(page, run, screenshots, tmp_path):
    run("discover", "--model", "models/nominal.yaml", "--measured", "tests/data/twin/r12.csv", "--baseline", "tests/data/twin/baseline.csv", "--out", tmp_path)
    page.goto(f"file://{tmp_path}/report.html")
    page.wait_for_selector(".scene-ready")
    names = page.locator(".scene-panel h4").all_text_contents()
    assert len(names) == 2 and "tip_load" in names[1], names
    assert ink(page, "canvas") > 20
    page.click(".scene-play")
    page.wait_for_timeout(500)
    assert 0 < time_s(page) < 1.5
    page.click(".scene-play")
    screenshots(page, "discovery")


@pytest.mark.skipif(not (ROOT / "results/fig8/spec.yaml").is_file(), reason="no published results")
def test_the_path_under_four_policies(page, serve, screenshots):
    page.goto(serve("results/fig8"))
    page.wait_for_selector(".scene-ready")
    assert page.locator(".scene-panel").count() == 4
    outputs = page.locator("output").all_text_contents()
    assert all("from the target" in text for text in outputs)
    # A is done before C.
    assert re.match(r"finished at \d+\.\d s; ", outputs[0]) and not outputs[2].startswith("finished"), outputs
    assert "path of the target" in page.locator(".scene-key").inner_text()
    assert "repetition 1" in page.locator("h1").inner_text()
    size = page.evaluate("document.querySelector('.scene-data').textContent.length")
    print(f"{size} bytes of scenes")
    screenshots(page, "path")

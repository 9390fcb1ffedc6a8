"""The page of all published results: its numbers are those of the CSVs, its charts answer, everybody can use it."""

import csv
import json
import math
import re
import shutil

import pytest
from axe_playwright_python.sync_playwright import Axe
from conftest import ROOT

MOST_BYTES = 3_000_000


@pytest.fixture(scope="session")
def report(run, tmp_path_factory):
    file = tmp_path_factory.mktemp("report") / "report.html"
    run("report", "--out", file)
    return file


@pytest.fixture(scope="session")
def table(run, tmp_path_factory):
    """Reads a published table, packed or not."""
    folder = tmp_path_factory.mktemp("tables")

    def read(name):
        file = ROOT / name
        if not file.is_file():
            packed = folder / name.replace("/", "_").replace(".csv", ".parquet")
            if not packed.with_suffix(".csv").is_file():
                shutil.copy(file.with_suffix(".parquet"), packed)
                run("pack", "--undo", packed)
            file = packed.with_suffix(".csv")
        with file.open(newline="") as lines:
            return list(csv.DictReader(lines))

    return read


@pytest.fixture
def opened(page, report):
    page.goto(report.as_uri())
    page.wait_for_selector("figure.chart svg")
    return page


def test_the_page_is_one_small_file(report):
    text = report.read_text()
    assert len(text.encode()) <= MOST_BYTES
    assert 'src="http' not in text and "@import" not in text


def test_every_number_of_a_chart_is_in_its_csv(opened, table):
    data = json.loads(opened.text_content("#data"))
    assert len(data["charts"]) > 15
    for embedded in data["tables"]:
        rows = table(embedded["file"])
        for name, column in embedded["columns"].items():
            published = [row[name] for row in rows]
            if isinstance(column, dict):
                assert {column["levels"][code] for code in column["codes"]} <= set(published), (embedded["file"], name)
                continue
            known = {float(f"{float(cell):.4e}") for cell in published if cell}
            strange = {value for value in column if value is not None} - known
            assert not strange, (embedded["file"], name, list(strange)[:5])


def test_numbers_of_claims_and_table_1_are_those_of_the_csvs(opened, table):
    known = set()
    for name in ("results/claims.csv", "results/table1/summary.csv"):
        for row in table(name):
            for cell in row.values():
                try:
                    known.add(float(cell))
                except ValueError:
                    pass
    shown = opened.eval_on_selector_all("data", "all => all.map(one => [+one.value, one.textContent])")
    assert len(shown) > 200
    for value, text in shown:
        assert value in known, (value, text)
        number = float(text.replace("−", "-"))
        digits = len(text.split(".")[1]) if "." in text else 0
        scales = (1.0, 1000.0)
        assert any(math.isclose(number, scale * value, abs_tol=0.51 * 10**-digits) for scale in scales), (value, text)


def test_every_claim_is_there_with_range_verdict_and_command(opened, table):
    rows = table("results/claims.csv")
    lines = opened.locator("tr[data-verdicts]")
    assert lines.count() == len({(row["experiment"], row["claim"]) for row in rows})
    assert opened.locator("tr[data-verdicts] .verdict").count() == len(rows)
    text = opened.locator("tr[data-verdicts]", has_text="--claim c_beats_pi_real_closed").inner_text()
    for part in ("< 0 mm", "reproduced", "undecided", "[", "mean error (C, closed loop)"):
        assert part in text, (part, text)


def test_claims_are_filtered_by_verdict(opened):
    lines = opened.locator("tr[data-verdicts]:visible")
    every = lines.count()
    choices = opened.get_by_role("group", name="Show claims")
    choices.get_by_role("button", name="undecided", exact=True).click()
    assert 0 < lines.count() < every
    assert all("undecided" in verdicts for verdicts in lines.evaluate_all("all => all.map(one => one.dataset.verdicts)"))
    choices.get_by_role("button", name="all", exact=True).click()
    assert lines.count() == every


def test_too_few_repetitions_are_printed(opened, table):
    rows = [row for row in table("results/claims.csv") if int(row["seeds"]) < 10]
    assert opened.locator(".too-few").count() == len(rows) > 0
    assert all(row["verdict"] == "undecided" for row in rows)
    failed = [row for row in table("results/fig8/summary.csv") if row["status"] != "ok"]
    reason = opened.locator("#claims").inner_text()
    assert all(row["status"] in reason for row in failed)


def test_counts_of_verdicts_add_up(opened):
    for tile in opened.locator(".tiles > div").all():
        total, *parts = [int(number) for number in re.findall(r"\d+", tile.inner_text())]
        assert total == sum(parts), tile.inner_text()


def test_repair_is_what_its_tables_say(opened, table):
    rows = table("results/repair/repairs.csv")
    alarms = sum(bool(row["alarm_s"]) for row in rows)
    text = opened.locator("#repair p").first.inner_text()
    assert f"raised an alarm in {alarms} of {len(rows)} cases" in text, text


def test_contents_lead_to_their_parts(opened):
    links = opened.locator(".contents a").evaluate_all("all => all.map(one => one.getAttribute('href'))")
    assert len(links) > 10
    assert all(opened.locator(link).count() == 1 for link in links)
    every = opened.locator("main a").evaluate_all("all => all.map(one => one.getAttribute('href'))")
    assert all(opened.locator(link).count() == 1 for link in every), every


def test_only_possible_choices_are_offered(opened):
    chart = opened.locator("#repair figure.chart")
    integral = chart.get_by_role("button", name="Integral", exact=True)
    assert integral.is_disabled()
    chart.get_by_role("button", name="Closed loop").click()
    assert integral.is_enabled()
    integral.click()
    chart.get_by_role("button", name="Open loop").click()
    assert chart.locator(".plot .mark").count() > 0
    empty = opened.locator("figure.chart .controls button").evaluate_all("all => all.filter(one => !one.textContent.trim()).length")
    assert empty == 0


def test_paper_shows_what_is_selected(opened):
    opened.emulate_media(media="print")
    shown = opened.locator("#repair .selection")
    assert shown.is_visible() and shown.inner_text() == "Selected: Open loop; A."


def test_axes_stay_without_series(opened):
    chart = opened.locator("figure.chart", has_text="(a) π_real: error against real points")
    ticks = lambda: chart.locator(".plot text").all_text_contents()
    chart.get_by_role("button", name="Closed loop").click()
    chart.get_by_role("button", name="Open loop").click()
    assert "5000" in ticks() and chart.locator(".plot .mark").count() == 0


def test_charts_answer_to_pointer_keys_and_buttons(opened):
    chart = opened.locator("figure.chart", has_text="(a) π_real: error against real points")
    chart.scroll_into_view_if_needed()
    before = chart.locator("svg").last.inner_html()
    chart.get_by_role("button", name="convergence").click()
    assert chart.locator("svg").last.inner_html() != before
    marks = chart.locator(".plot .mark")
    count = marks.count()
    chart.get_by_role("button", name="Open loop").click()
    assert marks.count() == count / 2
    chart.get_by_role("button", name="Open loop").click()
    chart.locator(".plot svg").focus()
    opened.keyboard.press("ArrowRight")
    tip = chart.locator(".tip").inner_text()
    assert "mean error (mm)" in tip and "[" in tip, tip
    marks.first.hover()
    assert "real points" in chart.locator(".tip").inner_text()
    chart.locator("summary").click()
    # A browser reports an opened table after the click has returned.
    chart.locator(".numbers tbody tr").first.wait_for()
    assert chart.locator(".numbers tbody tr").count() > 4


def test_the_robot_moves_on_the_path(opened):
    player = opened.locator(".scene-player").first
    player.scroll_into_view_if_needed()
    assert player.locator("canvas").count() == 4
    player.locator(".scene-play").click()
    opened.wait_for_timeout(400)
    assert player.locator(".scene-play").inner_text() == "Pause"


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(opened, scheme):
    opened.emulate_media(color_scheme=scheme)
    found = Axe().run(opened)
    serious = [fault for fault in found.response["violations"] if fault["impact"] in ("serious", "critical")]
    assert not serious, [(fault["id"], [node["html"][:120] for node in fault["nodes"][:4]]) for fault in serious]


def test_screenshots_fit(opened, screenshots):
    screenshots(opened, "report")

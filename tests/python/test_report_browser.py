# SPDX-License-Identifier: GPL-3.0-or-later
"""The report in a real browser: headless Chromium with software rendering."""

from __future__ import annotations

import base64
import io
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from evaluations import COUNTS, RUN_METHODS
from processes import wait_until

webdriver = pytest.importorskip("selenium.webdriver")
image = pytest.importorskip("PIL.Image")


@pytest.fixture(scope="module")
def output(evaluation) -> Path:
    return evaluation / "out"


@pytest.fixture(scope="module")
def browser(output):
    binary = shutil.which("chromium") or shutil.which("chromium-browser")
    driver = shutil.which("chromedriver")
    if not binary or not driver:
        pytest.skip("Chromium and its driver are not installed (Debian: chromium chromium-driver)")
    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for argument in (
        "--headless=new",
        "--no-sandbox",
        "--disable-dev-shm-usage",
        "--enable-unsafe-swiftshader",
        "--use-angle=swiftshader",
        "--window-size=1200,900",
    ):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    service = webdriver.chrome.service.Service(driver)
    with webdriver.Chrome(options=options, service=service) as chrome:
        # Offline: whatever the page wanted from elsewhere would fail and be logged.
        chrome.execute_cdp_cmd("Network.enable", {})
        chrome.execute_cdp_cmd("Network.setBlockedURLs", {"urls": ["http://*", "https://*"]})
        chrome.get((output / "report.html").as_uri())
        wait_until(lambda: chrome.execute_script("return Boolean(window.spherosegViewer)"))
        yield chrome


def canvas_pixels(browser) -> np.ndarray:
    data = browser.execute_script(
        "spherosegViewer.draw(); return spherosegViewer.canvas.toDataURL('image/png')"
    )
    raw = base64.b64decode(data.split(",", 1)[1])
    return np.asarray(image.open(io.BytesIO(raw)).convert("RGB")).astype(int)


def choose(browser, menu: int, title: str) -> None:
    browser.execute_script(
        "const menu = document.querySelectorAll('#viewer select')[arguments[0]];"
        "menu.value = [...menu.options].find((o) => o.text.startsWith(arguments[1])).value;"
        "menu.dispatchEvent(new Event('change'));",
        menu,
        title,
    )


def shown(browser) -> str:
    return browser.execute_script("return document.getElementById('viewer').dataset.shown")


def note(browser) -> str:
    return browser.execute_script("return document.querySelector('#viewer output').textContent")


def test_console_is_silent(browser):
    assert browser.get_log("browser") == []


def test_table_has_a_row_per_mesh_count_and_method_with_the_right_numbers(browser, output):
    rows = browser.execute_script(
        "return [...document.querySelectorAll('#table1 tbody tr')].map((row) => [row.dataset.mesh,"
        " Number(row.dataset.k), row.dataset.method,"
        " Number(row.querySelector('[data-measure]').textContent.replace(',', ''))])"
    )
    expected = [
        [row["mesh"], row["submesh_count"], row["method"], row["boundary_edge_count"]]
        for row in json.loads((output / "results.json").read_text())["rows"]
    ]
    assert rows == expected
    assert len(rows) == 2 * len(RUN_METHODS) * len(COUNTS)


def test_view_draws_the_mesh_in_many_colours_and_turns(browser):
    before = canvas_pixels(browser)
    drawn = (before < 250).any(axis=2)
    assert 0.1 < drawn.mean() < 0.9
    assert len(np.unique(before[drawn] // 32, axis=0)) >= 6
    assert not drawn[:3].any()
    browser.execute_script("spherosegViewer.turn(0.5, 0.3)")
    assert (canvas_pixels(browser) != before).any(axis=2).mean() > 0.03
    browser.execute_script("spherosegViewer.scale(0.5)")
    smaller = (canvas_pixels(browser) < 250).any(axis=2).mean()
    assert smaller == pytest.approx(drawn.mean() / 4, rel=0.25)
    browser.execute_script("spherosegViewer.scale(2)")


def test_click_picks_the_submesh_under_the_pointer(browser, output):
    choose(browser, 0, "second")
    choose(browser, 1, "Region growing, k = 16")
    wait_until(lambda: shown(browser) == "Region growing, k = 16")
    browser.execute_script("spherosegViewer.turn(0.13, 0.17)")  # no vertex lies in the middle
    canvas = browser.find_element("css selector", "#viewer canvas")
    webdriver.ActionChains(browser).move_to_element(canvas).click().perform()
    wait_until(lambda: note(browser).startswith("Sub-mesh"))
    # The triangle in the middle that is nearest to the eye, by the view's own matrix.
    view = browser.execute_script("return [...spherosegViewer.view(0)]")
    matrix = np.array(view).reshape(4, 4).T
    with np.load(output / "labels" / "second.npz") as arrays:
        vertices, faces = arrays["vertices"], arrays["faces"]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    vertices = (vertices - (low + high) / 2) / (high - low).max() * 2  # as the view has them
    place = (matrix @ np.column_stack((vertices, np.ones(len(vertices)))).T).T[:, :3]
    corners = place[faces]
    signs = np.stack(
        [
            corners[:, i, 0] * corners[:, (i + 1) % 3, 1]
            - corners[:, i, 1] * corners[:, (i + 1) % 3, 0]
            for i in range(3)
        ]
    )
    hit = np.flatnonzero((signs >= 0).all(axis=0) | (signs <= 0).all(axis=0))
    front = hit[np.argmin(corners[hit, :, 2].mean(axis=1))]
    labels = np.load(output / "labels" / "second-k16-region_growing.npy")
    count = np.count_nonzero(labels == labels[front])
    assert note(browser).startswith(f"Sub-mesh {labels[front]}: {count} triangles, ")
    assert (canvas_pixels(browser)[..., 2] < 100).mean() > 0.005  # lit up in yellow


def test_no_turn_cuts_the_mesh_off(browser):
    for mesh in ("first", "second"):
        browser.execute_script("document.getElementById('viewer').dataset.shown = ''")
        choose(browser, 0, mesh)
        wait_until(lambda: shown(browser) == "All pairs, k = 5")
        for _ in range(8):
            browser.execute_script("spherosegViewer.turn(0.4, 0.4)")
            drawn = (canvas_pixels(browser) < 250).any(axis=2)
            assert drawn.any()
            assert not any(edge.any() for edge in (drawn[:3], drawn[-3:], drawn[:, :3]))


def test_counts_of_one_are_told_in_the_singular(browser):
    def told(*counts: int) -> str:
        return browser.execute_script(
            "const [triangles, vertices, edges, bowties] = arguments;"
            "const kept = spherosegViewer.counts;"
            "spherosegViewer.counts = {triangles, vertices, edges, bowties};"
            "spherosegViewer.picked = 0;"
            "spherosegViewer.tell();"
            "spherosegViewer.counts = kept;"
            "return spherosegViewer.note.textContent",
            *([count] for count in counts),
        )

    assert told(1, 1, 1, 1) == "Sub-mesh 0: 1 triangle, 1 vertex, 1 boundary edge, 1 bowtie"
    assert told(2, 4, 0, 2) == "Sub-mesh 0: 2 triangles, 4 vertices, 0 boundary edges, 2 bowties"


def test_click_beside_the_mesh_picks_nothing(browser):
    browser.execute_script("spherosegViewer.pick(2, 2)")
    assert note(browser).startswith("Click or tap")


def test_arrow_keys_turn_the_view(browser):
    before = canvas_pixels(browser)
    canvas = browser.find_element("css selector", "#viewer canvas")
    canvas.send_keys("\ue014")  # arrow right
    assert (canvas_pixels(browser) != before).any()


def test_every_labelling_can_be_shown(browser):
    for mesh in ("first", "second"):
        choose(browser, 0, mesh)
        wait_until(lambda: shown(browser) == "All pairs, k = 5")
        for title in ("METIS k-way, k = 16", "All pairs, k = 16", "All pairs, k = 5"):
            choose(browser, 1, title)
            wait_until(lambda title=title: shown(browser) == title)
            assert (canvas_pixels(browser) < 250).any()


def test_of_two_choices_the_later_one_is_shown_in_the_end(browser):
    choose(browser, 0, "first")
    wait_until(lambda: shown(browser) == "All pairs, k = 5")
    left = browser.execute_async_script(
        "const done = arguments[0], menu = document.querySelector('#viewer select');"
        "const places = () => [...spherosegViewer.positions].join();"
        "const wanted = places(), original = unpack;"
        "let calls = 0;"
        # The one chosen first takes longer: two arrays of a mesh, four of a labelling.
        "window.unpack = async (text) => {"
        "    if (calls++ < 2) await new Promise((go) => setTimeout(go, 300));"
        "    return original(text); };"
        "for (const index of [1, 0]) {"
        "    menu.selectedIndex = index; menu.dispatchEvent(new Event('change')); }"
        "setTimeout(() => { window.unpack = original; done([calls, places() === wanted]); }, 1500)"
    )
    assert left == [12, True]


def test_phone_screen_needs_no_sideways_scrolling(browser):
    metrics = {"width": 380, "height": 760, "deviceScaleFactor": 2, "mobile": True}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    try:
        width = browser.execute_script("return document.documentElement.scrollWidth")
        assert width <= 380
        assert (canvas_pixels(browser) < 250).any()
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_long_names_leave_the_numbers_on_the_screen(browser):
    beyond = browser.execute_script(
        "const places = [document.querySelector('#table1 .name'), document.querySelector('h3')];"
        "const kept = places.map((place) => place.textContent);"
        "for (const place of places) place.textContent = 'scans/2026_'.repeat(20);"
        "const box = document.getElementById('table1').parentElement;"
        "const beyond = [document.documentElement, box].map((e) => e.scrollWidth - e.clientWidth);"
        "places.forEach((place, i) => { place.textContent = kept[i]; });"
        "return beyond"
    )
    assert beyond == [0, 0]


def test_wide_table_scrolls_within_the_screen(browser):
    box = browser.execute_script(
        "const box = document.getElementById('table1').parentElement;"
        "return [box.scrollWidth - box.clientWidth, box.clientHeight, innerHeight]"
    )
    assert box[0] == 0  # all columns fit into the width of 1200
    assert box[1] < box[2]  # and elsewhere the bar below the table can be reached


def test_page_prints(browser):
    printed = browser.execute_cdp_cmd("Page.printToPDF", {"printBackground": True})
    assert base64.b64decode(printed["data"])[:5] == b"%PDF-"
    visible = browser.execute_script(
        "return [...document.styleSheets[0].cssRules].some((r) => r.conditionText === 'print')"
    )
    assert visible


def test_what_is_folded_on_the_screen_is_unfolded_on_paper(browser):
    browser.execute_script(
        "document.body.insertAdjacentHTML('beforeend',"
        " '<details><summary>Left out</summary><p>reason</p></details>')"
    )
    visible = "return document.querySelector('details p').checkVisibility()"
    assert not browser.execute_script(visible)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    assert browser.execute_script(visible)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    browser.execute_script("document.querySelector('details').remove()")


def test_console_is_still_silent_at_the_end(browser):
    assert browser.get_log("browser") == []

# SPDX-License-Identifier: MIT
"""Opens reports of `run` and `compare` in headless Chromium and reads them as a person would.

usage: report_browser_test.py DYNFILTER CHROMIUM [--pictures FOLDER]
Exits with 77, which CTest shows as skipped, where CHROMIUM cannot be started.
"""

import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from xml.etree import ElementTree

from browser import Browser, BrowserError

SKIPPED = 77
LONG = "DYNFILTER_LONG_TESTS" in os.environ
WIDTHS = (1400, 400)
HOSTILE = "<img src=x onerror=alert(1)>"
# `var uPlot = ...` of the library cannot replace it: the page as built without it.
NO_UPLOT = "Object.defineProperty(window, 'uPlot', { value: undefined, writable: false, configurable: false });"

failures = []


def check(condition, what):
    if not condition:
        failures.append(what)
        print("FAILED: " + what)


def equal(got, wanted, what):
    check(got == wanted, f"{what}: {got!r}, expected {wanted!r}")


def run(*arguments):
    done = subprocess.run(arguments, capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(f"{' '.join(arguments)}: {done.stderr}")


def read(file):
    with open(file, encoding="utf-8") as text:
        return json.load(text)


def value_of(summary, key):
    for part in key.split("."):
        summary = summary[part]
    return summary


def number(text):
    return None if text == "null" else float(text)


# ---- checks of any report


def check_quiet(browser, name):
    equal(browser.problems, [], f"{name}: console")
    equal(browser.dialogs, [], f"{name}: dialogs")
    outside = [url for url in browser.requests if not url.startswith(("data:", "file:", "about:"))]
    files = {url for url in browser.requests if url.startswith("file:")}
    equal(outside, [], f"{name}: requests")
    equal(len(files), 1, f"{name}: files read")


def check_layout(browser, name, width):
    equal(browser.evaluate("document.documentElement.scrollWidth <= innerWidth"), True, f"{name} at {width} px fits the width")
    texts = browser.evaluate("document.body.innerText")
    for wrong in ("NaN", "undefined", "Infinity", "[object"):
        check(wrong not in texts, f"{name}: text with {wrong}")


def check_accessible(browser, name):
    equal(browser.evaluate("[...document.querySelectorAll('img')].filter(i => !i.alt).length"), 0, f"{name}: pictures without alt")
    equal(browser.evaluate("[...document.querySelectorAll('[role=img], [role=application], [role=region], input')]"
                           ".filter(e => !e.getAttribute('aria-label')).length"), 0, f"{name}: parts without a label")
    equal(browser.evaluate("[...document.querySelectorAll('button')].filter(b => !(b.innerText || b.ariaLabel)).length"), 0,
          f"{name}: buttons without a name")
    equal(browser.evaluate("[...document.querySelectorAll('button, input, summary, [role=application]')]"
                           ".filter(e => e.tabIndex < 0).length"), 0, f"{name}: out of reach of the keyboard")
    equal(browser.evaluate("document.querySelector('meta[http-equiv]').content.startsWith(\"default-src 'none'\")"), True, f"{name}: policy")


def check_keys(browser, name):
    """Arrow keys, Home and End go through the frames, from wherever the page has the focus."""
    last = browser.evaluate("Number(document.getElementById('frame-slider').max)")
    browser.evaluate("document.activeElement.blur()")
    shown = "Number(document.getElementById('frame-slider').value)"
    for key, code, wanted in (("Home", 36, 0), ("ArrowRight", 39, min(1, last)), ("End", 35, last), ("ArrowLeft", 37, max(0, last - 1)),
                              ("PageUp", 33, max(0, last - 11))):
        browser.key(key, code)
        equal(browser.evaluate(shown), wanted, f"{name}: frame after {key}")


def check_saved(browser, name):
    """Every button that saves gives an SVG which names its plot and needs no style sheet."""
    browser.evaluate("window.saved = []; URL.createObjectURL = blob => (window.saved.push(blob), 'blob:x'); HTMLAnchorElement.prototype.click = () => {}")
    titles = browser.evaluate("[...document.querySelectorAll('button')].filter(b => b.innerText === 'save SVG').map(b => (b.click(), b.closest('figure').querySelector('figcaption').firstChild.textContent))")
    texts = browser.evaluate("Promise.all(window.saved.map(blob => blob.text()))")
    equal(len(texts), len(titles), f"{name}: saved plots")
    check(len(texts) >= 4, f"{name}: {len(texts)} plots to save")
    for title, text in zip(titles, texts):
        root = ElementTree.fromstring(text)
        equal(root.tag, "{http://www.w3.org/2000/svg}svg", f"{name}: {title} is SVG")
        check(title.strip() in "".join(root.itertext()), f"{name}: the title of {title}")
        check("class=" not in text and "var(" not in text and "NaN" not in text, f"{name}: {title} stands alone")
        shapes = [part for part in root.iter() if part.tag.rpartition("}")[2] in ("path", "circle", "rect", "line")]
        check(len(shapes) > 3, f"{name}: {title} has {len(shapes)} shapes")


def errors_of(run):
    return [e for e in run["frames"]["error_m"] if e is not None]


def check_statistics(browser, name):
    """Those of evo, computed here once more."""
    runs = browser.evaluate("JSON.parse(document.getElementById('data').textContent).runs")
    for k, run in enumerate(runs):
        errors, shown = errors_of(run), f"[...document.querySelectorAll('tr:nth-child({k + 1}) [data-statistic]')]"
        cells = dict(browser.evaluate(shown + ".map(c => [c.dataset.statistic, Number(c.dataset.value)])"))
        wanted = {"n": len(errors), "rmse": math.sqrt(statistics.mean(e * e for e in errors)), "mean": statistics.mean(errors),
                  "median": statistics.median(errors), "std": statistics.pstdev(errors), "min": min(errors), "max": max(errors)}
        equal(set(cells), set(wanted), f"{name}: statistics of run {k}")
        for key in wanted:
            check(abs(cells[key] - wanted[key]) < 1e-9, f"{name}: {key} of run {k}: {cells[key]}, {wanted[key]}")


def check_slider(browser, name):
    """The slider moves the cursor of every plot, of the paths and the picture."""
    last = browser.evaluate("Number(document.getElementById('frame-slider').max)")
    lines = "[...document.querySelectorAll('.frame-line, .frame-line-svg')]"
    places = []
    for frame in (0, last):
        browser.evaluate(f"(s => {{ s.value = {frame}; s.dispatchEvent(new Event('input')); }})(document.getElementById('frame-slider'))")
        browser.settle()
        cursors = browser.evaluate(lines + ".map(l => Number(l.dataset.frame))")
        check(len(cursors) >= 3, f"{name}: plots with a cursor: {len(cursors)}")
        equal(set(cursors), {frame}, f"{name}: cursors at frame {frame}")
        equal(browser.evaluate("[...document.querySelectorAll('.path-view > g')].map(g => Number(g.dataset.frame))"), [frame, frame],
              f"{name}: cursors of the paths")
        places.append(browser.evaluate(lines + ".map(l => l.getBoundingClientRect().left)"))
        if browser.evaluate("document.querySelectorAll('.picture img').length") > 0:
            nearest = browser.evaluate("Number(document.querySelector('.picture img').dataset.frame)")
            check(abs(nearest - frame) < last / 2 + 1, f"{name}: picture of frame {nearest} at {frame}")
    if last > 0:
        check(all(b > a + 50 for a, b in zip(*places)), f"{name}: cursors do not move: {places}")
        browser.evaluate("document.getElementById('frame-slider').focus()")
        browser.key("ArrowLeft", 37)
        equal(browser.evaluate("Number(document.querySelector('.frame-line, .frame-line-svg').dataset.frame)"), last - 1,
              f"{name}: the left arrow key")


def check_figures(browser, name, shown, summary):
    """Every figure that `shown` selects is that of the summary."""
    cells = browser.evaluate(f"[...document.querySelectorAll({json.dumps(shown)})].map(c => [c.dataset.key, c.dataset.value, c.innerText])")
    check(len(cells) >= 6, f"{name}: {len(cells)} figures at {shown}")
    for key, value, text in cells:
        wanted = value_of(summary, key)
        equal(number(value), wanted, f"{name}: {key}")
        if wanted is None:
            equal(text, "\u2013", f"{name}: text of {key}")
        else:
            digits = len(text.split(" ")[0].partition(".")[2])
            check(abs(float(text.split(" ")[0]) - wanted) <= 0.5 * 10 ** -digits + 1e-9, f"{name}: {key} reads {text}, is {wanted}")


def check_all(browser, file, name, before=""):
    for width in WIDTHS:
        for dark in (False, True):
            browser.open(file, width, dark=dark, before=before)
            check_layout(browser, name, width)
            check_quiet(browser, f"{name} at {width} px, {'dark' if dark else 'light'}")
    browser.open(file, WIDTHS[0], before=before)
    check_accessible(browser, name)
    check_slider(browser, name)
    check_keys(browser, name)
    check_saved(browser, name)
    equal(browser.problems, [], f"{name}: console after use")


def check_zoom(browser, name):
    """A click enlarges a picture to the window, Escape ends that, other keys do not."""
    width = "document.querySelector('.picture img').getBoundingClientRect().width"
    small = browser.evaluate(width)
    browser.evaluate("document.querySelector('.picture img').click()")
    equal(browser.evaluate(width), WIDTHS[0], f"{name}: width of a zoomed picture")
    browser.key("ArrowLeft", 37)
    equal(browser.evaluate(width), WIDTHS[0], f"{name}: zoomed at another frame")
    browser.key("Escape", 27)
    equal(browser.evaluate(width), small, f"{name}: width after Escape")


# ---- one report each


def check_run(browser, out, pipeline):
    file, summary = os.path.join(out, "report.html"), read(os.path.join(out, "summary.json"))
    check_all(browser, file, "run")
    check_zoom(browser, "run")
    check_figures(browser, "run", f"[data-pipeline='{pipeline}']", summary)
    for reference in ("none", "oracle"):
        beside = read(os.path.join(os.path.dirname(out), reference, "summary.json"))
        check_figures(browser, "run beside " + reference, f"[data-pipeline='{reference}']", beside)
    data = "JSON.parse(document.getElementById('data').textContent)"
    errors = [e for e in browser.evaluate(data + ".runs[0].frames.error_m") if e is not None]
    rms = math.sqrt(sum(e * e for e in errors) / len(errors))
    check(abs(rms - summary["ate_rmse_m"]) < 1e-5, f"rms of the errors {rms}, ATE {summary['ate_rmse_m']}")

    # A click on a plot, a drag that zooms all of them, the path and the map by keyboard and mouse.
    browser.evaluate("document.querySelector('.plot').scrollIntoView()")
    if browser.evaluate("typeof uPlot !== 'undefined'"):
        box = browser.evaluate("(r => [r.left, r.top, r.width, r.height])(document.querySelector('.u-over').getBoundingClientRect())")
        middle = box[1] + box[3] / 2
        browser.drag((box[0] + box[2] * 0.25, middle), (box[0] + box[2] * 0.25, middle))
        quarter = browser.evaluate("Number(document.querySelector('.frame-line').dataset.frame)")
        last = browser.evaluate("Number(document.getElementById('frame-slider').max)")
        check(abs(quarter - last / 4) <= 1, f"a click at a quarter chose frame {quarter} of {last}")
        places = "[...document.querySelectorAll('.frame-line')].map(l => Math.round(l.getBoundingClientRect().left))"
        before = browser.evaluate(places)
        browser.drag((box[0] + box[2] * 0.1, middle), (box[0] + box[2] * 0.6, middle))
        after = browser.evaluate(places)
        check(all(a > b + 10 for a, b in zip(after, before)), f"a drag zooms all plots: {before}, {after}")
    for part in ("path-view", "map"):
        content = ("document.querySelector('.path-view').innerHTML" if part == "path-view"
                   else "document.querySelector('.map').toDataURL()")
        old = browser.evaluate(content)
        browser.evaluate(f"document.querySelector('.{part}').scrollIntoView({{ block: 'center' }}); document.querySelector('.{part}').focus()")
        browser.key("ArrowLeft", 37)
        turned = browser.evaluate(content)
        check(old != turned, f"{part}: the arrow key changes nothing")
        box = browser.evaluate(f"(r => [r.left, r.top, r.width, r.height])(document.querySelector('.{part}').getBoundingClientRect())")
        browser.drag((box[0] + box[2] / 2, box[1] + box[3] / 2), (box[0] + box[2] / 2 + 60, box[1] + box[3] / 2 + 20))
        check(browser.evaluate(content) != turned, f"{part}: the mouse changes nothing")
    browser.evaluate("document.querySelector('.theme').click()")
    browser.settle()
    equal(browser.evaluate("getComputedStyle(document.body).backgroundColor"), "rgb(20, 23, 27)", "the dark theme")
    equal(browser.problems, [], "run: console after all")


def check_marks(browser, out):
    """Late results are listed, and a click goes there."""
    browser.open(os.path.join(out, "report.html"), WIDTHS[0])
    equal(browser.evaluate("[...document.querySelectorAll('.marks summary')].some(s => s.innerText.startsWith('late'))"), True, "late frames are listed")
    browser.evaluate("document.querySelector('.chips button').click()")
    browser.settle()
    first = browser.evaluate("document.querySelector('.chips button').innerText.split('–')[0]")
    check(browser.evaluate("document.querySelector('.frame-text').innerText").startswith(f"frame {first},"), "a mark is a link")
    equal(browser.problems, [], "late: console")


def check_compare(browser, out):
    file, rows = os.path.join(out, "report.html"), read(os.path.join(out, "summary.json"))["rows"]
    check_all(browser, file, "compare")
    for k, row in enumerate(rows):
        check_figures(browser, f"compare, row {k}", f"tbody tr:nth-child({k + 1}) [data-key]", row)
    # Sorted by ATE, both ways.
    ate = "[...document.querySelectorAll('tbody tr [data-key=ate_rmse_m]')].map(c => Number(c.dataset.value))"
    head = "[...document.querySelectorAll('thead button')].find(b => b.innerText.startsWith('ATE')).click()"
    wanted = sorted(row["ate_rmse_m"] for row in rows)
    for order in (wanted, wanted[::-1]):
        browser.evaluate(head)
        equal(browser.evaluate(ate), order, "compare: sorted by ATE")
    # A switch takes a run's lines away.
    lines = "document.querySelectorAll('.plot')[0].querySelectorAll('.legend li').length"
    equal(browser.evaluate(lines), len(rows), "compare: lines of the error")
    browser.evaluate("[...document.querySelectorAll('tbody tr:not(.focus) input')][0].click()")
    browser.settle()
    equal(browser.evaluate(lines), len(rows) - 1, "compare: lines after a switch")
    # A name chooses the run and its map.
    maps = {row["pipeline"]: row["map"]["points"] for row in rows}
    shown = "Number(document.querySelector('.map-figure .hint').innerText.match(/of ([0-9,]+) points/)[1].replaceAll(',', ''))"
    first = browser.evaluate("document.querySelector('tbody tr.focus .choose').innerText")
    equal(browser.evaluate(shown), maps[first], "compare: points of the first map")
    browser.evaluate("document.querySelector('tbody tr:not(.focus) .choose').click()")
    browser.settle()
    chosen = browser.evaluate("document.querySelector('tbody tr.focus .choose').innerText")
    equal(browser.evaluate(shown), maps[chosen], "compare: points of the chosen map")
    check(chosen != first, "compare: another run is chosen")
    check(chosen in browser.evaluate("document.querySelector('.about').innerText"), "compare: a name chooses the run")
    equal(browser.problems, [], "compare: console after use")


def check_beside(browser, out):
    """Two pipelines at one frame, whatever the slider says; a choice changes one of them."""
    browser.open(os.path.join(out, "report.html"), WIDTHS[0])
    images = "[...document.querySelectorAll('.beside img')].map(i => [Number(i.dataset.frame), i.dataset.run])"
    for frame in (2, 9):
        browser.evaluate(f"(s => {{ s.value = {frame}; s.dispatchEvent(new Event('input')); }})(document.getElementById('frame-slider'))")
        browser.settle()
        (left, one), (right, other) = browser.evaluate(images)
        equal((left, right), (frame, frame), "beside: frames")
        check(one != other, "beside: one pipeline twice")
    browser.evaluate("(s => { s.value = 'oracle'; s.dispatchEvent(new Event('change')); })(document.querySelector('.beside select'))")
    equal([run for _, run in browser.evaluate(images)], ["oracle", other], "beside: after a choice")


def check_variants(browser, out):
    """A box per pipeline over its runs. The errors of `none` are ten times the others': on a logarithmic scale."""
    file, rows = os.path.join(out, "report.html"), read(os.path.join(out, "summary.json"))["rows"]
    check_all(browser, file, "variants")
    check_statistics(browser, "variants")
    plots = browser.evaluate("[...document.querySelectorAll('.boxes')].map(f => [f.querySelector('figcaption').firstChild.textContent,"
                             "f.querySelectorAll('.box').length, f.querySelectorAll('.box-dot').length, f.querySelector('svg').ariaLabel])")
    ates = [row["ate_rmse_m"] for row in rows if row["pipeline"] == "none"]
    equal([plots[0][0], plots[0][1], plots[0][2]], ["ATE", 2, 12], "variants: boxes of the ATE, dots")
    check(f"none: median {statistics.median(ates):.4f}, from {min(ates):.4f} to {max(ates):.4f}" in plots[0][3], f"variants: {plots[0][3]}")
    medians = [statistics.median(row["ate_rmse_m"] for row in rows if row["pipeline"] == p) for p in ("none", "oracle")]
    pressed = "document.querySelector('.boxes button').getAttribute('aria-pressed')"
    equal(browser.evaluate(pressed), str(medians[0] > 10 * medians[1]).lower(), "variants: the scale")
    ticks = "[...document.querySelectorAll('.boxes')[0].querySelectorAll('.tick')].map(t => t.textContent)"
    before = browser.evaluate(ticks)
    browser.evaluate("document.querySelector('.boxes button').click()")
    check(browser.evaluate(ticks) != before, "variants: the other scale has other ticks")


def make_report(dynfilter, root):
    walk, runs = os.path.join(root, "walk"), os.path.join(root, "runs")
    run(dynfilter, "synth", "walking_xyz", walk, "--frames", "16", "--seed", "3")
    os.mkdir(runs)
    for pipeline in ("none", "oracle"):
        run(dynfilter, "run", walk, "--pipeline", pipeline, "--out", os.path.join(runs, pipeline))
    run(dynfilter, "run", walk, "--pipeline", "dynfilter", "--out", os.path.join(runs, "own"), "--map", os.path.join(root, "map.ply"))


def make_more_reports(dynfilter, root):
    walk, odd = os.path.join(root, "walk"), os.path.join(root, HOSTILE)
    run(dynfilter, "synth", "static_desk", odd, "--frames", "1")
    run(dynfilter, "run", walk, "--pipeline", "rts_slam", "--detector-mode", "late:3", "--out", os.path.join(root, "late"))
    run(dynfilter, "compare", walk, "--pipelines", "none,dynfilter,oracle", "--out", os.path.join(root, "compared"),
        "--map", os.path.join(root, "maps"))
    run(dynfilter, "compare", walk, "--pipelines", "none,oracle", "--variants", "--out", os.path.join(root, "variants"))
    # Nothing to compare with, one frame, and a name that is a program.
    for name in ("groundtruth.txt", "detections.txt"):
        os.remove(os.path.join(odd, name))
    for name in ("labels", "dynamic", "masks"):
        os.rename(os.path.join(odd, name), os.path.join(odd, "no_" + name))
    run(dynfilter, "run", odd, "--pipeline", "dynfilter", "--out", os.path.join(root, "odd"))


def check_more(browser, root):
    check_marks(browser, os.path.join(root, "late"))
    check_compare(browser, os.path.join(root, "compared"))
    check_beside(browser, os.path.join(root, "compared"))
    check_variants(browser, os.path.join(root, "variants"))
    check_all(browser, os.path.join(root, "odd", "report.html"), "one frame of a hostile name")
    check(HOSTILE in browser.evaluate("document.querySelector('h1').innerText"), "the name is shown as it is")
    check_all(browser, os.path.join(root, "compared", "report.html"), "without uPlot", NO_UPLOT)
    check(browser.evaluate("document.getElementById('no-uplot') !== null"), "without uPlot: the page says so")
    check(browser.evaluate("document.querySelectorAll('.plain-plot path').length") > 5, "without uPlot: lines")


def main():
    dynfilter, chromium = sys.argv[1:3]
    try:
        browser = Browser(chromium)
    except (BrowserError, OSError) as error:
        print(f"skipped: {chromium}: {error}")
        return SKIPPED
    with browser, tempfile.TemporaryDirectory() as root:
        make_report(dynfilter, root)
        check_run(browser, os.path.join(root, "runs", "own"), "dynfilter")
        if LONG:
            make_more_reports(dynfilter, root)
            check_more(browser, root)
    print(f"{len(failures)} failed" if failures else "all right")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

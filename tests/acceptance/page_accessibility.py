#!/usr/bin/env python3
"""Looks at a page as a screen reader, a keyboard and a pair of eyes meet it: Chromium's accessibility tree, the tab key,
the contrast of every text in light and dark, the width of a telephone and of paper. Prints each problem in a line; exit 1
when there is any. Talks to the browser over its debugging pipe: nothing but Python's own library.

usage: page_accessibility.py BROWSER PAGE.html LANGUAGE [PICTURES]
"""
import base64
import fcntl
import json
import os
import pathlib
import subprocess
import sys
import tempfile


class Browser:
    def __init__(self, program, profile):
        to_read, to_write = os.pipe()
        from_read, from_write = os.pipe()

        def in_child():  # the browser reads from 3 and writes to 4
            high = [fcntl.fcntl(fd, fcntl.F_DUPFD, 10) for fd in (to_read, from_write)]
            os.dup2(high[0], 3)
            os.dup2(high[1], 4)

        self.process = subprocess.Popen(
            [program, "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe", f"--user-data-dir={profile}", "about:blank"],
            preexec_fn=in_child, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_read)
        os.close(from_write)
        self.to, self.back, self.rest, self.number, self.session = to_write, from_read, b"", 0, None

    def message(self):
        while b"\0" not in self.rest:
            piece = os.read(self.back, 1 << 20)
            if not piece:
                raise RuntimeError("the browser has gone")
            self.rest += piece
        text, self.rest = self.rest.split(b"\0", 1)
        return json.loads(text)

    def ask(self, method, **params):
        self.number += 1
        call = {"id": self.number, "method": method, "params": params}
        if self.session:
            call["sessionId"] = self.session
        data = json.dumps(call).encode() + b"\0"
        while data:
            data = data[os.write(self.to, data):]
        while True:
            answer = self.message()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]

    def run(self, script):
        result = self.ask("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(json.dumps(result["exceptionDetails"]))
        return result["result"].get("value")


CONTRAST = r"""
(() => {
  const lin = v => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  const lum = c => 0.2126 * lin(c[0]) + 0.7152 * lin(c[1]) + 0.0722 * lin(c[2]);
  const parse = s => { const m = s.match(/[\d.]+/g).map(Number); return m.length < 4 ? [...m, 1] : m; };
  const behind = e => { for (; e; e = e.parentElement) { const c = parse(getComputedStyle(e).backgroundColor); if (c[3] > 0.99) return c; } return [255, 255, 255, 1]; };
  const bad = [];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const text = walk.currentNode.nodeValue.trim(), e = walk.currentNode.parentElement;
    if (!text || e.closest('script,style,noscript,.skip,.hush')) continue;
    if (!e.getClientRects().length) continue;
    const style = getComputedStyle(e), svg = e.ownerSVGElement;
    const ink = parse(svg ? style.fill : style.color), page = behind(svg ? svg.parentElement : e);
    const a = lum(ink), b = lum(page), ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    const size = parseFloat(style.fontSize), large = size >= 24 || (size >= 18.66 && parseInt(style.fontWeight) >= 700);
    if (ratio < (large ? 3 : 4.5)) bad.push(`${ratio.toFixed(2)}:1 for "${text.slice(0, 40)}"`);
  }
  return [...new Set(bad)];
})()
"""

DATA_CONTRAST = r"""
(() => {
  const lin = v => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  const lum = c => 0.2126 * lin(c[0]) + 0.7152 * lin(c[1]) + 0.0722 * lin(c[2]);
  const parse = s => s.match(/[\d.]+/g).map(Number);
  const bad = [];
  for (const line of document.querySelectorAll('svg .line')) {
    const ink = lum(parse(getComputedStyle(line).stroke)), card = lum(parse(getComputedStyle(line.closest('section')).backgroundColor));
    const ratio = (Math.max(ink, card) + 0.05) / (Math.min(ink, card) + 0.05);
    if (ratio < 3) bad.push(`${ratio.toFixed(2)}:1 for the line of ${line.closest('svg').getAttribute('class')}`);
  }
  return [...new Set(bad)];
})()
"""


WIDE = r"""
(() => {
  const wide = document.documentElement.clientWidth, bad = [];
  if (document.documentElement.scrollWidth <= wide) return bad;
  for (const e of document.body.querySelectorAll('*')) {
    if (e.getBoundingClientRect().right <= wide + 1 || (e.parentElement && e.parentElement.closest('.scroll') && getComputedStyle(e.parentElement.closest('.scroll')).overflowX !== 'visible')) continue;
    bad.push(`${e.tagName} ${e.getAttribute('class') || ''} in ${(e.closest('section') || {}).id}`);
  }
  return [...new Set(bad)].slice(-6);
})()
"""


POINTS_OUT_OF_SIGHT = r"""
(() => {
  const points = [...document.querySelectorAll('#items .points')];
  if (document.querySelector('#items table') && !points.length) return ['a table of items without points'];
  return points.filter(e => {
    const cell = e.getBoundingClientRect(), seen = e.closest('.scroll').getBoundingClientRect();
    return cell.width === 0 || cell.left < seen.left - 1 || cell.right > Math.min(seen.right, document.documentElement.clientWidth) + 1;
  }).map(e => `"${e.textContent.trim()}" ends at ${Math.round(e.getBoundingClientRect().right)}`);
})()
"""


AFTER_TWO_FRAMES = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"


def check(browser, page, language, pictures):
    problems = []
    target = browser.ask("Target.createTarget", url="about:blank")["targetId"]
    browser.session = browser.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
    for domain in ("Page", "Accessibility", "DOM", "Runtime"):
        browser.ask(f"{domain}.enable")
    width = {"height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.ask("Emulation.setDeviceMetricsOverride", width=1000, **width)
    browser.ask("Page.navigate", url=pathlib.Path(page).absolute().as_uri())
    browser.run("new Promise(done => document.readyState === 'complete' ? done() : addEventListener('load', done))")
    browser.run(AFTER_TWO_FRAMES)

    # What a screen reader is told.
    nodes = browser.ask("Accessibility.getFullAXTree")["nodes"]
    spoken = [n for n in nodes if not n.get("ignored")]
    role = lambda n: n.get("role", {}).get("value", "")
    name = lambda n: n.get("name", {}).get("value", "").strip()
    prop = lambda n, key: next((p["value"].get("value") for p in n.get("properties", []) if p["name"] == key), None)
    roles = [role(n) for n in spoken]
    if not name(spoken[0]):
        problems.append("the page has no title")
    for landmark in ("main", "banner", "contentinfo"):
        if roles.count(landmark) != 1:
            problems.append(f"{roles.count(landmark)} landmarks {landmark}")
    for n in spoken:
        if role(n) in ("link", "button", "slider", "checkbox", "textbox", "combobox", "image", "img", "navigation", "region", "Canvas") and not name(n):
            problems.append(f"a {role(n)} without a name")
    levels = [int(prop(n, "level")) for n in spoken if role(n) == "heading"]
    if levels[:1] != [1] or levels.count(1) != 1:
        problems.append(f"headings begin with {levels[:1]}, and there are {levels.count(1)} of the first level")
    for a, b in zip(levels, levels[1:]):
        if b > a + 1:
            problems.append(f"a heading of level {b} below one of level {a}")
    children = {n["nodeId"]: n.get("childIds", []) for n in nodes}
    by_id = {n["nodeId"]: n for n in nodes}

    def below(node):
        for child in children.get(node, []):
            if child in by_id:
                yield by_id[child]
                yield from below(child)

    if browser.run("document.querySelectorAll('[role=group]:not([aria-label])').length"):
        problems.append("a group of buttons without a name")
    tables = [n for n in spoken if role(n) == "table"]
    for n in tables:
        inside = [role(m) for m in below(n["nodeId"])]
        if "columnheader" not in inside and "rowheader" not in inside:
            problems.append("a table without headers")
    spoken_language = browser.run("document.documentElement.lang")
    if not spoken_language.lower().startswith(language):
        problems.append(f"the page says its language is {spoken_language}")

    # The tab key reaches everything that can be used, in the order of the page, and shows where it is.
    wanted = browser.run("[...document.querySelectorAll('a[href],button,input,summary,[tabindex=\"0\"]')].filter(e => e.getClientRects().length).length")
    browser.run("document.body.tabIndex = -1, document.body.focus(), window.seen = []")
    for _ in range(wanted + 2):
        for kind in ("keyDown", "keyUp"):
            browser.ask("Input.dispatchKeyEvent", type=kind, key="Tab", code="Tab", windowsVirtualKeyCode=9)
        browser.run("""(() => { const e = document.activeElement; if (e === document.body || seen.includes(e)) return;
          seen.push(e); const s = getComputedStyle(e); e.dataset.ring = s.outlineStyle !== 'none' && parseFloat(s.outlineWidth) >= 2 ? 'yes' : 'no'; })()""")
    reached = browser.run("seen.length")
    if reached < wanted:
        problems.append(f"the tab key reaches {reached} of {wanted}")
    if browser.run("seen.some((e, i) => i && !(seen[i - 1].compareDocumentPosition(e) & 4))"):
        problems.append("the tab key does not follow the page's order")
    hidden = browser.run("seen.filter(e => e.dataset.ring === 'no').map(e => e.outerHTML.slice(0, 60))")
    problems += [f"no focus ring on {e}" for e in hidden]

    # The turnable view answers to keys, and says so.
    if browser.run("!!document.querySelector('#viewer canvas')"):
        look = "document.querySelector('#viewer canvas').toDataURL().length + document.querySelector('#viewer canvas').toDataURL().slice(-3000)"
        before = browser.run(look)
        top = browser.run("(() => { const c = document.querySelector('#viewer canvas'); c.focus(); return scrollY; })()")
        for _ in range(4):
            browser.ask("Input.dispatchKeyEvent", type="keyDown", key="ArrowLeft", code="ArrowLeft", windowsVirtualKeyCode=37)
            browser.ask("Input.dispatchKeyEvent", type="keyDown", key="ArrowDown", code="ArrowDown", windowsVirtualKeyCode=40)
        browser.run(AFTER_TWO_FRAMES)
        if browser.run(look) == before:
            problems.append("arrow keys do not turn the view")
        if browser.run("scrollY") != top:
            problems.append("arrow keys on the view scroll the page")
        said = browser.run("(() => { document.querySelector('#viewer [data-look=above]').click(); return document.querySelector('#viewer [aria-live]').textContent; })()")
        if not said:
            problems.append("the view does not say what it shows")

    # Eyes: contrast in both schemes; a telephone's width and large type.
    for scheme in ("light", "dark"):
        browser.ask("Emulation.setEmulatedMedia", media="screen", features=[{"name": "prefers-color-scheme", "value": scheme}])
        problems += [f"{scheme}: contrast {bad}" for bad in browser.run(CONTRAST)]
        problems += [f"{scheme}: contrast {bad}" for bad in browser.run(DATA_CONTRAST)]
        # A part that is a page of its own shows itself, and the rest not, once its link was followed.
        if browser.run("!!document.getElementById('technical')"):
            shown = "[...document.querySelectorAll('#report, #technical')].filter(e => e.getClientRects().length).map(e => e.id).join(' ')"
            for place, wanted in (("#technical", "technical"), ("#details", "technical"), ("#result", "report")):
                browser.run(f"location.hash = '{place}'")
                if browser.run(shown) != wanted:
                    problems.append(f"at {place} the page shows {browser.run(shown)}, not {wanted}")
                problems += [f"{scheme}: {place}: contrast {bad}" for bad in browser.run(CONTRAST)]
        if pictures:
            shot = browser.ask("Page.captureScreenshot", captureBeyondViewport=True, clip={
                "x": 0, "y": 0, "width": 1000, "height": browser.run("document.documentElement.scrollHeight"), "scale": 1})
            (pathlib.Path(pictures) / f"{scheme}.png").write_bytes(base64.b64decode(shot["data"]))
    for pixels in (640, 320):
        browser.ask("Emulation.setDeviceMetricsOverride", width=pixels, **width)
        problems += [f"wider than {pixels} pixels: {e}" for e in browser.run(WIDE)]
        problems += [f"points out of sight at {pixels} pixels: {e}" for e in browser.run(POINTS_OUT_OF_SIGHT)]
    browser.ask("Emulation.setDeviceMetricsOverride", width=700, **width)
    browser.ask("Emulation.setEmulatedMedia", media="print", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    problems += [f"wider than the paper: {e}" for e in browser.run(WIDE)]
    problems += [f"print: contrast {bad}" for bad in browser.run(CONTRAST)]
    paper = base64.b64decode(browser.ask("Page.printToPDF", paperWidth=8.27, paperHeight=11.69, printBackground=False)["data"])
    if not paper.startswith(b"%PDF") or len(paper) < 10000:
        problems.append("nothing was printed")
    if pictures:
        (pathlib.Path(pictures) / "page.pdf").write_bytes(paper)
    return problems, {"spoken": len(spoken), "headings": len(levels), "tables": len(tables), "by_tab": reached}


def main():
    program, page, language = sys.argv[1:4]
    pictures = sys.argv[4] if len(sys.argv) > 4 else None
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(program, profile)
        try:
            problems, counts = check(browser, page, language, pictures)
        finally:
            browser.process.kill()
            browser.process.wait()
    for problem in problems:
        print("problem:", problem)
    print("looked at:", json.dumps(counts))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())

"""Makes the pages of this tree work on the site of ./run docs.

site.py PAGE.md          Doxygen's filter: prints the page with links that work there. Files that it links to and that are
                         no pages of the site are copied into the site's folder `files/`. Doxygen 1.9.4 gives headings no
                         names, so this does.
site.py --check FOLDER   fails if a page of the site refers to a file or a heading that is not there.
"""

import html
import os
import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SITE = Path(os.environ.get("TYPODONT_SITE", ROOT / "build/docs/html"))
LINK = re.compile(r"(!?\[[^\]]*\])\(([^)\s]+)\)")


def pages() -> set[Path]:
    """The Markdown files that Doxygen reads."""
    text = (ROOT / "docs/Doxyfile").read_text().replace("\\\n", " ")
    inputs = re.search(r"^INPUT\s*=(.*)$", text, re.M).group(1).split()
    found = set()
    for name in inputs:
        place = ROOT / name
        found.update(place.glob("*.md") if place.is_dir() else [place])
    return found


def heading_id(page: Path, heading: str) -> str:
    """A name for a heading; it differs between pages. `heading`: its text, or its anchor as GitHub makes it."""
    anchor = re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")  # as GitHub does
    return re.sub(r"[^a-z0-9_-]", "", f"{str(page.relative_to(ROOT)).replace('/', '-')[:-3].lower()}--{anchor}")


def filtered(page: Path) -> str:
    known = pages()

    def link(match: re.Match) -> str:
        text, target = match.groups()
        name, _, anchor = target.partition("#")
        if re.match(r"\w+:", target):
            return match.group(0)
        file = (page.parent / name).resolve() if name else page
        if file.is_dir() and file / "README.md" in known:
            file = file / "README.md"
            return f"{text}({os.path.relpath(file, page.parent)})"
        if file in known:
            return f"{text}(#{heading_id(file, anchor)})" if anchor else match.group(0)
        if not file.is_file():
            return text.lstrip("!")[1:-1]  # a folder: there is no page to link to
        copy = SITE / "files" / file.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, copy)
        return f"{text}(files/{file.relative_to(ROOT)})"

    def heading(match: re.Match) -> str:
        return f"{match.group(0)} {{#{heading_id(page, match.group(1))}}}"

    parts = re.split(r"(^```.*?^```)", page.read_text(), flags=re.M | re.S)
    for i in range(0, len(parts), 2):  # the others are code
        parts[i] = re.sub(r"^##+ (.*)$", heading, LINK.sub(link, parts[i]), flags=re.M)
    return "".join(parts)


def check(site: Path) -> int:
    text = {file: file.read_text(errors="replace") for file in site.glob("*.html")}
    broken = set()
    for file, page in text.items():
        for target in re.findall(r'(?:href|src)="([^"]*)"', page):
            name, _, anchor = html.unescape(target).partition("#")
            if re.match(r"\w+:|//", name) or "$" in name:
                continue
            there = site / name if name else file
            if not there.exists():
                broken.add(f"{file.name}: {target}")
            elif anchor and file.name.startswith(("md_", "index")) and there in text:
                if f'id="{anchor}"' not in text[there] and f'name="{anchor}"' not in text[there]:
                    broken.add(f"{file.name}: {target}")
    for line in sorted(broken):
        print(line, file=sys.stderr)
    print(f"{len(text)} pages, {len(broken)} broken links")
    return 1 if broken or not text else 0


if __name__ == "__main__":
    if sys.argv[1] == "--check":
        sys.exit(check(Path(sys.argv[2])))
    print(filtered(Path(sys.argv[1]).resolve()), end="")

"""Does what the Markdown files link to exist, headings included? links.py SOURCE"""
import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1])
documents = [source / "README.md", *sorted(source.glob("docs/*.md")), *sorted(source.glob("tests/data/**/*.md"))]


def headings(document):
    """As links name them: small letters, blanks as hyphens, nothing else but letters, digits, hyphens."""
    text = re.sub(r"^```.*?^```$", "", document.read_text(encoding="utf-8"), flags=re.M | re.S)
    return {re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-") for title in re.findall(r"^#+ (.*)$", text, re.M)}


def exists(document, link):
    path, _, heading = link.partition("#")
    target = document.parent / path if path else document
    return target.exists() and (not heading or target.suffix != ".md" or heading in headings(target))


missing = [f"{d.relative_to(source)}: {link}" for d in documents
           for link in re.findall(r"\]\(([^)\s]+)\)", d.read_text(encoding="utf-8"))
           if not re.match(r"https?:|mailto:", link) and not exists(d, link)]
print(*missing, sep="\n")
sys.exit(bool(missing))

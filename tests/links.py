"""Does what the Markdown files link to exist? links.py SOURCE"""
import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1])
documents = [source / "README.md", *sorted(source.glob("docs/*.md")), *sorted(source.glob("tests/data/**/*.md"))]
missing = [f"{d.relative_to(source)}: {link}" for d in documents
           for link in re.findall(r"\]\(([^)#\s]+)", d.read_text())
           if not re.match(r"https?:|mailto:", link) and not (d.parent / link).exists()]
print(*missing, sep="\n")
sys.exit(bool(missing))

"""Links of a built book that lead nowhere. Usage: book_links.py HTML_FOLDER"""

import re
import sys
from pathlib import Path

root = Path(sys.argv[1]).resolve()
pages = [page for page in root.rglob("*.html") if page.name not in ("print.html", "404.html", "toc.html")]
broken = []
for page in pages:
    for link in re.findall(r'(?:href|src)="([^"#]+)', page.read_text(encoding="utf-8")):
        inside = not re.match(r"[a-z]+:", link)
        if inside and not (page.parent / link).exists():
            broken.append(f"{page.relative_to(root)}: {link}")
print("\n".join(broken) or f"{len(pages)} pages, every link leads to a file")
sys.exit(bool(broken))

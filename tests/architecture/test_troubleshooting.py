"""What the page about troubleshooting quotes is what the code says."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
# Strings that go on in the next line.
JOINT = re.compile(r'"\s*\n\s*f?"')


def test_quoted_messages_are_those_of_the_code() -> None:
    page = (ROOT / "docs/troubleshooting.md").read_text(encoding="utf-8")
    symptoms = [line.split("|")[1] for line in page.splitlines() if line.startswith("| `")]
    quotes = [quote for cell in symptoms for quote in re.findall(r"`([^`]+)`", cell)[:1]]
    assert len(quotes) > 15
    files = [
        path for part in ("openrooms_usd", "converters") for path in (ROOT / part).rglob("*.py")
    ]
    code = "".join(JOINT.sub("", path.read_text(encoding="utf-8")) for path in files)
    parts = [part.strip() for quote in quotes for part in quote.split("…") if part.strip()]
    assert [part for part in parts if part not in code] == []

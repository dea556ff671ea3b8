"""A hook of MkDocs: files beside docs/ become pages of the site, and links lead there.

In the repository a link is relative to its file, as GitHub follows it. So the pages need no address
of a server, and the site can be read without a network.
"""

import re
from pathlib import Path
from posixpath import dirname, join, normpath, relpath
from typing import Any, Final

from mkdocs.structure.files import File, Files

# Where files beside docs/ are in the site.
_FOLDER: Final = "project/"
_PAGES: Final = ("ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")
_LANGUAGES: Final = {".py": "python", ".yaml": "yaml"}
_LINK: Final = re.compile(r"\]\((?![a-z]+:|#)([^)#\s]+)")


def on_files(files: Files, config: Any) -> Files:
    """Add the pages beside docs/, and one for each example."""
    root = Path(config.config_file_path).parent
    for path in (*(root / name for name in _PAGES), *sorted((root / "examples").iterdir())):
        language = _LANGUAGES.get(path.suffix)
        text = path.read_text(encoding="utf-8") if path.is_file() else ""
        name = path.relative_to(root).as_posix()
        if language:
            text = f"# {path.name}\n\n```{language}\n{text}```\n"
        if text:
            files.append(File.generated(config, _in_site(name), content=text))
    return files


def on_page_markdown(markdown: str, *, page: Any, **_: Any) -> str:
    """Turn links between files of the repository into links between pages."""
    place = page.file.src_uri
    source = _in_repository(place)

    def in_site(link: re.Match[str]) -> str:
        target = normpath(join(dirname(source), link[1]))
        return f"]({relpath(_in_site(target), dirname(place) or '.')}"

    return _LINK.sub(in_site, markdown)


def _in_site(name: str) -> str:
    """Where the site has a file of the repository."""
    if name.startswith("docs/"):
        return name.removeprefix("docs/")
    return _FOLDER + name + (".md" if Path(name).suffix in _LANGUAGES else "")


def _in_repository(name: str) -> str:
    """Which file of the repository a Markdown page of the site is made of."""
    return name.removeprefix(_FOLDER) if name.startswith(_FOLDER) else f"docs/{name}"

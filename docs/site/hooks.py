"""What MkDocs does beyond its settings: pages from elsewhere in the repository, notebooks, and the API's sources."""

from __future__ import annotations

import ast
import re
import shutil
from pathlib import Path

import nbformat
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from nbclient import NotebookClient
from nbconvert import MarkdownExporter

ROOT = Path(__file__).parents[2]
PAGES = {"CONTRIBUTING.md": "CONTRIBUTING.md", "CHANGELOG.md": "CHANGELOG.md"}
"""Site -> repository."""
NOTEBOOK_SECONDS = 300
"""For one cell."""
FETCHED = re.compile(r"<(?:script|img|iframe|link)\b[^>]*\b(?:src|href)=[\"']?(?:https?:)?//[^\"'> ]*")

_EXPORTS = re.compile(r"^__all__ = \[[^\]]*\]\n", re.MULTILINE)


def on_startup(command: str, dirty: bool) -> None:
    """Lays the packages together as they are installed, for mkdocstrings reads files and imports nothing."""
    place = ROOT / "out" / "api"
    shutil.rmtree(place, ignore_errors=True)
    ignore = shutil.ignore_patterns("__pycache__", "*.npz")
    for package, folder in (("", "drake_ltl"), ("diagrams", "diagrams"), ("examples", "examples")):
        shutil.copytree(ROOT / folder, place / "drake_ltl" / package, ignore=ignore, dirs_exist_ok=True)
    for file in place.rglob("*.py"):
        file.write_text(readable(file.read_text(encoding="utf-8")), encoding="utf-8")
    for file in place.glob("drake_ltl/*/__init__.py"):  # what packages hand on is shown once, where it is defined
        file.write_text(_EXPORTS.sub("", file.read_text(encoding="utf-8")), encoding="utf-8")


def on_config(config: MkDocsConfig) -> None:
    """Pages that the navigation does not name are at the end of the guide, before examples and questions."""
    named = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    (guide,) = (entry["Guide"] for entry in config.nav if "Guide" in entry)
    guide[-2:-2] = [page.name for page in sorted((ROOT / "docs").glob("*.md")) if f": {page.name}\n" not in named]


def readable(source: str) -> str:
    """Ports under a heading of their own; classes that a function makes for each scalar type as plain classes."""
    source = source.replace(".. pydrake_system::\n", "Ports:\n")
    for node in ast.parse(source).body:
        inner = node.body[0] if isinstance(node, ast.FunctionDef) and node.name.endswith("_") else None
        if isinstance(inner, ast.ClassDef):
            name = node.name.removesuffix("_")
            text = ast.get_docstring(inner) or ""
            body = "\n".join(f"    {line}" if line else "" for line in text.splitlines())
            start = source.index(f"\n{name} = {name}_[None]\n")
            source = f'{source[:start]}\nclass {name}:\n    """{body.strip()}\n    """\n'
    return source


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the repository's own pages, the examples, and the notebooks as they come out when they are run."""
    for uri, name in PAGES.items():
        files.append(File.generated(config, uri, content=(ROOT / name).read_text(encoding="utf-8")))
    for path in sorted((ROOT / "examples").glob("*.*")):
        if path.suffix in (".md", ".yaml", ".py") and path.stem != "__init__":
            files.append(File.generated(config, f"examples/{path.name}", content=path.read_text(encoding="utf-8")))
    for path in sorted((ROOT / "examples" / "notebooks").glob("*.ipynb")):
        text, pictures = run(path)
        files.append(File.generated(config, f"notebooks/{path.stem}.md", content=text))
        for name, data in pictures.items():
            files.append(File.generated(config, f"notebooks/{name}", content=data))
    return files


def run(path: Path) -> tuple[str, dict[str, bytes]]:
    """The notebook as Markdown with its outputs, and its pictures. CellExecutionError if a cell fails."""
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=NOTEBOOK_SECONDS, resources={"metadata": {"path": str(path.parent)}}).execute()
    text, resources = MarkdownExporter().from_notebook_node(notebook, {"unique_key": path.stem})
    return text, resources.get("outputs", {})


def on_page_markdown(markdown: str, page: object, config: MkDocsConfig, files: Files) -> str:
    """Links from the documentation to the examples lead, on GitHub, out of its folder; on the site they do not."""
    depth = page.file.src_uri.count("/")
    markdown = markdown.replace("](" + "../" * (depth + 1) + "examples/", "](" + "../" * depth + "examples/")
    markdown = re.sub(r"\]\(notebooks/(\w+)\.ipynb\)", r"](../notebooks/\1.md)", markdown)
    return markdown.replace("](docs/", "](") if page.file.src_uri in PAGES else markdown


def on_post_build(config: MkDocsConfig) -> None:
    """Nothing on the site is fetched from elsewhere; and what mkdocstrings has read may go."""
    shutil.rmtree(ROOT / "out" / "api")
    for page in Path(config.site_dir).rglob("*.html"):
        found = FETCHED.search(page.read_text(encoding="utf-8"))
        if found:
            raise PluginError(f"{page}: {found[0]} would be fetched from a network")

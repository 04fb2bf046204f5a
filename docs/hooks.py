"""What the site has beside the pages in this folder: the README as its first page, and references made anew.

A hook of MkDocs (`mkdocs build`); `generated` gives the same pages to whoever wants to look at them.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
ROOT = DOCS.parent
PARTS = ("specs", "plugins", "benchmarks", "tests/reference", "LICENSE", "CHANGELOG.md")
"""What of the repository pages link to: it goes to the site as it is."""


MODULES = (
    "quantities",
    "kernels",
    "testing",
    "solution",
    "report",
    "preview",
    "exchange",
    "study",
    "intervals",
    "mechanics.virtual_joints",
    "mechanics.bars",
)
"""Of which the reference tells every public name, beside what `import orthospec` gives."""


def on_files(files: Any, config: Any) -> Any:
    """Add the pages that are made, and what they and others link to."""
    from mkdocs.structure.files import File

    for name, text in generated().items():
        files.append(File.generated(config, name, content=text))
    for path in linked():
        source = str(path.relative_to(ROOT))
        files.append(File.generated(config, f"repository/{source}", abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Links go where their targets stand in the site."""
    here = page.file.src_uri
    if here.startswith("reference/"):
        return markdown
    return re.sub(r"\]\((?!https?:|#)([^)#]+)", lambda found: f"]({_moved(found[1], here)}", markdown)


def _moved(link: str, here: str) -> str:
    """A link of a page, relative to it in the site."""
    own = DOCS / here
    if here == "index.md":
        own = ROOT / "README.md"
    elif here.startswith("repository/"):
        own = ROOT / here.removeprefix("repository/")
    target = (own.parent / link).resolve()
    if target.is_dir():
        target = target / "README.md"
    if target == ROOT / "README.md":
        place = "index.md"
    elif target.is_relative_to(DOCS):
        place = target.relative_to(DOCS).as_posix()
    else:
        place = f"repository/{target.relative_to(ROOT).as_posix()}"
    return posixpath.relpath(place, posixpath.dirname(here))


def linked() -> Iterator[Path]:
    """The files of the repository that pages may link to."""
    for part in PARTS:
        path = ROOT / part
        files = [path] if path.is_file() else sorted(path.rglob("*"))
        yield from (one for one in files if one.is_file() and one.suffix in {".yaml", ".md", ".py", ""})


def generated() -> Mapping[str, str]:
    """The pages that are made, by their names."""
    return {
        "index.md": (ROOT / "README.md").read_text(encoding="utf-8"),
        "reference/commands.md": _commands(),
        "reference/keys.md": _keys(),
        "reference/plugins.md": _plugins(),
        "reference/python.md": _python(),
    }


def _commands() -> str:
    """Each command with its arguments and options, as `--help` tells them."""
    import typer

    from orthospec.cli import app

    parts = ["# Commands\n"]
    for name, command in typer.main.get_command(app).commands.items():  # type: ignore[attr-defined]
        parts.append(f"## orthospec {name}\n\n{command.help}\n")
        rows = [row for parameter in command.params if (row := _parameter(parameter))]
        parts.append("\n".join(["| | |", "|---|---|", *rows]) + "\n")
    return "\n".join(parts)


def _parameter(parameter: Any) -> str:
    opts = ", ".join(f"`{one}`" for one in parameter.opts if one.startswith("-"))
    value = (
        "" if getattr(parameter, "is_flag", False) else f" `{parameter.metavar or parameter.name.upper()}`"
    )
    return (
        f"| {opts}{value} | {_cell(getattr(parameter, 'help', '') or '')} |"
        if parameter.name != "help"
        else ""
    )


def _keys() -> str:
    """The keys of a spec from its JSON Schema, section by section."""
    from orthospec.spec import schema

    content = schema()
    parts = ["# Keys of a spec\n", "Made from the schema that `orthospec schema` prints.\n"]
    rows = [f"| `{name}` | {_cell(_said(one, content))} |" for name, one in content["properties"].items()]
    parts.append("\n".join(["| key | meaning |", "|---|---|", *rows]) + "\n")
    for name, one in content["properties"].items():
        inner = _resolved(one, content)
        own = inner.get("properties") or _resolved(inner.get("additionalProperties") or {}, content).get(
            "properties"
        )
        if own and name not in ("manipulator", "measures"):
            rows = [f"| `{key}` | {_cell(_said(value, content))} |" for key, value in own.items()]
            parts.append("\n".join([f"## {name}\n", "| key | meaning |", "|---|---|", *rows]) + "\n")
    return "\n".join(parts)


def _resolved(schema: Any, content: Any) -> Any:
    if not isinstance(schema, dict):
        return {}
    if "$ref" in schema:
        return _resolved(content["$defs"][schema["$ref"].rpartition("/")[2]], content) | {
            key: value for key, value in schema.items() if key != "$ref"
        }
    for several in ("anyOf", "oneOf", "allOf"):
        for one in schema.get(several, []):
            found = _resolved(one, content)
            if "properties" in found or "additionalProperties" in found:
                return found | {"description": schema.get("description", found.get("description", ""))}
    return schema


def _said(schema: Any, content: Any) -> str:
    found = _resolved(schema, content)
    said = schema.get("description") or found.get("description", "")
    default = schema.get("default", found.get("default"))
    return said if default in (None, [], {}) else f"{said} ({default} if left out)"


def _plugins() -> str:
    """Each machine and measure that is installed, with its formula, units and keys."""
    from orthospec.show import explained, installed

    parts = ["# Machines and measures\n"]
    for entry in installed():
        (one, *_) = explained(entry["name"])
        if one["distribution"] != "orthospec":
            continue
        facts = {key: one[key] for key in ("unit", "sides", "needs", "axes", "joint_units") if one.get(key)}
        told = "; ".join(f"{key.replace('_', ' ')}: {_listed(value)}" for key, value in facts.items())
        parts.append(f"## {one['name']}\n\n{one['description']}\n\n{told}\n")
        rows = [
            f"| `{key['name']}` | {', '.join(dict.fromkeys(key['units']))} | {_cell(key['meaning'])} |"
            for key in one["keys"]
        ]
        if rows:
            parts.append("\n".join(["| key | unit | meaning |", "|---|---|---|", *rows]) + "\n")
    return "\n".join(parts)


def _listed(value: Any) -> str:
    return ", ".join(value) if isinstance(value, list) else str(value)


def _python() -> str:
    """Every public name, from its docstring."""
    import orthospec

    parts = ["# Python\n", "What `import orthospec` gives, and the modules for authors of plugins.\n"]
    parts += [f"::: orthospec.{name}\n" for name in orthospec.__all__]
    parts += [f"::: orthospec.{name}\n" for name in MODULES]
    return "\n".join(parts)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ").replace("<", "&lt;")

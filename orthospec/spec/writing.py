"""Plain data as YAML that the strict parser reads back as the same data, the same bytes each time."""

from __future__ import annotations

from typing import Any

import yaml

from orthospec.spec.strict_yaml import scalar


def dump(data: Any) -> str:
    """Block style, short collections in flow style, the order of keys kept, floats that read back exactly."""
    return yaml.dump(
        data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110, default_flow_style=None
    )


class _Dumper(yaml.SafeDumper):
    """Quotes the strings that unquoted would be read as something else: a lone bracket joins what follows."""

    def ignore_aliases(self, data: Any) -> bool:  # noqa: ARG002
        """Write each part out, however often it is used."""
        return True


def _string(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    is_whole = text.count("(") == text.count(")")
    style = None if text.isprintable() and is_whole and isinstance(scalar(text), str) else '"'
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _string)

"""What to start from: a spec for any installed machine whose keys have examples, and a plugin's
distribution."""

from orthospec.starter.distribution import write_plugin
from orthospec.starter.files import write_start
from orthospec.starter.text import starting_spec

__all__ = ["starting_spec", "write_plugin", "write_start"]

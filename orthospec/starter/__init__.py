"""A spec to start from, for any installed machine whose keys have examples."""

from orthospec.starter.files import write_start
from orthospec.starter.text import starting_spec

__all__ = ["starting_spec", "write_start"]

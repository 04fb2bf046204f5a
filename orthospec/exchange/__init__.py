"""A result for other programs: fields, surfaces, the machine, and tables, each by a library made for it."""

from orthospec.exchange.files import KINDS, export

__all__ = ["KINDS", "export"]

"""A result as a scene in space: the machine at work, its workspace, the cuboids and the measures in them."""

from orthospec.preview.live import show_live
from orthospec.preview.page import preview

__all__ = ["preview", "show_live"]

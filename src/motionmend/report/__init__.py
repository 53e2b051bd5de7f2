"""Reports: a player in one HTML file, and figures as PNG."""

from .html import html_report

__all__ = ["html_report"]

"""report.html, put together from its sections."""

import html
import json

from diagnosis.diagnose import Diagnosis


def report_page(result: Diagnosis) -> str:
    """The page's text; nothing in it is loaded from elsewhere."""
    body = html.escape(json.dumps(result.table, indent=2, default=float))
    return (
        f"<!doctype html><html lang=en><meta charset=utf-8><title>Diagnosis</title><pre>{body}</pre></html>\n"
    )

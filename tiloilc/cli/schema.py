"""`tiloilc schema`: the JSON Schema of the task file."""

from __future__ import annotations

import json
import sys


def command() -> None:
    """Print the JSON Schema of the task file."""
    from tiloilc.spec import json_schema

    sys.stdout.write(json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n")

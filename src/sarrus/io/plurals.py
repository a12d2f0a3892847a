"""Messages on a number of things, in the singular or the plural."""

from __future__ import annotations

import re

FORMS = re.compile(r"\[(?:([^|\]]*)\|)?([^|\]]*)\]")


def counted(message: str, n: int) -> str:
    """Return a message on n things: ``"{n} joint[s] [is|are] locked"`` has letters of the plural and both forms."""
    return FORMS.sub(lambda forms: (forms[1] or "") if n == 1 else forms[2], message).replace("{n}", str(n))

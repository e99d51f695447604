# SPDX-License-Identifier: GPL-3.0-or-later
"""`make docs`: the tables of parameters and log variables in DESIGN.md, from the C source."""

from __future__ import annotations

from ground.docparams import Variable, log_variables, map_variables, parameters
from tests.tools.objects import FIRMWARE_APP

DESIGN = FIRMWARE_APP / "DESIGN.md"
BEGIN = "<!-- Written by `make docs` from the doc comments in app/. -->"
END = "<!-- End of what `make docs` writes. -->"


def tables() -> str:
    """All tables, in Markdown."""
    return "\n".join(
        (
            "**Parameters, group `way`.** Stored: it can be kept over a restart.",
            "",
            "| name | type | at first | stored | meaning |",
            "|---|---|---|---|---|",
            *(_parameter(one) for one in parameters().values()),
            "",
            "**Log variables, group `way`.**",
            "",
            *_logs(log_variables()),
            "",
            "**Log variables, group `waymap`:** the map's stream, for one log block.",
            "",
            *_logs(map_variables()),
        )
    )


def renewed(text: str) -> str:
    """The text with current tables between the marks."""
    before, _, rest = text.partition(BEGIN)
    _, mark, after = rest.partition(END)
    if not mark:
        raise ValueError(f"{DESIGN} has lost its marks")
    return f"{before}{BEGIN}\n\n{tables()}\n\n{END}{after}"


def _parameter(one: Variable) -> str:
    stored = "yes" if one.stored else "no"
    return f"| `{one.name}` | {one.type} | {one.default:g} | {stored} | {one.help} |"


def _logs(variables: dict[str, Variable]) -> list[str]:
    rows = [f"| `{one.name}` | {one.type} | {one.help} |" for one in variables.values()]
    return ["| name | type | meaning |", "|---|---|---|", *rows]


if __name__ == "__main__":
    DESIGN.write_text(renewed(DESIGN.read_text()))

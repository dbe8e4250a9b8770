"""How data show themselves: as tables in a terminal, as HTML in a notebook, both from the same rich renderable."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table
    from rich.text import Text

_CELL = "text-align:left;vertical-align:top;padding:2px 12px 2px 0"
_BOLD = {"bold green": "color:#1a7f37;font-weight:600", "bold red": "color:#c22;font-weight:600", "red": "color:#c22"}


class Shown:
    """Base of what `rich.print` and notebooks show as `__rich__` says. `repr` stays one short line."""

    def __rich__(self) -> RenderableType:
        raise NotImplementedError

    def _repr_html_(self) -> str:
        return to_html(self.__rich__())


def to_html(renderable: RenderableType) -> str:
    """Groups, tables and texts as HTML: real tables, which wrap and can be copied, without scripts."""
    return f"<div>{''.join(_parts(renderable))}</div>"


def _parts(renderable: RenderableType) -> Iterator[str]:
    from rich.console import Group
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    if isinstance(renderable, Group):
        for part in renderable.renderables:
            yield from _parts(part)
    elif isinstance(renderable, Padding):
        yield from _parts(renderable.renderable)
    elif isinstance(renderable, Table):
        yield _table(renderable)
    else:
        text = renderable if isinstance(renderable, Text) else Text(str(renderable))
        yield f"<p style='margin:4px 0'>{_text(text)}</p>"


def _table(table: Table) -> str:
    columns = [list(column.cells) for column in table.columns]
    head = "".join(f"<th style='{_CELL}'>{_cell(column.header)}</th>" for column in table.columns)
    rows = "".join(
        f"<tr>{''.join(f'<td style={_CELL!r}>{_cell(cell)}</td>' for cell in row)}</tr>"
        for row in zip(*columns, strict=True)
    )
    title = f"<caption style='text-align:left'>{_cell(table.title)}</caption>" if table.title else ""
    return f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


def _cell(cell: RenderableType) -> str:
    from rich.text import Text

    return _text(cell if isinstance(cell, Text) else Text(str(cell)))


def _text(text: Text) -> str:
    """Styles of parts, but only those that stand for something."""
    pieces, end = [], 0
    for span in sorted(text.spans, key=lambda span: span.start):
        style = _BOLD.get(str(span.style))
        if style is None or span.start < end:
            continue
        pieces += [escape(text.plain[end : span.start]), _styled(text.plain[span.start : span.end], style)]
        end = span.end
    whole = "".join([*pieces, escape(text.plain[end:])]).replace("\n", "<br>")
    base = _BOLD.get(str(text.style))
    return f"<span style='{base}'>{whole}</span>" if base else whole


def _styled(text: str, style: str) -> str:
    return f"<span style='{style}'>{escape(text)}</span>"

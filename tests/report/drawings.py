"""What stands in a drawing: its titles and its elements, as an XML reader finds them."""

from __future__ import annotations

import re
from xml.etree import ElementTree

SVG = "{http://www.w3.org/2000/svg}"


def parsed(svg: str) -> ElementTree.Element:
    """The root of a drawing; fails where it is no XML."""
    text = svg if "xmlns=" in svg else svg.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1)
    return ElementTree.fromstring(text)


def titles(markup: str) -> list[str]:
    """Texts of all titles of one or several drawings."""
    drawings = re.findall(r"<svg.*?</svg>", markup, re.DOTALL)
    return [title.text or "" for drawing in drawings for title in parsed(drawing).iter(f"{SVG}title")]


def texts(svg: str) -> list[str]:
    """All that is written in a drawing."""
    return ["".join(text.itertext()).strip() for text in parsed(svg).iter(f"{SVG}text")]


def elements(markup: str, kind: str) -> list[ElementTree.Element]:
    """Elements of a class."""
    drawings = re.findall(r"<svg.*?</svg>", markup, re.DOTALL)
    return [e for drawing in drawings for e in parsed(drawing).iter() if kind in e.get("class", "").split()]

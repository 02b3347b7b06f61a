"""XML elements that know their place, read strictly: no document type, bounded size and depth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from xml.parsers import expat

from trees.language.diagnostics import Diagnostics, Location

MAX_DEPTH = 64


@dataclass(frozen=True, kw_only=True)
class Element:
    """One element of an XML file."""

    tag: str
    attributes: Mapping[str, str]
    place: Location
    children: list[Element] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """What is written between its tags, apart from its children."""
        return " ".join("".join(self.texts).split())

    def all(self, tag: str) -> Iterator[Element]:
        """Its children of a tag."""
        return (child for child in self.children if child.tag == tag)


class _RefusedError(Exception):
    """The file is XML, and more than is read here."""


def read_elements(text: str, diagnostics: Diagnostics) -> Element | None:
    """The root element of an XML file, or None and a diagnostic.

    Args:
        text: the file.
        diagnostics: where they are noted.
    """
    parser = expat.ParserCreate()
    parser.buffer_text = True
    open_elements: list[Element] = []
    roots: list[Element] = []

    def here() -> Location:
        return Location(line=parser.CurrentLineNumber, column=parser.CurrentColumnNumber + 1)

    def begin(tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag=tag, attributes=attributes, place=here())
        if len(open_elements) >= MAX_DEPTH:
            diagnostics.error(
                here(), f"elements nest deeper than {MAX_DEPTH} levels", "split the tree"
            )
            raise _RefusedError
        (open_elements[-1].children if open_elements else roots).append(element)
        open_elements.append(element)

    def end(tag: str) -> None:
        open_elements.pop()

    def written(letters: str) -> None:
        if open_elements:
            open_elements[-1].texts.append(letters)

    def document_type(*_: object) -> None:
        # Entities, which grow without bound or read other files, can only be declared in one.
        diagnostics.error(here(), "a document type is not read", "remove `<!DOCTYPE ...>`")
        raise _RefusedError

    parser.StartElementHandler = begin
    parser.EndElementHandler = end
    parser.CharacterDataHandler = written
    parser.StartDoctypeDeclHandler = document_type
    try:
        parser.Parse(text, True)
    except _RefusedError:
        return None
    except expat.ExpatError as error:
        place = Location(line=error.lineno, column=error.offset + 1)
        problem = expat.errors.messages[error.code]
        diagnostics.error(place, f"this is not XML: {problem}", "hint it here or on the line above")
        return None
    return roots[0]

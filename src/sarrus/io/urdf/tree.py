"""Check that links and joints form one tree; the joints in the order of that tree."""

from __future__ import annotations

from collections.abc import Mapping

from ...model.show import quote
from ..robot import Edge, Link
from ..xml.reader import Reader


def root_of(edges: Mapping[str, Edge], links: Mapping[str, Link], file: str) -> str:
    """Return the only link that is no child, or raise a ModelError."""
    above: dict[str, Edge] = {}
    for edge in edges.values():
        if edge.child in above:
            other = above[edge.child]
            message = f"link {quote(edge.child)} is already the child of joint {quote(other.name)}"
            remedy = "Close the loop with a joint in a loops file: a URDF is a tree."
            raise Reader(file, f"joint {quote(edge.name)}").refusal(f"{message}. {remedy}", edge.line)
        above[edge.child] = edge
    roots = [link for link in links.values() if link.name not in above]
    if not roots:
        message = "every link is the child of a joint, so none is the root. Let one link be no child."
        raise Reader(file, "robot").refusal(message, 1)
    if len(roots) > 1:
        names = " and ".join(quote(link.name) for link in roots[:2])
        message = f"{names} both are no child of a joint. Connect all links into one tree."
        raise Reader(file, "robot").refusal(message, roots[1].line)
    return roots[0].name


def in_order(edges: Mapping[str, Edge], links: Mapping[str, Link], root: str, file: str) -> list[Edge]:
    """Return the edges from the root outward, or raise a ModelError if some hang together in a circle."""
    below: dict[str, list[Edge]] = {}
    for edge in edges.values():
        below.setdefault(edge.parent, []).append(edge)
    order: list[Edge] = []
    waiting = list(reversed(below.get(root, [])))
    while waiting:
        order.append(waiting.pop())
        waiting += reversed(below.get(order[-1].child, []))
    _refuse_circle(edges, order, root, file)
    return order


def _refuse_circle(edges: Mapping[str, Edge], order: list[Edge], root: str, file: str) -> None:
    reached = {edge.name for edge in order}
    for edge in edges.values():
        if edge.name not in reached:
            message = f"hangs in a circle of joints that does not reach the root {quote(root)}"
            remedy = "Let one of them have its parent in the tree."
            raise Reader(file, f"joint {quote(edge.name)}").refusal(f"{message}. {remedy}", edge.line)

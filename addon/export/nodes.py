# SPDX-License-Identifier: GPL-3.0-or-later
"""Walking a node tree: through reroutes, muted nodes and groups.

A place in the tree is a socket and the stack of group nodes that were entered to reach it.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Source:
    """What feeds an input: an output socket of a node, or (node None) the value of `socket` itself."""

    node: object
    socket: object
    stack: tuple


def source_of(socket, stack: tuple = ()) -> Source:
    """Follow an input's link to the node that makes its value; reroutes, groups and muting are seen through."""
    for _ in range(1000):  # a bound against cycles in broken files
        link = live_link(socket)
        if link is None:
            return Source(None, socket, stack)
        node, output = link.from_node, link.from_socket
        if node.mute:
            inner = next((i for i in node.internal_links if i.to_socket == output), None)
            if inner is None:
                return Source(None, None, stack)
            socket = inner.from_socket
        elif node.type == "REROUTE":
            socket = node.inputs[0]
        elif node.type == "GROUP" and node.node_tree:
            end = next((n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output), None)
            if end is None:
                return Source(None, None, stack)
            socket, stack = by_identifier(end.inputs, output.identifier), (*stack, node)
        elif node.type == "GROUP_INPUT" and stack:
            socket, stack = by_identifier(stack[-1].inputs, output.identifier), stack[:-1]
        else:
            return Source(node, output, stack)
        if socket is None:
            return Source(None, None, stack)
    return Source(None, None, stack)


def live_link(socket):
    """The link into an input, or None where there is none that counts."""
    if not socket.is_linked:
        return None
    return next((link for link in socket.links if link.is_valid and not link.is_muted), None)


def by_identifier(sockets, identifier):
    return next((s for s in sockets if s.identifier == identifier), None)


def find_input(node, *names):
    """The first of a node's inputs with one of these identifiers or names; None where it has none."""
    for name in names:
        for socket in node.inputs:
            if socket.identifier == name:
                return socket
    for name in names:
        for socket in node.inputs:
            if socket.name == name and socket.enabled:
                return socket
    return None

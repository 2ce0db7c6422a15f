# SPDX-License-Identifier: GPL-3.0-or-later
"""Switches a material's nodes on for ours, and off again. Before Blender 5.0 a material may have Use Nodes off.

Without nodes it is drawn with the color, roughness and metallic of its Viewport Display. A new tree takes them over, so
that the material looks as before.
"""
from __future__ import annotations

import hashlib

import bpy

from .. import compat

SWITCHED = "rumple_switched_nodes_on"  # custom property of a material
MADE = "rumple_made_for_our_nodes"  # custom property of a node tree that did not exist: its state when it was made
_TAKEN = {"diffuse_color": ("Base Color",), "roughness": ("Roughness",), "metallic": ("Metallic",),
          "specular_intensity": ("Specular", "Specular IOR Level")}  # the second name: from Blender 4.0 on


def keeps_nodes(data_block: bpy.types.Material | bpy.types.NodeTree) -> bool:
    """Whether nodes that are changed stay so. A library override gets those of the linked file again when it is
    opened."""
    return compat.is_editable(data_block) and data_block.override_library is None


def switch_on(material: bpy.types.Material) -> None:
    """Let a material use nodes. A tree that the artist had stays as it is."""
    if compat.uses_nodes(material):
        return
    is_new = material.node_tree is None
    compat.use_nodes(material)
    material[SWITCHED] = True
    tree = material.node_tree
    if is_new or tree.get(MADE) == _state(tree):
        _take_over(material)
        tree[MADE] = _state(tree)


def switch_back(material: bpy.types.Material) -> None:
    """Switch the nodes off again if switch_on() did it, none of our nodes is left, and the artist changed nothing in a
    tree that was made for them."""
    tree = material.node_tree
    if SWITCHED not in material or any(map(_is_ours, tree.nodes)):
        return
    del material[SWITCHED]
    if MADE not in tree or tree[MADE] == _state(tree):
        compat.use_nodes(material, False)
    else:
        del tree[MADE]


def _take_over(material: bpy.types.Material) -> None:
    shader = next((node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED"), None)
    for prop, names in _TAKEN.items():
        for name in names:
            if shader is not None and name in shader.inputs:
                shader.inputs[name].default_value = getattr(material, prop)


def _is_ours(node: bpy.types.Node) -> bool:
    """Whether it is a group of the Wrinkle Field or the Wrinkle Maps."""
    return (node.type == "GROUP" and node.node_tree is not None
            and any(key.startswith("rumple_") for key in node.node_tree.keys()))


def _state(tree: bpy.types.NodeTree) -> str:
    """Digest of the nodes of a tree, their values and links."""
    values = [(node.bl_idname, node.name, socket.identifier, _plain(getattr(socket, "default_value", None)))
              for node in tree.nodes for socket in node.inputs]
    links = sorted((link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)
                   for link in tree.links)
    return hashlib.sha1(repr((values, links)).encode()).hexdigest()


def _plain(value: object) -> object:
    return tuple(value) if isinstance(value, bpy.types.bpy_prop_array) else value

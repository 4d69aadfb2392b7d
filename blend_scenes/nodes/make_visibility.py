"""Makes a scene of balls on a floor, some of which not all see.

    python blend_scenes/nodes/make_visibility.py -- OUT.blend CASE        (or blender -b --python ...)

CASE: a name of CASES below.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
from make_lamps import lamp
from make_worlds import add, ball, new_scene, shader


def lit_scene(scene):
    """A dim world and an area lamp."""
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.3
    add(scene, "key", lamp("AREA", shape="SQUARE", size=1.5, energy=120.0), (-2, -2, 4), (0.4, -0.4, 0))


def collection_of(scene, *objects):
    """Objects in a collection of their own; its layer collection."""
    made = bpy.data.collections.new("apart")
    scene.collection.children.link(made)
    for each in objects:
        scene.collection.objects.unlink(each)
        made.objects.link(each)
    return scene.view_layers[0].layer_collection.children["apart"]


# ------------------------------------------------------------------ holes


def veil():
    """A material that lets half of the light through."""
    made = shader("veil", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.2, 0.2, 1.0))
    tree = made.node_tree
    mix, clear = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
    output = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    tree.links.new(clear.outputs[0], mix.inputs[1])
    tree.links.new(output.inputs["Surface"].links[0].from_socket, mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    return made


def held_out(scene):
    """A ball and, by its collection, a veil; the glossy ball and the floor show both."""
    lit_scene(scene)
    scene.render.film_transparent = True
    bpy.data.objects["diffuse"].is_holdout = True
    mesh = ball()
    mesh.materials.append(veil())
    collection_of(scene, add(scene, "veil", mesh, (0.2, -1.5, 0.8), scale=(0.7, 0.7, 0.7))).holdout = True


def held_out_opaque(scene):
    """The same without a transparent film, and a ball that shines is held out."""
    held_out(scene)
    scene.render.film_transparent = False
    bpy.data.objects["diffuse"].data.materials[0] = shader("glow", "ShaderNodeEmission", Strength=2.0)


def indirect_only(scene):
    lit_scene(scene)
    collection_of(scene, bpy.data.objects["diffuse"]).indirect_only = True


# ------------------------------------------------------------------ light linking


def panel_mesh(strength):
    """An upright square that shines green."""
    mesh = bpy.data.meshes.new("panel")
    mesh.from_pydata([(-1, 0, 0), (1, 0, 0), (1, 0, 1), (-1, 0, 1)], [], [(0, 1, 2, 3)])
    mesh.materials.append(shader("panel", "ShaderNodeEmission", Color=(0.5, 1.0, 0.5, 1.0), Strength=strength))
    return mesh


def named(name, *objects, excluded=()):
    """A collection, of no scene, that includes objects and excludes others."""
    made = bpy.data.collections.new(name)
    for each in (*objects, *excluded):
        made.objects.link(each)
    for row, each in zip(made.collection_objects, made.objects, strict=True):
        row.light_linking.link_state = "EXCLUDE" if each in excluded else "INCLUDE"
    return made


def three_lamps(scene):
    """A key lamp for one ball, one for all but the other, and a panel for the floor; a plain one for all."""
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.1
    matte, glossy, floor = (bpy.data.objects[name] for name in ("diffuse", "glossy", "floor"))
    key = add(scene, "key", lamp("AREA", shape="SQUARE", size=1.5, energy=200.0, color=(1.0, 0.8, 0.6)), (-2, -2, 4),
              (0.4, -0.4, 0))
    key.light_linking.receiver_collection = named("key", matte)
    rim = add(scene, "rim", lamp("POINT", energy=300.0, shadow_soft_size=0.4, color=(0.5, 0.7, 1.0)), (2, 2, 3))
    rim.light_linking.receiver_collection = named("rim", excluded=[matte])
    panel = add(scene, "panel", panel_mesh(3.0), (0, 1.5, 1.2))
    nested = named("nested", glossy)
    outer = named("outer", floor)
    outer.children.link(nested)
    outer.collection_children[0].light_linking.link_state = "EXCLUDE"
    panel.light_linking.receiver_collection = outer
    add(scene, "plain", lamp("SUN", energy=0.5, angle=0.1), rotation=(0.5, 0.3, 0))


def shadows(scene):
    """One ball casts no shadow in the light of an area lamp, the other none in that of a sun and of a panel. Both are
    diffuse, for Cycles loses light of such lamps that comes by glossy reflection."""
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.1
    matte, glossy = (bpy.data.objects[name] for name in ("diffuse", "glossy"))
    key = add(scene, "key", lamp("AREA", shape="SQUARE", size=1.0, energy=200.0), (-3, -1, 4), (0.2, -0.6, 0))
    key.light_linking.blocker_collection = named("key", excluded=[matte])
    glossy.data.materials[0] = shader("pale", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.7, 1.0))
    sun = add(scene, "sun", lamp("SUN", energy=2.0, angle=0.1, color=(1.0, 0.8, 0.5)), rotation=(-0.5, -0.5, 0))
    sun.light_linking.blocker_collection = named("sun", matte)
    panel = add(scene, "panel", panel_mesh(5.0), (0, 2.5, 1.2))
    panel.light_linking.blocker_collection = sun.light_linking.blocker_collection


# ------------------------------------------------------------------ shadow catchers


def caught(scene):
    """The floor catches the shadows of both balls and the light of a panel."""
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.5
    add(scene, "key", lamp("AREA", shape="SQUARE", size=1.5, energy=300.0), (-3, -1, 5), (0.2, -0.5, 0))
    scene.render.film_transparent = True
    bpy.data.objects["floor"].is_shadow_catcher = True
    bpy.data.objects["diffuse"].data.materials[0] = shader("red", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.1, 0.1, 1.0))
    add(scene, "panel", panel_mesh(0.3), (0, 2.5, 0.2))


# ------------------------------------------------------------------ portals


def portal(scene):
    """A roof and walls around the balls, with an opening that a portal marks."""
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 3.0
    room = bpy.data.meshes.new("room")
    room.from_pydata([(-4, -8, 0), (-4, 4, 0), (4, 4, 0), (4, -8, 0), (-4, -8, 4), (-4, 4, 4), (4, 4, 4), (4, -8, 4),
                      (-4, -1, 4), (4, -1, 4), (-4, 1, 4), (4, 1, 4)], [],
                     [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 4, 7, 3), (4, 8, 9, 7), (10, 5, 6, 11)])
    room.materials.append(shader("walls", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.7, 0.7, 1.0)))
    add(scene, "room", room)
    add(scene, "portal", lamp("AREA", shape="RECTANGLE", size=8.0, size_y=2.0, is_portal=True), (0, 0, 4))


CASES = (held_out, held_out_opaque, indirect_only, three_lamps, shadows, caught, portal)

if __name__ == "__main__":
    out, case = sys.argv[sys.argv.index("--") + 1:][:2]
    scene = new_scene()
    next(each for each in CASES if each.__name__ == case)(scene)
    bpy.ops.wm.save_as_mainfile(filepath=out)

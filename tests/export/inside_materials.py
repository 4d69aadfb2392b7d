"""Materials as programs: every supported shader, folding of constants, notes for the rest."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from common import add, export, material, near, node, notes_of, program, run_all, square

V1 = bpy.app.version < (4, 0, 0)
PRINCIPLED = {"level": "Specular", "transmission": "Transmission", "emission": "Emission"} if V1 else {
    "level": "Specular_IOR_Level", "transmission": "Transmission_Weight", "emission": "Emission_Color"}


def exported(build, name="tested"):
    add("square", square(materials=(material(name, build),)))
    scene = export()
    return program(scene, name), notes_of(scene, name), scene


def surface(kind, distribution=None, **inputs):
    """Program and notes of a material of one shader node."""
    def build(tree, output):
        made = node(tree, kind, output.inputs["Surface"], **inputs)
        if distribution:
            made.distribution = distribution
    return exported(build)[:2]


def check(steps, *wanted):
    """Compare with [(operation, weight, {parameter: value})]; parameters not given may be anything."""
    assert [s[0] for s in steps] == [w[0] for w in wanted], steps
    for (_, weight, params), (_, want_weight, want_params) in zip(steps, wanted, strict=False):
        near(weight, np.broadcast_to(want_weight, 3))
        for name, value in want_params.items():
            near(params[name], value)


def rgb(name, *color):
    return {f"{name}_{c}": v for c, v in zip("rgb", color, strict=False)}


def test_diffuse():
    steps, notes = surface("ShaderNodeBsdfDiffuse", Color=(0.1, 0.2, 0.3))
    check(steps, ("diffuse", (0.1, 0.2, 0.3), {}))
    assert not notes


def test_rough_diffuse():
    steps, notes = surface("ShaderNodeBsdfDiffuse", Color=(0.1, 0.2, 1.5), Roughness=0.5)
    check(steps, ("rough_diffuse", (0.1, 0.2, 1.5), {"roughness": 0.5} | rgb("albedo", 0.1, 0.2, 1.0)))
    assert not notes


def test_translucent_and_toon():
    check(surface("ShaderNodeBsdfTranslucent", Color=(0.1, 0.2, 0.3))[0], ("translucent", (0.1, 0.2, 0.3), {}))
    bpy.data.materials.remove(bpy.data.materials["tested"])
    for component, operation in (("DIFFUSE", "diffuse_toon"), ("GLOSSY", "glossy_toon")):
        def build(tree, output, component=component):
            made = node(tree, "ShaderNodeBsdfToon", output.inputs["Surface"], Color=(0.1, 0.2, 0.3), Size=0.4,
                        Smooth=0.1)
            made.component = component
        steps, notes, _ = exported(build)
        check(steps, (operation, (0.1, 0.2, 0.3), {"size": 0.4, "smooth": 0.1}))
        assert not notes
        bpy.data.materials.remove(bpy.data.materials["tested"])


def test_sheen_and_velvet():
    if V1:
        check(surface("ShaderNodeBsdfVelvet", Sigma=0.4)[0], ("velvet", 0.8, {"sigma": 0.4}))
        return
    for distribution, wanted in (("ASHIKHMIN", ("velvet", 0.8, {"sigma": 0.4})),
                                 ("MICROFIBER", ("sheen", 0.8, {"roughness": 0.4}))):
        check(surface("ShaderNodeBsdfSheen", distribution, Roughness=0.4)[0], wanted)
        bpy.data.materials.remove(bpy.data.materials["tested"])


def test_other_distributions():
    kind = "ShaderNodeBsdfGlossy" if V1 else "ShaderNodeBsdfAnisotropic"
    for distribution in ("BECKMANN", "ASHIKHMIN_SHIRLEY"):
        steps, notes = surface(kind, distribution, Color=(0.9, 0.8, 0.7), Roughness=0.3)
        check(steps, (distribution.lower(), (0.9, 0.8, 0.7), {"roughness_x": 0.3, "roughness_y": 0.3}))
        assert not notes
        bpy.data.materials.remove(bpy.data.materials["tested"])


def test_glossy():
    kind = "ShaderNodeBsdfGlossy" if V1 else "ShaderNodeBsdfAnisotropic"
    for distribution, multi in (("GGX", 0), ("MULTI_GGX", 1)):
        if V1 and multi:
            continue
        steps, notes = surface(kind, distribution, Color=(0.9, 0.8, 0.7), Roughness=0.3)
        check(steps[:1], ("glossy", 1.0, {"roughness": 0.3, "multiscatter": multi} | rgb("tint", 0.9, 0.8, 0.7)))
        assert not notes
        bpy.data.materials.remove(bpy.data.materials["tested"])


def test_beckmann_refraction_and_glass():
    for kind, reflects in (("Refraction", 0), ("Glass", 1)):
        steps, notes = surface(f"ShaderNodeBsdf{kind}", "BECKMANN", Color=(1.0, 1.0, 1.0), Roughness=0.2, IOR=1.3)
        check(steps, ("beckmann_glass", 1, {"roughness": 0.2, "ior": 1.3, "reflects": reflects}))
        assert not notes
        bpy.data.materials.remove(bpy.data.materials["tested"])


def test_refraction_and_glass():
    steps, _ = surface("ShaderNodeBsdfRefraction", "GGX", Color=(0.5, 0.6, 0.7), Roughness=0.1, IOR=1.3)
    check(steps, ("refraction", (0.5, 0.6, 0.7), {"roughness": 0.1, "ior": 1.3}))
    bpy.data.materials.remove(bpy.data.materials["tested"])
    steps, _ = surface("ShaderNodeBsdfGlass", "GGX", Color=(0.5, 0.6, 0.7), Roughness=0.0, IOR=1.4)
    check(steps, ("glass", 1.0, {"roughness": 0.0, "ior": 1.4, "multiscatter": 0} | rgb("tint", 0.5, 0.6, 0.7)))


def test_transparent_and_emission():
    check(surface("ShaderNodeBsdfTransparent", Color=(0.5, 1.0, 1.0))[0], ("transparent", (0.5, 1, 1), {}))
    bpy.data.materials.remove(bpy.data.materials["tested"])
    check(surface("ShaderNodeEmission", Color=(0.5, 1.0, 1.0), Strength=4.0)[0], ("emission", (2, 4, 4), {}))


def test_holdout():
    steps, notes = surface("ShaderNodeHoldout")
    check(steps, ("holdout", 1, {}))
    assert not notes


def test_mix_and_add_fold_into_weights():
    def build(tree, output):
        mix = node(tree, "ShaderNodeMixShader", output.inputs["Surface"], Fac=0.25)
        both = node(tree, "ShaderNodeAddShader", mix.inputs[1])
        node(tree, "ShaderNodeBsdfDiffuse", both.inputs[0], Color=(0.4, 0.4, 0.4))
        node(tree, "ShaderNodeEmission", both.inputs[1], Color=(1.0, 1.0, 1.0), Strength=2.0)
        node(tree, "ShaderNodeBsdfTransparent", mix.inputs[2])
    check(exported(build)[0], ("diffuse", 0.3, {}), ("emission", 1.5, {}), ("transparent", 0.25, {}))


def test_mixed_by_a_value():
    """Where the factor differs from point to point weights are values, and no closure is dropped."""
    def build(tree, output):
        mix = node(tree, "ShaderNodeMixShader", output.inputs["Surface"])
        geometry = tree.nodes.new("ShaderNodeNewGeometry")
        tree.links.new(geometry.outputs["Backfacing"], mix.inputs[0])
        node(tree, "ShaderNodeBsdfTranslucent", mix.inputs[1])
        node(tree, "ShaderNodeBsdfPrincipled", mix.inputs[2], **({"Clearcoat": 1.0} if V1 else {"Coat_Weight": 1.0}))
    steps, notes, _ = exported(build)
    assert [s[0] for s in steps] == ["translucent", "specular", "layer_specular", "specular", "layer_specular",
                                     "diffuse"]
    assert not notes


def test_closures_without_weight_are_dropped():
    def build(tree, output):
        mix = node(tree, "ShaderNodeMixShader", output.inputs["Surface"], Fac=1.0)
        node(tree, "ShaderNodeBsdfToon", mix.inputs[1])
        node(tree, "ShaderNodeBsdfDiffuse", mix.inputs[2])
    steps, notes, _ = exported(build)
    check(steps, ("diffuse", 0.8, {}))
    assert not notes  # what does not show is not talked about


def principled(**inputs):
    def build(tree, output):
        made = node(tree, "ShaderNodeBsdfPrincipled", output.inputs["Surface"], **inputs)
        made.distribution = "GGX"
    return exported(build)[:2]


def test_principled_plain():
    steps, notes = principled(Base_Color=(0.2, 0.4, 0.6), Roughness=0.3, IOR=1.45)
    coat = {"roughness": 0.3, "ior": 1.45, "multiscatter": 0} | rgb("tint", 1, 1, 1)
    check(steps, ("specular", 1, coat), ("layer_specular", 1, coat), ("diffuse", (0.2, 0.4, 0.6), {}))
    assert not notes


def test_principled_everything():
    steps, _ = principled(**{
        "Base_Color": (0.25, 0.36, 0.49), "Metallic": 0.2, "Roughness": 0.3, "IOR": 1.5, "Alpha": 0.5,
        PRINCIPLED["level"]: 0.8, PRINCIPLED["transmission"]: 0.25, PRINCIPLED["emission"]: (1.0, 2.0, 3.0),
        "Emission_Strength": 2.0})
    root = np.sqrt(1.6 * 0.04)
    check(steps, ("transparent", 0.5, {}), ("emission", (1, 2, 3), {}),
          ("metal", 0.1, rgb("f0", 0.25, 0.36, 0.49) | rgb("f82", 1, 1, 1)),
          ("principled_glass", 0.1, {"ior": 1.5} | rgb("transmission", 0.5, 0.6, 0.7)),
          ("specular", 0.3, {"ior": (1 + root) / (1 - root)}), ("layer_specular", 1, {}),
          ("diffuse", np.array((0.25, 0.36, 0.49)) * 0.3, {}))


def test_principled_without_specular_is_diffuse():
    steps, _ = principled(**{"Base_Color": (0.2, 0.4, 0.6), PRINCIPLED["level"]: 0.0})
    check(steps, ("diffuse", (0.2, 0.4, 0.6), {}))


def test_principled_tint():
    steps, _ = principled(Base_Color=(0.2, 0.4, 0.6), Specular_Tint=0.5 if V1 else (0.6, 0.7, 0.8))
    check(steps[:1], ("specular", 1, rgb("tint", 0.6, 0.7, 0.8)))


def test_principled_sheen_and_coat_lie_over_the_rest():
    """Sheen over coat over specular over diffuse. Files of 3.x have a fifth of the sheen and a quarter of the coat."""
    inputs = {"Clearcoat": 0.8, "Clearcoat_Roughness": 0.1, "Sheen": 0.5} if V1 else {
        "Coat_Weight": 0.8, "Coat_Roughness": 0.1, "Coat_IOR": 1.6, "Coat_Tint": (0.9, 0.8, 0.7), "Sheen_Weight": 0.5,
        "Sheen_Tint": (1.0, 0.5, 0.2), "Sheen_Roughness": 0.4}
    steps, notes = principled(Base_Color=(0.2, 0.4, 0.6), Metallic=0.25, **inputs)
    sheen = ("sheen", 0.1, {"roughness": 0.5}) if V1 else ("sheen", (0.5, 0.25, 0.1), {"roughness": 0.4})
    coat = ("specular", 0.2 if V1 else 0.8, {"roughness": 0.1, "ior": 1.5 if V1 else 1.6, "multiscatter": 1})
    tint = () if V1 else (("layer_absorption", 0.8, {"ior": 1.6} | rgb("tint", 0.9, 0.8, 0.7)),)
    check(steps, sheen, ("layer_sheen", *sheen[1:]), coat, ("layer_specular", *coat[1:]), *tint, ("metal", 0.25, {}),
          ("specular", 0.75, {}), ("layer_specular", 1, {}), ("diffuse", (0.15, 0.3, 0.45), {}))
    assert not notes


def test_principled_rough_diffuse():
    if not V1:
        steps, _ = principled(**{"Base_Color": (0.2, 0.4, 0.6), PRINCIPLED["level"]: 0.0, "Diffuse_Roughness": 0.5})
        check(steps, ("rough_diffuse", (0.2, 0.4, 0.6), {"roughness": 0.5} | rgb("albedo", 0.2, 0.4, 0.6)))


def test_principled_film():
    if V1:
        return
    steps, notes = principled(**{"Base_Color": (0.25, 0.25, 0.25), "Roughness": 0.3, "Thin_Film_Thickness": 300.0,
                                 "Thin_Film_IOR": 1.4, PRINCIPLED["transmission"]: 0.5})
    film = {"thickness": 300.0, "film_ior": 1.4}
    both = film | {"roughness_x": 0.3, "roughness_y": 0.3}
    check(steps, ("film_glass", 0.5, film | {"roughness": 0.3}), ("film_specular", 0.5, both),
          ("layer_film_specular", 1, both), ("diffuse", 0.125, {}))
    assert not notes


MEAN_PATH = 0.25 / np.pi  # over the radius


def test_subsurface():
    others = {"IOR": 1.3} if V1 else {"IOR": 1.3, "Roughness": 0.25}

    def build(tree, output):
        shader = node(tree, "ShaderNodeSubsurfaceScattering", output.inputs["Surface"], Color=(0.2, 0.4, 0.6),
                      Scale=2.0, Radius=(1.0, 0.5, 0.0), **others)
        shader.falloff = "RANDOM_WALK_FIXED_RADIUS" if V1 else "RANDOM_WALK"
    steps, notes, _ = exported(build)
    walk = {"ior": 1.3, "roughness": 1.0 if V1 else 0.5, "diffuse": 0.0, "anisotropy": 0.0, "out": 1.0}
    assert [s[0] for s in steps] == ["diffuse", "subsurface"] and not notes
    near(steps[0][1], (0.0, 0.0, 0.6))
    near(steps[1][1], (0.2, 0.4, 0.0))
    for name, value in (walk | rgb("albedo", 0.2, 0.4, 0.6)).items():
        near(steps[1][2][name], value)
    near(steps[1][2]["radius_g"], MEAN_PATH)


def test_subsurface_of_skin_and_of_what_is_not_supported():
    for falloff, share in (("RANDOM_WALK" if V1 else "RANDOM_WALK_SKIN", 0.5), ("BURLEY", 0.0)):
        def build(tree, output, falloff=falloff):
            shader = node(tree, "ShaderNodeSubsurfaceScattering", output.inputs["Surface"], Radius=(1.0, 1.0, 1.0))
            shader.falloff = falloff
        (step,), notes, _ = exported(build)
        near(step[2]["diffuse"], share)
        assert bool(notes) == (falloff == "BURLEY")
        bpy.data.materials.remove(bpy.data.materials["tested"])


def test_principled_subsurface():
    """In files of 3.x the amount is the scale: all light goes below, and the colour is mixed with another."""
    inputs = {"Subsurface": 0.25, "Subsurface_Color": (1.0, 0.8, 0.6)} if V1 else {
        "Subsurface_Weight": 0.25, "Subsurface_Scale": 0.25}
    steps, _ = principled(Base_Color=(0.2, 0.4, 0.6), Subsurface_Radius=(1.0, 0.5, 0.25),
                          **{PRINCIPLED["level"]: 0.0}, **inputs)
    color = np.array((0.4, 0.5, 0.6)) if V1 else np.array((0.2, 0.4, 0.6))
    assert [s[0] for s in steps] == (["subsurface"] if V1 else ["subsurface", "diffuse"])
    near(steps[0][1], color * (1.0 if V1 else 0.25))
    radius = {} if V1 else {"radius_r": 0.25 * MEAN_PATH}  # V1's method is the skin's
    for name, value in (rgb("albedo", *color) | radius).items():
        near(steps[0][2][name], value)


def test_principled_leaves_out_by_name():
    _, notes = principled(**{"Clearcoat" if V1 else "Coat_Weight": 1.0, PRINCIPLED["emission"]: (1.0, 1.0, 1.0),
                             "Emission_Strength": 1.0})
    assert any("emission" in what for what in notes)


def test_constants_are_folded():
    def build(tree, output):
        shader = node(tree, "ShaderNodeBsdfDiffuse", output.inputs["Surface"])
        mix = node(tree, "ShaderNodeMixRGB", shader.inputs["Color"], Fac=0.5)
        color = node(tree, "ShaderNodeRGB", mix.inputs[1])
        color.outputs[0].default_value = (0.2, 0.4, 0.6, 1.0)
        value = tree.nodes.new("ShaderNodeValue")
        value.outputs[0].default_value = 0.1
        double = tree.nodes.new("ShaderNodeMath")
        double.operation = "MULTIPLY"
        double.inputs[1].default_value = 2.0
        tree.links.new(value.outputs[0], double.inputs[0])
        reroute = tree.nodes.new("NodeReroute")
        tree.links.new(double.outputs[0], reroute.inputs[0])
        tree.links.new(reroute.outputs[0], mix.inputs[2])
    steps, notes, _ = exported(build)
    check(steps, ("diffuse", (0.2, 0.3, 0.4), {}))
    assert not notes


def test_groups_and_muted_nodes():
    group = bpy.data.node_groups.new("group", "ShaderNodeTree")
    if hasattr(group, "interface"):
        group.interface.new_socket("Tone", in_out="INPUT", socket_type="NodeSocketColor")
        group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    else:
        group.inputs.new("NodeSocketColor", "Tone")
        group.outputs.new("NodeSocketShader", "Shader")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    shader = node(group, "ShaderNodeBsdfDiffuse", end.inputs[0])
    bright = group.nodes.new("ShaderNodeBrightContrast")
    bright.mute = True
    group.links.new(start.outputs[0], bright.inputs["Color"])
    group.links.new(bright.outputs[0], shader.inputs["Color"])

    def build(tree, output):
        user = tree.nodes.new("ShaderNodeGroup")
        user.node_tree = group
        user.inputs[0].default_value = (0.3, 0.2, 0.1, 1.0)
        tree.links.new(user.outputs[0], output.inputs["Surface"])
    steps, notes, _ = exported(build)
    check(steps, ("diffuse", (0.3, 0.2, 0.1), {}))
    assert not notes


def test_unknown_nodes_are_named_and_the_socket_counts():
    def build(tree, output):
        shader = node(tree, "ShaderNodeBsdfDiffuse", output.inputs["Surface"], Color=(0.3, 0.2, 0.1))
        node(tree, "ShaderNodeShaderToRGB", shader.inputs["Color"]).name = "Profile"
        node(tree, "ShaderNodeBevel", shader.inputs["Normal"])
    steps, notes, _ = exported(build)
    check(steps, ("diffuse", (0.3, 0.2, 0.1), {}))
    for words in (("Profile", "Color"), ("Bevel", "normal")):
        assert any(all(word in what for word in words) for what in notes), notes


def test_anisotropy_runs_along_a_tangent():
    """Of a constant amount, the larger roughness first; the tangent is a value, and so are then the parameters."""
    steps, notes, scene = exported(lambda tree, output: node(
        tree, "ShaderNodeBsdfPrincipled", output.inputs["Surface"], Metallic=1.0, Anisotropic=0.6, Roughness=0.4))
    assert [s[0] for s in steps] == ["aniso_metal"] and not notes
    flags, constants = int(scene.instruction_flags[0]), dict(zip(scene.step_to, scene.step_number, strict=True))
    assert flags >> 16 and flags >> 8 & 255
    aspect = (1.0 - 0.9 * 0.6) ** 0.25
    near([constants[int(steps[0][2][name])] for name in ("roughness_x", "roughness_y")], [0.4 / aspect, 0.4 * aspect])


def test_two_stacks_begin_anew():
    def build(tree, output):
        mix = node(tree, "ShaderNodeMixShader", output.inputs["Surface"])
        node(tree, "ShaderNodeBsdfPrincipled", mix.inputs[1], Roughness=0.2)
        node(tree, "ShaderNodeBsdfPrincipled", mix.inputs[2], Roughness=0.6)
    steps, notes, _ = exported(build)
    assert [s[0] for s in steps] == ["specular", "specular", "layer_specular", "diffuse", "layer_reset",
                                     "layer_specular", "diffuse"]
    near([steps[k][2]["roughness"] for k in (0, 1, 2, 5)], [0.2, 0.6, 0.2, 0.6])
    assert not notes


def test_without_nodes_and_without_material():
    plain = bpy.data.materials.new("plain")
    plain.diffuse_color = (0.1, 0.2, 0.3, 1.0)
    if bpy.app.version < (5, 0, 0):
        plain.use_nodes = False
    else:
        plain.node_tree.nodes.clear()
        shader = node(plain.node_tree, "ShaderNodeBsdfDiffuse", Color=(0.1, 0.2, 0.3))
        plain.node_tree.links.new(shader.outputs[0], plain.node_tree.nodes.new("ShaderNodeOutputMaterial").inputs[0])
    add("plain", square(materials=(plain,)))
    add("bare", square())
    add("empty slot", square(materials=(None,)))
    scene = export()
    check(program(scene, "plain"), ("diffuse", (0.1, 0.2, 0.3), {}))
    check(program(scene, "default_surface"), ("diffuse", 0.8, {}))
    assert len(scene.material_first) == 3


def test_output_without_a_shader_is_black():
    assert exported(lambda tree, output: None)[0] == []


def test_output_for_cycles_counts():
    def build(tree, output):
        node(tree, "ShaderNodeBsdfDiffuse", output.inputs["Surface"], Color=(1.0, 0.0, 0.0))
        output.target = "EEVEE"
        other = tree.nodes.new("ShaderNodeOutputMaterial")
        other.target = "CYCLES"
        node(tree, "ShaderNodeBsdfDiffuse", other.inputs["Surface"], Color=(0.0, 1.0, 0.0))
    check(exported(build)[0], ("diffuse", (0, 1, 0), {}))


def test_metallic_node():
    if not hasattr(bpy.types, "ShaderNodeBsdfMetallic"):
        return  # versions before 4.3
    steps, _ = surface("ShaderNodeBsdfMetallic", "GGX", Base_Color=(0.9, 0.7, 0.3), Edge_Tint=(1.0, 0.9, 0.8),
                       Roughness=0.2)
    check(steps, ("metal", 1, {"roughness": 0.2} | rgb("f0", 0.9, 0.7, 0.3) | rgb("f82", 1.0, 0.9, 0.8)))
    bpy.data.materials.remove(bpy.data.materials["tested"])

    def build(tree, output):
        made = node(tree, "ShaderNodeBsdfMetallic", output.inputs["Surface"], Roughness=0.2)
        made.fresnel_type = "PHYSICAL_CONDUCTOR"
        made.inputs["IOR"].default_value, made.inputs["Extinction"].default_value = (0.2, 0.9, 1.1), (3.9, 2.4, 2.2)
    steps, notes, _ = exported(build)
    wanted = {"roughness": 0.2, "multiscatter": 1} | rgb("n", 0.2, 0.9, 1.1) | rgb("k", 3.9, 2.4, 2.2)
    check(steps, ("conductor", 1, wanted))
    assert not notes


run_all(sys.modules[__name__])

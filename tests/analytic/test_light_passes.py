"""Light passes: together they are the picture, and each has what its closures bring, by known answers."""

import numpy as np
import pytest

from isophote.passes import PASSES, make_named, make_passes
from isophote.records import numbers
from isophote.values import ARITHMETIC
from tests.parity.scenes import SCENES
from tests.parity.scenes.shown import GROUPS, NAMED, shown
from tests.scenes import POINT, SUN, Builder, ball, diffuse, emission, pixels, place, program, quad, ready, render

KINDS = ("Diff", "Gloss", "Trans")
LIGHT = ("combined", "emission", "environment",
         *(f"{kind}_{of}" for kind in ("diffuse", "glossy", "transmission") for of in ("direct", "indirect", "color")))
GLOSSY = ("glossy", 0.5, dict(roughness=0.4, multiscatter=0))


def passes_of(scene, samples=16, **settings):
    """(passes of a render by Blender's names, what of the picture each of them makes)."""
    made = make_passes(render(scene, samples, passes=LIGHT, **settings), LIGHT)
    parts = {f"{kind}{of}": made[f"{kind}{of}"] * made[f"{kind}Col"].astype(float)
             for kind in KINDS for of in ("Dir", "Ind")}
    return made, parts | {"Emit": made["Emit"], "Env": made["Env"]}


@pytest.mark.parametrize("settings", [{}, dict(clamp_direct=0.5, clamp_indirect=0.1)], ids=["whole", "clamped"])
@pytest.mark.parametrize("name", SCENES)
def test_the_passes_are_the_picture(name, settings):
    """sum of (direct + indirect) * colour, emission and environment: but for rounding, of which there is some for each
    of a pixel's contributions."""
    made, parts = passes_of(SCENES[name](), **settings)
    together = sum(parts.values())
    picture = made["Combined"][..., :3]
    assert np.abs(together - picture).max() <= 3e-6 * picture.max() and picture.max() > 0
    np.testing.assert_allclose(together, picture, rtol=2e-5, atol=1e-6 * picture.max())


def test_passes_change_no_bit_of_the_picture():
    scene = SCENES["closures"]()
    with_passes, without = (render(scene, 16, passes=passes) for passes in (tuple(PASSES), ("combined",)))
    assert (pixels(with_passes) == pixels(without)).all()


def test_a_floor_in_the_sun():
    """Direct light of a diffuse floor is E/pi whatever its colour, which is a pass of its own."""
    b = Builder((4, 4))
    b.add(quad((9, 0, -5), (90, 0, 0), (0, 90, 0)), diffuse((0.8, 0.4, 0.1)))
    b.lamp(SUN, 3.0)
    made, _ = passes_of(b.make())
    np.testing.assert_allclose(made["DiffDir"], 3.0 / np.pi, rtol=1e-5)
    np.testing.assert_allclose(made["DiffCol"], np.broadcast_to((0.8, 0.4, 0.1), (4, 4, 3)), rtol=1e-6)
    for name in ("DiffInd", "GlossDir", "GlossInd", "GlossCol", "TransDir", "TransInd", "TransCol", "Emit", "Env"):
        assert not made[name].any(), name


def test_what_the_camera_sees_itself():
    """Emission and environment, also through transparent surfaces, whose colour does not count."""
    b = Builder((8, 4))
    b.world = (1.0, 2.0, 3.0)
    b.add(quad((0.5, 9, -3), (0.5, 0, 0), (0, 90, 0)), emission(4.0))
    b.add(quad((9, 0, -2), (90, 0, 0), (0, 90, 0)), program(("transparent", (0.5, 0.25, 1.0))))
    made, _ = passes_of(b.make(), 64, filter_width=0.0)
    np.testing.assert_allclose(made["Env"][:, 0], np.broadcast_to((0.5, 0.5, 3.0), (4, 3)), rtol=1e-5)
    np.testing.assert_allclose(made["Emit"][:, 5], np.broadcast_to((2.0, 1.0, 4.0), (4, 3)), rtol=1e-5)
    assert not any(made[f"{kind}{of}"].any() for kind in KINDS for of in ("Dir", "Ind", "Col"))


@pytest.mark.parametrize("roughness", [0.0, 0.3])
def test_glass_reflects_and_transmits(roughness):
    """A pane of glass seen from above in a world of 1: its own reflection is the glossy part, what comes through it
    or back from its other side the transmitted one."""
    b = Builder((4, 4))
    b.world = 1.0
    glass = program(("glass", 1.0, dict(roughness=roughness, ior=1.5, multiscatter=0)))
    b.look((0, 0, 3), (0, 0, 0), 1e-3, up=(0, 1, 0))
    b.add(quad((0.1, 0, 0), (9, 0, 0), (0, 9, 0)), glass)
    made, parts = passes_of(b.make(), 4096)
    if roughness == 0.0:
        np.testing.assert_allclose(parts["GlossDir"].mean(), 0.04, rtol=0.05)
        np.testing.assert_allclose(parts["TransDir"].mean(), 0.96, rtol=0.01)
    np.testing.assert_allclose(made["GlossCol"].mean(), 0.04, rtol=0.05)
    np.testing.assert_allclose(made["TransCol"].mean(), 0.96, rtol=0.01)
    assert not parts["DiffDir"].any() and not made["DiffCol"].any()


def test_mixed_closures_have_each_their_own_light():
    """Light is linear: what a mix's closures bring is what materials of them alone do."""
    def lit(*steps):
        b = Builder((6, 6))
        b.look((0, -3, 2), (0, 0, 0.3), 0.4)
        b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
        b.add(ball((0, 0, 0.6), 0.6, 16), program(*steps))
        b.lamp(POINT, 100.0, place((1, -2, 3)), size=(0.5, 0))
        return passes_of(b.make(), 2048, max_bounces=1)[1]

    mixed, matte, shining = (lit(*steps) for steps in ((("diffuse", 0.4), GLOSSY), (("diffuse", 0.4),), (GLOSSY,)))
    ball_only = np.s_[2:4, 2:4]
    for of in ("Dir", "Ind"):
        close = dict(rtol=0.03, atol=2e-3)
        for kind, alone in (("Diff", matte), ("Gloss", shining)):
            ours, theirs = (parts[f"{kind}{of}"][ball_only].mean() for parts in (mixed, alone))
            np.testing.assert_allclose(ours, theirs, **close)
            assert ours > 0.01


# ------------------------------------------------------------------ light groups


@pytest.mark.parametrize("settings", [{}, dict(clamp_direct=0.5, clamp_indirect=0.1)], ids=["whole", "clamped"])
def test_groups_of_all_lights_are_the_picture(settings):
    film = render(shown(), 32, passes=("combined",), named=NAMED, **settings)
    made = make_named(film)
    together = sum(made[f"Combined_{name}"].astype(float) for name in GROUPS)
    picture = pixels(film)[..., :3]
    np.testing.assert_allclose(together, picture, rtol=1e-5, atol=1e-6 * picture.max())
    assert all(made[f"Combined_{name}"].mean() > 0.01 for name in GROUPS)


@pytest.mark.parametrize("varying", [False, True], ids=["even", "map"])
def test_each_group_has_its_own_light(varying):
    """A floor in the sun, under a world and a panel: what the sun brings is known, the others by renders without it."""
    def floor(sun, groups):
        b = Builder((6, 6), light_groups=("Sun", "Other"))
        b.look((0, -1, 3), (0, 0, 0), 0.3)
        b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
        b.add(quad((0, 1, 1), (0.5, 0, 0), (0, 0, 0.5)), emission(2.0))
        b.world, others = 0.3, {}
        if varying:
            b.material(program(("emission", (0.1, 0.2, 0.3))))
            b.material(emission(tuple(ARITHMETIC.call("position", ())[:3])))
            others = dict(world_material=[3])
        if sun:
            b.lamp(SUN, 3.0, flags=groups[0] << 16)
        return b.make(instance_group=[0, groups[1]], world_group=groups[1], **others)

    sun, others, nothing = (make_named(render(scene, 1024, passes=("combined",), named=scene.named, max_bounces=0))
                            for scene in (floor(True, (1, 2)), floor(False, (1, 2)), floor(True, (0, 0))))
    assert sun["Combined_Sun"].mean() == pytest.approx(0.5 * 3 / np.pi, rel=0.02)
    np.testing.assert_allclose(sun["Combined_Other"].mean((0, 1)), others["Combined_Other"].mean((0, 1)), rtol=0.05)
    assert not others["Combined_Sun"].any() and not any(plane.any() for plane in nothing.values())


def test_groups_ask_for_no_kernels_but_their_own():
    """They share a word with a lamp's limit of bounces."""
    def features(flags):
        b = Builder((6, 6), light_groups=("Sun",))
        b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
        b.lamp(SUN, 3.0, flags=flags)
        return ready(b.make()).features

    limits = numbers()["FEATURE_LIGHT_LIMITS"]
    assert features(1 << 16) == features(0) and features(1 << 16 | 3 << 8) == features(0) | limits

"""Pictures: the smallest type that holds them, alpha, each kept once, sequences, tiles, and what cannot be read."""

import os
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from common import add, export, material, node, notes_of, run_all, square

BYTE, SHORT, HALF, FLOAT = 2, 1, 5, 4  # TEXEL_ numbers of kernels/scene_records.h
SIZES = {BYTE: np.uint8, SHORT: np.uint16, HALF: np.float16, FLOAT: np.float32}
SRGB, DIVIDE_ALPHA = 1, 2
FOLDER = Path(tempfile.mkdtemp())
try:
    import OpenImageIO  # noqa: F401
    HAS_FILES = True
except ImportError:
    HAS_FILES = False


def noise(channels=4, height=2, width=3, seed=0):
    return np.random.default_rng(seed).random((height, width, channels)).astype(np.float32)


def image(texels, is_float=False, space="sRGB", alpha="STRAIGHT"):
    made = bpy.data.images.new("image", texels.shape[1], texels.shape[0], alpha=True, float_buffer=is_float)
    made.colorspace_settings.name, made.alpha_mode = space, alpha
    full = np.ones((*texels.shape[:2], 4), np.float32)
    full[:, :, :texels.shape[2]] = texels
    made.pixels.foreach_set(full.ravel())
    return made


def shown(*pictures, alpha=False, **modes):
    """The scene of a plane for each picture that shines with it."""
    for picture in pictures:
        def build(tree, output, picture=picture):
            emission = node(tree, "ShaderNodeEmission", output.inputs["Surface"])
            texture = node(tree, "ShaderNodeTexImage", emission.inputs["Color"])
            texture.image = picture
            for mode, value in modes.items():
                setattr(texture, mode, value)
            if alpha:
                tree.links.new(texture.outputs["Alpha"], emission.inputs["Strength"])
        add("square", square(materials=(material("shown", build),)))
    return export()


def texels_of(scene, number):
    first, width, height, channels, kind, _ = scene.images[number]
    return scene.image_texels[4 * first:].view(SIZES[kind])[:width * height * channels].reshape(height, width, channels)


def test_bytes_stay_bytes():
    scene = shown(image(noise(3)))
    assert scene.images[0, 3:].tolist() == [3, BYTE, SRGB | 1 << 2]
    np.testing.assert_array_equal(texels_of(scene, 0), np.rint(255 * noise(3)))


def test_colors_are_stored_times_alpha_unless_they_are_data():
    scene = shown(image(noise()), image(noise(), space="Non-Color"), image(noise(), alpha="CHANNEL_PACKED"), alpha=True)
    whole = np.rint(255 * noise()).astype(int)
    np.testing.assert_array_equal(texels_of(scene, 0)[:, :, :3], whole[:, :, :3] * whole[:, :, 3:] // 255)
    np.testing.assert_array_equal(texels_of(scene, 1), whole)
    np.testing.assert_array_equal(texels_of(scene, 2), whole)
    assert scene.images[:, 5].tolist() == [SRGB | DIVIDE_ALPHA | 4, 4, SRGB | 4]


def test_grey_is_one_channel_and_halfs_are_halfs():
    grey = np.repeat(noise(1), 3, axis=2)
    halfs = (8.0 * noise(3)).astype(np.float16).astype(np.float32)
    scene = shown(image(grey), image(halfs, is_float=True), image(noise(3), is_float=True))
    assert scene.images[:, 3:5].tolist() == [[1, BYTE], [3, HALF], [3, FLOAT]], scene.images
    np.testing.assert_array_equal(texels_of(scene, 1), halfs)
    np.testing.assert_array_equal(texels_of(scene, 2), noise(3))


def test_each_picture_is_kept_once():
    picture = image(noise(3))
    scene = shown(picture, picture, interpolation="Cubic")
    assert len(scene.images) == 1
    assert len(shown(picture, interpolation="Closest").image_texels) == len(scene.image_texels)


def test_repeats_are_texels_that_count():
    for interpolation, taps in (("Closest", 1), ("Linear", 4), ("Cubic", 16), ("Smart", 16)):
        bpy.data.objects.remove(bpy.data.objects.get("square") or bpy.data.objects.new("square", None))
        assert shown(image(noise(3)), interpolation=interpolation).step_repeat.max() == taps


def test_numbers_that_are_none_become_black():
    texels = noise(3)
    texels[0, 0, 1] = np.nan
    assert not texels_of(shown(image(texels, is_float=True)), 0)[0, 0].any()


def test_missing_pictures_are_magenta_and_named():
    broken = bpy.data.images.new("broken", 4, 4)
    broken.source, broken.filepath = "FILE", str(FOLDER / "nowhere.png")
    scene = shown(None, broken)
    notes = notes_of(scene, "shown") + notes_of(scene, "shown.001")
    assert any("it has no image: rendered magenta" in note for note in notes)
    assert any("nowhere.png' cannot be read" in note for note in notes), notes
    assert scene.instruction_weight.tolist() == [[1.0, 0.0, 1.0]] * 2


def save(name, value):
    made = image(np.full((2, 2, 3), value, np.float32), space="Non-Color")
    made.filepath_raw, made.file_format = str(FOLDER / name), "PNG"
    made.save()


def test_sequences_show_the_picture_of_the_frame():
    for number in (7, 8, 9):
        save(f"frame_{number:03d}.png", number / 255.0)
    picture = bpy.data.images.load(str(FOLDER / "frame_007.png"))
    picture.source = "SEQUENCE"
    bpy.context.scene.frame_set(2)
    def build(tree, output):
        emission = node(tree, "ShaderNodeEmission", output.inputs["Surface"])
        texture = node(tree, "ShaderNodeTexImage", emission.inputs["Color"])
        texture.image = picture
        user = texture.image_user
        user.frame_start, user.frame_duration, user.frame_offset = 1, 3, 6
    add("square", square(materials=(material("shown", build),)))
    scene = export()
    if HAS_FILES:
        assert (texels_of(scene, 0) == 8).all()
    else:
        assert "sequences and tiles need OpenImageIO" in notes_of(scene, "shown")[0]


def test_tiles():
    for tile in (1001, 1012):
        save(f"tile.{tile}.png", (tile - 1000) / 255.0)
    picture = bpy.data.images.load(str(FOLDER / "tile.1001.png"))
    picture.source = "TILED"
    picture.filepath = str(FOLDER / "tile.<UDIM>.png")
    picture.tiles.new(tile_number=1012)
    scene = shown(picture)
    if HAS_FILES:
        table = scene.value_tables.astype(int)
        assert table[0] == 13  # 12 places, and one for all that there are not
        assert (texels_of(scene, table[1]) == 1).all() and (texels_of(scene, table[12]) == 12).all()
        assert len(set(table[2:12])) == 1 and table[2] == table[13]
    else:
        assert "tile 1001: sequences and tiles need OpenImageIO" in notes_of(scene, "shown")[0]


os.chdir(FOLDER)
run_all(sys.modules[__name__])

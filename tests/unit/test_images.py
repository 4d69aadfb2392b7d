import os

import numpy as np
import pytest

from isophote.images import ImageError, check_writable, decode_srgb, encode_srgb, read_image, to_srgb8, write_image

oiio = pytest.importorskip("OpenImageIO")
rng = np.random.default_rng(5)


def planes(height=5, width=7):
    shapes = {"Combined": 4, "Depth": 1, "Normal": 3, "Albedo": 3, "Position": 3, "Sample Count": 1, "Error": 3}
    return {name: rng.normal(size=(height, width, count)).astype(np.float32) for name, count in shapes.items()}


def test_exr_round_trip_keeps_every_bit(tmp_path):
    written = planes()
    written["Error"][0, 0] = np.nan
    written["Depth"][1, 1] = 1e10
    write_image(tmp_path / "a.exr", written, {"isophote:partial": 1, "isophote:samples": 12})
    image = read_image(tmp_path / "a.exr")
    assert {name: a.tobytes() for name, a in image.planes.items()} == {name: a.tobytes() for name, a in written.items()}
    assert image.partial and image.metadata["isophote:samples"] == 12


def test_exr_has_blenders_channel_names_and_rows_from_the_top(tmp_path):
    written = planes()
    write_image(tmp_path / "a.exr", written)
    source = oiio.ImageInput.open(str(tmp_path / "a.exr"))
    names = source.spec().channelnames
    assert {"ViewLayer.Combined.R", "ViewLayer.Combined.A", "ViewLayer.Depth.Z", "ViewLayer.Normal.X",
            "ViewLayer.Albedo.B", "ViewLayer.Sample Count.X"} <= set(names)
    top = source.read_image(oiio.FLOAT)[0, :, names.index("ViewLayer.Depth.Z")]
    source.close()
    assert (top == written["Depth"][-1, :, 0]).all()


def test_one_part_a_pass_is_read_as_blender_5_writes_it(tmp_path):
    path, written = str(tmp_path / "parts.exr"), planes()
    specs = []
    for name, ids in (("Combined", "RGBA"), ("Depth", "Z"), ("Normal", "XYZ")):
        spec = oiio.ImageSpec(7, 5, len(ids), oiio.FLOAT)
        spec.channelnames = [f"ViewLayer.{name}.{channel}" for channel in ids]
        spec.attribute("name", f"ViewLayer.{name}")
        specs.append((name, spec))
    output = oiio.ImageOutput.create(path)
    assert output.open(path, [spec for _, spec in specs])
    for index, (name, spec) in enumerate(specs):
        if index:
            assert output.open(path, spec, "AppendSubimage")
        assert output.write_image(np.ascontiguousarray(written[name][::-1]))
    output.close()
    image = read_image(path)
    assert list(image.planes) == ["Combined", "Depth", "Normal"]
    for name in image.planes:
        assert image.planes[name].tobytes() == written[name].tobytes()


def test_bare_channels_are_combined_and_layers_are_told_apart(tmp_path):
    path = str(tmp_path / "layers.exr")
    spec = oiio.ImageSpec(2, 2, 4, oiio.FLOAT)
    spec.channelnames = ["B", "G", "R", "Fog.Depth.Z"]
    output = oiio.ImageOutput.create(path)
    output.open(path, spec)
    output.write_image(np.broadcast_to(np.float32([3, 2, 1, 9]), (2, 2, 4)).copy())
    output.close()
    image = read_image(path)
    assert image.planes["Combined"][0, 0].tolist() == [1, 2, 3]
    assert image.planes["Depth"][0, 0].tolist() == [9]


def test_png_holds_straight_srgb(tmp_path):
    combined = np.zeros((2, 3, 4), np.float32)
    combined[0, 0] = [0.5, 0.25, 1.0, 1.0]
    combined[1, 2] = [0.1, 0.2, 0.0, 0.5]  # premultiplied: straight 0.2, 0.4, 0
    write_image(tmp_path / "a.png", {"Combined": combined}, {"isophote:partial": 1})
    source = oiio.ImageInput.open(str(tmp_path / "a.png"))
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(str(tmp_path / "a.png"), config)
    pixels = source.read_image(oiio.UINT8)
    source.close()
    assert pixels[1, 0].tolist() == [188, 137, 255, 255]  # the lower row comes last
    assert pixels[0, 2].tolist() == [124, 170, 0, 128]
    image = read_image(tmp_path / "a.png")
    assert image.partial
    assert np.allclose(image.planes["Combined"], combined, atol=0.005)


def test_exposure_is_in_stops():
    combined = np.full((1, 1, 4), 0.25, np.float32)
    combined[..., 3] = 1.0
    brighter = np.full((1, 1, 4), 0.5, np.float32)
    brighter[..., 3] = 1.0
    assert (to_srgb8(combined, exposure=1.0) == to_srgb8(brighter)).all()


def test_srgb_is_its_own_inverse_and_clips():
    x = np.linspace(0.0, 1.0, 1001)
    assert np.allclose(decode_srgb(encode_srgb(x)), x, atol=1e-6)
    assert encode_srgb(np.array([-1.0, 7.0, np.nan, np.inf])).tolist() == pytest.approx([0.0, 1.0, 0.0, 1.0])


def test_a_failed_write_leaves_what_was_there(tmp_path):
    path = tmp_path / "a.png"
    write_image(path, planes())
    before = path.read_bytes()
    with pytest.raises(ImageError, match="a.png: .*Combined"):
        write_image(path, {"Depth": planes()["Depth"]})
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["a.png"]


def test_places_that_cannot_be_written_are_named(tmp_path):
    with pytest.raises(ImageError, match="there is no folder"):
        check_writable(tmp_path / "none" / "a.exr")
    with pytest.raises(ImageError, match="pictures end in .exr or .png"):
        check_writable(tmp_path / "a.jpg")
    (tmp_path / "folder.exr").mkdir()
    with pytest.raises(ImageError, match="is a folder"):
        check_writable(tmp_path / "folder.exr")
    check_writable(tmp_path / "a.exr")
    assert not (tmp_path / "a.exr").exists()


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="needs a folder that not even root may write to")
def test_read_only_folders_are_found_before_rendering():
    with pytest.raises(ImageError, match="cannot write to /proc/self"):
        check_writable("/proc/self/a.exr")


def test_damaged_pictures_are_named(tmp_path):
    path = tmp_path / "a.exr"
    write_image(path, planes(64, 64))
    whole = path.read_bytes()
    for cut in (0, 20, len(whole) // 2):
        path.write_bytes(whole[:cut])
        with pytest.raises(ImageError, match="a.exr: "):
            read_image(path)
    with pytest.raises(ImageError, match="no such file"):
        read_image(tmp_path / "none.exr")

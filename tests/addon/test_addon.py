# SPDX-License-Identifier: Apache-2.0
"""The add-on in real Blenders: registering, results, passes, regions, errors, cancelling."""

import json
import re
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

TURNING_CUBE = Path(__file__).parent / "scenarios" / "turning_cube.py"


def read(path) -> dict[str, np.ndarray]:
    """Every channel of every part of an EXR, (h, w) with rows from the bottom, by its full name."""
    source = oiio.ImageInput.open(str(path))
    assert source, f"{path}: {oiio.geterror()}"
    channels = {}
    part = 0
    while source.seek_subimage(part, 0):
        spec = source.spec()
        data = source.read_image(part, 0, 0, spec.nchannels, "float")
        window = np.zeros((spec.full_height, spec.full_width, spec.nchannels), np.float32)
        window[spec.y:spec.y + spec.height, spec.x:spec.x + spec.width] = data.reshape(spec.height, spec.width, -1)
        prefix = spec.getattribute("name") or ""
        for index, name in enumerate(spec.channelnames):
            # One part a pass (5.0) or all in one (before): the full name is the same.
            channels[name if "." in name or not prefix else f"{prefix}.{name}"] = window[::-1, :, index]
        part += 1
    source.close()
    return channels


def rgba(path) -> np.ndarray:
    channels = read(path)
    return np.stack([channels[c] for c in "RGBA"], axis=-1)


def test_register_and_unregister(host):
    found, log = host.scenario("register")
    assert found["on"] == found["again"]
    assert found["on"]["engine"] and found["on"]["scene"] and found["on"]["object"] and found["on"]["layer"]
    assert found["on"]["panels"] > 200
    assert found["off"] == {"engine": False, "scene": False, "object": False, "layer": False, "panels": 0}
    assert "Traceback" not in log


def test_passes_of_two_view_layers(host):
    found, log = host.scenario("passes")
    channels = read(host.folder / "passes.exr")
    centre = (24, 32)
    for layer in ("ViewLayer", "Empty"):
        for name, ids in (("Combined", "RGBA"), ("Depth", "Z"), ("Normal", "XYZ"), ("Position", "XYZ"),
                          ("Albedo", "RGB"), ("Sample Count", "X"), ("Invalid", "X"), ("Error", "RGB")):
            for channel in ids:
                assert f"{layer}.{name}.{channel}" in channels, sorted(channels)
    assert (channels["ViewLayer.Sample Count.X"] == 8).all() and not channels["ViewLayer.Invalid.X"].any()
    distance = found["distance"]
    assert distance - 2 < channels["ViewLayer.Depth.Z"][centre] < distance
    assert channels["Empty.Depth.Z"][centre] > 100
    normal = [channels[f"ViewLayer.Normal.{c}"][centre] for c in "XYZ"]
    assert np.linalg.norm(normal) == pytest.approx(1, abs=0.2)
    position = np.array([channels[f"ViewLayer.Position.{c}"][centre] for c in "XYZ"])
    assert np.abs(position).max() == pytest.approx(1, abs=1e-3), "on the surface of the cube, in the world"
    assert (channels["ViewLayer.Error.R"] >= 0).all() and channels["ViewLayer.Error.R"].max() > 0
    assert "Isophote: device" in log and "error" in log
    for name in ("Depth", "CryptoObject01", "Combined_Key"):
        assert f"note: pass '{name}': an AOV with the name of a pass: left out" in log
    assert "ViewLayer.Own.R" in channels and "ViewLayer.Depth.R" not in channels


def test_passes_are_those_of_cycles(host):
    """By their names in this version, and by their means: of light that is not yet divided by its colour."""
    found, _ = host.scenario("every_pass")
    theirs, ours = (read(host.folder / f"{engine}.exr") for engine in ("cycles", "isophote"))
    assert set(theirs) == set(ours)
    if found["version"][0] < 4:
        return  # its Principled BSDF is another one
    for name in ours:
        color = re.sub(r"(Dir|Ind)\b", "Col", re.sub(r"(Direct|Indirect)\b", "Color", name))
        a, b = (image[name] * (image[color] if color != name else 1) for image in (theirs, ours))
        assert b.mean() == pytest.approx(a.mean(), rel=0.01, abs=1e-3), name


def coverages(channels, kind) -> dict[int, np.ndarray]:
    """id's bits -> (h, w), of all passes of a kind of Cryptomatte."""
    pairs = [(channels[f"{name}.{a}"], channels[f"{name}.{b}"]) for name in sorted(
        {name[:-2] for name in channels if f".Crypto{kind}" in name}) for a, b in ("rg", "ba")]
    bits = [np.ascontiguousarray(ids).view(np.uint32) for ids, _ in pairs]
    return {each: sum(np.where(of == each, shares, 0) for of, (_, shares) in zip(bits, pairs, strict=True))
            for each in np.unique(bits).tolist() if each}


def test_cryptomatte_is_that_of_cycles(host):
    """Channels, coverage by id, what headers say, and what the compositor makes of it."""
    host.scenario("cryptomatte", timeout=400)
    theirs, ours = (read(host.folder / f"{engine}.exr") for engine in ("CYCLES", "ISOPHOTE"))
    assert set(theirs) == set(ours) and "ViewLayer.CryptoAsset02.a" in ours
    told = [{field.name: field.value for field in oiio.ImageInput.open(str(host.folder / f"{engine}.exr")).spec()
             .extra_attribs if field.name.startswith("cryptomatte/")} for engine in ("CYCLES", "ISOPHOTE")]
    assert set(told[0]) == set(told[1]) and len(told[0]) == 12
    for key in told[0]:
        assert key.endswith("/manifest") or told[0][key] == told[1][key]
    manifests = {told[1][f"{key[:-8]}name"]: (json.loads(text), told[0][key])
                 for key, text in told[1].items() if key.endswith("/manifest")}
    floor = 'Floor of "stones" ä'
    for kind, names in (("Object", {"Cube", floor, "Ball", "Both"}), ("Asset", {"Top", floor, "Ball", "Both"}),
                        ("Material", {"Material", "Veil", "Left", "Right", "default_surface"})):
        mine, other = manifests[f"ViewLayer.Crypto{kind}"]
        assert set(mine) == names
        assert all(f'"{name}":"{bits}"' in other for name, bits in mine.items()), "Cycles escapes nothing"
        found, expected = coverages(ours, kind), coverages(theirs, kind)
        assert set(found) == set(expected) == {int(bits, 16) for bits in mine.values()}
        for each in found:
            difference = found[each] - expected[each]
            assert np.abs(difference).max() < 0.25 and abs(difference.mean()) < 2e-3
            assert np.sqrt((difference**2).mean()) < 0.03
    matte, other = ours["Composite.Combined.R"], theirs["Composite.Combined.R"]
    ball = int(manifests["ViewLayer.CryptoObject"][0]["Ball"], 16)
    np.testing.assert_allclose(matte, coverages(ours, "Object")[ball], atol=1e-6)
    assert np.abs(matte - other).max() < 0.25 and abs((matte - other).mean()) < 2e-3


def test_shadows_are_caught_as_by_cycles(host):
    """The matte and the shadow behind it, or the matte alone beside the shadow's own pass."""
    host.scenario("shadow_catcher")
    for kind in ("combined", "apart"):
        theirs, ours = (read(host.folder / f"{engine}_{kind}.exr") for engine in ("cycles", "isophote"))
        assert set(theirs) == set(ours) and any("Shadow Catcher" in name for name in ours) == (kind == "apart")
        for name in ours:
            assert ours[name].mean() == pytest.approx(theirs[name].mean(), rel=0.05), (kind, name)
            assert np.abs(ours[name] - theirs[name]).mean() < 0.02, (kind, name)


def test_a_render_stops_at_the_error_of_the_panel(host):
    _, log = host.scenario("wanted_error")
    samples = read(host.folder / "wanted_error.exr")["ViewLayer.Sample Count.X"]
    assert 16 <= samples.min() == samples.max() < 4096 and "stopped by error" in log
    assert "95 % of pixels within" in log and "of the picture unsure" in log
    found = oiio.ImageInput.open(str(host.folder / "wanted_error.exr")).spec()
    texts = {a.name.split(".")[-1]: a.value for a in found.extra_attribs if "isophote.ViewLayer" in a.name}
    assert texts["stopped"] == "error" and texts["error_target"] == "10 %", texts
    assert 0.0 < float(texts["error_95"].split()[0]) <= 10.0


def test_region_percentage_and_transparency(host):
    found, _ = host.scenario("frames")
    full, crop, region = (rgba(host.folder / f"{name}.exr") for name in ("full", "crop", "region"))
    x0, y0, x1, y1 = (np.array(found["border"], np.float32) * np.array([97, 61, 97, 61], np.float32)).astype(int)
    assert full.shape == (61, 97, 4)
    assert crop.shape == (y1 - y0, x1 - x0, 4)
    assert np.array_equal(crop, full[y0:y1, x0:x1]), "a region has the bits of the whole"
    assert region.shape == full.shape
    assert np.array_equal(region[y0:y1, x0:x1], crop)
    outside = region.copy()
    outside[y0:y1, x0:x1] = 0
    assert not outside.any()
    half = rgba(host.folder / "half.exr")
    assert half.shape == (30, 48, 4)
    assert half[0, 0].tolist() == [0, 0, 0, 0] and half[15, 24, 3] == 1
    opaque = rgba(host.folder / "opaque.exr")
    assert (opaque[..., 3] == 1).all()


@pytest.mark.timed
def test_cancel_keeps_the_picture(host):
    found, log = host.scenario("cancel")
    assert found["seconds"] < 0.5, log
    assert rgba(host.folder / "cancelled.exr")[..., :3].max() > 0
    assert "stopped by cancelled" in log


def test_without_its_native_module_it_says_so(host):
    found, log = host.scenario("no_native")
    assert found["registered"] and log.count("the native module of Isophote") >= 2, log
    assert "Install the zip" in found["failed"] + log


def test_render_without_camera_fails_visibly(host):
    found, log = host.scenario("no_camera")
    assert "no camera" in found["failed"] + log
    assert "Isophote: error:" in log
    picture = host.folder / "no_camera.exr"
    if picture.exists():
        colours = np.unique(rgba(picture).reshape(-1, 4), axis=0)
        assert colours.tolist() == [[0, 0, 0, 1], [1, 0, 1, 1]], "a chequer that nobody takes for a picture"


@pytest.mark.parametrize("job", [["-f", "1"], ["-s", "1", "-e", "2", "-a"]], ids=["still", "animation"])
@pytest.mark.parametrize(("output", "said"), [("frame_##", "no camera in scene 'Scene'"),
                                              ("/proc/no/frame_##", "cannot save")], ids=["camera", "output"])
def test_errors_end_the_program_with_1(host, job, output, said):
    """As Blender does where a render reports an error or cannot be saved; an animation stops at the frame."""
    script = TURNING_CUBE if "proc" in output else TURNING_CUBE.with_name("cube_for_camera.py")
    done = host.run("--python", str(script), "-E", "ISOPHOTE", "-o", str(host.folder / output), "-F", "PNG", *job, "--",
                    str(host.folder))
    assert done.returncode == 1 and said in done.stdout, done.stdout
    assert len(list(host.folder.glob("frame_*.png"))) <= 1


def test_animation_from_the_command_line(host):
    done = host.run("--python", str(TURNING_CUBE), "-E", "ISOPHOTE", "-o", str(host.folder / "frame_##"), "-F", "PNG",
                    "-s", "1", "-e", "2", "-a", "--", str(host.folder))
    assert done.returncode == 0, done.stdout
    first, second = (oiio.ImageBuf(str(host.folder / f"frame_0{n}.png")).get_pixels() for n in (1, 2))
    assert first.shape == second.shape == (48, 64, first.shape[2])
    assert np.abs(first - second).max() > 0.1
    assert done.stdout.count("Isophote: device") == 2


def test_frames_have_the_bits_of_stills_and_what_is_kept_goes(host):
    """Geometry lives from frame to frame of an animation, and longer where Persistent Data is on; no bit knows."""
    found, log = host.scenario("animation")
    for frame in range(1, 5):
        still = rgba(host.folder / f"still_{frame:04d}.exr")
        for name in ("usual", "persistent", "again", "off", "opencl", "opencl_persistent"):
            assert np.array_equal(rgba(host.folder / f"{name}_{frame:04d}.exr"), still), (name, frame)
    last, before = (rgba(host.folder / f"{name}.exr") for name in ("persistent_last", "once_more"))
    assert np.array_equal(last, rgba(host.folder / "still_last.exr")) and not np.array_equal(last, before)
    assert found["usual"] == {"made": ["built", "kept", "kept", "refitted"], "left": 0}, log
    assert found["persistent"] == {"made": ["built", "kept", "kept", "refitted"], "left": 1}
    assert found["again"] == {"made": ["refitted", "kept", "kept", "refitted"], "left": 1}
    assert found["still"] == ["built"] * 4
    assert (found["off"], found["after"], found["loaded"]) == (0, 1, 0)
    made = ["built", "kept", "kept", "refitted"]
    assert found["opencl"] == {"made": made, "left": 0, "opened": 1, "devices": 0}
    assert found["opencl_persistent"] == {"made": made, "left": 1, "opened": 2, "devices": 1}
    assert found["opencl_after"] == {"opened": 2, "devices": 1} and found["devices_after"] == 0


def test_metadata_says_how_it_was_made(host):
    done = host.run("--python", str(TURNING_CUBE), "-o", str(host.folder / "still_#"), "-F", "PNG", "-f", "1", "--",
                    str(host.folder))
    assert done.returncode == 0, done.stdout
    spec = oiio.ImageInput.open(str(host.folder / "still_1.png")).spec()
    fields = {attribute.name: attribute.value for attribute in spec.extra_attribs}
    assert fields["isophote.ViewLayer.samples"] == "8" and fields["isophote.ViewLayer.partial"] == "no", fields


def test_settings_come_from_cycles(host):
    found, log = host.scenario("copy_cycles")
    assert found.pop("result") == ["FINISHED"]
    assert found == {"samples": 77, "time_limit": 12.5, "seed": 5, "max_bounces": 11, "diffuse_bounces": 3,
                     "glossy_bounces": 2, "transmission_bounces": 9, "transparent_bounces": 6, "clamp_direct": 1.5,
                     "clamp_indirect": 10.0, "filter_width": 2.5, "device": "openmp"}, log


def test_the_panel_says_what_was_left_out(host):
    found, log = host.scenario("left_out")
    assert found["before"] is None and found["empty"] == ["scene 'scene': it is empty: only the world is rendered"]
    assert found["after"] == ["material 'Material': Hair BSDF (ShaderNodeBsdfHair): not supported, rendered as Diffuse"]
    assert f"Isophote: note: {found['after'][0]}" in log
    assert "Traceback" not in log


def test_each_eye_has_its_view(host):
    """In every way that cameras converge, spherical stereo of panoramas included: as Cycles of the same Blender."""
    found, log = host.scenario("stereo", timeout=400)
    for name in found["names"]:
        ours, theirs = ([rgba(host.folder / f"{name}_{engine}_{eye}.exr")[..., :3] for eye in "LR"]
                        for engine in ("ISOPHOTE", "CYCLES"))
        for eye in (0, 1):
            assert np.quantile(np.abs(ours[eye] - theirs[eye]).max(axis=-1), 0.9) < 1e-4, name
        assert np.abs(ours[0] - ours[1]).mean() > 0.01, name
    assert "Isophote: view right" in log and "Isophote: error" not in log


def test_what_moves_blurs_as_in_cycles(host):
    """Places that a camera moves through, wherever the frame lies in its shutter's time, at last with objects that move
    beside it; Cycles' table of the shutter has 256 entries, which moves its times a little."""
    found, log = host.scenario("motion", timeout=400)
    for name in found["names"]:
        ours, theirs = (rgba(host.folder / f"{name}_{engine}.exr")[..., :3] for engine in ("ISOPHOTE", "CYCLES"))
        limit, off = (5e-3, 1e-3) if name != "objects" else (0.03, 4e-3)  # that one has light that bounces
        assert np.quantile(np.abs(ours - theirs).max(axis=-1), 0.9) < limit, name
        np.testing.assert_allclose(ours.mean(axis=(0, 1)), theirs.mean(axis=(0, 1)), atol=off)
    for name in ("perspective", "equirectangular"):
        both = [read(host.folder / f"vectors_{name}_{engine}.exr") for engine in ("ISOPHOTE", "CYCLES")]
        for channel in "XYZW":
            ours, theirs = (next(image[key] for key in image if key.endswith(f"Vector.{channel}")) for image in both)
            off = np.abs(ours - theirs) / (1 + np.abs(theirs))
            assert np.quantile(off, 0.9) < 1e-3 and np.abs(theirs).max() > 1, (name, channel, np.quantile(off, 0.9))
    assert "Isophote: error" not in log

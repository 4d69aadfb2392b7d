import numpy as np
import pytest
from noise_device import AOV_PLANES, radiance

from isophote.film import COMBINED_PLANES, Film, FilmError
from isophote.passes import PASSES, USUAL, channels_of, check_passes, make_passes, planes_for
from isophote.planes import make_planes

REGION = (2, 1, 9, 5)


def exposed(samples, first=0, planes=AOV_PLANES):
    film = Film(REGION, planes, first)
    for sample in range(first, first + samples):
        film.open[:] += radiance(REGION, sample, 3, planes)
        film.add_samples(1)
    return film


def test_passes_are_means_of_all_samples():
    samples = np.array([radiance(REGION, sample, 3, AOV_PLANES) for sample in range(71)], np.float64)
    made = make_passes(exposed(71), USUAL)
    assert list(made) == ["Combined", "Depth", "Normal", "Albedo", "Position", "Sample Count", "Invalid",
                          "Error"]
    expected = (samples[:, 0:4] + samples[:, 4:8]).mean(axis=0).transpose(1, 2, 0)
    assert np.allclose(made["Combined"], expected, rtol=1e-6)
    assert np.allclose(made["Normal"], samples[:, 13:16].mean(axis=0).transpose(1, 2, 0), rtol=1e-6)
    assert np.allclose(made["Albedo"], samples[:, 16:19].mean(axis=0).transpose(1, 2, 0), rtol=1e-6)
    assert (made["Sample Count"] == 71).all()


def test_depth_and_position_are_those_of_sample_0():
    made = make_passes(exposed(130), ["depth", "position"])
    y, x = np.mgrid[1:5, 2:9]
    assert (made["Depth"][..., 0] == x + 10).all()
    assert (made["Position"] == np.stack([x, y, x + y], axis=-1)).all()


def test_every_pass_has_its_shape_and_type():
    channels = channels_of(PASSES, 5)
    made = make_passes(exposed(2, planes=planes_for(PASSES, levels=5)), PASSES)
    assert list(made) == list(channels) and {"CryptoAsset00", "CryptoAsset02"} < set(made)
    for name, array in made.items():
        assert array.shape == (4, 7, len(channels[name])) and array.dtype == np.float32


def test_a_film_without_samples_is_black_not_nan():
    assert (make_passes(exposed(0), ["combined"])["Combined"] == 0.0).all()


def test_planes_follow_what_is_asked_for():
    assert planes_for(["combined", "error", "sample_count"]) == COMBINED_PLANES
    assert planes_for(["combined", "albedo"]).first == {"albedo": 9}
    assert planes_for(["albedo", "depth"]).first == {"depth": 9, "albedo": 10}
    light = planes_for(["diffuse_direct"], clamps=True)
    assert light.groups == ("diffuse_color", "diffuse_direct") and light.cut == 9 + 6 and int(light) == 9 + 6 + 4
    assert light.columns == 6 + 12 and planes_for(["diffuse_color"]).columns == 3
    with pytest.raises(ValueError, match="no planes haze; there are depth"):
        make_planes(["haze"])


def test_missing_parts_are_named():
    with pytest.raises(FilmError, match="pass albedo: the film was made without albedo"):
        make_passes(exposed(2, planes=COMBINED_PLANES), ["albedo"])
    with pytest.raises(FilmError, match="begins at sample 64"):
        make_passes(exposed(2, first=64), ["depth"])
    with pytest.raises(ValueError, match="no pass 'haze'; there are combined, depth"):
        check_passes(["combined", "haze"])

# SPDX-License-Identifier: Apache-2.0
"""The button that measures what settings cost, in real Blenders."""


def test_the_button_measures_the_open_scene(host):
    found, log = host.scenario("ledger")
    limited, clamped = found["limited"], found["clamped"]
    assert limited["error"] == clamped["error"] == "", log
    assert limited["sentences"][0].startswith("The limit of 0 bounces ended ")
    assert " of the light (95 %: " in limited["sentences"][0]
    assert clamped["sentences"][0].startswith("Clamping indirect light at 0.01 took ")
    assert limited["sentences"][-1] == "Measured on pictures of 48 x 32 pixels"
    assert found["stopped"] and found["engine"] == "ISOPHOTE", "the open file stays what it is"
    assert "Traceback" not in log

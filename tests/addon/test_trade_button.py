# SPDX-License-Identifier: Apache-2.0
"""The trade report's button in real Blenders: stopped, continued, and one of a changed scene."""

import json
from pathlib import Path


def test_the_button_makes_a_report(host):
    found, log = host.scenario("trade")
    whole, refused, stopped = (found[name] for name in ("whole", "refused", "stopped"))
    assert whole["error"] == "" and not whole["partial"], log
    assert refused["error"].startswith("the report there is of something else: clamp_indirect was 2.0, now 3.0")
    assert stopped["error"] == "" and stopped["partial"] and stopped["seconds"] < 25, log
    rows = json.loads((Path(whole["page"]).parent / "rows.json").read_text())
    base = next(choice for choice in rows["choices"] if choice["choice"] == "base")
    assert base["settings"]["clamp_indirect"] == 2.0 and rows["size"] == [32, 21] and rows["full_size"] == [48, 32]
    assert (Path(whole["page"]).parent / "pictures" / "base.picture.png").is_file()
    assert found["file"] == "" and found["engine"] == "ISOPHOTE", "the open file stays what it is"
    assert "Traceback" not in log

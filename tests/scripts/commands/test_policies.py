"""`activesuit policies`."""

import json

from activesuit.envs.policies import POLICIES
from activesuit.envs.policies.trained import shipped_policies
from activesuit.scripts.main import main


def test_lists_every_policy(capsys):
    main(["policies"])
    out = capsys.readouterr().out
    main(["policies", "--json"])
    found = json.loads(capsys.readouterr().out)
    assert list(found) == [*POLICIES, *shipped_policies()]
    for name, one in found.items():
        assert name in out
        assert one["does"].endswith(".")
    assert found["adaptive"]["sensors"] == ["encoders", "interaction"]
    assert {"suit", "load", "wearer", "forgetting"} <= set(found["adaptive"]["options"])

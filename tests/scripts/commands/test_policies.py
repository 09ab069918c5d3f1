"""`activesuit list policies`."""

import json

from activesuit.envs.policies import POLICIES
from activesuit.envs.policies.trained import shipped_policies
from activesuit.scripts.main import main
from helpers import fails, run


def test_lists_every_policy(capsys):
    main(["list", "policies"])
    out = capsys.readouterr().out
    main(["list", "policies", "--json"])
    found = json.loads(capsys.readouterr().out)
    assert list(found) == [*POLICIES, *shipped_policies()]
    for name, one in found.items():
        assert name in out
        assert one["does"].endswith(".")
    assert found["adaptive"]["sensors"] == ["encoders", "interaction"]
    assert {"suit", "load", "wearer", "forgetting"} <= set(found["adaptive"]["options"])


def test_says_what_one_needs(capsys):
    given = next(iter(shipped_policies().items()))
    found = [json.loads(run(capsys, "list", "policies", one, "--json")) for one in given]
    assert found[0][given[0]] == found[1][given[1]]
    assert "unknown policy 'magic'" in fails(capsys, "list", "policies", "magic")

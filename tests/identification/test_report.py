"""Words of fits: rows of parameters, and what a remark advises on the command line."""

import json
from typing import Any

from activesuit.hysteresis import HingedStops
from activesuit.hysteresis.parameter_table import parameter_table


def test_the_constant_of_a_model_is_not_called_the_offset_of_a_sensor():
    given: Any = {"thresholds": (0.1,), "weights": (1.0,), "knots": (1.0,), "slopes": (0.5, 0.5)}
    model = HingedStops(stiffness=2.0, offset=0.7, **given)
    _, rows = parameter_table({"value": model})
    assert ["offset of the model [N·m]", "0.7"] in rows
    assert "offset" in json.dumps(model.to_dict())  # files keep the name

"""What is said of a program's error."""

import pytest
from cflib.crazyflie import Crazyflie

from q2q_sim.licence.program_process.program_lines import error_in


@pytest.mark.parametrize(("name", "said"), [
    ("colAv.enable", "KeyError: 'colAv' in Param.get_value"),
    ("stabilizer.no", "KeyError: 'no' in Param.get_value"),
    ("stabilizer", "ValueError: not enough values to unpack (expected 2, got 1)"),
])  # fmt: skip
def test_where_an_unknown_parameter_is_read_cflib_is_named(name: str, said: str) -> None:
    param = Crazyflie().param
    param._initialized.set()
    param.values = {"stabilizer": {"controller": "1"}}
    with pytest.raises((KeyError, ValueError)) as caught:
        param.get_value(name)
    assert error_in(__file__, caught.value).what == said


def test_a_key_that_the_program_itself_lacks_is_not_of_cflib() -> None:
    with pytest.raises(KeyError) as caught:
        dict.__getitem__({}, "colAv")
    assert error_in(__file__, caught.value).what == "KeyError: 'colAv'"

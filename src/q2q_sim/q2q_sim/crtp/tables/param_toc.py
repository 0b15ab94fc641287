"""Table of contents of the parameters, in the order of their numbers.

Source: firmware: modules/src/param_logic.c.
"""

from q2q_sim.crtp.tables.number_types import TYPES
from q2q_sim.crtp.tables.toc import Toc, TocEntry
from q2q_sim.firmware.parameters.parameter_table import TABLE, Definition

EXTENDED, READ_ONLY = 0x10, 0x40


def type_byte(one: Definition) -> int:
    """Return the type byte of a parameter in the table."""
    kind = TYPES[one.kind].param or 0
    return kind | (EXTENDED if one.persistent else 0) | (READ_ONLY if one.read_only else 0)


def param_toc() -> Toc:
    """Return the parameters' table of contents."""
    return Toc([TocEntry(one.group, one.last, type_byte(one)) for one in TABLE])


PARAM_TOC = param_toc()

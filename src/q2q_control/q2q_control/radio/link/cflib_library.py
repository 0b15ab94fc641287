"""cflib's Crazyflie, without the logs and the thread that disturb a node.

cflib is imported only when one is made.
"""

import logging
import warnings
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cflib.crazyflie import Crazyflie

UNCONNECTED = r"(?s)The supervisor subsystem requires .* reports version -1\."
"""cflib's warning of old firmware where no vehicle is connected: the firmware is not known yet."""


def new_crazyflie(cache: str) -> "Crazyflie":
    """Return a Crazyflie that is not connected; `cache` is a folder for its tables, empty for none.

    Raises:
        ValueError: cflib is not installed.
    """
    try:
        import cflib.crtp
        from cflib.crazyflie import Crazyflie
    except ImportError as missing:
        words = "cflib is not installed: `pip install cflib==0.1.34`, or scripts/setup --dev"
        raise ValueError(words) from missing
    logging.getLogger("cflib").setLevel(logging.ERROR)  # the node itself logs every lost link
    logging.getLogger("cflib.crazyflie").addFilter(_is_news)
    warnings.filterwarnings("ignore", UNCONNECTED, UserWarning)
    cflib.crtp.init_drivers()
    made = Crazyflie(rw_cache=cache or None)
    made.link_statistics.latency.start = _no_thread
    return made


def hang_up(crazyflie: "Crazyflie") -> None:
    """Close a link without cflib's last setpoint of zero thrust, with which a flying vehicle falls."""
    link, crazyflie.link = crazyflie.link, None
    if link is not None:
        link.close()
    crazyflie.close_link()


def _no_thread() -> None:
    """Start no ping thread: CflibLink pings itself.

    cflib 0.1.34 joins its ping thread where a link is lost: from itself where a ping finds the loss, or while
    it waits for a lock that the joining thread holds.
    """


def _is_news(record: logging.LogRecord) -> bool:
    """Return whether the node does not log it itself: the reason of a failed link comes with a traceback."""
    return not str(record.msg).startswith("Couldn't load link driver")

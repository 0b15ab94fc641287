"""Connect by callbacks, change a parameter and read it back, without flying."""

from threading import Event

import cflib.crtp
from cflib.crazyflie import Crazyflie

done = Event()


def show(name: str, value: str) -> None:
    """Print a parameter."""
    print(name, value)
    done.set()


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    cf = Crazyflie()
    ready = Event()
    cf.fully_connected.add_callback(lambda _: ready.set())
    cf.open_link("radio://0/80/2M/E7E7E7E7E7")
    if not ready.wait(30.0):
        raise SystemExit("no connection")
    cf.param.add_update_callback(group="stabilizer", name="controller", cb=show)
    cf.param.set_value("stabilizer.controller", 2)
    done.wait(5.0)
    cf.close_link()

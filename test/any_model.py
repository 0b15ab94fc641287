"""A jet that the compiled sums over jets do not know as one."""

from q2q_model.downwash.jet import Jet


class AnyModel:
    """Jet that is not known to be one."""

    def __init__(self, jet: Jet) -> None:
        self.reach, self.max_delay = jet.reach, jet.max_delay
        self.delay, self.acceleration, self.deviation = jet.delay, jet.acceleration, jet.deviation

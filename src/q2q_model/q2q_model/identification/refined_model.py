"""Model scaled by a gain that was found in flight, and its file."""

from dataclasses import replace

from q2q_model.downwash.envelope_network import EnvelopeNetwork, Network
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.jet import Jet
from q2q_model.downwash.level_set import LevelSet, peak_downwash
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.geometry.zone import Cylinder
from q2q_model.model_files.model_bounds import check_model
from q2q_model.model_files.model_file import Fit, ModelFile

GAIN_STEP = 1e-3
"""Accuracy of the largest gain of a model near the bounds of model files [-]."""


class UnscalableModelError(ValueError):
    """Model whose downwash no gain multiplies."""


def refined_file(base: ModelFile, model: InteractionModel, gain: float) -> ModelFile:
    """Return the file of a model that is `gain` times that of its base.

    Its fit has the flights of the base and no score: those of the base are of another downwash. A zone of
    a downwash that the model no longer reaches is replaced by the paper's.
    """
    known = base.fit or Fit("model without a fit", ())
    fit = Fit(f"{known.method}, times {gain:.3f} in flight", known.flights, digests=known.digests)
    zone = base.zone
    if isinstance(zone, LevelSet) and zone.threshold >= peak_downwash(model):
        zone = Cylinder()
    return replace(base, interaction=model, fit=fit, zone=zone)


def scale_downwash(model: InteractionModel, gain: float) -> InteractionModel:
    """Return a model whose downwash is `gain` times as strong.

    Raises:
        UnscalableModelError: a model of another class than those of model files.
    """
    if isinstance(model, Jet):
        return replace(model, strength=gain * model.strength)
    if isinstance(model, EnvelopeNetwork):
        return replace(model, lower=_scaled(model.lower, gain), upper=_scaled(model.upper, gain))
    if isinstance(model, NoInteraction):
        return model
    raise UnscalableModelError(
        f"a model of the class {type(model).__name__} has no gain that can be refined in flight: "
        "give a Jet or an EnvelopeNetwork (identify --model-type)"
    )


def _scaled(net: Network, gain: float) -> Network:
    return replace(net, output_weights=gain * net.output_weights, output_bias=gain * net.output_bias)


def largest_gain(model: InteractionModel, most: float) -> float:
    """Return the largest gain, 1 to `most`, by which a model may be scaled; raise as `scale_downwash`."""
    if _may_be_scaled(model, most):
        return most
    low, high = 1.0, most
    while high - low > GAIN_STEP:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _may_be_scaled(model, middle) else (low, middle)
    return low


def _may_be_scaled(model: InteractionModel, gain: float) -> bool:
    """Return whether a model file may hold a scaled model."""
    try:
        check_model(scale_downwash(model, gain))
    except UnscalableModelError:
        raise
    except ValueError:
        return False
    return True

"""Model file of an airframe never flown, from that of another."""

from argparse import Namespace
from dataclasses import replace

from q2q_model.downwash.jet import Jet
from q2q_model.downwash.level_set import LevelSet, level_set
from q2q_model.downwash.scaled_jet import QuadrotorSize, scaled_jet
from q2q_model.geometry.zone import Cylinder, Ellipsoid, Zone
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_file import Fit, ModelFile, save


def run(args: Namespace) -> int:
    """Scale the jet of a model, write the result, print it, and return the exit status."""
    known = find_model(args.model)
    if not isinstance(known.interaction, Jet):
        kind = type(known.interaction).__name__
        raise ValueError(  # noqa: TRY004  the user's choice, not a defect
            f"model {args.model} is of the class {kind}: only a Jet can be scaled (identify --model-type jet)"
        )
    flown = QuadrotorSize(args.flown_mass, args.flown_rotor_radius)
    new = QuadrotorSize(args.mass, args.rotor_radius)
    below = None if args.below_mass is None else QuadrotorSize(args.below_mass, args.below_rotor_radius)
    jet = scaled_jet(known.interaction, flown, new, below)
    base = known.fit or Fit("", ())
    fit = Fit(f"{args.model}, scaled by momentum theory", base.flights, digests=base.digests)
    zone = scaled_zone(known.zone, jet, new.rotor_radius / flown.rotor_radius)
    save(args.out, ModelFile(jet, zone, fit=fit))
    print(
        f"induced velocity {new.induced_velocity:.2f} m/s (flown: {flown.induced_velocity:.2f}), "
        f"disk loading {new.disk_loading:.1f} kg/m^2 ({flown.disk_loading:.1f})\n"
        f"downwash {jet.strength:.2f} m/s^2 at {jet.reference_gap:.2f} m, "
        f"give or take {jet.relative_std:.0%}\nmodel: {args.out}"
    )
    return 0


def scaled_zone(zone: Zone, jet: Jet, length: float) -> Zone:
    """Return a zone `length` times as large; a level set is that of the scaled jet."""
    if isinstance(zone, LevelSet):
        return level_set(jet, zone.threshold)
    assert isinstance(zone, Cylinder | Ellipsoid)  # model files have no other
    return replace(zone, eps=length * zone.eps, d=length * zone.d)

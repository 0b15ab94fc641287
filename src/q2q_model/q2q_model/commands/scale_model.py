"""Scale a jet to another airframe by momentum theory.

Widths and gaps scale with the radius of the rotors, speeds with the induced velocity sqrt(m g / (2 rho A)),
and the downwash on another vehicle below with the ratio of the disk loadings. The predicted standard
deviation is increased by 20 % of the downwash. Gains and residual are not scaled: the scaled model has none.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from functools import partial

from q2q_model.commands.argument_types import output_file, positive_number
from q2q_model.commands.command_line import CommandLine, UsageError, Work, run_command
from q2q_model.model_files.model_names import check_model_name
from q2q_model.vehicle.constants import NEURAL_SWARM_MASS, ROTOR_RADIUS

EXAMPLE = """  ros2 run q2q_model scale_model --model model.q2q --mass 0.067 --rotor-radius 0.033 --out b.q2q
  ros2 run q2q_model scale_model --model model.q2q --mass 0.067 --rotor-radius 0.033 \\
      --below-mass 0.032 --below-rotor-radius 0.0225 --out over_small.q2q"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run `scale_model`; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    if (args.below_mass is None) != (args.below_rotor_radius is None):
        raise UsageError("give --below-mass and --below-rotor-radius together")
    check_model_name(args.model)
    from q2q_model.tools.scale_jet import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("scale_model", __doc__, EXAMPLE)
    made.add_argument(
        "--model", required=True, help="model to scale: a shipped name, or a .q2q file with a jet"
    )
    made.add_argument(
        "--out", type=output_file, required=True, metavar="FILE", help="model file to write (.q2q)"
    )
    size = partial(made.add_argument, type=positive_number)
    size("--mass", required=True, metavar="KG", help="take-off mass of the source")
    size("--rotor-radius", required=True, metavar="M", help="rotor radius of the source")
    size("--below-mass", metavar="KG", help="mass of the vehicle below (default: the source's)")
    size(
        "--below-rotor-radius", metavar="M", help="rotor radius of the vehicle below (default: the source's)"
    )
    size("--flown-mass", default=NEURAL_SWARM_MASS, metavar="KG", help="mass of the vehicles of --model")
    size(
        "--flown-rotor-radius",
        default=ROTOR_RADIUS,
        metavar="M",
        help="rotor radius of the vehicles of --model",
    )
    return made


if __name__ == "__main__":
    sys.exit(main())

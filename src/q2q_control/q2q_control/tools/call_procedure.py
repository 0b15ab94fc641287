"""One call of the flight procedure from the command line."""

import sys
from argparse import Namespace

from q2q_control.ros.procedure_call import ask


def run(args: Namespace) -> int:
    """Make the call; return the exit status."""
    service = f"{args.node}/{args.call}"
    reply = ask(service)
    print(f"{service}: {reply.reason}", file=sys.stdout if reply.granted else sys.stderr)
    return 0 if reply.granted else 1

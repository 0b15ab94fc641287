"""One call of the flight procedure from the command line."""

import sys
from argparse import Namespace

from q2q_control.ros.procedure_call import ask


def run(args: Namespace) -> int:
    """Make the call; return the exit status."""
    service = f"{args.node}/{args.call}"
    reply = ask(service, lambda: not args.on_enter or _entered(service))
    print(f"{service}: {reply.reason}", file=sys.stdout if reply.granted else sys.stderr)
    return 0 if reply.granted else 1


def _entered(service: str) -> bool:
    """Return whether Enter is pressed; False at the end of the input or Ctrl-C."""
    print(f"{service} is ready: press Enter to call it, Ctrl-C to leave", flush=True)
    try:
        return sys.stdin.readline() != ""
    except KeyboardInterrupt:
        return False

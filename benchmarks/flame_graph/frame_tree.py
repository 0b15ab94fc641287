"""Tree of the functions of sampled stacks, from the folded lines that py-spy writes.

    outer (package/file.py:12);inner (package/other.py:3) 17

is a stack that was sampled 17 times. Of each stack the part within the function `root` is kept, below the
node that runs it: the file of a node (`ros/pid_node.py`) among the functions around it.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

NODE = re.compile(r"\(.*?(\w+)_node\.py(:\d+)?\)$")
"""Frame in the file of a node."""


@dataclass(slots=True)
class Frame:
    """Function, in the calls that lead to it, with the functions that it calls."""

    name: str
    samples: int = 0
    """Samples in which it or a function that it calls was running."""
    calls: dict[str, "Frame"] = field(default_factory=dict)

    @property
    def own(self) -> int:
        """Return the samples in which it was running itself."""
        return self.samples - sum(one.samples for one in self.calls.values())

    def add(self, stack: Iterable[str], samples: int) -> None:
        """Count a stack below this frame."""
        self.samples += samples
        frame = self
        for name in stack:
            frame = frame.calls.setdefault(name, Frame(name))
            frame.samples += samples


def frame_tree(lines: Iterable[str], root: str) -> Frame:
    """Return the tree of the stacks of folded lines within the function `root`.

    Raises:
        ValueError: no stack is within `root`.
    """
    tree = Frame("all")
    for line in lines:
        folded, _, samples = line.rstrip().rpartition(" ")
        stack = folded.split(";")
        inside = [k for k, frame in enumerate(stack) if frame.startswith(f"{root} (")]
        if inside:
            tree.add([*_node_of(stack[: inside[0]]), *stack[inside[0] + 1 :]], int(samples))
    if not tree.samples:
        raise ValueError(f"no stack within {root}: sample a longer flight")
    return tree


def busiest(tree: Frame) -> list[tuple[str, float]]:
    """Return every function with its own share of all samples, without its calls, largest first."""
    shares: dict[str, float] = {}
    waiting = [tree]
    while waiting:
        frame = waiting.pop()
        shares[frame.name] = shares.get(frame.name, 0.0) + frame.own / tree.samples
        waiting += frame.calls.values()
    return sorted(shares.items(), key=lambda one: -one[1])


def _node_of(outer: Iterable[str]) -> list[str]:
    """Return the name of the node whose file is among frames, if there is one."""
    found = [match[1] for frame in outer if (match := NODE.search(frame))]
    return found[-1:]

"""The firmware app on an ARM Cortex-M4: it compiles, fits, and a step takes few enough instructions."""

import shutil
import subprocess
from pathlib import Path

import pytest
from native_apps import STACKED

from q2q_control.onboard.app_folder import CORE, write_app
from q2q_model.downwash.jet import MEASURED_LAW, MOVING_LAW, Jet
from q2q_model.model_files.model_file import ModelFile
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

GCC, QEMU = "arm-none-eabi-gcc", "qemu-system-arm"
HERE = Path(__file__).parent / "cortex_m4"
CORTEX_M4 = ("-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard")
ARM = ("-std=c99", "-O2", "-fno-math-errno", "-Wall", "-Wextra", "-Werror", "-Wdouble-promotion", *CORTEX_M4)
CLOCK_MHZ = 168.0
"""STM32F405 of a Crazyflie 2.x."""
CYCLES = 1.5
"""Assumed cycles per instruction: 1 for arithmetic, 2 for loads, 14 for divisions and roots, flash behind the
accelerator. The emulator counts instructions only."""
AIM_US = 50.0
"""Largest in a column of 0.2 m [us]."""
WORST_US = 70.0
"""In any column, 3.5 % of the 2 ms of a step; clang's code takes 54 us (docs/onboard.md)."""
needs_gcc = pytest.mark.skipif(shutil.which(GCC) is None, reason=f"no {GCC}: install gcc-arm-none-eabi")
needs_qemu = pytest.mark.skipif(shutil.which(QEMU) is None, reason=f"no {QEMU}: install qemu-system-arm")


def section_sizes(folder: Path) -> dict[str, int]:
    """Return the bytes of text, data and bss of the core's objects."""
    subprocess.run([GCC, *ARM, "-c", *CORE], cwd=folder, check=True)
    objects = [name[:-1] + "o" for name in CORE]
    lines = subprocess.run(
        ["arm-none-eabi-size", *objects], cwd=folder, check=True, capture_output=True, text=True
    ).stdout
    rows = [line.split()[:3] for line in lines.splitlines()[1:]]
    return {name: sum(int(row[k]) for row in rows) for k, name in enumerate(("text", "data", "bss"))}


def emulated(folder: Path) -> list[int]:
    """Return mean and largest instructions of a step: in all columns of five, alone, in one of 0.2 m."""
    script = f"-T{HERE / 'memory.ld'}"
    sources = [*CORE, str(HERE / "count.c")]
    build = [GCC, *ARM, "-nostartfiles", script, "-I.", *sources, "-lm", "-lc", "-lgcc", "-o", "count.elf"]
    subprocess.run(build, cwd=folder, check=True)
    machine = ["-M", "mps2-an386", "-icount", "shift=0", "-nographic"]
    lines = subprocess.run(
        [QEMU, *machine, "-semihosting-config", "enable=on,target=native", "-kernel", "count.elf"],
        cwd=folder, check=True, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    return [int(word) for word in (lines.stdout + lines.stderr).split()]


@needs_gcc
@pytest.mark.parametrize("jet", [MEASURED_LAW, MOVING_LAW, STACKED])
def test_the_core_takes_6_kilobytes_of_flash_and_no_memory_but_its_state(jet: Jet, tmp_path: Path) -> None:
    write_app(tmp_path, ModelFile(jet), CRAZYFLIE_2_0)
    sizes = section_sizes(tmp_path)
    assert sizes["text"] < 6000
    assert sizes["data"] == sizes["bss"] == 0


@needs_gcc
@needs_qemu
@pytest.mark.parametrize("jet", [MEASURED_LAW, MOVING_LAW, STACKED])
def test_a_step_with_five_neighbours_takes_less_than_50_microseconds(jet: Jet, tmp_path: Path) -> None:
    write_app(tmp_path, ModelFile(jet), CRAZYFLIE_2_0)
    mean, largest, idle, _, _, usual = emulated(tmp_path)
    assert idle < mean <= largest
    assert usual * CYCLES / CLOCK_MHZ < AIM_US
    assert largest * CYCLES / CLOCK_MHZ < WORST_US

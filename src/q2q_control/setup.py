"""ament_python build of q2q_control."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "q2q_control"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_data={PACKAGE: ["py.typed", "onboard/firmware_app/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="q2q developers",
    maintainer_email="maintainer@q2q.invalid",
    description="Interaction-aware PID and MPC, failsafe, interfaces to Crazyflies",
    license="MIT",
    entry_points={
        "console_scripts": [
            "pid = q2q_control.commands.control_nodes:pid",
            "mpc = q2q_control.commands.control_nodes:mpc",
            "own_controller = q2q_control.commands.control_nodes:own_controller",
            "crazyswarm = q2q_control.commands.control_nodes:crazyswarm",
            "radio = q2q_control.commands.control_nodes:radio",
            "call = q2q_control.commands.call:main",
            "export_app = q2q_control.commands.export_app:main",
        ],
    },
)
